//! What a pointer cuts that is dragged across the picture.

use crate::geometry::ConvexHull;
use crate::math::Plane;
use crate::query::error::QueryError;
use crate::query::request::Ray;
use crate::query::shape::QueryShape;

/// Thickness of the blade as a share of how far it reaches: a hull has some.
const THICKNESS: f32 = 1e-4;

/// The blade between two rays of a camera: a plane to cut by, and a shape that says who is in its way.
///
/// ```
/// use bevy_cleave::prelude::*;
/// # use bevy_math::Vec3;
/// # fn cut(commands: &mut bevy_ecs::prelude::Commands, space: SpatialQuery, eye: Vec3, a: Vec3, b: Vec3) -> Result<(), QueryError> {
/// // Rays through where the pointer was pressed and where it was released, from a camera's `viewport_to_world`.
/// let blade = Blade::between(&Ray::new(eye, a, 30.0)?, &Ray::new(eye, b, 30.0)?)?;
/// for body in space.overlap_shape(&blade.shape(), &Pose::IDENTITY, &QueryFilter::all())? {
///     commands.slice(body, blade.plane());
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Blade {
    plane: Plane,
    fan: ConvexHull,
}

impl Blade {
    /// The blade between two rays, which reaches as far as they do.
    ///
    /// # Errors
    /// [`QueryError::Length`] if a ray has no end or no length, [`QueryError::ZeroDirection`] if both are one.
    pub fn between(from: &Ray, to: &Ray) -> Result<Self, QueryError> {
        for ray in [from, to] {
            let value = ray.max_distance();
            if !(value > 0.0 && value.is_finite()) {
                let name = "the reach of a blade";
                return Err(QueryError::Length { name, value });
            }
        }
        let ends = [from, to].map(|ray| ray.at(ray.max_distance()));
        // Across both, be they from one point or side by side; in f64, for short ways of a pointer.
        let origin = from.origin().as_dvec3();
        let [a, b] = ends.map(|end| end.as_dvec3() - origin);
        let normal = a
            .cross(b)
            .try_normalize()
            .ok_or(QueryError::ZeroDirection)?;
        let plane = Plane::through(from.origin(), normal.as_vec3());
        let half = 0.5 * THICKNESS * from.max_distance().max(to.max_distance()) * plane.normal;
        let corners = [from.origin(), ends[0], ends[1], to.origin()];
        let points = corners.map(|corner| [corner - half, corner + half]);
        let fan = ConvexHull::from_points(points.as_flattened());
        // Rays that hardly differ enclose nothing.
        let fan = fan.map_err(|_| QueryError::ZeroDirection)?;
        Ok(Self { plane, fan })
    }

    /// To cut by, world frame.
    pub fn plane(&self) -> Plane {
        self.plane
    }

    /// All that is between the rays, in the world frame: what overlaps it at the identity is in the way.
    pub fn shape(&self) -> QueryShape<'_> {
        QueryShape::hull(&self.fan)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn ray(direction: Vec3, reach: f32) -> Ray {
        Ray::new(Vec3::new(1.0, 2.0, 3.0), direction, reach).expect("a ray")
    }

    #[test]
    fn blade_holds_both_rays_and_its_plane_goes_through_them() {
        for number in 0..50 {
            let [x, y] = [number % 7, number / 7].map(|i| 0.3 * (i as f32 - 3.0));
            let from = ray(Vec3::new(x, y, -2.0), 30.0);
            for apart in [0.3, 0.03, 0.003] {
                let turned = from.direction() + apart * Vec3::new(1.0 - y, 0.3 + x, 0.7);
                let to = ray(turned, 20.0);
                let blade = Blade::between(&from, &to).expect("rays that differ");
                for ray in [&from, &to] {
                    for share in [0.1, 0.5, 0.9] {
                        let at = ray.at(share * ray.max_distance());
                        assert!(blade.plane().distance(at).abs() < 1e-4);
                        let faces = blade.fan.faces().iter();
                        let out = faces.map(|face| face.plane.distance(at));
                        assert!(out.fold(f32::MIN, f32::max) < 1e-4);
                    }
                }
            }
        }
    }

    #[test]
    fn parallel_rays_of_an_orthographic_camera_make_a_blade() {
        let from = Ray::new(Vec3::ZERO, Vec3::NEG_Z, 10.0).expect("a ray");
        let to = Ray::new(Vec3::X, Vec3::NEG_Z, 10.0).expect("a ray");
        let blade = Blade::between(&from, &to).expect("rays that differ");
        assert!((blade.plane().normal.y.abs() - 1.0).abs() < 1e-6);
        assert!((blade.fan.volume() - 10.0 * 1e-3).abs() < 1e-4);
    }

    #[test]
    fn rays_without_a_blade_between_them_are_refused() {
        let from = ray(Vec3::X, 30.0);
        assert_eq!(
            Blade::between(&from, &from).err(),
            Some(QueryError::ZeroDirection)
        );
        for reach in [0.0, f32::INFINITY] {
            let to = ray(Vec3::Y, reach);
            let refused = Blade::between(&from, &to);
            assert!(matches!(refused, Err(QueryError::Length { .. })));
        }
    }
}
