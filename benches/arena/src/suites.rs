//! Lists of scenes to run together.

/// A minute or two with the default settings.
pub(crate) const QUICK: &[&str] = &["stick", "tower:10", "pyramid:30", "pile:500"];

/// All that the report is made of.
pub(crate) const FULL: &[&str] = &[
    "pyramid:30",
    "pyramid:50",
    "pyramids:10",
    "pile:500",
    "pile:2000",
    "tower:10",
    "tower:20",
    "tower:40",
    "massratio:10",
    "massratio:100",
    "massratio:1000",
    "arch",
    "cards",
    "dominoes",
    "stick",
    "slide",
    "spin",
    "collide",
    "bounce",
    "fall",
    "bullet",
    "bullet_ccd",
];

/// What the report of joints is made of.
pub(crate) const JOINTS: &[&str] = &[
    "chain10:1",
    "chain10:100",
    "chain10:1000",
    "chain30:1",
    "chain30:100",
    "chain30:1000",
    "chain100:1",
    "chain100:100",
    "chain100:1000",
    "pendulum",
    "pendulum_energy",
    "double_pendulum:30",
    "double_pendulum:90",
    "door:100",
    "bridge:1500",
    "bridge:0",
    "motor",
    "spring",
    "gyroscope",
    "stairs:10",
    "ragdolls:100",
];

/// The suite with that name.
pub(crate) fn named(name: &str) -> Option<&'static [&'static str]> {
    match name {
        "quick" => Some(QUICK),
        "full" => Some(FULL),
        "joints" => Some(JOINTS),
        _ => None,
    }
}
