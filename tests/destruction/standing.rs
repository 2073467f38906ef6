//! What stands: whatever breaks it, nothing stays that hangs on nothing, and nothing falls that is held.

use crate::common::dice::Dice;
use crate::kit::*;
use bevy_cleave::prelude::*;
use glam::Vec3;
use std::collections::{HashMap, HashSet};

/// What is remembered of a body that stands.
#[derive(Clone)]
struct Known {
    /// The first of what it was part of.
    origin: BodyId,
    /// m.
    reach: f32,
    /// Region of the world in which it is held.
    region: Option<Plane>,
    touches: bool,
}

struct Scene {
    simulation: Simulation,
    known: HashMap<BodyId, Known>,
    whole: f64,
    dropped: f64,
    has_floor: bool,
    /// All that broke.
    broken: HashSet<BodyId>,
}

fn reach_of(size: Vec3) -> f32 {
    0.01 * (size.min_element() * size.max_element()).sqrt()
}

impl Scene {
    fn new(dice: &mut Dice) -> Self {
        let mut simulation = Simulation::default();
        simulation.config.sleep.enabled = dice.below(3) == 0;
        let has_floor = dice.below(4) > 0;
        if has_floor {
            let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
            simulation.bodies.insert(floor).expect("usable");
        }
        let mut scene = Self {
            simulation,
            known: HashMap::new(),
            whole: 0.0,
            dropped: 0.0,
            has_floor,
            broken: HashSet::new(),
        };
        let mut boxes: Vec<(Vec3, Vec3)> = Vec::new();
        for number in 0..1 + dice.below(4) {
            scene.add_wall(dice, &mut boxes, number == 0);
        }
        scene
    }

    /// Adds a body that stands on the floor, or hangs on another one.
    fn add_wall(&mut self, dice: &mut Dice, boxes: &mut Vec<(Vec3, Vec3)>, is_first: bool) {
        let size = Vec3::new(
            dice.in_range(0.3, 3.0),
            dice.in_range(0.5, 2.5),
            dice.in_range(0.1, 0.6),
        );
        let mut at = 0.5 * size.y * Vec3::Y + Vec3::X * 4.0 * boxes.len() as f32;
        let mut hangs = false;
        if !is_first && dice.below(3) > 0 {
            let (below, of) = boxes[dice.below(boxes.len())];
            hangs = true;
            at = match dice.below(2) {
                0 => below + 0.5 * (of.y + size.y) * Vec3::Y,
                _ => {
                    below
                        + 0.5 * (of.z + size.z) * Vec3::Z * [1.0, -1.0][dice.below(2)]
                        + Vec3::Y * 0.5 * size.y
                }
            };
            // Not into anything else.
            let meets = boxes
                .iter()
                .any(|&(c, s)| ((c - at).abs() - 0.5 * (s + size)).max_element() < -1e-4);
            if meets {
                return;
            }
        }
        boxes.push((at, size));
        let shape = match dice.below(3) {
            0 => {
                let cells = match dice.below(2) {
                    0 => FracturePattern::Brick {
                        size: size / dice.in_range(1.8, 4.0),
                    },
                    _ => FracturePattern::Voronoi {
                        cells: 4 + dice.below(20) as u16,
                        focus: 0.0,
                    },
                };
                let strength = 10.0_f32.powf(dice.in_range(3.5, 6.0));
                let cluster = Cluster::cut(&cuboid(size), &cells, 7, strength).expect("cells");
                Shape::Compound(cluster.compound().expect("connected"))
            }
            1 => {
                let half = Vec3::new(0.5 * size.x, size.y, size.z);
                let at = |side: f32| {
                    (
                        Pose::from_position(Vec3::X * 0.25 * side * size.x),
                        cuboid(half),
                    )
                };
                Shape::Compound(Compound::new([at(-1.0), at(1.0)]).expect("two halves"))
            }
            _ => Shape::Convex(cuboid(size)),
        };
        let mut desc = BodyDesc::new(RigidBody::Static, shape);
        desc.pose.position = at;
        let volume = size.element_product();
        let strength = 1000.0 * volume * 10.0_f32.powf(dice.in_range(-2.0, 0.5));
        let is_bonded = matches!(&desc.shape, Shape::Compound(it) if it.is_bonded());
        if !is_bonded || dice.below(4) == 0 {
            desc.fracturable = Some(breakable(dice, strength));
        }
        let slot = self.simulation.bodies.insert(desc).expect("usable");
        let reach = reach_of(size);
        let mut known = Known {
            origin: self.simulation.bodies.id(slot),
            reach,
            region: None,
            touches: true,
        };
        let wants_region = !self.has_floor && !hangs || dice.below(4) == 0;
        if wants_region {
            let height = -0.5 * size.y + dice.in_range(0.05, 0.4) * size.y;
            let mut anchors = if hangs {
                Anchors::touching()
            } else {
                Anchors::none()
            }
            .and_behind(Vec3::Y, height);
            known.touches = hangs;
            if dice.below(2) == 0 {
                known.reach = 0.003;
                anchors = anchors.with_reach(0.003);
            }
            known.region = Some(Plane {
                normal: Vec3::Y,
                offset: at.y + height,
            });
            self.simulation
                .bodies
                .set_anchors(slot, Some(anchors))
                .expect("usable");
        }
        self.known.insert(known.origin, known);
    }

