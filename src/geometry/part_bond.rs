//! `PartBond`: what holds two parts of a compound together.

use crate::geometry::compound_part::CompoundPart;
use crate::geometry::polygon::Polygon;
use crate::geometry::shared_area::patches_of_hulls;
use crate::math::{Pose, rotate, tangents};
use glam::{DMat2, DVec2, DVec3, Vec2, Vec3};

/// Largest gap between faces that count as touching, as a share of the smaller part's least extent.
pub(crate) const BOND_GAP: f32 = 0.01;

/// Least area that is worth a bond, as a share of the square of the smaller part's least extent: more than rounding makes of two
/// edges that touch.
const MIN_AREA: f32 = 1e-3;

/// Damage of a bond that is worn out. The little that is left keeps its numbers usable until it is taken away.
pub(crate) const WORN_OUT: f32 = 0.999;

/// A bond between two parts of a compound: the face that they share, and what it bears.
///
/// The face counts as a rectangle with the same area, center and second moments. All is plain data, in the frame of the compound.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct PartBond {
    /// The parts, by index.
    pub parts: [u32; 2],
    /// Centroid of the shared face, m.
    pub center: Vec3,
    /// Unit normal of the face, from the first part to the second.
    pub normal: Vec3,
    /// Unit vector in the face: a principal axis of its second moments.
    pub axis: Vec3,
    /// Half the sides of the rectangle, along `axis` and along `normal x axis`, m.
    pub half_extents: Vec2,
    /// Area, m2.
    pub area: f32,
    /// Tensile strength, Pa.
    pub strength: f32,
    /// Shear strength without pressure, Pa; pressure adds friction to it.
    pub shear_strength: f32,
    /// Share of both strengths that blows have worn away, from 0 to less than 1; see [`Fatigue`](crate::bodies::Fatigue).
    pub damage: f32,
}

impl PartBond {
    /// A bond over the faces that two of the parts share, as strong in shear as in tension (Pa); none if they share none.
    ///
    /// Faces are shared if they are parallel to within a degree and no farther apart than a hundredth of the smaller part's
    /// least extent.
    pub fn between(parts: &[CompoundPart], [a, b]: [u32; 2], strength: f32) -> Option<Self> {
        let [first, second] = [a, b].map(|part| parts.get(part as usize));
        let (first, second) = (first?, second?);
        let extent = |part: &CompoundPart| part.shape.aabb().extents().min_element();
        let extent = extent(first).min(extent(second));
        let b_in_a = first.pose.inverse() * second.pose;
        let mut moments = FaceMoments::default();
        let hulls = [first, second].map(|part| part.shape.hull());
        patches_of_hulls(
            hulls[0],
            hulls[1],
            &b_in_a,
            BOND_GAP * extent,
            |patch, normal| {
                moments.add(&Polygon::from_slice(patch), normal);
            },
        );
        (moments.area > f64::from(MIN_AREA * extent * extent))
            .then(|| moments.bond([a, b], &first.pose, strength))?
    }

    /// Whether blows have left nothing of it.
    pub(crate) fn is_worn_out(&self) -> bool {
        self.damage >= WORN_OUT
    }

    /// What is left of its tensile and its shear strength, Pa.
    pub(crate) fn strengths(&self) -> [f32; 2] {
        [self.strength, self.shear_strength].map(|strength| strength * (1.0 - self.damage))
    }

    /// Whether its numbers mean something.
    pub(crate) fn is_usable(&self) -> bool {
        let positive = [self.area, self.strength, self.shear_strength];
        let is_positive = |x: f32| x.is_finite() && x > 0.0;
        let [a, b] = self.parts;
        a != b
            && positive.into_iter().all(is_positive)
            && is_positive(self.half_extents.min_element())
            && self.half_extents.is_finite()
            && (0.0..1.0).contains(&self.damage)
            && self.center.is_finite()
            && (self.normal.length() - 1.0).abs() < 1e-3
            && (self.axis.length() - 1.0).abs() < 1e-3
            && self.normal.dot(self.axis).abs() < 1e-2
    }

    /// The same in a frame that is shifted.
    pub(crate) fn translated(self, offset: Vec3) -> Self {
        Self {
            center: self.center + offset,
            ..self
        }
    }

    /// The same of a compound that is scaled. The face is an approximation where factors differ and it is not along the axes.
    pub(crate) fn scaled(self, factor: Vec3) -> Self {
        let axis = factor * self.axis;
        let other = factor * self.normal.cross(self.axis);
        // A plane's normal goes with the inverse factors.
        let normal = (self.normal / factor).normalize();
        let along = axis.reject_from_normalized(normal).normalize();
        let sides = Vec2::new(axis.length(), other.reject_from_normalized(along).length());
        Self {
            center: factor * self.center,
            normal,
            axis: along,
            half_extents: self.half_extents * sides,
            area: self.area * sides.element_product(),
            ..self
        }
    }
}

