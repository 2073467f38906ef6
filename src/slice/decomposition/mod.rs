//! Convex decomposition: a closed mesh that is not convex as convex parts, with a bound on how far they stick out of it.
//!
//! The solid is cut by planes until the hull of each piece is near enough to it (`concavity.rs`); which planes are tried is in
//! `planes.rs`. A plane is worth what it takes off the air in the hulls of the pieces, each connected piece having a hull of
//! its own. Then parts are put together again where the hull of both stays near enough (`merging.rs`).
//!
//! Must not know bodies. Read `decompose` first.
//!
//! # References
//! - X. Wei, M. Liu, Z. Ling, H. Su, "Approximate Convex Decomposition for 3D Meshes with Collision-Aware Concavity and Tree
//!   Search", ACM TOG 41(4), 2022: cuts of the mesh itself, merging afterwards. Their concavity is sampled; here it is bounded.

mod compound;
mod concavity;
mod merging;
mod planes;
mod solid;

use crate::geometry::hull::hull_unless_flat;
use crate::geometry::mesh::check_vertices;
use crate::geometry::{ConvexHull, HullError, MeshError, TriMesh};
use crate::math::Plane;
use crate::slice::components::{compacted, split_components};
use crate::slice::decomposition::concavity::{Question, concavity};
use crate::slice::decomposition::merging::Merging;
use crate::slice::decomposition::solid::Solid;
use crate::slice::mesh_slicer::MeshSlicer;
use crate::slice::{SliceError, SliceOptions};
use glam::Vec3;

/// A hull with less air than this share of its volume is the solid itself.
const NO_AIR: f64 = 1e-5;

/// What a cut counts that is as large as the piece's surface, as a share of the piece's volume.
const AREA_COST: f64 = 0.001;

/// How planes are chosen. What is best for one cut need not be so for the next, so all are tried, and the one with the fewest parts is
/// taken.
const WAYS: [Way; 4] = [
    Way {
        along_edges_only: false,
        piece_cost: 0.01,
    },
    Way {
        along_edges_only: false,
        piece_cost: 0.1,
    },
    Way {
        along_edges_only: true,
        piece_cost: 0.01,
    },
    Way {
        along_edges_only: true,
        piece_cost: 0.1,
    },
];

/// A way to choose a plane.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// Whether only planes along hollow edges are tried, where there are any.
    along_edges_only: bool,
    /// What a piece more counts, as a share of the volume.
    piece_cost: f64,
}

/// The concavity of the parts is found to this share of what is allowed.
const TOLERANCE_SHARE: f64 = 0.125;

/// Smallest concavity, as a share of the size, that is told from none.
const LEAST_CONCAVITY: f64 = 1e-3;

/// How exact a decomposition is, and in how many parts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct DecompositionOptions {
    /// How far a part may stick out of the solid, as a share of the diagonal of the solid's bounding box. Gaps narrower than twice
    /// that may be filled. Less than 1e-3 counts as 1e-3.
    pub max_concavity: f32,
    /// Most parts; where more would be needed for the concavity, it is larger than allowed, and
    /// [`ConvexPart::concavity`] says how large.
    pub max_parts: usize,
}

impl Default for DecompositionOptions {
    /// 2 % of the size, at most 64 parts.
    fn default() -> Self {
        Self {
            max_concavity: 0.02,
            max_parts: 64,
        }
    }
}

impl DecompositionOptions {
    /// The same with another largest concavity, a share of the solid's size.
    #[must_use]
    pub fn with_max_concavity(mut self, share: f32) -> Self {
        self.max_concavity = share;
        self
    }

    /// The same with another largest number of parts.
    #[must_use]
    pub fn with_max_parts(mut self, count: usize) -> Self {
        self.max_parts = count;
        self
    }

    fn is_usable(&self) -> bool {
        self.max_parts > 0 && self.max_concavity >= 0.0 && self.max_concavity.is_finite()
    }
}

