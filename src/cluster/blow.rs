//! What a blow breaks: the parts around it as free bodies for the instant of the blow, held by bonds that yield.
//!
//! A blow of rigid bodies has no duration, and the inside of a body that it breaks is not rigid. So what hits the cluster
//! meets the struck part alone, and the part its neighbors through their bonds. A corner of a bonded face pulls back in proportion to how
//! far it has opened, up to its share of strength times area; from there on it yields, until the work is strength times area
//! times the [way](crate::cluster::network::BREAKING_SHARE) that breaking takes. Pressed together, faces give no way, bonded or not. The motion is
//! followed in time steps of the fastest vibration until what is left of the energy cannot break a bond any more. So it is
//! inertia, and not the length of the simulation's step, that says how much of the blow each bond gets.
//!
//! Only parts near the blow take part, as long as those behind them have not heard of it; else more of them.

use crate::cluster::network::Network;
use glam::{Mat3, Vec3};

/// Parts that take part at first; those around them stay where they are. If those are pulled at, four times as many do.
const FIRST_PARTS: usize = 64;

/// Share of what it bears up to which a bond to parts that stay where they are may be loaded.
const HEARD: f32 = 0.25;

/// Share of the way to breaking up to which a bond is elastic; it yields for the rest, so that the work is force times way.
const ELASTIC: f32 = 0.5;

/// Time steps at most: several times as long as a vibration goes from the blow to the outermost part and back.
const MOST_STEPS: usize = 768;

/// Time steps from one look at the energy to the next.
const STEPS_PER_LOOK: usize = 8;

/// Looks after which it is over if nothing has yielded and the springs have not come to hold more: longer than the slowest vibration of a
/// part against its neighbors.
const CALM_LOOKS: usize = 8;

/// Length of a time step, as a share of the reciprocal of the highest angular frequency. The limit of stability is 2.
const STEP_SHARE: f32 = 1.0;

const NONE: u32 = u32::MAX;

/// One point where something hits the cluster, or stands against it; frame of the compound.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Striker {
    /// The part that it is at.
    pub(crate) part: u32,
    /// m.
    pub(crate) point: Vec3,
    /// Unit vector along which it pushes the cluster.
    pub(crate) direction: Vec3,
    /// How fast it comes, relative to the cluster as a rigid body, m/s; negative if it goes.
    pub(crate) speed: f32,
    /// As seen along the direction, 1/kg; 0 for what stands.
    pub(crate) inverse_mass: f32,
}

/// What became of the bonds.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BlowOutcome {
    /// Bonds that broke, ascending.
    pub(crate) broken: Vec<u32>,
    /// Work that all bonds took, J.
    pub(crate) work: f32,
}

impl Network {
    /// What a blow makes of the bonds. `is_held`: parts that hold on to the world.
    pub(crate) fn blow(&self, strikers: &[Striker], is_held: impl Fn(u32) -> bool) -> BlowOutcome {
        let mut most = FIRST_PARTS;
        let mut instant = Instant::new(self, strikers, &is_held, most);
        while !instant.run() {
            most *= 4;
            instant = Instant::new(self, strikers, &is_held, most);
        }
        let mut broken: Vec<u32> = (instant.links.iter())
            .filter(|link| link.is_broken)
            .map(|link| link.bond)
            .collect();
        broken.sort_unstable();
        BlowOutcome {
            broken,
            work: instant.work,
        }
    }
}

/// A part in the instant of the blow, relative to the motion of the cluster.
#[derive(Clone, Copy, Debug)]
struct Body {
    inverse_mass: f32,
    inverse_inertia: Mat3,
    mass: f32,
    inertia: Mat3,
    velocity: Vec3,
    angular: Vec3,
    displacement: Vec3,
    turn: Vec3,
    force: Vec3,
    torque: Vec3,
}

/// A corner of a bonded face.
#[derive(Clone, Copy, Debug)]
struct Corner {
    /// From the centers of both parts, m.
    arms: [Vec3; 2],
    /// How far it has yielded: opened, and slid, m.
    opened: f32,
    slid: Vec3,
}

/// A bond in the instant of the blow.
#[derive(Debug)]
struct Link {
    bond: u32,
    bodies: [u32; 2],
    normal: Vec3,
    corners: [Corner; 4],
    /// Of a corner, N/m.
    stiffness: f32,
    /// What a corner bears in tension and in shear, N.
    limits: [f32; 2],
    /// How far it may yield, m.
    way: f32,
    /// Energy that breaking it takes, J.
    energy: f32,
    is_broken: bool,
}

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
struct Instant {
    bodies: Vec<Body>,
    links: Vec<Link>,
    hitting: Vec<Hitting>,
    friction: f32,
    step: f32,
    /// J.
    work: f32,
    /// Velocity of something that stands, in which frame energies are told; none if nothing does.
    standing: Option<Vec3>,
}

