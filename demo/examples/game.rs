//! A game as a newcomer would write it: rough ground, a figurine, a wall, a pane in its frame, a door, a ball on a chain, a goal, and
//! a hero that walks. Swipe to slice, right button to throw, arrows and space to walk and jump, `E` for an explosion under the pointer,
//! `S` for slow motion, `B` to go back by two seconds, `D` for what the solver sees, `F5` to save to `target/game.ron` and `F9` to load that.
//!
//! What is the game is above; what only brings the physics and Bevy together is [`glue`], line by line, with why it is needed.

use bevy::ecs::entity_disabling::Disabled;
use bevy::input::common_conditions::input_just_pressed;
use bevy::prelude::*;
use bevy::window::PrimaryWindow;
use bevy_cleave::import::{ImportOptions, Model};
use bevy_cleave::prelude::*;

const SPOT: &str = include_str!("../../assets/meshes/spot.obj");
/// Material slot of cut faces.
const CUT: u16 = 1;
/// How far the pointer reaches, m.
const REACH: f32 = 50.0;

fn main() {
    App::new()
        .add_plugins((bevy::DefaultPlugins, glue::plugins))
        // A file that is not there ends no game.
        .set_error_handler(bevy::ecs::error::warn)
        .init_resource::<Points>()
        .add_systems(
            Startup,
            (build_level, build_targets, build_machines, build_goal).chain(),
        )
        .add_systems(
            Update,
            (
                slice,
                throw,
                explode,
                walk,
                slow_down,
                go_back,
                look_inside,
                score,
                glue::save.run_if(input_just_pressed(KeyCode::F5)),
                glue::load.run_if(input_just_pressed(KeyCode::F9)),
            ),
        )
        .add_observer(paint)
        .add_observer(reach)
        .run();
}

/// What a body looks like; what is drawn of it follows, since a file of the game holds no materials.
#[derive(Clone, Copy, Component, Reflect)]
#[reflect(Component)]
enum Look {
    Ground,
    Brick,
    Figurine,
    Glass,
    Iron,
    Flesh,
}

fn paint(
    event: On<Add<Look>>,
    // What broke and may come back is disabled, and in a file it is so from the start.
    looks: Query<&Look, Allow<Disabled>>,
    palette: Res<Palette>,
    mut commands: Commands,
) -> Result {
    let (material, draw) = match looks.get(event.entity)? {
        Look::Ground => (&palette.ground, DrawShape::new()),
        Look::Brick => (&palette.brick, DrawShape::new()),
        Look::Figurine => {
            let cut = DrawShape::new().with_slot(CUT, palette.flesh.clone());
            (&palette.brick, cut)
        }
        Look::Glass => (&palette.glass, DrawShape::new()),
        Look::Iron => (&palette.iron, DrawShape::new()),
        Look::Flesh => (&palette.flesh, DrawShape::new()),
    };
    let mut entity = commands.entity(event.entity);
    entity.insert_if_new((material.clone(), draw));
    Ok(())
}

/// Materials of the game.
#[derive(Resource)]
struct Palette {
    ground: MeshMaterial3d<StandardMaterial>,
    brick: MeshMaterial3d<StandardMaterial>,
    glass: MeshMaterial3d<StandardMaterial>,
    iron: MeshMaterial3d<StandardMaterial>,
    flesh: MeshMaterial3d<StandardMaterial>,
}

fn build_level(mut commands: Commands, mut materials: ResMut<Assets<StandardMaterial>>) -> Result {
    let mut paint = |color: Color| {
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: color,
            alpha_mode: if color.alpha() < 1.0 {
                AlphaMode::Blend
            } else {
                AlphaMode::Opaque
            },
            ..default()
        }))
    };
    let palette = Palette {
        ground: paint(Color::srgb(0.35, 0.42, 0.30)),
        brick: paint(Color::srgb(0.60, 0.30, 0.22)),
        glass: paint(Color::srgba(0.6, 0.85, 0.85, 0.35)),
        iron: paint(Color::srgb(0.25, 0.25, 0.28)),
        flesh: paint(Color::srgb(0.75, 0.10, 0.08)),
    };
    let eye = Transform::from_xyz(4.0, 3.0, 7.0).looking_at(Vec3::new(0.0, 0.8, 0.0), Vec3::Y);
    commands.spawn((Camera3d::default(), eye));
    let sun = DirectionalLight {
        shadow_maps_enabled: true,
        ..default()
    };
    commands.spawn((
        sun,
        Transform::from_xyz(3.0, 6.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));

    // Rough ground: a level of triangles over a grid of heights.
    let heights: Vec<f32> = (0..64 * 64)
        .map(|i| 0.06 * ops::sin((i % 64) as f32 * 0.9) * ops::cos((i / 64) as f32 * 0.7))
        .collect();
    let ground = StaticMesh::from_heights(&heights, 64, 0.4)?;
    let at = Transform::from_xyz(-12.8, 0.0, -12.8);
    commands.insert_resource(palette);
    commands.spawn((RigidBody::Static, ground, at, Look::Ground));
    Ok(())
}

