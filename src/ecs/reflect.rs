//! What inspectors and scene files may read and write: types registered for reflection.
//!
//! The types themselves are plain data that only derive `Reflect`; that they are components and resources is said here,
//! in the first layer that knows what these are.

use crate::bodies::body::RigidBody;
use crate::contact::layers::CollisionLayers;
use crate::contact::material::{Density, Friction, Restitution};
use crate::ecs::components::{AngularVelocity, LinearVelocity, MassOverride, Sleeping};
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
use bevy_reflect::{FromReflect, GetTypeRegistration, TypePath};

/// Registers all types of the plugin that have `Reflect`. Fields' types follow by themselves.
pub(crate) fn register_types(app: &mut App) {
    component::<RigidBody>(app);
    component::<HalfSpaceShape>(app);
    component::<LinearVelocity>(app);
    component::<AngularVelocity>(app);
    component::<Density>(app);
    component::<MassOverride>(app);
    component::<MassProperties>(app);
    component::<Friction>(app);
    component::<Restitution>(app);
    component::<CollisionLayers>(app);
    component::<Fracturable>(app);
    component::<Sleeping>(app);
    component::<Joint>(app);
    component::<JointLoad>(app);
    resource::<Gravity>(app);
    resource::<SolverConfig>(app);
    resource::<FractureBudget>(app);
    resource::<StepReport>(app);
    app.register_type::<Ledger>();
}

fn component<T: Component + FromReflect + GetTypeRegistration + TypePath>(app: &mut App) {
    app.register_type::<T>()
        .register_type_data::<T, ReflectComponent>();
}

fn resource<T: Resource + FromReflect + GetTypeRegistration + TypePath>(app: &mut App) {
    app.register_type::<T>()
        .register_type_data::<T, ReflectComponent>()
        .register_type_data::<T, ReflectResource>();
}
