//! Bonds: bodies that hold together face to face until their load reaches a strength, so that what is built of pieces
//! cracks along its joints without being cut.
//!
//! A bond lets the contact of its pair pull: each point of the manifold bears up to its share of strength times area in
//! tension and in shear, and returns to where it was when the bond was made; see [`bond_constraints`](crate::solver::wide::bond). Where a
//! point that bears all it can has opened or slid by [`BREAKING_SHARE`] of the smaller body's least extent, where any has by
//! [`TEARING_SHARE`](crate::fracture::bonded_pair::TEARING_SHARE), or where the bodies have come too far apart to touch, the bond is broken for good, and the pair is an
//! ordinary contact.
//!
//! The load is shared by at most four points at the rim of the common face. So a rectangular face of depth `d` bears a
//! bending moment of `strength area d / 2`, three times that of an elastic beam whose stress at the rim is the strength.
//!
//! Bodies that turn about each other need 1.5 times the strength that keeps them on their circle.
//!
//! Bonds hold where contacts do: the bodies must touch, their layers must let them, and one of them must be dynamic. They
//! go with their bodies; those of a body that breaks or is cut go to the pieces that lie on the bonded neighbor. All methods
//! of the solver bear them.

use crate::bodies::store::Bodies;
use crate::cluster::network::BREAKING_SHARE;
use crate::contact::body_id::BodyId;
use crate::contact::manifolds::{ManifoldHead, Manifolds};
use crate::contact::point::ContactPoint;
use crate::fracture::bond::{Bond, BondError};
use crate::fracture::bonded_pair::{BondedPair, BrokenBond};
use crate::fracture::neighbors::{close_pairs, smaller_extent, touching_area};
use crate::math::Pose;
use crate::solver::wide::bond::BondedManifold;
use bevy_ecs::resource::Resource;

/// All bonds of a simulation.
#[derive(Clone, Debug, Default, Resource)]
pub struct Bonds {
    /// Sorted by bodies.
    pub(super) joints: Vec<BondedPair>,
    /// Bonds that broke in the last step.
    pub broken: Vec<BrokenBond>,
}

impl Bonds {
    /// Number of bonds.
    pub fn len(&self) -> usize {
        self.joints.iter().filter(|joint| !joint.is_loose).count()
    }

    /// Whether there are no bonds.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Slots of the two bodies of each bond, and the bond, in order of the bodies' ids.
    pub fn iter(&self) -> impl Iterator<Item = ([u32; 2], &Bond)> {
        let joints = self.joints.iter().filter(|joint| !joint.is_loose);
        joints.map(|joint| (joint.slots, &joint.bond))
    }

    /// The bond between the bodies in two slots.
    pub fn get(&self, bodies: &Bodies, a: u32, b: u32) -> Option<&Bond> {
        if !(bodies.contains(a) && bodies.contains(b)) {
            return None;
        }
        let joint = &self.joints[self.find(names(bodies, a, b)).ok()?];
        (!joint.is_loose).then_some(&joint.bond)
    }

    /// Bonds the bodies in two slots as they lie now, in place of a bond that they have. Wakes both.
    ///
    /// # Errors
    /// [`BondError`]; nothing changes then.
    pub fn bond(
        &mut self,
        bodies: &mut Bodies,
        a: u32,
        b: u32,
        bond: Bond,
    ) -> Result<(), BondError> {
        let joint = BondedPair::new(bodies, a, b, bond)?;
        self.put(bodies, joint);
        Ok(())
    }

    /// Bonds them as [`bond`](Self::bond) does, as they lay when B's pose in A's frame was `b_in_a`: if they lie otherwise, the bond pulls.
    ///
    /// # Errors
    /// [`BondError`]; nothing changes then.
    pub fn bond_at(
        &mut self,
        bodies: &mut Bodies,
        a: u32,
        b: u32,
        bond: Bond,
        b_in_a: Pose,
    ) -> Result<(), BondError> {
        let mut joint = BondedPair::new(bodies, a, b, bond)?;
        if !(b_in_a.is_finite() && b_in_a.rotation.is_normalized()) {
            return Err(BondError::Pose);
        }
        joint.b_in_a = joint.seen_from(a, b_in_a);
        self.put(bodies, joint);
        Ok(())
    }

    /// Where the body in slot `b` lay in the frame of that in slot `a` when they were bonded.
    pub fn rest_pose(&self, bodies: &Bodies, a: u32, b: u32) -> Option<Pose> {
        self.get(bodies, a, b)?;
        let joint = &self.joints[self.find(names(bodies, a, b)).ok()?];
        Some(joint.seen_from(a, joint.b_in_a))
    }

    fn put(&mut self, bodies: &mut Bodies, joint: BondedPair) {
        match self.find(joint.bodies) {
            Ok(at) => self.joints[at] = joint,
            Err(at) => self.joints.insert(at, joint),
        }
        joint.slots.into_iter().for_each(|slot| bodies.wake(slot));
    }

