//! Bonds hold what they are said to hold, break where mechanics says they break, and stay broken.

#[path = "../app/mod.rs"]
mod app;
#[path = "../dice/mod.rs"]
mod dice;

mod areas;
mod inheritance;
mod plugin;
mod rows;
mod rules;
mod scene;
mod strength;
mod structures;
