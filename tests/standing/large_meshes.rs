//! A large mesh is cut over several steps: the work of a step, counted and not timed, stays within what the budget says and a cell more, and the pieces
//! are the same as in one go.

use crate::scenes::*;
use bevy_cleave::prelude::*;
use glam::Vec3;

const CELLS: u16 = 30;

/// A ball of 5120 triangles that falls and breaks; the work of each step in which something was cut, and the volumes of the pieces.
fn drop_ball(triangles_per_step: usize) -> (Vec<usize>, Vec<f64>, usize) {
    let mesh = ConvexMesh::icosphere(0.5, 4)
        .expect("a ball")
        .hull()
        .to_mesh();
    assert_eq!(mesh.triangles().len(), 5_120);
    // A round hull of fewer faces around it, as an artist would give it: the mesh alone is large.
    let hull = ConvexMesh::icosphere(0.52, 2)
        .expect("a ball")
        .hull()
        .clone();
    let mut simulation = scene([floor()]);
    simulation.budget.triangles_per_step = triangles_per_step;
    let body = BodyDesc {
        fracturable: Some(Fracturable {
            generations: 0,
            ..voronoi(CELLS, 50.0, 1)
        }),
        ..BodyDesc::dynamic(ConvexMesh::from_parts(hull, Some(mesh)), 1.5 * Vec3::Y)
    };
    simulation.bodies.insert(body).expect("usable");
    let (mut work, mut waited) = (Vec::new(), 0);
    for _ in 0..120 {
        simulation.step(H);
        work.extend(Some(simulation.fractures.take_cut_work()).filter(|&work| work > 0));
        waited += usize::from(simulation.fractures.waiting() > 0);
        let done = simulation.fractures.done.iter();
        if let Some(fracture) = done.last() {
            assert!(fracture.ledger.mass_error() < 1e-6, "{fracture:?}");
            let volume = |&slot: &u32| {
                let shape = simulation.bodies.convex(slot).expect("a piece");
                shape.visual().expect("seen").volume()
            };
            let volumes = fracture.pieces.iter().map(volume).collect();
            return (work, volumes, waited);
        }
    }
    panic!("nothing broke in {work:?}");
}

/// Triangles looked at for each that the budget counts (`PASSES_OF_A_CUT`).
const PASSES: usize = 22;

#[test]
fn a_large_mesh_is_cut_over_several_steps_into_the_pieces_of_one_go() {
    let (at_once, whole, waited) = drop_ball(100_000);
    assert_eq!((at_once.len(), waited), (1, 0), "in the step of the blow");
    let total = at_once[0];
    for triangles in [300, 1000, 3000] {
        let (work, pieces, waited) = drop_ball(triangles);
        assert_eq!(work.iter().sum::<usize>(), total, "{work:?}");
        assert!(waited + 1 >= work.len(), "{waited} steps for {work:?}");
        // The last cell of a step may be the one that has most of the mesh.
        let most = PASSES * triangles + total / 5;
        assert!(work.iter().all(|&w| w <= most), "{work:?}");
        let steps = total / (PASSES * triangles) + 1;
        assert!(
            work.len() <= steps && work.len() >= steps / 4,
            "{steps}: {work:?}"
        );
        assert_eq!(pieces.len(), whole.len());
        let difference = pieces.iter().zip(&whole).map(|(a, b)| (a - b).abs());
        assert!(difference.fold(0.0, f64::max) < 1e-9, "other pieces");
    }
}

#[test]
fn what_is_cut_in_the_meantime_is_not_cut_once_more() {
    let mesh = ConvexMesh::icosphere(0.5, 4)
        .expect("a ball")
        .hull()
        .to_mesh();
    let ball = ConvexMesh::from_mesh(mesh).expect("closed");
    let mut simulation = scene([floor()]);
    simulation.budget.triangles_per_step = 100;
    let body = BodyDesc {
        fracturable: Some(Fracturable {
            generations: 0,
            ..voronoi(CELLS, 50.0, 1)
        }),
        ..BodyDesc::dynamic(ball, 1.5 * Vec3::Y)
    };
    let slot = simulation.bodies.insert(body).expect("usable");
    let mut pieces = 0;
    for _ in 0..240 {
        let is_cut_now = simulation.fractures.waiting() > 0 && pieces == 0;
        if is_cut_now {
            let middle = simulation.bodies.center_of_mass(slot);
            simulation
                .slice(slot, Plane::through(middle, Vec3::X))
                .expect("a body");
        }
        simulation.step(H);
        pieces += simulation
            .fractures
            .done
            .iter()
            .map(|f| f.pieces.len())
            .sum::<usize>();
    }
    assert_eq!((pieces, simulation.fractures.waiting()), (2, 0));
}
