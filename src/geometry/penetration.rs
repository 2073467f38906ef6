//! How deep a core is in another one: the least way that leads out.
//!
//! # References
//! G. van den Bergen, "Proximity Queries and Penetration Depth Computation on 3D Game Objects", GDC 2001: the depth is the least reach of
//! the difference of both along any axis.

use crate::geometry::distance::{Nearest, Separation, distance_from};
use crate::geometry::support::{Core, PlacedCore};
use glam::DVec3;
use std::cmp::Ordering;

/// How often a way out is made shorter at most.
const MAX_TURNS: usize = 16;

/// Share by which a way must be shorter than another one to be taken instead.
const GAIN: f64 = 1e-4;

/// A way by which a core B gets out of a core A.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WayOut {
    /// Unit vector.
    pub(crate) normal: DVec3,
    /// m.
    pub(crate) length: f64,
    /// Where A is left, if that is known.
    pub(crate) on_a: Option<DVec3>,
}

impl WayOut {
    /// The one along an axis.
    pub(crate) fn along(a: &Core, b: &PlacedCore, normal: DVec3) -> Self {
        Self {
            normal,
            length: normal.dot(a.exact_support(normal) - b.support(-normal)),
            on_a: None,
        }
    }

    /// The least one along some axes.
    pub(crate) fn least(
        a: &Core,
        b: &PlacedCore,
        axes: impl IntoIterator<Item = DVec3>,
    ) -> Option<Self> {
        let ways = axes.into_iter().map(|axis| Self::along(a, b, axis));
        ways.min_by(Self::order)
    }

    /// From short to long.
    pub(crate) fn order(&self, other: &Self) -> Ordering {
        self.length.total_cmp(&other.length)
    }

    /// Turned as long as that makes it shorter.
    pub(crate) fn turned(self, a: &Core, b: &PlacedCore) -> Self {
        let mut best = self;
        for _ in 0..MAX_TURNS {
            let Some(beyond) = best.beyond(a, b) else {
                break;
            };
            best.on_a = Some(beyond.on_a);
            let turned = Self::along(a, b, beyond.normal);
            if turned.length > (1.0 - GAIN) * best.length {
                break;
            }
            best = Self {
                on_a: best.on_a,
                ..turned
            };
        }
        best
    }

    /// Where both are nearest when B has gone twice as far: the way along that normal is no longer, for the gap there is no less.
    fn beyond(&self, a: &Core, b: &PlacedCore) -> Option<Nearest> {
        let there = b.moved(2.0 * self.length * self.normal);
        match distance_from(a, &there, self.normal, f64::INFINITY) {
            Separation::Near(nearest) if self.length > 0.0 => Some(nearest),
            _ => None,
        }
    }
}
