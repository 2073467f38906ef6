//! Time per slice into two closed, unconverged halves: this crate beside others, on the same meshes and planes.
//!
//! Criterion times each engine alone. The table at the end is what the report has: all engines of a body take turns within
//! a round, and the medians over the rounds are printed, so that on a machine that others use too the ratios hold. All
//! times are CPU times of the thread.

use criterion::measurement::{Measurement, ValueFormatter, WallTime};
use criterion::{BenchmarkId, Criterion, Throughput};
use slicers::bodies::{Body, bodies};
use slicers::engines::{REFERENCE, engines};
use std::time::Duration;

/// Rounds, of which the medians are taken.
const ROUNDS: usize = 11;

/// CPU time of the thread.
fn cpu_time() -> Duration {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the pointer is to a timespec that lives through the call.
    unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) };
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

/// For criterion, which measures wall time otherwise.
struct CpuTime;

impl Measurement for CpuTime {
    type Intermediate = Duration;
    type Value = Duration;

    fn start(&self) -> Duration {
        cpu_time()
    }

    fn end(&self, start: Duration) -> Duration {
        cpu_time() - start
    }

    fn add(&self, a: &Duration, b: &Duration) -> Duration {
        *a + *b
    }

    fn zero(&self) -> Duration {
        Duration::ZERO
    }

    fn to_f64(&self, value: &Duration) -> f64 {
        value.as_nanos() as f64
    }

    fn formatter(&self) -> &dyn ValueFormatter {
        WallTime.formatter()
    }
}

fn bench(criterion: &mut Criterion<CpuTime>, body: &Body) {
    let mut group = criterion.benchmark_group(body.name);
    group.throughput(Throughput::Elements(body.mesh.triangles().len() as u64));
    for mut engine in engines(body) {
        let mut planes = body.planes.iter().cycle();
        group.bench_function(BenchmarkId::from_parameter(engine.name), |bencher| {
            bencher.iter(|| planes.next().is_some_and(&mut engine.slice));
        });
    }
}

/// Prints a row for each engine.
fn compare(body: &Body) {
    let mut engines = engines(body);
    let mut times = vec![Vec::new(); engines.len()];
    let mut cuts = vec![0; engines.len()];
    // The first round fills memory and caches.
    for round in 0..=ROUNDS {
        for (index, engine) in engines.iter_mut().enumerate() {
            let start = cpu_time();
            cuts[index] = body.planes.iter().filter(|plane| (engine.slice)(plane)).count();
            if round > 0 {
                times[index].push((cpu_time() - start).div_f64(body.planes.len() as f64));
            }
        }
    }
    let medians: Vec<Duration> = times.iter_mut().map(|times| median(times)).collect();
    let reference = engines.iter().position(|engine| engine.name == REFERENCE).expect("the reference");
    for (index, engine) in engines.iter().enumerate() {
        let time = medians[index].as_secs_f64();
        let ratio = medians[reference].as_secs_f64() / time;
        let (shape, name, of) = (body.name, engine.name, body.planes.len());
        println!("| {shape} | {name} | {:.2} | {ratio:.2} | {} of {of} |", 1e6 * time, cuts[index]);
    }
}

fn median(times: &mut [Duration]) -> Duration {
    times.sort_unstable();
    times[times.len() / 2]
}

fn main() {
    let bodies = bodies();
    let mut criterion = Criterion::default()
        .with_measurement(CpuTime)
        .sample_size(10)
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_millis(800))
        .configure_from_args();
    bodies.iter().for_each(|body| bench(&mut criterion, body));
    criterion.final_summary();
    println!("| body | slicer | us per slice | parry's time over it | halves made |\n|---|---|---|---|---|");
    bodies.iter().for_each(compare);
}