impl Instant {
    fn new(
        network: &Network,
        strikers: &[Striker],
        is_held: &impl Fn(u32) -> bool,
        most: usize,
    ) -> Self {
        let members = neighborhood(network, strikers, is_held, most);
        let mut number = vec![NONE; network.nodes.len()];
        for (index, &part) in (0..).zip(&members) {
            number[part as usize] = index;
        }
        let outside = members.len() as u32;
        let mut bodies: Vec<Body> = (members.iter())
            .map(|&part| Body::of(network, part, is_held(part)))
            .collect();
        bodies.push(Body::FIXED);
        let place = |part: u32| number[part as usize].min(outside);
        let mut links: Vec<Link> = Vec::new();
        for &part in &members {
            for &bond in network.bonds_of(part) {
                let other = place(network.other(bond, part));
                // Each once: from the member that comes first.
                if place(part) < other {
                    links.push(Link::of(network, bond, place));
                }
            }
        }
        let hitting = strikers.iter().map(|striker| Hitting {
            striker: *striker,
            body: place(striker.part),
            arm: striker.point - network.nodes[striker.part as usize].center.as_vec3(),
            speed: striker.speed,
            gap: 0.0,
        });
        let is_free = members.len() == network.nodes.len();
        let any_fixed = bodies[..members.len()]
            .iter()
            .any(|body| body.inverse_mass == 0.0);
        let wall = strikers.iter().find(|striker| striker.inverse_mass == 0.0);
        let standing = if any_fixed || !is_free {
            Some(Vec3::ZERO)
        } else {
            wall.map(|striker| striker.speed * striker.direction)
        };
        let mut instant = Self {
            step: time_step(&bodies, &links),
            bodies,
            links,
            hitting: hitting.collect(),
            friction: network.friction,
            work: 0.0,
            standing,
        };
        instant.hit();
        instant
    }

