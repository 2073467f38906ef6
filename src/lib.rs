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
//! - [`extras`]: plugins of their own, such as interpolation, and those of the cargo features `mesh`, `gizmos`, `diagnostics`
//!   and `picking`.
//! - [`step`]: the loop, one function per phase; [`Simulation`](prelude::Simulation) runs it on plain data, without an app.
//! - [`joints`]: what holds two bodies together at a distance.
//! - [`solver`]: methods and settings ([`SolverConfig`](prelude::SolverConfig)); [`bodies`]: what a body is made from.
//! - [`import`]: a door for models as artists make them.
//! - [`fracture`]: who breaks, and what becomes of the motion; [`mod@slice`]: a plane against meshes and hulls, patterns.
//! - [`query`]: rays, casts, overlaps and what is near.
//! - [`contact`], [`mass`], [`geometry`], [`math`]: what the others are built on.
//!
//! How it works inside is told in the repository: `docs/architecture.md` opens with the way of one contact through a step and says
//! where to find what, `docs/glossary.md` has the terms. Layers from the bottom up, each of which uses only those before it: `tuning`,
//! `math`, `merge`, `disjoint_sets`, `simd`, `threads`, `geometry`, `mass`, `slice`, `import`, `cluster`, `contact`, `bodies`, `joints`, `solver`, `collide`,
//! `query`, `fracture`, `step`, `ecs`, `plugin`, `extras`.
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
pub mod cluster;
mod collide;
pub mod contact;
mod disjoint_sets;
pub mod ecs;
pub mod extras;
pub mod fracture;
pub mod geometry;
pub mod import;
pub mod joints;
pub mod mass;
pub mod math;
mod merge;
pub mod plugin;
pub mod query;
mod simd;
pub mod slice;
pub mod solver;
pub mod step;
mod threads;
mod tuning;

/// What most users need.
pub mod prelude {
    pub use crate::bodies::{
        AnchorRegion, Anchors, Bodies, BodyDesc, BodyDrive, BodyError, Fatigue, LockedAxes,
        RigidBody, Shape, StepForces,
    };
    pub use crate::cluster::{Cluster, ClusterError};
    pub use crate::contact::{
        BodyId, CollisionLayers, CombineRule, ContactCache, Density, Friction, Restitution,
        SurfaceMaterials,
    };
    pub use crate::ecs::{
        AngularDamping, AngularVelocity, BodyHandle, BodyIssues, BodyProblem, BodyWarning,
        BondBroken, BondCommands, BondConstructor, BondDescription, ChildrenOfPieces, Collision,
        CollisionEnd, CollisionEvents, CollisionStart, Collisions, CompoundConstructor,
        CompoundOfChildren, ConstantForce, ConstantTorque, ContactForce, ContactForceEvents,
        DebrisRemoved, Explosion, Fading, ForceCommands, Forces, ForcesItem, FractureCause,
        Fractured, GravityScale, JointA, JointB, JointBroken, JointCommands, JointHandle,
        JointProblem, JointsOfA, JointsOfB, LevelConstructor, LinearDamping, LinearVelocity, Mass,
        MassOverride, MaxSpeed, PhysicsHistory, PieceOf, PieceRules, Pieces, Remains, RewindApp,
        RewindCommands, Rewound, Sensor, ShapeAwaited, ShapeConstructor, Sleeping, SliceCommands,
        SpatialQuery, SpawnBody, SurfaceVelocity, Walker, WalkerError, Walking, describe_bodies,
    };
    #[cfg(feature = "diagnostics")]
    pub use crate::extras::CleaveDiagnosticsPlugin;
    #[cfg(feature = "picking")]
    pub use crate::extras::CleavePickingPlugin;
    #[cfg(feature = "gizmos")]
    pub use crate::extras::{CleaveGizmos, CleaveGizmosPlugin};
    #[cfg(feature = "mesh")]
    pub use crate::extras::{
        CleaveMeshPlugin, DrawShape, MeshConversionError, ShapeFromMesh, ShapeFromMeshError,
        ShapeRefused, ShapesOfScene, SlotMesh,
    };
    pub use crate::extras::{InterpolationPlugin, NoInterpolation};
    pub use crate::fracture::{
        Bond, BondError, Bonds, BreakingImpact, BrokenBond, CutError, CutRequest, DebrisRules,
        ExpiredPiece, FadingPiece, Fracture, FractureBudget, Fractures, Ledger, RemovedDebris,
    };
    pub use crate::geometry::{
        Compound, CompoundError, CompoundPart, ConvexHull, ConvexMesh, HalfSpaceShape, HullError,
        MeshError, PartBond, StaticMesh, TriMesh,
    };
    pub use crate::joints::{
        AxisRange, BrokenJoint, DriveTarget, Joint, JointAxis, JointDrive, JointError, JointId,
        JointLoad, JointSpring, Joints,
    };
    pub use crate::mass::MassProperties;
    pub use crate::math::{Aabb, Plane, Pose};
    pub use crate::plugin::{
        CleavePlugin, PhysicsSchedule, PhysicsSystems, RewindPlugin, WalkerPlugin,
    };
    pub use crate::query::{
        Blade, Queries, QueryError, QueryFilter, QueryHit, QueryIndex, QueryShape, Ray, ShapeCast,
        Slid, Slider, WalkInput, WalkSettings, WalkState,
    };
    pub use crate::slice::{Fracturable, FracturePattern, Relief};
    #[cfg(feature = "exact")]
    pub use crate::solver::Exact;
    pub use crate::solver::{
        FrictionModel, Gravity, Method, Pgs, SleepConfig, SoftStep, SolverConfig,
    };
    pub use crate::step::{
        ContactChange, ContactEvent, ContactEvents, ContactWatch, Contacts, IslandReport,
        Simulation, StepError, StepReport, StepSettings,
    };
    pub use crate::{capsule, cone, cuboid, cylinder, icosphere, prism, sphere};
}

