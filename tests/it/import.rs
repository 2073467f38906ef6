//! Models as artists make them: what is wrong with them, made on purpose, and what the import does about it.

use crate::common::dice::Dice;
use crate::common::mesh_parts::{cuboid, joined};
use crate::models::model_mesh;
use bevy_cleave::geometry::{TriMesh, primitives};
use bevy_cleave::import::{
    Import, ImportError, ImportOptions, Model, ModelObject, OpenParts, PartState,
};
use bevy_cleave::math::Plane;
use bevy_cleave::slice::{Cut, SliceOptions, slice_mesh};
use glam::{IVec3, Vec2, Vec3};

fn object(mesh: &TriMesh) -> ModelObject {
    ModelObject {
        name: "thing".into(),
        positions: mesh.positions().to_vec(),
        triangles: mesh.triangles().to_vec(),
        ..ModelObject::default()
    }
}

fn import(object: ModelObject) -> Import {
    let model = Model::from_object(object);
    model.import(&ImportOptions::default()).unwrap()
}

/// Whether all but the sheets is closed, by a look of its own: every directed edge once, and its reverse once.
fn is_closed(mesh: &TriMesh) -> bool {
    let number = |v: u32| mesh.topology()[v as usize];
    let solid = mesh.triangles()[mesh.sheets()..]
        .iter()
        .map(|t| t.map(number));
    let mut edges: Vec<[u32; 2]> = solid
        .flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]])
        .collect();
    edges.sort_unstable();
    let is_once = edges.windows(2).all(|pair| pair[0] != pair[1]);
    is_once
        && edges
            .iter()
            .all(|&[a, b]| a != b && edges.binary_search(&[b, a]).is_ok())
}

/// Cuts a mesh, and one part of it again, and checks that all stays closed and nothing is lost.
fn check_cuts(mesh: &TriMesh, dice: &mut Dice, context: &str) {
    assert!(is_closed(mesh), "{context}");
    assert!(mesh.is_closed(), "{context}");
    let mut part = mesh.clone();
    for _ in 0..3 {
        let plane = dice.plane_through(part.positions());
        let Cut::Cut(halves) = slice_mesh(&part, plane, SliceOptions::default()).unwrap() else {
            continue;
        };
        let volumes = [&halves.below, &halves.above].map(|half| {
            assert!(is_closed(half), "{context} {plane:?}");
            half.volume()
        });
        let error = (volumes[0] + volumes[1] - part.volume()).abs();
        assert!(
            error <= 1e-5 * mesh.volume().abs().max(1e-3),
            "{context} {plane:?}: {error}"
        );
        let sheets = halves.below.sheets() + halves.above.sheets();
        assert!(sheets >= part.sheets(), "{context}: sheets are lost");
        part = if dice.below(2) == 0 {
            halves.below
        } else {
            halves.above
        };
    }
}

/// The shapes that faults are put into; all about 1 m, none symmetric in its triangles.
fn solids() -> Vec<TriMesh> {
    vec![
        cuboid(Vec3::new(1.0, 0.7, 0.4), Vec3::new(0.1, 0.2, 0.3)),
        primitives::icosphere(0.5, 2).unwrap().to_mesh(),
        primitives::regular_prism(7, 0.4, 0.9).unwrap().to_mesh(),
        model_mesh("stairs.obj"),
        model_mesh("key.obj"),
        model_mesh("plate.obj"),
    ]
}

/// What an artist or a tool may do to a model.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    OpenUnderside,
    Holes,
    DoubledFaces,
    InsideOut,
    SomeTurned,
    FourFaces,
    Divided,
    Unwelded,
    WithoutArea,
    SplitVertices,
    TwoSided,
    Leaf,
    TouchingCorner,
}

const FAULTS: [Fault; 13] = [
    Fault::OpenUnderside,
    Fault::Holes,
    Fault::DoubledFaces,
    Fault::InsideOut,
    Fault::SomeTurned,
    Fault::FourFaces,
    Fault::Divided,
    Fault::Unwelded,
    Fault::WithoutArea,
    Fault::SplitVertices,
    Fault::TwoSided,
    Fault::Leaf,
    Fault::TouchingCorner,
];

impl Fault {
    /// Whether the volume is known to stay what it was.
    fn keeps_volume(self) -> bool {
        !matches!(self, Self::Holes | Self::FourFaces | Self::TouchingCorner)
    }

