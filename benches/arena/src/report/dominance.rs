//! How much faster we are than each point of each peer, at an error no larger.

use crate::job::quantile;
use crate::table::{Row, Table};

/// Our engines.
pub(crate) const OURS: [&str; 2] = ["cleave", "cleave-plugin"];

/// Errors below it count as equal: f32 positions of some metres are rounded to that.
pub(crate) const ROUNDING: f64 = 1e-6;

/// The peer that is a plugin of an app itself.
const PLUGIN: &str = "avian";

/// Where the engines that are no plugins are stepped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Footing {
    /// By themselves, as they are measured.
    Alone,
    /// In an app: what an update of one without physics takes is added to their time.
    InApp,
}

/// A peer's point and what we have against it.
#[derive(Clone, Debug)]
pub(crate) struct Duel<'a> {
    pub(crate) peer: &'a Row,
    /// Our cheapest point that stands with an error no larger; none if there is none.
    pub(crate) ours: Option<&'a Row>,
    /// What an app would add to the peer's time, ms.
    pub(crate) app: f64,
}

impl Duel<'_> {
    /// The peer's time over ours; 0 if we have no point with as small an error.
    pub(crate) fn ratio(&self) -> f64 {
        self.ours.map_or(0.0, |ours| self.cost() / ours.cost())
    }

    /// The peer's time, ms.
    pub(crate) fn cost(&self) -> f64 {
        self.peer.cost() + self.app
    }
}

/// All duels of one of our engines in one scene, or in all.
#[derive(Clone, Debug, Default)]
pub(crate) struct Duels<'a>(pub(crate) Vec<Duel<'a>>);

impl<'a> Duels<'a> {
    /// One of our engines against all points of other engines that stand, on `threads` threads.
    pub(crate) fn new(
        table: &'a Table,
        ours: &str,
        threads: usize,
        scene: &str,
        footing: Footing,
    ) -> Self {
        let here = |row: &&Row| row.scene == scene && row.threads == threads && row.stands();
        let rows: Vec<&Row> = table.rows.iter().filter(here).collect();
        let mine: Vec<&Row> = rows.iter().copied().filter(|r| r.engine == ours).collect();
        let peers = rows
            .into_iter()
            .filter(|r| !OURS.contains(&r.engine.as_str()));
        let app = match footing {
            Footing::Alone => 0.0,
            Footing::InApp => table.bare_cost(scene, threads).unwrap_or(0.0),
        };
        let duel = |peer: &'a Row| Duel {
            peer,
            ours: cheapest(&mine, peer),
            app: if peer.engine == PLUGIN { 0.0 } else { app },
        };
        Self(peers.map(duel).collect())
    }

    fn ratios(&self) -> Vec<f64> {
        self.0.iter().map(Duel::ratio).collect()
    }

    /// Least ratio. Not a number if no peer stands.
    pub(crate) fn worst(&self) -> f64 {
        quantile(&self.ratios(), 0.0)
    }

    pub(crate) fn median(&self) -> f64 {
        quantile(&self.ratios(), 0.5)
    }

    /// The duel with the least ratio.
    pub(crate) fn hardest(&self) -> Option<&Duel<'a>> {
        self.0.iter().min_by(|a, b| a.ratio().total_cmp(&b.ratio()))
    }

    /// Peer points at which we are at least as fast.
    pub(crate) fn won(&self) -> usize {
        self.0.iter().filter(|duel| duel.ratio() >= 1.0).count()
    }

    /// Peer points whose error we do not reach.
    pub(crate) fn not_reached(&self) -> impl Iterator<Item = &Row> {
        self.0.iter().filter(|d| d.ours.is_none()).map(|d| d.peer)
    }
}

fn cheapest<'a>(mine: &[&'a Row], peer: &Row) -> Option<&'a Row> {
    let bound = peer.err.max(ROUNDING);
    let as_good = mine.iter().copied().filter(|r| r.err <= bound);
    as_good.min_by(|a, b| a.cost().total_cmp(&b.cost()))
}

/// Over all scenes: what one of our engines reaches on one number of threads.
#[derive(Clone, Debug)]
pub(crate) struct Overall<'a> {
    pub(crate) engine: &'static str,
    pub(crate) threads: usize,
    footing: Footing,
    /// By scene, in the order of the table; scenes in which no peer stands are left out.
    pub(crate) scenes: Vec<(String, Duels<'a>)>,
}

impl<'a> Overall<'a> {
    fn new(table: &'a Table, engine: &'static str, threads: usize, footing: Footing) -> Self {
        let scenes = table.distinct(|row| row.scene.clone()).into_iter();
        let duels = scenes.map(|scene| {
            let duels = Duels::new(table, engine, threads, &scene, footing);
            (scene, duels)
        });
        Self {
            engine,
            threads,
            footing,
            scenes: duels.filter(|(_, duels)| !duels.0.is_empty()).collect(),
        }
    }

    /// What it is about.
    pub(crate) fn title(&self) -> String {
        match self.footing {
            Footing::Alone => self.engine.into(),
            Footing::InApp => format!("{}, others in an app too", self.engine),
        }
    }

