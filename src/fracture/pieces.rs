//! What becomes of a body that breaks: its pieces, first as shapes, then as bodies.

use crate::bodies::anchors::Hold;
use crate::bodies::body::{BodyDesc, RigidBody, Shape};
use crate::bodies::store::Bodies;
use crate::fracture::budget::FractureBudget;
use crate::fracture::conservation::{keep_mass, keep_momentum};
use crate::fracture::holding::Foothold;
use crate::fracture::ledger::{Invariants, Ledger, Reference};
use crate::fracture::{CutError, Fracture};
use crate::geometry::{Compound, ConvexHull, ConvexMesh, HullError, TriMesh};
use crate::mass::VolumeIntegrals;
use crate::math::{Plane, Pose, rotate};
use crate::slice::fracturable::Fracturable;
use crate::slice::separate::fit_hulls;
use crate::slice::{Cutting, Piece, PieceCutter, SliceError, SliceOptions};
use glam::{Quat, Vec3};
use smallvec::SmallVec;

/// How one body is to be divided.
#[derive(Clone, Debug)]
pub(super) struct BreakPlan {
    pub(super) slot: u32,
    /// What a blow makes of it.
    pub(super) blow: Option<Cutting>,
    /// Planes of cuts that were asked for, body's frame; they go through all that the blow leaves.
    pub(super) cuts: SmallVec<[Plane; 8]>,
    /// Most pieces that the blow may make.
    pub(super) most: usize,
    /// Of a body of several parts, the one that the blow divides.
    pub(super) struck: Option<usize>,
}

/// The pieces of one body, in its frame.
#[derive(Clone, Debug)]
pub(super) struct PieceSet {
    pieces: Vec<Piece>,
    /// The same of a body of several parts.
    compounds: Vec<Compound>,
    /// What the cuts left, if air that they held is none of the pieces, and had counted as material.
    halves: Vec<ConvexHull>,
    /// Area of the cracks, m2: half of what the surface has grown by.
    crack_area: f64,
    /// The planes of the cuts, and those of a blow that divides by planes, body's frame.
    planes: SmallVec<[Plane; 8]>,
}

impl PieceSet {
    pub(super) fn new(
        bodies: &Bodies,
        plan: &BreakPlan,
        cutter: &mut PieceCutter,
    ) -> Result<Self, CutError> {
        if let Some(compound) = bodies.compound(plan.slot) {
            return Self::of_compound(bodies, plan, compound, cutter);
        }
        let mesh = bodies.convex(plan.slot).ok_or(CutError::NotConvex)?;
        let looks = bodies.cut_looks(plan.slot);
        let visual = looks.visual_of(mesh);
        let visual = visual.as_deref();
        let pieces = pieces_of(mesh.hull(), visual, plan, (cutter, looks.options))?;
        Self::of_pieces(bodies, plan, pieces, cutter)
    }

    /// The same of what its cuts have made.
    pub(super) fn of_pieces(
        bodies: &Bodies,
        plan: &BreakPlan,
        mut pieces: Vec<Piece>,
        cutter: &mut PieceCutter,
    ) -> Result<Self, CutError> {
        let mesh = bodies.convex(plan.slot).ok_or(CutError::NotConvex)?;
        let looks = bodies.cut_looks(plan.slot);
        let surface: f64 = pieces.iter().map(|piece| piece.hull.area()).sum();
        let crack_area = 0.5 * (surface - mesh.hull().area());
        let mut halves = Vec::new();
        if looks.has_visual(mesh) {
            halves.extend(pieces.iter().map(|piece| piece.hull.clone()));
            let air = pieces.len();
            pieces.retain(Piece::is_seen);
            let mut is_changed = pieces.len() != air;
            if !looks.keeps_parts {
                let joined = pieces.len();
                cutter.separate(&mut pieces)?;
                is_changed |= pieces.len() != joined;
            }
            is_changed |= fit_hulls(&mut pieces, looks.amplitude())?;
            // Where the mesh has the mass, the air never had any.
            if !is_changed || mesh.weighs_visual() {
                halves.clear();
            }
        }
        if pieces.len() < 2 {
            return Err(CutError::Missed);
        }
        if let Some((relief, seed)) = &looks.relief {
            cutter.roughen(&mut pieces, relief, *seed);
        }
        let mut planes = plan.cuts.clone();
        if let Some(Cutting::Planes(blow)) = &plan.blow {
            planes.extend_from_slice(blow);
        }
        Ok(Self {
            pieces,
            compounds: Vec::new(),
            halves,
            crack_area,
            planes,
        })
    }

