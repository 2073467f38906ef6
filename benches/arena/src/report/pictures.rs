//! One picture for each scene: error against time on one thread.

use super::dominance::OURS;
use super::error_label;
use super::shared::chart::{Axis, Chart, Mark, Note, Series, draw as draw_chart};
use crate::table::{Row, Table};
use std::path::Path;

/// Errors below it are drawn at it.
const FLOOR: f64 = 1e-7;

/// Points with larger errors are left out: everything has fallen.
const CEILING: f64 = 10.0;

const PALETTE: [[u8; 3]; 9] = [
    [31, 102, 173],
    [90, 170, 225],
    [196, 78, 34],
    [235, 150, 90],
    [38, 132, 84],
    [126, 72, 160],
    [110, 110, 110],
    [170, 170, 170],
    [190, 160, 30],
];
const MARKS: [Mark; 3] = [Mark::Triangle, Mark::Square, Mark::Cross];

/// Draws all scenes with more than one point into `folder`; scenes and files.
pub(super) fn draw(table: &Table, folder: &Path) -> Result<Vec<(String, String)>, crate::Error> {
    let engines = table.distinct(|row| row.engine.clone());
    let mut drawn = Vec::new();
    for scene in table.distinct(|row| row.scene.clone()) {
        let here = |r: &&Row| r.scene == scene && r.threads == 1 && r.stands() && r.err < CEILING;
        let rows: Vec<&Row> = table.rows.iter().filter(here).collect();
        let is_flat = rows.iter().all(|r| r.err == rows[0].err);
        if is_flat {
            continue;
        }
        let file = format!("{}.png", scene.replace(':', "_"));
        draw_chart(folder.join(&file), &chart(&scene, &rows, &engines))?;
        drawn.push((scene, file));
    }
    Ok(drawn)
}

fn chart(scene: &str, rows: &[&Row], engines: &[String]) -> Chart {
    let (first, place) = (rows[0], |r: &Row| (r.cost(), r.err.max(FLOOR)));
    let of = |engine: &String| {
        rows.iter()
            .copied()
            .filter(|r| r.engine == *engine)
            .collect::<Vec<_>>()
    };
    let series = engines.iter().enumerate().map(|(i, engine)| Series {
        name: engine.clone(),
        color: PALETTE[i % PALETTE.len()],
        mark: Some(if OURS.contains(&engine.as_str()) {
            Mark::Circle
        } else {
            MARKS[i % MARKS.len()]
        }),
        is_filled: OURS.contains(&engine.as_str()),
        line: 1,
        points: of(engine).into_iter().map(place).collect(),
    });
    let note = |row: &&Row| Note {
        at: place(row),
        text: row.setting.clone(),
        is_ringed: row.is_default,
    };
    let mut notes: Vec<Note> = rows.iter().map(note).collect();
    notes.sort_by_key(|note| !note.is_ringed);
    let errors = rows.iter().map(|r| place(r).1);
    Chart {
        title: format!(
            "{scene}: {} bodies, {} steps, one thread",
            first.bodies, first.steps
        ),
        caption:
            "Points that fell are left out; rings are the settings that the engines ship with."
                .into(),
        x: Axis::tight("CPU time of a step, ms", rows.iter().map(|r| r.cost())),
        y: Axis::decades(error_label(first), errors),
        series: series.filter(|s| !s.points.is_empty()).collect(),
        notes,
        level: None,
    }
}
