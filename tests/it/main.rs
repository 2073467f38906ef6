//! All tests that need no process of their own, a module for each topic. None makes a task pool, which all would share from then
//! on: what does is in `plugin`, `threads`, `unsafe_code`, `team_helpers` or `determinism`.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/slides.rs"]
mod slides;

mod hull_chain;
mod mlcp_files;
mod models;
mod slice_common;
mod sources;
mod surfaces;

mod allocation;
mod bonds;
mod boxes;
mod contact;
mod contact_cache;
mod docs;
mod fracture;
mod fracture_budget;
mod fracture_energy;
mod fracture_in_step;
mod fracture_ledger;
mod fracture_materials;
mod geometry;
mod ghosts;
mod hard_cases;
mod import;
mod import_far;
mod known_pairs;
mod layering;
mod leaning_plates;
mod local_steps;
mod lying_edges;
mod mass;
mod mlcp;
mod pattern;
mod prelude;
mod public_items;
mod recycling;
mod seams;
mod shape;
mod sleep;
mod slice;
mod slice_cells;
mod slice_faces;
mod slice_hull;
mod slice_mesh;
mod slice_relief;
mod slice_separate;
mod solver;
