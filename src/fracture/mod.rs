//! Bodies that break: which ones, through which planes, and what becomes of their motion.
//!
//! A body breaks when the contact impulses of one step pass its strength, or when a cut is asked for. It is cut in its
//! own frame; each piece becomes a body about its own centre of mass and moves as that part of the parent did:
//! `v_i = v + omega x r_i`, `omega_i = omega`, which conserves momentum, angular momentum and energy exactly; the
//! [`Ledger`] shows the rounding.

mod impact;
mod ledger;

pub use ledger::{Ledger, Totals};

use crate::contact::BodyId;
use crate::contact::cache::ContactCache;
use crate::contact::manifold::Manifold;
use crate::geometry::ConvexMesh;
use crate::geometry::predicates::check_plane;
use crate::mass::VolumeIntegrals;
use crate::math::{Plane, Pose, rotate};
use crate::slice::fracturable::Fracturable;
use crate::slice::{Cutting, Piece, PieceCutter, SliceError, SliceOptions};
use crate::solver::bodies::{Bodies, BodyDesc, BodyError, RigidBody, Shape};
use bevy_ecs::resource::Resource;
use glam::Quat;
use smallvec::SmallVec;

/// Why a cut that was asked for was not made. The body is left as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CutError {
    /// There is no such body (any more).
    #[error("there is no such body")]
    NoBody,
    /// Only dynamic bodies can be cut.
    #[error("only dynamic bodies can be cut")]
    NotDynamic,
    /// The body is out of the simulation because its state is not finite.
    #[error("the body is left out of the simulation")]
    Frozen,
    /// The body's mass was given, not computed: nobody knows which piece would get which share.
    #[error("a body with a MassOverride cannot be cut: give it a Density instead")]
    MassOverride,
    /// The plane does not go through the body.
    #[error("the plane misses the body")]
    Missed,
    /// Fewer than two pieces are larger than the least volume.
    #[error("fewer than two pieces would be larger than the least volume")]
    TooSmall,
    /// The slicer refused.
    #[error(transparent)]
    Slice(#[from] SliceError),
    /// A piece does not make a body.
    #[error(transparent)]
    Piece(#[from] BodyError),
}

/// A cut that was asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutRequest {
    /// The body to cut.
    pub body: BodyId,
    /// Its slot.
    pub slot: u32,
    /// Where to cut, in the body's frame: it moves with the body until the cut is made.
    pub plane: Plane,
}

impl CutRequest {
    /// A cut of the body in `slot` by a plane in the world, as the body lies now.
    ///
    /// # Errors
    /// [`CutError::NoBody`] if the slot is free.
    pub fn in_world(bodies: &Bodies, slot: u32, plane: Plane) -> Result<Self, CutError> {
        if !bodies.contains(slot) {
            return Err(CutError::NoBody);
        }
        let plane = plane.in_frame_of(&bodies.pose(slot));
        Ok(Self {
            body: bodies.id(slot),
            slot,
            plane,
        })
    }
}

/// One body that became several.
#[derive(Clone, Debug, PartialEq)]
pub struct Fracture {
    /// The body that is no more.
    pub parent: BodyId,
    /// The slot it had.
    pub parent_slot: u32,
    /// Slots of the pieces.
    pub pieces: SmallVec<[u32; 8]>,
    /// The planes, world frame; of a body that broke into cells, only those of cuts on request.
    pub planes: SmallVec<[Plane; 8]>,
    /// Before and after.
    pub ledger: Ledger,
}

/// Cuts asked for, and what the last fracture phase did.
#[derive(Debug, Default, Resource)]
pub struct Fractures {
    /// Cuts to make in the next fracture phase, in order; several on one body cut its pieces too.
    pub requests: Vec<CutRequest>,
    /// Fractures of the last step, in order of the parents' ids.
    pub done: Vec<Fracture>,
    /// Cuts of the last step that were not made.
    pub refused: Vec<(CutRequest, CutError)>,
    breaking: Vec<Breaking>,
    impacts: Vec<impact::ImpulseSum>,
}

