//! The command line.

use crate::engine::{Entry, registry};
use crate::{Error, scene, suites};
use std::str::FromStr;

pub(crate) const USAGE: &str = "\
arena run     [--suite quick|full|joints] [--scene a,b:size,..] [--engines a,b,..] [--settings default|all|NAME,..]
              [--threads 1,2] [--repeats N] [--limit SECS] [--sleeping] [--out FILE.csv]
arena scale   [--scene pile,pile-at-rest,pyramids] [--bodies 1000,2000,..] [--engines a,b,..] [--settings ..] [--threads 1,2]
              [--repeats N] [--out FILE.csv]
arena ask     [--bodies 1000,..] [--triangles 500000,..] [--questions N] [--repeats N]
arena level   [--bodies N] [--cells N] [--spacings 0.7,..]
arena events  [--bodies N]
arena heaps   [--scenes N] [--seed N] [--families a,b,..] [--engines a,b,..] [--game]
arena report  [FILE.csv] [--out DIR | --page FILE.md]
arena list

  --suite     quick: a few scenes, each engine as it ships; full: all scenes of contacts, all settings; joints: all with joints
  --scene     scenes from the list, each with an optional size
  --engines   engines from the list (default: all)
  --settings  `default` for what an engine ships with, `all`, or names from the list; an engine takes those that it has
  --threads   numbers of threads (default: 1)
  --repeats   timing runs of each point besides the one for errors, interleaved over all points (default: 3;
              0 takes the times from the run for errors)
  --limit     seconds after which a run counts as failed (default: 300)
  --out       file to append to, or folder of the report
  --page      the whole report as one page without pictures";

/// What follows the command.
pub(crate) struct Arguments(std::vec::IntoIter<String>);

impl Arguments {
    pub(crate) fn new(words: Vec<String>) -> Self {
        Self(words.into_iter())
    }

    /// The next word.
    pub(crate) fn word(&mut self) -> Option<String> {
        self.0.next()
    }

    /// The next word, which belongs to `flag`.
    pub(crate) fn value<T: FromStr>(&mut self, flag: &str) -> Result<T, Error> {
        let word = self.word().ok_or(format!("{flag} needs a value"))?;
        parse(flag, &word)
    }

    /// The parts of the next word between commas.
    pub(crate) fn list<T: FromStr>(&mut self, flag: &str) -> Result<Vec<T>, Error> {
        let word: String = self.value(flag)?;
        word.split(',').map(|part| parse(flag, part)).collect()
    }
}

fn parse<T: FromStr>(flag: &str, word: &str) -> Result<T, Error> {
    let refuse = |_| format!("`{word}` is no value for {flag}").into();
    word.parse().map_err(refuse)
}

/// The error for a word that no command knows.
pub(crate) fn unknown(word: &str) -> Error {
    format!("`{word}`?\n{USAGE}").into()
}

/// Refuses names that no engine has.
pub(crate) fn check_engines(all: &[Entry], names: &[String]) -> Result<(), Error> {
    let is_unknown = |name: &&String| all.iter().all(|entry| entry.name != **name);
    match names.iter().find(is_unknown) {
        Some(name) => Err(format!("no engine `{name}`, see `arena list`").into()),
        None => Ok(()),
    }
}

/// Prints scenes, suites, engines and settings.
pub(crate) fn list(mut arguments: Arguments) -> Result<(), Error> {
    if let Some(word) = arguments.word() {
        return Err(unknown(&word));
    }
    println!("scenes (name:size)");
    for (name, size, default, _) in scene::LIBRARY {
        println!("  {name:<15} {size}, {default} unless given");
    }
    println!("suites");
    println!("  quick  {}", suites::QUICK.join(" "));
    println!("  full   {}", suites::FULL.join(" "));
    println!("  joints {}", suites::JOINTS.join(" "));
    println!("engines");
    for entry in registry() {
        let names: Vec<_> = entry.settings.iter().map(|s| s.name.as_str()).collect();
        let (name, knob, default) = (entry.name, entry.knob, &entry.default);
        println!(
            "  {name:<15} {knob}: {}; ships with {default}",
            names.join(" ")
        );
    }
    Ok(())
}