    fn standing(&self) -> Vec<u32> {
        let bodies = &self.simulation.bodies;
        bodies
            .iter()
            .filter(|&s| bodies.kind(s) == RigidBody::Static && is_solid(bodies, s))
            .collect()
    }

    /// Lets something happen to what stands.
    fn disturb(&mut self, dice: &mut Dice) {
        let standing = self.standing();
        let Some(&slot) = standing.get(dice.below(standing.len().max(1))) else {
            return;
        };
        let corners = corners(&self.simulation.bodies, slot);
        let [a, b] = [(); 2].map(|()| corners[dice.below(corners.len())]);
        let target = a.lerp(b, dice.unit());
        match dice.below(5) {
            0 | 1 => {
                let _ = self
                    .simulation
                    .slice(slot, Plane::through(target, dice.direction()));
            }
            2 | 3 => {
                let from = target + 3.0 * (dice.direction() + Vec3::Z * [1.0, -1.0][dice.below(2)]);
                let (mass, speed) = (dice.in_range(1.0, 50.0), dice.in_range(5.0, 60.0));
                let from = from.with_y(from.y.max(0.3));
                let shot = shot(dice, target, from, mass, speed);
                self.whole += f64::from(mass);
                self.simulation.bodies.insert(shot).expect("usable");
            }
            _ => {
                let explosion = Explosion {
                    center: target + 0.5 * dice.direction(),
                    radius: dice.in_range(0.5, 3.0),
                    impulse: 10.0_f32.powf(dice.in_range(1.0, 3.0)),
                };
                self.simulation.bodies.explode(explosion).expect("usable");
            }
        }
    }

    /// Steps, and takes note of pieces.
    fn step(&mut self, h: f32) -> Result<usize, String> {
        self.simulation.step(h);
        self.dropped += check_ledgers(&self.simulation)?;
        let done = std::mem::take(&mut self.simulation.fractures.done);
        self.broken
            .extend(done.iter().map(|fracture| fracture.parent));
        for fracture in &done {
            let Some(known) = self.known.get(&fracture.parent).cloned() else {
                continue;
            };
            for &id in &fracture.ids {
                self.known.insert(id, known.clone());
            }
            let bodies = &self.simulation.bodies;
            for (&slot, &id) in fracture.pieces.iter().zip(&fracture.ids) {
                let is_loose =
                    bodies.is_current(slot, id) && bodies.kind(slot) == RigidBody::Dynamic;
                if is_loose && !fracture.fallen.contains(&slot) && self.is_firm(slot, &known, h) {
                    let at = bodies.center_of_mass(slot);
                    return Err(format!("piece {slot} at {at} fell though it is held"));
                }
            }
            for &slot in fracture.fallen.iter() {
                let bodies = &self.simulation.bodies;
                if bodies.contains(slot)
                    && bodies.kind(slot) == RigidBody::Dynamic
                    && let Some(known) = self.known.get(&bodies.id(slot)).cloned()
                    && self.is_firm(slot, &known, h)
                {
                    return Err(format!(
                        "{slot} at {} was let fall though it is held",
                        bodies.center_of_mass(slot)
                    ));
                }
            }
        }
        // What fell is nobody's piece that stands any more.
        let bodies = &self.simulation.bodies;
        for slot in bodies.iter() {
            if bodies.kind(slot) == RigidBody::Dynamic {
                self.known.remove(&bodies.id(slot));
            }
        }
        Ok(done.len())
    }

    /// Whether a body is surely held by the floor or by its region, were it not for rounding.
    fn is_firm(&self, slot: u32, known: &Known, h: f32) -> bool {
        let bodies = &self.simulation.bodies;
        // Where it was before it moved in this step, unless it is too fast to tell.
        let (v, omega) = bodies.velocity(slot);
        hulls(bodies, slot).iter().any(|(pose, shape)| {
            let at: Vec<Vec3> = shape
                .hull()
                .vertices()
                .iter()
                .map(|&p| pose.transform_point(p) - h * v)
                .collect();
            let least = shape.hull().aabb().extents().min_element();
            if (v.length() + omega.length()) * h > 0.005 * least {
                return false;
            }
            if let Some(region) = known.region {
                let deep = at
                    .iter()
                    .filter(|&&p| region.distance(p) < -0.02 * least - known.reach);
                if deep.count() >= 3 {
                    return true;
                }
            }
            if self.has_floor && known.touches && at.iter().all(|p| p.y > -1e-4) {
                let on: Vec<Vec3> = at.iter().copied().filter(|p| p.y < 1e-5).collect();
                let area = on
                    .iter()
                    .flat_map(|&a| on.iter().map(move |&b| (a, b)))
                    .flat_map(|(a, b)| on.iter().map(move |&c| 0.5 * (b - a).cross(c - a).length()))
                    .fold(0.0_f32, f32::max);
                return area > 0.05 * least * least;
            }
            false
        })
    }

