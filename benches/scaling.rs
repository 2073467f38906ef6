//! What an app does to each of many entities takes no longer for each the more there are.
//!
//! Told for each deed: processor time for an entity, of so many and of four times as many, and how much more that is. Rounds of steps count as one
//! deed. What looks for neighbors in a tree, or no longer fits into a cache, may take a little more; twice as much is a search through all of them.
//!
//! `cargo bench --bench scaling`
#![allow(clippy::print_stdout, reason = "a bench tells its figures")]

use bevy_app::{App, TaskPoolPlugin};
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use cpu_time::ProcessTime;
use glam::Vec3;

/// Bodies of a row of the grid, 1 m apart.
const ROW: usize = 128;

/// Times each deed is done, each time to another scene; the least time counts.
const ROUNDS: usize = 3;

/// An app and the entities that something is done to.
struct Stage {
    app: App,
    entities: Vec<Entity>,
    /// Their joints, or the one floor or parent that they all have.
    others: Vec<Entity>,
}

/// What is done, what comes before it, and what is timed.
type Deed = (&'static str, fn(&mut Stage, usize), fn(&mut Stage, usize));

const DEEDS: &[Deed] = &[
    ("spawn", |_, _| (), |s, n| s.bodies(n, RigidBody::Dynamic)),
    ("spawn where no Transform is one", |_, _| (), Stage::refused),
    ("mend it", Stage::refused, |s, _| {
        s.edit(|t: &mut Transform| t.scale = Vec3::ONE);
    }),
    ("spawn beside such", Stage::refused, |s, n| {
        s.bodies(n, RigidBody::Dynamic);
    }),
    ("wait for shapes", Stage::shapeless, |s, _| s.updates(3)),
    ("get shapes", Stage::shapeless, |s, _| s.insert(cube(0.5))),
    ("three steps", Stage::crates, |s, _| s.updates(3)),
    ("set velocities", Stage::crates, |s, _| {
        s.edit(|v: &mut LinearVelocity| v.0.y = 0.1);
    }),
    ("move elsewhere", Stage::crates, |s, _| {
        s.edit(|t: &mut Transform| t.translation.y += 1.0);
    }),
    ("other shapes", Stage::crates, |s, _| s.insert(cube(0.4))),
    ("become static", Stage::crates, |s, _| {
        s.insert(RigidBody::Static);
    }),
    ("static ones get velocities", Stage::posts, |s, _| {
        s.insert(LinearVelocity(Vec3::X));
    }),
    ("become sensors", Stage::crates, |s, _| s.insert(Sensor)),
    ("disable", Stage::crates, |s, _| s.insert(Disabled)),
    ("enable", Stage::disabled, |s, _| s.remove::<Disabled>()),
    ("lose RigidBody", Stage::crates, |s, _| {
        s.remove::<RigidBody>();
    }),
    ("despawn", Stage::watched, |s, _| s.despawn()),
    ("lose the floor", Stage::watched, |s, _| {
        let floor = s.others.pop().expect("a floor");
        s.app.world_mut().despawn(floor);
        s.updates(1);
    }),
    ("explode", Stage::crates, |s, _| {
        let explosion = Explosion {
            center: Vec3::ZERO,
            radius: 1e3,
            impulse: 1.0,
        };
        s.app.world_mut().commands().explode(explosion);
        s.updates(1);
    }),
    ("slice", Stage::crates, |s, _| s.slice()),
    ("move kinematic ones", Stage::platforms, |s, _| {
        s.edit(|t: &mut Transform| t.translation.y += 0.01);
    }),
    ("join", Stage::crates, |s, _| s.join()),
    ("refuse joints", Stage::joined, |s, _| s.refuse_joints()),
    (
        "steps with refused joints",
        Stage::refused_joints,
        |s, _| {
            s.updates(3);
        },
    ),
    ("bond", Stage::crates, |s, _| s.bond()),
    ("unbond", Stage::bonded, |s, _| s.unbond()),
    ("parent moves", Stage::family, |s, _| {
        let parent = s.others[0];
        let mut parent = s.app.world_mut().entity_mut(parent);
        parent.get_mut::<Transform>().expect("one").translation.y += 1.0;
        s.updates(1);
    }),
    ("characters stand", Stage::characters, |s, _| s.updates(3)),
    ("characters walk", Stage::characters, |s, _| s.walk()),
    ("characters walk among platforms", Stage::city, |s, _| {
        s.walk();
    }),
    (
        "Queries::walk among platforms",
        Stage::city,
        Stage::walk_plainly,
    ),
];

fn main() {
    // `cargo test` runs it to see that it works.
    let is_bench = std::env::args().any(|arg| arg == "--bench");
    let count = if is_bench { 1000 } else { 20 };
    for &(name, before, deed) in DEEDS {
        let [few, many] = [count, 4 * count].map(|n| {
            let times = (0..ROUNDS).map(|_| microseconds(before, deed, n));
            times.fold(f64::INFINITY, f64::min) / n as f64
        });
        let ratio = many / few;
        println!("{name:32} {few:8.2} {many:8.2} us, {ratio:.2} times");
    }
}

fn microseconds(before: fn(&mut Stage, usize), deed: fn(&mut Stage, usize), n: usize) -> f64 {
    let mut app = App::new();
    app.add_plugins((
        TaskPoolPlugin::default(),
        TimePlugin,
        CleavePlugin::default(),
        WalkerPlugin,
    ))
    .insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    app.finish();
    app.cleanup();
    app.update();
    let mut stage = Stage {
        app,
        entities: Vec::new(),
        others: Vec::new(),
    };
    before(&mut stage, n);
    let start = ProcessTime::now();
    deed(&mut stage, n);
    start.elapsed().as_secs_f64() * 1e6
}

fn cube(size: f32) -> ConvexMesh {
    ConvexMesh::cuboid(size, size, size).expect("a cube has a volume")
}

fn place(number: usize) -> Vec3 {
    Vec3::new((number % ROW) as f32, 0.25, (number / ROW) as f32)
}

impl Stage {
    fn updates(&mut self, count: usize) {
        (0..count).for_each(|_| self.app.update());
    }

    /// Spawns as many as asked for, each with what is made for its place, and lets a step see them.
    fn spawn<B: Bundle>(&mut self, n: usize, bundle: impl Fn(Transform) -> B) {
        for number in 0..n {
            let bundle = bundle(Transform::from_translation(place(number)));
            let entity = self.app.world_mut().spawn(bundle).id();
            self.entities.push(entity);
        }
        self.updates(1);
    }

    fn bodies(&mut self, n: usize, kind: RigidBody) {
        let shape = cube(0.5);
        self.spawn(n, |at| (kind, shape.clone(), at));
    }

    fn floor(&mut self) {
        let half_space = HalfSpaceShape { normal: Vec3::Y };
        let floor = self.app.world_mut().spawn((RigidBody::Static, half_space));
        self.others.push(floor.id());
    }

    fn crates(&mut self, n: usize) {
        self.bodies(n, RigidBody::Dynamic);
    }

    fn posts(&mut self, n: usize) {
        self.bodies(n, RigidBody::Static);
    }

    fn platforms(&mut self, n: usize) {
        self.bodies(n, RigidBody::Kinematic);
    }

    fn watched(&mut self, n: usize) {
        self.floor();
        self.crates(n);
        self.insert(CollisionEvents);
        self.updates(2);
    }

    fn disabled(&mut self, n: usize) {
        self.crates(n);
        self.insert(Disabled);
    }

    fn refused(&mut self, n: usize) {
        let shape = cube(0.5);
        let kind = RigidBody::Dynamic;
        self.spawn(n, |at| (kind, shape.clone(), at.with_scale(Vec3::NAN)));
    }

    fn shapeless(&mut self, n: usize) {
        self.spawn(n, |at| (RigidBody::Dynamic, at));
    }

    fn family(&mut self, n: usize) {
        let parent = self.app.world_mut().spawn(Transform::default()).id();
        self.others.push(parent);
        self.crates(n);
        for &child in &self.entities {
            self.app
                .world_mut()
                .entity_mut(child)
                .insert(ChildOf(parent));
        }
        self.updates(1);
    }

    fn characters(&mut self, n: usize) {
        self.floor();
        let shape = ConvexMesh::capsule(0.2, 0.6).expect("a capsule has a volume");
        self.spawn(n, |mut at| {
            at.translation.y = 0.55;
            (RigidBody::Kinematic, shape.clone(), at, Walker::default())
        });
        self.updates(10);
    }

    fn city(&mut self, n: usize) {
        self.platforms(n);
        self.insert(LinearVelocity(0.01 * Vec3::Y));
        self.entities.clear();
        self.characters(n);
    }

    fn walk(&mut self) {
        for &entity in &self.entities {
            let mut character = self.app.world_mut().entity_mut(entity);
            character.get_mut::<Walker>().expect("one").velocity = Vec3::X;
        }
        self.updates(3);
    }

    /// As many characters as asked for, that no entity stands for, by one view.
    fn walk_plainly(&mut self, n: usize) {
        let mut index = QueryIndex::default();
        let bodies = self.app.world().resource::<Bodies>();
        index.refresh(bodies);
        let queries = index.queries(bodies);
        let shape = ConvexMesh::capsule(0.2, 0.6).expect("a capsule has a volume");
        let settings = WalkSettings::default();
        let slider = Slider {
            shape: QueryShape::from(&shape),
            skin: settings.skin,
        };
        let input = WalkInput {
            velocity: Vec3::X,
            jump: 0.0,
            gravity: 9.81 * Vec3::NEG_Y,
            step_dt: 1.0 / 60.0,
        };
        let mut pushes = Vec::new();
        for number in 0..n {
            let mut state = WalkState {
                position: place(number) + Vec3::new(0.5, 0.6, 0.5),
                ..WalkState::default()
            };
            let how = (&slider, &settings);
            queries.walk(how, &mut state, &input, &QueryFilter::all(), &mut pushes);
        }
    }

    /// Changes a component of each entity.
    fn edit<C: Component<Mutability = bevy_ecs::component::Mutable>>(
        &mut self,
        change: fn(&mut C),
    ) {
        for &entity in &self.entities {
            let mut entity = self.app.world_mut().entity_mut(entity);
            change(&mut entity.get_mut::<C>().expect("one"));
        }
        self.updates(1);
    }

    fn insert(&mut self, component: impl Bundle + Clone) {
        for &entity in &self.entities {
            let mut entity = self.app.world_mut().entity_mut(entity);
            entity.insert(component.clone());
        }
        self.updates(1);
    }

    fn remove<B: Bundle>(&mut self) {
        for &entity in &self.entities {
            self.app.world_mut().entity_mut(entity).remove::<B>();
        }
        self.updates(1);
    }

    fn despawn(&mut self) {
        for entity in self.entities.drain(..) {
            self.app.world_mut().despawn(entity);
        }
        self.updates(1);
    }

    fn slice(&mut self) {
        for (number, &entity) in self.entities.iter().enumerate() {
            let plane = Plane {
                normal: Vec3::X,
                offset: place(number).x,
            };
            self.app.world_mut().commands().slice(entity, plane);
        }
        self.updates(1);
    }

    /// Does something to each two that are next to each other.
    fn pairs(&mut self, mut deed: impl FnMut(&mut Commands, Entity, Entity)) {
        for pair in self.entities.chunks_exact(2) {
            deed(&mut self.app.world_mut().commands(), pair[0], pair[1]);
        }
        self.updates(1);
    }

    fn join(&mut self) {
        let mut joints = Vec::new();
        let mut joint = Joint::ball();
        joint.frame_a.position = Vec3::X;
        self.pairs(|commands, a, b| joints.push(commands.join(a, b, joint)));
        self.others = joints;
    }

    fn joined(&mut self, n: usize) {
        self.crates(n);
        self.join();
    }

    fn refuse_joints(&mut self) {
        for &joint in &self.others {
            let mut joint = self.app.world_mut().entity_mut(joint);
            let mut joint = joint.get_mut::<Joint>().expect("one");
            joint.frame_a.position.x = f32::NAN;
        }
        self.updates(1);
    }

    fn refused_joints(&mut self, n: usize) {
        self.joined(n);
        self.refuse_joints();
    }

    fn bond(&mut self) {
        self.pairs(|commands, a, b| commands.bond(a, b, Bond::new(100.0, 0.25)));
    }

    fn bonded(&mut self, n: usize) {
        self.crates(n);
        self.bond();
    }

    fn unbond(&mut self) {
        self.pairs(|commands, a, b| commands.unbond(a, b));
    }
}
