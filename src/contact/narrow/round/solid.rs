//! A convex shape as tests of round pairs read it.

use crate::geometry::frustum::{DISC_CORNERS, Frustum};
use crate::geometry::hull_lanes::lowest;
use crate::geometry::round_core::RoundCore;
use crate::geometry::support::Core;
use crate::geometry::{ConvexHull, ConvexMesh};
use glam::{DVec3, Vec3};

/// Cosine of the angle (rad 1e-3) up to which a direction is that of a face: as good as the distance of curved cores tells it.
const SAME: f32 = 1.0 - 5e-7;

/// Share of the largest sphere inside by which cylinders and cones are taken smaller.
const SHRINK: f32 = 0.02;

/// Sine of the angle between a line and a surface up to which it may lie on it.
const LYING: f32 = 0.05;

/// Sine of the tilt of a disc up to which its corners are at fixed places: what stands still keeps its points.
const LEVEL: f32 = 3e-4;

/// Cosine of the tilt of a disc beyond which only its lowest point can touch what is flat.
const STANDING: f32 = 0.98;

/// Sine of the tilt of a disc from which its rim rolls.
const ROLLING: f32 = 0.5;

/// What a shape is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Form<'s> {
    Point(Vec3),
    Segment([Vec3; 2]),
    Hull(&'s ConvexHull),
    Frustum(Frustum),
    Triangle([Vec3; 3]),
}

/// A convex shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Solid<'s> {
    pub(crate) form: Form<'s>,
    /// Around the form, m.
    pub(crate) radius: f32,
    /// What distances are found with.
    pub(crate) inner: Core<'s>,
    /// How far inside of the surface that is, m.
    pub(crate) depth: f32,
    outer: Core<'s>,
}

/// A place on the form of a shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) at: Vec3,
    /// Radius of curvature of the surface there, m; 0 where it does not roll.
    pub(crate) curvature: f32,
}

impl<'s> Solid<'s> {
    pub(crate) fn of(mesh: &'s ConvexMesh) -> Self {
        let Some(round) = mesh.round() else {
            let hull = mesh.hull();
            return Self::sharp(Form::Hull(hull), Core::of_hull(hull));
        };
        let (form, core) = match &round.core {
            RoundCore::Point => (Form::Point(Vec3::ZERO), round.core()),
            RoundCore::Segment(half) => {
                let ends = [*half * Vec3::NEG_Y, *half * Vec3::Y];
                (Form::Segment(ends), round.core())
            }
            RoundCore::Hull(hull) => (Form::Hull(hull), round.core()),
            RoundCore::Frustum(frustum) => {
                let depth = SHRINK * frustum.inradius();
                let inner = Core::Frustum(frustum.shrunk(depth));
                let form = Form::Frustum(*frustum);
                return Self {
                    inner,
                    depth,
                    ..Self::sharp(form, round.core())
                };
            }
        };
        Self {
            radius: round.radius,
            depth: round.radius,
            ..Self::sharp(form, core)
        }
    }

    pub(crate) fn of_triangle(corners: [Vec3; 3]) -> Self {
        Self::sharp(Form::Triangle(corners), Core::of_triangle(corners))
    }

    fn sharp(form: Form<'s>, core: Core<'s>) -> Self {
        Self {
            form,
            radius: 0.0,
            inner: core,
            depth: 0.0,
            outer: core,
        }
    }

