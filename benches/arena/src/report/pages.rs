//! The pages of the report as Markdown.

use super::dominance::{Duel, Duels, Footing, OURS, Overall, ROUNDING, overall};
use super::error_label;
use crate::table::{Row, Table};
use std::fmt::Write;

/// All of a table on one page without pictures: figures over all scenes, each scene's, each engine as it ships, the least errors, all points.
pub(super) fn single(table: &Table, title: &str) -> String {
    let mut page = format!(
        "# {title}\n\nWritten by `arena report FILE.csv --page FILE.md` (`benches/arena`) from the results of\n\n"
    );
    for comment in &table.comments {
        writeln!(page, "- {comment}").expect("a string");
    }
    page += &rules("[below](#all-points)");
    page += &figures(table);
    for overall in overall(table) {
        page += &by_scene(&overall);
    }
    page += &as_shipped(table);
    page += &least_errors(table);
    page + "\n## All points\n" + &all_points(table)
}

/// The first page: figures over all scenes, each scene's, each engine as it ships, pictures. `pictures`: scene and file.
pub(super) fn overview(table: &Table, pictures: &[(String, String)]) -> String {
    let mut page = String::from(
        "# Arena\n\nWritten by `arena report` (`benches/arena`) from the results of\n\n",
    );
    for comment in &table.comments {
        writeln!(page, "- {comment}").expect("a string");
    }
    page += &rules("[points.md](points.md)");
    page += &figures(table);
    for overall in overall(table) {
        page += &by_scene(&overall);
    }
    page += &as_shipped(table);
    page += "\n## Pictures\n\nRings: settings that the engines ship with.\n\n";
    for (scene, file) in pictures {
        writeln!(page, "![{scene}]({file})\n").expect("a string");
    }
    page
}

/// `points`: a link to all of them.
fn rules(points: &str) -> String {
    format!(
        "\nTimes are medians over the steps after landing, in ms per step: CPU time of the process on one thread, wall \
         time on more. For each point of another engine that stands (finite, nothing fallen, no wall passed), at any \
         setting, its ratio is its time over the time of our cheapest setting whose error is no larger; 0 if we have \
         none. Errors below {ROUNDING:e} count as equal. Our plugin and Avian are measured by a whole update of their app; where \
         others are said to be in an app too, the time of an update without physics, measured beside, is added to \
         theirs. All points: {points}.\n"
    )
}

fn figures(table: &Table) -> String {
    let mut text = String::from(
        "\n## Dominance\n\n| ours | threads | dominance_worst | dominance_median | median over scenes of the worst | \
         points at which ours is at least as fast | points not reached |\n|---|---|---|---|---|---|---|\n",
    );
    for overall in overall(table) {
        let all = overall.all();
        let (engine, threads, of_worst) =
            (overall.title(), overall.threads, overall.median_of_worst());
        let (worst, median) = (all.worst(), all.median());
        let (won, missed, count) = (all.won(), all.not_reached().count(), all.0.len());
        writeln!(
            text,
            "| {engine} | {threads} | {worst:.2} | {median:.2} | {of_worst:.2} | {won} | {missed} of {count} |"
        )
        .expect("a string");
    }
    text
}

fn by_scene(overall: &Overall<'_>) -> String {
    let mut text = format!(
        "\n### {}, {} thread(s)\n\n| scene | worst | median | hardest point | ms | error | ours | ms | error | not reached \
         |\n|---|---|---|---|---|---|---|---|---|---|\n",
        overall.title(),
        overall.threads
    );
    for (scene, duels) in &overall.scenes {
        let Some(duel) = duels.hardest() else {
            continue;
        };
        let Duel { peer, ours, .. } = duel;
        let [setting, ms, err] = match ours {
            Some(ours) => [ours.setting.clone(), time(ours.cost()), number(ours.err)],
            None => ["not reached".into(), "-".into(), "-".into()],
        };
        let missed: Vec<String> = duels.not_reached().map(name).collect();
        writeln!(
            text,
            "| {scene} | {:.2} | {:.2} | {} | {} | {} | {setting} | {ms} | {err} | {} |",
            duels.worst(),
            duels.median(),
            name(peer),
            time(duel.cost()),
            number(peer.err),
            missed.join(", ")
        )
        .expect("a string");
    }
    text
}

fn name(row: &Row) -> String {
    format!("{} {}", row.engine, row.setting)
}

/// Milliseconds with four digits.
fn time(ms: f64) -> String {
    if ms < 1.0 {
        format!("{ms:.4}")
    } else {
        format!("{ms:.3}")
    }
}

fn number(value: f64) -> String {
    if value == 0.0 || (0.01..1000.0).contains(&value.abs()) {
        format!("{value:.3}")
    } else {
        format!("{value:.1e}")
    }
}

