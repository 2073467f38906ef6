//! A stage for characters: an app of any size, turn and step length, in which places are told in units of that size.
#![expect(
    clippy::disallowed_methods,
    reason = "sizes of scenes may differ between platforms"
)]

use crate::common::dice::Dice;
use bevy_app::{App, TaskPoolPlugin};
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use glam::{Quat, Vec2, Vec3};
use std::time::Duration;

/// Radius of a capsule that walks, and the length of the segment within it, units.
pub(crate) const RADIUS: f32 = 0.3;
pub(crate) const LENGTH: f32 = 1.0;
/// Height of its frame over level ground.
pub(crate) const STANDING: f32 = RADIUS + 0.5 * LENGTH;
/// Gap that it keeps.
pub(crate) const SKIN: f32 = 0.01;

/// An app, and where its course lies in the world.
pub(crate) struct Stage {
    pub(crate) app: App,
    /// From the course to the world, without the size.
    pub(crate) world: Pose,
    /// m.
    pub(crate) unit: f32,
    pub(crate) step_dt: f32,
    /// What walks: a capsule mostly.
    form: usize,
}

impl Stage {
    /// Along the axes of the world, in metres.
    pub(crate) fn plain(hertz: f64) -> Self {
        let step = Duration::from_secs_f64(1.0 / hertz);
        let mut app = App::new();
        app.add_plugins((
            TaskPoolPlugin::default(),
            TimePlugin,
            CleavePlugin::default(),
            WalkerPlugin,
        ))
        .insert_resource(Time::<Fixed>::from_duration(step))
        .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
        app.finish();
        app.cleanup();
        app.update();
        Self {
            app,
            world: Pose::IDENTITY,
            unit: 1.0,
            step_dt: step.as_secs_f32(),
            form: 2,
        }
    }

    /// Of some size from a tenth to ten times, somewhere, turned somehow.
    pub(crate) fn any(dice: &mut Dice) -> Self {
        let hertz = [30.0, 60.0, 60.0, 64.0, 120.0, 240.0][dice.below(6)];
        let unit = [1.0, 1.0, 10.0_f32.powf(dice.in_range(-1.0, 1.0))][dice.below(3)];
        let world = match dice.below(3) {
            0 => Pose::IDENTITY,
            1 => Pose::new(unit * dice.vector(-50.0, 50.0), Quat::IDENTITY),
            _ => Pose::new(unit * dice.vector(-10.0, 10.0), dice.rotation()),
        };
        let form = dice.below(8);
        Self {
            form,
            ..Self::plain(hertz).moved_to(world, unit)
        }
    }

    pub(crate) fn moved_to(mut self, world: Pose, unit: f32) -> Self {
        (self.world, self.unit) = (world, unit);
        let down = world.rotation * Vec3::NEG_Y;
        self.app.insert_resource(Gravity(9.81 * unit * down));
        self
    }

    pub(crate) fn settings(&self) -> WalkSettings {
        WalkSettings {
            up: self.world.rotation * Vec3::Y,
            step_height: 0.3 * self.unit,
            skin: SKIN * self.unit,
            ..WalkSettings::default()
        }
    }

    pub(crate) fn transform(&self, at: Pose) -> Transform {
        let pose = self.world * Pose::new(self.unit * at.position, at.rotation);
        Transform::from_translation(pose.position).with_rotation(pose.rotation)
    }

    /// A direction or a velocity of the course, in the world.
    pub(crate) fn vector(&self, v: Vec3) -> Vec3 {
        self.unit * (self.world.rotation * v)
    }

    pub(crate) fn box_shape(&self, size: Vec3) -> ConvexMesh {
        let size = self.unit * size;
        ConvexMesh::cuboid(size.x, size.y, size.z).expect("a box")
    }

    pub(crate) fn add(&mut self, kind: RigidBody, shape: impl Bundle, at: Pose) -> Entity {
        let at = self.transform(at);
        self.app.world_mut().spawn((kind, shape, at)).id()
    }

