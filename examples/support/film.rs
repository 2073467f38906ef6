//! Scenes that are run, and pictures of some of their moments.

use super::Error;
use super::picture::{Picture, contact_sheet};
use bevy_cleave::prelude::*;
use glam::Vec3;
use std::path::Path;

/// Length of a step, s.
const H: f32 = 1.0 / 60.0;

/// Bodies on a floor at height 0.
pub fn on_floor(bodies: impl IntoIterator<Item = BodyDesc>) -> Result<Simulation, Error> {
    let mut simulation = Simulation::default();
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor)?;
    for body in bodies {
        simulation.bodies.insert(body)?;
    }
    Ok(simulation)
}

/// Runs a scene until the last of four times (s, ascending), writes the pictures that are taken at them to `folder/name.png`, and tells
/// the ledgers of what broke.
pub fn film(
    (folder, name): (&str, &str),
    simulation: &mut Simulation,
    times: [f32; 4],
    picture: impl Fn(&Simulation) -> Picture,
) -> Result<Vec<Ledger>, Error> {
    let (mut pictures, mut ledgers, mut steps) = (Vec::new(), Vec::new(), 0);
    for time in times {
        while steps < (time / H).round() as usize {
            simulation.step(H);
            ledgers.extend(simulation.fractures.done.iter().map(|f| f.ledger));
            steps += 1;
        }
        pictures.push((format!("{name}, t = {time} s"), picture(simulation)));
    }
    contact_sheet(&pictures, 2, 2).save(Path::new(folder).join(format!("{name}.png")))?;
    Ok(ledgers)
}
