//! Shapes of constant sizes, which are checked by the compiler: no `Result` to look at.

/// Least and largest size of a constant shape, m. Well inside of what a hull may have.
const SIZES: [f32; 2] = [1e-4, 1e4];

/// Largest ratio of two sizes of a constant shape: flatter ones may be no hulls for rounding.
const MAX_RATIO: f32 = 1e3;

/// Whether all hulls with these sizes, m, are usable.
#[doc(hidden)]
pub const fn are_sizes_usable<const N: usize>(sizes: [f32; N]) -> bool {
    let (mut least, mut largest) = (f32::INFINITY, 0.0);
    let mut at = 0;
    while at < N {
        let size = sizes[at];
        // Not true of a NaN.
        if !(size >= SIZES[0] && size <= SIZES[1]) {
            return false;
        }
        least = if size < least { size } else { least };
        largest = if size > largest { size } else { largest };
        at += 1;
    }
    largest <= MAX_RATIO * least
}

/// A cuboid with constant edges along x, y and z, m: `cuboid!(1.0, 0.05, 1.0)`, or one for a cube.
///
/// A [`ConvexMesh`](crate::geometry::ConvexMesh), like [`ConvexMesh::cuboid`](crate::geometry::ConvexMesh::cuboid), without its
/// errors: sizes that are no constants, not within 0.1 mm and 10 km, or more than a thousand times one another do not compile.
#[macro_export]
macro_rules! cuboid {
    ($x:expr, $y:expr, $z:expr $(,)?) => {{
        const SIZES: [f32; 3] = [$x, $y, $z];
        const {
            assert!(
                $crate::geometry::are_sizes_usable(SIZES),
                "no cuboid has these sizes"
            );
        }
        $crate::geometry::ConvexMesh::cuboid(SIZES[0], SIZES[1], SIZES[2])
            .expect("checked at compile time")
    }};
    ($edge:expr $(,)?) => {
        $crate::cuboid!($edge, $edge, $edge)
    };
}

/// An icosphere with a constant radius, m, and 1 to 4 subdivisions (2 unless given): `icosphere!(0.5)`.
///
/// A [`ConvexMesh`](crate::geometry::ConvexMesh), as [`ConvexMesh::icosphere`](crate::geometry::ConvexMesh::icosphere) makes it;
/// checked as by [`cuboid!`](crate::cuboid).
#[macro_export]
macro_rules! icosphere {
    ($radius:expr, $subdivisions:expr $(,)?) => {{
        const RADIUS: f32 = $radius;
        const SUBDIVISIONS: u32 = $subdivisions;
        const {
            assert!(
                $crate::geometry::are_sizes_usable([RADIUS]),
                "no icosphere has this size"
            );
            assert!(
                SUBDIVISIONS >= 1 && SUBDIVISIONS <= 4,
                "1 to 4 subdivisions"
            );
        }
        $crate::geometry::ConvexMesh::icosphere(RADIUS, SUBDIVISIONS)
            .expect("checked at compile time")
    }};
    ($radius:expr $(,)?) => {
        $crate::icosphere!($radius, 2)
    };
}

/// An upright prism over a regular polygon of 3 to 64 sides, with a constant circumradius and height, m: `prism!(6, 0.5, 1.0)`.
///
/// A [`ConvexMesh`](crate::geometry::ConvexMesh), as
/// [`ConvexMesh::regular_prism`](crate::geometry::ConvexMesh::regular_prism) makes it; checked as by [`cuboid!`](crate::cuboid).
#[macro_export]
macro_rules! prism {
    ($sides:expr, $radius:expr, $height:expr $(,)?) => {{
        const SIDES: u32 = $sides;
        const SIZES: [f32; 2] = [$radius, $height];
        const {
            assert!(
                $crate::geometry::are_sizes_usable(SIZES),
                "no prism has these sizes"
            );
            assert!(SIDES >= 3 && SIDES <= 64, "3 to 64 sides");
        }
        $crate::geometry::ConvexMesh::regular_prism(SIDES, SIZES[0], SIZES[1])
            .expect("checked at compile time")
    }};
}

/// A sphere with a constant radius, m: `sphere!(0.5)`.
///
/// A [`ConvexMesh`](crate::geometry::ConvexMesh), as [`ConvexMesh::sphere`](crate::geometry::ConvexMesh::sphere) makes it; checked as
/// by [`cuboid!`](crate::cuboid).
#[macro_export]
macro_rules! sphere {
    ($radius:expr $(,)?) => {{
        const RADIUS: f32 = $radius;
        const {
            assert!(
                $crate::geometry::are_sizes_usable([RADIUS]),
                "no sphere has this size"
            );
        }
        $crate::geometry::ConvexMesh::sphere(RADIUS).expect("checked at compile time")
    }};
}

