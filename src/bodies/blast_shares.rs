//! How those that a blast reaches share its impulse.

/// How many times as fast a blast makes a piece, at most, as all that it reaches together. By area alone splinters get as fast as they are thin,
/// some kilometers in a second; the gas that drives them is not faster than what else it drives by much, and flows around what is small.
const FASTEST: f64 = 4.0;

/// A piece or a part in a blast.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reached {
    /// The area that it turns to the blast, less with the distance, m2; none if the blast does not reach it.
    pub(crate) weight: f64,
    /// kg.
    pub(crate) mass: f64,
}

/// Shares of an impulse by weight, but to none more than makes it [`FASTEST`] times as fast as all that are reached would be together: what is
/// spared a splinter goes to the others. They sum to one if any is reached.
pub(crate) fn shares(pieces: &[Reached]) -> Vec<f64> {
    let mut given = vec![0.0; pieces.len()];
    let mut reached: Vec<usize> = (0..pieces.len())
        .filter(|&it| pieces[it].weight > 0.0 && pieces[it].mass > 0.0)
        .collect();
    let mass: f64 = reached.iter().map(|&it| pieces[it].mass).sum();
    // Those that get fastest come last, and are taken from the end: each leaves more for all before it.
    reached.sort_by(|&a, &b| {
        let speed = |it: usize| pieces[it].weight / pieces[it].mass;
        speed(a).total_cmp(&speed(b)).then(a.cmp(&b))
    });
    let mut weights: Vec<f64> = vec![0.0];
    for &it in &reached {
        weights.push(weights[weights.len() - 1] + pieces[it].weight);
    }
    let mut left = 1.0;
    for (at, &it) in reached.iter().enumerate().rev() {
        let most = FASTEST * pieces[it].mass / mass;
        given[it] = (left * pieces[it].weight / weights[at + 1]).min(most);
        left -= given[it];
    }
    given
}

#[cfg(test)]
mod tests {
    use super::{FASTEST, Reached, shares};
    use rand_core::{Rng, SeedableRng};

    #[test]
    fn a_blast_is_shared_by_area_and_makes_no_splinter_faster_than_the_rest_by_much() {
        let mut random = rand_pcg::Pcg64::seed_from_u64(1);
        let mut unit = || f64::from(random.next_u32()) / f64::from(u32::MAX);
        for count in 1..200 {
            let pieces: Vec<Reached> = (0..count)
                .map(|_| {
                    let size = unit();
                    Reached {
                        weight: if unit() < 0.2 { 0.0 } else { unit() },
                        mass: size * size * size * size * size * size,
                    }
                })
                .collect();
            let given = shares(&pieces);
            let reached = || pieces.iter().zip(&given).filter(|(it, _)| it.weight > 0.0);
            let together = reached().map(|(it, _)| it.mass).sum::<f64>();
            let sum = given.iter().sum::<f64>();
            assert!(together == 0.0 || (sum - 1.0).abs() < 1e-12, "{sum}");
            for (it, share) in pieces.iter().zip(&given) {
                assert!(*share <= FASTEST * it.mass / together * (1.0 + 1e-12));
                assert!(it.weight > 0.0 || *share == 0.0);
            }
            // Those below the limit have the same pressure.
            let is_below = |it: &&(&Reached, &f64)| *it.1 < 0.999 * FASTEST * it.0.mass / together;
            let pressures: Vec<f64> = (reached().filter(|it| is_below(&it)))
                .map(|(it, share)| share / it.weight)
                .collect();
            for pressure in &pressures {
                assert!((pressure / pressures[0] - 1.0).abs() < 1e-9);
            }
        }
    }
}
