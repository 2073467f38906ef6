//! Bodies divided into many pieces: they fill the body, they are what the pattern says, and their number follows the
//! energy.

use crate::common::dice::Dice;
use crate::common::properties::cases;
use crate::common::scenes::awake;
use crate::models::{MODELS, closed_models, model_mesh};
use crate::slice_common::{defect, impact_on, model_hull};
use bevy_cleave::geometry::{ConvexHull, PlaneError, TriMesh, primitives};
use bevy_cleave::mass::VolumeIntegrals;
use bevy_cleave::math::{Plane, Pose};
use bevy_cleave::prelude::{BodyDesc, ConvexMesh, HalfSpaceShape};
use bevy_cleave::slice::{
    CellPlanes, Cutting, Fracturable, FracturePattern, HullSlicer, Impact, Piece, PieceCutter,
    SliceError, SliceOptions, cells_for_energy,
};
use bevy_cleave::testing::predicates::length_scale;
use bevy_cleave::testing::slice::CrackArea;
use glam::{Quat, Vec3};
use proptest::prelude::*;

/// Relative volume that a division may lose or gain.
const VOLUME_TOLERANCE: f64 = 1e-6;

const MOST: u32 = 4096;

fn divide(hull: &ConvexHull, visual: Option<&TriMesh>, cutting: &Cutting) -> Vec<Piece> {
    let options = SliceOptions::default();
    PieceCutter::default()
        .cut(hull, visual, cutting, usize::MAX, options)
        .unwrap()
}

fn patterns(hull: &ConvexHull) -> Vec<FracturePattern> {
    let center = hull.aabb().center();
    let own = [Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Z].map(|n| Plane::through(center, n));
    vec![
        FracturePattern::SinglePlane,
        FracturePattern::RandomPlane,
        FracturePattern::Star { planes: 4 },
        FracturePattern::Radial { rays: 9, rings: 3 },
        FracturePattern::Radial { rays: 3, rings: 0 },
        FracturePattern::Voronoi {
            cells: 40,
            focus: 0.0,
        },
        FracturePattern::Voronoi {
            cells: 40,
            focus: 0.9,
        },
        FracturePattern::Slabs { count: 6 },
        FracturePattern::Brick {
            size: 0.3 * hull.aabb().extents(),
        },
        FracturePattern::Planes(own.into()),
    ]
}

fn contains(hull: &ConvexHull, point: Vec3, margin: f32) -> bool {
    let mut faces = hull.faces().iter();
    faces.all(|face| face.plane.distance(point) <= margin)
}

/// Every piece is a valid hull, the volumes add up to `tolerance` (m3), and random points are in one piece each.
fn check_filled(name: &str, hull: &ConvexHull, pieces: &[Piece], tolerance: f64, dice: &mut Dice) {
    for piece in pieces {
        assert_eq!(piece.hull.validate(), Ok(()), "{name}");
        let volume = piece.hull.volume();
        assert!((piece.volume - volume).abs() <= 1e-12 * volume, "{name}");
    }
    let sum: f64 = pieces.iter().map(|piece| piece.volume).sum();
    let error = (sum - hull.volume()).abs();
    assert!(
        error <= tolerance,
        "{name}: {error:e} of {:e}",
        hull.volume()
    );
    let size = length_scale(&hull.aabb());
    for _ in 0..200 {
        let corners = [(); 4].map(|()| hull.vertices()[dice.below(hull.vertices().len())]);
        let weights = [(); 4].map(|()| dice.unit() + 1e-3);
        let total: f32 = weights.iter().sum();
        let mean = corners.iter().zip(weights).map(|(&p, w)| w / total * p);
        let point: Vec3 = mean.sum();
        let within = |margin: f32| {
            let holding = pieces.iter().filter(|p| contains(&p.hull, point, margin));
            holding.count()
        };
        assert!(within(2e-6 * size) >= 1, "{name}: {point} is in no piece");
        assert!(within(-2e-6 * size) <= 1, "{name}: {point} is in several");
    }
}

