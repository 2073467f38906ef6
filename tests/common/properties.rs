//! How many random inputs a property test tries, and which.

use proptest::test_runner::{Config, RngSeed};

/// The same `cases` inputs in every run, so that a failure means a change of the code.
///
/// `PROPTEST_RNG_SEED` and `PROPTEST_CASES` choose others: that is how to look for new failures.
pub(crate) fn cases(cases: u32) -> Config {
    let chosen = Config::default();
    let is_counted = std::env::var_os("PROPTEST_CASES").is_some();
    Config {
        cases: if is_counted { chosen.cases } else { cases },
        rng_seed: match chosen.rng_seed {
            RngSeed::Random => RngSeed::Fixed(1),
            fixed @ RngSeed::Fixed(_) => fixed,
        },
        failure_persistence: None,
        ..chosen
    }
}
