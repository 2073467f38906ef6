//! How much longer a step with fractures takes than those around it.

use crate::support::stats;

/// Steps to either side that are looked at.
const REACH: usize = 15;
/// Least number of steps without fracture that a median is taken of.
const LEAST: usize = 5;

/// What a step is to be, to be compared with those around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Pieces were made in it.
    Fracture,
    /// None were: how much steps differ anyway.
    Quiet,
}

/// The time of each step of a kind over the median of its neighbors; NaN for the others.
///
/// Neighbors are the steps without fracture that are at most 15 steps away. Where there are fewer than five of these,
/// because something breaks all the time, they are all steps that are at most 15 steps away.
pub(crate) fn ratios(times: &[f64], made: &[usize], kind: Kind) -> Vec<f64> {
    let ratio = |step: usize| {
        if (made[step] > 0) != (kind == Kind::Fracture) {
            return f64::NAN;
        }
        let from = step.saturating_sub(REACH);
        let to = (step + REACH + 1).min(times.len());
        let around = || (from..to).filter(|&other| other != step);
        let quiet: Vec<f64> = around()
            .filter(|&i| made[i] == 0)
            .map(|i| times[i])
            .collect();
        let all: Vec<f64> = around().map(|i| times[i]).collect();
        let neighbors = if quiet.len() < LEAST { all } else { quiet };
        times[step] / stats::median(&neighbors)
    };
    (0..times.len()).map(ratio).collect()
}

/// The numbers among `values`.
pub(crate) fn finite(values: &[f64]) -> Vec<f64> {
    values.iter().copied().filter(|v| v.is_finite()).collect()
}

/// The largest number among `ratios` and its step, counted from 1.
pub(crate) fn worst(ratios: &[f64]) -> (f64, usize) {
    let numbered = (1..).zip(ratios.iter().copied()).map(|(i, r)| (r, i));
    numbered
        .filter(|(ratio, _)| ratio.is_finite())
        .fold(
            (f64::NAN, 0),
            |worst, next| {
                if worst.0 >= next.0 { worst } else { next }
            },
        )
}
