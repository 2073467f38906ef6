//! Eight contacts at a time: the library's lanes against `fearless_simd` and `pulp`, by instructions, time and bits.
//!
//! `cargo run --release --bin simd` prints a table. One text, [`kernel::sweep`], does what the inner loop of the solver does (look up
//! two bodies in each lane, a normal and two friction rows, write the bodies back); below it stand the operations of each.
//! Instructions are counted by callgrind, which knows no AVX-512. Bits are those of the bodies after the sweeps.

mod kernel;
mod others;
mod ours;

use bevy_cleave::testing::simd::LaneWidth;
use fearless_simd::Level;
use kernel::Scene;
use pulp::x86::V3;
use std::process::ExitCode;
use weigh::{Error, count, cpu_us};

/// Sweeps of a measurement; of one under callgrind a twentieth.
const SWEEPS: usize = 200;

/// One who sweeps.
enum Who {
    Ours(LaneWidth),
    Fearless(fn() -> Option<Level>),
    PulpAvx2,
    PulpScalar,
}

const ALL: [(&str, Who); 9] = [
    ("ours, widest", Who::Ours(LaneWidth::Widest)),
    ("ours, four lanes", Who::Ours(LaneWidth::Four)),
    ("ours, one lane", Who::Ours(LaneWidth::One)),
    (
        "fearless_simd, widest",
        Who::Fearless(|| Some(Level::new())),
    ),
    (
        "fearless_simd, AVX2",
        Who::Fearless(|| Some(Level::Avx2(Level::new().as_avx2()?))),
    ),
    (
        "fearless_simd, SSE2",
        Who::Fearless(|| Some(Level::Sse2(Level::new().as_sse2()?))),
    ),
    (
        "fearless_simd, plain",
        Who::Fearless(|| Some(Level::fallback())),
    ),
    ("pulp, AVX2", Who::PulpAvx2),
    ("pulp, scalar", Who::PulpScalar),
];

impl Who {
    /// Some sweeps; `None` where the processor cannot.
    fn sweep(&self, scene: &mut Scene, count: usize) -> Option<()> {
        match self {
            Self::Ours(width) => counted_sweeps(count, || ours::sweep(scene, *width)),
            Self::Fearless(level) => {
                let level = level()?;
                counted_sweeps(count, || others::fearless(scene, level));
            }
            Self::PulpAvx2 => {
                let v3 = V3::try_new()?;
                counted_sweeps(count, || others::pulp_avx2(scene, v3));
            }
            Self::PulpScalar => counted_sweeps(count, || others::pulp_scalar(scene)),
        }
        Some(())
    }
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("simd: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), Error> {
    if let Some(word) = std::env::args().nth(1) {
        let (_, who) = &ALL[word.parse::<usize>()?];
        let done = who.sweep(&mut Scene::new(), SWEEPS / 20);
        return done.ok_or("not on this processor".into());
    }
    println!("| who | instructions a block | ns a block | bits |");
    println!("|---|---|---|---|");
    let blocks = Scene::new().blocks() as f64;
    let mut times = [f64::INFINITY; ALL.len()];
    let mut bits = [None; ALL.len()];
    for _ in 0..7 {
        for (number, (_, who)) in ALL.iter().enumerate() {
            let mut scene = Scene::new();
            let start = cpu_us();
            if who.sweep(&mut scene, SWEEPS).is_some() {
                times[number] = times[number].min(cpu_us() - start);
                bits[number] = Some(scene.hash());
            }
        }
    }
    let program = std::env::current_exe()?;
    for (number, (name, _)) in ALL.iter().enumerate() {
        let Some(hash) = bits[number] else {
            println!("| {name} | | | not on this processor |");
            continue;
        };
        let is_same = if Some(hash) == bits[0] {
            "the same"
        } else {
            "OTHER"
        };
        // Valgrind knows no AVX-512, so a processor that has it may be another one there.
        let instructions = match count(&program, &[&number.to_string()], "counted_sweeps") {
            Ok((_, total)) => format!("{:.0}", 20.0 * total / (SWEEPS as f64 * blocks)),
            Err(error) => error.to_string(),
        };
        let ns = 1e3 * times[number] / (SWEEPS as f64 * blocks);
        println!("| {name} | {instructions} | {ns:.1} | {is_same} |");
    }
    Ok(())
}

/// What is counted.
#[inline(never)]
fn counted_sweeps(count: usize, mut sweep: impl FnMut()) {
    (0..count).for_each(|_| sweep());
}
