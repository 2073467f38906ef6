//! Structures whose behaviour is known in advance, as lists of bodies in exact contact: what moves does so by the solver.
//!
//! The static body comes first, and where there are several, all of them; then the dynamic ones, from the ground up.
#![allow(dead_code, reason = "each user builds some of them")]

use bevy_cleave::prelude::*;
use glam::{DQuat, DVec2, DVec3, Quat, Vec3};

/// A horizontal floor at height 0 with friction `mu`.
pub(crate) fn floor(mu: f32) -> BodyDesc {
    half_space(Vec3::Y, mu)
}

/// A static half-space through the origin.
pub(crate) fn half_space(normal: Vec3, mu: f32) -> BodyDesc {
    BodyDesc {
        friction: Friction::new(mu),
        ..BodyDesc::floor(HalfSpaceShape::new(normal).expect("a direction"))
    }
}

/// A dynamic body with friction `mu`.
pub(crate) fn block(shape: &ConvexMesh, position: Vec3, mu: f32) -> BodyDesc {
    BodyDesc {
        friction: Friction::new(mu),
        ..BodyDesc::dynamic(shape.clone(), position)
    }
}

/// A static body with friction `mu`.
pub(crate) fn fixed(shape: &ConvexMesh, position: Vec3, mu: f32) -> BodyDesc {
    BodyDesc {
        kind: RigidBody::Static,
        ..block(shape, position, mu)
    }
}

/// A box with edges of the lengths in `size`, m.
pub(crate) fn cuboid(size: Vec3) -> ConvexMesh {
    ConvexMesh::cuboid(size.x, size.y, size.z).expect("valid size")
}

/// From -1 to 1, different for every `i`, without a pattern that a column could lean along: multiples of an irrational
/// number, folded.
fn scatter(i: usize, irrational: f64) -> f32 {
    (2.0 * (i as f64 * irrational).fract() - 1.0) as f32
}

/// A column of `count` unit cubes on a floor, friction 0.6, each off the axis by up to 1 mm in x and z.
pub(crate) fn tower(count: usize) -> Vec<BodyDesc> {
    let shape = cuboid(Vec3::ONE);
    let cubes = (0..count).map(|i| {
        let (x, z) = (scatter(i, 0.618_034), scatter(i, 0.414_214));
        let off_axis = 7e-4 * Vec3::new(x, 0.0, z);
        block(&shape, Vec3::Y * (i as f32 + 0.5) + off_axis, 0.6)
    });
    std::iter::once(floor(0.6)).chain(cubes).collect()
}

/// A floor and columns of five cubes, `count` in all; one alone lies on the floor.
pub(crate) fn columns(count: usize) -> Vec<BodyDesc> {
    let column = tower(5.min(count));
    let side = ((count / 5) as f64).sqrt().ceil().max(1.0) as usize;
    let mut bodies = vec![column[0].clone()];
    for place in 0..count.div_ceil(5) {
        let at = 2.0 * Vec3::new((place % side) as f32, 0.0, (place / side) as f32);
        bodies.extend(column[1..].iter().cloned().map(|mut desc| {
            desc.pose.position += at;
            desc
        }));
    }
    bodies
}

/// Four unit cubes of 1 t under a fifth of `factor` t, friction 0.6.
pub(crate) fn mass_ratio(factor: f32) -> Vec<BodyDesc> {
    let mut bodies = tower(5);
    bodies[5].density *= factor;
    bodies
}

/// A wall of unit cubes with `base` of them in the lowest row and one less in each row above, 0.1 m apart, friction 0.6.
pub(crate) fn pyramid(base: usize) -> Vec<BodyDesc> {
    let shape = cuboid(Vec3::ONE);
    let place = |row: usize, i: usize| {
        let x = 1.1 * (i as f32 - 0.5 * (base - row - 1) as f32);
        Vec3::new(x, row as f32 + 0.5, 0.0)
    };
    let places = (0..base).flat_map(|row| (0..base - row).map(move |i| place(row, i)));
    let cubes = places.map(|place| block(&shape, place, 0.6));
    std::iter::once(floor(0.6)).chain(cubes).collect()
}

