//! What inspectors and scene files may read and write: types registered for reflection.
//!
//! The types themselves are plain data that only derive `Reflect`; that they are components and resources is said here,
//! in the first layer that knows what these are.

use crate::bodies::anchors::Anchors;
use crate::bodies::body::RigidBody;
use crate::bodies::drive::LockedAxes;
use crate::bodies::fatigue::Fatigue;
use crate::contact::layers::CollisionLayers;
use crate::contact::material::{Density, Friction, Restitution};
use crate::contact::surface::SurfaceMaterials;
use crate::ecs::bond_constructor::BondConstructor;
use crate::ecs::collisions::{CollisionEvents, ContactForceEvents, Sensor};
use crate::ecs::components::{
    AngularVelocity, LinearVelocity, MassOverride, ShapeAwaited, Sleeping,
};
use crate::ecs::forces::*;
use crate::ecs::joint::{JointA, JointB, JointsOfA, JointsOfB};
use crate::ecs::parts::CompoundOfChildren;
use crate::ecs::piece_children::ChildrenOfPieces;
use crate::ecs::pieces::{PieceOf, Pieces, Remains};
use crate::ecs::shape_constructor::{CompoundConstructor, LevelConstructor, ShapeConstructor};
use crate::ecs::walker::Walker;
use crate::fracture::{FractureBudget, Ledger};
use crate::geometry::HalfSpaceShape;
use crate::joints::{Joint, JointLoad};
use crate::mass::MassProperties;
use crate::slice::fracturable::Fracturable;
use crate::solver::config::{Gravity, SolverConfig};
use crate::step::StepReport;
use bevy_app::App;
use bevy_ecs::prelude::{Component, Resource};
use bevy_ecs::reflect::{ReflectComponent, ReflectResource};
use bevy_reflect::std_traits::ReflectDefault;
use bevy_reflect::{FromReflect, GetTypeRegistration, TypePath};

/// Registers all types of the plugin that have `Reflect`. Fields' types follow by themselves.
pub(crate) fn register_types(app: &mut App) {
    // These have no default: they name entities.
    component::<JointA>(app);
    component::<JointB>(app);
    component::<PieceOf>(app);
    component::<Remains>(app);
    component_with_default::<JointsOfA>(app);
    component_with_default::<JointsOfB>(app);
    component_with_default::<Pieces>(app);
    component_with_default::<HalfSpaceShape>(app);
    component_with_default::<MassOverride>(app);
    component_with_default::<Joint>(app);
    component_with_default::<JointLoad>(app);
    component_with_default::<ShapeConstructor>(app);
    component_with_default::<CompoundConstructor>(app);
    component_with_default::<LevelConstructor>(app);
    component_with_default::<BondConstructor>(app);
    component_with_default::<Walker>(app);
    component_with_default::<Fracturable>(app);
    component_with_default::<RigidBody>(app);
    component_with_default::<LinearVelocity>(app);
    component_with_default::<AngularVelocity>(app);
    component_with_default::<Density>(app);
    component_with_default::<Mass>(app);
    component_with_default::<MassProperties>(app);
    component_with_default::<Friction>(app);
    component_with_default::<Restitution>(app);
    component_with_default::<SurfaceMaterials>(app);
    component_with_default::<CollisionLayers>(app);
    component_with_default::<Sleeping>(app);
    component_with_default::<ShapeAwaited>(app);
    component_with_default::<CollisionEvents>(app);
    component_with_default::<ContactForceEvents>(app);
    component_with_default::<Sensor>(app);
    component_with_default::<GravityScale>(app);
    component_with_default::<LinearDamping>(app);
    component_with_default::<AngularDamping>(app);
    component_with_default::<LockedAxes>(app);
    component_with_default::<MaxSpeed>(app);
    component_with_default::<ConstantForce>(app);
    component_with_default::<ConstantTorque>(app);
    component_with_default::<SurfaceVelocity>(app);
    component_with_default::<ChildrenOfPieces>(app);
    component_with_default::<CompoundOfChildren>(app);
    component_with_default::<Anchors>(app);
    component_with_default::<Fatigue>(app);
    resource::<Gravity>(app);
    resource::<SolverConfig>(app);
    resource::<FractureBudget>(app);
    resource::<StepReport>(app);
    app.register_type::<Ledger>();
}

fn component_with_default<T>(app: &mut App)
where
    T: Component + Default + FromReflect + GetTypeRegistration + TypePath,
{
    component::<T>(app);
    app.register_type_data::<T, ReflectDefault>();
}

fn component<T: Component + FromReflect + GetTypeRegistration + TypePath>(app: &mut App) {
    app.register_type::<T>()
        .register_type_data::<T, ReflectComponent>();
}

fn resource<T>(app: &mut App)
where
    T: Resource + Default + FromReflect + GetTypeRegistration + TypePath,
{
    app.register_type::<T>()
        .register_type_data::<T, ReflectComponent>()
        .register_type_data::<T, ReflectResource>()
        .register_type_data::<T, ReflectDefault>();
}
