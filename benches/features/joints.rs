//! Joints of every kind: the same rows of crates, joined by balls and by others.

use crate::built::{Held, crates, of_two};
use crate::pair::{Pair, Row};
use bevy_cleave::prelude::*;

/// rad.
const WIDE: f32 = 0.5;

/// By balls, and by something else.
fn by(joint: Joint) -> Pair {
    of_two(
        crates(Held::Joints(&Joint::ball())),
        crates(Held::Joints(&joint)),
    )
}

/// By hinges, and by hinges with something more.
fn with(change: impl FnOnce(Joint) -> Joint) -> Pair {
    let hinge = Joint::hinge();
    of_two(
        crates(Held::Joints(&hinge)),
        crates(Held::Joints(&change(hinge))),
    )
}

pub(crate) fn rows() -> Vec<Row> {
    let row = |difference, make| Row::new("Joints", difference, make);
    vec![
        row("20 rows of 10 crates, joined by balls", || {
            of_two(crates(Held::No), crates(Held::Joints(&Joint::ball())))
        }),
        row("the same by hinges, without: by balls", || {
            by(Joint::hinge())
        }),
        row("the same fixed", || by(Joint::fixed())),
        row("the same by sliders", || by(Joint::slider())),
        row("the same by cylinders", || by(Joint::cylindrical())),
        row("the same by cones with twist", || {
            by(Joint::cone_twist(WIDE, WIDE))
        }),
        row("the same by rods", || by(Joint::rod(0.1))),
        row("the same by ropes", || by(Joint::rope(0.1))),
        row("the same by springs", || {
            let spring = JointSpring::Frequency {
                hertz: 2.0,
                damping_ratio: 1.0,
            };
            by(Joint::spring(0.1, spring))
        }),
        row("hinges that have limits, without: hinges", || {
            with(|hinge| hinge.with_angular_limits(-WIDE, WIDE))
        }),
        row("hinges that have motors", || {
            with(|hinge| hinge.with_angular_drive(JointDrive::velocity(0.0, 1.0)))
        }),
        row("hinges that may break", || {
            with(|hinge| hinge.with_strength(1e9, 1e9))
        }),
        row("hinges whose bodies may touch", || {
            with(|hinge| hinge.with_contacts(true))
        }),
    ]
}
