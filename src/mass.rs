//! Polyhedral volume integrals, and the mass, center of mass and inertia that follow from them.
//!
//! The integrals are exact for the polyhedron given, up to rounding in `f64`. Symbols, all in the body's frame:
//!
//! - `V`: volume, m3;
//! - `c`: centroid, m, the center of mass at uniform density;
//! - `C = integral of x x^T dV`: second moments about a point, m5;
//! - `I = tr(C) 1 - C`: inertia tensor at unit density, m5, and times the density, kg m2.
//!
//! # References
//! - F. Tonon, "Explicit Exact Formulas for the 3-D Tetrahedron Inertia Tensor in Terms of its Vertex Coordinates",
//!   Journal of Mathematics and Statistics 1(1), 2004.
//! - B. Mirtich, "Fast and Accurate Computation of Polyhedral Mass Properties", Journal of Graphics Tools 1(2), 1996.
//! - G. H. Golub, C. F. Van Loan, *Matrix Computations*, 4th ed., section 8.5 (Jacobi methods).

pub(crate) mod approximate;

use crate::geometry::moments::{Moments, SolidMoments};
use crate::geometry::{Compound, ConvexHull, ConvexMesh, TriMesh};
use crate::math::{Pose, outer};
use bevy_ecs::component::Component;
use glam::{DMat3, DQuat, DVec3, Mat3, Quat, Vec3};

/// Volume integrals of a closed polyhedron at unit density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeIntegrals {
    /// Volume, m3.
    pub volume: f64,
    /// Centroid, m.
    pub centroid: DVec3,
    /// Inertia tensor about the centroid at unit density, m5.
    pub inertia: DMat3,
}

impl VolumeIntegrals {
    /// Integrals over the inside of a hull.
    pub fn of_hull(hull: &ConvexHull) -> Self {
        Self::of_moments(&hull.moments)
    }

    /// Integrals over the inside of a mesh; they mean something only if the mesh is closed.
    pub fn of_mesh(mesh: &TriMesh) -> Self {
        volume_integrals(mesh.positions(), mesh.solid().iter().copied())
    }

    /// Integrals over what of a shape has mass: the shape itself, exactly if it is round, or the mesh in it.
    pub fn of_shape(shape: &ConvexMesh) -> Self {
        match shape.weighed_visual() {
            Some(mesh) => Self::of_mesh(mesh),
            None => Self::of_moments(shape.moments()),
        }
    }

    /// Integrals over the parts of a compound, added up: where parts overlap, the overlap counts for each.
    pub fn of_compound(compound: &Compound) -> Self {
        let parts = compound.parts().iter();
        let parts = parts.map(|part| Self::of_shape(&part.shape).seen_from(&part.pose));
        // A compound has at least one part.
        let sum = parts.reduce(|sum, part| sum.joined_with(&part));
        sum.unwrap_or(Self {
            volume: 0.0,
            centroid: DVec3::ZERO,
            inertia: DMat3::ZERO,
        })
    }

    /// The same body seen from the frame in which its own is at a pose.
    pub(crate) fn seen_from(&self, pose: &Pose) -> Self {
        // As exact as a quaternion of f32 is a rotation.
        let turn = DMat3::from_quat(pose.rotation.as_dquat().normalize());
        Self {
            volume: self.volume,
            centroid: turn * self.centroid + pose.position.as_dvec3(),
            inertia: turn * self.inertia * turn.transpose(),
        }
    }

    fn of_moments(moments: &SolidMoments) -> Self {
        let (volume, arm) = (moments.volume(), moments.sums.arm());
        let second = moments.sums.second() / 120.0 - volume * outer(arm, arm);
        Self {
            volume,
            centroid: moments.apex + arm,
            inertia: inertia_of_second_moments(second),
        }
    }