/// Time and error of each engine with the setting that it ships with.
fn as_shipped(table: &Table) -> String {
    let head = "\n## As shipped\n\nms per step, error; *fallen* in italics.\n";
    by_engine(table, head, |rows| {
        let row = rows.iter().find(|r| r.is_default)?;
        Some(shipped(row))
    })
}

/// The point of each engine with the least error, at any setting.
fn least_errors(table: &Table) -> String {
    let head = "\n## Least errors\n\nSetting: ms per step, error.\n";
    by_engine(table, head, |rows| {
        let standing = rows.iter().filter(|r| r.stands());
        let row = standing.min_by(|a, b| {
            (a.err, a.cost())
                .partial_cmp(&(b.err, b.cost()))
                .expect("finite")
        })?;
        Some(format!("{}: {}", row.setting, shipped(row)))
    })
}

/// Tables with a line for each scene and a column for each engine, of which `cell` gets the points.
fn by_engine(table: &Table, head: &str, cell: impl Fn(&[&Row]) -> Option<String>) -> String {
    let engines = table.distinct(|row| row.engine.clone());
    let mut text = String::from(head);
    for threads in table.distinct(|row| row.threads) {
        writeln!(
            text,
            "\n### {threads} thread(s)\n\n| scene | bodies | {} |",
            engines.join(" | ")
        )
        .expect("a string");
        writeln!(text, "|---|---|{}", "---|".repeat(engines.len())).expect("a string");
        for scene in table.distinct(|row| row.scene.clone()) {
            let here = |r: &&Row| r.scene == scene && r.threads == threads;
            let rows: Vec<&Row> = table.rows.iter().filter(here).collect();
            let Some(first) = rows.first() else { continue };
            let of = |engine: &String| {
                let its: Vec<&Row> = rows
                    .iter()
                    .copied()
                    .filter(|r| r.engine == *engine)
                    .collect();
                cell(&its).unwrap_or("-".into())
            };
            let cells: Vec<String> = engines.iter().map(of).collect();
            writeln!(
                text,
                "| {scene} | {} | {} |",
                first.bodies,
                cells.join(" | ")
            )
            .expect("a string");
        }
    }
    text
}

fn shipped(row: &Row) -> String {
    let cell = format!("{}, {}", time(row.cost()), number(row.err));
    if row.stands() {
        cell
    } else {
        format!("*{cell}*")
    }
}

/// The second page: all points of all scenes, with what we have against each.
pub(super) fn points(table: &Table) -> String {
    let head = "# All points of the arena\n\nSee [README.md](README.md) for the rules.\n";
    String::from(head) + &all_points(table)
}

fn all_points(table: &Table) -> String {
    let mut page = String::new();
    for scene in table.distinct(|row| row.scene.clone()) {
        for threads in table.distinct(|row| row.threads) {
            let here = |r: &&Row| r.scene == scene && r.threads == threads;
            let mut rows: Vec<&Row> = table.rows.iter().filter(here).collect();
            rows.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
            if let Some(first) = rows.first() {
                let bodies = first.bodies;
                write!(
                    page,
                    "\n## {scene}, {bodies} bodies, {threads} thread(s)\n\n"
                )
                .expect("a string");
                page += &points_of(table, &rows);
            }
        }
    }
    page
}

fn points_of(table: &Table, rows: &[&Row]) -> String {
    let [first, ..] = rows else {
        return String::new();
    };
    let duels =
        OURS.map(|ours| Duels::new(table, ours, first.threads, &first.scene, Footing::Alone));
    let mut text = format!(
        "| engine | setting | ms | mean CPU ms | {} | mean penetration, m | gain of energy | speed at the end, m/s | fallen | \
         {} |\n|---|---|---|---|---|---|---|---|---|---|---|\n",
        error_label(first),
        OURS.map(|ours| format!("ratio to {ours}")).join(" | ")
    );
    for row in rows {
        let ratios = duels.each_ref().map(|duels| ratio(duels, row));
        writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            row.engine,
            row.setting,
            time(row.cost()),
            time(row.cpu_mean),
            number(row.err),
            number(row.pen_mean),
            number(row.energy_gain),
            number(row.rms_speed),
            row.fallen,
            ratios.join(" | ")
        )
        .expect("a string");
    }
    text
}

fn ratio(duels: &Duels<'_>, row: &Row) -> String {
    let duel = duels.0.iter().find(|duel| std::ptr::eq(duel.peer, row));
    match duel {
        Some(Duel {
            ours: Some(ours), ..
        }) => {
            format!("{:.2} ({})", row.cost() / ours.cost(), ours.setting)
        }
        Some(_) => "not reached".into(),
        None => String::new(),
    }
}
