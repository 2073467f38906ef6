//! What a body is made from, as its entity has it, and what of that changed.

use crate::bodies::body::{BodyDesc, BodyError, RigidBody, Shape};
use crate::contact::body_id::BodyId;
use crate::contact::layers::CollisionLayers;
use crate::contact::material::{Density, Friction, Restitution};
use crate::contact::surface::SurfaceMaterials;
use crate::ecs::collisions::Sensor;
use crate::ecs::components::*;
use crate::ecs::forces::Mass;
use crate::ecs::parents::is_same_scale;
use crate::ecs::scaled_shapes::ScaledShapes;
use crate::geometry::{Compound, ConvexMesh, HalfSpaceShape, StaticMesh, TriMesh};
use crate::mass::{MassProperties, VolumeIntegrals};
use crate::math::Pose;
use crate::slice::fracturable::Fracturable;
use bevy_ecs::change_detection::ContiguousRef;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_math::Vec3;
use bevy_transform::components::Transform;

/// Everything a body is made from.
#[derive(QueryData)]
pub(crate) struct BodyParts {
    pub(super) child_of: Option<&'static ChildOf>,
    pub(super) kind: &'static RigidBody,
    convex: Option<&'static ConvexMesh>,
    compound: Option<&'static Compound>,
    half_space: Option<&'static HalfSpaceShape>,
    level: Option<&'static StaticMesh>,
    is_shape_awaited: Has<ShapeAwaited>,
    pub(super) transform: &'static Transform,
    pub(super) linear: &'static LinearVelocity,
    pub(super) angular: &'static AngularVelocity,
    density: &'static Density,
    mass: Option<&'static MassOverride>,
    friction: &'static Friction,
    restitution: &'static Restitution,
    surfaces: Option<&'static SurfaceMaterials>,
    layers: &'static CollisionLayers,
    sensor: Has<Sensor>,
    total_mass: Option<&'static Mass>,
    fracturable: Option<&'static Fracturable>,
}

/// The description of a body at `pose` that has this shape.
pub(super) fn describe(
    parts: &BodyPartsItem,
    pose: Pose,
    shape: Shape,
) -> Result<BodyDesc, BodyError> {
    let volume = match &shape {
        Shape::Convex(mesh) => Some(VolumeIntegrals::of_shape(mesh)),
        Shape::Compound(compound) => Some(VolumeIntegrals::of_compound(compound)),
        Shape::HalfSpace(_) | Shape::Level(_) => None,
    };
    let density = match (volume, parts.total_mass) {
        (Some(integrals), Some(&Mass(mass))) if parts.mass.is_none() => {
            let density = mass / MassProperties::from_integrals(&integrals, 1.0)?.mass;
            let is_usable = mass > 0.0 && density.is_finite();
            is_usable
                .then_some(density)
                .ok_or(BodyError::TotalMass(mass))?
        }
        _ => parts.density.0,
    };
    Ok(BodyDesc {
        kind: *parts.kind,
        shape,
        pose,
        linear_velocity: parts.linear.0,
        angular_velocity: parts.angular.0,
        density,
        mass: parts.mass.map(|m| m.0),
        friction: *parts.friction,
        restitution: *parts.restitution,
        surfaces: parts.surfaces.cloned(),
        layers: *parts.layers,
        is_sensor: parts.sensor,
        fracturable: parts.fracturable.cloned(),
    })
}

/// What came of a description, unless all that is wrong with it is that its shape is still to come.
pub(super) fn unless_awaited<T>(
    parts: Option<&BodyPartsItem>,
    found: Result<T, BodyError>,
) -> Result<Option<T>, BodyError> {
    match found {
        Err(BodyError::NoShape) if parts.is_some_and(|parts| parts.is_shape_awaited) => Ok(None),
        found => found.map(Some),
    }
}

/// The shape that an entity has, as it is before it is scaled.
pub(super) fn shape_of(parts: &BodyPartsItem) -> Result<Shape, BodyError> {
    let convex = parts.convex.map(|mesh| Shape::Convex(mesh.clone()));
    let compound = || Some(Shape::Compound(parts.compound?.clone()));
    let half_space = || Some(Shape::HalfSpace(*parts.half_space?));
    let level = || Some(Shape::Level(parts.level?.clone()));
    let shape = convex.or_else(compound).or_else(half_space);
    shape.or_else(level).ok_or(BodyError::NoShape)
}

/// The same, scaled.
pub(super) fn scaled(shape: &Shape, scale: Vec3) -> Result<Shape, BodyError> {
    if scale == Vec3::ONE {
        return Ok(shape.clone());
    }
    let refused = BodyError::Scaled(scale);
    Ok(match shape {
        Shape::Convex(mesh) => Shape::Convex(mesh.scaled(scale).map_err(|_| refused)?),
        Shape::Compound(parts) => Shape::Compound(parts.scaled(scale).map_err(|_| refused)?),
        Shape::Level(_) if scale.min_element() <= 0.0 => return Err(refused),
        Shape::Level(mesh) => Shape::Level(mesh.scaled(scale).map_err(|_| refused)?),
        Shape::HalfSpace(half_space) => Shape::HalfSpace(HalfSpaceShape {
            normal: scaled_normal(half_space.normal, scale)?,
        }),
    })
}

