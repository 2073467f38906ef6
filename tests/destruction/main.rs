//! Laws of what breaks, over random members: what stands, clusters, cuts, what waits, debris, and what holds bodies together. None needs a
//! reference. A program of its own, because it runs hundreds of scenes.

#![expect(
    clippy::disallowed_methods,
    reason = "sizes and strengths of scenes may differ between platforms"
)]

#[path = "../common/mod.rs"]
mod common;

mod blasts;
mod clusters;
mod cuts;
mod edges;
mod heirs;
mod kit;
mod looks;
mod standing;
mod waiting;

use kit::Verdict;

/// Judges scenes 0 to `scenes` by a law: at most `failing` break it, and together they show at least `shown` of what it is about.
fn check(law: fn(u64) -> Verdict, scenes: u64, (failing, shown): (usize, usize)) {
    let (mut broken, mut sum) = (Vec::new(), 0);
    for seed in 0..scenes {
        match law(seed) {
            Ok(count) => sum += count,
            Err(why) => broken.push(format!("scene {seed}: {why}")),
        }
    }
    assert!(broken.len() <= failing, "{}", broken.join("\n"));
    assert!(sum >= shown, "{sum}");
}

#[test]
fn pieces_of_a_cut_are_apart_on_their_sides_and_move_as_the_body_did() {
    check(cuts::judge, 300, (0, 1000));
}

// Of plain hulls they had no slot, and of pieces that break no more that of the outside.
#[test]
fn faces_of_cuts_and_nothing_else_have_their_slot() {
    check(looks::judge, 300, (0, 2000));
    check(looks::judge_after_a_blow, 150, (0, 500));
}

#[test]
fn what_rests_on_a_body_that_is_cut_goes_on_resting() {
    check(cuts::judge_stack, 100, (0, 250));
}

#[test]
fn nothing_stays_that_hangs_on_nothing_and_nothing_falls_that_is_held() {
    check(standing::judge, 50, (0, 500));
}

#[test]
fn nothing_is_lost_of_what_breaks_while_it_is_let_fall() {
    check(standing::judge_felled, 60, (0, 120));
}

#[test]
fn nothing_stays_of_what_breaks_after_its_hold_was_taken_away() {
    check(standing::judge_removed, 200, (0, 200));
}

#[test]
fn clusters_are_the_groups_that_bonds_hold_together_and_weigh_what_their_parts_do() {
    check(clusters::judge, 50, (0, 150));
}

/// What comes off hits its neighbors in the same step, with energies that differ with the order; and a bond that bears all it can, but for rounding, breaks
/// in one of them and not in the other: six in a hundred.
#[test]
fn clusters_break_alike_with_parts_in_another_order_moved_and_turned() {
    check(clusters::judge_same, 150, (9, 70));
}

#[test]
fn what_breaks_by_a_blow_breaks_by_a_harder_one() {
    check(clusters::judge_harder, 150, (1, 40));
}

#[test]
fn clusters_gain_no_energy_by_breaking() {
    check(clusters::judge_energy, 150, (0, 100));
}

#[test]
fn what_waits_comes_to_its_turn_or_is_gone() {
    check(waiting::judge, 100, (0, 600));
}

#[test]
fn blasts_break_what_waits_too() {
    check(waiting::judge_in_the_end, 150, (0, 100));
}

#[test]
fn a_blast_drives_all_pieces_away_or_in_and_none_as_a_bullet() {
    check(blasts::judge, 200, (0, 700));
}

/// Splinters got 1e5 to 1e9 m/s in 94 heaps of 100; in some all that they touched overflowed with them and stopped.
#[test]
fn a_blast_makes_no_splinter_so_fast_that_a_heap_overflows() {
    check(blasts::judge_dust, 100, (0, 1000));
}

#[test]
fn debris_goes_by_its_rules_and_its_mass_is_told() {
    check(waiting::judge_debris, 12, (0, 600));
}

#[test]
fn pieces_share_the_bonds_of_a_body_by_area() {
    check(heirs::judge_bonds, 150, (0, 400));
}

/// Was held at the edge in the air, step by step, while gravity made it faster: seven in 1500.
#[test]
fn what_strikes_an_edge_of_what_hangs_flies_on() {
    check(edges::judge, 1500, (0, 2000));
}

#[test]
fn joints_stay_where_they_are_however_often_a_body_breaks_in_a_step() {
    check(heirs::judge_joints, 150, (0, 1500));
}