fn build_targets(mut commands: Commands) -> Result {
    let figurine = Fracturable {
        cut_material: Some(CUT),
        ..Fracturable::with_strength(400.0)
    };
    let model = Model::from_obj(SPOT)?.import(&ImportOptions::default())?;
    let shape = model.shape()?.scaled(Vec3::splat(0.5))?;
    for i in 0..3 {
        let at = Transform::from_xyz(1.1 * i as f32 - 1.1, 2.5 + i as f32, 1.2);
        let body = (RigidBody::Dynamic, shape.clone(), figurine.clone());
        commands.spawn((body, at, Look::Figurine));
    }

    let mut wall = Vec::new();
    for (course, i) in (0..8).flat_map(|course| (0..8).map(move |i| (course, i))) {
        let shift = 0.25 * (course % 2) as f32;
        let at = Transform::from_xyz(
            0.5 * i as f32 + shift - 4.2,
            0.25 * course as f32 + 0.2,
            -1.6,
        );
        // On rough ground it would fall over by itself.
        let kind = if course == 0 {
            RigidBody::Static
        } else {
            RigidBody::Dynamic
        };
        let brick = (kind, cuboid!(0.5, 0.25, 0.25), Density(1900.0));
        wall.push(commands.spawn((brick, at, Look::Brick)).id());
    }
    commands.bond_neighbors(wall, 3.0e5);

    let glass = Fracturable {
        pattern: FracturePattern::Radial { rays: 16, rings: 8 },
        toughness: 8.0,
        generations: 0,
        ..Fracturable::with_strength(20.0)
    };
    let mut held = Vec::new();
    for x in [1.3, 2.7] {
        let at = Transform::from_xyz(x, 0.8, -0.8);
        let post = (RigidBody::Static, cuboid!(0.1, 1.6, 0.1), at);
        held.push(commands.spawn((post, Look::Ground)).id());
    }
    let at = Transform::from_xyz(2.0, 0.9, -0.8);
    let pane = (
        RigidBody::Dynamic,
        cuboid!(1.3, 1.0, 0.015),
        Density(2500.0),
        glass,
    );
    held.push(commands.spawn((pane, at, Look::Glass)).id());
    commands.bond_neighbors(held, 4.0e5);
    Ok(())
}

/// A door between two posts, and a ball on a chain beside it.
fn build_machines(mut commands: Commands) {
    let hinge_side = Vec3::new(-0.45, 0.0, 0.0);
    let at = Vec3::new(-3.6, 1.0, 1.6);
    let door = (
        RigidBody::Dynamic,
        cuboid!(0.9, 1.7, 0.06),
        Density(600.0),
        Fracturable::with_strength(60.0),
    );
    let door = (door, Transform::from_translation(at), Look::Brick);
    let door = commands.spawn(door).id();
    for side in [-1.0, 1.0] {
        let post = (RigidBody::Static, cuboid!(0.1, 2.0, 0.1));
        let place = Transform::from_translation(at + 0.54 * side * Vec3::X);
        commands.spawn((post, place, Look::Ground));
    }
    let hinge = Joint::hinge()
        .with_axes(Vec3::Y, Vec3::Y)
        .with_anchors(at + hinge_side, hinge_side)
        .with_angular_friction(2.0);
    commands.join(None, door, hinge);

    let hook = Vec3::new(-2.2, 3.0, 2.2);
    let half = Vec3::new(0.0, 0.12, 0.0);
    let mut above = (None, hook);
    for i in 0..8 {
        let middle = hook - (2 * i + 1) as f32 * half;
        let link = (RigidBody::Dynamic, capsule!(0.025, 0.19), Density(7800.0));
        let place = Transform::from_translation(middle);
        let link = commands.spawn((link, place, Look::Iron)).id();
        let joint = Joint::ball().with_anchors(above.1, half);
        commands.join(above.0, link, joint);
        above = (Some(link), -half);
    }
    let reach = Vec3::new(0.0, 0.2, 0.0);
    let ball = (RigidBody::Dynamic, sphere!(0.2), Density(7800.0));
    let push = LinearVelocity(Vec3::new(-2.5, 0.0, 0.0));
    let place = Transform::from_translation(hook - 16.0 * half - reach);
    let ball = commands.spawn((ball, place, push, Look::Iron)).id();
    commands.join(above.0, ball, Joint::ball().with_anchors(above.1, reach));
}

