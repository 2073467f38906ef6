//! Side-of-plane tests: the one place where geometric tolerances are defined.
