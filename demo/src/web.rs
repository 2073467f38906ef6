//! What a web page can ask the playground: its state, for tests and for who is curious.

use crate::exhibits::Shown;
use crate::measures::Measures;
use bevy::prelude::*;
use bevy_cleave::prelude::*;
use std::cell::RefCell;
use wasm_bindgen::prelude::*;

thread_local! {
    /// The state of the last frame. The page and the app share a thread.
    static STATE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// The state of the last frame as JSON; empty before the first one.
#[wasm_bindgen]
pub fn state() -> String {
    STATE.with_borrow(String::clone)
}

pub(crate) fn plugin(app: &mut App) {
    app.add_systems(Last, publish);
}

fn publish(
    measures: Res<Measures>,
    shown: Res<Shown>,
    mut fractures: MessageReader<Fractured>,
    mut counts: Local<[u64; 2]>,
) {
    let [frames, cuts] = &mut *counts;
    *frames += 1;
    *cuts += fractures.read().count() as u64;
    let Measures {
        pieces,
        step_time,
        frame_time,
        ..
    } = *measures;
    let exhibit = shown.0.name();
    STATE.set(format!(
        r#"{{"exhibit":"{exhibit}","frames":{frames},"cuts":{cuts},"pieces":{pieces},"step_ms":{step_time:.3},"frame_ms":{frame_time:.2}}}"#
    ));
}