    /// The pieces of a body of several parts: a blow divides the part that it struck, and cuts go through all.
    fn of_compound(
        bodies: &Bodies,
        plan: &BreakPlan,
        compound: &Compound,
        cutter: &mut PieceCutter,
    ) -> Result<Self, CutError> {
        let looks = bodies.cut_looks(plan.slot);
        let broken = match (&plan.blow, plan.struck) {
            (Some(blow), Some(struck)) => {
                let how = (blow, plan.most);
                cutter.break_part(compound, struck, how, &looks)?
            }
            _ => vec![compound.clone()],
        };
        let mut compounds = Vec::with_capacity(broken.len());
        for piece in broken {
            compounds.extend(cutter.cut_compound(&piece, &plan.cuts, &looks)?);
        }
        if compounds.len() < 2 {
            return Err(CutError::Missed);
        }
        let area = |compound: &Compound| -> f64 {
            let parts = compound.parts().iter();
            parts.map(|part| part.shape.hull().area()).sum()
        };
        let surface: f64 = compounds.iter().map(area).sum();
        Ok(Self {
            pieces: Vec::new(),
            crack_area: 0.5 * (surface - area(compound)).max(0.0),
            compounds,
            halves: Vec::new(),
            planes: plan.cuts.clone(),
        })
    }

    /// Number of pieces.
    pub(super) fn len(&self) -> usize {
        self.pieces.len() + self.compounds.len()
    }

    /// Area of the cracks, m2: half of what the surface has grown by.
    pub(super) fn crack_area(&self) -> f64 {
        self.crack_area
    }
}

/// The pieces of a hull and what rides in it: what the blow makes of it, and then the cuts.
fn pieces_of(
    hull: &ConvexHull,
    visual: Option<&TriMesh>,
    plan: &BreakPlan,
    (cutter, options): (&mut PieceCutter, SliceOptions),
) -> Result<Vec<Piece>, SliceError> {
    let whole = Cutting::Planes(SmallVec::new());
    let blow = plan.blow.as_ref().unwrap_or(&whole);
    let mut pieces = cutter.cut(hull, visual, blow, plan.most, options)?;
    cutter.cut_pieces(&mut pieces, &plan.cuts, usize::MAX, options)?;
    Ok(pieces)
}

/// Replaces the body in `slot` by its pieces, which move as its parts did, or leaves it as it is.
pub(super) fn replace(
    bodies: &mut Bodies,
    slot: u32,
    division: PieceSet,
    budget: &FractureBudget,
) -> Result<Fracture, CutError> {
    let reference = Reference::of(bodies, slot);
    let foothold = Foothold::of(bodies, slot);
    let mut pieces: Vec<BodyDesc> = (division.pieces.into_iter())
        .map(|piece| piece_desc(bodies, slot, piece.hull, piece.visual))
        .collect();
    for piece in &division.compounds {
        pieces.push(compound_desc(bodies, slot, piece).map_err(SliceError::from)?);
    }
    let mut halves: Vec<BodyDesc> = (division.halves.into_iter())
        .map(|half| piece_desc(bodies, slot, half, None))
        .collect();
    keep_mass(bodies, slot, &mut pieces, &mut halves);
    let mut ledger = Ledger::default();
    ledger.before.add_body(bodies, slot, &reference);
    ledger.dropped = lost_between_parts(&pieces, &halves, &reference);
    let holds = match &foothold {
        Some(foothold) => foothold.keep(bodies, &mut pieces),
        None => vec![None; pieces.len()],
    };
    let pieces: Vec<_> = pieces.into_iter().zip(holds).collect();
    let (kept, numbers) = insert(bodies, slot, pieces, budget, &mut ledger, &reference);
    if kept.len() < 2 {
        kept.iter().for_each(|&s| bodies.remove(s));
        return Err(CutError::TooSmall);
    }
    keep_momentum(bodies, &kept, &mut ledger, &reference);
    let to_world = bodies.pose(slot).inverse();
    let planes = division.planes.iter();
    let mut fracture = Fracture {
        parent: bodies.id(slot),
        parent_slot: slot,
        ids: kept.iter().map(|&piece| bodies.id(piece)).collect(),
        pieces: kept,
        numbers,
        planes: planes.map(|p| p.in_frame_of(&to_world)).collect(),
        ledger,
        fallen: Vec::new(),
        blow: None,
        waited: None,
        is_load: false,
        goes_on: false,
    };
    let Some(foothold) = foothold else {
        bodies.remove(slot);
        return Ok(fracture);
    };
    bodies.retire(slot);
    fracture.fallen = foothold.let_fall(bodies, &fracture.pieces);
    Ok(fracture)
}