/// The same of the entity of a body, whose shape may be known already.
pub(super) fn scaled_anew(
    known: &mut ScaledShapes,
    body: (u32, BodyId),
    shape: Shape,
    scale: Vec3,
) -> Result<Shape, BodyError> {
    if scale == Vec3::ONE {
        known.forget(body.0);
        return Ok(shape);
    }
    // What rounding makes of a scale as parents turn is the same.
    let before = known.get(body, &shape, |before| is_same_scale(scale, before));
    before.map_or_else(
        || {
            let made = scaled(&shape, scale)?;
            known.keep(body, shape, scale, made.clone());
            Ok(made)
        },
        Ok,
    )
}

/// The normal of a plane through the origin of a frame that is scaled.
fn scaled_normal(normal: Vec3, scale: Vec3) -> Result<Vec3, BodyError> {
    let scaled = (normal / scale).normalize();
    let is_usable = scale.min_element() > 0.0 && scaled.is_finite();
    is_usable.then_some(scaled).ok_or(BodyError::Scaled(scale))
}

/// What does nothing on a body of this description.
pub(super) fn idle_part(parts: &BodyPartsItem, desc: &BodyDesc) -> Result<(), BodyError> {
    let (half_space, level) = (parts.half_space.is_some(), parts.level.is_some());
    let shapes = [
        parts.convex.is_some(),
        parts.compound.is_some(),
        half_space,
        level,
    ];
    if shapes.into_iter().filter(|&is_there| is_there).count() > 1 {
        return Err(BodyError::SeveralShapes);
    }
    if desc.surfaces.is_some() && !desc.shape.level().is_some_and(StaticMesh::has_materials) {
        return Err(BodyError::IdleSurfaces);
    }
    let Some(fracturable) = &desc.fracturable else {
        return Ok(());
    };
    let check = |visual: Option<&TriMesh>| {
        let closed = visual.map_or(Ok(()), TriMesh::check_closed);
        closed.map_err(BodyError::UnbreakableVisual)
    };
    match &desc.shape {
        Shape::Convex(mesh) => check(mesh.visual())?,
        Shape::Compound(compound) => {
            let mut parts = compound.parts().iter();
            parts.try_for_each(|part| check(part.shape.visual()))?;
        }
        Shape::HalfSpace(_) | Shape::Level(_) => return Err(BodyError::UnbreakableShape),
    }
    if desc.is_sensor {
        return Err(BodyError::UnbreakableShape);
    }
    fracturable
        .makes_pieces()
        .then_some(())
        .ok_or(BodyError::NoPieces)
}

/// What of a body's description changed.
pub(super) type Changes = Or<(
    Changed<ConvexMesh>,
    Changed<Compound>,
    Changed<HalfSpaceShape>,
    Changed<StaticMesh>,
    Changed<Density>,
    Changed<MassOverride>,
    Changed<Friction>,
    Changed<Restitution>,
    Changed<SurfaceMaterials>,
    Changed<CollisionLayers>,
    Changed<Fracturable>,
    Changed<Sensor>,
    Changed<Mass>,
)>;

/// The same components, table by table.
pub(super) type ChangeTicks = (
    (
        Option<Ref<'static, ConvexMesh>>,
        Option<Ref<'static, Compound>>,
        Option<Ref<'static, HalfSpaceShape>>,
        Option<Ref<'static, StaticMesh>>,
        Option<Ref<'static, Density>>,
        Option<Ref<'static, MassOverride>>,
        Option<Ref<'static, Mass>>,
    ),
    (
        Option<Ref<'static, Friction>>,
        Option<Ref<'static, Restitution>>,
        Option<Ref<'static, SurfaceMaterials>>,
        Option<Ref<'static, CollisionLayers>>,
        Option<Ref<'static, Fracturable>>,
        Option<Ref<'static, Sensor>>,
    ),
);

/// Whether any value of a column may have changed.
pub(super) fn any_changed<T>(column: Option<ContiguousRef<T>>) -> bool {
    column.is_some_and(|column| {
        let (_, ticks) = ContiguousRef::split(column);
        // All of these components ask for such a note.
        ticks.summary_tick_is_changed().unwrap_or(true)
    })
}

/// Whether any description may have changed: a look at what tables have noted of all their entities together.
pub(super) fn has_any_changed(ticks: &Query<ChangeTicks, With<BodyHandle>>) -> bool {
    use any_changed as any;
    let Ok(mut tables) = ticks.contiguous_iter() else {
        return true;
    };
    tables.any(|((a, b, c, d, e, f, l), (g, h, m, i, j, k))| {
        any(a)
            || any(b)
            || any(c)
            || any(d)
            || any(e)
            || any(f)
            || any(g)
            || any(h)
            || any(i)
            || any(j)
            || any(k)
            || any(l)
            || any(m)
    })
}
