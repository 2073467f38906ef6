//! Level geometry, round shapes and questions to a scene: a program of their own, which takes half a minute by itself.

#[path = "../common/app.rs"]
mod app;
#[path = "../common/mod.rs"]
mod common;

mod events;
mod in_app;
mod lying;
mod mesh;
mod queries;
mod surfaces;