/// Adds the pieces of `parent` that are large enough to the bodies, and all to the ledger; their slots, and which of them they are.
pub(super) fn insert(
    bodies: &mut Bodies,
    parent: u32,
    pieces: Vec<(BodyDesc, Option<Hold>)>,
    budget: &FractureBudget,
    ledger: &mut Ledger,
    reference: &Reference,
) -> (SmallVec<[u32; 8]>, SmallVec<[u32; 8]>) {
    let fracturable = bodies.fracturable(parent).cloned();
    let looks = bodies.cut_looks(parent);
    let min_volume = fracturable.as_ref().map_or(0.0, |f| f.min_volume);
    let min_volume = f64::from(min_volume.max(budget.min_volume));
    let (mut kept, mut numbers) = (SmallVec::new(), SmallVec::new());
    for (number, (mut desc, hold)) in (0..).zip(pieces) {
        let inherited = fracturable.as_ref().and_then(|f| f.for_piece(kept.len()));
        let own = desc.fracturable.take();
        let inherited = inherited.map(|f| Fracturable {
            generations: f.generations.min(budget.generations.saturating_sub(1)),
            ..f
        });
        desc.fracturable = own.or(inherited);
        let dropped = Invariants::of_piece(&desc, reference);
        // A piece whose mass or inertia no f32 can hold is as good as too small.
        let is_large_enough = desc
            .shape
            .hull_volume()
            .is_some_and(|volume| volume > min_volume);
        match is_large_enough.then(|| bodies.insert_with_mass(desc)) {
            Some(Ok(slot)) => {
                ledger.after.add_body(bodies, slot, reference);
                if bodies.fracturable(slot).is_none() {
                    bodies.keep_cut_looks(slot, looks);
                }
                if let Some(hold) = hold {
                    *bodies.hold_mut(slot) = hold;
                }
                kept.push(slot);
                numbers.push(number);
            }
            Some(Err(_)) | None => {
                ledger.dropped.add(&dropped);
                ledger.dropped_pieces += 1;
            }
        }
    }
    (kept, numbers)
}

/// What the hulls of pieces held between the parts that came apart: air that had counted as material.
fn lost_between_parts(
    pieces: &[BodyDesc],
    halves: &[BodyDesc],
    reference: &Reference,
) -> Invariants {
    let mut lost = Invariants::default();
    if halves.is_empty() {
        return lost;
    }
    for half in halves {
        lost.add(&Invariants::of_piece(half, reference));
    }
    for piece in pieces {
        lost.take(&Invariants::of_piece(piece, reference));
    }
    lost
}

/// The body that a piece becomes: in a frame about its own centroid, moving as that part of the parent did: dynamic, and it does not break.
fn piece_desc(bodies: &Bodies, parent: u32, hull: ConvexHull, visual: Option<TriMesh>) -> BodyDesc {
    let weighs_visual = bodies.convex(parent).is_some_and(ConvexMesh::weighs_visual);
    let weighed = ConvexMesh::weighed_part(&hull, visual.as_ref(), weighs_visual);
    let integrals =
        weighed.map_or_else(|| VolumeIntegrals::of_hull(&hull), VolumeIntegrals::of_mesh);
    let centroid = integrals.centroid.as_vec3();
    let shift = Pose::new(-centroid, Quat::IDENTITY);
    let visual = visual.map(|mesh| mesh.transformed(&shift));
    let mut shape = ConvexMesh::from_parts(hull.translated(-centroid), visual);
    if weighs_visual {
        shape = shape.with_mass_of_visual();
    }
    part_of(bodies, parent, Shape::Convex(shape), centroid)
}

/// The same of a piece of a body of several parts.
pub(super) fn compound_desc(
    bodies: &Bodies,
    parent: u32,
    piece: &Compound,
) -> Result<BodyDesc, HullError> {
    if let Some(mesh) = piece.single_hull()? {
        let centroid = VolumeIntegrals::of_shape(&mesh).centroid.as_vec3();
        let shift = Pose::from_position(-centroid);
        let visual = mesh.visual().map(|mesh| mesh.clone().transformed(&shift));
        let mut shape = ConvexMesh::from_parts(mesh.hull().clone().translated(-centroid), visual);
        if mesh.weighs_visual() {
            shape = shape.with_mass_of_visual();
        }
        return Ok(part_of(bodies, parent, Shape::Convex(shape), centroid));
    }
    let centroid = VolumeIntegrals::of_compound(piece).centroid.as_vec3();
    let shape = Shape::Compound(piece.translated(-centroid));
    Ok(part_of(bodies, parent, shape, centroid))
}

/// A body of a shape whose frame is at `centroid` of the parent's (m), which moves as that part of the parent did.
fn part_of(bodies: &Bodies, parent: u32, shape: Shape, centroid: Vec3) -> BodyDesc {
    let info = bodies.info(parent);
    let rotation = bodies.pose(parent).rotation;
    let (v, omega) = bodies.velocity(parent);
    let lever: Vec3 = rotate(rotation, centroid - bodies.mass(parent).center);
    BodyDesc {
        kind: RigidBody::Dynamic,
        shape,
        pose: Pose::new(bodies.center_of_mass(parent) + lever, rotation),
        linear_velocity: v + omega.cross(lever),
        angular_velocity: omega,
        density: info.density,
        mass: None,
        friction: info.friction,
        restitution: info.restitution,
        surfaces: None,
        layers: info.layers,
        is_sensor: info.is_sensor,
        fracturable: None,
    }
}
