//! One run of a scene: in a process of its own, by the plain step or by the plugin.

use crate::course::{Hashes, View, Watch};
use crate::scene::Scene;
use bevy_app::{App, TaskPoolOptions, TaskPoolPlugin, TaskPoolThreadAssignmentPolicy};
use bevy_cleave::prelude::*;
use bevy_cleave::testing::batch::SolverOverrides;
use bevy_cleave::testing::simd::LaneWidth;
use bevy_ecs::prelude::*;
use bevy_tasks::{ComputeTaskPool, TaskPoolBuilder};
use bevy_time::Time;
use bevy_transform::components::Transform;
use std::process::Command;
use std::time::Duration;

/// Names the run to a child process.
const VARIABLE: &str = "CLEAVE_DETERMINISM_RUN";

/// The only test that a child process runs.
const CHILD: &str = "a_run_gives_the_same_bits_here_and_in_a_child";

/// What a child prints before its hashes.
const MARK: &str = "hashes ";

/// Length of a step, s.
fn step_length() -> Duration {
    Duration::from_secs_f64(1.0 / 60.0)
}

/// What makes the steps, and how bodies come to where they are in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Driver {
    /// [`Simulation`], slots in the order of ids.
    Plain,
    /// [`Simulation`] in slots that others left in another order.
    RecycledSlots,
    /// [`Simulation`], taken back every so often to a copy of what it was some steps before.
    TakenBack,
    /// The plugin.
    Plugin,
    /// The plugin with entities and slots that others left in another order.
    RecycledEntities,
    /// The plugin with entities in many tables.
    ManyTables,
    /// The plugin with entities that were made in the opposite order, before they got their components.
    EntitiesBackwards,
}

/// A way to run a scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run {
    pub(crate) scene: Scene,
    pub(crate) driver: Driver,
    /// Threads of the task pool; 0 for no pool.
    pub(crate) threads: usize,
    pub(crate) lanes: LaneWidth,
}

impl Run {
    /// Makes the run in a child process; its hashes.
    pub(crate) fn hashes_of_child(&self) -> Hashes {
        let program = std::env::current_exe().expect("a test program has a path");
        let output = Command::new(program)
            .args(["--exact", CHILD, "--nocapture"])
            .env(VARIABLE, format!("{self:?}"))
            .output()
            .expect("the test program can be started");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(
            output.status.success(),
            "{self:?}: {text}{}",
            String::from_utf8_lossy(&output.stderr)
        );
        let hashes = text.split(MARK).nth(1).expect("the child prints hashes");
        let mut hashes = hashes.split_whitespace().map(|hash| {
            u64::from_str_radix(hash, 16).unwrap_or_else(|_| panic!("{hash} is not a hash"))
        });
        let mut next = || hashes.next().expect("the child prints two hashes");
        Hashes {
            state: next(),
            course: next(),
        }
    }

    /// All ways there are.
    fn all() -> impl Iterator<Item = Self> {
        use Driver::*;
        let drivers = [
            Plain,
            RecycledSlots,
            TakenBack,
            Plugin,
            RecycledEntities,
            ManyTables,
            EntitiesBackwards,
        ];
        let widths = [LaneWidth::Widest, LaneWidth::Four, LaneWidth::One];
        Scene::ALL.into_iter().flat_map(move |scene| {
            drivers.into_iter().flat_map(move |driver| {
                (0..=8).flat_map(move |threads| {
                    widths.into_iter().map(move |lanes| Self {
                        scene,
                        driver,
                        threads,
                        lanes,
                    })
                })
            })
        })
    }

    /// The run that the environment names to a child process.
    pub(crate) fn asked_for() -> Option<Self> {
        let name = std::env::var(VARIABLE).ok()?;
        let run = Self::all().find(|run| format!("{run:?}") == name);
        Some(run.unwrap_or_else(|| panic!("{VARIABLE} names no run: {name:?}")))
    }

    /// Makes the run and prints its hashes.
    pub(crate) fn print_hashes(&self) {
        let Hashes { state, course } = self.hashes();
        println!("{MARK}{state:016x} {course:016x}");
    }

    /// Makes the run in this process; its hashes.
    pub(crate) fn hashes(&self) -> Hashes {
        let (bodies, mut watch) = match self.driver {
            Driver::Plain | Driver::RecycledSlots | Driver::TakenBack => self.step_plainly(),
            _ => self.step_plugin(),
        };
        let hashes = watch.end(&bodies);
        println!("{:?}", watch.events);
        self.scene.check(&watch.events);
        hashes
    }

    fn config(&self) -> SolverConfig {
        self.scene.config()
    }

    fn step_plainly(&self) -> (Bodies, Watch) {
        if self.threads > 0 {
            let pool = TaskPoolBuilder::new().num_threads(self.threads);
            ComputeTaskPool::get_or_init(|| pool.build());
        }
        let mut simulation = Simulation {
            config: self.config(),
            overrides: SolverOverrides {
                lane_width: self.lanes,
                order: self.scene.order(),
            },
            ..Default::default()
        };
        if self.driver == Driver::RecycledSlots {
            use_and_leave_slots(&mut simulation);
        }
        let descs = self.scene.bodies().into_iter();
        let slots: Vec<u32> = descs
            .map(|desc| simulation.bodies.insert(desc).expect("usable"))
            .collect();
        self.scene.prepare(&mut simulation, &slots);
        let mut watch = Watch::default();
        for step in 0..self.scene.steps() {
            if self.driver == Driver::TakenBack && step % 9 == 4 {
                go_and_come_back(&mut simulation);
            }
            self.scene.act(step, &mut simulation, &slots);
            simulation.step(step_length().as_secs_f32());
            watch.add(&View::of(&simulation));
        }
        (simulation.bodies, watch)
    }

