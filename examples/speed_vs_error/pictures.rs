//! One picture for each scene: error over time.

use crate::support::Error;
use crate::support::chart::{Axis, Chart, Mark, Note, Series, draw};
use crate::sweep::{Point, Sweep, method_name};
use bevy_cleave::prelude::*;
use std::path::Path;

pub(crate) const BLUE: [u8; 3] = [31, 102, 173];
pub(crate) const ORANGE: [u8; 3] = [206, 92, 20];
pub(crate) const GREEN: [u8; 3] = [38, 132, 84];
pub(crate) const PURPLE: [u8; 3] = [126, 72, 160];
const GREY: [u8; 3] = [150, 150, 150];

fn look(method: Method) -> ([u8; 3], Mark) {
    match method {
        Method::SoftStep => (BLUE, Mark::Circle),
        Method::Pgs => (ORANGE, Mark::Triangle),
        Method::Exact => (GREEN, Mark::Square),
    }
}

/// Writes the picture of a scene to `folder`.
pub(crate) fn scene(folder: &Path, sweep: &Sweep) -> Result<(), Error> {
    let scene = &sweep.scene;
    let errors = || sweep.points.iter().filter_map(|p| p.error);
    let unit = if scene.unit.is_empty() {
        String::new()
    } else {
        format!(" in {}", scene.unit)
    };
    let y = Axis::decades(format!("error{unit}"), errors().chain([scene.bar]));
    // What failed is drawn on the upper edge.
    let at = |p: &Point| (p.median, p.error.unwrap_or(y.high));
    let x = Axis::tight(
        "median time of a step in ms, one thread",
        sweep.points.iter().map(|p| p.median),
    );
    let mut series = vec![Series {
        name: "none beats it in both".into(),
        colour: GREY,
        mark: None,
        is_filled: false,
        line: 2,
        points: sweep.front().into_iter().map(at).collect(),
    }];
    for method in [Method::SoftStep, Method::Pgs, Method::Exact] {
        series.extend(method_series(sweep, method, at));
    }
    let front = sweep.front();
    let noted = [sweep.default(), sweep.paper()];
    let notes = noted.into_iter().chain(front).chain(&sweep.points);
    let notes = notes.enumerate().map(|(i, point)| Note {
        at: at(point),
        text: point.setting.name.clone(),
        is_ringed: i == 0,
    });
    let mut notes: Vec<Note> = notes.collect();
    let mut seen = Vec::new();
    notes.retain(|note| {
        let is_new = !seen.contains(&note.text);
        seen.push(note.text.clone());
        is_new
    });
    let chart = Chart {
        title: scene.title.into(),
        caption: scene.measure.into(),
        x,
        y: y.clone(),
        series,
        notes,
        level: Some((scene.bar, "good".into())),
    };
    draw(folder.join(format!("{}.png", scene.key)), &chart)
}

/// The points of a method: those with the disc of friction, those with the box, and those that failed.
fn method_series(
    sweep: &Sweep,
    method: Method,
    at: impl Fn(&Point) -> (f64, f64),
) -> Vec<Series> {
    let (colour, mark) = look(method);
    let of = |pick: &dyn Fn(&Point) -> bool| {
        let own = sweep.points.iter();
        let own = own.filter(|p| p.setting.config.method == method && pick(p));
        own.map(&at).collect::<Vec<_>>()
    };
    let is_box = |p: &Point| p.setting.config.friction_model == FrictionModel::Box;
    let name = method_name(method);
    let kinds = [
        (name.into(), mark, true, of(&|p| p.error.is_some() && !is_box(p))),
        (
            format!("{name}, box friction"),
            mark,
            false,
            of(&|p| p.error.is_some() && is_box(p)),
        ),
        (format!("{name}: failed"), Mark::Cross, true, of(&|p| p.error.is_none())),
    ];
    let series = kinds.map(|(name, mark, is_filled, points)| Series {
        name,
        colour,
        mark: Some(mark),
        is_filled,
        line: 0,
        points,
    });
    series.into_iter().filter(|s| !s.points.is_empty()).collect()
}