    fn put_into(self, o: &mut ModelObject, dice: &mut Dice) {
        let count = o.triangles.len();
        let corners = |o: &ModelObject, t: usize| o.triangles[t].map(|v| o.positions[v as usize]);
        let min = o.positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
        let max = o
            .positions
            .iter()
            .copied()
            .fold(Vec3::NEG_INFINITY, Vec3::max);
        match self {
            Self::OpenUnderside => {
                let positions = o.positions.clone();
                let bottom =
                    |t: &[u32; 3]| t.iter().all(|&v| positions[v as usize].y <= min.y + 1e-6);
                let left: Vec<_> = o.triangles.iter().copied().filter(|t| !bottom(t)).collect();
                if left.len() > count / 2 {
                    o.triangles = left;
                }
            }
            Self::Holes => {
                for _ in 0..1 + count / 60 {
                    let t = dice.below(o.triangles.len());
                    o.triangles.remove(t);
                }
            }
            Self::DoubledFaces => {
                for _ in 0..count {
                    let [a, b, c] = o.triangles[dice.below(count)];
                    o.triangles.push([b, c, a]);
                }
            }
            Self::InsideOut => o.triangles.iter_mut().for_each(|t| t.swap(0, 1)),
            Self::SomeTurned => {
                for _ in 0..count / 5 {
                    o.triangles[dice.below(count)].swap(1, 2);
                }
            }
            Self::FourFaces => {
                // A box that shares an edge with another one, by position.
                let at = Vec3::new(max.x + 0.5, max.y + 0.5, max.z + 0.5);
                for offset in [Vec3::ZERO, Vec3::new(1.0, 1.0, 0.0)] {
                    push(o, &cuboid(Vec3::ONE, at + offset));
                }
            }
            Self::Divided => {
                // A corner in the middle of one side of an edge that its neighbor does not have.
                let t = dice.below(count);
                let [a, b, c] = o.triangles[t];
                let middle = 0.5 * (o.positions[a as usize] + o.positions[b as usize]);
                push_vertex(o, middle, a);
                let m = o.positions.len() as u32 - 1;
                o.triangles[t] = [a, m, c];
                o.triangles.push([m, b, c]);
            }
            Self::Unwelded => {
                // One triangle moved off its neighbors by much less than anything can be seen.
                let t = dice.below(count);
                let moved = corners(o, t).map(|p| p + 2e-7 * (max - min).length());
                let old = o.triangles[t];
                for (k, position) in moved.into_iter().enumerate() {
                    push_vertex(o, position, old[k]);
                    o.triangles[t][k] = o.positions.len() as u32 - 1;
                }
            }
            Self::WithoutArea => {
                let [a, b, _] = o.triangles[dice.below(count)];
                o.triangles.push([a, b, b]);
                o.triangles.push([a, a, a]);
            }
            Self::SplitVertices => {
                let old = o.triangles.clone();
                for (t, k) in (0..count).flat_map(|t| (0..3).map(move |k| (t, k))) {
                    push_vertex(o, o.positions[old[t][k] as usize], old[t][k]);
                    o.triangles[t][k] = o.positions.len() as u32 - 1;
                }
            }
            Self::TwoSided => {
                // A card of two triangles, seen from both sides.
                let first = push_card(o, max + 0.1);
                o.triangles
                    .extend([[first, first + 2, first + 1], [first, first + 3, first + 2]]);
            }
            Self::Leaf => {
                push_card(o, max + 0.1);
            }
            Self::TouchingCorner => {
                // A box that touches the solid in one of its corners only.
                let corner = o.positions[o.triangles[0][0] as usize];
                push(o, &cuboid(Vec3::ONE, corner + 0.5));
            }
        }
    }
}

fn push_vertex(o: &mut ModelObject, position: Vec3, like: u32) {
    o.positions.push(position);
    let uv = o.uvs.get(like as usize).copied();
    o.uvs.extend(uv);
}

fn push(o: &mut ModelObject, mesh: &TriMesh) {
    let first = o.positions.len() as u32;
    mesh.positions().iter().for_each(|&p| push_vertex(o, p, 0));
    o.triangles
        .extend(mesh.triangles().iter().map(|t| t.map(|v| first + v)));
}

fn push_card(o: &mut ModelObject, at: Vec3) -> u32 {
    let first = o.positions.len() as u32;
    for corner in [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.2), Vec3::Y] {
        push_vertex(o, at + 0.3 * corner, 0);
    }
    o.triangles
        .extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    first
}