/// One of the convex parts that stand for a solid, in the solid's frame.
#[derive(Clone, Debug)]
pub struct ConvexPart {
    /// The part.
    pub hull: ConvexHull,
    /// No point of the part is farther than this from the solid, as a share of the diagonal of the solid's bounding box.
    pub concavity: f32,
    /// What of the solid the part stands for, m3; its hull has so much and the air that it closes in.
    pub volume: f64,
}

/// Why a solid was not decomposed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DecompositionError {
    /// The mesh is open, encloses nothing, or has numbers that are not finite.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The solid is too small, too large or too flat for a body.
    #[error(transparent)]
    Hull(#[from] HullError),
    /// The concavity is negative or not finite, or no part is allowed.
    #[error("a concavity of {max_concavity} in at most {max_parts} parts cannot be met")]
    Options {
        /// Largest concavity that was asked for.
        max_concavity: f32,
        /// Most parts that were asked for.
        max_parts: usize,
    },
}

/// Convex parts that stand for a closed mesh.
///
/// All of the mesh is in the parts, but for slivers that are too flat for a hull. The parts stick out of it by no more than
/// [`max_concavity`](DecompositionOptions::max_concavity), unless there would be more of them than
/// [`max_parts`](DecompositionOptions::max_parts). They overlap each other by no more than they stick out of the pieces that they stand for.
/// Sheets of the mesh have no inside and are left out. Works at load or offline: a model of a thousand triangles takes a fraction of a
/// second to some seconds. The same mesh gives the same parts, in the same order.
///
/// # Errors
/// [`DecompositionError`] says what is wrong with the mesh or the options.
pub fn decompose(
    mesh: &TriMesh,
    options: DecompositionOptions,
) -> Result<Vec<ConvexPart>, DecompositionError> {
    if !options.is_usable() {
        return Err(DecompositionError::Options {
            max_concavity: options.max_concavity,
            max_parts: options.max_parts,
        });
    }
    check_vertices(mesh.positions(), mesh.triangles())?;
    mesh.check_closed()?;
    let volume = mesh.volume();
    let is_outward = volume > 0.0;
    if !is_outward {
        return Err(MeshError::NoVolume { volume }.into());
    }
    let bare = compacted(&TriMesh {
        positions: mesh.positions.clone(),
        triangles: mesh.solid().to_vec(),
        topology: mesh.topology.clone(),
        known_closed: mesh.known_closed.clone(),
        ..TriMesh::default()
    });
    ConvexHull::from_points(bare.positions())?;
    let size = f64::from(bare.aabb().diagonal());
    let max_concavity = size * f64::from(options.max_concavity).max(LEAST_CONCAVITY);
    let solid = Solid::new(&bare);
    let parts_of = |way: Way| {
        let pieces = cut_apart(&bare, max_concavity, options.max_parts, way);
        Merging::new(&solid, max_concavity, options.max_parts).run(pieces)
    };
    let worst = |parts: &[ConvexPart]| parts.iter().map(|p| p.concavity).fold(0.0, f32::max);
    let [first, others @ ..] = WAYS;
    let mut parts = parts_of(first);
    for way in others {
        // Less than two are no decomposition.
        if parts.len() <= 2 {
            break;
        }
        let other = parts_of(way);
        let order = other.len().cmp(&parts.len());
        if order.then(worst(&other).total_cmp(&worst(&parts))).is_lt() {
            parts = other;
        }
    }
    for part in &mut parts {
        if part.concavity > 0.0 {
            // It was enough to know that it is allowed, or that the solid could not be cut any more.
            let tolerance = Question::UpTo(TOLERANCE_SHARE * max_concavity);
            let sticks_out = concavity(&part.hull, &solid, tolerance);
            part.concavity = (sticks_out.min(part.concavity.into()) / size) as f32;
        }
    }
    Ok(parts)
}

