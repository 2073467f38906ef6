//! A point of a lane as the rows of its problem, for the exact method and for residuals.

use crate::solver::rows::contact_rows::PointRows;
use crate::solver::wide::block::{Block, Point, vector};
use crate::solver::wide::bond::BondConstraint;

impl Point {
    /// The point of a lane as rows.
    pub fn rows(
        &self,
        lane: usize,
        block: &Block,
        constraint: Option<&BondConstraint>,
        rebound: f32,
    ) -> PointRows {
        let anchors = [0, 1].map(|k| vector(&self.anchors[k], lane));
        let mut rows = PointRows {
            bodies: block.pair(lane),
            friction: block.friction.0[lane],
            restitution: block.restitution.0[lane],
            separation: self.separation.0[lane],
            slop: block.slop.0[lane],
            speed_scale: block.speed_scale.0[lane],
            rebound,
            total_normal_impulse: self.total_normal_impulse.0[lane],
            adhesion: constraint.map_or(0.0, |constraint| constraint.adhesion.0[lane]),
            shear: constraint.map_or(0.0, |constraint| constraint.shear.0[lane]),
            ..PointRows::default()
        };
        rows.set_geometry(vector(&block.normal, lane), anchors, block.sides(lane));
        rows.set_impulses(self.impulse.map(|lanes| lanes.0[lane]));
        rows.normal.target_velocity = self.target_velocity.0[lane];
        for (k, row) in rows.tangents.iter_mut().enumerate() {
            row.target_velocity =
                constraint.map_or(0.0, |constraint| constraint.target_velocity[k].0[lane]);
        }
        rows
    }
}
