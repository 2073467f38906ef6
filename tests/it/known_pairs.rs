//! What is known of pairs stays theirs while other pairs come and go by the thousand: bodies that do not move have the
//! contacts that they have for who sees them for the first time.

use crate::common::dice::Dice;
use bevy_cleave::contact::Manifolds;
use bevy_cleave::prelude::*;
use bevy_cleave::step::mass_properties;
use bevy_cleave::testing::collide::{Lookahead, NarrowPhase, update_pairs};
use bevy_cleave::testing::contact::Broadphase;
use glam::Vec3;

/// Bodies along an edge of the block that they fill.
const EDGE: usize = 13;

/// All pairs that somebody has seen so far, and the contacts that were found last.
#[derive(Default)]
struct Observer {
    broadphase: Broadphase,
    narrow: NarrowPhase,
    manifolds: Manifolds,
}

impl Observer {
    /// The contacts of the bodies as they are now.
    fn look(&mut self, bodies: &Bodies) -> &Manifolds {
        let Self {
            broadphase,
            narrow,
            manifolds,
        } = self;
        let ahead = Lookahead::new(1.0 / 60.0, Vec3::ZERO);
        update_pairs(broadphase, narrow, bodies, ahead);
        narrow.collide(bodies, broadphase, ahead, manifolds, None);
        manifolds
    }
}

/// Cubes that lie nearly in rows, each in touch with some of its neighbors.
struct Block {
    dice: Dice,
    cube: ConvexMesh,
    bodies: Bodies,
    /// By place: the slot of the cube there.
    places: Vec<Option<u32>>,
}

impl Block {
    fn new() -> Self {
        Self {
            dice: Dice::new(3),
            cube: ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a cube"),
            bodies: Bodies::default(),
            places: vec![None; EDGE * EDGE * EDGE],
        }
    }

    /// Adds or removes cubes at random places until there are `count`.
    fn set_count(&mut self, count: usize) {
        while self.bodies.len() != count {
            let place = self.dice.below(self.places.len());
            match self.places[place] {
                Some(slot) if self.bodies.len() > count => {
                    self.bodies.remove(slot);
                    self.places[place] = None;
                }
                None if self.bodies.len() < count => {
                    let cells = [place % EDGE, place / EDGE % EDGE, place / EDGE / EDGE];
                    let at = Vec3::from_array(cells.map(|cell| cell as f32));
                    let at = at + self.dice.vector(-0.02, 0.02);
                    let body = BodyDesc::dynamic(self.cube.clone(), at);
                    self.places[place] = Some(self.bodies.insert(body).expect("usable"));
                }
                _ => {}
            }
        }
        mass_properties(&mut self.bodies, &mut StepReport::default());
    }
}

#[test]
fn contacts_are_those_of_a_first_look_while_pairs_come_and_go() {
    let mut block = Block::new();
    let mut observer = Observer::default();
    let mut most = 0;
    // Up in leaps and in small steps, down again, and with others each time.
    let counts = [
        1, 2, 40, 45, 300, 310, 900, 2000, 1960, 2000, 700, 1500, 90, 3, 0, 600,
    ];
    for count in counts {
        block.set_count(count / 3);
        block.set_count(count);
        // Parts are put into order one by one.
        for _ in 0..40 {
            observer.look(&block.bodies);
        }
        let seen = observer.look(&block.bodies);
        let mut newcomer = Observer::default();
        assert!(seen == newcomer.look(&block.bodies), "{count} cubes");
        most = most.max(seen.len());
    }
    assert!(most > 4096, "{most} manifolds are too few to be sorted");
}

#[test]
fn bodies_that_replace_all_others_are_seen_for_the_first_time() {
    let mut observer = Observer::default();
    // Fewer, more, and as many of the same ids and slots, in other places.
    for (seed, count) in [(3, 300), (4, 40), (5, 300), (6, 300)] {
        let mut block = Block::new();
        block.dice = Dice::new(seed);
        block.set_count(count);
        let seen = observer.look(&block.bodies);
        let mut newcomer = Observer::default();
        assert!(seen == newcomer.look(&block.bodies), "{count} cubes");
    }
}
