//! The instant of a blow: bodies, bonds and what hits, followed in time.

use crate::cluster::hit::{Hit, Striker};
use crate::cluster::link::{Link, length};
use crate::cluster::moving_part::Body;
use crate::cluster::network::Network;
use glam::{Mat3, Vec3, Vec4};

/// Share of what it bears up to which a bond to parts that stay where they are may be loaded, at most.
const HEARD: f32 = 0.25;

/// Time steps at most: several times as long as a vibration goes from the blow to the outermost part and back.
pub(super) const MOST_STEPS: usize = 768;

/// Time steps from one look at the energy to the next.
const STEPS_PER_LOOK: usize = 8;

/// Looks after which it is over if nothing has yielded and the springs have not come to hold more: longer than the slowest vibration of a
/// part against its neighbors.
const CALM_LOOKS: usize = 8;

/// How many times as fast as most parts one may vibrate. A part that is much smaller than its neighbors is lighter, and its bonds are stiffer: a slice
/// of a hundredth of a brick would make time steps of a hundredth, so that the blow would not get far in as many as there may be. It is followed as a
/// larger one.
const QUICKEST: f32 = 4.0;

/// Length of a time step, as a share of the reciprocal of the highest angular frequency. The limit of stability is 2.
const STEP_SHARE: f32 = 1.0;

const NONE: u32 = u32::MAX;

/// What hits.
#[derive(Debug)]
struct Hitting {
    striker: Striker,
    body: u32,
    arm: Vec3,
    /// Along its direction, m/s.
    speed: f32,
    /// From the part, m.
    gap: f32,
}

/// The instant of a blow.
pub(super) struct Instant {
    bodies: Vec<Body>,
    pub(super) links: Vec<Link>,
    hitting: Vec<Hitting>,
    friction: f32,
    /// Share of what it bears up to which a bond to parts that stay where they are may be loaded.
    heard: f32,
    step: f32,
    /// Taken by the bonds, J.
    pub(super) work: f32,
    /// Bonds times time steps.
    pub(super) followed: usize,
    /// Velocity of something that stands, in which frame energies are told; none if nothing does.
    standing: Option<Vec3>,
}

impl Instant {
    /// Of these parts; all others stay where they are. `endurance`: see [`Link::of`].
    pub(super) fn new(
        network: &Network,
        (hit, endurance): (Hit, f32),
        is_held: &impl Fn(u32) -> bool,
        members: &[u32],
    ) -> Self {
        let mut number = vec![NONE; network.nodes.len()];
        for (index, &part) in (0..).zip(members) {
            number[part as usize] = index;
        }
        let outside = members.len() as u32;
        let parts = members.iter();
        let parts = parts.map(|&part| Body::of(network, part, is_held(part)));
        let mut bodies: Vec<Body> = parts.collect();
        for push in hit.pushes {
            bodies[number[push.part as usize] as usize].take(push);
        }
        bodies.push(Body::FIXED);
        let place = |part: u32| number[part as usize].min(outside);
        let mut links: Vec<Link> = Vec::new();
        for &part in members {
            for &bond in network.bonds_of(part) {
                let other = place(network.other(bond, part));
                // Each once: from the member that comes first.
                if place(part) < other {
                    links.push(Link::of(network, bond, endurance, place));
                }
            }
        }
        let hitting = hit.strikers.iter().map(|striker| Hitting {
            striker: *striker,
            body: place(striker.part),
            arm: striker.point - network.nodes[striker.part as usize].center.as_vec3(),
            speed: striker.speed,
            gap: 0.0,
        });
        let is_free = members.len() == network.nodes.len();
        let mut taking = bodies[..members.len()].iter();
        let any_fixed = taking.any(|body| body.inverse_mass == 0.0);
        let mut strikers = hit.strikers.iter();
        let wall = strikers.find(|striker| striker.inverse_mass == 0.0);
        let standing = if any_fixed || !is_free {
            Some(Vec3::ZERO)
        } else {
            wall.map(|striker| striker.speed * striker.direction)
        };
        let mut instant = Self {
            step: tame(&mut bodies, &mut links),
            bodies,
            links,
            hitting: hitting.collect(),
            friction: network.friction,
            heard: HEARD.min(endurance),
            work: 0.0,
            followed: 0,
            standing,
        };
        instant.hit();
        instant
    }

    /// Follows the motion; whether no part that does not take part has heard of it, if somebody `asks`.
    pub(super) fn run(&mut self, asks: bool) -> bool {
        let (mut most, mut work, mut calm) = (0.0f32, 0.0, 0);
        for step in 0..MOST_STEPS {
            if step % STEPS_PER_LOOK == 0 {
                if asks && self.is_heard_outside() {
                    return false;
                }
                let held = self.held_energy();
                let is_calm = held <= most && self.work == work;
                calm = if is_calm { calm + 1 } else { 0 };
                if calm > CALM_LOOKS || self.is_over(held) {
                    break;
                }
                (most, work) = (most.max(held), self.work);
            }
            self.followed += self.links.len();
            for index in 0..self.links.len() {
                self.pull(index);
            }
            for body in &mut self.bodies {
                body.advance(self.step);
            }
            self.hit();
        }
        true
    }

    /// Whether a bond to a part that does not take part is loaded.
    fn is_heard_outside(&self) -> bool {
        let outside = self.bodies.len() as u32 - 1;
        let outer = self.links.iter();
        let outer = outer.filter(|link| !link.is_broken && link.bodies.contains(&outside));
        outer.into_iter().any(|link| {
            let parts = link.bodies.map(|body| &self.bodies[body as usize]);
            let heard = self.heard * link.limits[0].min(link.limits[1]) / link.stiffness;
            let moved = length(link.corners.moved(parts));
            moved.cmpgt(Vec4::splat(heard)).any()
        })
    }

