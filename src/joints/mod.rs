//! Joints as plain data: what holds two bodies together at a distance, and what is known of each from step to step.
//!
//! | file | holds |
//! |---|---|
//! | `axis.rs` | what one direction of motion may do: range, softness, drive, friction |
//! | `joint.rs` | `Joint`: two frames and six axes, and the kinds that are made of them |
//! | `driving.rs` | whether a motor moves what it holds |
//! | `error.rs` | why a joint is not usable |
//! | `store.rs` | `Joints`: who is joined to whom, loads, what broke |
//!
//! Must not know rows or how anything is solved: that is `solver/joint`. Read `joint.rs` first.

pub(crate) mod axis;
mod driving;
pub(crate) mod error;
pub(crate) mod joint;
pub(crate) mod store;

pub use axis::{AxisRange, DriveTarget, JointAxis, JointDrive, JointSpring};
pub use error::JointError;
pub use joint::Joint;
pub use store::{BrokenJoint, JointId, JointLoad, Joints};
