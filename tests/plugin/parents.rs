//! Bodies beneath parents that come, go, move and are scaled: a body is where its `Transform`s say, and as large.

use crate::app::app;
use crate::common::dice::Dice;
use crate::hierarchy::{local_beneath, world_of};
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_math::{Affine3A, Quat, Vec3};
use bevy_transform::components::Transform;

/// Nodes and bodies of all kinds that rest without weight and do not touch, some beneath others.
struct Scene {
    app: App,
    dice: Dice,
    /// First the nodes, then the bodies.
    entities: Vec<Entity>,
    nodes: usize,
}

impl Scene {
    fn new(seed: u64) -> Self {
        let mut app = app();
        app.insert_resource(Gravity(Vec3::ZERO));
        let mut dice = Dice::new(seed);
        let nodes = 4;
        let mut entities = Vec::new();
        for i in 0..nodes + 9 {
            let place = Self::place(&mut dice);
            let mut entity = app.world_mut().spawn(place);
            let kinds = [RigidBody::Dynamic, RigidBody::Kinematic, RigidBody::Static];
            if i >= nodes {
                let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a cube");
                let apart = CollisionLayers {
                    memberships: 1,
                    filters: 0,
                };
                entity.insert((kinds[i % 3], cube, apart));
            }
            entities.push(entity.id());
        }
        Self {
            app,
            dice,
            entities,
            nodes,
        }
    }

    fn place(dice: &mut Dice) -> Transform {
        let scale = [1.0, 1.0, dice.in_range(0.5, 2.0)][dice.below(3)];
        Transform::from_translation(dice.vector(-5.0, 5.0))
            .with_rotation(dice.rotation())
            .with_scale(Vec3::splat(scale))
    }

    fn kind(&self, entity: Entity) -> Option<RigidBody> {
        self.app.world().get::<RigidBody>(entity).copied()
    }

    /// Whether one is above the other.
    fn is_above(&self, above: Entity, entity: Entity) -> bool {
        let world = self.app.world();
        let up = |&entity: &Entity| world.get::<ChildOf>(entity).map(ChildOf::parent);
        std::iter::successors(Some(entity), up).any(|it| it == above)
    }

    /// Does something to one entity.
    fn act(&mut self) -> (Entity, String) {
        let entity = self.entities[self.dice.below(self.entities.len())];
        let parent = self.entities[self.dice.below(self.entities.len())];
        let stays = self.dice.below(2) == 0;
        let what = self.dice.below(7);
        let place = Self::place(&mut self.dice);
        let before = world_of(self.app.world(), entity);
        let is_loop = self.is_above(entity, parent);
        let mut it = self.app.world_mut().entity_mut(entity);
        match what {
            0 | 1 if !is_loop => drop(it.insert(ChildOf(parent))),
            2 | 3 => drop(it.remove::<ChildOf>()),
            4 => drop(it.insert(Disabled)),
            5 => drop(it.remove::<Disabled>()),
            _ => drop(it.insert(place)),
        }
        if stays && what < 4 {
            let world = self.app.world();
            let above = world.get::<ChildOf>(entity).map(ChildOf::parent);
            let local = local_beneath(world, above, before);
            self.app.world_mut().entity_mut(entity).insert(local);
        }
        (entity, format!("{what} {entity} {parent} {stays}"))
    }

    fn is_enabled(&self, entity: Entity) -> bool {
        !self.app.world().entity(entity).contains::<Disabled>()
    }

    /// Where all entities are.
    fn places(&self) -> Vec<Place> {
        let entities = self.entities.iter();
        let place = |&entity: &Entity| Place {
            world: world_of(self.app.world(), entity),
            is_enabled: self.is_enabled(entity),
        };
        entities.map(place).collect()
    }

    /// Where an entity is to be after a step, when something was done to the one that is named: a dynamic body goes its own way
    /// when what is above it moves, and takes along what is below it. Nothing is asked of what was disabled or beneath that.
    fn expected(&self, entity: Entity, acted: Entity, before: &[Place]) -> Option<Affine3A> {
        let world = self.app.world();
        let own = world.get::<Transform>(entity).copied();
        let own = own.expect("all have one").compute_affine();
        let Some(child_of) = world.get::<ChildOf>(entity) else {
            return Some(own);
        };
        let world = self.expected(child_of.parent(), acted, before)? * own;
        let at = self.entities.iter().position(|&it| it == entity);
        let before = before[at.expect("one of them")];
        if self.kind(entity) != Some(RigidBody::Dynamic) || entity == acted && before.is_enabled {
            return Some(world);
        }
        let (scale, ..) = world.to_scale_rotation_translation();
        let (_, turn, at) = before.world.to_scale_rotation_translation();
        let stays = Affine3A::from_scale_rotation_translation(scale, turn, at);
        (before.is_enabled && self.is_enabled(entity)).then_some(stays)
    }
}