    /// Whether all that stands has a chain of contacts to the floor or a region.
    fn check_nothing_floats(&self) -> Result<(), String> {
        let bodies = &self.simulation.bodies;
        let standing: Vec<u32> = self.standing();
        let shapes: Vec<_> = standing.iter().map(|&s| hulls(bodies, s)).collect();
        let known: Vec<&Known> = standing
            .iter()
            .map(|&s| &self.known[&bodies.id(s)])
            .collect();
        let rough = 1.05;
        let mut held: Vec<bool> = shapes
            .iter()
            .zip(&known)
            .map(|(hulls, known)| {
                hulls.iter().any(|(pose, shape)| {
                    let mut at = shape
                        .hull()
                        .vertices()
                        .iter()
                        .map(|&p| pose.transform_point(p));
                    at.any(|p| {
                        let on_floor =
                            self.has_floor && known.touches && p.y <= rough * known.reach + 1e-5;
                        on_floor
                            || known
                                .region
                                .is_some_and(|r| r.distance(p) <= rough * known.reach + 1e-5)
                    })
                })
            })
            .collect();
        loop {
            let mut is_changed = false;
            for i in 0..standing.len() {
                if held[i] || !known[i].touches {
                    continue;
                }
                let reaches = (0..standing.len()).any(|j| {
                    held[j]
                        && known[j].origin != known[i].origin
                        && gap(&shapes[i], &shapes[j])
                            <= rough * known[i].reach.max(known[j].reach) + 1e-5
                });
                held[i] |= reaches;
                is_changed |= reaches;
            }
            if !is_changed {
                break;
            }
        }
        for (i, &slot) in standing.iter().enumerate() {
            ask!(
                held[i],
                "body {slot} ({} hulls) at {} hangs in the air",
                shapes[i].len(),
                bodies.center_of_mass(slot)
            );
            ask!(
                bodies.velocity(slot) == (Vec3::ZERO, Vec3::ZERO),
                "what stands moves"
            );
        }
        Ok(())
    }
}

/// Least gap between hulls of two bodies, by the normals of faces: never more than it is.
fn gap(a: &[(Pose, ConvexMesh)], b: &[(Pose, ConvexMesh)]) -> f32 {
    let of = |a: &(Pose, ConvexMesh), b: &(Pose, ConvexMesh)| {
        let points = |(pose, shape): &(Pose, ConvexMesh)| -> Vec<Vec3> {
            shape
                .hull()
                .vertices()
                .iter()
                .map(|&p| pose.transform_point(p))
                .collect()
        };
        let one = |a: &(Pose, ConvexMesh), b: &[Vec3]| {
            let faces = a.1.hull().faces().iter().map(|face| {
                let plane = face.plane.in_frame_of(&a.0.inverse());
                b.iter()
                    .map(|&p| plane.distance(p))
                    .fold(f32::INFINITY, f32::min)
            });
            faces.fold(f32::NEG_INFINITY, f32::max)
        };
        one(a, &points(b)).max(one(b, &points(a)))
    };
    a.iter()
        .flat_map(|a| b.iter().map(move |b| of(a, b)))
        .fold(f32::INFINITY, f32::min)
}

pub(crate) fn judge(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let mut scene = Scene::new(dice);
    scene.step(H)?;
    scene.whole = mass(&scene.simulation.bodies);
    scene
        .check_nothing_floats()
        .map_err(|e| format!("from the start: {e}"))?;
    if dice.below(4) == 0 {
        scene.simulation.budget.pieces_per_step = 2 + dice.below(6);
    }
    let mut broken = 0;
    for number in 0..40 {
        if dice.below(4) == 0 {
            scene.disturb(dice);
        }
        let h = if number % 2 == 0 { H } else { 1e-4 };
        broken += scene.step(h).map_err(|e| format!("step {number}: {e}"))?;
        scene
            .check_nothing_floats()
            .map_err(|e| format!("step {number}: {e}"))?;
        let left = mass(&scene.simulation.bodies) + scene.dropped;
        ask!(
            (left - scene.whole).abs() < 3e-6 * scene.whole,
            "step {number}: {left} kg of {} kg",
            scene.whole
        );
    }
    Ok(broken)
}

