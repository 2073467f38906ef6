//! Scenes run: the simulation of a scene, and what can be measured of it from outside, in `f64`.

use super::scene::{Actor, Form, Ground, Scene};
use super::solid::{Solid, above, plane_of};
use bevy_cleave::prelude::*;
use glam::{DMat3, DVec3};

/// A scene that runs.
pub(crate) struct Run<'s> {
    pub(crate) scene: &'s Scene,
    pub(crate) simulation: Simulation,
    /// Slot of each actor.
    pub(crate) slots: Vec<u32>,
    /// Shape of each actor.
    shapes: Vec<Shape>,
    /// Whether a body was ever left out.
    pub(crate) had_problems: bool,
}

impl<'s> Run<'s> {
    /// Sets the scene up with default settings but for sleep; `None` if a body's numbers are not usable.
    pub(crate) fn new(scene: &'s Scene, sleeps: bool) -> Option<Self> {
        let mut simulation = Simulation {
            gravity: Gravity(scene.gravity),
            ..Simulation::default()
        };
        if !sleeps {
            simulation.config.sleep = SleepConfig::off();
        }
        if scene.soft > 0 {
            simulation.config.method = SoftStep {
                min_substeps: scene.soft,
                max_substeps: scene.soft,
                tolerance: None,
                ..SoftStep::default()
            }
            .into();
        }
        let (mut slots, mut shapes) = (Vec::new(), Vec::new());
        for actor in &scene.actors {
            let desc = actor.desc()?;
            shapes.push(desc.shape.clone());
            slots.push(simulation.bodies.insert(desc).ok()?);
        }
        Some(Self {
            scene,
            simulation,
            slots,
            shapes,
            had_problems: false,
        })
    }

    pub(crate) fn step(&mut self) {
        self.simulation.step(self.scene.step_length());
        self.had_problems |= !self.simulation.report.problems.is_empty();
    }

    /// Computes the masses of the bodies, which are known only after the mass phase of a step.
    pub(crate) fn weigh(&mut self) {
        let Simulation { bodies, report, .. } = &mut self.simulation;
        bevy_cleave::step::mass_properties(bodies, report);
        self.had_problems |= !report.problems.is_empty();
    }

    /// Number and slot of the dynamic bodies.
    pub(crate) fn dynamic(&self) -> impl Iterator<Item = (usize, u32, &Actor)> + '_ {
        let actors = self.scene.actors.iter().zip(&self.slots).enumerate();
        actors
            .filter(|(_, (actor, _))| actor.is_dynamic())
            .map(|(i, (actor, &slot))| (i, slot, actor))
    }

    /// State of a body.
    pub(crate) fn state(&self, slot: u32) -> State {
        let bodies = &self.simulation.bodies;
        let (linear, angular) = bodies.velocity(slot);
        State {
            center: bodies.center_of_mass(slot).as_dvec3(),
            pose: bodies.pose(slot),
            linear: linear.as_dvec3(),
            angular: angular.as_dvec3(),
        }
    }

    /// Mass (kg) and inertia about the center of mass, world axes, kg m2.
    pub(crate) fn inertia(&self, slot: u32) -> (f64, DMat3) {
        let mass = self.simulation.bodies.mass(slot);
        let rotation = self.simulation.bodies.pose(slot).rotation.as_dquat();
        let turn = DMat3::from_quat(rotation.normalize());
        let inertia = mass.inertia().as_dmat3();
        (f64::from(mass.mass), turn * inertia * turn.transpose())
    }

    fn shape(&self, slot: u32) -> &Shape {
        let actor = self.slots.iter().position(|&it| it == slot);
        &self.shapes[actor.expect("a body of the scene")]
    }

    /// Least extent of a body's box, or that of its thinnest part, and its largest distance from its center of mass, m.
    pub(crate) fn size(&self, slot: u32) -> (f64, f64) {
        let bodies = &self.simulation.bodies;
        let center = bodies.mass(slot).center;
        let (mut least, mut far) = (f32::INFINITY, 0.0_f32);
        let mut add = |mesh: &ConvexMesh, pose: &Pose| {
            least = least.min(mesh.aabb().extents().min_element());
            let corners = mesh.hull().vertices().iter();
            far = corners.fold(far, |far, v| {
                far.max(pose.transform_point(*v).distance(center))
            });
        };
        match self.shape(slot) {
            Shape::Convex(mesh) => add(mesh, &Pose::IDENTITY),
            Shape::Compound(compound) => {
                let parts = compound.parts().iter();
                parts.for_each(|part| add(&part.shape, &part.pose));
            }
            Shape::HalfSpace(_) | Shape::Level(_) => return (0.0, 0.0),
        }
        (f64::from(least), f64::from(far))
    }

    /// The body as it lies, or nothing for a half-space.
    pub(crate) fn solid(&self, slot: u32) -> Option<Solid> {
        Solid::of(self.shape(slot), &self.simulation.bodies.pose(slot))
    }

    /// All bodies as they lie.
    pub(crate) fn solids(&self) -> Vec<Option<Solid>> {
        self.slots.iter().map(|&slot| self.solid(slot)).collect()
    }

    /// How far a body is from another, m, below zero where they overlap; exact only below `enough`.
    pub(crate) fn gap(&self, solids: &[Option<Solid>], i: usize, j: usize, enough: f64) -> f64 {
        match (&solids[i], &solids[j]) {
            (Some(a), Some(b)) => a.separation(b, enough),
            (Some(solid), None) => self.gap_to_plane(solid, j),
            (None, Some(solid)) => self.gap_to_plane(solid, i),
            (None, None) => f64::INFINITY,
        }
    }

    fn gap_to_plane(&self, solid: &Solid, plane: usize) -> f64 {
        let pose = self.simulation.bodies.pose(self.slots[plane]);
        match &self.scene.actors[plane].form {
            Form::HalfSpace(normal) => {
                let (point, normal) = plane_of(&pose, *normal);
                above(solid, point, normal)
            }
            Form::Ground(ground) => above_ground(solid, ground, &pose),
            _ => f64::INFINITY,
        }
    }
}

/// How far a body is above a ground: corners of one from faces of the other, m.
fn above_ground(solid: &Solid, ground: &Ground, pose: &Pose) -> f64 {
    let turn = pose.rotation.as_dquat().normalize();
    let at = pose.position.as_dvec3();
    let corners = solid
        .corners()
        .map(|corner| ground.below(turn.inverse() * (corner - at)));
    let points = ground
        .points()
        .map(|point| solid.outside(turn * point + at));
    corners.chain(points).fold(f64::INFINITY, f64::min)
}

/// Motion of a body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State {
    /// Centre of mass, m.
    pub(crate) center: DVec3,
    pub(crate) pose: Pose,
    /// m/s.
    pub(crate) linear: DVec3,
    /// rad/s.
    pub(crate) angular: DVec3,
}

impl State {
    pub(crate) fn is_finite(&self) -> bool {
        self.center.is_finite() && self.linear.is_finite() && self.angular.is_finite()
    }
}
