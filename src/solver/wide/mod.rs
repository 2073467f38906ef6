//! What is done to eight contacts at a time, one in each lane. Nothing here knows islands, batches or threads.

pub mod bias;
pub mod block;
pub mod body_pair;
pub mod bond;
pub mod contacts;
pub mod extrapolate;
pub mod pass;
pub mod point_rows;
pub mod prepare;
pub mod reanchor;
pub mod sweep;
