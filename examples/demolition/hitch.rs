//! How much longer a step with fractures takes than those around it.

use crate::support::stats;

/// Steps to either side that are looked at.
const REACH: usize = 15;
/// Least number of neighbours that a median is taken of.
const LEAST: usize = 5;

/// What a step with fractures is compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Neighbours {
    /// The steps without a fracture that are at most 15 steps away; if there are fewer than five of these, the five nearest.
    ///
    /// Asks for the most: a step in which pieces are made is compared with those in which none are, however far away,
    /// and a wall at rest before the first blow counts as much as the rubble after it.
    Quiet,
    /// All steps that are at most 15 steps away: what somebody sees who looks at the clock alone.
    All,
}

/// The time of each step in which pieces were made, over the median of its neighbours; NaN for the others.
pub(crate) fn ratios(times: &[f64], made: &[usize], neighbours: Neighbours) -> Vec<f64> {
    let ratio = |step: usize| {
        if made[step] == 0 {
            return f64::NAN;
        }
        let mut around: Vec<usize> = (0..times.len())
            .filter(|&other| other != step && (neighbours == Neighbours::All || made[other] == 0))
            .collect();
        around.sort_by_key(|other| other.abs_diff(step));
        let near = around.iter().filter(|other| other.abs_diff(step) <= REACH);
        let count = near.count().max(LEAST).min(around.len());
        let times_around: Vec<f64> = around[..count].iter().map(|&other| times[other]).collect();
        times[step] / stats::median(&times_around)
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
        .fold((f64::NAN, 0), |worst, next| {
            if worst.0 >= next.0 { worst } else { next }
        })
}