    /// Inertia tensor about `point` (m, same frame) at unit density, m5, by the parallel-axis theorem.
    pub fn inertia_about(&self, point: DVec3) -> DMat3 {
        self.inertia + particle_inertia(self.volume, self.centroid - point)
    }

    /// Integrals over two disjoint bodies taken as one, both in the same frame.
    pub fn joined_with(&self, other: &Self) -> Self {
        let volume = self.volume + other.volume;
        let centroid = (self.volume * self.centroid + other.volume * other.centroid) / volume;
        Self {
            volume,
            centroid,
            inertia: self.inertia_about(centroid) + other.inertia_about(centroid),
        }
    }
}

/// Inertia tensor of a particle about the origin, kg m2: `m (r.r 1 - r r^T)`, the shift of the parallel-axis theorem.
///
/// `mass` in kg, `offset` from the origin to the particle in m.
pub fn particle_inertia(mass: f64, offset: DVec3) -> DMat3 {
    inertia_of_second_moments(mass * outer(offset, offset))
}

/// `tr(C) 1 - C`.
fn inertia_of_second_moments(moments: DMat3) -> DMat3 {
    let trace = moments.x_axis.x + moments.y_axis.y + moments.z_axis.z;
    DMat3::from_diagonal(DVec3::splat(trace)) - moments
}

/// Volume, centroid and inertia of the closed polyhedron with these `positions` (m) and `triangles` (indices,
/// counter-clockwise seen from outside), at unit density.
///
/// Sums signed tetrahedra `(o, a, b, c)` with the apex `o` at the first corner, which keeps rounding small far from the
/// frame's origin. With `a`, `b`, `c` relative to `o`, `d = a . (b x c)` (six times the volume) and `s = a + b + c`:
///
/// - `V = sum of d / 6`,
/// - `V (c - o) = sum of d s / 24`,
/// - `C = sum of d (s s^T + a a^T + b b^T + c c^T) / 120` about `o`, then `- V (c - o)(c - o)^T` about the centroid.
///
/// The surface has to be closed; an inside-out one gives a negative volume, one without volume a centroid of NaN, and
/// [`MassProperties::from_integrals`] refuses both.
///
/// Source: Tonon 2004, with Mirtich's sum over a surface.
pub fn volume_integrals<P: Copy + Into<DVec3>>(
    positions: &[P],
    triangles: impl Iterator<Item = [u32; 3]>,
) -> VolumeIntegrals {
    let mut triangles = triangles.peekable();
    let apex = triangles
        .peek()
        .map_or(DVec3::ZERO, |first| positions[first[0] as usize].into());
    let mut sums = Moments::default();
    for corners in triangles {
        let [a, b, c] = corners.map(|corner| positions[corner as usize].into() - apex);
        sums.add_triangle(a, b, c);
    }
    VolumeIntegrals::of_moments(&SolidMoments {
        apex,
        sums,
        root: sums.six_volumes,
    })
}

/// Sweeps of the Jacobi method after which the off-diagonals are zero to rounding; it converges quadratically, and
/// symmetric 3x3 matrices have not been seen to need more than six.
const MAX_JACOBI_SWEEPS: usize = 16;

