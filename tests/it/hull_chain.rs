//! The predicate of the property test and of the fuzz target: bytes choose a body and a chain of cuts, and every cut has
//! to be right. It judges by volumes of its own, not by the slicer's classification.

use bevy_cleave::geometry::{ConvexHull, HullDefect, primitives};
use bevy_cleave::mass::{VolumeIntegrals, volume_integrals};
use bevy_cleave::math::Plane;
use bevy_cleave::slice::{Cut, HullHalves, HullSlicer, SliceError};
use bevy_cleave::testing::predicates::{
    CONVEX_RELATIVE, FLAT_RELATIVE, ON_PLANE_RELATIVE, length_scale,
};
use glam::{DVec3, Vec3};

/// Distances from a vertex or face, as shares of the size.
const TINY: [f32; 7] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9];

/// Most cuts of one chain.
const LONGEST: usize = 64;

/// Bytes as a source of choices; zeros when they are used up.
struct Choices<'a>(&'a [u8]);

impl Choices<'_> {
    fn byte(&mut self) -> u8 {
        self.0.split_off_first().copied().unwrap_or(0)
    }

    fn below(&mut self, count: usize) -> usize {
        (usize::from(self.byte()) << 8 | usize::from(self.byte())) % count.max(1)
    }

    /// From [-1, 1].
    fn signed(&mut self) -> f32 {
        let bits = u16::from_le_bytes([self.byte(), self.byte()]);
        f32::from(bits) / 32767.5 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.signed(), self.signed(), self.signed())
    }
}

/// Cuts a body again and again as `bytes` say, and gives the number of cuts made. Panics where one is wrong.
pub(crate) fn cut_chain(bytes: &[u8]) -> usize {
    let mut choices = Choices(bytes);
    let Some(mut hull) = body(&mut choices) else {
        return 0;
    };
    let root = f64::from(length_scale(&hull.aabb()));
    let mut halves = HullHalves::copies_of(&hull);
    let (mut slicer, mut cuts) = (HullSlicer::default(), 0);
    while !choices.0.is_empty() && cuts < LONGEST {
        let plane = plane(&hull, &mut choices);
        if check_cut(&hull, plane, root, &mut slicer, &mut halves) {
            let half = if choices.byte() % 2 == 0 {
                &mut halves.below
            } else {
                &mut halves.above
            };
            std::mem::swap(&mut hull, half);
        }
        cuts += 1;
    }
    cuts
}

/// A body of any size, at its origin or far from it.
fn body(choices: &mut Choices) -> Option<ConvexHull> {
    let kind = choices.byte();
    let scale = [1.0, 1e-3, 1e3, 0.03, 30.0][usize::from(choices.byte() % 5)];
    let hull = match kind % 8 {
        0 => primitives::cuboid(scale, scale, scale),
        1 => primitives::cuboid(scale, 0.01 * scale, 0.3 * scale),
        2 => primitives::regular_prism(3 + u32::from(choices.byte() % 30), scale, 0.5 * scale),
        3 => primitives::icosphere(scale, 1),
        4 => primitives::icosphere(scale, 2),
        5 => primitives::wedge(scale, 0.7 * scale, 0.4 * scale),
        _ => {
            let count = 4 + choices.byte() % 20;
            let points: Vec<Vec3> = (0..count).map(|_| scale * choices.vector()).collect();
            ConvexHull::from_points(&points)
        }
    };
    let far = [0.0, 0.0, 3.0 * scale, 1e4][usize::from(choices.byte() % 4)];
    hull.ok()
        .map(|hull| hull.translated(far * choices.vector()))
        // Moving rounds the corners; a body that is small beside its distance need not stay convex.
        .filter(ConvexHull::is_valid)
}

/// A plane through the body, or one that meets it in as unfortunate a way as can be.
fn plane(hull: &ConvexHull, choices: &mut Choices) -> Plane {
    let size = length_scale(&hull.aabb());
    let points = hull.vertices();
    let kind = choices.byte() % 10;
    let corner = points[choices.below(points.len())];
    let other = points[choices.below(points.len())];
    let face = hull.faces()[choices.below(hull.faces().len())];
    let tiny = TINY[usize::from(choices.byte() % 7)] * size * choices.signed().signum();
    match kind {
        0 => Plane::through(corner, choices.vector()),
        1 => Plane::through(corner, (other - corner).cross(choices.vector())),
        2 => {
            let third = points[choices.below(points.len())];
            Plane::through(corner, (other - corner).cross(third - corner))
        }
        3 => face.plane,
        4 => Plane {
            offset: face.plane.offset + tiny,
            ..face.plane
        },
        5 => {
            let plane = Plane::through(corner, choices.vector());
            Plane {
                offset: plane.offset + tiny,
                ..plane
            }
        }
        6 => Plane {
            normal: choices.vector() * [1.0, f32::NAN][usize::from(choices.byte() % 2)],
            offset: choices.signed(),
        },
        7 => Plane::through(corner + 3.0 * size * choices.vector(), choices.vector()),
        _ => Plane::through(
            corner.lerp(other, 0.5 * (choices.signed() + 1.0)),
            choices.vector(),
        ),
    }
}