/// Unit normal of a slope of `degrees` that falls towards `heading` degrees about y, from x to z.
fn slope_normal(degrees: f64, heading: f64) -> DVec3 {
    let (tilt, towards) = (
        DVec2::from_angle(degrees.to_radians()),
        DVec2::from_angle(heading.to_radians()),
    );
    DVec3::new(tilt.y * towards.x, tilt.x, tilt.y * towards.y)
}

/// Unit vector down a slope of `degrees` that falls towards `heading`.
pub(crate) fn downhill(degrees: f64, heading: f64) -> Vec3 {
    let normal = slope_normal(degrees, heading);
    (normal * normal.y - DVec3::Y).normalize().as_vec3()
}

/// A half-space that falls by `degrees` towards `heading`, and a body of `shape` on it whose lowest point is `height`
/// below its origin. The body is turned with the slope only, so its axes are at `heading` to the fall.
pub(crate) fn slope(
    shape: &ConvexMesh,
    height: f32,
    mu: f32,
    degrees: f64,
    heading: f64,
) -> Vec<BodyDesc> {
    let normal = slope_normal(degrees, heading);
    let mut body = block(shape, (f64::from(height) * normal).as_vec3(), mu);
    body.pose.rotation = DQuat::from_rotation_arc(DVec3::Y, normal).as_quat();
    vec![half_space(normal.as_vec3(), mu), body]
}

/// A box on a slope that falls by `degrees` towards `heading`.
pub(crate) fn slope_box(size: Vec3, mu: f32, degrees: f64, heading: f64) -> Vec<BodyDesc> {
    slope(&cuboid(size), 0.5 * size.y, mu, degrees, heading)
}

/// A unit cube that slides on a floor with `speed` (m/s) towards `heading` degrees to its own axes.
pub(crate) fn sliding_box(mu: f32, speed: f32, heading: f64) -> Vec<BodyDesc> {
    let towards = DVec2::from_angle(heading.to_radians()).as_vec2();
    let mut cube = block(&cuboid(Vec3::ONE), 0.5 * Vec3::Y, mu);
    cube.linear_velocity = speed * Vec3::new(towards.x, 0.0, towards.y);
    vec![floor(mu), cube]
}

/// A bar of square section, 1 m long, that slides with `speed` (m/s) along x in a groove of two planes at 90 degrees.
pub(crate) fn v_groove(mu: f32, speed: f32) -> Vec<BodyDesc> {
    let side = 0.25_f32;
    let center = (2.0 * side * side).sqrt() * 0.5;
    let mut bar = block(&cuboid(Vec3::new(1.0, side, side)), center * Vec3::Y, mu);
    let eighth_turn = std::f32::consts::FRAC_PI_4;
    bar.pose.rotation = Quat::from_rotation_x(eighth_turn);
    bar.linear_velocity = speed * Vec3::X;
    let plane = |side: f32| half_space(Vec3::new(0.0, 1.0, side), mu);
    vec![plane(-1.0), plane(1.0), bar]
}

/// The hull of a polygon in the xy plane, from `-depth / 2` to `depth / 2` along z, about the mean of its corners; and
/// that mean.
fn extruded(polygon: &[DVec2], depth: f32) -> (ConvexMesh, Vec3) {
    let mean = polygon.iter().sum::<DVec2>() / polygon.len() as f64;
    let corners = polygon.iter().flat_map(|&corner| {
        let flat = (corner - mean).as_vec2();
        [-0.5, 0.5].map(|side| flat.extend(side * depth))
    });
    let shape = ConvexMesh::from_points(&corners.collect::<Vec<_>>()).expect("valid size");
    (shape, mean.as_vec2().extend(0.0))
}

/// A semicircular arch on a floor: `voussoirs` equal blocks with flat sides and radial joints, 0.5 m deep, their corners
/// on circles of radius `1 -+ thickness / 2` m.
pub(crate) fn arch(voussoirs: u32, thickness: f64, mu: f32) -> Vec<BodyDesc> {
    let corner = |joint: u32, radius: f64| {
        // Exactly on the floor at both ends, where the sine of pi is rounded.
        let share = f64::from(joint) / f64::from(voussoirs);
        let mut direction = DVec2::from_angle(std::f64::consts::PI * share);
        direction.y *= f64::from(joint % voussoirs).min(1.0);
        radius * direction
    };
    let (inner, outer) = (1.0 - 0.5 * thickness, 1.0 + 0.5 * thickness);
    let blocks = (0..voussoirs).map(|i| {
        let corners = [
            corner(i, inner),
            corner(i, outer),
            corner(i + 1, outer),
            corner(i + 1, inner),
        ];
        let (shape, center) = extruded(&corners, 0.5);
        block(&shape, center, mu)
    });
    std::iter::once(floor(mu)).chain(blocks).collect()
}