/// Eigenvalues, ascending, of a symmetric matrix and the rotation from the frame of its eigenvectors to the frame the
/// matrix is in: `tensor = R diag(values) R^T`.
///
/// Cyclic Jacobi rotations, which use nothing beyond the square root and so give the same bits on every platform. A
/// matrix with equal eigenvalues gets one of the possible frames; a diagonal one keeps its axes up to their order.
///
/// Source: Golub and Van Loan, section 8.5.2.
pub fn principal_axes(tensor: DMat3) -> (DVec3, DQuat) {
    let mut a = tensor.to_cols_array_2d();
    let mut axes = DVec3::AXES;
    for _ in 0..MAX_JACOBI_SWEEPS {
        if a[0][1] == 0.0 && a[0][2] == 0.0 && a[1][2] == 0.0 {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            jacobi_rotate(&mut a, &mut axes, p, q);
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a[i][i].total_cmp(&a[j][j]));
    let values = DVec3::from_array(order.map(|i| a[i][i]));
    let [x, y, _] = order.map(|i| axes[i]);
    // The third axis as a cross product makes the frame right-handed.
    let frame = DMat3::from_cols(x, y, x.cross(y));
    (values, DQuat::from_mat3(&frame).normalize())
}

/// Makes `a[p][q]` zero by a rotation in the plane of the axes `p` and `q`, and applies it to `axes`.
fn jacobi_rotate(a: &mut [[f64; 3]; 3], axes: &mut [DVec3; 3], p: usize, q: usize) {
    let off = a[p][q];
    // Too small to change either diagonal entry: zero to rounding.
    if a[p][p].abs() + off.abs() == a[p][p].abs() && a[q][q].abs() + off.abs() == a[q][q].abs() {
        (a[p][q], a[q][p]) = (0.0, 0.0);
        return;
    }
    // The smaller root of t^2 + 2 tau t - 1 = 0 is the tangent of an angle of at most 45 degrees.
    let tau = (a[q][q] - a[p][p]) / (2.0 * off);
    let t = 1.0_f64.copysign(tau) / (tau.abs() + (1.0 + tau * tau).sqrt());
    let c = 1.0 / (1.0 + t * t).sqrt();
    let s = t * c;
    let r = 3 - p - q;
    a[p][p] -= t * off;
    a[q][q] += t * off;
    (a[p][q], a[q][p]) = (0.0, 0.0);
    let (arp, arq) = (a[r][p], a[r][q]);
    let (new_rp, new_rq) = (c * arp - s * arq, s * arp + c * arq);
    (a[r][p], a[p][r]) = (new_rp, new_rp);
    (a[r][q], a[q][r]) = (new_rq, new_rq);
    let (vp, vq) = (axes[p], axes[q]);
    (axes[p], axes[q]) = (c * vp - s * vq, s * vp + c * vq);
}

/// Mass, center of mass and principal inertia of a body, in its own frame.
#[derive(Clone, Copy, Debug, PartialEq, Component)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct MassProperties {
    /// Mass, kg.
    pub mass: f32,
    /// Center of mass in the body's frame, m.
    pub center: Vec3,
    /// Principal moments of inertia about the center, ascending, kg m2.
    pub principal: Vec3,
    /// Rotation from the principal frame to the body's frame.
    pub principal_frame: Quat,
}

/// Why a body has no usable mass.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MassError {
    /// The density is not a positive finite number.
    #[error("a density of {density} kg/m3 is not positive and finite")]
    Density {
        /// Density, kg/m3.
        density: f32,
    },
    /// The volume is not a positive finite number.
    #[error("a volume of {volume} m3 is not positive and finite")]
    Volume {
        /// Volume, m3.
        volume: f64,
    },
    /// The inertia is not finite, or too flat for a body: a principal moment is not positive.
    #[error(
        "principal moments of inertia of {principal} m5 at unit density are not positive and finite"
    )]
    Inertia {
        /// Principal moments at unit density, m5.
        principal: DVec3,
    },
    /// A mass or moment, or its inverse, cannot be held as `f32`.
    #[error("a mass of {mass} kg with principal moments {principal} kg m2 is out of range")]
    OutOfRange {
        /// Mass, kg.
        mass: f64,
        /// Principal moments, kg m2.
        principal: DVec3,
    },
}

impl Default for MassProperties {
    /// No mass at all: a body whose mass is not computed yet, or that has none.
    fn default() -> Self {
        Self {
            mass: 0.0,
            center: Vec3::ZERO,
            principal: Vec3::ZERO,
            principal_frame: Quat::IDENTITY,
        }
    }
}