    pub(crate) fn add_box(&mut self, kind: RigidBody, size: Vec3, at: Pose) -> Entity {
        let shape = self.box_shape(size);
        self.add(kind, shape, at)
    }

    /// A static box that is not turned.
    pub(crate) fn block(&mut self, size: Vec3, at: Vec3) -> Entity {
        self.add_box(RigidBody::Static, size, Pose::from_position(at))
    }

    pub(crate) fn add_floor(&mut self) -> Entity {
        self.block(Vec3::new(80.0, 1.0, 80.0), -0.5 * Vec3::Y)
    }

    /// A level of triangles, with corners in units.
    pub(crate) fn add_level(
        &mut self,
        corners: &[Vec3],
        triangles: &[[u32; 3]],
        two: bool,
    ) -> Entity {
        let corners: Vec<Vec3> = corners.iter().map(|at| self.unit * *at).collect();
        let mesh = StaticMesh::new(&corners, triangles).expect("a level");
        let mesh = if two { mesh.two_sided() } else { mesh };
        self.add(RigidBody::Static, mesh, Pose::IDENTITY)
    }

    /// What a character is made of.
    fn form(&self) -> ConvexMesh {
        let (radius, length) = (RADIUS * self.unit, LENGTH * self.unit);
        let high = length + 2.0 * radius;
        match self.form {
            0 => ConvexMesh::cylinder(radius, high),
            1 => ConvexMesh::cuboid(2.0 * radius, high, 2.0 * radius),
            _ => ConvexMesh::capsule(radius, length),
        }
        .expect("usable")
    }

    /// A character, upright.
    pub(crate) fn add_walker(&mut self, at: Vec3) -> Entity {
        let shape = self.form();
        let walker = Walker {
            settings: self.settings(),
            ..Walker::default()
        };
        self.add(
            RigidBody::Kinematic,
            (shape, walker),
            Pose::from_position(at),
        )
    }

    pub(crate) fn step(&mut self) {
        self.app.update();
    }

    /// Steps for so many seconds.
    pub(crate) fn run(&mut self, secs: f32) {
        (0..self.steps(secs)).for_each(|_| self.step());
    }

    pub(crate) fn steps(&self, secs: f32) -> usize {
        (secs / self.step_dt).round() as usize
    }

    pub(crate) fn transform_of(&self, entity: Entity) -> Transform {
        *self.get::<Transform>(entity)
    }

    pub(crate) fn get<C: Component>(&self, entity: Entity) -> &C {
        self.app.world().get::<C>(entity).expect("there")
    }

    /// Where an entity is on the course.
    pub(crate) fn place(&self, entity: Entity) -> Vec3 {
        let at = self.transform_of(entity).translation;
        self.world.inverse_transform_point(at) / self.unit
    }

    /// A place on an entity's body, as the body sees it, units.
    pub(crate) fn seen_from(&self, entity: Entity, at: Vec3) -> Vec3 {
        let of = self.transform_of(entity);
        (of.rotation.inverse() * (at - of.translation)) / self.unit
    }

    pub(crate) fn wish(&mut self, walker: Entity, wish: Vec2) {
        let velocity = self.vector(Vec3::new(wish.x, 0.0, wish.y));
        self.walker(walker).velocity = velocity;
    }

