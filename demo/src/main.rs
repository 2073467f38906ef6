//! A playground for `bevy_cleave`: slice, throw, shatter. In a window, into pictures, in a browser.
//!
//! `main` says how it runs; [`playground`] says what of it there is, a file for each.

mod ball;
mod debug_view;
mod exhibits;
mod look;
mod measures;
#[cfg(not(target_arch = "wasm32"))]
mod offscreen;
mod panel;
mod playground;
mod shapes;
mod studio;
mod swipe;
mod tempo;
#[cfg(target_arch = "wasm32")]
mod web;
mod window;

#[cfg(not(target_arch = "wasm32"))]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        [] => window::run(),
        ["pictures", folder, ref names @ ..] => offscreen::pictures::take(folder.as_ref(), names)?,
        ["film", file] => offscreen::film::take(file.as_ref())?,
        _ => return Err("usage: cleave_demo [pictures FOLDER [NAME..] | film FILE.gif]".into()),
    }
    Ok(())
}

#[cfg(target_arch = "wasm32")]
fn main() {
    window::run();
}
