//! A boulder that falls on an edge of rock.

use super::{Stage, recipes};
use crate::shapes;
use bevy::prelude::*;

pub(super) fn put_up(stage: &mut Stage, at: Vec3) -> Result {
    let plinth = stage.looks.plinth.clone();
    stage.fix(Vec3::new(1.2, 0.5, 0.9), at + 0.25 * Vec3::Y, &plinth)?;
    let place = Transform::from_translation(at + Vec3::new(0.1, 4.5, 0.0))
        .with_rotation(Quat::from_rotation_z(0.5));
    let granite = stage.looks.granite.clone();
    stage.put(
        shapes::boulder(0.75)?,
        place,
        2650.0,
        recipes::stone(),
        &granite,
    );
    Ok(())
}
