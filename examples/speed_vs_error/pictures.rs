//! Pictures: error over time for each scene, share of solved problems over work and over time.

use crate::files::{Files, LEVELS};
use crate::support::Error;
use crate::support::chart::{Axis, Chart, Mark, Note, Series, draw};
use crate::sweep::{Point, Sweep, method_name};
use bevy_cleave::prelude::*;
use std::path::Path;

const BLUE: [u8; 3] = [31, 102, 173];
const ORANGE: [u8; 3] = [206, 92, 20];
const GREEN: [u8; 3] = [38, 132, 84];
const PURPLE: [u8; 3] = [126, 72, 160];
const GREY: [u8; 3] = [150, 150, 150];

/// Whether two methods are of one kind, whatever their effort.
fn is_same_method(a: &Method, b: &Method) -> bool {
    std::mem::discriminant(a) == std::mem::discriminant(b)
}

/// Shape of the friction bound.
pub(crate) fn friction_of(method: &Method) -> FrictionModel {
    match method {
        Method::SoftStep(_) => FrictionModel::Disc,
        Method::Pgs(pgs) => pgs.friction,
        Method::Exact(exact) => exact.friction,
    }
}

fn look(method: Method) -> ([u8; 3], Mark) {
    match method {
        Method::SoftStep(_) => (BLUE, Mark::Circle),
        Method::Pgs(_) => (ORANGE, Mark::Triangle),
        Method::Exact(_) => (GREEN, Mark::Square),
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
        color: GREY,
        mark: None,
        is_filled: false,
        line: 2,
        points: sweep.front().into_iter().map(at).collect(),
    }];
    let methods = [
        SolverConfig::default(),
        SolverConfig::paper(),
        SolverConfig::exact(),
    ];
    for method in methods.map(|config| config.method) {
        series.extend(method_series(sweep, method, at));
    }
    let chart = Chart {
        title: scene.title.into(),
        caption: scene.measure.into(),
        x,
        y: y.clone(),
        series,
        notes: notes(sweep, at),
        level: Some((scene.bar, "good".into())),
    };
    draw(folder.join(format!("{}.png", scene.key)), &chart)
}

/// Names of the points: the default's with a ring, the paper's, those that none beats, and those of the others that did not
/// fail.
fn notes(sweep: &Sweep, at: impl Fn(&Point) -> (f64, f64)) -> Vec<Note> {
    let others = sweep.points.iter().filter(|p| p.error.is_some());
    let first = [sweep.default(), sweep.paper()];
    let points = first.into_iter().chain(sweep.front()).chain(others);
    let mut notes: Vec<Note> = Vec::new();
    for point in points {
        let text = &point.setting.name;
        if notes.iter().all(|note| note.text != *text) {
            notes.push(Note {
                at: at(point),
                text: text.clone(),
                is_ringed: notes.is_empty(),
            });
        }
    }
    notes
}

/// The points of a method: those with the disc of friction, those with the box, and those that failed.
fn method_series(sweep: &Sweep, method: Method, at: impl Fn(&Point) -> (f64, f64)) -> Vec<Series> {
    let (color, mark) = look(method);
    let of = |pick: &dyn Fn(&Point) -> bool| {
        let own = sweep.points.iter();
        let own = own.filter(|p| is_same_method(&p.setting.config.method, &method) && pick(p));
        own.map(&at).collect::<Vec<_>>()
    };
    let is_box = |p: &Point| friction_of(&p.setting.config.method) == FrictionModel::Box;
    let name = method_name(method);
    let kinds = [
        (
            name.into(),
            mark,
            true,
            of(&|p| p.error.is_some() && !is_box(p)),
        ),
        (
            format!("{name}, box friction"),
            mark,
            false,
            of(&|p| p.error.is_some() && is_box(p)),
        ),
        (
            format!("{name}: failed"),
            Mark::Cross,
            true,
            of(&|p| p.error.is_none()),
        ),
    ];
    let series = kinds.map(|(name, mark, is_filled, points)| Series {
        name,
        color,
        mark: Some(mark),
        is_filled,
        line: 0,
        points,
    });
    series
        .into_iter()
        .filter(|s| !s.points.is_empty())
        .collect()
}

/// Colors of the iterative methods on files.
const COLORS: [[u8; 3]; 3] = [ORANGE, BLUE, GREEN];

/// Writes two pictures for each level of error: share of solved problems over sweeps, and over time.
pub(crate) fn profiles(folder: &Path, files: &Files) -> Result<(), Error> {
    for (i, level) in LEVELS.into_iter().enumerate() {
        let curves = files.curves.iter();
        let work = curves.clone().map(|curve| {
            let sweeps = curve.cold.sweeps.iter().map(|&k| k as f64);
            let points = sweeps.zip(curve.cold.shares(level)).collect();
            (curve.name, points)
        });
        let x = |values| Axis::tight("sweeps: updates of each row", values);
        let name = format!("work_{}.png", i + 1);
        profile(&folder.join(name), level, x, work.collect())?;

        let grid = grid(files);
        let on_grid = |share: &dyn Fn(f64) -> f64| grid.iter().map(|&t| (t, share(t))).collect();
        let mut time: Vec<_> = curves
            .map(|curve| (curve.name, on_grid(&|t| curve.share(level, t))))
            .collect();
        time.push(("exact", on_grid(&|t| files.exact_share(t))));
        let x = |values| Axis::tight("microseconds for each contact", values);
        profile(&folder.join(format!("time_{}.png", i + 1)), level, x, time)?;
    }
    Ok(())
}

/// Times for the horizontal axis, microseconds for each contact.
fn grid(files: &Files) -> Vec<f64> {
    let least = files.times().fold(f64::INFINITY, f64::min);
    let most = files.times().fold(0.0, f64::max);
    let count = 120;
    let at = |i: i32| least * (most / least).powf(f64::from(i) / f64::from(count));
    (0..=count).map(at).collect()
}

type Curve<'a> = (&'a str, Vec<(f64, f64)>);

fn profile(
    path: &Path,
    level: f64,
    x: impl Fn(Vec<f64>) -> Axis,
    curves: Vec<Curve<'_>>,
) -> Result<(), Error> {
    let values = curves.iter().flat_map(|c| &c.1).map(|p| p.0).collect();
    let colors = COLORS.into_iter().chain([PURPLE]);
    let series = curves.into_iter().zip(colors);
    let chart = Chart {
        title: format!("Problems from files solved to a velocity error of {level}"),
        caption: "from no impulses; error in the mass norm, relative to what the contacts do"
            .into(),
        x: x(values),
        y: Axis {
            label: "solved in %".into(),
            low: 0.0,
            high: 100.0,
            is_log: false,
        },
        series: series
            .map(|((name, points), color)| Series {
                name: name.into(),
                color,
                mark: None,
                is_filled: true,
                line: 3,
                points,
            })
            .collect(),
        notes: Vec::new(),
        level: None,
    };
    draw(path, &chart)
}
