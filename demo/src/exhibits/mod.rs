//! What there is to slice and to break. Each exhibit is a function that puts it up; a key and a button for each.

mod brick;
mod concrete;
mod figurine;
mod furniture;
mod glass;
mod recipes;
mod stone;
mod tower;
mod wood;
mod wrecking;

use crate::look::{INSIDE, Look, Looks};
use crate::shapes;
use crate::studio::View;
use bevy::prelude::*;
use bevy_cleave::prelude::*;

/// What stands in the studio.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Exhibit {
    /// A wall, a pane, a figurine.
    #[default]
    All,
    Glass,
    Brick,
    Wood,
    Stone,
    Concrete,
    Figurine,
    Furniture,
    Wrecking,
    Tower,
}

impl Exhibit {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::All => "All",
            Self::Glass => "Glass",
            Self::Brick => "Brick",
            Self::Wood => "Wood",
            Self::Stone => "Stone",
            Self::Concrete => "Concrete",
            Self::Figurine => "Figurine",
            Self::Furniture => "Table",
            Self::Wrecking => "Chain",
            Self::Tower => "Tower",
        }
    }

    fn put_up(self, stage: &mut Stage) -> Result {
        match self {
            Self::All => {
                brick::put_up(stage, Vec3::new(-1.15, 0.0, -0.7))?;
                glass::put_up(stage, Vec3::new(1.05, 0.0, 0.0))?;
                figurine::put_up(stage, Vec3::new(-0.35, 0.0, 0.85))
            }
            Self::Glass => glass::put_up(stage, Vec3::ZERO),
            Self::Brick => brick::put_up(stage, Vec3::ZERO),
            Self::Wood => wood::put_up(stage, Vec3::ZERO),
            Self::Stone => stone::put_up(stage, Vec3::ZERO),
            Self::Concrete => concrete::put_up(stage, Vec3::ZERO),
            Self::Figurine => figurine::put_up(stage, Vec3::ZERO),
            Self::Furniture => furniture::put_up(stage, Vec3::ZERO),
            Self::Wrecking => wrecking::put_up(stage, Vec3::ZERO),
            Self::Tower => tower::put_up(stage, Vec3::ZERO),
        }
    }

    /// Where it is looked at from.
    fn view(self) -> View {
        let from = |height: f32, distance: f32| View {
            target: height * Vec3::Y,
            distance,
            ..View::default()
        };
        match self {
            Self::All => from(0.62, 4.9),
            Self::Glass => from(0.72, 3.1),
            Self::Brick => from(0.62, 4.0),
            Self::Wood => from(0.5, 3.4),
            Self::Stone => from(0.75, 5.6),
            Self::Concrete => from(0.68, 4.2),
            Self::Figurine => from(0.68, 3.1),
            Self::Furniture => from(0.45, 3.8),
            Self::Wrecking => View {
                yaw: 0.75,
                ..from(1.3, 7.0)
            },
            Self::Tower => from(0.85, 5.6),
        }
    }
}

/// Puts an exhibit in the place of what is there.
#[derive(Clone, Copy, Message)]
pub(crate) struct Show(pub(crate) Exhibit);

/// What is shown now.
#[derive(Default, Resource)]
pub(crate) struct Shown(pub(crate) Exhibit);

pub(crate) fn plugin(app: &mut App) {
    app.init_resource::<Shown>()
        .add_message::<Show>()
        .add_systems(Startup, |mut show: MessageWriter<Show>| {
            show.write(Show(Exhibit::default()));
        })
        .add_systems(Update, show);
}

fn show(
    mut commands: Commands,
    mut requests: MessageReader<Show>,
    mut shown: ResMut<Shown>,
    mut view: ResMut<View>,
    looks: Res<Looks>,
    mut history: ResMut<PhysicsHistory>,
    bodies: Query<Entity, (With<RigidBody>, With<DrawShape>)>,
) -> Result {
    let Some(&Show(exhibit)) = requests.read().last() else {
        return Ok(());
    };
    for body in &bodies {
        commands.entity(body).despawn();
    }
    history.clear();
    shown.0 = exhibit;
    *view = exhibit.view();
    let mut stage = Stage {
        commands: &mut commands,
        looks: &looks,
    };
    exhibit.put_up(&mut stage)
}

/// Spawns bodies for an exhibit.
struct Stage<'s, 'w, 'c> {
    commands: &'s mut Commands<'w, 'c>,
    looks: &'s Looks,
}

impl Stage<'_, '_, '_> {
    /// A body that breaks by `recipe`, in pieces that show what is inside.
    fn put(
        &mut self,
        shape: impl Bundle,
        at: Transform,
        density: f32,
        recipe: Fracturable,
        look: &Look,
    ) -> Entity {
        let recipe = Fracturable {
            cut_material: Some(INSIDE),
            ..recipe
        };
        let body = (
            RigidBody::Dynamic,
            shape,
            at,
            Density(density),
            recipe,
            look.clone(),
        );
        self.commands.spawn(body).id()
    }

    /// Something of iron, which does not break.
    fn hang(&mut self, shape: ConvexMesh, at: Vec3, turn: Quat, density: f32) -> Entity {
        let at = Transform::from_translation(at).with_rotation(turn);
        let body = (RigidBody::Dynamic, shape, at, Density(density));
        self.commands.spawn((body, self.looks.iron.clone())).id()
    }

    /// A block that stays where it is.
    fn fix(&mut self, size: Vec3, at: Vec3, look: &Look) -> Result<Entity> {
        let shape = shapes::block(size, 0.006)?;
        Ok(self.stand(shape, at, look))
    }

    /// What stands.
    fn stand(&mut self, shape: impl Bundle, at: Vec3, look: &Look) -> Entity {
        let at = Transform::from_translation(at);
        let body = (RigidBody::Static, shape, at, look.clone());
        self.commands.spawn(body).id()
    }
}
