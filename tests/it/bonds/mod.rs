//! Bonds hold what they are said to hold, break where mechanics says they break, and stay broken.

mod areas;
mod inheritance;
mod rows;
mod rules;
mod scene;
mod strength;
mod structures;