#[test]
fn every_fault_in_every_solid_is_repaired_and_cuts_stay_closed() {
    let mut dice = Dice::new(61);
    for (index, solid) in solids().iter().enumerate() {
        for fault in FAULTS {
            let mut faulty = object(solid);
            fault.put_into(&mut faulty, &mut dice);
            let context = format!("{fault:?} in solid {index}");
            let import = import(faulty);
            if fault.keeps_volume() {
                let error = (import.mesh.volume() - solid.volume()).abs() / solid.volume();
                assert!(error < 1e-4, "{context}: {error}\n{}", import.report);
            }
            for _ in 0..4 {
                check_cuts(&import.mesh, &mut dice, &context);
            }
            import.shape().unwrap();
        }
    }
}

#[test]
fn several_faults_at_once_never_leave_a_cut_open() {
    let mut dice = Dice::new(62);
    for round in 0..400 {
        let solids = solids();
        let mut faulty = object(&solids[dice.below(solids.len())]);
        faulty.uvs = vec![Vec2::new(0.25, 0.75); faulty.positions.len()];
        let faults: Vec<Fault> = (0..1 + dice.below(5))
            .map(|_| FAULTS[dice.below(FAULTS.len())])
            .collect();
        faults
            .iter()
            .for_each(|fault| fault.put_into(&mut faulty, &mut dice));
        let context = format!("round {round}: {faults:?}");
        let open_parts = [
            OpenParts::Ride,
            OpenParts::LeaveOut,
            OpenParts::Thicken(0.01),
        ][dice.below(3)];
        let options = ImportOptions {
            open_parts,
            max_fill: dice.unit(),
            ..ImportOptions::default()
        };
        match Model::from_object(faulty).import(&options) {
            Ok(import) => {
                assert!(
                    import
                        .mesh
                        .uvs()
                        .iter()
                        .all(|&uv| uv.distance(Vec2::new(0.25, 0.75)) < 1e-6)
                );
                check_cuts(&import.mesh, &mut dice, &context);
            }
            Err(error) => assert!(
                matches!(error, ImportError::NothingSolid { .. }),
                "{context}: {error}"
            ),
        }
    }
}

