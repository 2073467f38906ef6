//! Whatever is done to entities in whatever order: nothing panics, entities and bodies know each other, nothing of what breaks
//! is lost, and a body that touches nobody does not notice.

use crate::app::{accompanied_app, app, bits_of_entity};
use crate::common::dice::Dice;
use crate::common::mesh_parts::{cuboid, joined};
use crate::common::properties::cases;
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::components::Transform;
use glam::{Quat, Vec3};
use proptest::prelude::*;
use std::collections::HashSet;

const STEPS: usize = 240;

/// Entities that are spawned at most; pieces come on top.
const MAX_SPAWNED: usize = 40;

/// Relative mass that a fracture may lose or gain.
const MASS_TOLERANCE: f64 = 1e-6;

/// Relative momentum that it may.
const MOMENTUM_TOLERANCE: f64 = 1e-5;

/// An app, what is done to it, and who is in it.
struct Chaos {
    app: App,
    dice: Dice,
    /// All entities that ever were, in the order in which they came: commands may name those that are gone.
    entities: Vec<Entity>,
    spawned: usize,
    /// A cube that falls on a floor of its own and touches nothing else.
    bystander: Entity,
}

/// A number that a body can have, or, as often, one that it cannot.
fn number(dice: &mut Dice) -> f32 {
    let numbers = [f32::NAN, f32::INFINITY, -1.0, 0.0, 1e30, 1e-30];
    match numbers.get(dice.below(2 * numbers.len())) {
        Some(&number) => number,
        None => dice.in_range(0.0, 2.0),
    }
}

/// Mostly usable numbers.
fn vector(dice: &mut Dice, size: f32) -> Vec3 {
    let mut vector = dice.vector(-size, size);
    if dice.below(15) == 0 {
        vector[dice.below(3)] = number(dice);
    }
    vector
}

fn place(dice: &mut Dice) -> Vec3 {
    dice.vector(-2.0, 2.0) + 2.5 * Vec3::Y
}

fn plane(dice: &mut Dice) -> Plane {
    match dice.below(10) {
        0 => Plane::through(vector(dice, 1.0), Vec3::ZERO),
        1 => Plane {
            normal: vector(dice, 1e20),
            offset: number(dice),
        },
        _ => Plane::through(place(dice), dice.direction()),
    }
}

/// A box with a cavity, and one or two others that may reach into it and into each other.
fn boxes(dice: &mut Dice) -> TriMesh {
    let half = Vec3::splat(0.5);
    let hollow = [
        (cuboid(Vec3::ONE, Vec3::ZERO), false),
        (cuboid(half, dice.vector(-0.2, 0.2)), true),
    ];
    let others = [(); 2].map(|()| (cuboid(half, dice.vector(-1.0, 1.0)), false));
    let count = 1 + dice.below(2);
    joined(&[&hollow[..], &others[..count]].concat())
}

fn shape(dice: &mut Dice) -> ConvexMesh {
    let size = dice.vector(0.1, 1.0);
    let mesh = match dice.below(5) {
        0 => ConvexMesh::cuboid(size.x, size.y, size.z),
        1 => ConvexMesh::cuboid(1.0, 0.002, 1.0),
        2 => ConvexMesh::cuboid(0.01, 0.01, 0.01),
        3 => ConvexMesh::from_mesh(boxes(dice)),
        _ => {
            let points: Vec<Vec3> = (0..12).map(|_| 0.5 * dice.direction()).collect();
            ConvexMesh::from_points(&points)
        }
    };
    mesh.expect("these have a volume")
}

fn pattern(dice: &mut Dice) -> FracturePattern {
    match dice.below(8) {
        0 => FracturePattern::SinglePlane,
        1 => FracturePattern::RandomPlane,
        2 => FracturePattern::Star { planes: 3 },
        3 => FracturePattern::Radial { rays: 5, rings: 2 },
        4 => FracturePattern::Voronoi {
            cells: 6,
            focus: number(dice),
        },
        5 => FracturePattern::Slabs { count: 4 },
        6 => FracturePattern::Brick {
            size: Vec3::splat(number(dice)),
        },
        _ => FracturePattern::Planes([plane(dice)].into()),
    }
}

fn fracturable(dice: &mut Dice) -> Fracturable {
    let strength = [0.0, 1.0, 30.0, number(dice)][dice.below(4)];
    let toughness = [0.0, 0.0, number(dice)][dice.below(3)];
    Fracturable {
        separate_parts: dice.below(3) == 0,
        cut_material: [None, Some(3)][dice.below(2)],
        generations: [0, 1, 3][dice.below(3)],
        ..Fracturable::with_strength(strength)
            .with_pattern(pattern(dice))
            .with_toughness(toughness, 8)
    }
}

