//! `arena report`: tables and pictures from the table of results.

pub(crate) mod dominance;
pub(crate) mod machine;
mod pages;
mod pictures;
mod shared;

use crate::Error;
use crate::cli::{self, Arguments};
use crate::table::{Row, Table};
use std::fs;
use std::path::{Path, PathBuf};

/// A file of results, where the commands read and write it unless told otherwise.
pub(crate) fn results(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("results")
        .join(name)
}

/// Writes the report that the command line asks for.
pub(crate) fn run(mut words: Arguments) -> Result<(), Error> {
    let mut input = results("arena.csv");
    let mut folder = PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../docs/report/arena"
    ));
    let mut page: Option<PathBuf> = None;
    while let Some(word) = words.word() {
        match word.as_str() {
            "--page" => page = Some(words.value(&word)?),
            "--out" => folder = words.value(&word)?,
            _ if word.starts_with('-') => return Err(cli::unknown(&word)),
            _ => input = word.into(),
        }
    }
    let table = Table::read(&input)?;
    if let Some(file) = page {
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        fs::write(&file, pages::single(&table, &format!("Arena: {name}")))?;
        print!("{}", dominance::summary(&table));
        println!("report in {}", file.display());
        return Ok(());
    }
    fs::create_dir_all(&folder)?;
    let drawn = pictures::draw(&table, &folder)?;
    fs::write(folder.join("README.md"), pages::overview(&table, &drawn))?;
    fs::write(folder.join("points.md"), pages::points(&table))?;
    print!("{}", dominance::summary(&table));
    println!("report in {}", folder.display());
    Ok(())
}

/// What the error of a scene means.
fn error_label(row: &Row) -> &'static str {
    match row.scene_name() {
        "pyramid" | "pyramids" | "tower" | "massratio" | "arch" | "cards" => {
            "largest displacement, m"
        }
        "stick" => "creep, m",
        "pile" => "mean penetration, m",
        "dominoes" => "share still standing",
        "slide" => "relative error of acceleration",
        "spin" => "error of orientation, rad",
        "collide" => "relative drift of momentum",
        "bounce" => "relative error of rebound height",
        "fall" => "error of height, m",
        "chain10" | "chain30" | "chain100" | "bridge" | "stairs" | "ragdolls" => {
            "largest gap of an anchor, m"
        }
        "pendulum" => "relative error of the period",
        "pendulum_energy" => "error of energy over that of a swing",
        "double_pendulum" | "door" => "largest distance from the exact path, m",
        "spring" => "distance from the exact path over how far it sinks",
        "gyroscope" | "motor" => "distance from the exact path over the way",
        "bullet" | "bullet_ccd" => "passed the wall",
        _ => "error",
    }
}