impl MassProperties {
    /// Mass properties at uniform `density` (kg/m3) from the integrals of the body's shape.
    ///
    /// # Errors
    /// [`MassError`] says which number is not usable.
    pub fn from_integrals(integrals: &VolumeIntegrals, density: f32) -> Result<Self, MassError> {
        let VolumeIntegrals {
            volume,
            centroid,
            inertia,
        } = *integrals;
        if !(density.is_finite() && density > 0.0) {
            return Err(MassError::Density { density });
        }
        if !(volume.is_finite() && volume > 0.0) {
            return Err(MassError::Volume { volume });
        }
        let (principal, frame) = principal_axes(inertia);
        let usable = principal.is_finite() && principal.x > 0.0 && centroid.is_finite();
        if !usable {
            return Err(MassError::Inertia { principal });
        }
        let (mass, principal) = (volume * f64::from(density), principal * f64::from(density));
        let result = Self {
            mass: mass as f32,
            center: centroid.as_vec3(),
            principal: principal.as_vec3(),
            principal_frame: frame.as_quat(),
        };
        if !result.is_in_range() {
            return Err(MassError::OutOfRange { mass, principal });
        }
        Ok(result)
    }

    /// Checks values that were not computed here.
    ///
    /// # Errors
    /// [`MassError::OutOfRange`] unless all numbers are finite, and mass and moments positive with finite inverses.
    pub fn validate(&self) -> Result<(), MassError> {
        if self.is_in_range() && self.principal_frame.is_normalized() {
            return Ok(());
        }
        Err(MassError::OutOfRange {
            mass: self.mass.into(),
            principal: self.principal.as_dvec3(),
        })
    }

    fn is_in_range(&self) -> bool {
        let in_range = |value: f32| value > 0.0 && value.is_normal() && value.recip().is_normal();
        let moments = self.principal.to_array();
        in_range(self.mass) && moments.into_iter().all(in_range) && self.center.is_finite()
    }

    /// Mass properties of a solid hull of uniform `density` (kg/m3).
    ///
    /// # Errors
    /// As [`from_integrals`](Self::from_integrals).
    pub fn of_hull(hull: &ConvexHull, density: f32) -> Result<Self, MassError> {
        Self::from_integrals(&VolumeIntegrals::of_hull(hull), density)
    }

    /// Mass properties of a shape of uniform `density` (kg/m3): of itself, or of the mesh in it.
    ///
    /// # Errors
    /// As [`from_integrals`](Self::from_integrals).
    pub fn of_shape(shape: &ConvexMesh, density: f32) -> Result<Self, MassError> {
        Self::from_integrals(&VolumeIntegrals::of_shape(shape), density)
    }

    /// Mass properties of a compound of uniform `density` (kg/m3): the sums of those of its parts.
    ///
    /// # Errors
    /// As [`from_integrals`](Self::from_integrals).
    pub fn of_compound(compound: &Compound, density: f32) -> Result<Self, MassError> {
        Self::from_integrals(&VolumeIntegrals::of_compound(compound), density)
    }

    /// Inverse of the mass, 1/kg.
    pub fn inverse_mass(&self) -> f32 {
        self.mass.recip()
    }

    /// Inverses of the principal moments, 1/(kg m2).
    pub fn inverse_principal(&self) -> Vec3 {
        self.principal.recip()
    }

    /// Inertia tensor about the center along the axes of the body's frame, kg m2.
    pub fn inertia(&self) -> Mat3 {
        self.in_body_frame(self.principal)
    }

    /// Inverse of [`inertia`](Self::inertia), 1/(kg m2).
    pub fn inverse_inertia(&self) -> Mat3 {
        self.in_body_frame(self.inverse_principal())
    }

    fn in_body_frame(&self, diagonal: Vec3) -> Mat3 {
        let body_from_principal = Mat3::from_quat(self.principal_frame);
        body_from_principal * Mat3::from_diagonal(diagonal) * body_from_principal.transpose()
    }
}