    /// Forces of a bond, and what they break.
    fn pull(&mut self, index: usize) {
        let link = &mut self.links[index];
        let [a, b] = link.bodies.map(|body| body as usize);
        let parts = [&self.bodies[a], &self.bodies[b]];
        let (force, [torque_a, torque_b], work) = link.pull(self.friction, parts);
        self.work += work;
        self.bodies[a].force += force;
        self.bodies[a].torque += torque_a;
        self.bodies[b].force -= force;
        self.bodies[b].torque += torque_b;
    }

    /// What hits shares its speed with the part that it is at.
    fn hit(&mut self) {
        for hitting in &mut self.hitting {
            let body = &mut self.bodies[hitting.body as usize];
            let direction = hitting.striker.direction;
            let along = direction.dot(body.velocity + body.angular.cross(hitting.arm));
            let approach = hitting.speed - along;
            hitting.gap = (hitting.gap - self.step * approach).max(0.0);
            let lever = hitting.arm.cross(direction);
            let inverse = hitting.striker.inverse_mass
                + body.inverse_mass
                + lever.dot(body.inverse_inertia * lever);
            if hitting.gap > 0.0 || approach <= 0.0 || inverse <= 0.0 {
                continue;
            }
            let impulse = approach / inverse;
            hitting.speed -= hitting.striker.inverse_mass * impulse;
            body.velocity += body.inverse_mass * impulse * direction;
            body.angular += body.inverse_inertia * (impulse * lever);
        }
    }

    /// Whether what is left of the energy is too little to break a bond, or to strain another one.
    fn is_over(&self, held: f32) -> bool {
        let whole = self.links.iter();
        let whole = whole.filter(|link| !(link.is_broken || link.is_strained()));
        let least = whole.map(|link| link.energy).fold(f32::INFINITY, f32::min);
        least == f32::INFINITY || self.kinetic_energy() + held < least
    }

    /// Energy of all motion relative to what stands, or to the common motion, J.
    fn kinetic_energy(&self) -> f32 {
        let frame = self.standing.unwrap_or_else(|| {
            let (mut momentum, mut mass) = (Vec3::ZERO, 0.0);
            for body in &self.bodies {
                momentum += body.mass * body.velocity;
                mass += body.mass;
            }
            for hitting in self.hitting.iter().filter(|hitting| hitting.gap <= 0.0) {
                let own = hitting.striker.inverse_mass.recip();
                momentum += own * hitting.speed * hitting.striker.direction;
                mass += own;
            }
            momentum / mass
        });
        let bodies = self.bodies.iter().map(|body| {
            let spin = body.angular.dot(body.inertia * body.angular);
            body.mass * (body.velocity - frame).length_squared() + spin
        });
        let strikers = self.hitting.iter().filter(|hitting| {
            let is_near = hitting.gap <= 0.0;
            is_near && hitting.striker.inverse_mass > 0.0
        });
        let strikers = strikers.map(|hitting| {
            let speed = hitting.speed - frame.dot(hitting.striker.direction);
            speed * speed / hitting.striker.inverse_mass
        });
        0.5 * (bodies.sum::<f32>() + strikers.sum::<f32>())
    }

    /// Energy of the springs, J.
    fn held_energy(&self) -> f32 {
        let springs = self.links.iter().map(|link| {
            let parts = link.bodies.map(|body| &self.bodies[body as usize]);
            link.held_energy(parts)
        });
        springs.sum()
    }
}

/// Gives parts that are too quick more mass, and their bonds less stiffness, both by the same factor; a time step that all vibrations are slow
/// for, s.
fn tame(bodies: &mut [Body], links: &mut [Link]) -> f32 {
    let squares = frequencies(bodies, links);
    let mut moving: Vec<f32> = squares.iter().copied().filter(|&it| it > 0.0).collect();
    if moving.is_empty() {
        return 0.0;
    }
    moving.sort_unstable_by(f32::total_cmp);
    let most = QUICKEST * QUICKEST * moving[moving.len() / 2];
    let factors: Vec<f32> = squares
        .iter()
        .map(|it| (it / most).max(1.0).sqrt())
        .collect();
    for (body, &factor) in bodies.iter_mut().zip(&factors) {
        body.enlarge(factor);
    }
    for link in links {
        let [a, b] = link.bodies.map(|body| factors[body as usize]);
        link.stiffness /= a.max(b);
    }
    STEP_SHARE / moving[moving.len() - 1].min(most).sqrt()
}

/// By body: square of the highest angular frequency, at most, 1/s2; zero for what nothing moves.
fn frequencies(bodies: &[Body], links: &[Link]) -> Vec<f32> {
    // By body: what its bonds pull with per way, and per turn.
    let mut stiffness = vec![[0.0f32; 2]; bodies.len()];
    for link in links {
        for (side, &body) in link.bodies.iter().enumerate() {
            let arms = &link.corners.arms[side];
            let own = &mut stiffness[body as usize];
            for square in arms.dot(*arms).to_array() {
                own[0] += link.stiffness;
                own[1] += link.stiffness * square;
            }
        }
    }
    let squares = bodies.iter().zip(&stiffness).map(|(body, [way, turn])| {
        let Mat3 {
            x_axis,
            y_axis,
            z_axis,
        } = body.inverse_inertia;
        let lightest = x_axis.x.max(y_axis.y).max(z_axis.z);
        2.0 * (way * body.inverse_mass + turn * lightest)
    });
    squares.collect()
}
