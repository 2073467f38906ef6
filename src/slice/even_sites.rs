//! Sites of Voronoi cells that are about equally large.
//!
//! Random sites make cells of which the largest has some thirty times the volume of the smallest. Here each site is the candidate
//! that lies farthest from all before it (Mitchell), and then moves to the centroid of its cell a few times (Lloyd), which is that
//! of the samples that are nearer to it than to any other site.
//!
//! # References
//! - D. P. Mitchell, "Spectrally Optimal Sampling for Distribution Ray Tracing", SIGGRAPH 1991: best candidates.
//! - S. P. Lloyd, "Least Squares Quantization in PCM", IEEE Transactions on Information Theory 28(2), 1982.

use crate::slice::random::PointsInHull;
use glam::{DVec3, Vec3};
use rand_pcg::Pcg32;

/// Candidates for each site.
const CANDIDATES: usize = 8;

/// Samples for each cell: the centroid of so many is off by a tenth of the cell's size.
const SAMPLES: usize = 32;

/// How often sites move to the centroids of their cells.
const ROUNDS: usize = 6;

/// Up to `count` sites in the hull, none of which coincide.
pub(super) fn even_sites(points: &PointsInHull, count: usize, random: &mut Pcg32) -> Vec<Vec3> {
    let mut sites: Vec<Vec3> = Vec::with_capacity(count);
    for _ in 0..count {
        let mut best = (0.0, None);
        for _ in 0..CANDIDATES {
            let candidate = points.next(random);
            let distances = sites.iter().map(|site| site.distance_squared(candidate));
            let nearest = distances.fold(f32::INFINITY, f32::min);
            if nearest > best.0 {
                best = (nearest, Some(candidate));
            }
        }
        sites.extend(best.1);
    }
    let samples: Vec<Vec3> = (0..SAMPLES * sites.len())
        .map(|_| points.next(random))
        .collect();
    for _ in 0..ROUNDS {
        relax(&mut sites, &samples);
    }
    sites
}

/// Moves each site to the mean of the samples that are nearest to it.
fn relax(sites: &mut [Vec3], samples: &[Vec3]) {
    let mut sums = vec![(DVec3::ZERO, 0.0); sites.len()];
    for &sample in samples {
        let distances = sites.iter().map(|site| site.distance_squared(sample));
        let nearest = distances
            .enumerate()
            .min_by(|(_, a), (_, b)| a.total_cmp(b));
        if let Some((nearest, _)) = nearest {
            sums[nearest].0 += sample.as_dvec3();
            sums[nearest].1 += 1.0;
        }
    }
    for (site, (sum, count)) in sites.iter_mut().zip(sums) {
        if count > 0.0 {
            *site = (sum / count).as_vec3();
        }
    }
}