#[test]
fn all_patterns_fill_all_models() {
    for name in MODELS {
        let hull = model_hull(name);
        let mut dice = Dice::new(41);
        for pattern in patterns(&hull) {
            let impact = impact_on(&hull, &mut dice);
            let cutting = pattern.cutting(&impact, &hull, 5, MOST).unwrap();
            let pieces = divide(&hull, None, &cutting);
            assert!(pieces.len() >= 2, "{name} {pattern:?}");
            let name = format!("{name} {pattern:?}");
            let tolerance = VOLUME_TOLERANCE * hull.volume();
            check_filled(&name, &hull, &pieces, tolerance, &mut dice);
            assert_eq!(pattern.cutting(&impact, &hull, 5, MOST), Some(cutting));
        }
    }
}

/// Pieces of pieces of pieces, each about its own centroid as bodies are: of the first 400 bodies of each generation.
///
/// Corners are rounded to `f32`, so that thinner needles than there are among these lose more; as bodies they get it back by their
/// density (`tests/it/fracture_ledger.rs`).
#[test]
fn pieces_of_pieces_fill_them() {
    let centered = |hull: &ConvexHull| {
        let centroid = VolumeIntegrals::of_hull(hull).centroid;
        hull.clone().translated(-centroid.as_vec3())
    };
    let mut dice = Dice::new(5);
    let mut hulls: Vec<ConvexHull> = MODELS.iter().map(|m| centered(&model_hull(m))).collect();
    hulls.extend((0..40).map(|_| {
        let size = dice.vector(0.02, 1.0);
        primitives::cuboid(size.x, size.y, size.z).unwrap()
    }));
    for generation in 0..3 {
        let (mut errors, mut next) = (Vec::new(), Vec::new());
        for hull in &hulls {
            for pattern in patterns(hull) {
                let impact = impact_on(hull, &mut dice);
                let seed = dice.below(1000) as u64;
                let cutting = pattern.cutting(&impact, hull, seed, 60).unwrap();
                let pieces = divide(hull, None, &cutting);
                let sum: f64 = pieces.iter().map(|piece| piece.volume).sum();
                errors.push((sum / hull.volume() - 1.0).abs());
                next.push(centered(&pieces[dice.below(pieces.len())].hull));
            }
        }
        let worst = errors.into_iter().fold(0.0, f64::max);
        assert!(
            worst <= VOLUME_TOLERANCE,
            "generation {generation}: {worst:e}"
        );
        next.truncate(400);
        hulls = next;
    }
}

#[test]
fn visual_meshes_are_divided_with_the_hull() {
    for name in closed_models() {
        let mesh = model_mesh(name);
        let hull = model_hull(name);
        let mut dice = Dice::new(42);
        for pattern in patterns(&hull) {
            let impact = impact_on(&hull, &mut dice);
            let cutting = pattern.cutting(&impact, &hull, 6, MOST).unwrap();
            let pieces = divide(&hull, Some(&mesh), &cutting);
            let mut sum = 0.0;
            for piece in &pieces {
                let visual = piece.visual.as_ref().unwrap();
                assert_eq!(defect(visual), None, "{name} {pattern:?}");
                let size = length_scale(&hull.aabb());
                let mut corners = visual.positions().iter();
                assert!(
                    corners.all(|&p| contains(&piece.hull, p, 2e-6 * size)),
                    "{name}"
                );
                sum += visual.volume();
            }
            let error = (sum / mesh.volume() - 1.0).abs();
            assert!(error <= VOLUME_TOLERANCE, "{name} {pattern:?}: {error:e}");
        }
    }
}

