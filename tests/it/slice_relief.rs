//! Relief of cut faces over many bodies, divisions and amplitudes: pieces stay closed, fit each other, and weigh together what the
//! whole weighed.

use crate::common::dice::Dice;
use crate::common::mesh_parts::{torus, voxels};
use crate::models::model_mesh;
use crate::slice_common::{defect, impact_on};
use bevy_cleave::geometry::{ConvexHull, TriMesh, primitives};
use bevy_cleave::prelude::*;
use bevy_cleave::slice::{
    Cutting, FracturableError, FracturePattern, Piece, PieceCutter, Relief, SliceOptions,
};
use glam::{Vec2, Vec3};
use std::collections::HashMap;

/// A body, what is drawn of it, and its name.
struct Body {
    name: &'static str,
    hull: ConvexHull,
    mesh: TriMesh,
}

impl Body {
    /// With normals and texture coordinates, so that all attributes take part.
    fn new(name: &'static str, mesh: &TriMesh) -> Self {
        let faceted: Vec<Vec3> = (mesh.triangles().as_flattened().iter())
            .map(|&v| mesh.positions()[v as usize])
            .collect();
        let triangles: Vec<[u32; 3]> = (0..mesh.triangles().len() as u32)
            .map(|t| [3 * t, 3 * t + 1, 3 * t + 2])
            .collect();
        let normals: Vec<Vec3> = (faceted.chunks(3))
            .flat_map(|t| [(t[1] - t[0]).cross(t[2] - t[0]).normalize_or(Vec3::Y); 3])
            .collect();
        let uvs = faceted.iter().map(|p| Vec2::new(p.x, p.y)).collect();
        let mesh = TriMesh::new(faceted, triangles).unwrap();
        Self {
            name,
            hull: ConvexHull::from_points(mesh.positions()).unwrap(),
            mesh: (mesh.with_normals(normals).unwrap().with_uvs(uvs)).unwrap(),
        }
    }

    fn size(&self) -> f32 {
        self.hull.aabb().diagonal()
    }
}

fn bodies() -> Vec<Body> {
    let hull = |hull: Result<ConvexHull, _>| hull.unwrap().to_mesh();
    let u = [[0, 0, 0], [0, 1, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0]];
    vec![
        Body::new("cube", &hull(primitives::cuboid(1.0, 1.0, 1.0))),
        Body::new("slab", &hull(primitives::cuboid(2.0, 1.2, 0.1))),
        Body::new("ball", &hull(primitives::icosphere(0.6, 2))),
        Body::new("wedge", &hull(primitives::wedge(1.5, 0.4, 0.7))),
        Body::new("torus", &torus(0.5, 0.15, 24, 12)),
        Body::new("u", &voxels(&u)),
        Body::new("cow", &model_mesh("spot.obj")),
    ]
}

fn patterns(body: &Body) -> Vec<FracturePattern> {
    let (cells, focus) = (20, 0.5);
    vec![
        FracturePattern::RandomPlane,
        FracturePattern::Star { planes: 3 },
        FracturePattern::Voronoi { cells, focus },
        FracturePattern::EvenVoronoi { cells },
        FracturePattern::Radial { rays: 7, rings: 2 },
        FracturePattern::Slabs { count: 4 },
        FracturePattern::Brick {
            size: 0.31 * body.hull.aabb().extents(),
        },
    ]
}

/// The pieces as they were cut, and with a relief.
fn cut(body: &Body, cutting: &Cutting, most: usize, relief: &Relief, seed: u64) -> [Vec<Piece>; 2] {
    let mut cutter = PieceCutter::default();
    let options = SliceOptions::default();
    let mut pieces = cutter
        .cut(&body.hull, Some(&body.mesh), cutting, most, options)
        .unwrap();
    let flat = pieces.clone();
    cutter.roughen(&mut pieces, relief, seed);
    [flat, pieces]
}

fn visual(piece: &Piece) -> &TriMesh {
    piece.visual.as_ref().unwrap()
}

fn volume(pieces: &[Piece]) -> f64 {
    pieces.iter().map(|piece| visual(piece).volume()).sum()
}

/// How a division came out.
#[derive(Debug, Default)]
struct Sums {
    flat_triangles: usize,
    triangles: usize,
    moved: usize,
    /// Vertices that were moved, of which both sides do not have the same.
    lone: usize,
}