#[derive(Debug)]
struct Breaking {
    slot: u32,
    planes: SmallVec<[Plane; 8]>,
    /// Cells that the body breaks into before the planes cut them.
    cells: Option<Cutting>,
    requests: SmallVec<[CutRequest; 2]>,
}

/// Breaks all bodies whose strength was passed or that are to be cut.
///
/// Pieces get slots, parents lose theirs; the parents' cache entries go. Results are in `fractures`.
pub fn fracture_bodies(
    fractures: &mut Fractures,
    bodies: &mut Bodies,
    manifolds: &[Manifold],
    cache: &mut ContactCache,
) {
    fractures.done.clear();
    fractures.refused.clear();
    collect_requests(fractures, bodies);
    collect_impacts(fractures, bodies, manifolds);
    let mut breaking = std::mem::take(&mut fractures.breaking);
    breaking.sort_by_key(|b| bodies.id(b.slot));
    for entry in breaking.drain(..) {
        match break_body(bodies, &entry) {
            Ok(fracture) => fractures.done.push(fracture),
            Err(error) => fractures
                .refused
                .extend(entry.requests.iter().map(|&r| (r, error.clone()))),
        }
    }
    fractures.breaking = breaking;
    if !fractures.done.is_empty() {
        let done = &fractures.done;
        cache.remove_bodies(|id| done.binary_search_by_key(&id, |f| f.parent).is_ok());
    }
}

/// Sorts out requests that cannot be met; several on one body become one list of planes.
fn collect_requests(fractures: &mut Fractures, bodies: &Bodies) {
    for request in fractures.requests.drain(..) {
        if let Err(error) = check_request(&request, bodies) {
            fractures.refused.push((request, error));
            continue;
        }
        let entry = breaking_of(&mut fractures.breaking, request.slot);
        entry.planes.push(request.plane);
        entry.requests.push(request);
    }
}

fn check_request(request: &CutRequest, bodies: &Bodies) -> Result<(), CutError> {
    if !bodies.is(request.slot, request.body) {
        return Err(CutError::NoBody);
    }
    if bodies.kind(request.slot) != RigidBody::Dynamic {
        return Err(CutError::NotDynamic);
    }
    if !bodies.is_active(request.slot) {
        return Err(CutError::Frozen);
    }
    if bodies.has_mass_override(request.slot) {
        return Err(CutError::MassOverride);
    }
    check_plane(&request.plane).map_err(SliceError::from)?;
    Ok(())
}

/// Adds the bodies whose contact impulses of this step exceed their strength.
fn collect_impacts(fractures: &mut Fractures, bodies: &Bodies, manifolds: &[Manifold]) {
    if !bodies.any_fracturable() {
        return;
    }
    impact::sum_impulses(&mut fractures.impacts, bodies.slots(), manifolds);
    for (slot, sum) in (0..).zip(&fractures.impacts) {
        let Some(cutting) = impact::cutting_of_impact(bodies, slot, sum) else {
            continue;
        };
        let entry = breaking_of(&mut fractures.breaking, slot);
        match cutting {
            Cutting::Planes(planes) => entry.planes.extend(planes),
            cells => entry.cells = Some(cells),
        }
    }
}

/// The entry of the body in `slot`, made if it is not there yet.
fn breaking_of(breaking: &mut Vec<Breaking>, slot: u32) -> &mut Breaking {
    let index = breaking.iter().position(|b| b.slot == slot);
    let index = index.unwrap_or_else(|| {
        breaking.push(Breaking {
            slot,
            planes: SmallVec::new(),
            cells: None,
            requests: SmallVec::new(),
        });
        breaking.len() - 1
    });
    &mut breaking[index]
}

