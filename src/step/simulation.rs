//! A simulation on plain data, and what its steps are told.

use crate::bodies::store::Bodies;
use crate::contact::impulses::ContactCache;
use crate::fracture::{Bond, BondError, Bonds, CutError, CutRequest, FractureBudget, Fractures};
use crate::joints::{Joint, JointError, JointId, Joints};
use crate::math::Plane;
use crate::query::{Queries, QueryIndex};
use crate::solver::config::{Gravity, SolverConfig};
use crate::solver::settings::SolverOverrides;
use crate::step::contacts::Contacts;
use crate::step::report::StepReport;
use crate::step::settings::StepSettings;

/// A simulation on plain data: what the plugin does, without an app.
///
/// A clone is a snapshot: it goes on to the same bits. Shapes are shared, buffers are left out.
#[derive(Clone, Debug, Default)]
pub struct Simulation {
    /// The bodies.
    pub bodies: Bodies,
    /// Contacts of the last step.
    pub contacts: Contacts,
    /// Multipliers of earlier steps.
    pub cache: ContactCache,
    /// Cuts asked for and made.
    pub fractures: Fractures,
    /// What holds bodies together.
    pub bonds: Bonds,
    /// What holds bodies together at a distance.
    pub joints: Joints,
    /// Gravity.
    pub gravity: Gravity,
    /// How contacts are solved.
    pub config: SolverConfig,
    /// What fracture may cost.
    pub budget: FractureBudget,
    /// What the last step did.
    pub report: StepReport,
    /// Where bodies are, for queries.
    pub query_index: QueryIndex,
    /// What a test wants otherwise.
    #[doc(hidden)]
    pub overrides: SolverOverrides,
}

impl Simulation {
    /// Cuts the body in `slot` by a plane (world frame) in the next step; what came of it is in `fractures` then.
    ///
    /// # Errors
    /// [`CutError::NoBody`] if the slot is free.
    pub fn slice(&mut self, slot: u32, plane: Plane) -> Result<(), CutError> {
        let request = CutRequest::in_world(&self.bodies, slot, plane)?;
        self.fractures.requests.push(request);
        Ok(())
    }

    /// Bonds the bodies in two slots as they lie now.
    ///
    /// # Errors
    /// [`BondError`]; nothing changes then.
    pub fn bond(&mut self, a: u32, b: u32, bond: Bond) -> Result<(), BondError> {
        self.bonds.bond(&mut self.bodies, a, b, bond)
    }

    /// Bonds all of the given bodies that touch face to face over their common areas with a tensile and shear strength
    /// (Pa); the number of bonds made. See [`Bonds::bond_neighbors`].
    ///
    /// # Errors
    /// [`BondError`]; no bonds are made then.
    pub fn bond_neighbors(&mut self, slots: &[u32], strength: f32) -> Result<usize, BondError> {
        self.bonds.bond_neighbors(&mut self.bodies, slots, strength)
    }

    /// A view of the bodies as they are now, for rays, casts, overlaps and what is near. To make it takes a look at each body (some
    /// 10 ns); it lasts until something changes.
    pub fn queries(&mut self) -> Queries<'_> {
        self.query_index.refresh(&self.bodies);
        self.query_index.queries(&self.bodies)
    }

    /// Joins the body in slot `b` to the one in slot `a`, or to the world.
    ///
    /// # Errors
    /// [`JointError`]; nothing changes then.
    pub fn join(&mut self, a: Option<u32>, b: u32, joint: Joint) -> Result<JointId, JointError> {
        self.joints.insert(&mut self.bodies, a, b, joint)
    }

    /// What the phases of a step of `step_dt` seconds are told.
    pub fn settings(&self, step_dt: f32) -> StepSettings {
        StepSettings {
            gravity: self.gravity,
            config: self.config,
            budget: self.budget,
            step_dt,
            overrides: self.overrides,
        }
    }
}