/// Cuts `hull`, which comes from a body of length scale `root` (m), and checks verdict, volumes and both parts; whether there
/// are two.
pub(crate) fn check_cut(
    hull: &ConvexHull,
    plane: Plane,
    root: f64,
    slicer: &mut HullSlicer,
    halves: &mut HullHalves,
) -> bool {
    let length = plane.normal.as_dvec3().length();
    let usable = plane.offset.is_finite() && (length - 1.0).abs() <= 1e-5;
    let verdict = match slicer.slice_into(hull, plane, halves) {
        Ok(verdict) => verdict,
        Err(SliceError::Plane(_)) => {
            assert!(!usable, "{plane:?} is refused");
            return false;
        }
        Err(error) => panic!("{error}: {plane:?}"),
    };
    assert!(usable, "{plane:?} is taken");
    let [below, above] = volumes(hull, &plane);
    // What a layer over the whole surface holds: of the thickness of a plane, or of a body too thin to be one.
    let layer = |relative: f32| f64::from(relative) * root * surface(hull);
    match verdict {
        Cut::Below => assert!(above <= layer(FLAT_RELATIVE), "{above} m3 above {plane:?}"),
        Cut::Above => assert!(below <= layer(FLAT_RELATIVE), "{below} m3 below {plane:?}"),
        Cut::Cut(()) => {
            let parts = [(&halves.below, below), (&halves.above, above)];
            for (part, volume) in parts {
                check_part(part, root);
                assert!(
                    (part.volume() - volume).abs() <= layer(2.0 * ON_PLANE_RELATIVE),
                    "{plane:?}"
                );
            }
            let sum = halves.below.volume() + halves.above.volume();
            assert!(
                (sum - hull.volume()).abs() <= layer(ON_PLANE_RELATIVE),
                "{sum} {plane:?}"
            );
        }
    }
    verdict.is_cut()
}

/// Closed, a 2-manifold, convex to rounding of the body it comes from, with a volume and its moments.
pub(crate) fn check_part(part: &ConvexHull, root: f64) {
    match part.validate() {
        Ok(()) => {}
        Err(HullDefect::NotConvex { distance, .. }) => {
            assert!(
                f64::from(distance) <= f64::from(CONVEX_RELATIVE) * root,
                "{distance} m outside"
            );
        }
        Err(defect) => panic!("{defect}"),
    }
    let kept = VolumeIntegrals::of_hull(part);
    let fresh = volume_integrals(part.vertices(), part.triangles());
    assert!(kept.volume > 0.0 && kept.volume.is_finite());
    // Both sums have roundings of numbers of the size of the part, or 64 times that; see `MIN_SHARE`.
    let box_volume: f64 = part.aabb().extents().as_dvec3().to_array().iter().product();
    let size = f64::from(part.aabb().diagonal());
    let scale = kept.volume.max(box_volume);
    assert!(
        (kept.volume - fresh.volume).abs() <= 1e-11 * scale,
        "{kept:?} {fresh:?}"
    );
    assert!((kept.centroid - fresh.centroid).length() * kept.volume <= 1e-10 * scale * size);
    let inertia = (kept.inertia - fresh.inertia).to_cols_array();
    assert!(
        inertia
            .iter()
            .all(|e| e.abs() <= 1e-10 * scale * size * size),
        "{kept:?} {fresh:?}"
    );
}

/// Volumes below and above a plane (m3): each face is clipped in `f64`, and the pieces are summed up as tetrahedra about a
/// point of the plane, about which the cap has no volume.
fn volumes(hull: &ConvexHull, plane: &Plane) -> [f64; 2] {
    let normal = plane.normal.as_dvec3();
    let center = hull.aabb().center().as_dvec3();
    let height = |p: DVec3| normal.dot(p) - f64::from(plane.offset);
    let apex = center - height(center) / normal.length_squared() * normal;
    [-1.0, 1.0].map(|sign| {
        let mut six_volumes = 0.0;
        for corners in hull.triangles() {
            let points = corners.map(|v| hull.vertices()[v as usize].as_dvec3());
            let mut kept = Vec::with_capacity(4);
            for k in 0..3 {
                let (a, b) = (points[k], points[(k + 1) % 3]);
                let (from, to) = (sign * height(a), sign * height(b));
                if from >= 0.0 {
                    kept.push(a - apex);
                }
                if (from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0) {
                    kept.push(a + from / (from - to) * (b - a) - apex);
                }
            }
            for pair in kept.get(1..).unwrap_or_default().windows(2) {
                six_volumes += kept[0].dot(pair[0].cross(pair[1]));
            }
        }
        six_volumes / 6.0
    })
}

/// Area of the surface, m2.
fn surface(hull: &ConvexHull) -> f64 {
    let areas = hull.triangles().map(|corners| {
        let [a, b, c] = corners.map(|v| hull.vertices()[v as usize].as_dvec3());
        0.5 * (b - a).cross(c - a).length()
    });
    areas.sum()
}