    /// All duels of all scenes.
    pub(crate) fn all(&self) -> Duels<'a> {
        let duels = self
            .scenes
            .iter()
            .flat_map(|(_, duels)| duels.0.iter().cloned());
        Duels(duels.collect())
    }

    /// Median over the scenes of the least ratio in each.
    pub(crate) fn median_of_worst(&self) -> f64 {
        let worst: Vec<f64> = self.scenes.iter().map(|(_, duels)| duels.worst()).collect();
        quantile(&worst, 0.5)
    }
}

/// For each of our engines in the table and each number of threads.
pub(crate) fn overall(table: &Table) -> Vec<Overall<'_>> {
    let (engines, threads) = (
        table.distinct(|r| r.engine.clone()),
        table.distinct(|r| r.threads),
    );
    let here = OURS.iter().filter(|o| engines.iter().any(|e| e == *o));
    let alone = here.map(|&engine| (engine, Footing::Alone));
    let in_app = (!table.bare.is_empty()).then_some(("cleave-plugin", Footing::InApp));
    let lines = alone.chain(in_app);
    let pairs = lines.flat_map(|line| threads.iter().map(move |&t| (line, t)));
    let all = pairs.map(|((engine, footing), t)| Overall::new(table, engine, t, footing));
    all.filter(|o| !o.scenes.is_empty()).collect()
}

/// The figures over all scenes and the hardest duel of each scene, as plain text.
pub(crate) fn summary(table: &Table) -> String {
    let mut text = String::new();
    for overall in overall(table) {
        let (all, threads) = (overall.all(), overall.threads);
        text += &format!(
            "{} on {threads} thread(s): dominance_worst {:.3}, dominance_median {:.3}, median of worst {:.3}, won {}, \
             not reached {} of {}\n",
            overall.title(),
            all.worst(),
            all.median(),
            overall.median_of_worst(),
            all.won(),
            all.not_reached().count(),
            all.0.len()
        );
        for (scene, duels) in &overall.scenes {
            text += &format!(
                "  {scene:<14} worst {:.3}, median {:.3}",
                duels.worst(),
                duels.median()
            );
            text += &duels.hardest().map_or(String::new(), hardest);
        }
    }
    text
}

fn hardest(duel: &Duel<'_>) -> String {
    let Duel { peer, ours, .. } = duel;
    let (engine, setting) = (&peer.engine, &peer.setting);
    let them = format!(
        "{engine} {setting}: {:.4} ms, {:.2e}",
        duel.cost(),
        peer.err
    );
    match ours {
        Some(ours) => format!(
            "; {them}; ours {}: {:.4} ms, {:.2e}\n",
            ours.setting,
            ours.cost(),
            ours.err
        ),
        None => format!("; {them}; not reached\n"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(engine: &str, setting: &str, cpu: f64, err: f64) -> Row {
        Row {
            scene: "tower:10".into(),
            engine: engine.into(),
            setting: setting.into(),
            threads: 1,
            cpu,
            err,
            ..Row::default()
        }
    }

    fn ratios(rows: Vec<Row>) -> Vec<f64> {
        let table = Table {
            rows,
            ..Table::default()
        };
        Duels::new(&table, "cleave", 1, "tower:10", Footing::Alone).ratios()
    }

    #[test]
    fn a_peer_meets_our_cheapest_point_that_is_as_good() {
        let ours = [
            row("cleave", "a", 1.0, 0.1),
            row("cleave", "b", 2.0, 0.01),
            row("cleave", "c", 4.0, 0.001),
        ];
        let with = |peer| ratios(ours.iter().cloned().chain([peer]).collect());
        assert_eq!(with(row("rapier", "4", 3.0, 0.1)), [3.0]);
        assert_eq!(with(row("rapier", "4", 3.0, 0.05)), [1.5]);
        assert_eq!(with(row("rapier", "4", 3.0, 1e-4)), [0.0]);
        assert_eq!(with(row("cleave-plugin", "a", 3.0, 0.1)), [] as [f64; 0]);
    }

    #[test]
    fn errors_at_the_rounding_floor_count_as_equal() {
        let rows = vec![row("cleave", "a", 1.0, 9e-7), row("rapier", "4", 2.0, 0.0)];
        assert_eq!(ratios(rows), [2.0]);
    }

    #[test]
    fn an_app_is_added_to_the_time_of_engines_that_have_none() {
        let rows = vec![
            row("cleave-plugin", "a", 2.0, 0.1),
            row("rapier", "4", 1.0, 0.1),
            row("avian", "4", 1.0, 0.1),
        ];
        let table = Table {
            rows,
            bare: vec![row("bare-app", "default", 1.5, f64::INFINITY)],
            ..Table::default()
        };
        let ratios = |footing| Duels::new(&table, "cleave-plugin", 1, "tower:10", footing).ratios();
        assert_eq!(ratios(Footing::Alone), [0.5, 0.5]);
        assert_eq!(ratios(Footing::InApp), [1.25, 0.5]);
    }

    #[test]
    fn points_that_fell_do_not_count() {
        let fallen = |engine| Row {
            fallen: 1,
            ..row(engine, "a", 1.0, 0.1)
        };
        assert_eq!(
            ratios(vec![row("cleave", "a", 1.0, 0.1), fallen("rapier")]),
            [] as [f64; 0]
        );
        assert_eq!(
            ratios(vec![fallen("cleave"), row("rapier", "4", 1.0, 0.1)]),
            [0.0]
        );
    }
}