/// A face's corners in an order that does not depend on where the loop starts or which way it runs.
fn sorted_face(hull: &ConvexHull, face: usize) -> Vec<[u32; 3]> {
    let corners = hull.face_loop(&hull.faces()[face]);
    let bits = |v: &u32| hull.vertices()[*v as usize].to_array().map(f32::to_bits);
    let mut bits: Vec<_> = corners.iter().map(bits).collect();
    bits.sort_unstable();
    bits
}

#[test]
fn walls_of_voronoi_cells_match_bit_for_bit() {
    let cube = primitives::cuboid(1.0, 1.0, 1.0).unwrap();
    let impact = impact_on(&cube, &mut Dice::new(43));
    let pattern = FracturePattern::Voronoi {
        cells: 100,
        focus: 0.5,
    };
    let cutting = pattern.cutting(&impact, &cube, 7, MOST).unwrap();
    let pieces = divide(&cube, None, &cutting);
    assert_eq!(pieces.len(), 100);
    let mut faces = Vec::new();
    for piece in &pieces {
        for (index, face) in piece.hull.faces().iter().enumerate() {
            let is_outer = face.plane.normal.abs().max_element() == 1.0
                && (face.plane.offset - 0.5).abs() < 1e-6;
            if !is_outer {
                faces.push(sorted_face(&piece.hull, index));
            }
        }
    }
    faces.sort();
    let total = faces.len();
    let paired: usize = faces
        .chunk_by(|a, b| a == b)
        .filter(|run| run.len() == 2)
        .map(<[_]>::len)
        .sum();
    // A vertex that lies half way between two numbers of f32 may be rounded either way by two neighbors.
    assert!(
        paired as f64 >= 0.99 * total as f64,
        "{paired} of {total} walls have a twin"
    );
}

#[test]
fn voronoi_cells_are_what_is_nearest_to_their_sites() {
    let hull = model_hull("spot.obj");
    let mut dice = Dice::new(44);
    let impact = impact_on(&hull, &mut dice);
    let pattern = FracturePattern::Voronoi {
        cells: 60,
        focus: 0.6,
    };
    let Some(Cutting::Sites(sites)) = pattern.cutting(&impact, &hull, 8, MOST) else {
        panic!("cells about points");
    };
    let pieces = divide(&hull, None, &Cutting::Sites(sites.clone()));
    assert_eq!(pieces.len(), sites.len());
    let size = hull.aabb().diagonal();
    for (index, piece) in pieces.iter().enumerate() {
        for &vertex in piece.hull.vertices() {
            let own = vertex.distance(sites[index]);
            let nearest = sites
                .iter()
                .map(|site| site.distance(vertex))
                .fold(f32::MAX, f32::min);
            assert!(own <= nearest + 4e-6 * size, "{own} {nearest}");
        }
    }
}

/// Voronoi cells one after the other: the whole hull cut by every bisector, the near part kept.
fn cells_one_by_one(hull: &ConvexHull, sites: &[Vec3]) -> Vec<f64> {
    let mut slicer = HullSlicer::default();
    let mut volumes = Vec::new();
    for (index, &site) in sites.iter().enumerate() {
        let mut cell = hull.clone();
        for (other, &far) in sites.iter().enumerate() {
            if other != index {
                let plane = Plane::through(0.5 * (site + far), far - site);
                if let Some(halves) = slicer.slice(&cell, plane).unwrap().halves() {
                    cell = halves.below;
                }
            }
        }
        volumes.push(cell.volume());
    }
    volumes
}

#[test]
fn cells_agree_with_cuts_one_after_the_other() {
    for name in ["crate.obj", "spot.obj", "rubble.obj"] {
        let hull = model_hull(name);
        let impact = impact_on(&hull, &mut Dice::new(45));
        let pattern = FracturePattern::Voronoi {
            cells: 30,
            focus: 0.7,
        };
        let Some(Cutting::Sites(sites)) = pattern.cutting(&impact, &hull, 9, MOST) else {
            panic!("cells about points");
        };
        let pieces = divide(&hull, None, &Cutting::Sites(sites.clone()));
        for (piece, expected) in pieces.iter().zip(cells_one_by_one(&hull, &sites)) {
            let error = (piece.volume - expected).abs() / hull.volume();
            assert!(error < 1e-6, "{name}: {error:e}");
        }
    }
}