fn budget(dice: &mut Dice) -> FractureBudget {
    FractureBudget {
        pieces_per_step: [3, 20, 64][dice.below(3)],
        max_alive_pieces: [50, 20_000][dice.below(2)],
        debris: DebrisRules {
            max_sleep: [0.1, f32::INFINITY][dice.below(2)],
            max_pieces: [20, usize::MAX][dice.below(2)],
            fade: [0.0, 0.2][dice.below(2)],
            ..Default::default()
        },
        ..FractureBudget::default()
    }
}

impl Chaos {
    fn new(mut app: App, seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        let world = app.world_mut();
        let mut config = world.resource_mut::<SolverConfig>();
        config.sleep = [SleepConfig::default(), SleepConfig::off()][dice.below(2)];
        config.measure_error = dice.below(2) == 0;
        world.insert_resource(budget(&mut dice));
        let floor = ConvexMesh::cuboid(20.0, 1.0, 20.0).expect("valid size");
        let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
        let far = Transform::from_xyz(300.0, 0.0, 0.0);
        // A body of 1e30 kg/m3 throws others that far in a step.
        let apart = CollisionLayers {
            memberships: 2,
            filters: 2,
        };
        world.spawn((RigidBody::Static, floor.clone(), far, apart));
        let above = Transform::from_xyz(300.0, 3.0, 0.0).with_rotation(Quat::from_rotation_z(0.3));
        let bystander = world.spawn((RigidBody::Dynamic, cube, above, apart)).id();
        let floor = world.spawn((RigidBody::Static, floor, Transform::default()));
        let entities = vec![floor.id()];
        Self {
            app,
            dice,
            entities,
            spawned: 0,
            bystander,
        }
    }

    /// Any of all that ever were, mostly one of the last.
    fn any(&mut self) -> Entity {
        let count = self.entities.len();
        let from = [0, count.saturating_sub(12)][self.dice.below(3).min(1)];
        self.entities[from + self.dice.below(count - from)]
    }

    /// Does something to somebody.
    fn act(&mut self) {
        let (a, b) = (self.any(), self.any());
        let dice = &mut self.dice;
        let mut commands = self.app.world_mut().commands();
        match dice.below(9) {
            0 => self.spawn(),
            1 => commands.slice(a, plane(dice)),
            2 => match dice.below(4) {
                0 => commands.bond(a, b, Bond::new(number(dice), number(dice))),
                1 => commands.bond(a, b, Bond::new(1e4, 0.1)),
                2 => commands.bond_neighbors([a, b], 1e4),
                _ => commands.unbond(a, b),
            },
            3 => self.copy(b),
            _ => {
                if let Ok(mut entity) = self.app.world_mut().get_entity_mut(a) {
                    change(&mut entity, dice);
                }
            }
        }
        self.app.world_mut().flush();
    }

    fn spawn(&mut self) {
        if self.spawned == MAX_SPAWNED {
            return;
        }
        self.spawned += 1;
        let dice = &mut self.dice;
        let transform = Transform::from_translation(place(dice)).with_rotation(dice.rotation());
        let kind = [RigidBody::Dynamic, RigidBody::Kinematic][dice.below(4) / 3];
        let velocity = LinearVelocity(vector(dice, 20.0));
        let mut entity = self.app.world_mut().spawn((kind, transform, velocity));
        if dice.below(20) != 0 {
            entity.insert(shape(dice));
        }
        if dice.below(2) == 0 {
            entity.insert(fracturable(dice));
        }
        self.entities.push(entity.id());
    }

    fn copy(&mut self, entity: Entity) {
        let world = self.app.world_mut();
        if self.spawned < MAX_SPAWNED && world.get_entity(entity).is_ok() {
            self.spawned += 1;
            let copy = world.entity_mut(entity).clone_and_spawn();
            self.entities.push(copy);
        }
    }

    /// Makes a step and looks what has become of everything.
    fn update(&mut self) {
        self.app.update();
        let messages = self.app.world().resource::<Messages<Fractured>>();
        for fractured in messages.iter_current_update_messages() {
            let ledger = &fractured.ledger;
            let error = ledger.mass_error();
            assert!(error <= MASS_TOLERANCE, "{error:e}: {fractured:?}");
            let error = ledger.momentum_error();
            assert!(error <= MOMENTUM_TOLERANCE, "{error:e}: {fractured:?}");
            self.entities.extend(&fractured.pieces);
        }
        self.check_bodies();
    }

