//! A house of cards (case 9).

use super::support::{displacement, frames, run, simulation, threshold};
use crate::common::structures::{card_house, card_house_friction, plain_card_house};
use bevy_cleave::prelude::*;

/// How far a house of cards has moved after 10 s, m.
fn moved(house: Vec<BodyDesc>) -> f32 {
    let mut simulation = simulation(house);
    let start = frames(&simulation);
    run(&mut simulation, 10.0);
    displacement(&simulation, &start)
}

/// Hard because thin cards on their edges hold each other by friction alone; they need `tan(20) / 2 = 0.182` if bare and
/// `3 tan(20) / 4 = 0.273` under a plate of their weight, less what the width of the strips they touch on gives.
#[test]
fn card_house_stands_above_the_least_friction_and_slides_out_below_it() {
    for loaded in [false, true] {
        let least = card_house_friction(loaded);
        let stands = |share: f64| {
            let moved = moved(card_house((share * least) as f32, loaded));
            println!(
                "case 9: loaded {loaded}: at {share:.4} of the friction {least:.5} moved {:.3} mm",
                1e3 * moved
            );
            moved < 0.01
        };
        let found = threshold(0.95, 1.05, stands);
        println!(
            "case 9: loaded {loaded}: threshold {:+.1} % off",
            100.0 * (found - 1.0)
        );
    }
}

/// Hard because plain cards meet edge to edge, where the contact normal is anything between the normals of their faces;
/// engines whose cards slide at 0.5 are what the case was made for.
#[test]
fn plain_cards_stand_with_friction_of_a_half() {
    let moved = moved(plain_card_house(0.5));
    println!("case 9: plain cards at 0.5 moved {:.3} mm", 1e3 * moved);
    assert!(moved < 0.01, "moved {moved} m");
}