#[test]
fn focus_puts_more_sites_near_the_impact() {
    let cube = primitives::cuboid(1.0, 1.0, 1.0).unwrap();
    let impact = Impact {
        point: Vec3::new(0.5, 0.0, 0.0),
        normal: Vec3::NEG_X,
        impulse: 1.0,
        energy: 1.0,
    };
    let near = |focus: f32| {
        let pattern = FracturePattern::Voronoi { cells: 200, focus };
        match pattern.cutting(&impact, &cube, 10, MOST) {
            Some(Cutting::Sites(sites)) => {
                let distances = sites.iter().map(|site| site.distance(impact.point));
                distances.filter(|&d| d < 0.3).count()
            }
            other => panic!("{other:?}"),
        }
    };
    let (even, graded, steep) = (near(0.0), near(0.5), near(1.0));
    assert!(
        even < graded && 2 * graded < steep * 2 && 3 * even < steep,
        "{even} {graded} {steep}"
    );
}

/// Largest over smallest cell: some thirty of random sites, four or five of even ones. The cells fill the body all the same.
#[test]
fn even_cells_are_of_about_one_size() {
    for (x, y, z) in [(1.0, 1.0, 1.0), (4.0, 2.0, 0.3), (0.2, 3.0, 0.2)] {
        let hull = primitives::cuboid(x, y, z).unwrap();
        for seed in 0..5 {
            let impact = impact_on(&hull, &mut Dice::new(seed));
            let ratio = |pattern: FracturePattern| {
                let cutting = pattern.cutting(&impact, &hull, seed, MOST).unwrap();
                let pieces = divide(&hull, None, &cutting);
                let volumes = pieces.iter().map(|piece| piece.volume);
                let whole: f64 = volumes.clone().sum();
                assert!((whole / hull.volume() - 1.0).abs() < 1e-5);
                assert_eq!(pieces.len(), 50);
                let largest = volumes.clone().fold(0.0, f64::max);
                largest / volumes.fold(f64::INFINITY, f64::min)
            };
            let even = ratio(FracturePattern::EvenVoronoi { cells: 50 });
            let random = ratio(FracturePattern::Voronoi {
                cells: 50,
                focus: 0.0,
            });
            assert!(even < 5.5 && random > 1.8 * even, "{even} and {random}");
        }
    }
}

#[test]
fn bricks_are_of_one_size_and_staggered() {
    let wall = primitives::cuboid(4.0, 2.0, 0.5).unwrap();
    let impact = impact_on(&wall, &mut Dice::new(46));
    let pattern = FracturePattern::Brick {
        size: Vec3::new(1.0, 0.5, 0.5),
    };
    let cutting = pattern.cutting(&impact, &wall, 0, MOST).unwrap();
    let pieces = divide(&wall, None, &cutting);
    // Two courses of four, and two of three and two halves.
    assert_eq!(pieces.len(), 18);
    let halves = pieces.iter().filter(|p| (p.volume - 0.125).abs() < 1e-6);
    let whole = pieces.iter().filter(|p| (p.volume - 0.25).abs() < 1e-6);
    assert_eq!((whole.count(), halves.count()), (14, 4));
    for limit in [2, 3, 7, 10, 100] {
        let cutting = pattern.cutting(&impact, &wall, 0, limit).unwrap();
        assert!(
            divide(&wall, None, &cutting).len() <= limit as usize + 1,
            "{limit}"
        );
    }
    for size in [
        Vec3::ZERO,
        Vec3::NAN,
        Vec3::INFINITY,
        Vec3::new(1.0, -1.0, 1.0),
    ] {
        let unusable = FracturePattern::Brick { size };
        assert_eq!(unusable.cutting(&impact, &wall, 0, MOST), None, "{size}");
    }
    let dust = FracturePattern::Brick {
        size: Vec3::splat(f32::MIN_POSITIVE),
    };
    let cutting = dust.cutting(&impact, &wall, 0, 50).unwrap();
    assert!(divide(&wall, None, &cutting).len() <= 51);
}