/// Angle of a card of [`card_house`] to the vertical, degrees.
const CARD_LEAN: f64 = 20.0;

/// Half the width of the strips on which the cards of [`card_house`] touch, m.
const CARD_STRIP: f64 = 1e-3;

/// The right one of two cards of 1 x 0.7 x 0.025 m that lean against each other, and its place.
///
/// Where two plain boxes lean edge to edge, every direction between the normals of their faces is a contact normal. So
/// that there is one answer, the ends are bevelled to strips of 2 mm in the middle of the card: one flat on the floor, one
/// upright against the other card, one level on top for a load.
fn card() -> (ConvexMesh, Vec3) {
    let (length, half_thickness, bevel) = (1.0, 0.0125, 0.05);
    let lean = DVec2::from_angle(CARD_LEAN.to_radians());
    let (foot, apex) = (
        DVec2::new(length * lean.y, 0.0),
        DVec2::new(0.0, length * lean.x),
    );
    let up = (apex - foot).normalize();
    let outward = half_thickness * DVec2::new(lean.x, lean.y);
    let strip = CARD_STRIP;
    let (low, high) = (foot + bevel * up, apex - bevel * up);
    let corners = [
        foot - strip * DVec2::X,
        foot + strip * DVec2::X,
        low + outward,
        high + outward,
        apex + DVec2::new(2.0 * strip, strip),
        apex + DVec2::new(0.0, strip),
        apex - DVec2::new(0.0, strip),
        high - outward,
        low - outward,
    ];
    extruded(&corners, 0.7)
}

/// Two cards that lean against each other at 20 degrees to the vertical; if `loaded`, under a plate that weighs as much as
/// both of them.
pub(crate) fn card_house(mu: f32, loaded: bool) -> Vec<BodyDesc> {
    let (shape, place) = card();
    let right = block(&shape, place, mu);
    let mut left = block(&shape, place * Vec3::new(-1.0, 1.0, 1.0), mu);
    left.pose.rotation = Quat::from_xyzw(0.0, 1.0, 0.0, 0.0);
    let mut bodies = vec![floor(mu), right, left];
    if loaded {
        let size = Vec3::new(0.3, 0.05, 0.7);
        let top = (DVec2::from_angle(CARD_LEAN.to_radians()).x + CARD_STRIP) as f32;
        let mut plate = block(&cuboid(size), (top + 0.5 * size.y) * Vec3::Y, mu);
        plate.density = 2.0 * card_mass().mass / size.element_product();
        bodies.push(plate);
    }
    bodies
}

fn card_mass() -> MassProperties {
    MassProperties::of_hull(card().0.hull(), 1000.0).expect("a card has a mass")
}

/// The least friction that holds a [`card_house`]: when the feet slide out, each card turns about the inner end of its
/// foot, touches the other with the top of its strip, and carries the load on the outer end of its level strip. Moments
/// about the foot give the thrust there. For infinitely thin cards it is `tan(20) / 2` bare, `3 tan(20) / 4` loaded.
pub(crate) fn card_house_friction(loaded: bool) -> f64 {
    let lean = DVec2::from_angle(CARD_LEAN.to_radians());
    let center = f64::from(card().1.x + card_mass().center.x);
    let (foot, top) = (lean.y - CARD_STRIP, lean.x + CARD_STRIP);
    if loaded {
        0.5 * ((foot - center) + (foot - 2.0 * CARD_STRIP)) / top
    } else {
        (foot - center) / top
    }
}

