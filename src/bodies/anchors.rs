//! Where bodies that stand hold on to the world: what of them stays when they break.
//!
//! Few bodies have any, so they are a list by slot that grows with the last of those.

use crate::bodies::body::BodyError;
use crate::contact::body_id::BodyId;
use bevy_ecs::component::Component;
use glam::Vec3;

/// Where a static or kinematic body holds on to the world.
///
/// When it breaks or is cut, the pieces that reach there stay as it was, static or kinematic; all others become dynamic and fall. A
/// static body without this component holds on wherever it touches other static bodies face to face or reaches into them, as
/// [`Anchors::touching`] says; one that touches none holds on to nothing. A kinematic one without it holds on to nothing.
///
/// ```
/// # use bevy_cleave::prelude::*;
/// # use glam::Vec3;
/// // A post that is set into the ground, and a bridge of 8 m that lies on both banks.
/// let post = Anchors::none().and_behind(Vec3::Y, -1.0);
/// let bridge = Anchors::none()
///     .and_within(Vec3::new(-4.0, -1.0, -2.0), Vec3::new(-3.5, 1.0, 2.0))
///     .and_within(Vec3::new(3.5, -1.0, -2.0), Vec3::new(4.0, 1.0, 2.0));
/// # assert_eq!((post.regions.len(), bridge.regions.len()), (1, 2));
/// ```
#[derive(Clone, Debug, PartialEq, Component)]
#[component(summary_tick)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct Anchors {
    /// Whether it holds on to static bodies that it touches. Pieces of what it was a piece of are none: there is a crack between
    /// them.
    pub is_touching: bool,
    /// Where else it holds on.
    pub regions: Vec<AnchorRegion>,
    /// Gap to what it holds on to, m; `None` for a hundredth of the geometric mean of the body's least and largest extents. Its
    /// pieces keep it.
    pub reach: Option<f32>,
}

/// A part of the body's frame, in which it holds on to the world. It is scaled with the entity's `Transform`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum AnchorRegion {
    /// Everything behind the plane of points `p` with `normal . p = offset`.
    Behind {
        /// Points away from the region; need not be of unit length.
        normal: Vec3,
        /// m, for a normal of unit length.
        offset: f32,
    },
    /// A box along the body's axes.
    Within {
        /// Its lower corner, m.
        min: Vec3,
        /// Its upper corner, m.
        max: Vec3,
    },
}

impl Default for Anchors {
    fn default() -> Self {
        Self::touching()
    }
}

impl Anchors {
    /// Where it touches other static bodies: half-spaces, levels, walls.
    pub const fn touching() -> Self {
        Self {
            is_touching: true,
            regions: Vec::new(),
            reach: None,
        }
    }

    /// Nowhere: all of its pieces fall.
    pub const fn none() -> Self {
        Self {
            is_touching: false,
            regions: Vec::new(),
            reach: None,
        }
    }

    /// There too: everything behind the plane `normal . p = offset` of the body's frame.
    pub fn and_behind(mut self, normal: Vec3, offset: f32) -> Self {
        self.regions.push(AnchorRegion::Behind { normal, offset });
        self
    }

    /// There too: a box along the axes of the body's frame, from its lower to its upper corner.
    pub fn and_within(mut self, min: Vec3, max: Vec3) -> Self {
        self.regions.push(AnchorRegion::Within { min, max });
        self
    }

    /// The same over gaps of up to `reach`, m.
    pub fn with_reach(mut self, reach: f32) -> Self {
        self.reach = Some(reach);
        self
    }

    /// Whether its numbers mean something.
    ///
    /// # Errors
    /// [`BodyError::Anchors`] says what does not.
    pub fn validate(&self) -> Result<(), BodyError> {
        if self
            .reach
            .is_some_and(|reach| !(reach.is_finite() && reach >= 0.0))
        {
            return Err(BodyError::Anchors("the reach is negative or not finite"));
        }
        let is_usable = |region: &AnchorRegion| match *region {
            AnchorRegion::Behind { normal, offset } => {
                normal.try_normalize().is_some() && offset.is_finite()
            }
            AnchorRegion::Within { min, max } => {
                min.is_finite() && max.is_finite() && (max - min).min_element() > 0.0
            }
        };
        if !self.regions.iter().all(is_usable) {
            return Err(BodyError::Anchors(
                "a region is empty or has a number that is not finite",
            ));
        }
        Ok(())
    }

    /// The same of an entity that is scaled.
    pub(crate) fn scaled(&self, scale: Vec3) -> Self {
        let mut scaled = self.clone();
        for region in &mut scaled.regions {
            *region = match *region {
                AnchorRegion::Behind { normal, offset } => {
                    let length = (normal / scale).length() / normal.length();
                    AnchorRegion::Behind {
                        normal: (normal / scale).normalize_or_zero(),
                        offset: offset / length,
                    }
                }
                AnchorRegion::Within { min, max } => AnchorRegion::Within {
                    min: min * scale,
                    max: max * scale,
                },
            };
        }
        scaled
    }

    /// The same seen from the frame of a piece, along whose axes it lies and whose origin is at `origin`, m.
    pub(crate) fn seen_from(&self, origin: Vec3) -> Self {
        let mut seen = self.clone();
        for region in &mut seen.regions {
            match region {
                AnchorRegion::Behind { normal, offset } => {
                    *offset -= normal.normalize_or_zero().dot(origin);
                }
                AnchorRegion::Within { min, max } => {
                    *min -= origin;
                    *max -= origin;
                }
            }
        }
        seen
    }
}

/// What is known of how a body holds on to the world.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hold {
    /// Where it was said to.
    pub(crate) anchors: Option<Anchors>,
    /// What it once was a piece of: the first body that broke.
    pub(crate) origin: Option<BodyId>,
}