/// Area and moments of faces, by triangles.
#[derive(Default)]
struct FaceMoments {
    area: f64,
    /// Integral of the place, m3.
    first: DVec3,
    /// Area vector, m2.
    normal: DVec3,
    triangles: Vec<[DVec3; 3]>,
}

impl FaceMoments {
    fn add(&mut self, polygon: &Polygon, normal: Vec3) {
        let Some(&apex) = polygon.first() else {
            return;
        };
        for pair in polygon.windows(2).skip(1) {
            let [a, b, c] = [apex, pair[0], pair[1]].map(Vec3::as_dvec3);
            let area = 0.5 * (b - a).cross(c - a).length();
            self.area += area;
            self.first += area / 3.0 * (a + b + c);
            self.normal += area * normal.as_dvec3();
            self.triangles.push([a, b, c]);
        }
    }

    /// The bond over these faces, which are in the frame of a part at `pose`.
    fn bond(&self, parts: [u32; 2], pose: &Pose, strength: f32) -> Option<PartBond> {
        let normal = self.normal.as_vec3().try_normalize()?;
        let center = self.first / self.area;
        let [u, v] = tangents(normal).map(Vec3::as_dvec3);
        let mut second = DMat2::ZERO;
        for triangle in &self.triangles {
            let flat = triangle.map(|at| DVec2::new((at - center).dot(u), (at - center).dot(v)));
            let area = 0.5 * (flat[1] - flat[0]).perp_dot(flat[2] - flat[0]).abs();
            // The integral of x x^T over a triangle: its area times the mean of that of the middles of its sides.
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                let middle = 0.5 * (flat[i] + flat[j]);
                second += DMat2::from_cols(middle * middle.x, middle * middle.y) * (area / 3.0);
            }
        }
        let (turn, moments) = principal(second);
        let axis = (turn.x * u + turn.y * v).as_vec3();
        let half = |moment: f64| (3.0 * moment / self.area).sqrt() as f32;
        Some(PartBond {
            parts,
            center: pose.transform_point(center.as_vec3()),
            normal: rotate(pose.rotation, normal),
            axis: rotate(pose.rotation, axis).normalize(),
            half_extents: Vec2::new(half(moments.x), half(moments.y)),
            area: self.area as f32,
            strength,
            shear_strength: strength,
            damage: 0.0,
        })
    }
}

/// Unit eigenvector of the larger eigenvalue of a symmetric matrix, and both eigenvalues, the larger first.
fn principal(m: DMat2) -> (DVec2, DVec2) {
    let (a, b, d) = (m.x_axis.x, m.x_axis.y, m.y_axis.y);
    let (mean, half) = (0.5 * (a + d), 0.5 * (a - d));
    let radius = (half * half + b * b).sqrt();
    let rows = [DVec2::new(half + radius, b), DVec2::new(b, radius - half)];
    let longest = if rows[0].length_squared() > rows[1].length_squared() {
        rows[0]
    } else {
        rows[1]
    };
    let least = (mean - radius).max(0.0);
    (
        longest.normalize_or(DVec2::X),
        DVec2::new(mean + radius, least),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::ConvexMesh;
    use glam::Quat;

    #[test]
    fn a_shared_rectangle_is_found_as_it_is() {
        let brick = |x, y, z| ConvexMesh::cuboid(x, y, z).expect("a box");
        let parts = [
            CompoundPart::new(Pose::IDENTITY, brick(1.0, 1.0, 1.0)),
            CompoundPart::new(
                Pose::from_position(Vec3::new(0.75, 0.3, 0.0)),
                brick(0.5, 1.0, 0.6),
            ),
        ];
        let turn = Quat::from_xyzw(0.1, 0.5, -0.2, 0.7).normalize();
        let place = Pose::new(Vec3::new(3.0, -1.0, 2.0), turn);
        let turned = parts.map(|part| CompoundPart::new(place * part.pose, part.shape));
        let bond = PartBond::between(&turned, [0, 1], 1e5).expect("they touch");
        assert!((bond.area - 0.7 * 0.6).abs() < 1e-5, "{bond:?}");
        let center = place.transform_point(Vec3::new(0.5, 0.15, 0.0));
        assert!((bond.center - center).length() < 1e-5, "{bond:?}");
        assert!((bond.normal - turn * Vec3::X).length() < 1e-5, "{bond:?}");
        assert!((bond.axis.dot(turn * Vec3::Y).abs() - 1.0).abs() < 1e-5);
        assert!((bond.half_extents - Vec2::new(0.35, 0.3)).length() < 1e-5);
        assert!(bond.is_usable());
    }

    #[test]
    fn what_touches_at_an_edge_or_not_at_all_has_no_bond() {
        let cube = ConvexMesh::cuboid(1.0, 1.0, 1.0).expect("a box");
        for at in [Vec3::new(1.0, 1.0, 0.0), Vec3::new(1.05, 0.0, 0.0)] {
            let parts =
                [Vec3::ZERO, at].map(|at| CompoundPart::new(Pose::from_position(at), cube.clone()));
            assert_eq!(PartBond::between(&parts, [0, 1], 1.0), None);
        }
    }
}