    fn step_plugin(&self) -> (Bodies, Watch) {
        let mut app = self.app();
        self.spawn(app.world_mut());
        let mut watch = Watch::default();
        for _ in 0..self.scene.steps() {
            step(app.world_mut());
            watch.add(&view(app.world()));
        }
        let bodies = app.world_mut().remove_resource::<Bodies>();
        (bodies.expect("the plugin has bodies"), watch)
    }

    fn app(&self) -> App {
        let mut app = App::new();
        let compute = TaskPoolThreadAssignmentPolicy {
            min_threads: self.threads,
            max_threads: self.threads,
            percent: 1.0,
            on_thread_spawn: None,
            on_thread_destroy: None,
        };
        let task_pool_options = TaskPoolOptions {
            compute,
            ..Default::default()
        };
        app.add_plugins((
            TaskPoolPlugin { task_pool_options },
            CleavePlugin::default(),
        ))
        .init_resource::<Time>();
        app.world_mut().insert_resource(self.config());
        app.finish();
        app.cleanup();
        app
    }

    fn spawn(&self, world: &mut World) {
        let descs = self.scene.bodies();
        match self.driver {
            Driver::EntitiesBackwards => {
                let empty = descs.iter().map(|_| world.spawn_empty().id());
                let entities: Vec<Entity> = empty.collect();
                for (i, (desc, &entity)) in descs.iter().zip(entities.iter().rev()).enumerate() {
                    mark(&mut world.entity_mut(entity), i);
                    insert(&mut world.entity_mut(entity), desc);
                }
            }
            driver => {
                if driver == Driver::RecycledEntities {
                    use_and_leave_entities(world);
                }
                for (i, desc) in descs.into_iter().enumerate() {
                    let entity = world.spawn_body(desc);
                    if driver == Driver::ManyTables {
                        mark(&mut world.entity_mut(entity), i);
                    }
                }
            }
        }
    }
}

/// One step of the plugin, without the rest of an update.
fn step(world: &mut World) {
    world.resource_mut::<Time>().advance_by(step_length());
    world.run_schedule(PhysicsSchedule);
}

fn view(world: &World) -> View<'_> {
    View {
        bodies: world.resource(),
        contacts: world.resource(),
        cache: world.resource(),
        fractures: world.resource(),
        bonds: world.resource(),
        report: world.resource(),
    }
}

/// Numbers below `count` in another order: every seventh, round and round. `count` must not be a multiple of 7.
fn shuffled(count: usize) -> impl Iterator<Item = usize> {
    (0..count).map(move |i| 7 * i % count)
}

/// Bodies that come before those of the scene and go again.
const EARLIER: usize = 101;

/// A small body at its own place.
fn earlier(i: usize) -> BodyDesc {
    let shape = ConvexMesh::cuboid(0.1, 0.1, 0.1).expect("valid size");
    BodyDesc::dynamic(shape, glam::Vec3::new(i as f32, 50.0, 0.0))
}

/// Steps that are taken back.
fn go_and_come_back(simulation: &mut Simulation) {
    let copy = simulation.clone();
    (0..3).for_each(|_| simulation.step(step_length().as_secs_f32()));
    simulation.clone_from(&copy);
}

fn use_and_leave_slots(simulation: &mut Simulation) {
    let insert = |i| simulation.bodies.insert(earlier(i)).expect("usable");
    let slots: Vec<u32> = (0..EARLIER).map(insert).collect();
    simulation.step(step_length().as_secs_f32());
    shuffled(EARLIER).for_each(|i| simulation.bodies.remove(slots[i]));
}

fn use_and_leave_entities(world: &mut World) {
    let spawn = |i| world.spawn_body(earlier(i));
    let entities: Vec<Entity> = (0..EARLIER).map(spawn).collect();
    step(world);
    shuffled(EARLIER).for_each(|i| assert!(world.despawn(entities[i])));
}

#[derive(Component, Clone)]
struct First;

#[derive(Component, Clone)]
struct Second;

#[derive(Component, Clone)]
struct Third;

/// Puts the entity into one of eight tables.
fn mark(entity: &mut EntityWorldMut<'_>, i: usize) {
    if i & 1 > 0 {
        entity.insert(First);
    }
    if i & 2 > 0 {
        entity.insert(Second);
    }
    if i & 4 > 0 {
        entity.insert(Third);
    }
}

/// Makes a body of an entity: the components that the scenes use.
fn insert(entity: &mut EntityWorldMut<'_>, desc: &BodyDesc) {
    match &desc.shape {
        Shape::Convex(mesh) => entity.insert(mesh.clone()),
        Shape::HalfSpace(half_space) => entity.insert(*half_space),
        Shape::Level(mesh) => entity.insert(mesh.clone()),
        Shape::Compound(compound) => entity.insert(compound.clone()),
    };
    if let Some(fracturable) = desc.fracturable.clone() {
        entity.insert(fracturable);
    }
    let transform = Transform {
        translation: desc.pose.position,
        rotation: desc.pose.rotation,
        ..Transform::IDENTITY
    };
    entity.insert((
        desc.kind,
        transform,
        LinearVelocity(desc.linear_velocity),
        AngularVelocity(desc.angular_velocity),
        (Density(desc.density), desc.friction, desc.restitution),
    ));
}
