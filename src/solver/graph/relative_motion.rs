//! How far the bodies of a pair move against each other within a step.

use crate::bodies::store::Bodies;

/// Turn within a step (rad) from which the rows of a body's contacts follow it.
const TURN: f32 = 0.01;

/// Motion of two bodies against each other within a step, as a share of the smaller one's least extent, from which the
/// rows of their contact follow it.
const TRAVEL: f32 = 0.02;

/// How two bodies move against each other in a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct RelativeMotion {
    /// So far that the rows between them must follow.
    pub is_noticeable: bool,
    /// Farther than both are thick: they may pass through each other.
    pub is_fast: bool,
}

impl RelativeMotion {
    /// Of the bodies in two slots; `step`, s.
    pub fn of(bodies: &Bodies, slots: [usize; 2], step: f32) -> Self {
        let [a, b] = slots.map(|i| &bodies.velocity[i]);
        let extents = slots.map(|i| bodies.min_extent[i]);
        // Squares, so that no root has to be taken for each manifold of the scene.
        let square = |x: f32| x * x;
        let spin = a.angular.length_squared().max(b.angular.length_squared());
        let turn = square(step) * spin;
        let way = square(step) * (b.linear - a.linear).length_squared();
        Self {
            is_noticeable: turn > square(TURN) || way > square(TRAVEL * extents[0].min(extents[1])),
            is_fast: way > square(extents[0] + extents[1]),
        }
    }
}
