//! What the fractures and the steps did to mass, momentum and energy.

use bevy_cleave::prelude::*;
use glam::Vec3;

/// Sums over a run.
#[derive(Debug, Default)]
pub(crate) struct Books {
    /// By number of fractures that had to happen before: of bricks, of their pieces, and so on.
    generations: Vec<usize>,
    /// By slot: id, and number of fractures that the body comes from.
    depth: Vec<Option<(BodyId, usize)>>,
    ledgers: Vec<Ledger>,
    /// Mass of the dynamic bodies, kg.
    mass: f64,
    /// Of the bodies that were there at the first step, and of what came in since.
    mass_in: f64,
    /// Kinetic and potential energy of the dynamic bodies, J, with what comes in at the next step.
    energy: f64,
    /// As with the mass.
    energy_in: f64,
    /// Largest rise of the energy in one step, J.
    largest_rise: f64,
}

impl Books {
    /// Notes a body that joins in the next step.
    pub(crate) fn brought_in(&mut self, body: &BodyDesc) {
        if let Shape::Convex(mesh) = &body.shape {
            let mass = mesh.hull().volume() * f64::from(body.density);
            let speed = f64::from(body.linear_velocity.length());
            let energy = 0.5 * mass * speed * speed + potential(mass, body.pose.position);
            self.mass_in += mass;
            self.energy_in += energy;
            self.energy += energy;
        }
    }

    /// Notes what a step has done.
    pub(crate) fn close(&mut self, bodies: &Bodies, done: &[Fracture]) {
        self.depth.resize(bodies.slots(), None);
        for fracture in done {
            let known = self.depth[fracture.parent_slot as usize];
            let depth = known.filter(|&(id, _)| id == fracture.parent);
            let depth = depth.map_or(0, |(_, depth)| depth);
            self.generations
                .resize(self.generations.len().max(depth + 1), 0);
            self.generations[depth] += 1;
            for (&slot, &id) in fracture.pieces.iter().zip(&fracture.ids) {
                self.depth[slot as usize] = Some((id, depth + 1));
            }
            self.ledgers.push(fracture.ledger);
        }
        let (mut mass, mut energy) = (0.0, 0.0);
        let is_dynamic = |&slot: &u32| bodies.kind(slot) == RigidBody::Dynamic;
        for slot in bodies.iter().filter(is_dynamic) {
            let m = f64::from(bodies.mass(slot).mass);
            mass += m;
            energy += bodies.kinetic_energy(slot) + potential(m, bodies.center_of_mass(slot));
        }
        if self.mass == 0.0 {
            (self.mass_in, self.energy_in, self.energy) = (mass, energy, energy);
        }
        self.mass = mass;
        self.largest_rise = self.largest_rise.max(energy - self.energy);
        self.energy = energy;
    }

    pub(crate) fn print(&self) {
        let worst = |error: fn(&Ledger) -> f64| {
            let errors = self.ledgers.iter().map(error);
            errors.fold(f64::NEG_INFINITY, f64::max)
        };
        let dropped: u32 = self.ledgers.iter().map(|l| l.dropped_pieces).sum();
        let dropped_mass: f64 = self.ledgers.iter().map(|l| l.dropped.mass).sum();
        let mass_error = (self.mass + dropped_mass - self.mass_in) / self.mass_in;
        println!("fractures: {}", self.ledgers.len());
        println!("fractures_by_generation: {:?}", self.generations);
        println!("dropped_slivers: {dropped}");
        println!("dropped_mass_rel: {:.2e}", dropped_mass / self.mass_in);
        println!("mass_error_rel: {mass_error:.2e}");
        println!("ledger_mass_error_worst: {:.2e}", worst(Ledger::mass_error));
        println!(
            "ledger_momentum_error_worst: {:.2e}",
            worst(Ledger::momentum_error)
        );
        println!(
            "ledger_angular_momentum_error_worst: {:.2e}",
            worst(Ledger::angular_momentum_error)
        );
        println!(
            "ledger_energy_gain_worst: {:.2e}",
            worst(Ledger::energy_gain)
        );
        println!(
            "energy_rise_of_a_step_rel: {:.2e}",
            self.largest_rise / self.energy_in
        );
    }
}

/// Of a mass (kg) at a place, above the floor, J.
fn potential(mass: f64, place: Vec3) -> f64 {
    -mass * Gravity::default().0.as_dvec3().dot(place.as_dvec3())
}
