//! What a body is made from, and why one is refused.

use crate::contact::layers::CollisionLayers;
use crate::contact::material::{Friction, MaterialError, Restitution};
use crate::contact::surface::{SurfaceMaterial, SurfaceMaterials};
use crate::geometry::predicates::check_plane;
use crate::geometry::{Compound, ConvexMesh, HalfSpaceShape, MeshError, PlaneError, StaticMesh};
use crate::mass::{MassError, MassProperties};
use crate::math::{Plane, Pose};
use crate::slice::fracturable::{Fracturable, FracturableError};
use crate::slice::roughen::CutLooks;
use bevy_ecs::component::Component;
use glam::{Quat, Vec3};

/// How a body moves. Immutable: insert another value to change it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Component)]
#[component(immutable)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum RigidBody {
    /// Moved by forces and contacts.
    #[default]
    Dynamic,
    /// Moved by its velocity only, as if infinitely heavy, or by its entity's `Transform`, up to rounding, if that is set elsewhere.
    Kinematic,
    /// Never moves.
    Static,
}

/// Shape of a body.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A convex hull, perhaps with a mesh riding in it.
    Convex(ConvexMesh),
    /// Everything behind a plane; only for bodies that are not dynamic.
    HalfSpace(HalfSpaceShape),
    /// A mesh of triangles; only for bodies that are not dynamic.
    Level(StaticMesh),
    /// Several convex parts.
    Compound(Compound),
}

impl Shape {
    /// The level of triangles, if it is one.
    pub(crate) fn level(&self) -> Option<&StaticMesh> {
        match self {
            Self::Level(mesh) => Some(mesh),
            _ => None,
        }
    }

    /// The convex shape, if it is one.
    pub(crate) fn convex(&self) -> Option<&ConvexMesh> {
        match self {
            Self::Convex(mesh) => Some(mesh),
            _ => None,
        }
    }

    /// Whether its surface, or that of a part, is curved.
    pub(crate) fn is_round(&self) -> bool {
        match self {
            Self::Convex(mesh) => mesh.is_round(),
            Self::Compound(compound) => compound.has_round(),
            Self::HalfSpace(_) | Self::Level(_) => false,
        }
    }
}

/// What a body is made from.
#[derive(Clone, Debug)]
pub struct BodyDesc {
    /// How it moves.
    pub kind: RigidBody,
    /// Its shape.
    pub shape: Shape,
    /// `world_from_body`: where the shape's frame is.
    pub pose: Pose,
    /// Velocity of the center of mass, m/s.
    pub linear_velocity: Vec3,
    /// Angular velocity, world axes, rad/s.
    pub angular_velocity: Vec3,
    /// Density, kg/m3.
    pub density: f32,
    /// Mass properties to use instead of those that follow from shape and density.
    pub mass: Option<MassProperties>,
    /// Friction.
    pub friction: Friction,
    /// Restitution.
    pub restitution: Restitution,
    /// Of a level: both by material slot.
    pub surfaces: Option<SurfaceMaterials>,
    /// Which bodies it may touch.
    pub layers: CollisionLayers,
    /// Whether it only senses who is inside it, and neither pushes nor is pushed.
    pub is_sensor: bool,
    /// How it breaks, if it does.
    pub fracturable: Option<Fracturable>,
}

impl BodyDesc {
    /// A body at the origin, at rest, of density 1000 kg/m3, with default materials, that does not break.
    pub fn new(kind: RigidBody, shape: Shape) -> Self {
        Self {
            kind,
            shape,
            pose: Pose::IDENTITY,
            linear_velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
            density: 1000.0,
            mass: None,
            friction: Friction::default(),
            restitution: Restitution::default(),
            surfaces: None,
            layers: CollisionLayers::default(),
            is_sensor: false,
            fracturable: None,
        }
    }

    /// A dynamic convex body at `position`.
    pub fn dynamic(shape: ConvexMesh, position: Vec3) -> Self {
        Self {
            pose: Pose::new(position, Quat::IDENTITY),
            ..Self::new(RigidBody::Dynamic, Shape::Convex(shape))
        }
    }

    /// A dynamic body of several parts at `position`.
    pub fn compound(shape: Compound, position: Vec3) -> Self {
        Self {
            pose: Pose::from_position(position),
            ..Self::new(RigidBody::Dynamic, Shape::Compound(shape))
        }
    }

    /// A static level of triangles at the origin.
    pub fn level(mesh: StaticMesh) -> Self {
        Self::new(RigidBody::Static, Shape::Level(mesh))
    }

    /// A static half-space through the origin with the given outward normal: a floor.
    pub fn floor(half_space: HalfSpaceShape) -> Self {
        Self::new(RigidBody::Static, Shape::HalfSpace(half_space))
    }
}

