//! What stands breaks: which pieces hold on to the world and which fall; and which blows it takes, whatever rests on what is hit.
//! A program of its own, because it runs whole families of scenes.

#[path = "../common/mod.rs"]
mod common;

mod anchors;
mod debris;
mod in_app;
mod large_meshes;
mod loads;
mod scenes;
