//! Where it all stands: floor, light and camera.

use bevy::camera::Hdr;
use bevy::light::{CascadeShadowConfigBuilder, DirectionalLightShadowMap};
use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// The color that the floor fades into.
const BACKDROP: Color = Color::linear_rgb(0.92, 0.97, 1.04);

/// What the camera looks at, and from where.
#[derive(Clone, Copy, Resource)]
pub(crate) struct View {
    pub(crate) target: Vec3,
    /// From the target, rad about y; 0 looks along -z.
    pub(crate) yaw: f32,
    /// Above the horizon, rad.
    pub(crate) pitch: f32,
    /// m.
    pub(crate) distance: f32,
}

impl Default for View {
    fn default() -> Self {
        Self {
            target: Vec3::new(0.0, 0.75, 0.0),
            yaw: 0.32,
            pitch: 0.26,
            distance: 4.8,
        }
    }
}

impl View {
    /// The camera's pose.
    pub(crate) fn transform(&self) -> Transform {
        let turn = Quat::from_euler(EulerRot::YXZ, self.yaw, -self.pitch, 0.0);
        let eye = self.target + turn * (self.distance * Vec3::Z);
        Transform::from_translation(eye).looking_at(self.target, Vec3::Y)
    }
}

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<View>()
        .insert_resource(ClearColor(BACKDROP))
        .insert_resource(DirectionalLightShadowMap { size: 2048 })
        .add_systems(Startup, (build_floor, light, set_camera))
        .add_systems(Update, (orbit, follow_view).chain());
}

fn build_floor(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let floor = StandardMaterial {
        base_color: Color::srgb(0.62, 0.63, 0.65),
        perceptual_roughness: 0.75,
        reflectance: 0.3,
        ..default()
    };
    commands.spawn((
        RigidBody::Static,
        HalfSpaceShape { normal: Vec3::Y },
        Mesh3d(meshes.add(Plane3d::new(Vec3::Y, Vec2::splat(80.0)))),
        MeshMaterial3d(materials.add(floor)),
    ));
}

fn light(mut commands: Commands) {
    let shadows = CascadeShadowConfigBuilder {
        num_cascades: 1,
        maximum_distance: 16.0,
        ..default()
    };
    commands.spawn((
        DirectionalLight {
            color: Color::srgb(1.0, 0.95, 0.88),
            illuminance: 10_500.0,
            shadow_maps_enabled: true,
            ..default()
        },
        shadows.build(),
        Transform::from_xyz(-3.5, 6.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}

fn set_camera(mut commands: Commands, view: Res<View>, mut images: ResMut<Assets<Image>>) {
    let sky = EnvironmentMapLight::hemispherical_gradient(
        &mut images,
        Color::srgb(0.86, 0.91, 1.0),
        BACKDROP,
        Color::srgb(0.36, 0.34, 0.33),
    );
    commands.spawn((
        Camera3d::default(),
        Hdr,
        Msaa::Off,
        bevy::anti_alias::fxaa::Fxaa::default(),
        Projection::Perspective(PerspectiveProjection {
            fov: 0.62,
            ..default()
        }),
        DistanceFog {
            color: BACKDROP,
            falloff: FogFalloff::Linear {
                start: 7.0,
                end: 22.0,
            },
            ..default()
        },
        EnvironmentMapLight {
            intensity: 900.0,
            ..sky
        },
        view.transform(),
    ));
}

/// Arrow keys go around what is looked at, Page Up and Page Down go nearer and farther.
fn orbit(keys: Res<ButtonInput<KeyCode>>, time: Res<Time<Real>>, mut view: ResMut<View>) {
    let axis = |minus, plus| {
        f32::from(u8::from(keys.pressed(plus))) - f32::from(u8::from(keys.pressed(minus)))
    };
    let around = axis(KeyCode::ArrowLeft, KeyCode::ArrowRight);
    let up = axis(KeyCode::ArrowDown, KeyCode::ArrowUp);
    let away = axis(KeyCode::PageUp, KeyCode::PageDown);
    if (around, up, away) == (0.0, 0.0, 0.0) {
        return;
    }
    let speed = time.delta_secs();
    view.yaw += 1.2 * speed * around;
    view.pitch = (view.pitch + 0.9 * speed * up).clamp(0.03, 1.4);
    view.distance = (view.distance * ops::exp(1.5 * speed * away)).clamp(2.0, 20.0);
}

fn follow_view(view: Res<View>, mut camera: Query<&mut Transform, With<Camera3d>>) {
    if view.is_changed() {
        for mut transform in &mut camera {
            *transform = view.transform();
        }
    }
}
