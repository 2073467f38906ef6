//! How many scenes of each family broke each law, and what that cost.

use super::laws::{Breach, Law};
use std::fmt::Write;

/// What a scene was judged to do.
#[derive(Clone, Debug)]
pub(crate) struct Verdict {
    pub(crate) family: &'static str,
    pub(crate) seed: u64,
    pub(crate) breaches: Vec<Breach>,
    /// Processor time, ms.
    pub(crate) cost: f64,
}

/// Verdicts of one family.
#[derive(Clone, Debug, Default)]
pub(crate) struct Row {
    pub(crate) scenes: usize,
    /// Seeds of the scenes that broke a law.
    pub(crate) failing: Vec<u64>,
    /// By law in the order of [`Law::ALL`].
    by_law: [usize; Law::ALL.len()],
    /// ms.
    cost: f64,
}

/// Rows by family, in the order in which families came.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tally(pub(crate) Vec<(&'static str, Row)>);

impl Tally {
    pub(crate) fn note(&mut self, verdict: &Verdict) {
        let row = match self.0.iter().position(|(name, _)| *name == verdict.family) {
            Some(known) => &mut self.0[known].1,
            None => {
                self.0.push((verdict.family, Row::default()));
                &mut self.0.last_mut().expect("just pushed").1
            }
        };
        row.scenes += 1;
        row.cost += verdict.cost;
        if !verdict.breaches.is_empty() {
            row.failing.push(verdict.seed);
        }
        for breach in &verdict.breaches {
            let law = Law::ALL.iter().position(|(law, _)| *law == breach.law);
            row.by_law[law.expect("all are listed")] += 1;
        }
    }

    /// A table in Markdown: how many scenes, which share broke a law, and which broke each.
    pub(crate) fn table(&self) -> String {
        let mut text = String::from("| family | scenes | broke a law |");
        Law::ALL
            .iter()
            .for_each(|(_, name)| write!(text, " {name} |").expect("fits"));
        text.push_str(" ms a scene |\n|---|---|---|");
        text.push_str(&"---|".repeat(Law::ALL.len() + 1));
        let mut all = Row::default();
        for (family, row) in &self.0 {
            write_row(&mut text, family, row);
            all.scenes += row.scenes;
            all.cost += row.cost;
            all.failing.extend(&row.failing);
            all.by_law
                .iter_mut()
                .zip(row.by_law)
                .for_each(|(all, row)| *all += row);
        }
        write_row(&mut text, "all", &all);
        text
    }
}

fn write_row(text: &mut String, family: &str, row: &Row) {
    let scenes = row.scenes.max(1) as f64;
    let share = |count: usize| 100.0 * count as f64 / scenes;
    let failing = share(row.failing.len());
    write!(text, "\n| {family} | {} | {failing:.1} % |", row.scenes).expect("fits");
    for count in row.by_law {
        match count {
            0 => text.push_str(" |"),
            _ => write!(text, " {:.1} |", share(count)).expect("fits"),
        }
    }
    write!(text, " {:.0} |", row.cost / scenes).expect("fits");
}
