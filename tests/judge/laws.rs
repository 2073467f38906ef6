//! The laws: each with its name in tables and files, and the bound beyond which it is broken.
//!
//! None needs a reference engine or a solution. Bounds are relative to what a scene's own sizes and speeds are; where a
//! bound is not rounding, it says what it allows for.

use super::scene::Scene;
use super::{alike, cause, same, watch};

/// What every scene has to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Law {
    /// Nothing panics, is left out or stops being a number.
    Finite,
    /// Energy never rises.
    Energy,
    /// Nor does it fall where nothing takes any.
    Elastic,
    /// Momentum stays where nothing acts from outside.
    Momentum,
    /// What is passive comes to rest.
    Rest,
    /// What rests sleeps.
    Sleep,
    /// No overlap stays, and none gets deep.
    Overlap,
    /// Nothing gets through a plate.
    Tunnel,
    /// What is in balance stays where it is.
    Stand,
    /// What touches nothing moves as if nothing were there.
    Cause,
    /// A floor in many pieces is a floor in one piece.
    Seam,
    /// A scene turned, moved, mirrored or with its bodies in another order does the same.
    Same,
    /// Finer steps get nearer to one answer.
    Finer,
}

impl Law {
    /// All of them, with their names.
    pub(crate) const ALL: [(Self, &str); 13] = [
        (Self::Finite, "finite"),
        (Self::Energy, "energy"),
        (Self::Elastic, "elastic"),
        (Self::Momentum, "momentum"),
        (Self::Rest, "rest"),
        (Self::Sleep, "sleep"),
        (Self::Overlap, "overlap"),
        (Self::Tunnel, "tunnel"),
        (Self::Stand, "stand"),
        (Self::Cause, "cause"),
        (Self::Seam, "seam"),
        (Self::Same, "same"),
        (Self::Finer, "finer"),
    ];

    pub(crate) fn name(self) -> &'static str {
        let (_, name) = Self::ALL
            .iter()
            .find(|(law, _)| *law == self)
            .expect("listed");
        name
    }
}

/// A law that a scene broke, and how.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Breach {
    pub(crate) law: Law,
    /// What was seen, as a multiple of the bound.
    pub(crate) excess: f64,
    /// What was seen, in words.
    pub(crate) what: String,
}

/// The laws that the scene breaks; each once.
pub(crate) fn judge(scene: &Scene) -> Vec<Breach> {
    let judged = std::panic::catch_unwind(|| {
        let mut breaches = watch::judge(scene);
        if scene.has(Law::Cause) {
            breaches.extend(cause::judge(scene));
        }
        if scene.has(Law::Seam) {
            breaches.extend(alike::judge_seam(scene));
        }
        if scene.has(Law::Same) {
            breaches.extend(same::judge_same(scene));
        }
        if scene.has(Law::Finer) {
            breaches.extend(same::judge_finer(scene));
        }
        breaches
    });
    judged.unwrap_or_else(|_| {
        vec![Breach {
            law: Law::Finite,
            excess: f64::INFINITY,
            what: "panicked".into(),
        }]
    })
}