    /// Follows the motion; whether no part that does not take part has heard of it.
    fn run(&mut self) -> bool {
        let (mut most, mut work, mut calm) = (0.0f32, 0.0, 0);
        for step in 0..MOST_STEPS {
            if step % STEPS_PER_LOOK == 0 {
                if self.is_heard_outside() {
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
            let [a, b] = link.bodies.map(|body| &self.bodies[body as usize]);
            let heard = HEARD * link.limits[0].min(link.limits[1]) / link.stiffness;
            link.corners.iter().any(|corner| {
                let moved = (b.displacement + b.turn.cross(corner.arms[1]))
                    - (a.displacement + a.turn.cross(corner.arms[0]));
                moved.length() > heard
            })
        })
    }

    /// Forces of a bond, and what they break.
    fn pull(&mut self, index: usize) {
        let link = &mut self.links[index];
        let [a, b] = link.bodies.map(|body| self.bodies[body as usize]);
        let (mut force, mut torque_a, mut torque_b) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
        let mut work = 0.0;
        let mut is_torn = false;
        for corner in &mut link.corners {
            let moved = (b.displacement + b.turn.cross(corner.arms[1]))
                - (a.displacement + a.turn.cross(corner.arms[0]));
            let open = moved.dot(link.normal);
            let mut pull = if link.is_broken {
                (link.stiffness * open).min(0.0) * link.normal
            } else {
                let (pulled, done) = corner.yielding(link.stiffness, link.limits, self.friction, {
                    (open, moved - open * link.normal)
                });
                work += done;
                is_torn |= corner.opened.max(corner.slid.length()) > link.way;
                pulled.0 * link.normal + pulled.1
            };
            // On A; B gets the opposite.
            pull = if pull.is_finite() { pull } else { Vec3::ZERO };
            force += pull;
            torque_a += corner.arms[0].cross(pull);
            torque_b -= corner.arms[1].cross(pull);
        }
        link.is_broken |= is_torn;
        self.work += work;
        let [a, b] = link.bodies.map(|body| body as usize);
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

    /// Whether what is left of the energy is too little to break a bond.
    fn is_over(&self, held: f32) -> bool {
        let whole = self.links.iter().filter(|link| !link.is_broken);
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
        let springs = self.links.iter().flat_map(|link| {
            let [a, b] = link.bodies.map(|body| &self.bodies[body as usize]);
            link.corners.iter().map(move |corner| {
                let moved = (b.displacement + b.turn.cross(corner.arms[1]))
                    - (a.displacement + a.turn.cross(corner.arms[0]));
                let stretched = moved - corner.slid - corner.opened * link.normal;
                let is_pressed = stretched.dot(link.normal) < 0.0;
                if link.is_broken && !is_pressed {
                    0.0
                } else {
                    link.stiffness * stretched.length_squared()
                }
            })
        });
        0.5 * springs.sum::<f32>()
    }
}

impl Body {
    /// One that nothing moves.
    const FIXED: Self = Self {
        inverse_mass: 0.0,
        inverse_inertia: Mat3::ZERO,
        mass: 0.0,
        inertia: Mat3::ZERO,
        velocity: Vec3::ZERO,
        angular: Vec3::ZERO,
        displacement: Vec3::ZERO,
        turn: Vec3::ZERO,
        force: Vec3::ZERO,
        torque: Vec3::ZERO,
    };

    fn of(network: &Network, part: u32, is_held: bool) -> Self {
        if is_held {
            return Self::FIXED;
        }
        let node = &network.nodes[part as usize];
        Self {
            mass: node.mass as f32,
            inertia: node.inertia.as_mat3(),
            inverse_mass: node.mass.recip() as f32,
            inverse_inertia: node.inverse_inertia,
            ..Self::FIXED
        }
    }

    /// Symplectic Euler.
    fn advance(&mut self, h: f32) {
        self.velocity += h * self.inverse_mass * self.force;
        self.angular += self.inverse_inertia * (h * self.torque);
        self.displacement += h * self.velocity;
        self.turn += h * self.angular;
        (self.force, self.torque) = (Vec3::ZERO, Vec3::ZERO);
    }
}

impl Link {
    fn of(network: &Network, bond: u32, place: impl Fn(u32) -> u32) -> Self {
        let shape = &network.bonds[bond as usize];
        let opening = network.openings[bond as usize];
        let centers = shape
            .parts
            .map(|part| network.nodes[part as usize].center.as_vec3());
        let limits = [shape.strength, shape.shear_strength].map(|s| 0.25 * s * shape.area);
        Self {
            bond,
            bodies: shape.parts.map(place),
            normal: shape.normal,
            corners: Network::corners(shape).map(|at| Corner {
                arms: centers.map(|center| at - center),
                opened: 0.0,
                slid: Vec3::ZERO,
            }),
            stiffness: limits[0].max(limits[1]) / (ELASTIC * opening),
            limits,
            way: (1.0 - 0.5 * ELASTIC) * opening,
            energy: limits[0].min(limits[1]) * opening,
            is_broken: false,
        }
    }
}

impl Corner {
    /// Its pull on the first part, along the normal and across, N, if it is open and slid so far; it yields where that is more than it
    /// bears. And the work that this takes, J.
    fn yielding(
        &mut self,
        stiffness: f32,
        limits: [f32; 2],
        friction: f32,
        (open, across): (f32, Vec3),
    ) -> ((f32, Vec3), f32) {
        let mut work = 0.0;
        let mut pull = stiffness * (open - self.opened);
        if pull > limits[0] {
            let more = (pull - limits[0]) / stiffness;
            self.opened += more;
            work += limits[0] * more;
            pull = limits[0];
        }
        let mut shear = stiffness * (across - self.slid);
        let most = limits[1] + friction * (-pull).max(0.0);
        let size = shear.length();
        if size > most {
            let more = (size - most) / stiffness;
            self.slid += shear * (more / size);
            work += most * more;
            shear *= most / size;
        }
        ((pull, shear), work)
    }
}

/// The parts around a blow, nearest first: by the number of bonds between, then by index.
fn neighborhood(
    network: &Network,
    strikers: &[Striker],
    is_held: &impl Fn(u32) -> bool,
    most: usize,
) -> Vec<u32> {
    let mut members: Vec<u32> = strikers.iter().map(|striker| striker.part).collect();
    members.sort_unstable();
    members.dedup();
    let mut is_member = vec![false; network.nodes.len()];
    members
        .iter()
        .for_each(|&part| is_member[part as usize] = true);
    let mut next = 0;
    while let Some(&part) = members.get(next) {
        next += 1;
        // Nothing gets through what is held.
        if members.len() >= most || is_held(part) {
            continue;
        }
        for &bond in network.bonds_of(part) {
            let other = network.other(bond, part);
            if !std::mem::replace(&mut is_member[other as usize], true) {
                members.push(other);
            }
        }
    }
    members
}

/// A time step that all vibrations are slow for, s.
fn time_step(bodies: &[Body], links: &[Link]) -> f32 {
    // By body: what its bonds pull with per way, and per turn.
    let mut stiffness = vec![[0.0f32; 2]; bodies.len()];
    for link in links {
        for (side, &body) in link.bodies.iter().enumerate() {
            for corner in &link.corners {
                let own = &mut stiffness[body as usize];
                own[0] += link.stiffness;
                own[1] += link.stiffness * corner.arms[side].length_squared();
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
    let fastest = squares.fold(0.0, f32::max).sqrt();
    if fastest > 0.0 {
        STEP_SHARE / fastest
    } else {
        0.0
    }
}
