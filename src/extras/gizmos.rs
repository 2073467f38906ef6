//! What the solver sees, as lines.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::extras::island_colors::IslandColors;
use crate::fracture::Bonds;
use crate::geometry::{Compound, ConvexHull};
use crate::joints::Joints;
use crate::math::Pose;
use crate::step::Contacts;
use bevy_app::{App, Plugin, PostUpdate};
use bevy_color::Color;
use bevy_ecs::prelude::*;
use bevy_gizmos::AppGizmoBuilder;
use bevy_gizmos::config::GizmoConfigGroup;
use bevy_gizmos::gizmos::Gizmos;
use bevy_math::{Isometry3d, Vec3};
use bevy_reflect::Reflect;
use bevy_reflect::std_traits::ReflectDefault;

/// The longest line of an impulse, m.
const LONGEST_IMPULSE: f32 = 0.5;

/// Draws hulls, islands, contacts, impulses, bonds and joints. [`CleaveGizmos`] says which, and in which colors; `GizmoConfig::enabled` of that
/// group turns all of it on and off.
///
/// Needs Bevy's `GizmoPlugin` (part of `DefaultPlugins`), and something that renders what it collects.
#[derive(Clone, Copy, Debug, Default)]
pub struct CleaveGizmosPlugin;

/// The config group of what the physics draws: a color for each kind of line, `None` for none.
#[derive(Clone, Debug, GizmoConfigGroup, PartialEq, Reflect)]
#[reflect(Default)]
pub struct CleaveGizmos {
    /// Edges of dynamic hulls that are awake.
    pub awake: Option<Color>,
    /// Gives those of each island, of bodies that touch each other, are bonded or joined, a color of its own instead.
    pub islands: bool,
    /// Edges of dynamic hulls that sleep.
    pub asleep: Option<Color>,
    /// Edges of hulls that forces do not move.
    pub fixed: Option<Color>,
    /// Crosses at points of contact.
    pub contacts: Option<Color>,
    /// Lines along the normals of contacts, as long as what they push is fast.
    pub impulses: Option<Color>,
    /// m per m/s: how long the line of an impulse is that gives the lighter of the two bodies 1 m/s.
    pub impulse_scale: f32,
    /// Lines between the centers of bonded bodies.
    pub bonds: Option<Color>,
    /// Lines from the bodies' centers to the anchors of joints, and between these.
    pub joints: Option<Color>,
    /// Size of crosses, m.
    pub cross_size: f32,
}

impl Default for CleaveGizmos {
    /// All of it, with one color for all islands.
    fn default() -> Self {
        Self {
            islands: false,
            awake: Some(Color::srgb(0.1, 0.75, 0.3)),
            asleep: Some(Color::srgb(0.45, 0.45, 0.6)),
            fixed: Some(Color::srgb(0.25, 0.25, 0.3)),
            contacts: Some(Color::srgb(1.0, 0.2, 0.1)),
            impulses: Some(Color::srgb(1.0, 0.75, 0.1)),
            impulse_scale: 0.6,
            bonds: Some(Color::srgb(0.1, 0.45, 1.0)),
            joints: Some(Color::srgb(0.85, 0.2, 0.9)),
            cross_size: 0.02,
        }
    }
}

impl Plugin for CleaveGizmosPlugin {
    fn build(&self, app: &mut App) {
        app.init_gizmo_group::<CleaveGizmos>().add_systems(
            PostUpdate,
            (draw_hulls, draw_contacts, draw_bonds, draw_joints).run_if(is_enabled),
        );
    }
}

fn is_enabled(gizmos: Gizmos<CleaveGizmos>) -> bool {
    gizmos.config.enabled
}