    /// Bonds all of the given bodies that touch face to face over their common areas with a tensile and shear strength
    /// (Pa), in place of bonds that they have; the number of bonds made. Wakes them.
    ///
    /// Faces touch if they are parallel to within a degree, and no farther apart than a hundredth of the smaller body's
    /// least extent. Pairs neither of which is dynamic are left out.
    ///
    /// # Errors
    /// [`BondError`]; no bonds are made then.
    pub fn bond_neighbors(
        &mut self,
        bodies: &mut Bodies,
        slots: &[u32],
        strength: f32,
    ) -> Result<usize, BondError> {
        Bond::new(strength, 1.0).check()?;
        if slots.iter().any(|&slot| !bodies.contains(slot)) {
            return Err(BondError::NoBody);
        }
        let mut made = Vec::new();
        for [a, b] in close_pairs(bodies, slots) {
            if let Some(area) = touching_area(bodies, a, b) {
                made.push(BondedPair::new(bodies, a, b, Bond::new(strength, area))?);
            }
        }
        for slot in made.iter().flat_map(|joint| joint.slots) {
            bodies.wake(slot);
        }
        let count = made.len();
        // New ones first, so that of two for one pair the new one stays.
        made.append(&mut self.joints);
        made.sort_by_key(|joint| joint.bodies);
        made.dedup_by_key(|joint| joint.bodies);
        self.joints = made;
        Ok(count)
    }

    /// Takes the bond between the bodies in two slots away, and wakes them; whether there was one.
    pub fn unbond(&mut self, bodies: &mut Bodies, a: u32, b: u32) -> bool {
        if self.get(bodies, a, b).is_none() {
            return false;
        }
        if let Ok(at) = self.find(names(bodies, a, b)) {
            self.joints[at].is_loose = true;
        }
        [a, b].into_iter().for_each(|slot| bodies.wake(slot));
        true
    }

    /// Takes all bonds of the body in a slot away, and wakes it and whom it was bonded to; how many there were.
    pub fn unbond_all(&mut self, bodies: &mut Bodies, slot: u32) -> usize {
        let held = self.joints.iter().map(|joint| joint.slots);
        let held: Vec<[u32; 2]> = held.filter(|slots| slots.contains(&slot)).collect();
        held.into_iter()
            .filter(|&[a, b]| self.unbond(bodies, a, b))
            .count()
    }

    fn find(&self, bodies: (BodyId, BodyId)) -> Result<usize, usize> {
        self.joints
            .binary_search_by_key(&bodies, |joint| joint.bodies)
    }

    /// Forgets what broke in the last step.
    pub(crate) fn begin_step(&mut self) {
        self.broken.clear();
    }

    /// Tells the bodies which of them are bonded, before their contacts are looked for.
    pub(crate) fn note_pairs(&self, bodies: &mut Bodies) {
        bodies.bonded.clear();
        bodies
            .bonded
            .extend(self.joints.iter().map(|joint| joint.bodies));
    }

    /// Before the solve: finds the manifolds of the bonds, and notes in `bonded` what they bear and how far they are off.
    /// Bonds whose bodies are gone go, those whose bodies are apart are broken.
    pub(crate) fn attach(
        &mut self,
        bodies: &Bodies,
        manifolds: &mut Manifolds,
        bonded: &mut Vec<BondedManifold>,
    ) {
        let Self { joints, broken } = self;
        bonded.clear();
        if joints.is_empty() {
            return;
        }
        let name = |m: &ManifoldHead| (bodies.id(m.a), bodies.id(m.b));
        let mut next = 0;
        // A merge by pairs too, but one list shrinks meanwhile and the other is written by index.
        joints.retain_mut(|joint| {
            let rest = manifolds.heads()[next..].iter();
            next += rest.take_while(|m| name(m) < joint.bodies).count();
            let is_found = manifolds
                .heads()
                .get(next)
                .is_some_and(|m| name(m) == joint.bodies);
            let found = is_found.then(|| (next, manifolds.at_mut(next)));
            match found {
                _ if !joint.is_alive(bodies) => false,
                Some((_, (head, points))) if joint.is_loose => {
                    forget_pull(head, points);
                    false
                }
                Some((_, (head, points))) if joint.is_torn(bodies, points) => {
                    forget_pull(head, points);
                    broken.push(joint.broken());
                    false
                }
                Some((index, (head, points))) => {
                    // Nothing rebounds.
                    head.restitution = 0.0;
                    bonded.push(joint.hold(bodies, index as u32, head.normal, points));
                    joint.is_new = false;
                    true
                }
                None if joint.is_out_of_sight(bodies) => true,
                None => {
                    if !joint.is_loose {
                        broken.push(joint.broken());
                    }
                    false
                }
            }
        });
    }

    /// After the solve: breaks the bonds that have given way. What slept on their bodies wakes.
    pub(crate) fn break_overloaded(&mut self, bodies: &mut Bodies, bonded: &[BondedManifold]) {
        for held in bonded.iter().filter(|held| held.yielded > 0.0) {
            let Ok(at) = self.find(held.bodies) else {
                continue;
            };
            let joint = &mut self.joints[at];
            if held.yielded > BREAKING_SHARE * smaller_extent(bodies, joint.slots) {
                joint.is_loose = true;
                self.broken.push(joint.broken());
                joint.slots.into_iter().for_each(|slot| bodies.wake(slot));
            }
        }
    }
}

/// Takes from a contact's impulses what only a bond can bear.
fn forget_pull(head: &ManifoldHead, points: &mut [ContactPoint]) {
    for point in points {
        point.normal_impulse = point.normal_impulse.max(0.0);
        let bound = head.friction * point.normal_impulse;
        point.friction_impulse = point.friction_impulse.clamp_length_max(bound);
    }
}

fn names(bodies: &Bodies, a: u32, b: u32) -> (BodyId, BodyId) {
    let [a, b] = [a, b].map(|slot| bodies.id(slot));
    (a.min(b), a.max(b))
}
