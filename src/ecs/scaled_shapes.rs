//! Shapes of entities that are scaled. They are kept: whoever looks at an entity of which something else has changed is to find the very
//! shape that its body has, or the body would wake and lose its contacts.

use crate::bodies::body::Shape;
use crate::contact::body_id::BodyId;
use bevy_math::Vec3;

/// By slot, as far as any is scaled.
#[derive(Clone, Debug, Default)]
pub(crate) struct ScaledShapes(Vec<Option<Box<ScaledShape>>>);

/// A shape that was scaled.
#[derive(Clone, Debug)]
struct ScaledShape {
    id: BodyId,
    /// What it was before.
    of: Shape,
    scale: Vec3,
    shape: Shape,
}

impl ScaledShapes {
    /// The shape that `of` became for this body, if it is the last one, at a scale that is still the same.
    pub(crate) fn get(
        &self,
        (slot, id): (u32, BodyId),
        of: &Shape,
        is_scale: impl Fn(Vec3) -> bool,
    ) -> Option<Shape> {
        let known = self.0.get(slot as usize)?.as_ref()?;
        let is_same = known.id == id && known.of.is_same(of) && is_scale(known.scale);
        is_same.then(|| known.shape.clone())
    }

    /// Keeps what `of` became for this body.
    pub(crate) fn keep(&mut self, (slot, id): (u32, BodyId), of: Shape, scale: Vec3, shape: Shape) {
        let needed = self.0.len().max(slot as usize + 1);
        self.0.resize_with(needed, || None);
        self.0[slot as usize] = Some(Box::new(ScaledShape {
            id,
            of,
            scale,
            shape,
        }));
    }

    /// Forgets what is known of the body in a slot.
    pub(crate) fn forget(&mut self, slot: u32) {
        if let Some(known) = self.0.get_mut(slot as usize) {
            *known = None;
        }
    }
}
