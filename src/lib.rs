//! Rigid-body physics for convex bodies with real-time slicing and fracture, as a plugin for `bevy_ecs` and `bevy_app`.
//!
//! Bodies are convex polyhedra with exact mass, center and inertia. Contacts are rows of one mixed linear
//! complementarity problem, warm-started from a cache keyed by KD codes. A plane cuts a body, and the mesh that rides in
//! it, into closed pieces that are bodies of their own. The README has a scene to start from, in an app and without one.
//!
//! # Where to read on
//!
//! Users need the [`prelude`] and what is public in these rooms:
//!
//! - [`plugin`]: the phases of a step as system sets; [`ecs`]: components, commands and messages.
//! - [`step`]: the loop, one function per phase; [`Simulation`](prelude::Simulation) runs it on plain data, without an app.
//! - [`solver`]: methods and settings ([`SolverConfig`](prelude::SolverConfig)); [`bodies`]: what a body is made from.
//! - [`fracture`]: who breaks, and what becomes of the motion; [`mod@slice`]: a plane against meshes and hulls, patterns.
//! - [`contact`], [`mass`], [`geometry`], [`math`]: what the others are built on.
//!
//! How it works inside is told in the repository: `docs/architecture.md` opens with the way of one contact through a step and says
//! where to find what, `docs/glossary.md` has the terms. Layers from the bottom up, each of which uses only those before it: `math`, `simd`,
//! `threads`, `geometry`, `mass`, `slice`, `contact`, `bodies`, `solver`, `collide`, `fracture`, `step`, `ecs`, `plugin`.
//!
//! # Conventions
//!
//! - SI units: m, kg, s, rad, N s. Right-handed axes; only the default [`Gravity`](prelude::Gravity) prefers one (-y).
//! - A body's frame is that of its shape as given and of its entity's `Transform`; it need not be at the center of mass.
//!   Linear velocity is that of the center of mass; velocities are in world axes.
//! - Normals point from body A to body B, A being the one with the smaller id. Separation is negative where they overlap.
//! - Triangles and face loops run counter-clockwise seen from outside. A plane's positive side is where its normal points.
//! - State and geometry are `f32`, volume integrals and exact predicates `f64`. The step uses `+ - * /` and square roots
//!   only, in a fixed order: the same scene gives the same bits on any number of threads.
pub mod bodies;
pub mod collide;
pub mod contact;
pub mod ecs;
pub mod fracture;
pub mod geometry;
pub mod mass;
pub mod math;
mod merge;
pub mod plugin;
pub mod simd;
pub mod slice;
pub mod solver;
pub mod step;
pub mod threads;

/// What most users need.
pub mod prelude {
    pub use crate::bodies::body::{BodyDesc, BodyError, RigidBody, Shape};
    pub use crate::bodies::store::Bodies;
    pub use crate::contact::body_id::BodyId;
    pub use crate::contact::impulses::ContactCache;
    pub use crate::contact::layers::CollisionLayers;
    pub use crate::contact::material::{CombineRule, Density, Friction, Restitution};
    pub use crate::ecs::bond::BondCommands;
    pub use crate::ecs::components::{
        AngularVelocity, BodyHandle, BodyProblem, BodyWarning, BondBroken, Fractured,
        LinearVelocity, MassOverride, Sleeping,
    };
    pub use crate::ecs::cut::SliceCommands;
    pub use crate::ecs::spawn::SpawnBody;
    pub use crate::fracture::{
        Bond, BondError, Bonds, BreakingImpact, BrokenBond, CutError, CutRequest, Fracture,
        FractureBudget, Fractures, Ledger,
    };
    pub use crate::geometry::{ConvexHull, ConvexMesh, HalfSpace, HullError, MeshError, TriMesh};
    pub use crate::mass::MassProperties;
    pub use crate::math::{Aabb, Plane, Pose};
    pub use crate::plugin::{CleavePlugin, PhysicsSchedule, PhysicsSystems};
    pub use crate::slice::fracturable::Fracturable;
    pub use crate::slice::pattern::FracturePattern;
    #[cfg(feature = "exact")]
    pub use crate::solver::config::Exact;
    pub use crate::solver::config::{
        FrictionModel, Gravity, Method, Pgs, SleepConfig, SoftStep, SolverConfig,
    };
    pub use crate::step::{
        Contacts, IslandReport, Simulation, StepError, StepReport, StepSettings,
    };
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}