/// Two plain cards of 1 x 0.7 x 0.025 m that lean edge to edge at 20 degrees to the vertical.
pub(crate) fn plain_card_house(mu: f32) -> Vec<BodyDesc> {
    let shape = cuboid(Vec3::new(0.025, 1.0, 0.7));
    let lean = DVec2::from_angle(CARD_LEAN.to_radians());
    let place = 0.5 * DVec2::new(0.025 * lean.x + lean.y, 0.025 * lean.y + lean.x);
    let card = |side: f64| {
        let mut card = block(
            &shape,
            DVec3::new(side * place.x, place.y, 0.0).as_vec3(),
            mu,
        );
        card.pose.rotation = DQuat::from_rotation_z(side * CARD_LEAN.to_radians()).as_quat();
        card
    };
    vec![floor(mu), card(1.0), card(-1.0)]
}

/// `count` planks of 1 x 0.1 x 0.5 m on a table, each beyond the one below by `fraction` of the most that balances: from
/// the top 1/2, 1/4, 1/6 m and so on.
pub(crate) fn corbel(count: usize, fraction: f64) -> Vec<BodyDesc> {
    let shape = cuboid(Vec3::new(1.0, 0.1, 0.5));
    let table = fixed(
        &cuboid(Vec3::new(2.0, 1.0, 1.0)),
        Vec3::new(-1.0, -0.5, 0.0),
        0.6,
    );
    let mut overhang = 0.0;
    let planks = (0..count).map(|i| {
        overhang += fraction * 0.5 / (count - i) as f64;
        let place = DVec3::new(overhang - 0.5, 0.1 * i as f64 + 0.05, 0.0);
        block(&shape, place.as_vec3(), 0.6)
    });
    std::iter::once(table).chain(planks).collect()
}

/// Size of a domino, m.
pub(crate) const DOMINO: Vec3 = Vec3::new(0.2, 1.0, 0.5);

/// A domino with its lower front edge at `x`, leaning forward about that edge by `lean` and turning about it with `rate`
/// (rad, rad/s), friction 0.6.
pub(crate) fn domino(x: f32, lean: f32, rate: f32) -> BodyDesc {
    let rotation = Quat::from_rotation_z(-lean);
    let arm = rotation * (0.5 * DOMINO * Vec3::new(-1.0, 1.0, 0.0));
    let mut domino = block(&cuboid(DOMINO), x * Vec3::X + arm, 0.6);
    domino.pose.rotation = rotation;
    domino.angular_velocity = Vec3::new(0.0, 0.0, -rate);
    domino.linear_velocity = domino.angular_velocity.cross(arm);
    domino
}

/// A row of `count` dominoes, one every 0.5 m along x, of which the first turns about its lower front edge with 1 rad/s.
pub(crate) fn dominoes(count: usize) -> Vec<BodyDesc> {
    let row = (0..count).map(|i| domino(0.5 * i as f32, 0.0, if i == 0 { 1.0 } else { 0.0 }));
    std::iter::once(floor(0.6)).chain(row).collect()
}

/// A regular prism of circumradius 1 m, 2 m long so that it keeps its course, that lies across a slope of `degrees` on a side and turns downhill about the front
/// edge of that side with `rate` (rad/s), friction 1.
pub(crate) fn rolling_prism(sides: u32, degrees: f64, rate: f32) -> Vec<BodyDesc> {
    let half_angle = std::f64::consts::PI / f64::from(sides);
    let down = -std::f64::consts::FRAC_PI_2;
    let corners = (0..sides).map(|k| DVec2::from_angle(down + half_angle * f64::from(2 * k + 1)));
    let (shape, _) = extruded(&corners.collect::<Vec<_>>(), 2.0);
    let front = DVec2::from_angle(half_angle);
    let mut bodies = slope(&shape, front.x as f32, 1.0, degrees, 0.0);
    let body = &mut bodies[1];
    let arm = body.pose.rotation * Vec3::new(-front.y as f32, front.x as f32, 0.0);
    body.angular_velocity = Vec3::new(0.0, 0.0, -rate);
    body.linear_velocity = body.angular_velocity.cross(arm);
    bodies
}

/// The planes that cut a block of 4 x 2 x 4 m into 4 x 2 x 4 pieces: how far along which normal, m; those across it go
/// through its middle, which is 1 m up.
pub(crate) fn cuts_of_block() -> impl Iterator<Item = (f32, Vec3)> {
    let places = [-1.0, 0.0, 1.0].map(|x| [(x, Vec3::X), (x, Vec3::Z)]);
    places.into_iter().flatten().chain([(1.0, Vec3::Y)])
}
