//! A color for each island: which bodies depend on each other in a step.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::disjoint_sets::DisjointSets;
use crate::fracture::Bonds;
use crate::joints::Joints;
use crate::step::Contacts;
use bevy_color::Color;

/// Share of the circle of hues from one id to the next: that of the golden ratio, after which no few of them are near each other.
const NEXT_HUE: f32 = 0.618_034;

/// The islands, as a forest over slots: of each island the root is the body with the least id.
#[derive(Debug, Default)]
pub(super) struct IslandColors {
    sets: DisjointSets,
}

impl IslandColors {
    /// Finds the islands of the last step.
    pub(super) fn find(
        &mut self,
        bodies: &Bodies,
        contacts: &Contacts,
        bonds: &Bonds,
        joints: &Joints,
    ) {
        self.sets.reset(bodies.slots());
        let manifolds = contacts.manifolds().iter();
        let touching = manifolds.map(|manifold| [manifold.a, manifold.b]);
        let bonded = bonds.iter().map(|(ends, _)| ends);
        let joined = joints.iter().filter_map(|id| match joints.bodies(id)? {
            [Some(a), b] => Some([a, b?]),
            [None, _] => None,
        });
        for pair in touching.chain(bonded).chain(joined) {
            let are_free =
                pair.map(|slot| bodies.contains(slot) && bodies.kind(slot) == RigidBody::Dynamic);
            if are_free == [true; 2] {
                let [a, b] = pair.map(|slot| self.sets.root(slot));
                let (first, second) = match bodies.id(a) <= bodies.id(b) {
                    true => (a, b),
                    false => (b, a),
                };
                self.sets.put_under(first, second);
            }
        }
    }

    /// The color of a body: that of the first body of its island.
    pub(super) fn color(&mut self, bodies: &Bodies, slot: u32) -> Color {
        let root = self.sets.root(slot);
        let hue = (NEXT_HUE * bodies.id(root).0 as f32).fract();
        Color::hsl(360.0 * hue, 0.85, 0.55)
    }
}