    /// Each body has one entity that knows it, and a pose; what is drawn of it is closed.
    fn check_bodies(&mut self) {
        let world = self.app.world_mut();
        let mut query = world.query::<(Entity, &BodyHandle, &RigidBody, Has<Sleeping>)>();
        let bodies = world.resource::<Bodies>();
        let mut known = HashSet::new();
        for (entity, handle, kind, sleeps) in query.iter(world) {
            let Some((slot, id)) = handle.get() else {
                continue;
            };
            assert!(
                bodies.is_current(slot, id) && known.insert(slot),
                "{entity}"
            );
            let (v, omega) = bodies.velocity(slot);
            let Pose { position, rotation } = bodies.pose(slot);
            let is_finite = v.is_finite() && omega.is_finite() && position.is_finite();
            assert!(is_finite, "{entity}: {v} {omega} {position}");
            assert!(
                (rotation.length() - 1.0).abs() < 1e-3,
                "{entity}: {rotation}"
            );
            assert_eq!(sleeps, bodies.is_asleep(slot), "{entity}");
            if bodies.is_active(slot) {
                assert_eq!(*kind, bodies.kind(slot), "{entity}");
            }
            let visual = bodies.convex(slot).and_then(ConvexMesh::visual);
            let visual = visual.filter(|mesh| !mesh.triangles().is_empty());
            assert!(visual.is_none_or(TriMesh::is_closed), "{entity}");
        }
        assert_eq!(known.len(), bodies.len(), "bodies without entities");
    }

    /// Motion of all that there is, as bits.
    fn bits(&self) -> Vec<Vec<u32>> {
        let world = self.app.world();
        let is_whole = |&&entity: &&Entity| {
            let motion = (
                world.get::<Transform>(entity),
                world.get::<LinearVelocity>(entity),
                world.get::<AngularVelocity>(entity),
            );
            matches!(motion, (Some(_), Some(_), Some(_)))
        };
        let whole = self.entities.iter().filter(is_whole);
        whole.map(|&entity| bits_of_entity(world, entity)).collect()
    }

    fn place_of_bystander(&self) -> Vec3 {
        let transform = self.app.world().get::<Transform>(self.bystander);
        transform.expect("nothing is done to it").translation
    }
}

/// Changes a component, or takes some away.
fn change(entity: &mut EntityWorldMut<'_>, dice: &mut Dice) {
    let at = |place: Vec3| Transform::from_translation(place);
    match dice.below(24) {
        0 => entity.insert(Friction::new(number(dice))),
        1 => entity.insert(Restitution::new(number(dice))),
        2 => entity.insert(Density(number(dice))),
        3 => entity.insert(at(place(dice))),
        4 => entity.insert(at(vector(dice, 3.0))),
        5 => entity.insert(at(place(dice)).with_scale(Vec3::splat(number(dice)))),
        6 => entity.insert(LinearVelocity(vector(dice, 30.0))),
        7 => entity.insert(AngularVelocity(vector(dice, 30.0))),
        8 => entity.insert(RigidBody::Static),
        9 => entity.insert(RigidBody::Kinematic),
        10 | 11 => entity.insert(RigidBody::Dynamic),
        12 => entity.remove::<RigidBody>(),
        13 => entity.remove::<ConvexMesh>(),
        14 | 15 => entity.insert(shape(dice)),
        16 => entity.insert(fracturable(dice)),
        17 => entity.remove::<Fracturable>(),
        18 => entity.insert(Sleeping),
        19 => entity.remove::<Sleeping>(),
        20 => entity.remove::<(Transform, Density)>(),
        21 => entity.insert(HalfSpaceShape { normal: Vec3::NAN }),
        22 => entity.insert(MassOverride(MassProperties::default())),
        _ => match dice.below(4) {
            0 => entity.clear(),
            _ => entity.remove::<(HalfSpaceShape, MassOverride)>(),
        },
    };
}

proptest! {
    #![proptest_config(cases(4))]

    #[test]
    fn nothing_that_is_done_to_entities_does_harm(seed: u64) {
        let mut calm = Chaos::new(app(), seed);
        let mut runs = [app(), accompanied_app()].map(|app| Chaos::new(app, seed));
        for step in 0..STEPS {
            calm.update();
            for run in &mut runs {
                (0..run.dice.below(4)).for_each(|_| run.act());
                run.update();
                // What shares a batch is solved as precisely as its neediest member, so that it may land otherwise.
                let [place, alone] = [&*run, &calm].map(Chaos::place_of_bystander);
                prop_assert!(place.distance(alone) < 0.01, "step {}: {} {}", step, place, alone);
            }
            let [alone, accompanied] = runs.each_ref().map(Chaos::bits);
            prop_assert!(alone == accompanied, "step {}", step);
        }
    }
}