#[test]
fn radial_cracks_run_through_the_impact_and_rings_around_it() {
    let pane = primitives::cuboid(2.0, 2.0, 0.02).unwrap();
    let impact = Impact {
        point: Vec3::new(0.1, -0.2, 0.01),
        normal: Vec3::NEG_Z,
        impulse: 1.0,
        energy: 1.0,
    };
    let pattern = FracturePattern::Radial { rays: 12, rings: 3 };
    let cutting = pattern.cutting(&impact, &pane, 11, MOST).unwrap();
    let pieces = divide(&pane, None, &cutting);
    let touching = pieces
        .iter()
        .filter(|p| contains(&p.hull, impact.point, 1e-5));
    assert_eq!(touching.count(), 12);
    // The last ring may be beyond the corners.
    assert!((36..=48).contains(&pieces.len()), "{}", pieces.len());
    for piece in &pieces {
        for face in piece.hull.faces() {
            assert!(face.plane.normal.z.abs() < 1e-5 || face.plane.normal.z.abs() > 1.0 - 1e-5);
        }
    }
}

#[test]
fn slabs_lie_across_the_longest_direction() {
    let beam = primitives::cuboid(0.2, 0.3, 3.0).unwrap();
    let impact = Impact {
        point: Vec3::new(0.0, 0.15, 0.4),
        normal: Vec3::NEG_Y,
        impulse: 1.0,
        energy: 1.0,
    };
    let pattern = FracturePattern::Slabs { count: 7 };
    let pieces = divide(
        &beam,
        None,
        &pattern.cutting(&impact, &beam, 12, MOST).unwrap(),
    );
    assert_eq!(pieces.len(), 7);
    for (piece, next) in pieces.iter().zip(&pieces[1..]) {
        assert_eq!(piece.hull.aabb().max.z, next.hull.aabb().min.z);
        let thickness = piece.hull.aabb().extents().z;
        assert!(
            (0.6..1.4).contains(&(thickness / (3.0 / 7.0))),
            "{thickness}"
        );
    }
}

/// The middle of the box around a corner of a box is outside of it, and that of a wedge on its face.
#[test]
fn random_planes_cut_corners_and_wedges() {
    let mut dice = Dice::new(31);
    for case in 0..400 {
        let size = dice.vector(0.2, 2.0);
        let turn = [Quat::IDENTITY, dice.rotation()][case / 2 % 2];
        let mut corners = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        if case % 2 == 1 {
            corners.extend([Vec3::X + Vec3::Z, Vec3::Y + Vec3::Z]);
        }
        let corners: Vec<Vec3> = corners.iter().map(|&p| turn * (p * size)).collect();
        let hull = ConvexHull::from_points(&corners).unwrap();
        let impact = impact_on(&hull, &mut dice);
        for seed in 0..10 {
            let cutting = FracturePattern::RandomPlane.cutting(&impact, &hull, seed, MOST);
            let pieces = divide(&hull, None, &cutting.unwrap());
            assert_eq!(pieces.len(), 2, "case {case}, seed {seed}");
        }
    }
}

