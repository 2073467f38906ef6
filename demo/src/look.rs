//! What bodies look like: a material for the outside of each, and one for the faces that cuts lay open.

use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// Material slots of a body's mesh.
pub(crate) const OUTSIDE: u16 = 0;
/// Slot of the faces of cuts.
pub(crate) const INSIDE: u16 = 1;
/// Slots of stones of one body that are not of one color.
pub(crate) const SHADES: [u16; 3] = [OUTSIDE, 2, 3];

/// What a body is drawn with; its pieces have it too.
#[derive(Bundle, Clone)]
pub(crate) struct Look {
    outside: MeshMaterial3d<StandardMaterial>,
    shape: DrawShape,
}

impl Look {
    fn new(outside: Handle<StandardMaterial>, inside: Handle<StandardMaterial>) -> Self {
        Self {
            outside: MeshMaterial3d(outside),
            shape: DrawShape::new().with_slot(INSIDE, MeshMaterial3d(inside)),
        }
    }

    fn with_slot(self, slot: u16, material: Handle<StandardMaterial>) -> Self {
        let shape = self.shape.with_slot(slot, MeshMaterial3d(material));
        Self { shape, ..self }
    }
}

/// Of glass, whose pieces are of several tints: a cut that is seen from its edge would not be seen at all.
#[derive(Clone, Component)]
pub(crate) struct Tinted;

/// All looks that there are.
#[derive(Resource)]
pub(crate) struct Looks {
    pub(crate) glass: Look,
    /// Of its pieces.
    tints: [MeshMaterial3d<StandardMaterial>; 3],
    pub(crate) frame: Look,
    /// A few shades, so that no wall is of one color.
    pub(crate) bricks: Vec<Look>,
    pub(crate) laths: Vec<Look>,
    pub(crate) granite: Look,
    pub(crate) concrete: Look,
    /// Bars of steel in it.
    pub(crate) rebar: Look,
    pub(crate) porcelain: Look,
    pub(crate) iron: Look,
    pub(crate) plinth: Look,
    /// In [`SHADES`].
    pub(crate) sandstone: Look,
}

pub(crate) fn plugin(app: &mut App) {
    app.add_systems(PreStartup, mix).add_systems(Update, tint);
}

/// Gives the pieces of glass that came together tints in turn.
fn tint(
    mut pieces: Query<&mut MeshMaterial3d<StandardMaterial>, (With<Tinted>, Added<PieceOf>)>,
    looks: Res<Looks>,
) {
    for (mut material, tint) in pieces.iter_mut().zip(looks.tints.iter().cycle()) {
        material.clone_from(tint);
    }
}

fn mix(mut commands: Commands, mut materials: ResMut<Assets<StandardMaterial>>) {
    let mut add = |color: Color, roughness: f32, metallic: f32| {
        materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: roughness,
            metallic,
            ..default()
        })
    };
    let mut look = |outside: [f32; 3], inside: [f32; 3], roughness: f32| {
        let outside = add(Color::srgb_from_array(outside), roughness, 0.0);
        Look::new(outside, add(Color::srgb_from_array(inside), 0.9, 0.0))
    };
    let bricks = [
        [0.62, 0.28, 0.20],
        [0.56, 0.24, 0.18],
        [0.67, 0.33, 0.24],
        [0.52, 0.25, 0.21],
    ];
    let bricks = bricks.map(|outside| look(outside, [0.83, 0.52, 0.40], 0.85));
    let laths = [[0.55, 0.36, 0.19], [0.50, 0.32, 0.16], [0.60, 0.41, 0.23]];
    let laths = laths.map(|outside| look(outside, [0.88, 0.74, 0.52], 0.6));
    let frame = look([0.16, 0.18, 0.21], [0.3, 0.3, 0.3], 0.45);
    let granite = look([0.36, 0.37, 0.39], [0.66, 0.63, 0.60], 0.8);
    let concrete = look([0.60, 0.59, 0.57], [0.67, 0.66, 0.63], 0.9);
    let rebar = look([0.36, 0.20, 0.12], [0.36, 0.20, 0.12], 0.6);
    let porcelain = look([0.93, 0.91, 0.86], [0.80, 0.33, 0.22], 0.25);
    let plinth = look([0.78, 0.77, 0.75], [0.8, 0.8, 0.8], 0.7);
    let iron = add(Color::srgb(0.55, 0.56, 0.58), 0.28, 1.0);
    let iron = Look::new(iron.clone(), iron);
    let shades = [[0.76, 0.64, 0.45], [0.70, 0.58, 0.41], [0.80, 0.69, 0.51]];
    let [first, second, third] = shades.map(|shade| add(Color::srgb_from_array(shade), 0.9, 0.0));
    let sandstone = Look::new(first.clone(), first)
        .with_slot(SHADES[1], second)
        .with_slot(SHADES[2], third);
    let mut glass = |color: Color| {
        materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: 0.06,
            reflectance: 0.7,
            alpha_mode: AlphaMode::Blend,
            double_sided: true,
            cull_mode: None,
            ..default()
        })
    };
    // The edge of a pane is seen along its width: dark and green.
    let edge = glass(Color::srgba(0.25, 0.66, 0.58, 0.85));
    let tints = [0.40, 0.16, 0.28].map(|alpha| glass(Color::srgba(0.62, 0.86, 0.84, alpha)));
    commands.insert_resource(Looks {
        glass: Look::new(tints[2].clone(), edge),
        tints: tints.map(MeshMaterial3d),
        frame,
        bricks: bricks.into(),
        laths: laths.into(),
        granite,
        concrete,
        rebar,
        porcelain,
        iron,
        plinth,
        sandstone,
    });
}