/// A capsule along y with a constant radius and length of the straight part, m: `capsule!(0.3, 1.2)`.
///
/// A [`ConvexMesh`](crate::geometry::ConvexMesh), as [`ConvexMesh::capsule`](crate::geometry::ConvexMesh::capsule) makes it; checked
/// as by [`cuboid!`](crate::cuboid).
#[macro_export]
macro_rules! capsule {
    ($radius:expr, $length:expr $(,)?) => {
        $crate::__round!(capsule, $radius, $length)
    };
}

/// A cylinder along y with a constant radius and height, m: `cylinder!(0.5, 1.0)`.
///
/// A [`ConvexMesh`](crate::geometry::ConvexMesh), as [`ConvexMesh::cylinder`](crate::geometry::ConvexMesh::cylinder) makes it; checked
/// as by [`cuboid!`](crate::cuboid).
#[macro_export]
macro_rules! cylinder {
    ($radius:expr, $height:expr $(,)?) => {
        $crate::__round!(cylinder, $radius, $height)
    };
}

/// A cone along y, its tip up, with a constant radius and height, m: `cone!(0.5, 1.0)`.
///
/// A [`ConvexMesh`](crate::geometry::ConvexMesh), as [`ConvexMesh::cone`](crate::geometry::ConvexMesh::cone) makes it; checked as by
/// [`cuboid!`](crate::cuboid).
#[macro_export]
macro_rules! cone {
    ($radius:expr, $height:expr $(,)?) => {
        $crate::__round!(cone, $radius, $height)
    };
}

/// A round shape of two constant sizes.
#[doc(hidden)]
#[macro_export]
macro_rules! __round {
    ($shape:ident, $radius:expr, $length:expr) => {{
        const SIZES: [f32; 2] = [$radius, $length];
        const {
            assert!(
                $crate::geometry::are_sizes_usable(SIZES),
                "no such shape has these sizes"
            );
        }
        $crate::geometry::ConvexMesh::$shape(SIZES[0], SIZES[1]).expect("checked at compile time")
    }};
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::ConvexMesh;

    #[test]
    fn all_sizes_that_pass_make_shapes() {
        let sizes = [SIZES[0], 1e-3, 0.1, 1.0, 10.0, 1e3, SIZES[1]];
        for x in sizes {
            for y in sizes {
                for z in sizes {
                    let is_made = ConvexMesh::cuboid(x, y, z).is_ok();
                    assert!(is_made || !are_sizes_usable([x, y, z]), "{x} {y} {z}");
                }
                let make = [ConvexMesh::capsule, ConvexMesh::cylinder, ConvexMesh::cone];
                for make in make {
                    assert!(make(x, y).is_ok() || !are_sizes_usable([x, y]), "{x} {y}");
                }
                for sides in [3, 4, 7, 32, 64] {
                    let is_made = ConvexMesh::regular_prism(sides, x, y).is_ok();
                    assert!(is_made || !are_sizes_usable([x, y]), "{sides}: {x} {y}");
                }
            }
            for subdivisions in 1..=4 {
                assert!(ConvexMesh::icosphere(x, subdivisions).is_ok());
            }
            assert!(ConvexMesh::sphere(x).is_ok());
        }
        for bad in [f32::NAN, f32::INFINITY, 0.0, -1.0, 1e-9, 1e9] {
            assert!(!are_sizes_usable([1.0, bad]));
        }
        assert!(!are_sizes_usable([1.0, 1e-4]));
    }

    #[test]
    fn constants_become_shapes() {
        const EDGE: f32 = 2.0;
        assert!((cuboid!(EDGE).hull().volume() - 8.0).abs() < 1e-5);
        assert!((cuboid!(1.0, 2.0, 0.5 * EDGE).hull().volume() - 2.0).abs() < 1e-5);
        assert!(icosphere!(1.0).hull().vertices().len() > 12);
        assert_eq!(prism!(6, 1.0, 1.0).hull().vertices().len(), 12);
        let round = [
            sphere!(EDGE),
            capsule!(0.5, EDGE),
            cylinder!(0.5, EDGE),
            cone!(0.5, EDGE),
        ];
        assert!(round.iter().all(ConvexMesh::is_round));
    }
}