/// Where an entity is.
#[derive(Clone, Copy)]
struct Place {
    world: Affine3A,
    is_enabled: bool,
}

fn check(scene: &Scene, expected: &[Option<Affine3A>], story: &[String]) {
    let world = scene.app.world();
    let bodies = world.resource::<Bodies>();
    for (&entity, expected) in scene.entities[scene.nodes..].iter().zip(expected) {
        let Some(expected) = expected else {
            continue;
        };
        let about = || format!("{entity} {:?}: {story:?}", scene.kind(entity));
        assert!(world.get::<BodyIssues>(entity).is_none(), "{}", about());
        let handle = world.get::<BodyHandle>(entity).expect("a body");
        let (slot, _) = handle.get().expect("a body");
        let (scale, rotation, translation) = expected.to_scale_rotation_translation();
        let drawn = world_of(world, entity).to_scale_rotation_translation();
        let pose = bodies.pose(slot);
        for (at, turn) in [(pose.position, pose.rotation), (drawn.2, drawn.1)] {
            let off = at.distance(translation);
            assert!(off < 1e-2, "{at} for {translation}: {}", about());
            let turn = turn.angle_between(rotation);
            assert!(turn < 1e-2, "{turn} rad: {}", about());
        }
        let volume = scale.element_product();
        let found = bodies.mass(slot).mass / 1000.0;
        let is_sized =
            bodies.kind(slot) != RigidBody::Dynamic || (found - volume).abs() < 1e-2 * volume;
        assert!(is_sized, "{found} m3 for {volume}: {}", about());
    }
}

// What lost its parent stayed where it was, and was drawn elsewhere if it was static; what got one stayed if something that had been
// in its slot had had the same `Transform`; a dynamic body did not become as large as its parent made it.
#[test]
fn bodies_are_where_their_transforms_say_whoever_their_parents_are() {
    for seed in 0..12 {
        let mut scene = Scene::new(seed);
        scene.app.update();
        let mut story = Vec::new();
        for _ in 0..60 {
            let before = scene.places();
            let (entity, deed) = scene.act();
            story.push(deed);
            let bodies = scene.entities[scene.nodes..].iter();
            let expected: Vec<_> = bodies
                .map(|&body| {
                    let is_enabled = scene.is_enabled(body);
                    let expected = scene.expected(body, entity, &before);
                    expected.filter(|_| is_enabled)
                })
                .collect();
            scene.app.update();
            check(&scene, &expected, &story);
        }
    }
}

// It was drawn askew, or lost its contacts in every step.
#[test]
fn a_body_that_turns_is_refused_beneath_a_parent_with_unequal_scales() {
    let mut app = app();
    let skewed = Transform::from_scale(Vec3::new(1.0, 3.0, 1.0));
    let parent = app.world_mut().spawn(skewed).id();
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a cube");
    let child = (cube, ChildOf(parent), Transform::IDENTITY);
    let dynamic = (RigidBody::Dynamic, child.clone());
    let dynamic = app.world_mut().spawn(dynamic).id();
    let fixed = app.world_mut().spawn((RigidBody::Static, child)).id();
    (0..3).for_each(|_| app.update());
    let sheared = BodyProblem::Body(BodyError::Sheared);
    let issues = |app: &App, entity| {
        let issues = app.world().get::<BodyIssues>(entity).cloned();
        issues.is_some_and(|issues| issues.iter().any(|it| *it == sheared))
    };
    assert!(issues(&app, dynamic));
    assert!(!issues(&app, fixed));
    let even = Transform::from_scale(Vec3::splat(2.0));
    app.world_mut().entity_mut(parent).insert(even);
    (0..3).for_each(|_| app.update());
    assert!(!issues(&app, dynamic));
    let turned = Quat::from_rotation_y(0.3);
    app.world_mut()
        .get_mut::<Transform>(parent)
        .expect("it has one")
        .rotation = turned;
    app.update();
    assert!(!issues(&app, dynamic));
}