fn draw_hulls(
    (bodies, contacts): (Res<Bodies>, Res<Contacts>),
    (bonds, joints): (Res<Bonds>, Res<Joints>),
    mut islands: Local<IslandColors>,
    mut gizmos: Gizmos<CleaveGizmos>,
) {
    let CleaveGizmos {
        awake,
        asleep,
        fixed,
        islands: is_by_island,
        ..
    } = *gizmos.config_ext;
    if is_by_island {
        islands.find(&bodies, &contacts, &bonds, &joints);
    }
    for slot in bodies.iter() {
        let color = match (bodies.kind(slot), bodies.is_asleep(slot)) {
            (RigidBody::Dynamic, false) if is_by_island => Some(islands.color(&bodies, slot)),
            (RigidBody::Dynamic, false) => awake,
            (RigidBody::Dynamic, true) => asleep,
            _ => fixed,
        };
        let Some(color) = color else {
            continue;
        };
        let pose = bodies.pose(slot);
        let mut draw = |hull: &ConvexHull, pose: Pose| {
            for edge in hull.edges() {
                let ends = edge.vertices.map(|v| hull.vertices()[v as usize]);
                let [a, b] = ends.map(|end| pose.transform_point(end));
                gizmos.line(a, b, color);
            }
        };
        if let Some(shape) = bodies.convex(slot) {
            draw(shape.hull(), pose);
        }
        let parts = bodies.compound(slot).map_or(&[][..], Compound::parts);
        for part in parts {
            draw(part.shape.hull(), pose * part.pose);
        }
    }
}

fn draw_contacts(contacts: Res<Contacts>, bodies: Res<Bodies>, mut gizmos: Gizmos<CleaveGizmos>) {
    let group = gizmos.config_ext;
    let (crosses, lines) = (group.contacts, group.impulses);
    let (scale, size) = (group.impulse_scale, group.cross_size);
    for manifold in contacts.manifolds().iter() {
        let head = manifold.head();
        // What contacts do not move has no share in how fast they push.
        let inverse_mass = |slot: u32| match bodies.kind(slot) {
            RigidBody::Dynamic => bodies.mass(slot).inverse_mass(),
            _ => 0.0,
        };
        let lighter = inverse_mass(head.a).max(inverse_mass(head.b));
        for point in manifold.points() {
            let at = bodies.center_of_mass(head.a) + point.anchor_a;
            let length = (scale * lighter * point.normal_impulse).min(LONGEST_IMPULSE);
            if let Some(color) = lines {
                gizmos.line(at, at + length * head.normal, color);
            }
            if let Some(color) = crosses {
                gizmos.cross(Isometry3d::from_translation(at), size, color);
            }
        }
    }
}

fn draw_bonds(bonds: Res<Bonds>, bodies: Res<Bodies>, mut gizmos: Gizmos<CleaveGizmos>) {
    let Some(color) = gizmos.config_ext.bonds else {
        return;
    };
    for (ends, _) in bonds.iter() {
        let [a, b] = ends.map(|slot| bodies.center_of_mass(slot));
        gizmos.line(a, b, color);
    }
}

fn draw_joints(joints: Res<Joints>, bodies: Res<Bodies>, mut gizmos: Gizmos<CleaveGizmos>) {
    let Some(color) = gizmos.config_ext.joints else {
        return;
    };
    let size = gizmos.config_ext.cross_size;
    for id in joints.iter() {
        let (Some(joint), Some([a, b])) = (joints.get(id), joints.bodies(id)) else {
            continue;
        };
        let ends = [(a, joint.frame_a.position), (b, joint.frame_b.position)];
        let [from, to] = ends.map(|(slot, anchor): (Option<u32>, Vec3)| {
            let pose = slot.map_or(Pose::IDENTITY, |slot| bodies.pose(slot));
            let at = pose.transform_point(anchor);
            gizmos.cross(Isometry3d::from_translation(at), 2.0 * size, color);
            if let Some(slot) = slot {
                gizmos.line(bodies.center_of_mass(slot), at, color);
            }
            at
        });
        gizmos.line(from, to, color);
    }
}