#[test]
fn unusable_input_is_refused_or_breaks_nothing() {
    let cube = primitives::cuboid(1.0, 1.0, 1.0).unwrap();
    let impact = impact_on(&cube, &mut Dice::new(47));
    for pattern in patterns(&cube) {
        let lost = [
            Impact {
                point: Vec3::NAN,
                ..impact
            },
            Impact {
                normal: Vec3::ZERO,
                ..impact
            },
            Impact {
                normal: Vec3::NAN,
                ..impact
            },
        ];
        for impact in lost {
            assert_eq!(
                pattern.cutting(&impact, &cube, 0, MOST),
                None,
                "{pattern:?}"
            );
        }
        assert_eq!(pattern.cutting(&impact, &cube, 0, 1), None, "{pattern:?}");
    }
    let mut cutter = PieceCutter::default();
    let bad = Plane {
        normal: Vec3::ZERO,
        offset: 0.0,
    };
    let cells: CellPlanes = [bad].into_iter().collect();
    for cutting in [
        Cutting::Planes([bad].into_iter().collect()),
        Cutting::Cells(vec![cells]),
    ] {
        let pieces = cutter.cut(&cube, None, &cutting, 10, SliceOptions::default());
        assert!(matches!(
            pieces,
            Err(SliceError::Plane(PlaneError::ZeroNormal))
        ));
    }
    // Points that are the same, far away or not numbers: whatever becomes of them, no piece is counted twice.
    let sites = vec![
        Vec3::ZERO,
        Vec3::ZERO,
        Vec3::splat(0.2),
        Vec3::splat(1e30),
        Vec3::NAN,
        Vec3::splat(0.2),
    ];
    let pieces = divide(&cube, None, &Cutting::Sites(sites));
    let sum: f64 = pieces.iter().map(|piece| piece.volume).sum();
    assert!(
        (sum - 1.0).abs() < VOLUME_TOLERANCE && pieces.len() == 2,
        "{sum}"
    );
}

#[test]
fn numbers_of_pieces_keep_to_the_limit() {
    let cube = primitives::cuboid(1.0, 1.0, 1.0).unwrap();
    let mut dice = Dice::new(48);
    for pattern in patterns(&cube) {
        for limit in [2_u32, 3, 5, 8, 20] {
            let impact = impact_on(&cube, &mut dice);
            let cutting = pattern.cutting(&impact, &cube, 1, limit).unwrap();
            let pieces = PieceCutter::default()
                .cut(
                    &cube,
                    None,
                    &cutting,
                    limit as usize,
                    SliceOptions::default(),
                )
                .unwrap();
            let number = pieces.len();
            assert!(
                (2..=limit as usize).contains(&number),
                "{pattern:?} {limit}: {number}"
            );
            let sum: f64 = pieces.iter().map(|piece| piece.volume).sum();
            assert!((sum - 1.0).abs() < VOLUME_TOLERANCE, "{pattern:?} {limit}");
        }
    }
}

/// Area of the walls between pieces of `hull`, m2.
fn wall_area(hull: &ConvexHull, pieces: &[Piece]) -> f64 {
    let area = |hull: &ConvexHull| hull.to_mesh().area();
    let all: f64 = pieces.iter().map(|piece| area(&piece.hull)).sum();
    0.5 * (all - area(hull))
}