/// Inside views for the tests, benches and examples of this crate, by room. No part of the interface: it changes at will.
#[doc(hidden)]
pub mod testing {
    pub mod approximate {
        pub use crate::mass::approximate::{
            mean_of_vertices, off_diagonals_dropped, vertices_as_particles,
        };
    }
    pub mod batch {
        pub use crate::solver::adaptivity::IslandRequirements;
        pub use crate::solver::batch::layout::Group;
        pub use crate::solver::batch::{Batch, Step};
        pub use crate::solver::contact_solver::ContactSolver;
        pub use crate::solver::settings::{SolverOverrides, SubstepSettings};
    }
    pub mod bodies {
        pub use crate::bodies::integrate::integrate_positions;
        pub use crate::bodies::solver_body::{BodyMass, SolverBody};
    }
    pub mod collide {
        pub use crate::collide::narrow_phase::{NarrowPhase, update_pairs};
        pub use crate::collide::proxies::Lookahead;
    }
    pub mod contact {
        pub use crate::contact::body_manifold::ManifoldBody;
        pub use crate::contact::impulses::{CacheEntry, MAX_AGE};
        pub use crate::contact::narrow::half_space::collide_half_space;
        pub use crate::contact::pairs::broad_phase::{
            Broadphase, Pair, Proxy, ProxyKind, ProxyShape,
        };
    }
    #[cfg(feature = "exact")]
    pub mod exact {
        pub use crate::solver::exact::problem::{
            Body, Bounds, Contact, ContactProblem, DenseProblem,
        };
        pub use crate::solver::exact::{
            CERTIFIED, Certificate, ExactScratch, solve, solve_bodies, solve_dense,
        };
    }
    pub mod fracture {
        pub use crate::cluster::network::BREAKING_SHARE;
    }
    pub mod graph {
        pub use crate::solver::graph::coloring::Coloring;
        pub use crate::solver::graph::contact_order::ContactOrder;
        pub use crate::solver::graph::indices::{BodyNumber, LaneSlot, ManifoldIndex};
        pub use crate::solver::graph::islands::{Island, Islands};
        pub use crate::solver::graph::lane_assignment::{
            AssignmentRule, ContactEdge, LaneAssignment,
        };
        pub use crate::solver::graph::ordered_packing::{OrderedPacking, Packer};
        pub use crate::solver::graph::partition::{Partition, leaves, stages};
    }
    pub mod math {
        pub use crate::math::{rotate, tangents};
    }
    pub mod pgs {
        pub use crate::solver::rows::pgs::{
            ContactRows, apply_impulses, friction_in_box, relax, solve, sweep,
        };
    }
    pub mod predicates {
        pub use crate::geometry::predicates::{
            CONVEX_RELATIVE, FLAT_RELATIVE, ON_PLANE_RELATIVE, check_plane, convex_tolerance,
            length_scale, plane_tolerance, side, signed_distance,
        };
    }
    pub mod rows {
        pub use crate::solver::rows::acceleration::{ImpulseSystem, Momentum, PointContacts};
        pub use crate::solver::rows::contact_rows::{PointRows, Row, RowBody};
        pub use crate::solver::rows::mlcp::DenseMlcp;
        pub use crate::solver::rows::residual::{ResidualSum, Solved};
        pub use crate::solver::rows::soft_step::{Bias, RowSoftness, Softness};
    }
    pub mod simd {
        pub use crate::simd::dispatch::run;
        pub use crate::simd::lanes::{F8, Kernel, LaneWidth, Lanes, WIDTH};
    }
    pub mod slice {
        pub use crate::slice::crack_area::CrackArea;
    }
    pub mod threads {
        pub use crate::threads::team::{Shared, Team};
    }
    pub mod wide {
        pub use crate::solver::wide::block::{Block, Point};
        pub use crate::solver::wide::bond::BondConstraint;
        pub use crate::solver::wide::contacts::ContactBlocks;
        pub use crate::solver::wide::pass::Pass;
        pub use crate::solver::wide::prepare::{Source, fill};
    }
}

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

#[cfg(doctest)]
#[doc = include_str!("../docs/features.md")]
mod features {}