/// The one that walks.
#[derive(Component, Default, Reflect)]
#[reflect(Component)]
struct Hero;

/// Where the hero wants to get.
#[derive(Component, Default, Reflect)]
#[reflect(Component)]
struct Goal;

/// A zone that sees who is in it, and the hero.
fn build_goal(mut commands: Commands) {
    let at = Transform::from_xyz(3.4, 0.6, 2.2);
    let zone = (RigidBody::Static, cuboid!(0.8, 1.2, 0.8), Sensor, Goal);
    commands.spawn((zone, at, Look::Glass));
    let at = Transform::from_xyz(0.4, 1.2, 3.0);
    let hero = (RigidBody::Kinematic, capsule!(0.22, 0.6), Hero);
    commands.spawn((hero, Walker::default(), at, Look::Flesh));
}

/// Ten points for the hero in the goal, which is elsewhere then.
fn reach(
    event: On<CollisionStart>,
    heroes: Query<(), With<Hero>>,
    mut goals: Query<&mut Transform, With<Goal>>,
    mut points: ResMut<Points>,
) {
    if heroes.contains(event.other)
        && let Ok(mut goal) = goals.get_mut(event.entity)
    {
        points.0 += 10;
        goal.translation = Vec3::new(-goal.translation.x, 0.6, 2.6);
    }
}

fn walk(keys: Res<ButtonInput<KeyCode>>, mut heroes: Query<&mut Walker, With<Hero>>) {
    let along =
        |plus, minus| f32::from(i8::from(keys.pressed(plus)) - i8::from(keys.pressed(minus)));
    let x = along(KeyCode::ArrowRight, KeyCode::ArrowLeft);
    let z = along(KeyCode::ArrowDown, KeyCode::ArrowUp);
    for mut hero in &mut heroes {
        hero.velocity = 2.5 * Vec3::new(x, 0.0, z).clamp_length_max(1.0);
        if keys.just_pressed(KeyCode::Space) {
            hero.jump = 4.0;
        }
    }
}

/// From where the left button was pressed to where it was released, all that moves is cut.
fn slice(
    buttons: Res<ButtonInput<MouseButton>>,
    pointer: glue::Pointer,
    space: SpatialQuery,
    bodies: Query<&RigidBody>,
    mut pressed: Local<Option<Ray>>,
    mut commands: Commands,
) -> Result {
    if buttons.just_pressed(MouseButton::Left) {
        *pressed = pointer.ray();
    }
    let is_over = buttons.just_released(MouseButton::Left);
    let Some((from, to)) = pressed.take_if(|_| is_over).zip(pointer.ray()) else {
        return Ok(());
    };
    // Of a click nothing comes.
    let Ok(blade) = Blade::between(&from, &to) else {
        return Ok(());
    };
    let is_moved = |body| {
        bodies
            .get(body)
            .is_ok_and(|kind| *kind == RigidBody::Dynamic)
    };
    let moved = QueryFilter::all().with_predicate(&is_moved);
    for body in space.overlap_shape(&blade.shape(), &Pose::IDENTITY, &moved)? {
        commands.slice(body, blade.plane());
    }
    Ok(())
}

/// A ball from the camera through the pointer.
fn throw(buttons: Res<ButtonInput<MouseButton>>, pointer: glue::Pointer, mut commands: Commands) {
    if buttons.just_pressed(MouseButton::Right)
        && let Some(ray) = pointer.ray()
    {
        let ball = (RigidBody::Dynamic, icosphere!(0.1, 2), Density(7800.0));
        let at = Transform::from_translation(ray.at(1.0));
        let velocity = LinearVelocity(16.0 * ray.direction());
        let hard = ContactForceEvents { threshold: 5000.0 }; // N
        commands.spawn((ball, at, velocity, hard, Look::Iron));
    }
}

/// A blast of 200 N s at what the pointer is on.
fn explode(
    keys: Res<ButtonInput<KeyCode>>,
    pointer: glue::Pointer,
    space: SpatialQuery,
    mut commands: Commands,
) {
    if keys.just_pressed(KeyCode::KeyE)
        && let Some(ray) = pointer.ray()
        && let Some(hit) = space.cast_ray(&ray, &QueryFilter::all())
    {
        commands.explode(Explosion {
            center: hit.point,
            radius: 3.0,
            impulse: 200.0,
        });
    }
}

fn look_inside(keys: Res<ButtonInput<KeyCode>>, mut store: ResMut<GizmoConfigStore>) {
    if keys.just_pressed(KeyCode::KeyD) {
        store.config_mut::<CleaveGizmos>().0.enabled ^= true;
    }
}