/// The size of cells at which there are `count` of them.
fn spacing_of(estimate: &CrackArea, count: f64) -> f64 {
    let (mut low, mut high) = (1e-6, 1e6);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if estimate.cells(middle) > count {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[test]
fn estimated_walls_are_those_of_real_tessellations() {
    let shapes = [
        ("cube", primitives::cuboid(1.0, 1.0, 1.0).unwrap()),
        ("sphere", primitives::icosphere(0.7, 2).unwrap()),
        ("plate", primitives::cuboid(2.0, 2.0, 0.1).unwrap()),
        ("bar", primitives::cuboid(5.0, 0.3, 0.3).unwrap()),
        ("spot", model_hull("spot.obj")),
        ("key", model_hull("key.obj")),
    ];
    for (name, hull) in &shapes {
        let estimate = CrackArea::of_hull(hull);
        let mut dice = Dice::new(49);
        for (cells, focus) in [
            (10, 0.0),
            (30, 0.0),
            (100, 0.0),
            (300, 0.0),
            (30, 0.5),
            (100, 0.5),
        ] {
            let mut area = 0.0;
            let runs = 8;
            for seed in 0..runs {
                let pattern = FracturePattern::Voronoi { cells, focus };
                let impact = impact_on(hull, &mut dice);
                let cutting = pattern.cutting(&impact, hull, seed, MOST).unwrap();
                area += wall_area(hull, &divide(hull, None, &cutting)) / runs as f64;
            }
            let estimated = estimate.walls(spacing_of(&estimate, f64::from(cells)));
            let ratio = estimated / area;
            assert!(
                (0.75..1.25).contains(&ratio),
                "{name} {cells} {focus}: {ratio}"
            );
        }
    }
}

#[test]
fn spacing_is_the_inverse_of_walls() {
    for size in [[1.0, 1.0, 1.0], [5.0, 2.0, 0.1], [9.0, 0.2, 0.3]] {
        let hull = primitives::cuboid(size[0], size[1], size[2]).unwrap();
        let estimate = CrackArea::of_hull(&hull);
        let mut last = 1.0;
        for step in 1..200 {
            let area = 0.05 * f64::from(step * step) * hull.volume();
            let spacing = estimate.spacing(area);
            assert!((estimate.walls(spacing) / area - 1.0).abs() < 1e-9);
            let cells = estimate.cells(spacing);
            assert!(cells >= last, "more area, more cells");
            last = cells;
        }
    }
}

#[test]
fn harder_impacts_make_more_pieces() {
    let cube = primitives::cuboid(1.0, 1.0, 1.0).unwrap();
    let fracturable = Fracturable::with_strength(10.0)
        .with_pattern(FracturePattern::Voronoi {
            cells: 500,
            focus: 0.3,
        })
        .with_toughness(100.0, 200);
    let pieces = |energy: f32| {
        let impact = Impact {
            impulse: 20.0,
            energy,
            ..impact_on(&cube, &mut Dice::new(50))
        };
        match fracturable.cutting(&impact, &cube, u32::MAX) {
            Some(cutting) => divide(&cube, None, &cutting).len(),
            None => 1,
        }
    };
    let numbers: Vec<usize> = [1.0, 50.0, 200.0, 500.0, 1000.0, 1e6].map(pieces).to_vec();
    assert!(
        numbers.windows(2).all(|pair| pair[0] <= pair[1]),
        "{numbers:?}"
    );
    assert_eq!((numbers[0], numbers[5]), (1, 200), "{numbers:?}");
    // 5 m2 of cracks: 3 (0.97 n^(1/3) - 0.8) = 5 in a unit cube.
    assert_eq!(numbers[3], 16, "{numbers:?}");
    let soft = Impact {
        impulse: 5.0,
        energy: 1e6,
        ..impact_on(&cube, &mut Dice::new(50))
    };
    assert_eq!(
        fracturable.cutting(&soft, &cube, u32::MAX),
        None,
        "the impulse is below the strength"
    );
    let picky = Fracturable {
        min_energy: 100.0,
        ..fracturable
    };
    let weak = Impact {
        impulse: 20.0,
        energy: 99.0,
        ..soft
    };
    assert_eq!(picky.cutting(&weak, &cube, u32::MAX), None);
}

#[test]
fn energies_without_sense_break_nothing_or_everything() {
    let cube = primitives::cuboid(1.0, 1.0, 1.0).unwrap();
    for (energy, toughness) in [
        (0.0, 1.0),
        (-1.0, 1.0),
        (f64::NAN, 1.0),
        (0.0, 0.0),
        (1.0, f64::INFINITY),
    ] {
        assert_eq!(
            cells_for_energy(energy, toughness, &cube),
            1,
            "{energy} {toughness}"
        );
    }
    assert_eq!(cells_for_energy(f64::INFINITY, 1.0, &cube), u32::MAX);
    assert_eq!(cells_for_energy(1.0, 0.0, &cube), u32::MAX);
    for fracturable in [
        Fracturable {
            toughness: -1.0,
            ..Default::default()
        },
        Fracturable {
            toughness: f32::NAN,
            ..Default::default()
        },
        Fracturable {
            min_energy: -1.0,
            ..Default::default()
        },
        Fracturable {
            min_energy: f32::NAN,
            ..Default::default()
        },
    ] {
        assert!(fracturable.validate().is_err());
    }
}

#[test]
fn bodies_break_into_cells_in_a_simulation() {
    let brick = FracturePattern::Brick {
        size: Vec3::new(0.5, 0.25, 0.4),
    };
    let voronoi = FracturePattern::Voronoi {
        cells: 30,
        focus: 0.5,
    };
    for (pattern, count) in [(brick, 6), (voronoi, 30)] {
        let mut simulation = awake();
        let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
        simulation.bodies.insert(floor).unwrap();
        let shape = ConvexMesh::cuboid(1.0, 0.5, 0.4).unwrap();
        let mut desc = BodyDesc::dynamic(shape, Vec3::new(0.0, 2.0, 0.0));
        desc.angular_velocity = Vec3::new(0.3, 0.2, 0.1);
        let fracturable = Fracturable::with_strength(100.0).with_pattern(pattern.clone());
        desc.fracturable = Some(Fracturable {
            generations: 0,
            min_volume: 0.0,
            ..fracturable
        });
        simulation.bodies.insert(desc).unwrap();
        let mut broken = Vec::new();
        for _ in 0..60 {
            simulation.step(1.0 / 60.0);
            broken.append(&mut simulation.fractures.done.clone());
        }
        let [fracture] = &broken[..] else {
            panic!("{pattern:?}: {} fractures", broken.len());
        };
        assert!(fracture.pieces.len() >= count - 1, "{pattern:?}");
        let ledger = &fracture.ledger;
        assert!(ledger.mass_error() < 1e-6, "{pattern:?}");
        assert!(ledger.momentum_error() < 1e-5, "{pattern:?}");
        assert!(ledger.angular_momentum_error() < 1e-5, "{pattern:?}");
        assert!(ledger.energy_gain().abs() < 1e-5, "{pattern:?}");
    }
}

proptest! {
    #![proptest_config(cases(200))]

    /// Bodies anywhere, of any size and shape, hit anywhere.
    #[test]
    fn random_bodies_are_filled(seed in any::<u64>(), count in 4_usize..30, exponent in -3_i32..4) {
        let mut dice = Dice::new(seed);
        let scale = (0..exponent.abs()).fold(1.0, |s, _| if exponent < 0 { 0.1 * s } else { 10.0 * s });
        let center = scale * dice.vector(-3.0, 3.0);
        let flat = dice.vector(0.05, 1.0);
        let points: Vec<Vec3> = (0..count)
            .map(|_| center + scale * flat * (dice.unit() * dice.direction()))
            .collect();
        let Ok(hull) = ConvexHull::from_points(&points) else { return Ok(()) };
        let pose = Pose::new(Vec3::ZERO, Quat::IDENTITY);
        let all = patterns(&hull);
        let pattern = &all[dice.below(all.len())];
        let mut impact = impact_on(&hull, &mut dice);
        impact.point = pose.transform_point(impact.point + 0.1 * scale * dice.direction());
        impact.normal = dice.direction();
        if let Some(cutting) = pattern.cutting(&impact, &hull, seed, MOST) {
            let pieces = divide(&hull, None, &cutting);
            // Corners are rounded to f32, which moves walls by up to 6e-8 of the farthest coordinate; flat bodies far from
            // their origin have much surface for their volume.
            let scale = f64::from(length_scale(&hull.aabb()));
            let rounding = 6e-8 * scale * (hull.to_mesh().area() + wall_area(&hull, &pieces));
            let tolerance = VOLUME_TOLERANCE * hull.volume() + rounding;
            check_filled(&format!("{pattern:?}"), &hull, &pieces, tolerance, &mut dice);
        }
    }
}
