//! What the sub-steps of a batch found: as rows, and as impulses of contact points.

use crate::contact::manifolds::Run;
use crate::solver::batch::Batch;
use crate::solver::graph::indices::{BodyNumber, LaneSlot, ManifoldIndex};
use crate::solver::rows::contact_rows::PointRows;
use std::ops::Range;

impl Batch {
    /// Adds the rows of an island's points to `rows`, in the order of its manifolds, with numbers of bodies within the island.
    /// `places`: those of the island.
    pub fn collect_rows(&self, places: Range<usize>, first_body: u32, rows: &mut Vec<PointRows>) {
        for &(_, place) in &self.layout.places[places] {
            let (block, lane) = (
                &self.contacts.blocks[place.block as usize],
                place.lane as usize,
            );
            for i in block.points.clone().take(place.count as usize) {
                let rebound = self
                    .impacts
                    .points
                    .get(i)
                    .map_or(0.0, |impact| impact.rebound.0[lane]);
                let mut point = self.contacts.points[i].rows(
                    lane,
                    block,
                    self.bonds.constraints.get(i),
                    rebound,
                );
                point.bodies = point
                    .bodies
                    .map(|body| self.layout.original(BodyNumber(body)).0 - first_body);
                rows.push(point);
            }
        }
    }

    /// Writes the impulses into the contact points of a run of manifolds, of which the first has the index `first`, and leaves
    /// out what is not among them.
    pub(crate) fn store_impulses(&self, run: &mut Run, first: usize) {
        let end = first + run.len();
        for member in &self.layout.members {
            // Those of one island come in their order.
            let places = &self.layout.places[member.places.clone()];
            let [from, to] =
                [first, end].map(|past| places.partition_point(|place| place.0.index() < past));
            self.store_places(&places[from..to], first, run);
        }
    }

    /// `first`: index of the first manifold of the run.
    fn store_places(&self, places: &[(ManifoldIndex, LaneSlot)], first: usize, run: &mut Run) {
        let substeps = self.settings.substeps;
        for &(index, place) in places {
            let block = &self.contacts.blocks[place.block as usize];
            let to = run.points_of(index.index() - first);
            for (to, point) in to
                .iter_mut()
                .zip(&self.contacts.points[block.points.clone()])
            {
                point.store(place.lane as usize, block, to, substeps);
            }
        }
    }
}