/// Why a body is left out of the simulation.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BodyError {
    /// Position, rotation or velocity is NaN or infinite.
    #[error("{0} is not finite; the body is left out until it is")]
    NotFinite(&'static str),
    /// The motion overflowed: something pushed the body to an infinite speed.
    #[error("the motion overflowed; the body was stopped where it was")]
    Overflow,
    /// The rotation is not a unit quaternion.
    #[error(
        "the rotation is not a unit quaternion (length {length}); the body is left out until it is"
    )]
    NotUnitRotation {
        /// Length of the quaternion.
        length: f32,
    },
    /// No shape comes of this scale of the entity's `Transform`.
    #[error("a shape cannot be scaled by {0}: it must be finite, positive and not too small")]
    Scaled(Vec3),
    /// Parents that are scaled and turned shear the shape.
    #[error("parents with unequal scales shear the shape; scale it instead (ConvexMesh::scaled)")]
    Sheared,
    /// The density or the shape gives no usable mass.
    #[error(transparent)]
    Mass(#[from] MassError),
    /// Friction or restitution is out of range.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// The normal of a half-space is zero or not finite.
    #[error(transparent)]
    HalfSpace(#[from] PlaneError),
    /// A static body has a velocity.
    #[error("a Static body has a velocity, which does nothing: make it Kinematic")]
    StaticVelocity,
    /// A body that forces do not move is pushed all the time.
    #[error("ConstantForce and ConstantTorque move Dynamic bodies only")]
    IdleForce,
    /// What has no inside, or what no blow meets, is to break.
    #[error("Fracturable does nothing to a half-space, a StaticMesh or a Sensor")]
    UnbreakableShape,
    /// What is seen of a body that is to break does not enclose anything.
    #[error("Fracturable does nothing: its mesh cannot be cut ({0}); import::Model closes holes")]
    UnbreakableVisual(MeshError),
    /// What is to be made of several materials has no triangles with slots.
    #[error("SurfaceMaterials do nothing without a StaticMesh that has material slots")]
    IdleSurfaces,
    /// No blow makes two pieces of the body.
    #[error("Fracturable does nothing: pattern and max_pieces make no two pieces of the shape")]
    NoPieces,
    /// Numbers of `Fatigue` mean nothing.
    #[error("Fatigue needs a positive energy, and endurance and damage from 0 to 1")]
    Fatigue,
    /// A body that does not break is to wear out.
    #[error("Fatigue does nothing to a body that is neither Fracturable nor held by bonds")]
    IdleFatigue,
    /// Anchors mean nothing, or are on a body that falls anyway.
    #[error("Anchors do nothing: {0}")]
    Anchors(&'static str),
    /// More than one shape on an entity.
    #[error("an entity has one shape: ConvexMesh comes before Compound and HalfSpaceShape")]
    SeveralShapes,
    /// A shape or something else of a body, and no body.
    #[error(
        "what makes a body (a shape, Fracturable, Sensor, a force) does nothing without RigidBody"
    )]
    NoRigidBody,
    /// Something on a part of a compound that is of the whole body, or a shape that is no part.
    #[error(
        "a part of a compound has a ConvexMesh and a place: what else makes a body does nothing there, but on the compound's entity"
    )]
    IdlePart,
    /// A half-space cannot be dynamic.
    #[error("a half-space has no mass and cannot be dynamic")]
    DynamicHalfSpace,
    /// A level of triangles cannot be dynamic.
    #[error("a StaticMesh has no mass and cannot be dynamic")]
    DynamicLevel,
    /// Nobody knows which part would have which share of a given mass.
    #[error("a Compound with bonds cannot have a MassOverride: give it a Density instead")]
    BondedOverride,
    /// Strength or least volume is out of range.
    #[error(transparent)]
    Fracturable(#[from] FracturableError),
    /// Nobody knows which piece would get which share of a given mass.
    #[error("a body with a MassOverride cannot be Fracturable: give it a Density instead")]
    FracturableOverride,
    /// The `Mass` of the entity is not a positive number.
    #[error("Mass must be finite and positive, got {0} kg")]
    TotalMass(f32),
    /// A number of what drives the body means nothing: NaN, or negative where it must not be.
    #[error("{0} has a number that is not finite or negative; it does not act")]
    Drive(&'static str),
    /// A component that every body has was removed.
    #[error("a component that RigidBody requires (Transform, velocities, materials) was removed")]
    Incomplete,
    /// Neither `ConvexMesh`, `Compound`, `HalfSpaceShape` nor `StaticMesh` is there.
    #[error("a RigidBody needs a ConvexMesh, a Compound, a HalfSpaceShape or a StaticMesh")]
    NoShape,
}

/// What the step needs of a body besides its motion.
#[derive(Clone, Debug)]
pub(crate) struct BodyInfo {
    pub(crate) kind: RigidBody,
    pub(crate) shape: Shape,
    pub(crate) density: f32,
    pub(crate) mass_override: Option<MassProperties>,
    pub(crate) friction: Friction,
    pub(crate) restitution: Restitution,
    pub(crate) surfaces: Option<Box<SurfaceMaterials>>,
    pub(crate) layers: CollisionLayers,
    pub(crate) is_sensor: bool,
    pub(crate) fracturable: Option<Fracturable>,
    /// Of a piece that breaks no more: how its cuts look, if that is how cuts of what it was looked.
    pub(crate) cut_looks: Option<Box<CutLooks>>,
}

impl BodyInfo {
    pub(crate) fn of(desc: BodyDesc) -> Self {
        Self {
            kind: desc.kind,
            shape: desc.shape,
            density: desc.density,
            mass_override: desc.mass,
            friction: desc.friction,
            restitution: desc.restitution,
            surfaces: desc.surfaces.map(Box::new),
            layers: desc.layers,
            is_sensor: desc.is_sensor,
            fracturable: desc.fracturable,
            cut_looks: None,
        }
    }

    /// What its surface is made of.
    pub(crate) fn surface(&self) -> SurfaceMaterial {
        SurfaceMaterial {
            friction: self.friction,
            restitution: self.restitution,
        }
    }

    /// The same of the triangles in a slot, if it is a level that has such.
    pub(crate) fn surface_of(&self, slot: u16) -> SurfaceMaterial {
        let known = self.surfaces.as_ref().and_then(|known| known.get(slot));
        known.copied().unwrap_or_else(|| self.surface())
    }

    /// Whether friction, restitution and strength are usable.
    pub(crate) fn check_material(&self) -> Result<(), BodyError> {
        self.friction.validate()?;
        self.restitution.validate()?;
        if let Some(surfaces) = &self.surfaces {
            surfaces.validate()?;
        }
        let is_bonded = self.shape.compound().is_some_and(Compound::is_bonded);
        if is_bonded && self.mass_override.is_some() {
            return Err(BodyError::BondedOverride);
        }
        match &self.fracturable {
            Some(_) if self.mass_override.is_some() => Err(BodyError::FracturableOverride),
            Some(fracturable) => Ok(fracturable.validate()?),
            None => Ok(()),
        }
    }

    /// Whether shape and density make a body.
    pub(crate) fn check_mass(&self) -> Result<(), BodyError> {
        match (&self.shape, self.mass_override) {
            (Shape::HalfSpace(_), _) if self.kind == RigidBody::Dynamic => {
                Err(BodyError::DynamicHalfSpace)
            }
            (Shape::Level(_), _) if self.kind == RigidBody::Dynamic => Err(BodyError::DynamicLevel),
            (Shape::Level(_), _) => Ok(()),
            (Shape::HalfSpace(half_space), _) => {
                let plane = Plane::through(Vec3::ZERO, half_space.normal);
                Ok(check_plane(&plane)?)
            }
            (Shape::Convex(_) | Shape::Compound(_), Some(given)) => Ok(given.validate()?),
            (Shape::Compound(compound), None) => {
                Ok(MassProperties::of_compound(compound, self.density).map(drop)?)
            }
            (Shape::Convex(mesh), None) => {
                Ok(MassProperties::of_shape(mesh, self.density).map(drop)?)
            }
        }
    }

    /// Whether mass properties follow from the same things in both.
    pub(crate) fn has_mass_of(&self, other: &Self) -> bool {
        self.shape.is_same(&other.shape)
            && self.density == other.density
            && self.mass_override == other.mass_override
    }

    /// Whether contacts of both are found and solved in the same way, given the same shape and mass.
    pub(crate) fn touches_like(&self, other: &Self) -> bool {
        self.friction == other.friction
            && self.restitution == other.restitution
            && self.surfaces == other.surfaces
            && self.layers == other.layers
            && self.is_sensor == other.is_sensor
    }
}

pub(crate) fn check_pose(pose: &Pose) -> Result<(), BodyError> {
    if !pose.position.is_finite() {
        return Err(BodyError::NotFinite("the position"));
    }
    if !pose.rotation.is_finite() {
        return Err(BodyError::NotFinite("the rotation"));
    }
    if !pose.rotation.is_normalized() {
        return Err(BodyError::NotUnitRotation {
            length: pose.rotation.length(),
        });
    }
    Ok(())
}

pub(crate) fn check_velocity(linear: Vec3, angular: Vec3) -> Result<(), BodyError> {
    if linear.is_finite() && angular.is_finite() {
        Ok(())
    } else {
        Err(BodyError::NotFinite("the velocity"))
    }
}
