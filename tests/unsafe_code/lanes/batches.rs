//! A batch keeps who is where as long as its islands are the same, and is otherwise the same as one that is loaded anew.

use crate::common::dice::Dice;
use crate::common::properties::cases;
use bevy_cleave::contact::{MAX_POINTS, Manifold, ManifoldHead, Manifolds};
use bevy_cleave::prelude::*;
use bevy_cleave::step;
use bevy_cleave::testing::batch::{Batch, Group, IslandRequirements, Step, SubstepSettings};
use bevy_cleave::testing::bodies::SolverBody;
use bevy_cleave::testing::graph::{BodyNumber, Islands, LaneSlot, ManifoldIndex, stages};
use bevy_cleave::testing::threads::Team;
use bevy_cleave::testing::wide::Block;
use glam::Vec3;
use proptest::prelude::*;
use std::collections::HashMap;
use std::ops::Range;

/// Cubes in a grid of this shape, from which follow manifolds enough for four leaves; every 50th is fixed.
const GRID: [usize; 3] = [16, 16, 12];

fn cube_grid(dice: &mut Dice) -> Bodies {
    let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("valid size");
    let mut bodies = Bodies::default();
    let [x, y, z] = GRID;
    for i in 0..x * y * z {
        let at = Vec3::new((i % x) as f32, (i / x % y) as f32, (i / (x * y)) as f32);
        let mut desc = BodyDesc::dynamic(cube.clone(), at + dice.vector(-0.4, 0.4));
        if i % 50 == 0 {
            desc.kind = RigidBody::Static;
        }
        assert_eq!(bodies.insert(desc), Ok(i as u32));
    }
    step::mass_properties(&mut bodies, &mut StepReport::default());
    bodies
}

fn joint(dice: &mut Dice, a: usize, b: usize) -> Manifold {
    Manifold {
        head: ManifoldHead {
            a: a as u32,
            b: b as u32,
            normal: Vec3::Y,
            count: 1 + dice.below(MAX_POINTS) as u32,
            ..ManifoldHead::default()
        },
        ..Manifold::default()
    }
}

/// Manifolds between neighbors of the grid, and between the first cube, which is fixed, and some of all leaves.
fn grid_manifolds(dice: &mut Dice) -> Vec<Manifold> {
    let [x, y, z] = GRID;
    let mut manifolds = Vec::new();
    for i in 0..x * y * z {
        let neighbors = [
            (1, i % x + 1 < x),
            (x, i / x % y + 1 < y),
            (x * y, i / (x * y) + 1 < z),
        ];
        for (step, _) in neighbors.into_iter().filter(|(_, is_there)| *is_there) {
            manifolds.push(joint(dice, i, i + step));
        }
    }
    manifolds.extend((x + 1..x * y * z).step_by(37).map(|i| joint(dice, 0, i)));
    manifolds
}

/// Names of the bodies and manifolds of a block's lanes, and its points.
type Names = ([[u32; 8]; 2], [u32; 8], Range<usize>);

#[derive(Debug, PartialEq)]
struct Outcome {
    slots: Vec<u32>,
    bodies: Vec<SolverBody>,
    places: Vec<(ManifoldIndex, LaneSlot)>,
    domains: Vec<Range<usize>>,
    blocks: Vec<Names>,
    extents: Vec<f32>,
}

fn outcome(batch: &Batch) -> Outcome {
    let names = |block: &Block| (block.bodies, block.manifolds, block.points.clone());
    Outcome {
        slots: batch.layout.slots.clone(),
        bodies: batch.bodies.velocities.clone(),
        places: batch.layout.places.clone(),
        domains: batch.layout.subdomains.clone(),
        blocks: batch.contacts.blocks.iter().map(names).collect(),
        extents: batch.bodies.extents.clone(),
    }
}

/// Whether each lane in use names the bodies of its manifold, or copies of them, and each other one the idle body or a copy of it.
fn names_are_right(batch: &Batch, manifolds: &Manifolds) -> bool {
    let layout = &batch.layout;
    // The idle body comes behind those that have slots.
    let slot = |number: u32| {
        layout
            .slots
            .get(layout.original(BodyNumber(number)).index())
            .copied()
    };
    let mut lanes = batch
        .contacts
        .blocks
        .iter()
        .flat_map(|block| (0..8).map(move |lane| (block, lane)));
    lanes.all(|(block, lane)| {
        let bodies = block.pair(lane).map(slot);
        let head = manifolds.heads().get(block.manifolds[lane] as usize);
        let is_used = lane < block.used;
        head.is_some() == is_used && bodies == [head.map(|head| head.a), head.map(|head| head.b)]
    })
}

/// What threads may solve side by side: no body, fixed and idle ones among them, is in two domains of a stage.
fn stages_share_no_body(batch: &Batch) -> bool {
    let domains = &batch.layout.subdomains;
    let mut first = 0;
    stages(domains.len()).all(|count| {
        let stage = &domains[first..first + count];
        first += count;
        let mut domain_of = HashMap::new();
        stage.iter().enumerate().all(|(domain, blocks)| {
            let mut bodies = batch.contacts.blocks[blocks.clone()]
                .iter()
                .flat_map(|block| block.bodies.as_flattened());
            bodies.all(|body| *domain_of.entry(*body).or_insert(domain) == domain)
        })
    })
}

proptest! {
    #![proptest_config(cases(12))]

    /// Steps in which nothing changes, bodies shift a little, a manifold changes, comes or goes, or the team comes or goes.
    #[test]
    fn a_batch_that_is_used_again_is_the_one_loaded_anew(seed: u64) {
        let mut dice = Dice::new(seed);
        let mut bodies = cube_grid(&mut dice);
        let mut manifolds = grid_manifolds(&mut dice);
        let settings = SubstepSettings::new(&SolverConfig::default(), Vec3::NEG_Y, 0.01);
        let (mut islands, mut kept) = (Islands::default(), Batch::default());
        let mut has_team = true;
        for _ in 0..8 {
            let list: Manifolds = manifolds.iter().collect();
            islands.find(list.heads(), &bodies, |_| true, None);
            let largest = |island: &usize| islands.list[*island].manifolds.len();
            let largest = (0..islands.list.len()).max_by_key(largest).expect("there are some");
            Team::lead(crate::pool(), |team| {
                let step = Step {
                    islands: &islands,
                    manifolds: &list,
                    bodies: &bodies,
                    settings: &settings,
                    team: Some(team).filter(|_| has_team),
                    may_break: false,
                };
                let mut fresh = Batch::default();
                for batch in [&mut kept, &mut fresh] {
                    let group = [largest as u32];
                    batch.load(&step, Group::one(&group), &IslandRequirements::default());
                }
                prop_assert!(kept.layout.subdomains.len() == 7);
                prop_assert_eq!(outcome(&kept), outcome(&fresh));
                prop_assert!(names_are_right(&kept, &list));
                prop_assert!(!has_team || stages_share_no_body(&kept));
                Ok(())
            })?;
            let at = dice.below(manifolds.len());
            match dice.below(6) {
                0 => drop(manifolds.remove(at)),
                1 => manifolds[at].count = 1 + dice.below(MAX_POINTS) as u32,
                2 => bodies = cube_grid(&mut dice),
                3 => has_team = !has_team,
                _ => {}
            }
        }
    }
}