/// The hull of points; none if they are too flat for one.
fn hull_of(points: &[Vec3]) -> Option<ConvexHull> {
    hull_unless_flat(points).ok().flatten()
}

/// A connected piece of the solid.
struct Piece {
    mesh: TriMesh,
    hull: ConvexHull,
    volume: f64,
    /// m
    concavity: f64,
}

impl Piece {
    fn new(mesh: TriMesh, max_concavity: f64) -> Option<Self> {
        let hull = hull_of(mesh.positions())?;
        let volume = mesh.volume();
        let air = hull.volume() - volume;
        let concavity = if air <= NO_AIR * hull.volume() {
            0.0
        } else {
            concavity(&hull, &Solid::new(&mesh), Question::Within(max_concavity))
        };
        Some(Self {
            mesh,
            hull,
            volume,
            concavity,
        })
    }
}

/// Cuts a solid until the hull of each piece is near enough to the piece; concavities are in m.
fn cut_apart(mesh: &TriMesh, max_concavity: f64, max_parts: usize, way: Way) -> Vec<ConvexPart> {
    let pieces = split_components(mesh).into_iter();
    let mut open: Vec<Piece> = pieces
        .filter_map(|mesh| Piece::new(mesh, max_concavity))
        .collect();
    let mut done: Vec<ConvexPart> = Vec::new();
    // Some more than allowed, which may be put together again.
    let most = 2 * max_parts.min(usize::MAX / 4) + 16;
    while let Some(at) = (0..open.len()).max_by(|&a, &b| {
        let [a, b] = [a, b].map(|at| open[at].concavity * open[at].volume);
        a.total_cmp(&b)
    }) {
        let piece = open.swap_remove(at);
        let is_done = piece.concavity <= max_concavity || open.len() + done.len() >= most;
        let parts = if is_done { None } else { best_cut(&piece, way) };
        match parts {
            Some(parts) => {
                open.extend(
                    parts
                        .into_iter()
                        .filter_map(|mesh| Piece::new(mesh, max_concavity)),
                );
            }
            // What could not be cut as far as that sticks out by an amount that is yet to be found.
            None => done.push(ConvexPart {
                hull: piece.hull,
                concavity: if piece.concavity > max_concavity {
                    f32::INFINITY
                } else {
                    piece.concavity as f32
                },
                volume: piece.volume,
            }),
        }
    }
    done
}

/// The parts of a piece when it is cut by the plane that takes most air off the hulls.
fn best_cut(piece: &Piece, way: Way) -> Option<Vec<TriMesh>> {
    let mut slicer = MeshSlicer::default();
    let mut best: Option<(f64, Vec<TriMesh>)> = None;
    for plane in planes::candidates(&piece.mesh, way.along_edges_only) {
        let Some((cost, parts)) = cost_of(piece, plane, way, &mut slicer) else {
            continue;
        };
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, parts));
        }
    }
    best.map(|(_, parts)| parts)
}

/// What a cut leaves of air, and what it costs besides, as a share of the volume; none if the plane does not cut.
fn cost_of(
    piece: &Piece,
    plane: Plane,
    way: Way,
    slicer: &mut MeshSlicer,
) -> Option<(f64, Vec<TriMesh>)> {
    let cut: Result<_, SliceError> = slicer.slice(&piece.mesh, plane, SliceOptions::default());
    let halves = cut.ok()?.halves()?;
    let mut parts = [&halves.below, &halves.above]
        .map(split_components)
        .concat();
    // Along faces and edges, a part may come to touch itself: another plane will do.
    for part in &mut parts {
        part.known_closed.clear();
        part.check_closed().ok()?;
    }
    let hulls = parts.iter().filter_map(|part| hull_of(part.positions()));
    let air = hulls.map(|hull| hull.volume()).sum::<f64>() - piece.volume;
    let cost = air / piece.volume
        + way.piece_cost * parts.len() as f64
        + AREA_COST * halves.cap.area / piece.mesh.area();
    Some((cost, parts))
}