/// What a static cluster or body held on to is taken away or moved; when it breaks, nothing of it stays that hangs on nothing.
pub(crate) fn judge_removed(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let mut scene = Scene::new(dice);
    scene.step(H)?;
    if dice.below(2) == 0 {
        scene.disturb(dice);
        scene.step(H)?;
    }
    let standing = scene.standing();
    if standing.len() < 2 {
        return Ok(0);
    }
    let gone = standing[dice.below(standing.len())];
    let id = scene.simulation.bodies.id(gone);
    if dice.below(2) == 0 {
        scene.simulation.bodies.remove(gone);
    } else {
        let pose = Pose::from_position(50.0 * Vec3::Y);
        scene
            .simulation
            .bodies
            .set_pose(gone, pose)
            .expect("usable");
        let id = scene.simulation.bodies.id(gone);
        scene.known.get_mut(&id).expect("it stands").region = Some(Plane {
            normal: Vec3::Y,
            offset: 100.0,
        });
    }
    scene.step(H)?;
    // All that is left is cut; what is not in one piece any more stands only if it is held.
    for slot in scene.standing() {
        if scene.simulation.bodies.id(slot) == id {
            continue;
        }
        let corners = corners(&scene.simulation.bodies, slot);
        let [a, b] = [(); 2].map(|()| corners[dice.below(corners.len())]);
        let _ = scene
            .simulation
            .slice(slot, Plane::through(a.lerp(b, 0.5), dice.direction()));
        let explosion = Explosion {
            center: a.lerp(b, 0.5),
            radius: 2.0,
            impulse: 10.0_f32.powf(dice.in_range(1.0, 4.0)),
        };
        scene.simulation.bodies.explode(explosion).expect("usable");
    }
    let whole: Vec<BodyId> = scene
        .standing()
        .iter()
        .map(|&s| scene.simulation.bodies.id(s))
        .collect();
    scene.step(1e-5)?;
    // Whole ones that were left in the air stay there.
    for slot in scene.standing() {
        let id = scene.simulation.bodies.id(slot);
        if whole.contains(&id) && !scene.broken.contains(&id) {
            let everywhere = Plane {
                normal: Vec3::Y,
                offset: 100.0,
            };
            scene.known.get_mut(&id).expect("it stands").region = Some(everywhere);
        }
    }
    scene.check_nothing_floats()?;
    Ok(scene.broken.len())
}

/// A wall that stands on a post alone, both hit in the same step: the post is let break first and the wall fall with it, whatever breaks off of that.
pub(crate) fn judge_felled(seed: u64) -> Verdict {
    let dice = &mut Dice::new(seed);
    let mut simulation = Simulation::default();
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor).expect("usable");
    let size = Vec3::new(dice.in_range(0.6, 2.0), dice.in_range(0.6, 2.0), 0.3);
    let mut post = BodyDesc::new(RigidBody::Static, Shape::Convex(cuboid(size)));
    post.pose.position = 0.5 * size.y * Vec3::Y;
    post.fracturable = Some(Fracturable {
        strength: 10.0,
        pattern: FracturePattern::Planes([Plane::through(Vec3::ZERO, Vec3::Y)].into()),
        ..Default::default()
    });
    simulation.bodies.insert(post).expect("usable");
    let bricks = FracturePattern::Brick {
        size: size / dice.in_range(1.8, 4.0),
    };
    let strength = 10.0_f32.powf(dice.in_range(3.0, 6.0));
    let cluster = Cluster::cut(&cuboid(size), &bricks, 7, strength).expect("cells");
    let cluster = cluster.compound().expect("connected");
    let mut wall = BodyDesc::new(RigidBody::Static, Shape::Compound(cluster));
    wall.pose.position = 1.5 * size.y * Vec3::Y;
    simulation.bodies.insert(wall).expect("usable");
    let mut whole = 2.0 * 1000.0 * f64::from(size.element_product());
    for height in [0.5, 1.9] {
        let target = height * size.y * Vec3::Y;
        let mass = 10.0_f32.powf(dice.in_range(0.5, 2.5));
        let ball = shot(dice, target, target + Vec3::Z, mass, 30.0);
        simulation.bodies.insert(ball).expect("usable");
        whole += f64::from(mass);
    }
    let mut broken = 0;
    for _ in 0..10 {
        simulation.step(1.0 / 60.0);
        whole -= check_ledgers(&simulation)?;
        broken += simulation.fractures.done.len();
    }
    let bodies = &simulation.bodies;
    let solid = bodies.iter().filter(|&slot| is_solid(bodies, slot));
    let left: f64 = solid.map(|slot| f64::from(bodies.mass(slot).mass)).sum();
    ask!(
        (left - whole).abs() < 1e-5 * whole,
        "{left} kg of {whole} are left"
    );
    Ok(broken)
}