/// Checks one division, and adds it to `sums`.
fn check([flat, rough]: &[Vec<Piece>; 2], body: &Body, relief: &Relief, sums: &mut Sums) {
    let whole = body.mesh.volume();
    let (before, after) = (volume(flat), volume(rough));
    assert!((after - before).abs() <= 1e-6 * whole, "{before} {after}");
    assert_eq!(flat.len(), rough.len());
    let mut sides: HashMap<[u32; 3], usize> = HashMap::new();
    for (old, new) in flat.iter().zip(rough) {
        assert_eq!(old.hull, new.hull);
        assert_eq!(old.volume, new.volume);
        let [old, new] = [old, new].map(visual);
        sums.flat_triangles += old.triangles().len();
        sums.triangles += new.triangles().len();
        if old.triangles().is_empty() {
            continue;
        }
        assert_eq!(defect(new), None);
        // What was there stays where it was: rims, edges and corners.
        let known = old.positions().len();
        assert_eq!(old.positions(), &new.positions()[..known]);
        assert!(new.volume() > 0.0);
        check_triangles(new, known as u32, relief, body.size());
        for position in &new.positions()[known..] {
            *sides
                .entry(position.to_array().map(f32::to_bits))
                .or_default() += 1;
        }
    }
    sums.moved += sides.len();
    sums.lone += sides.values().filter(|&&count| count != 2).count();
}

/// Checks the triangles that have a new corner: they face as their normals do, and their texture is in metres.
fn check_triangles(mesh: &TriMesh, known: u32, relief: &Relief, size: f32) {
    let rounding = 1e-5 * size;
    for &triangle in mesh.triangles() {
        if triangle.iter().all(|&v| v < known) {
            continue;
        }
        let corners = triangle.map(|v| mesh.positions()[v as usize]);
        let area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        let longest = (0..3).map(|k| corners[k].distance(corners[(k + 1) % 3]));
        let longest = longest.fold(0.0, f32::max);
        for v in triangle {
            let normal = mesh.normals()[v as usize];
            assert!((normal.length() - 1.0).abs() < 1e-5);
            // Normals are means over the triangles around; none is on the other side, but for what the steepest bumps bend it.
            let steep = 8.0 * relief.amplitude / relief.wavelength;
            let turned = area.dot(normal) + rounding * longest;
            assert!(turned > 0.0 || steep > 0.5, "{triangle:?} {turned}");
        }
        for k in 0..3 {
            let [a, b] = [triangle[k], triangle[(k + 1) % 3]].map(|v| v as usize);
            let seen = mesh.positions()[a].distance(mesh.positions()[b]);
            let drawn = mesh.uvs()[a].distance(mesh.uvs()[b]);
            assert!(drawn <= seen + rounding, "{seen} {drawn}");
            assert!(
                drawn >= seen - 2.0 * relief.amplitude - rounding,
                "{seen} {drawn}"
            );
        }
    }
}

#[test]
fn pieces_with_relief_are_closed_and_fit_each_other() {
    let mut sums = Sums::default();
    let mut dice = Dice::new(34);
    for body in &bodies() {
        for pattern in patterns(body) {
            let wavelength = body.size() * dice.in_range(0.02, 0.15);
            let relief = Relief {
                amplitude: wavelength * [0.05, 0.25, 3.0][dice.below(3)],
                wavelength,
            };
            let impact = impact_on(&body.hull, &mut dice);
            let seed = dice.below(1000) as u64;
            let Some(cutting) = pattern.cutting(&impact, &body.hull, seed, 4096) else {
                continue;
            };
            let all = cut(body, &cutting, usize::MAX, &relief, seed);
            check(&all, body, &relief, &mut sums);
        }
    }
    assert!(sums.moved > 20_000, "{sums:?}");
    assert_eq!(sums.lone, 0, "{sums:?}");
}

#[test]
fn the_face_of_one_piece_fits_those_of_several() {
    // The last plane of a star leaves some pieces whole, so that one face lies on two; so do bricks in courses.
    let mut sums = Sums::default();
    for (seed, body) in (0..).zip(&bodies()[..5]) {
        let mut dice = Dice::new(seed);
        let relief = Relief::of_size(0.1 * body.size());
        for most in 3..8 {
            let planes = (0..6).map(|_| {
                let at = 0.2 * body.size() * dice.direction();
                bevy_cleave::math::Plane::through(0.5 * at, dice.direction())
            });
            let cutting = Cutting::Planes(planes.collect());
            let all = cut(body, &cutting, most, &relief, seed);
            check(&all, body, &relief, &mut sums);
        }
    }
    assert!(sums.moved > 2_000 && sums.lone == 0, "{sums:?}");
}

#[test]
fn the_same_seed_gives_the_same_relief_and_another_another() {
    let body = &bodies()[0];
    let sites = (0..9).map(|i| 0.4 * Dice::new(i).direction()).collect();
    let (cutting, relief) = (Cutting::Sites(sites), Relief::of_size(0.1));
    let [_, first] = cut(body, &cutting, 99, &relief, 7);
    let [_, second] = cut(body, &cutting, 99, &relief, 7);
    let [_, other] = cut(body, &cutting, 99, &relief, 8);
    let meshes = |pieces: &[Piece]| pieces.iter().map(|p| visual(p).clone()).collect::<Vec<_>>();
    assert_eq!(meshes(&first), meshes(&second));
    assert_ne!(meshes(&first), meshes(&other));
}

