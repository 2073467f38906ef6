//! What is found.

use crate::contact::body_id::BodyId;
use glam::Vec3;

/// A place on a body that a ray or a shape meets, or that is near.
///
/// `Body` is what bodies are called: a slot (`u32`), or in an app an entity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QueryHit<Body = u32> {
    /// The body.
    pub body: Body,
    /// Its id: of what is equally far, the body with the smaller one comes first.
    pub id: BodyId,
    /// The place on its surface, world frame, m; where a ray begins inside the body, that origin.
    pub point: Vec3,
    /// Unit normal there, out of the body, world axes. Where a ray or cast begins inside the body, against its direction.
    pub normal: Vec3,
    /// How far away, m: along the ray, along the cast, or from the point asked about; negative for a point inside the body.
    pub distance: f32,
    /// Which convex part of the body it is; 0 for a body of one part.
    pub part: u32,
    /// Which triangle of a mesh it is.
    pub triangle: Option<u32>,
    /// Which face of a hull it is; none where a ray or cast begins inside.
    pub face: Option<u32>,
}

impl<Body> QueryHit<Body> {
    /// The same place on a body that is called otherwise.
    pub(crate) fn of<Other>(self, body: Other) -> QueryHit<Other> {
        QueryHit {
            body,
            id: self.id,
            point: self.point,
            normal: self.normal,
            distance: self.distance,
            part: self.part,
            triangle: self.triangle,
            face: self.face,
        }
    }

    /// What hits are sorted by.
    pub(crate) fn order(&self, other: &Self) -> std::cmp::Ordering {
        let by_distance = self.distance.total_cmp(&other.distance);
        by_distance.then(self.id.cmp(&other.id))
    }

    /// Whether it comes before what is known, if anything is.
    pub(crate) fn comes_before(&self, known: Option<&Self>) -> bool {
        known.is_none_or(|known| self.order(known).is_lt())
    }
}
