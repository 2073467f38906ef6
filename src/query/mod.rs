//! What a game asks of a scene: rays, shapes that are moved, what overlaps, what is near; and characters that walk by asking.
//!
//! | file | holds |
//! |---|---|
//! | `view.rs` | [`Queries`]: one read-only view that answers all of it |
//! | `index.rs`, `place.rs` | where bodies are, laid out for it |
//! | `request.rs`, `shape.rs`, `filter.rs`, `error.rs` | what is asked: a ray, a cast, a shape, who counts |
//! | `blade.rs` | the blade between two rays of a camera |
//! | `hit.rs` | what is found |
//! | `target.rs` | one body: its shape where it lies now |
//! | `slide.rs`, `walk.rs`, `walker.rs` | a shape that slides along what it meets; a character that walks |
//! | `footing.rs` | what a character stands on, and steps up to |
//! | `ahead.rs`, `carry.rs` | bodies as a step will leave them; how they carry a character and shove it |
//! | `nearness.rs`, `convex.rs`, `cuboid.rs`, `compound.rs`, `hull.rs`, `round.rs`, `half_space.rs`, `level.rs`, `box_sweep.rs`, `local.rs` | the exact tests, in the frame of the body |
//!
//! Bodies are seen where they were when the index was refreshed; a scene that asks nothing has none. Nothing here changes a scene or is
//! remembered by it. Must not know contacts, the solver or the ECS. Read `view.rs` first.

pub(crate) mod ahead;
mod ball;
mod blade;
mod box_sweep;
mod carry;
pub(crate) mod compound;
pub(crate) mod convex;
mod cuboid;
pub(crate) mod error;
pub(crate) mod filter;
mod footing;
mod half_space;
pub(crate) mod hit;
mod hull;
pub(crate) mod index;
pub(crate) mod level;
pub(crate) mod local;
pub(crate) mod movers;
pub(crate) mod nearness;
mod place;
pub(crate) mod request;
mod round;
pub(crate) mod shape;
pub(crate) mod slide;
mod target;
pub(crate) mod view;
pub(crate) mod walk;
pub(crate) mod walker;

pub use blade::Blade;
pub use error::QueryError;
pub use filter::QueryFilter;
pub use hit::QueryHit;
pub use index::QueryIndex;
pub use request::{Ray, ShapeCast};
pub use shape::QueryShape;
pub use slide::{Slid, Slider};
pub use view::Queries;
pub use walker::{Footing, Push, WalkInput, WalkSettings, WalkState};
