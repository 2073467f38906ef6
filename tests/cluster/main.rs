//! Bodies whose parts are held by bonds: a program of their own.

#[path = "../common/app.rs"]
mod app;
#[path = "../common/mod.rs"]
mod common;
#[path = "../common/hierarchy.rs"]
mod hierarchy;

mod asleep;
mod blasts;
mod blows;
mod entities;
mod family;
mod hanging;
mod hung;
mod in_app;
mod levels;
mod loads;
mod lying;
mod pushes;
mod shapes;
mod thick;
mod threads;
mod unanchored;
mod wear;
mod wide;
