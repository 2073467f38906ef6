//! `CompoundPart`: a convex shape with a pose.

use crate::geometry::{ConvexHull, ConvexMesh, HullError};
use crate::math::{Aabb, Pose};
use glam::{Mat3, Vec3};

/// A convex part of a [`Compound`](crate::geometry::Compound).
#[derive(Clone, Debug)]
pub struct CompoundPart {
    /// Where the frame of its shape is in that of the compound.
    pub pose: Pose,
    /// Its shape.
    pub shape: ConvexMesh,
}

impl CompoundPart {
    /// The part, in the frame in which `pose` is given.
    pub fn new(pose: Pose, shape: ConvexMesh) -> Self {
        Self { pose, shape }
    }

    /// The box around it in another frame: that in which the compound's frame is turned and shifted so.
    pub(crate) fn bounds(&self, turn: &Mat3, shift: Vec3) -> Aabb {
        let own = *turn * Mat3::from_quat(self.pose.rotation);
        self.shape.bounds(&own, *turn * self.pose.position + shift)
    }

    /// How far a point of the compound's frame is above the face that it is highest above, m; negative inside.
    pub(crate) fn height_of(&self, point: Vec3) -> f32 {
        let own = self.pose.inverse_transform_point(point);
        let faces = self.shape.hull().faces().iter();
        let heights = faces.map(|face| face.plane.distance(own));
        heights.fold(f32::NEG_INFINITY, f32::max)
    }

    /// The part as a shape in the compound's frame, as a hull if it is turned or round.
    pub(crate) fn in_place(&self) -> Result<ConvexMesh, HullError> {
        if self.pose == Pose::IDENTITY {
            return Ok(self.shape.clone());
        }
        let corners = self.shape.hull().vertices().iter();
        let corners: Vec<Vec3> = corners.map(|v| self.pose.transform_point(*v)).collect();
        let visual = self.shape.visual().cloned();
        let visual = visual.map(|mesh| mesh.transformed(&self.pose));
        let hull = ConvexHull::from_points(&corners)?;
        Ok(ConvexMesh::from_parts(hull, visual))
    }
}

impl From<(Pose, ConvexMesh)> for CompoundPart {
    fn from((pose, shape): (Pose, ConvexMesh)) -> Self {
        Self::new(pose, shape)
    }
}

impl From<ConvexMesh> for CompoundPart {
    /// A part whose frame is that of the compound.
    fn from(shape: ConvexMesh) -> Self {
        Self::new(Pose::IDENTITY, shape)
    }
}
