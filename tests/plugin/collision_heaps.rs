//! Who touches whom in heaps that fall asleep and are disturbed: what is told in events and what can be looked at are one story.

use crate::app::app;
use crate::common::dice::Dice;
use bevy_app::App;
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_math::Vec3;
use bevy_transform::components::Transform;
use std::collections::BTreeSet;

type Pair = (Entity, Entity);

fn pair(a: Entity, b: Entity) -> Pair {
    (a.min(b), a.max(b))
}

/// What one step told, and what touches after it.
#[derive(Resource, Default)]
struct Told {
    starts: Vec<Pair>,
    ends: Vec<Pair>,
    listed: Vec<Pair>,
    /// By entity events, in the same order of the two.
    own_starts: Vec<Pair>,
    own_ends: Vec<Pair>,
}

fn listen(
    mut told: ResMut<Told>,
    mut starts: MessageReader<CollisionStart>,
    mut ends: MessageReader<CollisionEnd>,
    collisions: Collisions,
) {
    told.starts
        .extend(starts.read().map(|it| pair(it.entity, it.other)));
    told.ends
        .extend(ends.read().map(|it| pair(it.entity, it.other)));
    told.listed = collisions.iter().map(|it| pair(it.a, it.b)).collect();
}

/// Who is within so many of its bodies' least extents of whom.
#[derive(Resource, Default)]
struct Near(Vec<(Pair, bool)>);

/// More than the gap that ends a contact, m: 1 % of the smaller one's least extent, which is below 0.6 m here, and rounding.
const NEAR: f32 = 0.007;

/// Looks which of the pairs that are asked for are near each other.
fn measure(
    mut near: ResMut<Near>,
    space: SpatialQuery,
    shapes: Query<(&ConvexMesh, &Transform), With<RigidBody>>,
) {
    for ((a, b), is_near) in &mut near.0 {
        // The floor, if it is one of the two, has no such shape.
        let (own, other) = if shapes.contains(*a) {
            (*a, *b)
        } else {
            (*b, *a)
        };
        let Ok((mesh, at)) = shapes.get(own) else {
            continue;
        };
        let shape = QueryShape::from(mesh).rounded(NEAR).expect("a length");
        let pose = Pose::new(at.translation, at.rotation);
        let found = space.overlap_shape(&shape, &pose, &QueryFilter::all());
        *is_near = found.expect("a pose").contains(&other);
    }
}

struct Heap {
    app: App,
    dice: Dice,
    open: BTreeSet<Pair>,
    /// Those of them that were not near each other after the last step.
    apart: BTreeSet<Pair>,
    seed: u64,
    step: usize,
    story: Vec<String>,
}

impl Heap {
    /// A floor that is alone.
    fn floor(seed: u64) -> Self {
        let mut app = app();
        app.init_resource::<Told>()
            .init_resource::<Near>()
            .add_observer(|it: On<CollisionStart>, mut told: ResMut<Told>| {
                told.own_starts.push((it.entity, it.other));
            })
            .add_observer(|it: On<CollisionEnd>, mut told: ResMut<Told>| {
                told.own_ends.push((it.entity, it.other));
            });
        let half_space = HalfSpaceShape { normal: Vec3::Y };
        let floor = (RigidBody::Static, half_space, CollisionEvents);
        app.world_mut().spawn(floor);
        Self {
            app,
            dice: Dice::new(seed),
            open: BTreeSet::new(),
            apart: BTreeSet::new(),
            seed,
            step: 0,
            story: Vec::new(),
        }
    }

    /// Bodies that fall onto each other.
    fn new(seed: u64) -> Self {
        let mut heap = Self::floor(seed);
        let Self { app, dice, .. } = &mut heap;
        let width = dice.in_range(0.4, 1.5);
        // What is round rolls on for long otherwise.
        let drag = [0.0, 2.0][dice.below(2)];
        for i in 0..15 + dice.below(16) {
            let aside = dice.vector(-width, width);
            let place = Transform::from_translation(aside.with_y(0.5 + 0.45 * i as f32))
                .with_rotation(dice.rotation());
            let body = (RigidBody::Dynamic, shape(dice), place, CollisionEvents);
            let drag = (LinearDamping(drag), AngularDamping(drag));
            app.world_mut().spawn((body, drag));
        }
        heap
    }