#[test]
fn pieces_with_relief_are_cut_again_and_stay_closed() {
    for body in &bodies()[..6] {
        let mut dice = Dice::new(5);
        let relief = Relief::of_size(0.08 * body.size());
        let mut cutter = PieceCutter::default();
        let options = SliceOptions::default();
        let mut pieces = vec![Piece {
            hull: body.hull.clone(),
            visual: Some(body.mesh.clone()),
            volume: body.hull.volume(),
        }];
        for generation in 0..3 {
            let mut next = Vec::new();
            for piece in pieces {
                let through = piece.hull.aabb().center();
                let plane = bevy_cleave::math::Plane::through(through, dice.direction());
                let cutting = Cutting::Planes([plane].into_iter().collect());
                let mut parts = (cutter)
                    .cut(&piece.hull, piece.visual.as_ref(), &cutting, 99, options)
                    .unwrap();
                cutter.roughen(&mut parts, &relief, generation);
                next.extend(parts);
            }
            pieces = next;
            let whole = body.mesh.volume();
            assert!(
                (volume(&pieces) - whole).abs() < 2e-6 * whole,
                "{}",
                body.name
            );
            for piece in &pieces {
                assert_eq!(defect(visual(piece)), None, "{}", body.name);
            }
        }
    }
}

/// A block that is blown to pieces by what is asked for.
fn break_block(fracturable: Fracturable, visual: bool) -> Simulation {
    let mut simulation = Simulation::default();
    let floor = BodyDesc::floor(HalfSpaceShape { normal: Vec3::Y });
    simulation.bodies.insert(floor).unwrap();
    let mut shape = ConvexMesh::cuboid(1.0, 1.0, 1.0).unwrap();
    if visual {
        shape = ConvexMesh::from_mesh(shape.hull().to_mesh())
            .unwrap()
            .with_mass_of_visual();
    }
    let block = BodyDesc {
        fracturable: Some(fracturable),
        ..BodyDesc::dynamic(shape, Vec3::new(0.0, 4.0, 0.0))
    };
    simulation.bodies.insert(block).unwrap();
    for _ in 0..150 {
        simulation.step(1.0 / 60.0);
    }
    simulation
}

fn brittle() -> Fracturable {
    let (cells, focus) = (12, 0.0);
    Fracturable::with_strength(50.0).with_pattern(FracturePattern::Voronoi { cells, focus })
}

#[test]
fn relief_changes_what_is_drawn_and_nothing_else() {
    let flat = break_block(brittle(), false);
    let rough = break_block(brittle().with_relief(Relief::of_size(0.15)), false);
    let poses = |simulation: &Simulation| -> Vec<_> {
        let bodies = &simulation.bodies;
        bodies
            .iter()
            .map(|slot| (slot, bodies.pose(slot)))
            .collect()
    };
    assert!(flat.bodies.len() > 12);
    // Bit for bit, second generation included: hulls, masses and the order of pieces are the same.
    assert_eq!(poses(&flat), poses(&rough));
    let triangles = |simulation: &Simulation| -> usize {
        let bodies = &simulation.bodies;
        let shapes = bodies.iter().filter_map(|slot| bodies.convex(slot));
        shapes
            .map(|shape| shape.render_mesh().triangles().len())
            .sum()
    };
    assert!(triangles(&rough) > 3 * triangles(&flat));
}

#[test]
fn what_weighs_as_its_mesh_weighs_the_same_in_pieces_with_relief() {
    let rough = break_block(brittle().with_relief(Relief::of_size(0.15)), true);
    let bodies = &rough.bodies;
    let masses = bodies.iter().map(|slot| f64::from(bodies.mass(slot).mass));
    let sum: f64 = masses.sum();
    assert!((sum / 1000.0 - 1.0).abs() < 1e-5, "{sum}");
    for slot in bodies.iter() {
        let Some(mesh) = bodies.convex(slot).and_then(ConvexMesh::visual) else {
            continue;
        };
        let mass = f64::from(bodies.mass(slot).mass);
        assert!(
            (mass / (1000.0 * mesh.volume()) - 1.0).abs() < 1e-5,
            "{mass}"
        );
    }
}

#[test]
fn a_relief_without_lengths_is_refused() {
    for (amplitude, wavelength) in [
        (0.0, 1.0),
        (1.0, -1.0),
        (f32::NAN, 1.0),
        (1.0, f32::INFINITY),
    ] {
        let relief = Relief {
            amplitude,
            wavelength,
        };
        let refused = brittle().with_relief(relief).validate();
        assert!(matches!(refused, Err(FracturableError::Relief(_))));
    }
}
