//! `arena heaps`: random heaps of the library's judge through all engines: which share breaks a law, what a scene costs, and how
//! soon all sleep.
//!
//! Every engine is judged by the laws of the judge, from its poses and velocities. Each makes its steps in a run of its own for laws and sleep, and
//! in one without sleep; runs of a scene follow each other, so that all engines see the same machine.

use crate::Error;
use crate::cli::{self, Arguments, check_engines};
use crate::engine::{Engine, Entry, Settings, State, registry};
use crate::job::{cpu_ms, quantile};
use crate::judge::generate;
use crate::judge::laws::Law;
use crate::judge::run::Run;
use crate::judge::scene::{Role, Scene as Drawn};
use crate::judge::watch::Watches;
use crate::scene::drawn::{self, Heap};
use bevy_cleave::math::Pose;

/// What falls and comes to rest on a floor that stays where it is.
const FAMILIES: &str =
    "boxes,hulls,round,plates,rods,needles,wedges,sizes,masses,broken,stacks,towers,decks";

/// Sizes of bodies in a game, m, and its gravity, m/s2; drawn scenes are of 1 mm to 100 m.
const GAME: ([f32; 2], f32) = ([0.05, 5.0], 9.81);

struct Options {
    scenes: u64,
    seed: u64,
    families: Vec<String>,
    engines: Vec<String>,
    /// Whether scenes of other sizes than a game's are left out.
    is_game: bool,
}

/// What an engine did with a scene.
struct Outcome {
    broken: Vec<Law>,
    /// Step from which on all slept until the end.
    asleep: Option<usize>,
    /// CPU time of all steps with sleep and without, ms.
    cost: [f64; 2],
}

pub(crate) fn run(arguments: Arguments) -> Result<(), Error> {
    let options = Options::read(arguments)?;
    let all = registry();
    check_engines(&all, &options.engines)?;
    let entries: Vec<&Entry> = (options.engines.iter())
        .filter_map(|name| all.iter().find(|entry| entry.name == name))
        .collect();
    println!("{}", head(&entries));
    let mut total: Vec<Vec<Outcome>> = entries.iter().map(|_| Vec::new()).collect();
    for family in &options.families {
        let mut outcomes: Vec<Vec<Outcome>> = entries.iter().map(|_| Vec::new()).collect();
        for scene in scenes(&options, family)? {
            for (entry, outcomes) in entries.iter().zip(&mut outcomes) {
                outcomes.push(outcome(entry, &scene));
            }
        }
        println!("{}", row(family, &outcomes));
        for (total, outcomes) in total.iter_mut().zip(outcomes) {
            total.extend(outcomes);
        }
    }
    println!("{}", row("all", &total));
    Ok(())
}

impl Options {
    fn read(mut arguments: Arguments) -> Result<Self, Error> {
        let list = |names: &str| names.split(',').map(String::from).collect();
        let mut options = Self {
            scenes: 20,
            seed: 0,
            families: list(FAMILIES),
            engines: list("cleave,rapier,box3d"),
            is_game: false,
        };
        while let Some(word) = arguments.word() {
            match word.as_str() {
                "--scenes" => options.scenes = arguments.value(&word)?,
                "--seed" => options.seed = arguments.value(&word)?,
                "--families" => options.families = arguments.list(&word)?,
                "--engines" => options.engines = arguments.list(&word)?,
                "--game" => options.is_game = true,
                _ => return Err(cli::unknown(&word)),
            }
        }
        Ok(options)
    }
}

/// The scenes of a family that all engines can be given.
fn scenes(options: &Options, family: &str) -> Result<Vec<Drawn>, Error> {
    let mut scenes = Vec::new();
    let mut seed = options.seed;
    while (scenes.len() as u64) < options.scenes {
        let drawn = generate::scene(family, seed).ok_or(format!("no family `{family}`"))?;
        seed += 1;
        if options.is_game && !is_of_a_game(&drawn) {
            continue;
        }
        let Some(scene) = drawn::with_boxes(&drawn.version(Role::Here)) else {
            return Err(format!("`{family}` has floors that move or several materials").into());
        };
        scenes.push(scene);
    }
    Ok(scenes)
}

fn is_of_a_game(scene: &Drawn) -> bool {
    let ([least, most], gravity) = GAME;
    let mut dynamic = scene.actors.iter().filter(|actor| actor.is_dynamic());
    (scene.gravity.length() - gravity).abs() < 1e-3
        && dynamic.all(|actor| (least..most).contains(&(2.0 * actor.form.radius())))
}

