//! Descriptions of scenes that know no engine. Units: metres, kilograms, seconds; y is up.

pub(crate) mod drawn;
mod joint;
mod jointed;
mod library;
pub(crate) mod random;
mod reference;

pub(crate) use joint::{Joint, JointKind, Spring};
pub(crate) use library::{LIBRARY, build};

use glam::{DVec3, Quat, Vec3, vec3};
use parry3d_f64::shape::SharedShape;
use random::Rng;

/// A convex hull whose center of mass is the local origin.
pub(crate) struct Shape {
    pub(crate) points: Vec<Vec3>,
    /// Set when the hull is an axis-aligned box, so that an engine may use its native box.
    pub(crate) half_extents: Option<Vec3>,
}

#[derive(Clone)]
pub(crate) struct Body {
    /// Index into [`Scene::shapes`].
    pub(crate) shape: usize,
    pub(crate) fixed: bool,
    pub(crate) density: f32,
    pub(crate) pos: Vec3,
    pub(crate) rot: Quat,
    pub(crate) linvel: Vec3,
    pub(crate) angvel: Vec3,
    /// Ask for continuous collision where the engine makes it optional.
    pub(crate) bullet: bool,
}

/// What the end state is judged against.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Truth {
    /// Initial poses are an exact equilibrium. `err` = largest displacement \[m\]; fallen beyond `fell`.
    Rest { fell: f32 },
    /// No known answer. `err` = mean penetration of touching pairs \[m\]; fallen if not above the ground between walls at
    /// `walls` \[m\] on both sides of both axes.
    Settle { walls: f32 },
    /// Body 1 is in free fall. `err` = |height error| \[m\] at the end.
    Fall,
    /// Body 1 slides from rest on the ground. `err` = |a − a_exact| / |a_exact|.
    Slide,
    /// Body 0 spins freely. `err` = angle \[rad\] to a double-precision reference orientation at the end.
    FreeRotation,
    /// Body 1 bounces. `err` = relative error of the rebound height, which should be `height`.
    Bounce { height: f32 },
    /// Isolated system. `err` = relative drift of linear and angular momentum (the larger one).
    Isolated,
    /// All dynamic bodies should topple. `err` = fraction still standing.
    Topple,
    /// Body 1 flies along +x at a wall through x = 0. `err` = 1 if it passed.
    Wall,
    /// Joints hold. `err` = largest distance of the two anchors of a joint at the end of a step \[m\].
    Joints,
    /// The center of `body` is at [`Scene::path`] at the end of each step. `err` = largest distance from there, over `scale` \[m\].
    Path { body: usize, scale: f64 },
    /// Body 1 swings about the origin. `err` = relative error of the mean period, which should be `period` \[s\].
    Period { period: f64 },
    /// Energy is kept. `err` = largest difference of the mechanical energy from that at first, over `scale` \[J\].
    Energy { scale: f64 },
}

pub(crate) struct Scene {
    pub(crate) name: String,
    pub(crate) shapes: Vec<Shape>,
    pub(crate) bodies: Vec<Body>,
    /// Joined bodies do not collide with each other.
    pub(crate) joints: Vec<Joint>,
    pub(crate) gravity: Vec3,
    /// One material per scene, so that the engines' different mixing rules agree.
    pub(crate) friction: f32,
    pub(crate) restitution: f32,
    pub(crate) dt: f32,
    pub(crate) steps: usize,
    /// Steps before the timing window opens.
    pub(crate) warmup: usize,
    /// Steps between penetration measurements.
    pub(crate) deep_every: usize,
    pub(crate) truth: Truth,
    /// Exact places after each step, see [`Truth::Path`].
    pub(crate) path: Vec<DVec3>,
}

impl Scene {
    fn new(name: &str, truth: Truth) -> Self {
        Self {
            name: name.into(),
            shapes: vec![],
            bodies: vec![],
            joints: vec![],
            gravity: vec3(0.0, -9.81, 0.0),
            friction: 0.6,
            restitution: 0.0,
            dt: 1.0 / 60.0,
            steps: 600,
            warmup: 60,
            deep_every: 20,
            truth,
            path: vec![],
        }
    }

    fn on_ground(name: &str, truth: Truth) -> Self {
        Self::on_wide_ground(name, truth, 100.0)
    }

    /// On a box whose top is at height 0 and that goes from -`half` to `half` in x and z.
    fn on_wide_ground(name: &str, truth: Truth, half: f32) -> Self {
        let mut s = Self::new(name, truth);
        s.fixed_box(vec3(0.0, -1.0, 0.0), vec3(half, 1.0, half));
        s
    }

    pub(crate) fn num_dynamic(&self) -> usize {
        self.bodies.iter().filter(|b| !b.fixed).count()
    }

    fn boxed(&mut self, half: Vec3) -> usize {
        let points = (0..8)
            .map(|i| half * vec3(sign(i & 1), sign(i >> 1 & 1), sign(i >> 2 & 1)))
            .collect();
        self.shapes.push(Shape {
            points,
            half_extents: Some(half),
        });
        self.shapes.len() - 1
    }

    /// Adds the convex hull of `points`; returns its index and its center of mass, now the local origin.
    fn hull(&mut self, points: &[Vec3]) -> (usize, Vec3) {
        let points: Vec<_> = points.iter().map(|p| p.as_dvec3()).collect();
        let hull = SharedShape::convex_hull(&points).expect("degenerate hull");
        let com = hull.mass_properties(1.0).local_com;
        let poly = hull.as_convex_polyhedron().expect("convex polyhedron");
        let points = poly.points().iter().map(|p| (*p - com).as_vec3()).collect();
        self.shapes.push(Shape {
            points,
            half_extents: None,
        });
        (self.shapes.len() - 1, com.as_vec3())
    }

    /// A random convex hull: 8 to 24 points on an ellipsoid with half axes 0.6 to 1 times `size`.
    fn rock(&mut self, rng: &mut Rng, size: f32) -> usize {
        let axes = vec3(
            rng.range(0.6, 1.0),
            rng.range(0.6, 1.0),
            rng.range(0.6, 1.0),
        ) * size;
        let n = 8 + (rng.unit() * 17.0) as usize;
        let points: Vec<_> = (0..n).map(|_| rng.direction() * axes).collect();
        self.hull(&points).0
    }

    fn add(&mut self, shape: usize, pos: Vec3) -> &mut Body {
        self.bodies.push(Body {
            shape,
            fixed: false,
            density: 1000.0,
            pos,
            rot: Quat::IDENTITY,
            linvel: Vec3::ZERO,
            angvel: Vec3::ZERO,
            bullet: false,
        });
        self.bodies.last_mut().unwrap()
    }

    fn fixed_box(&mut self, pos: Vec3, half: Vec3) {
        let shape = self.boxed(half);
        self.add(shape, pos).fixed = true;
    }

    fn pyramid_at(&mut self, shape: usize, half: f32, base: usize, origin: Vec3) {
        for row in 0..base {
            for i in 0..base - row {
                let x = (i as f32 - 0.5 * (base - row - 1) as f32) * 2.2 * half;
                self.add(shape, origin + vec3(x, half * (2 * row + 1) as f32, 0.0));
            }
        }
    }
}

fn sign(bit: usize) -> f32 {
    if bit == 0 { -1.0 } else { 1.0 }
}
