//! Rigid-body physics for convex bodies with real-time slicing and fracture.

pub mod collide;
pub mod contact;
pub mod ecs;
pub mod fracture;
pub mod geometry;
pub mod mass;
pub mod math;
pub mod plugin;
pub mod slice;
pub mod solver;
pub mod step;

/// What most users need.
pub mod prelude {
    pub use crate::contact::cache::ContactCache;
    pub use crate::contact::material::{CombineRule, Density, Friction, Restitution};
    pub use crate::contact::{BodyId, CollisionLayers};
    pub use crate::ecs::components::{
        AngularVelocity, BodyHandle, BodyProblem, BodyWarning, Fractured, LinearVelocity,
        MassOverride,
    };
    pub use crate::ecs::cut::SliceCommands;
    pub use crate::fracture::{CutError, CutRequest, Fracture, Fractures, Ledger};
    pub use crate::geometry::{ConvexHull, ConvexMesh, HalfSpace, HullError, MeshError, TriMesh};
    pub use crate::mass::MassProperties;
    pub use crate::math::{Aabb, Plane, Pose};
    pub use crate::plugin::{CleavePlugin, PhysicsSchedule, PhysicsSystems};
    pub use crate::slice::fracturable::Fracturable;
    pub use crate::slice::pattern::FracturePattern;
    pub use crate::solver::bodies::{Bodies, BodyDesc, BodyError, RigidBody, Shape};
    pub use crate::solver::{FrictionModel, Gravity, SolverConfig};
    pub use crate::step::{Contacts, Simulation, StepError, StepReport, StepSettings};
}