    pub(crate) fn walker(&mut self, walker: Entity) -> Mut<'_, Walker> {
        let walker = self.app.world_mut().get_mut::<Walker>(walker);
        walker.expect("it walks")
    }

    pub(crate) fn set_velocity(&mut self, entity: Entity, linear: Vec3, angular: Vec3) {
        let linear = LinearVelocity(self.vector(linear));
        let angular = AngularVelocity(self.world.rotation * angular);
        (self.app.world_mut().entity_mut(entity)).insert((linear, angular));
    }

    pub(crate) fn is_on_ground(&self, walker: Entity) -> bool {
        self.get::<Walking>(walker).is_on_ground()
    }

    /// How far a walker is from what counts, units; negative inside.
    pub(crate) fn gap_to(&self, walker: Entity, counts: &dyn Fn(u32, RigidBody) -> bool) -> f32 {
        let world = self.app.world();
        let bodies = world.resource::<Bodies>();
        let queries = world.resource::<QueryIndex>().queries(bodies);
        let slot_of = |entity| world.get::<BodyHandle>(entity)?.get();
        let own = slot_of(walker).map(|(slot, _)| slot);
        let is_asked = |slot: u32| Some(slot) != own && counts(slot, bodies.kind(slot));
        let filter = QueryFilter::all().with_predicate(&is_asked);
        let at = self.transform_of(walker);
        let shape = self.get::<ConvexMesh>(walker);
        let mut near = Vec::new();
        let pose = Pose::new(at.translation, at.rotation);
        (queries.near_shape(&shape.into(), &pose, self.unit, &filter, &mut near)).expect("usable");
        near.first()
            .map_or(f32::INFINITY, |hit| hit.distance / self.unit)
    }

    /// How far it is from what does not move by itself.
    pub(crate) fn gap(&self, walker: Entity) -> f32 {
        self.gap_to(walker, &|_, kind| kind != RigidBody::Dynamic)
    }
}

/// Not turned.
pub(crate) fn flat(at: Vec3) -> Pose {
    Pose::from_position(at)
}

/// What a law says of a member.
pub(crate) type Verdict = Result<(), String>;

/// A law that is broken.
macro_rules! hold {
    ($is:expr, $($why:tt)*) => {
        let holds: bool = $is;
        if !holds {
            return Err(format!($($why)*));
        }
    };
}
pub(crate) use hold;

/// Judges members of a law, from the first seed on.
pub(crate) fn check(law: fn(u64) -> Verdict, members: u64) {
    let judge = |seed| law(seed).err().map(|why| format!("{seed}: {why}"));
    let broken: Vec<String> = (0..members).filter_map(judge).collect();
    assert!(
        broken.is_empty(),
        "{} of {members}:\n{}",
        broken.len(),
        broken.join("\n")
    );
}

pub(crate) fn heading(angle: f32) -> Vec2 {
    Vec2::new(angle.cos(), angle.sin())
}

/// Ground at height 0 around the origin, of some kind: a half-space, boxes, triangles of any cut.
pub(crate) fn add_ground(stage: &mut Stage, dice: &mut Dice) {
    match dice.below(5) {
        0 => {
            let normal = stage.world.rotation * Vec3::Y;
            stage.add(
                RigidBody::Static,
                HalfSpaceShape { normal },
                Pose::new(Vec3::ZERO, stage.world.rotation.inverse()),
            );
        }
        1 => {
            stage.add_floor();
        }
        2 => {
            // Slabs side by side.
            for i in -8..8 {
                let width = 5.0;
                let at = Vec3::new((i as f32 + 0.5) * width, -0.5, 0.0);
                stage.block(Vec3::new(width, 1.0, 80.0), at);
            }
        }
        _ => {
            let (corners, triangles) = flat_triangles(dice);
            stage.add_level(&corners, &triangles, dice.below(2) == 0);
        }
    }
}

/// Level triangles: rows of different cuts, so that edges end in the middle of others, with thin ones among them.
pub(crate) fn flat_triangles(dice: &mut Dice) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    let mut z = -40.0_f32;
    while z < 40.0 {
        let depth = [0.02, 0.7, 3.0, 10.0][dice.below(4)] * dice.in_range(0.5, 1.5);
        let mut x = -40.0_f32;
        while x < 40.0 {
            let width = [0.05, 0.5, 4.0, 20.0][dice.below(4)] * dice.in_range(0.5, 1.5);
            let first = corners.len() as u32;
            for (dx, dz) in [(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)] {
                corners.push(Vec3::new(x + dx, 0.0, z + dz));
            }
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| first + i);
            triangles.extend(match dice.below(2) {
                0 => [[a, c, b], [a, d, c]],
                _ => [[a, d, b], [b, d, c]],
            });
            x += width;
        }
        z += depth;
    }
    (corners, triangles)
}
