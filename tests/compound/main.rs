//! Bodies of several convex parts: a program of their own, which takes half a minute by itself.

#[path = "../common/app.rs"]
mod app;
#[path = "../common/mod.rs"]
mod common;
#[path = "../common/slides.rs"]
mod slides;

mod cutting;
mod in_app;
mod mass;
mod queries;
mod shapes;
mod sliding;
mod standing;