/// Replaces one body by its pieces, or leaves it as it is.
fn break_body(bodies: &mut Bodies, breaking: &Breaking) -> Result<Fracture, CutError> {
    let slot = breaking.slot;
    let mesh = bodies.convex(slot).ok_or(CutError::NotDynamic)?.clone();
    let fracturable = bodies.fracturable(slot).cloned();
    let pieces = pieces_of(&mesh, fracturable.as_ref(), breaking)?;
    if pieces.len() < 2 {
        return Err(CutError::Missed);
    }
    let least_volume = f64::from(fracturable.as_ref().map_or(0.0, |f| f.least_volume));
    let large_enough = |piece: &Piece| piece.volume > least_volume;
    let world_from_body = bodies.pose(slot);
    let about = bodies.centre_of_mass(slot).as_dvec3();
    let mut ledger = Ledger::default();
    ledger.before.add_body(bodies, slot, about);
    let mut kept = SmallVec::new();
    for piece in pieces {
        let integrals = VolumeIntegrals::of_hull(&piece.hull);
        let keep = large_enough(&piece);
        let inherited = fracturable.as_ref().and_then(|f| f.for_piece(kept.len()));
        let desc = piece_desc(bodies, slot, piece, &integrals, inherited);
        let dropped = Totals::of_piece(&desc, &integrals, about);
        // A piece whose mass or inertia no f32 can hold is as good as too small.
        match keep.then(|| bodies.insert_with_mass(desc)) {
            Some(Ok(piece_slot)) => {
                ledger.after.add_body(bodies, piece_slot, about);
                kept.push(piece_slot);
            }
            Some(Err(_)) | None => {
                ledger.dropped.add(&dropped);
                ledger.dropped_pieces += 1;
            }
        }
    }
    if kept.len() < 2 {
        kept.iter().for_each(|&s| bodies.remove(s));
        return Err(CutError::TooSmall);
    }
    let fracture = Fracture {
        parent: bodies.id(slot),
        parent_slot: slot,
        pieces: kept,
        planes: breaking
            .planes
            .iter()
            .map(|p| p.in_frame_of(&world_from_body.inverse()))
            .collect(),
        ledger,
    };
    bodies.remove(slot);
    Ok(fracture)
}

/// The pieces of one body, in its frame: cells first, then what the planes make of them.
fn pieces_of(
    mesh: &ConvexMesh,
    fracturable: Option<&Fracturable>,
    breaking: &Breaking,
) -> Result<Vec<Piece>, SliceError> {
    let options = SliceOptions {
        cap_colour: fracturable.and_then(|f| f.cut_colour),
        cap_material: fracturable.and_then(|f| f.cut_material),
        ..SliceOptions::default()
    };
    // A cut on request is made whatever the limit.
    let most = match fracturable {
        Some(fracturable) if breaking.requests.is_empty() => fracturable.most_pieces.into(),
        _ => usize::MAX,
    };
    let mut cutter = PieceCutter::default();
    let whole = Cutting::Planes(SmallVec::new());
    let cells = breaking.cells.as_ref().unwrap_or(&whole);
    let mut pieces = cutter.cut(mesh.hull(), mesh.visual(), cells, most, options)?;
    cutter.cut_pieces(&mut pieces, &breaking.planes, most, options)?;
    Ok(pieces)
}

/// The body that a piece becomes: in a frame about its own centroid, moving as that part of the parent did.
///
/// `integrals` are those of the piece's hull in the parent's frame.
fn piece_desc(
    bodies: &Bodies,
    parent: u32,
    piece: Piece,
    integrals: &VolumeIntegrals,
    fracturable: Option<Fracturable>,
) -> BodyDesc {
    let info = bodies.info(parent);
    let rotation = bodies.pose(parent).rotation;
    let centroid = integrals.centroid.as_vec3();
    let (v, omega) = bodies.velocity(parent);
    let lever = rotate(rotation, centroid - bodies.mass(parent).centre);
    let shift = Pose::new(-centroid, Quat::IDENTITY);
    let visual = piece.visual.map(|mesh| mesh.transformed(&shift));
    let shape = ConvexMesh::from_parts(piece.hull.translated(-centroid), visual);
    BodyDesc {
        kind: RigidBody::Dynamic,
        shape: Shape::Convex(shape),
        pose: Pose::new(bodies.centre_of_mass(parent) + lever, rotation),
        linear_velocity: v + omega.cross(lever),
        angular_velocity: omega,
        density: info.density,
        mass: None,
        friction: info.friction,
        restitution: info.restitution,
        layers: info.layers,
        fracturable,
    }
}
