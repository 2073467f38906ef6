//! The problem row by row: what is solved, by whatever method. Read [`mlcp`] first.

pub mod acceleration;
pub mod contact_rows;
pub mod mlcp;
pub mod pgs;
pub mod residual;
pub mod soft_step;
