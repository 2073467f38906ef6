//! A point of a lane as the rows of its problem, for the exact method and for residuals.

use crate::solver::rows::contact_rows::PointRows;
use crate::solver::wide::block::{Block, Point, vector};
use crate::solver::wide::bond::Tie;

impl Point {
    /// The point of a lane as rows.
    pub fn rows(&self, lane: usize, block: &Block, tie: Option<&Tie>, rebound: f32) -> PointRows {
        let anchors = [0, 1].map(|k| vector(&self.anchors[k], lane));
        let mut rows = PointRows {
            bodies: block.pair(lane),
            friction: block.friction.0[lane],
            restitution: block.restitution.0[lane],
            separation: self.separation.0[lane],
            slop: block.slop.0[lane],
            speed_scale: block.speed_scale.0[lane],
            rebound,
            total: self.total.0[lane],
            adhesion: tie.map_or(0.0, |tie| tie.adhesion.0[lane]),
            shear: tie.map_or(0.0, |tie| tie.shear.0[lane]),
            ..PointRows::default()
        };
        rows.set_geometry(vector(&block.normal, lane), anchors, block.sides(lane));
        rows.set_impulses(self.impulse.map(|lanes| lanes.0[lane]));
        rows.normal.wanted = self.wanted.0[lane];
        for (k, row) in rows.tangents.iter_mut().enumerate() {
            row.wanted = tie.map_or(0.0, |tie| tie.wanted[k].0[lane]);
        }
        rows
    }
}
