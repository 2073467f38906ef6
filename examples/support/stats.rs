//! Order statistics of measured samples.

/// The value below which `fraction` (0 to 1) of the samples lie, linearly interpolated between neighbors.
///
/// NaN if there is no sample; NaN samples sort last.
pub fn percentile(samples: &[f64], fraction: f64) -> f64 {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else {
        return f64::NAN;
    };
    let rank = fraction.clamp(0.0, 1.0) * last as f64;
    let below = rank.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (rank - below as f64) * (sorted[above] - sorted[below])
}

/// The middle sample, or the mean of the two middle ones.
pub fn median(samples: &[f64]) -> f64 {
    percentile(samples, 0.5)
}

/// The largest sample, negative infinity if there is none.
pub fn max(samples: &[f64]) -> f64 {
    samples.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}