    /// The form, to which the radius is to be added.
    pub(crate) fn core(&self) -> Core<'s> {
        self.outer
    }

    /// A point inside.
    pub(crate) fn middle(&self) -> Vec3 {
        match self.form {
            Form::Hull(hull) => hull.centroid(),
            _ => self.outer.middle(),
        }
    }

    /// The point of the surface farthest along a unit vector.
    pub(crate) fn support(&self, axis: DVec3) -> DVec3 {
        self.outer.exact_support(axis) + f64::from(self.radius) * axis
    }

    /// The normal of a flat or straight part of the surface that looks along a unit vector, if one does.
    pub(crate) fn normal_near(&self, axis: Vec3) -> Option<Vec3> {
        let same = |normal: Vec3| (normal.dot(axis) > SAME).then_some(normal);
        match self.form {
            Form::Point(_) => None,
            Form::Segment([a, b]) => {
                let along = (b - a).normalize();
                let across = axis - axis.dot(along) * along;
                across.try_normalize().and_then(same)
            }
            Form::Hull(_) | Form::Triangle(_) => self.face_near(axis).map(|face| face.normal),
            Form::Frustum(frustum) => {
                let side = || side_normal(&frustum, axis).and_then(same);
                self.face_near(axis).map(|face| face.normal).or_else(side)
            }
        }
    }

    /// The flat face that looks along a unit vector, if one does.
    pub(crate) fn face_near(&self, axis: Vec3) -> Option<Flat<'s>> {
        let flat = |normal: Vec3, outline| Flat { normal, outline };
        let found = match self.form {
            Form::Point(_) | Form::Segment(_) => None,
            Form::Hull(hull) => {
                let planes = hull.lanes.planes.iter();
                let (face, _) = lowest(planes.map(|p| &p.normals), -axis);
                let face = face.min(hull.faces().len() - 1);
                let normal = hull.faces()[face].plane.normal;
                Some(flat(normal, Outline::Face(hull, face)))
            }
            Form::Frustum(frustum) => {
                let disc = usize::from(axis.y > 0.0);
                let normal = if disc == 1 { Vec3::Y } else { Vec3::NEG_Y };
                let has_area = frustum.radii[disc] > 0.0;
                has_area.then_some(flat(normal, Outline::Disc(frustum, disc)))
            }
            Form::Triangle(corners) => {
                let [a, b, c] = corners;
                let normal = (b - a).cross(c - a).normalize_or_zero();
                Some(flat(normal, Outline::Corners(corners)))
            }
        };
        found.filter(|face| face.normal.dot(axis) > SAME)
    }

    /// What of the form looks along a unit vector most: the corners of a face in order, the ends of a line, or a point.
    pub(crate) fn feature(&self, axis: Vec3, places: &mut Vec<Place>) {
        places.clear();
        let curvature = self.radius;
        let mut add = |at| places.push(Place { at, curvature });
        match self.form {
            Form::Point(at) => add(at),
            Form::Segment(ends) => ends.into_iter().for_each(add),
            Form::Triangle(corners) => corners.into_iter().for_each(add),
            Form::Hull(hull) => {
                let (support, _) = lowest(hull.lanes.points.iter(), -axis);
                let face = hull.incident_face(support, -axis);
                let outline = face.map_or(&[][..], |face| hull.face_loop(face));
                outline
                    .iter()
                    .for_each(|&v| add(hull.vertices()[v as usize]));
            }
            Form::Frustum(frustum) => add_of_frustum(&frustum, axis, places),
        }
    }

    /// The straight part of the surface that looks along a unit vector, if it has an end on either side of the point there.
    pub(crate) fn line(&self, axis: Vec3) -> Option<[Place; 2]> {
        let place = |at| Place {
            at,
            curvature: self.radius,
        };
        let lies = |[a, b]: [Vec3; 2]| (b - a).dot(axis).abs() < LYING * (b - a).length();
        match self.form {
            Form::Point(_) => None,
            Form::Segment(ends) => lies(ends).then(|| ends.map(place)),
            Form::Frustum(frustum) => {
                let normal = side_normal(&frustum, axis)?;
                (normal.dot(axis) > 1.0 - 0.5 * LYING * LYING).then(|| side(&frustum, axis))
            }
            Form::Triangle([a, b, c]) => highest(
                [[a, b], [b, c], [c, a]].into_iter().filter(|e| lies(*e)),
                axis,
            )
            .map(|ends| ends.map(place)),
            Form::Hull(hull) => {
                let edges = hull.edges().iter();
                let edges = edges.map(|e| e.vertices.map(|v| hull.vertices()[v as usize]));
                highest(edges.filter(|e| lies(*e)), axis).map(|ends| ends.map(place))
            }
        }
    }

    /// Radius of curvature at a point of the form where the surface looks along a unit vector, m; 0 where it does not roll.
    pub(crate) fn curvature(&self, axis: Vec3, at: Vec3) -> f32 {
        match self.form {
            Form::Frustum(_) => rim_curvature(axis, Vec3::new(at.x, 0.0, at.z).length()),
            _ => self.radius,
        }
    }

    /// The point of a rim or the tip that looks along a unit vector, where neither a side nor a face does.
    pub(crate) fn sharp_point(&self, axis: Vec3) -> Option<Vec3> {
        let Form::Frustum(_) = self.form else {
            return None;
        };
        let is_sharp = self.normal_near(axis).is_none();
        is_sharp.then(|| self.outer.exact_support(axis.as_dvec3()).as_vec3())
    }
}