fn slow_down(keys: Res<ButtonInput<KeyCode>>, mut time: ResMut<Time<Virtual>>) {
    if keys.just_pressed(KeyCode::KeyS) {
        let speed = if time.relative_speed() < 1.0 {
            1.0
        } else {
            0.15
        };
        time.set_relative_speed(speed);
    }
}

fn go_back(keys: Res<ButtonInput<KeyCode>>, mut commands: Commands) {
    if keys.just_pressed(KeyCode::KeyB) {
        commands.rewind(128);
    }
}

/// What the player has won.
#[derive(Default, Resource)]
struct Points(usize);

/// A point for each piece, and one for each hard blow of a ball.
fn score(
    mut fractures: MessageReader<Fractured>,
    mut blows: MessageReader<ContactForce>,
    mut windows: Query<&mut Window>,
    mut points: ResMut<Points>,
) {
    let pieces: usize = fractures.read().map(|fracture| fracture.pieces.len()).sum();
    let blows = blows.read().filter(|blow| blow.is_crossing).count();
    if pieces + blows > 0 {
        points.0 += pieces + blows;
    }
    if points.is_changed() {
        for mut window in &mut windows {
            window.title = format!("{} points", points.0);
        }
    }
}

/// What a game has to add today, and nothing else.
mod glue {
    use super::*;
    use bevy::camera::visibility::VisibilityClass;
    use bevy::ecs::entity::EntityHashMap;
    use bevy::ecs::system::SystemParam;
    use bevy::world_serialization::serde::WorldDeserializer;
    use bevy::world_serialization::{DynamicWorld, DynamicWorldBuilder};
    use serde::de::DeserializeSeed;

    const FILE: &str = "target/game.ron";

    /// What draws, smooths, walks and shows inside is each to be asked for, since an app without a window needs none of it.
    pub(crate) fn plugins(app: &mut App) {
        app.add_plugins((
            CleavePlugin::default(),
            InterpolationPlugin,
            WalkerPlugin,
            RewindPlugin::default(),
            CleaveMeshPlugin,
            CleaveGizmosPlugin,
        ));
        let mut store = app.world_mut().resource_mut::<GizmoConfigStore>();
        store.config_mut::<CleaveGizmos>().0.enabled = false;
    }

    /// What is saved: bodies, joints, and what pieces are pieces of.
    type Saved = Or<(With<RigidBody>, With<Joint>, With<Remains>)>;

    fn saved(world: &mut World) -> Vec<Entity> {
        let mut saved = world.query_filtered::<Entity, (Saved, Allow<Disabled>)>();
        saved.iter(world).collect()
    }

    /// Which entities and components are a game is the game's affair, and so is where its files are.
    pub(crate) fn save(world: &mut World) -> Result {
        describe_bodies(world);
        let saved = saved(world);
        let registry = world.resource::<AppTypeRegistry>().read();
        let file = DynamicWorldBuilder::from_world(world, &registry)
            .deny_component::<Mesh3d>()
            .deny_component::<MeshMaterial3d<StandardMaterial>>()
            .deny_component::<VisibilityClass>()
            .deny_component::<Children>()
            .extract_entities(saved.into_iter())
            .build();
        Ok(std::fs::write(FILE, file.serialize(&registry)?)?)
    }

    pub(crate) fn load(world: &mut World) -> Result {
        let file = read(world)?;
        for entity in saved(world) {
            // A joint goes with its bodies.
            let _ = world.try_despawn(entity);
        }
        world.resource_mut::<PhysicsHistory>().clear();
        file.write_to_world(world, &mut EntityHashMap::default())?;
        Ok(())
    }

    fn read(world: &World) -> Result<DynamicWorld> {
        let text = std::fs::read_to_string(FILE)?;
        let type_registry = &world.resource::<AppTypeRegistry>().read();
        let mut assets = world.resource::<AssetServer>();
        let load_from_path = &mut assets;
        let reader = WorldDeserializer {
            type_registry,
            load_from_path,
        };
        Ok(reader.deserialize(&mut ron::Deserializer::from_str(&text)?)?)
    }

    /// Bevy without its picking has no ray of the pointer, and that of its cameras has no end.
    #[derive(SystemParam)]
    pub(crate) struct Pointer<'w, 's> {
        window: Query<'w, 's, &'static Window, With<PrimaryWindow>>,
        camera: Query<'w, 's, (&'static Camera, &'static GlobalTransform)>,
    }

    impl Pointer<'_, '_> {
        pub(crate) fn ray(&self) -> Option<Ray> {
            let (camera, eye) = self.camera.single().ok()?;
            let at = self.window.single().ok()?.cursor_position()?;
            let ray = camera.viewport_to_world(eye, at).ok()?;
            Ray::new(ray.origin, *ray.direction, REACH).ok()
        }
    }
}