#[test]
fn random_triangles_are_refused_or_closed() {
    let mut dice = Dice::new(63);
    for round in 0..300 {
        // Few places, so that edges of many triangles and doubled triangles are common.
        let positions: Vec<Vec3> = (0..6 + dice.below(8))
            .map(|_| dice.vector(-1.0, 1.0))
            .collect();
        let count = positions.len();
        let triangles = (0..4 + dice.below(40))
            .map(|_| [(); 3].map(|()| dice.below(count) as u32))
            .collect();
        let soup = ModelObject {
            positions,
            triangles,
            ..ModelObject::default()
        };
        let options = ImportOptions {
            max_fill: 10.0,
            ..ImportOptions::default()
        };
        if let Ok(import) = Model::from_object(soup).import(&options) {
            assert!(is_closed(&import.mesh), "round {round}");
            for _ in 0..3 {
                let plane = dice.plane_through(import.mesh.positions());
                if let Cut::Cut(halves) =
                    slice_mesh(&import.mesh, plane, SliceOptions::default()).unwrap()
                {
                    assert!(
                        is_closed(&halves.below) && is_closed(&halves.above),
                        "round {round}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_closed_model_is_taken_as_it_is() {
    for solid in solids() {
        let import = import(object(&solid));
        assert!(import.report.is_untouched(), "{}", import.report);
        assert_eq!(import.mesh.triangles().len(), solid.triangles().len());
        assert_eq!(import.mesh.volume(), solid.volume());
    }
}

#[test]
fn a_tube_that_stands_open_gets_a_ring_as_underside() {
    let (outer, inner) = (
        primitives::regular_prism(12, 0.5, 1.0).unwrap(),
        primitives::regular_prism(12, 0.4, 1.0).unwrap(),
    );
    let open = |mesh: TriMesh| {
        let positions = mesh.positions().to_vec();
        let is_side = |t: &&[u32; 3]| {
            let heights = t.map(|v| positions[v as usize].y);
            heights.iter().any(|&y| y > 0.1) && heights.iter().any(|&y| y < -0.1)
        };
        let sides = mesh.triangles().iter().filter(is_side).copied().collect();
        TriMesh::new(mesh.positions().to_vec(), sides).unwrap()
    };
    let tube = joined(&[
        (open(outer.to_mesh()), false),
        (open(inner.to_mesh()), true),
    ]);
    // Two walls that nothing joins: each is closed as a solid of its own, and the inner one is a hollow.
    let import = import(object(&tube));
    assert!(
        (import.mesh.volume() / (outer.volume() - inner.volume()) - 1.0).abs() < 1e-5,
        "{}",
        import.report
    );
}

#[test]
fn the_report_names_the_part_and_the_place() {
    let mut box_without_bottom = object(&cuboid(Vec3::ONE, Vec3::new(3.0, 0.5, 0.0)));
    Fault::OpenUnderside.put_into(&mut box_without_bottom, &mut Dice::new(1));
    box_without_bottom.name = "crate".into();
    let mut flag = ModelObject {
        name: "flag".into(),
        ..ModelObject::default()
    };
    push_card(&mut flag, Vec3::ZERO);
    let model = Model {
        objects: vec![box_without_bottom, flag],
        ..Model::default()
    };
    let imported = model.import(&ImportOptions::default()).unwrap();
    let [part, flag] = &imported.report.parts[..] else {
        panic!("{}", imported.report)
    };
    assert_eq!(
        (part.name.as_str(), part.state),
        ("crate", PartState::Repaired)
    );
    assert!((part.fill_share - 0.2).abs() < 1e-3);
    assert_eq!(part.holes.len(), 1);
    assert!(
        part.holes[0].center.distance(Vec3::new(3.0, 0.0, 0.0)) < 1e-3,
        "{part}"
    );
    assert_eq!(
        (flag.name.as_str(), flag.state),
        ("flag", PartState::Riding)
    );
    assert_eq!(imported.mesh.sheets(), 2);
    let text = imported.report.to_string();
    assert!(
        text.contains("crate")
            && text.contains("filled a hole with 4 edges at (3.000, 0.000, 0.000)"),
        "{text}"
    );
    // As asked for.
    let with = |options: ImportOptions| model.import(&options);
    let none = ImportOptions {
        max_fill: 0.1,
        ..ImportOptions::default()
    };
    let error = with(none).unwrap_err().to_string();
    assert!(
        error.contains("crate") && error.contains("max_fill") && error.contains("Thicken"),
        "{error}"
    );
    let left_out = ImportOptions {
        open_parts: OpenParts::LeaveOut,
        ..ImportOptions::default()
    };
    assert_eq!(with(left_out).unwrap().mesh.sheets(), 0);
    let thick = ImportOptions {
        open_parts: OpenParts::Thicken(0.01),
        ..ImportOptions::default()
    };
    let thick = with(thick).unwrap();
    assert_eq!(thick.report.count(PartState::Thickened), 1);
    assert!((thick.mesh.volume() - imported.mesh.volume() - 0.01 * 0.09 * 1.03).abs() < 1e-4);
}

#[test]
fn hollows_stay_and_inward_parts_beside_others_are_turned() {
    let (large, small) = (cuboid(Vec3::splat(2.0), Vec3::ZERO), Vec3::splat(0.5));
    let hollow = joined(&[(large.clone(), false), (cuboid(small, Vec3::ZERO), true)]);
    let import_of = |mesh: &TriMesh| import(object(mesh));
    let hollow = import_of(&hollow);
    assert!((hollow.mesh.volume() - (8.0 - 0.125)).abs() < 1e-6);
    assert_eq!(hollow.report.count(PartState::Hollow), 1);
    let beside = joined(&[
        (large, false),
        (cuboid(small, Vec3::new(1.25, 0.0, 0.0)), true),
    ]);
    let beside = import_of(&beside);
    assert!((beside.mesh.volume() - (8.0 + 0.125)).abs() < 1e-6);
    assert!(
        beside
            .report
            .parts
            .iter()
            .any(|part| part.repairs.inside_out)
    );
}

#[test]
fn sheets_are_cut_without_caps_and_go_with_what_they_hang_on() {
    let mut thing = object(&cuboid(Vec3::ONE, Vec3::ZERO));
    push_card(&mut thing, Vec3::new(0.6, -0.15, 0.0));
    let import = import(thing);
    let through = Plane::through(Vec3::ZERO, Vec3::Y);
    let halves = slice_mesh(&import.mesh, through, SliceOptions::default())
        .unwrap()
        .halves()
        .unwrap();
    assert!((halves.cap.area - 1.0).abs() < 1e-6);
    for half in [&halves.below, &halves.above] {
        assert!(half.sheets() > 0 && is_closed(half));
        assert_eq!(bevy_cleave::slice::split_components(half).len(), 1);
    }
    // A sheet alone on one side.
    let beyond = Plane::through(Vec3::new(0.55, 0.0, 0.0), Vec3::X);
    let halves = slice_mesh(&import.mesh, beyond, SliceOptions::default())
        .unwrap()
        .halves()
        .unwrap();
    assert_eq!(halves.above.sheets(), halves.above.triangles().len());
}

#[test]
fn bad_input_is_named() {
    let good = object(&cuboid(Vec3::ONE, Vec3::ZERO));
    let refuse = |object: ModelObject| {
        Model::from_object(object)
            .import(&ImportOptions::default())
            .unwrap_err()
    };
    let mut bad = good.clone();
    bad.positions[3].y = f32::NAN;
    assert!(matches!(
        refuse(bad),
        ImportError::NotFinite { vertex: 3, .. }
    ));
    let mut bad = good.clone();
    bad.triangles[1][2] = 999;
    assert!(matches!(
        refuse(bad),
        ImportError::IndexOutOfRange {
            triangle: 1,
            index: 999,
            ..
        }
    ));
    let mut bad = good.clone();
    bad.uvs.push(Vec2::ZERO);
    assert!(matches!(
        refuse(bad),
        ImportError::AttributeLength { found: 1, .. }
    ));
    assert_eq!(refuse(ModelObject::default()), ImportError::NoTriangles);
    let options = ImportOptions {
        max_fill: f32::NAN,
        ..ImportOptions::default()
    };
    let error = Model::from_object(good).import(&options).unwrap_err();
    assert!(matches!(
        error,
        ImportError::BadOption {
            option: "max_fill",
            ..
        }
    ));
}

/// The surface of random cells, faces side by side merged into rectangles of random lengths along a random axis of each plane, each with
/// corners of its own; and the number of cells.
fn random_strips(dice: &mut Dice) -> (ModelObject, usize) {
    const SIZE: i32 = 5;
    let share = dice.in_range(0.2, 0.8);
    let is_solid: Vec<bool> = (0..SIZE.pow(3)).map(|_| dice.unit() < share).collect();
    let at = |p: IVec3| {
        let is_inside = p.cmpge(IVec3::ZERO).all() && p.cmplt(IVec3::splat(SIZE)).all();
        is_inside && is_solid[(p.x + SIZE * (p.y + SIZE * p.z)) as usize]
    };
    let mut strips = ModelObject::default();
    for (axis, sign, depth) in (0..6 * SIZE).map(|i| (i / 2 % 3, i % 2 * 2 - 1, i / 6)) {
        let normal = IVec3::AXES[axis as usize];
        let turn = 1 + dice.below(2);
        let [u, v] = [turn, 3 - turn].map(|k| IVec3::AXES[(axis as usize + k) % 3]);
        let is_face = |p: IVec3| at(p) && !at(p + sign * normal);
        for row in 0..SIZE {
            let mut start = 0;
            while start < SIZE {
                let cell = |k: i32| depth * normal + k * u + row * v;
                let most = 1 + dice.below(SIZE as usize) as i32;
                let end = (start..SIZE.min(start + most)).take_while(|&k| is_face(cell(k)));
                let length = end.count() as i32;
                if length > 0 {
                    let base = cell(start) + if sign > 0 { normal } else { IVec3::ZERO };
                    let along = length * u;
                    let first = strips.positions.len() as u32;
                    let corners = [base, base + along, base + along + v, base + v];
                    strips
                        .positions
                        .extend(corners.map(|corner| 0.3 * corner.as_vec3()));
                    // Counter-clockwise from outside.
                    let is_turned = (sign > 0) == (turn == 1);
                    let quad = [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|k: u32| first + k));
                    let seen = |[a, b, c]: [u32; 3]| if is_turned { [a, b, c] } else { [a, c, b] };
                    strips.triangles.extend(quad.map(seen));
                }
                start += length.max(1);
            }
        }
    }
    (strips, is_solid.iter().filter(|&&solid| solid).count())
}

#[test]
fn faces_merged_into_strips_are_divided_until_they_have_whole_edges_in_common() {
    let mut dice = Dice::new(346);
    for round in 0..60 {
        let (strips, cells) = random_strips(&mut dice);
        let model = Model::from_object(strips);
        let import = model.import(&ImportOptions::default());
        let import = import.unwrap_or_else(|error| panic!("round {round}: {error}"));
        let volume = cells as f64 * 0.027;
        let error = (import.mesh.volume() - volume).abs();
        assert!(error < 1e-5 * volume, "round {round}: {error} of {volume}");
        check_cuts(&import.mesh, &mut dice, &format!("round {round}"));
    }
}