/// A flat face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flat<'s> {
    pub(crate) normal: Vec3,
    outline: Outline<'s>,
}

#[derive(Clone, Copy, Debug)]
enum Outline<'s> {
    Face(&'s ConvexHull, usize),
    Disc(Frustum, usize),
    Corners([Vec3; 3]),
}

impl Flat<'_> {
    /// Its corners, counter-clockwise seen from outside.
    pub(crate) fn outline(&self, corners: &mut Vec<Vec3>) {
        corners.clear();
        match &self.outline {
            Outline::Face(hull, face) => {
                let outline = hull.face_loop(&hull.faces()[*face]).iter();
                corners.extend(outline.map(|&v| hull.vertices()[v as usize]));
            }
            Outline::Disc(frustum, disc) => corners.extend(frustum.disc(*disc, Vec3::X)),
            Outline::Corners(list) => corners.extend(list),
        }
    }

    /// How far its plane is along its normal, m.
    pub(crate) fn offset(&self) -> f32 {
        match &self.outline {
            Outline::Face(hull, face) => hull.faces()[*face].plane.offset,
            Outline::Disc(frustum, disc) => self.normal.y * frustum.levels[*disc],
            Outline::Corners([a, ..]) => self.normal.dot(*a),
        }
    }
}

/// Of lines, the one whose lower end is highest along a unit vector.
fn highest(lines: impl Iterator<Item = [Vec3; 2]>, axis: Vec3) -> Option<[Vec3; 2]> {
    let mut best = None;
    for line in lines {
        let height = line[0].dot(axis).min(line[1].dot(axis));
        if best.is_none_or(|(_, most)| height > most) {
            best = Some((line, height));
        }
    }
    best.map(|(line, _)| line)
}

/// The unit vector across the axis on the side where a direction looks.
fn out_along(axis: Vec3) -> Option<Vec3> {
    let across = Vec3::new(axis.x, 0.0, axis.z);
    let length = across.length();
    (length > LEVEL).then(|| across / length)
}

/// The normal of the side of a cylinder or cone where a direction looks.
fn side_normal(frustum: &Frustum, axis: Vec3) -> Option<Vec3> {
    let n = frustum.side_normal().as_vec2();
    out_along(axis).map(|out| n.x * out + n.y * Vec3::Y)
}

/// The straight line of the side where a direction looks: a part of a surface that rolls about the axis.
fn side(frustum: &Frustum, axis: Vec3) -> [Place; 2] {
    let out = out_along(axis).unwrap_or(Vec3::X);
    [0, 1].map(|disc| Place {
        at: frustum.rim(disc, out),
        curvature: rim_curvature(axis, frustum.radii[disc]),
    })
}

/// Radius of curvature of a rim or a side that looks along a unit vector: from where this meets the axis.
fn rim_curvature(axis: Vec3, radius: f32) -> f32 {
    let tilt = Vec3::new(axis.x, 0.0, axis.z).length();
    if tilt > ROLLING { radius / tilt } else { 0.0 }
}

fn add_of_frustum(frustum: &Frustum, axis: Vec3, places: &mut Vec<Place>) {
    let side_looks = side_normal(frustum, axis).map_or(0.0, |normal| normal.dot(axis));
    let disc = usize::from(axis.y > 0.0);
    let radius = frustum.radii[disc];
    if side_looks >= axis.y.abs() || radius == 0.0 && side_looks > 0.0 {
        places.extend(side(frustum, axis));
        return;
    }
    let out = out_along(axis);
    if radius == 0.0 || axis.y.abs() < STANDING {
        let at = frustum.rim(disc, out.unwrap_or(Vec3::X));
        let curvature = rim_curvature(axis, radius);
        places.push(Place { at, curvature });
        return;
    }
    places.reserve(DISC_CORNERS);
    let corners = frustum.disc(disc, out.unwrap_or(Vec3::X));
    places.extend(corners.map(|at| Place { at, curvature: 0.0 }));
}