fn outcome(entry: &Entry, drawn: &Drawn) -> Outcome {
    let heap = drawn::heap(drawn);
    let (broken, asleep, with_sleep) = judge(entry, drawn, &heap);
    let mut engine = build(entry, &heap, false);
    let steps = 0..heap.scene.steps;
    let without = steps.map(|_| timed(engine.as_mut())).sum();
    Outcome {
        broken,
        asleep,
        cost: [with_sleep, without],
    }
}

fn build(entry: &Entry, heap: &Heap, sleeping: bool) -> Box<dyn Engine> {
    let mut settings = entry.settings.iter();
    let setting = settings.find(|setting| setting.name == entry.default);
    let settings = Settings {
        value: setting.expect("each engine has its default").value,
        threads: 1,
        sleeping,
    };
    (entry.build)(&heap.scene, &settings)
}

fn timed(engine: &mut dyn Engine) -> f64 {
    let begun = cpu_ms();
    engine.step();
    cpu_ms() - begun
}

/// Laws that the engine breaks, since when all sleep, and CPU time of all steps, ms.
fn judge(entry: &Entry, drawn: &Drawn, heap: &Heap) -> (Vec<Law>, Option<usize>, f64) {
    let mut engine = build(entry, heap, true);
    // Never steps: it shows the judge where the engine has its bodies.
    let mut run = Run::new(drawn, false).expect("usable bodies");
    run.weigh();
    let mut watches = Watches::new(&run);
    let (mut states, mut asleep, mut cost) = (Vec::new(), None, 0.0);
    for step in 1..=drawn.steps {
        cost += timed(engine.as_mut());
        states.clear();
        engine.read(&mut states);
        if !show(&mut run, heap, &states) {
            return (vec![Law::Finite], None, cost);
        }
        watches.look(&run, step);
        match engine.num_awake() {
            Some(0) => asleep = asleep.or(Some(step as usize)),
            _ => asleep = None,
        }
    }
    let mut broken: Vec<Law> = watches
        .breaches(&run)
        .into_iter()
        .flatten()
        .map(|breach| breach.law)
        .filter(|&law| law != Law::Sleep && drawn.has(law))
        .collect();
    if asleep.is_none() && engine.num_awake().is_some() && drawn.has(Law::Sleep) {
        broken.push(Law::Sleep);
    }
    (broken, asleep, cost)
}

/// Puts bodies where the engine has them; whether it has them somewhere.
fn show(run: &mut Run<'_>, heap: &Heap, states: &[State]) -> bool {
    let bodies = &mut run.simulation.bodies;
    let placed = run.slots.iter().zip(&heap.centers).zip(states);
    let mut placed = placed.map(|((&slot, &center), state)| {
        let rotation = state.rot.normalize();
        let pose = Pose::new(state.pos - rotation * center, rotation);
        bodies.set_pose(slot, pose)?;
        bodies.set_velocity(slot, state.linvel, state.angvel)
    });
    placed.all(|placed| placed.is_ok())
}

fn head(entries: &[&Entry]) -> String {
    let mut text = String::from("| family | scenes |");
    let mut rule = String::from("|---|---|");
    for entry in entries {
        text += &format!(
            " {0} breaks a law | {0} ms, sleep on | {0} ms, off | {0} steps to sleep |",
            entry.name
        );
        rule += "---|---|---|---|";
    }
    text + "\n" + &rule
}

/// Share that breaks a law (and which), mean CPU time of a scene with sleep and without, median number of steps until all sleep.
fn row(family: &str, outcomes: &[Vec<Outcome>]) -> String {
    let scenes = outcomes.first().map_or(0, Vec::len);
    let mut text = format!("| {family} | {scenes} |");
    for outcomes in outcomes {
        let share = |count: usize| 100.0 * count as f64 / scenes as f64;
        let broken = outcomes.iter().filter(|o| !o.broken.is_empty()).count();
        let by_law = Law::ALL.iter().filter_map(|&(law, name)| {
            let count = outcomes.iter().filter(|o| o.broken.contains(&law)).count();
            (count > 0).then(|| format!("{name} {:.0}", share(count)))
        });
        let by_law = by_law.collect::<Vec<_>>().join(", ");
        let mean = |i: usize| outcomes.iter().map(|o| o.cost[i]).sum::<f64>() / scenes as f64;
        let steps: Vec<f64> = outcomes
            .iter()
            .map(|o| o.asleep.map_or(f64::INFINITY, |step| step as f64))
            .collect();
        text += &format!(
            " {:.0} % ({by_law}) | {:.1} | {:.1} | {:.0} |",
            share(broken),
            mean(0),
            mean(1),
            quantile(&steps, 0.5)
        );
    }
    text
}
