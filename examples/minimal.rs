//! The scene of `shatter` as an app: a model falls among boxes, breaks, and its pieces tell.
#[path = "support/mod.rs"]
mod support;
use bevy_app::{App, TaskPoolPlugin, Update};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};

fn main() -> Result<(), support::Error> {
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), TimePlugin));
    app.add_plugins(CleavePlugin::default());
    app.insert_resource(Time::<Fixed>::from_hz(60.0));
    app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.add_systems(Update, tell);
    for body in support::scene::shatter(support::DEFAULT_MODEL)? {
        app.world_mut().spawn_body(body);
    }
    (0..=420).for_each(|_| app.update());
    Ok(())
}

#[expect(clippy::print_stdout, reason = "an example prints what it shows")]
fn tell(mut fractures: MessageReader<Fractured>) {
    for Fractured { parent, pieces, .. } in fractures.read() {
        println!("{parent} broke into {pieces:?}");
    }
}
