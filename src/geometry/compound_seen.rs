//! How much of a part of a compound something sees.

use crate::geometry::compound::Compound;
use crate::geometry::polygon::area_of;
use glam::Vec3;

impl Compound {
    /// Area of the faces of a part, as it looks from a point, m2: of what other parts leave open of them, or of all. Frame of the compound.
    pub(crate) fn area_seen(&self, part: usize, from: Vec3, is_open: bool) -> f32 {
        let place = &self.parts()[part];
        let (hull, from) = (place.shape.hull(), place.pose.inverse_transform_point(from));
        let seen = |polygon: &[Vec3], normal: Vec3| {
            let middle = polygon.iter().sum::<Vec3>() / polygon.len().max(1) as f32;
            let slope = normal.dot((from - middle).normalize_or_zero());
            area_of(polygon) * slope.max(0.0)
        };
        let faces = hull.faces().iter().enumerate().map(|(index, face)| {
            let open = self.cover().open_polygons(part, index);
            match open.filter(|_| is_open) {
                Some(polygons) => polygons.map(|it| seen(it, face.plane.normal)).sum::<f32>(),
                None => {
                    let corners = hull.face_loop(face).iter();
                    let corners = corners.map(|&corner| hull.vertices()[corner as usize]);
                    seen(&corners.collect::<Vec<_>>(), face.plane.normal)
                }
            }
        });
        faces.sum()
    }
}