    /// Boxes in rows on the floor, one stone apart from the next by next to nothing, so that they bear nothing of each other.
    fn rows(seed: u64) -> Self {
        let mut heap = Self::floor(seed);
        let Self { app, dice, .. } = &mut heap;
        for row in 0..4 {
            let mut end = 0.0;
            for _ in 0..2 + dice.below(5) {
                let [x, y, z] = [(); 3].map(|()| dice.in_range(0.1, 0.6));
                let shape = ConvexMesh::cuboid(x, y, z).expect("usable sizes");
                let at = Vec3::new(end + 0.5 * x, 0.5 * y, row as f32);
                end += x + dice.unit() * [1e-3, 1e-4, 1e-5, 1e-6, 1e-7][dice.below(5)];
                let place = Transform::from_translation(at);
                let body = (RigidBody::Dynamic, shape, place, CollisionEvents);
                app.world_mut().spawn(body);
            }
        }
        heap
    }

    /// A random body that takes part, if there are any.
    fn any(&mut self) -> Option<Entity> {
        let mut bodies = self
            .app
            .world_mut()
            .query_filtered::<(Entity, &RigidBody), ()>();
        let bodies = bodies.iter(self.app.world());
        let bodies = bodies.filter(|(_, kind)| **kind == RigidBody::Dynamic);
        let bodies: Vec<_> = bodies.map(|(entity, _)| entity).collect();
        let at = self.dice.below(bodies.len().max(1));
        bodies.get(at).copied()
    }

    /// What sleeps, and what never moves.
    fn sleepers(&mut self) -> BTreeSet<Entity> {
        let world = self.app.world_mut();
        let mut bodies = world.query::<(Entity, &RigidBody, Has<Sleeping>)>();
        let bodies = bodies.iter(world);
        let rests = bodies.filter(|(_, kind, sleeps)| *sleeps || **kind == RigidBody::Static);
        rests.map(|(entity, ..)| entity).collect()
    }

    /// How many bodies move that take part.
    fn dynamic(&self) -> usize {
        let bodies = self.app.world().resource::<Bodies>();
        let moves = |&slot: &u32| {
            bodies.kind(slot) == RigidBody::Dynamic
                && (bodies.is_active(slot) || bodies.is_asleep(slot))
        };
        bodies.iter().filter(moves).count()
    }

    fn disturb(&mut self) {
        let Some(entity) = self.any() else {
            return;
        };
        let deed = self.dice.below(9);
        self.story.push(format!("{}: {deed} {entity}", self.step));
        let (direction, spin) = (self.dice.direction(), self.dice.rotation());
        let world = self.app.world_mut();
        let at = *world.get::<Transform>(entity).expect("it has one");
        match deed {
            0 => drop(world.despawn(entity)),
            1 => drop(world.entity_mut(entity).insert(Disabled)),
            2 | 3 => {
                let plane = Plane::through(at.translation, direction);
                world.commands().slice(entity, plane);
            }
            4 => drop(world.entity_mut(entity).remove::<Sleeping>()),
            5 => drop(
                world
                    .entity_mut(entity)
                    .insert(LinearVelocity(3.0 * direction)),
            ),
            6 => {
                let moved = at.with_translation(at.translation + direction.abs());
                world.entity_mut(entity).insert(moved.with_rotation(spin));
            }
            7 => {
                let mut disabled = world.query_filtered::<Entity, With<Disabled>>();
                let disabled: Vec<_> = disabled.iter(world).collect();
                for entity in disabled {
                    world.entity_mut(entity).remove::<Disabled>();
                }
            }
            _ => drop(
                world
                    .entity_mut(entity)
                    .remove::<RigidBody>()
                    .insert(RigidBody::Dynamic),
            ),
        }
    }

    /// So many steps; how much they told.
    fn steps(&mut self, count: usize) -> usize {
        (0..count).map(|_| self.step()).sum()
    }

