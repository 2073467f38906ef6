//! The contacts that a pass goes through, with the bodies that they join.

use crate::bodies::solver_body::SolverBody;
use crate::simd::lanes::{F8, LaneWidth};
use crate::solver::config::FrictionModel;
use crate::solver::wide::block::{Block, Point, PointImpact};
use std::cell::Cell;

/// What all loops run over.
#[derive(Debug)]
pub struct ContactBlocks<'a> {
    /// Blocks of manifolds.
    pub blocks: &'a [Block],
    /// Points of the blocks.
    pub points: &'a mut [Point],
    /// What the blocks call the first of these points.
    pub first_point: usize,
    /// Impacts of the points; empty where nothing hits.
    pub impacts: &'a [PointImpact],
    /// By block: where a sweep that measures puts the largest velocity change of each lane; empty if nobody asks.
    pub lane_changes: &'a mut [F8],
    /// Velocities that the numbers in the blocks refer to.
    pub bodies: &'a [Cell<SolverBody>],
    /// Displacements of the bodies since the start of the step.
    pub displacements: &'a [Cell<SolverBody>],
    /// Shape of the friction bound.
    pub friction: FrictionModel,
    /// Lanes of a register.
    pub width: LaneWidth,
    /// Whether blocks and points lie in far memory, so that sweeps ask for them ahead.
    pub is_far: bool,
}

/// The elements of a list, for passes.
pub(crate) fn cells<T>(list: &mut [T]) -> &[Cell<T>] {
    Cell::from_mut(list).as_slice_of_cells()
}