    /// One step, and what must hold of it; how much it told.
    fn step(&mut self) -> usize {
        let before = self.sleepers();
        self.app.update();
        // Messages are read once the step is over.
        self.app
            .world_mut()
            .run_system_cached(listen)
            .expect("a system");
        self.step += 1;
        let told = std::mem::take(&mut *self.app.world_mut().resource_mut::<Told>());
        let about = format!("seed {}, step {}: {:?}", self.seed, self.step, self.story);
        for pair in &told.ends {
            assert!(
                self.open.remove(pair),
                "{pair:?} ends, had not begun; {about}"
            );
        }
        for pair in &told.starts {
            assert!(
                !told.ends.contains(pair),
                "{pair:?} ends and begins; {about}"
            );
            assert!(self.open.insert(*pair), "{pair:?} begins again; {about}");
        }
        self.check_own(&told, &about);
        let after = self.sleepers();
        let slept = |it: &Entity| before.contains(it) && after.contains(it);
        for (a, b) in told.starts.iter().chain(&told.ends) {
            assert!(!(slept(a) && slept(b)), "{a} and {b} sleep; {about}");
        }
        for &entity in self.open.iter().flat_map(|(a, b)| [a, b]) {
            let world = self.app.world();
            let entity = world.get_entity(entity).ok();
            let takes_part =
                entity.is_some_and(|it| it.contains::<RigidBody>() && !it.contains::<Disabled>());
            assert!(takes_part, "a pair of a body that is gone; {about}");
        }
        let listed: BTreeSet<Pair> = told.listed.iter().copied().collect();
        let unheard: Vec<_> = listed.difference(&self.open).collect();
        assert!(
            unheard.is_empty(),
            "{unheard:?} touch, had not begun; {about}"
        );
        let apart = self.open.difference(&listed).map(|&pair| (pair, false));
        self.app.insert_resource(Near(apart.collect()));
        self.app
            .world_mut()
            .run_system_cached(measure)
            .expect("a system");
        let near = &self.app.world().resource::<Near>().0;
        let apart = near.iter().filter(|(_, is_near)| !is_near);
        let apart: BTreeSet<Pair> = apart.map(|(pair, _)| *pair).collect();
        // The step looks at gaps before it moves bodies.
        let late: Vec<_> = apart.intersection(&self.apart).collect();
        assert!(
            late.is_empty(),
            "{late:?} do not touch, had not ended; {about}"
        );
        self.apart = apart;
        told.starts.len() + told.ends.len()
    }

    /// Events of entities are those of the messages, for each of the two that is there still.
    fn check_own(&self, told: &Told, about: &str) {
        for (own, messages) in [
            (&told.own_starts, &told.starts),
            (&told.own_ends, &told.ends),
        ] {
            let mut own = own.clone();
            own.sort_unstable();
            let both = messages.iter().flat_map(|&(a, b)| [(a, b), (b, a)]);
            let hears = |&(a, _): &Pair| self.app.world().get_entity(a).is_ok();
            let mut expected: Vec<_> = both.filter(hears).collect();
            expected.sort_unstable();
            own.retain(hears);
            assert_eq!(own, expected, "{about}");
        }
    }
}

/// A box, the hull of a cloud of points, or something round.
fn shape(dice: &mut Dice) -> ConvexMesh {
    let [a, b, c] = [(); 3].map(|()| dice.in_range(0.2, 0.6));
    match dice.below(6) {
        0 | 1 => ConvexMesh::cuboid(a, b, c),
        2 | 3 => {
            let points: Vec<_> = (0..12).map(|_| 0.5 * (a + b) * dice.direction()).collect();
            ConvexMesh::from_points(&points.iter().map(|p| 0.6 * *p).collect::<Vec<_>>())
        }
        4 => ConvexMesh::sphere(0.5 * a),
        _ => ConvexMesh::capsule(0.4 * a, b),
    }
    .expect("usable sizes")
}

#[test]
fn what_is_told_of_heaps_is_what_touches_asleep_or_not_whatever_happens() {
    let mut asleep = 0;
    for seed in 0..7 {
        let mut heap = Heap::new(seed);
        for _ in 0..4 {
            // Some disturbances while all moves, some when much sleeps.
            for _ in 0..2 + heap.dice.below(4) {
                let wait = 1 + heap.dice.below(60);
                heap.steps(wait);
                heap.disturb();
            }
            heap.steps(240);
        }
        let report = heap.app.world().resource::<StepReport>();
        if report.asleep == heap.dynamic() {
            asleep += 1;
            assert_eq!(heap.steps(60), 0, "seed {seed}");
        }
    }
    assert!(asleep > 2, "{asleep} heaps came to rest");
}

#[test]
fn what_falls_asleep_beside_each_other_and_bears_nothing_is_told_if_it_is_listed() {
    let mut beside = 0;
    for seed in 0..20 {
        let mut heap = Heap::rows(seed);
        heap.steps(150);
        assert_eq!(heap.sleepers().len(), heap.dynamic() + 1, "seed {seed}");
        beside += heap.open.len() - heap.dynamic();
        // They wake, and go on to touch or come apart, which is told too.
        heap.disturb();
        heap.steps(120);
    }
    assert!(beside > 20, "{beside} pairs touch beside each other");
}
