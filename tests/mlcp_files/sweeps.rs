//! Iterative methods on problem files, in double precision, with the sweep of the run-time solver.

use super::{File, Problem};
use bevy_cleave::solver::exact::problem::Bounds;
use bevy_cleave::solver::pgs::{self, ContactRows};

/// A problem in constraint space: `w` is kept up to date with `lambda`.
#[derive(Clone)]
pub(crate) struct State<'a> {
    a: &'a [f64],
    n: usize,
    per_contact: usize,
    pub(crate) lambda: Vec<f64>,
    pub(crate) w: Vec<f64>,
    lo: Vec<f64>,
    hi: Vec<f64>,
}

struct Contact<'s, 'a, const T: usize> {
    state: &'s mut State<'a>,
    first: usize,
}

impl<const T: usize> ContactRows for Contact<'_, '_, T> {
    type Real = f64;
    const TANGENTS: usize = T;
    fn has_friction(&self) -> bool {
        let i = self.first + 1;
        self.state.hi[i] > self.state.lo[i]
    }
    fn impulse(&self, row: usize) -> f64 {
        self.state.lambda[self.first + row]
    }
    fn velocity(&self, row: usize) -> f64 {
        self.state.w[self.first + row]
    }
    fn effective_mass(&self, row: usize) -> f64 {
        let i = self.first + row;
        1.0 / self.state.a[i * self.state.n + i]
    }
    fn normal_wish(&self) -> f64 {
        self.impulse(0) - self.velocity(0) * self.effective_mass(0)
    }
    fn bounds(&self, row: usize) -> [f64; 2] {
        let i = self.first + row;
        [self.state.lo[i], self.state.hi[i]]
    }
    fn move_to(&mut self, row: usize, impulse: f64) -> f64 {
        let i = self.first + row;
        let change = impulse - self.state.lambda[i];
        self.state.lambda[i] = impulse;
        self.state.push(i, change);
        (change / self.effective_mass(row)).abs()
    }
}

impl<'a> State<'a> {
    pub(crate) fn new(file: &File, a: &'a [f64]) -> Self {
        let Bounds::Frozen { lo, hi } = file.reference.as_ref().unwrap().bounds.clone() else {
            unreachable!()
        };
        Self {
            a,
            n: file.b.len(),
            per_contact: file.rows_per_contact,
            lambda: vec![0.0; file.b.len()],
            w: file.b.iter().map(|b| -b).collect(),
            lo,
            hi,
        }
    }
    fn push(&mut self, i: usize, change: f64) {
        if change != 0.0 {
            let column = &self.a[i * self.n..(i + 1) * self.n];
            self.w
                .iter_mut()
                .zip(column)
                .for_each(|(w, a)| *w += a * change);
        }
    }
    pub(crate) fn set(&mut self, lambda: &[f64]) {
        for i in 0..self.n {
            let change = lambda[i] - self.lambda[i];
            self.lambda[i] = lambda[i];
            self.push(i, change);
        }
    }
    pub(crate) fn sweep(&mut self) {
        for first in (0..self.n).step_by(self.per_contact) {
            if self.per_contact == 3 {
                pgs::relax(
                    &mut Contact::<2> { state: self, first },
                    pgs::friction_in_box,
                );
            } else {
                pgs::relax(
                    &mut Contact::<1> { state: self, first },
                    pgs::friction_in_box,
                );
            }
        }
    }
    fn natural_map(&self) -> f64 {
        (0..self.n)
            .map(|i| {
                let a = self.a[i * self.n + i];
                let l = self.lambda[i];
                let r = l - (l - self.w[i] / a).max(self.lo[i]).min(self.hi[i]);
                r * r * a
            })
            .sum::<f64>()
            .sqrt()
    }
}

pub(crate) fn error(a: &[f64], lambda: &[f64], file: &File) -> f64 {
    let r = file.reference.as_ref().unwrap();
    let n = lambda.len();
    let d: Vec<f64> = lambda.iter().zip(&r.lambda).map(|(x, y)| x - y).collect();
    let mut q = 0.0;
    for i in 0..n {
        if d[i] != 0.0 {
            q += d[i]
                * a[i * n..(i + 1) * n]
                    .iter()
                    .zip(&d)
                    .map(|(a, d)| a * d)
                    .sum::<f64>();
        }
    }
    q.max(0.0).sqrt() / r.energy_norm
}

const KS: [usize; 7] = [8, 16, 32, 64, 128, 256, 512];

fn run_pgs(file: &File, a: &[f64], start: &[f64]) -> Vec<f64> {
    let mut s = State::new(file, a);
    s.set(start);
    let mut out = vec![];
    for k in 1..=512 {
        s.sweep();
        if KS.contains(&k) {
            out.push(error(a, &s.lambda, file));
        }
    }
    out
}

fn run_nncg(file: &File, a: &[f64], start: &[f64], safe: bool) -> Vec<f64> {
    let mut s = State::new(file, a);
    s.set(start);
    let n = s.n;
    let mut out = vec![];
    let mut best = (f64::INFINITY, s.lambda.clone());
    let mut p = vec![0.0; n];
    let mut g_old = 0.0;
    for k in 1..=512 {
        let old = s.lambda.clone();
        s.sweep();
        let r = s.natural_map();
        if r < best.0 || !safe {
            best = (r, s.lambda.clone());
        }
        if KS.contains(&k) {
            out.push(error(a, &best.1, file));
        }
        let g: Vec<f64> = old.iter().zip(&s.lambda).map(|(o, l)| o - l).collect();
        // in the metric of A's diagonal
        let g2: f64 = (0..n).map(|i| g[i] * g[i] * a[i * n + i]).sum();
        let beta = if k == 1 { 0.0 } else { g2 / g_old };
        g_old = g2;
        if k == 1 || beta > 1.0 || !beta.is_finite() {
            p.iter_mut().for_each(|p| *p = 0.0);
            if k == 1 {
                p = g.iter().map(|g| -g).collect();
            }
        } else {
            let next: Vec<f64> = s.lambda.iter().zip(&p).map(|(l, p)| l + beta * p).collect();
            for i in 0..n {
                p[i] = beta * p[i] - g[i];
            }
            s.set(&next);
        }
    }
    out
}

/// n sub-steps with `sweeps` each. mode 0: b/n; 1: force split where known. total: clip sums instead of shares.
fn run_sub(
    file: &File,
    a: &[f64],
    start: &[f64],
    sweeps: usize,
    force: bool,
    total: bool,
    carry: f64,
) -> Vec<f64> {
    let mut out = vec![];
    for k in KS {
        let n = k / sweeps;
        if n == 0 {
            out.push(1.0);
            continue;
        }
        let mut s = State::new(file, a);
        let rows = s.n;
        // velocities at the start and what each sub-step adds
        let mut first = vec![0.0; rows];
        if let (true, Some(before), Problem::Bodies(p)) =
            (force, &file.velocity_before, &file.problem)
        {
            let mut q = p.clone();
            for (b, v) in q.bodies.iter_mut().zip(before) {
                b.velocity = *v;
            }
            first = q.free_velocities();
        }
        let each: Vec<f64> =
            s.w.iter()
                .zip(&first)
                .map(|(w, f)| (w - f) / n as f64)
                .collect();
        s.w.copy_from_slice(&first);
        let share = 1.0 / n as f64;
        let (lo, hi) = (s.lo.clone(), s.hi.clone());
        if !total {
            s.lo.iter_mut().for_each(|x| *x *= share);
            s.hi.iter_mut().for_each(|x| *x *= share);
        }
        let mut sum = vec![0.0; rows];
        let mut warm: Vec<f64> = start.iter().map(|l| l * share).collect();
        for _ in 0..n {
            for (w, e) in s.w.iter_mut().zip(&each) {
                *w += e;
            }
            if total {
                let before = s.lambda.clone();
                let next: Vec<f64> = (0..rows)
                    .map(|i| (s.lambda[i] + carry * warm[i]).max(lo[i]).min(hi[i]))
                    .collect();
                s.set(&next);
                for _ in 0..sweeps {
                    s.sweep();
                }
                warm = s.lambda.iter().zip(&before).map(|(l, b)| l - b).collect();
                sum = s.lambda.clone();
            } else {
                s.lambda.fill(0.0);
                let next: Vec<f64> = (0..rows)
                    .map(|i| (carry * warm[i]).max(s.lo[i]).min(s.hi[i]))
                    .collect();
                s.set(&next);
                for _ in 0..sweeps {
                    s.sweep();
                }
                warm = s.lambda.clone();
                for i in 0..rows {
                    sum[i] += s.lambda[i];
                }
            }
        }
        out.push(error(a, &sum, file));
    }
    out
}

pub(crate) fn explore(files: &[File]) {
    let mats: Vec<Vec<f64>> = files.iter().map(|f| f.problem.matrix()).collect();
    for warm in [false, true] {
        let set: Vec<usize> = (0..files.len())
            .filter(|&i| !warm || files[i].reference.as_ref().unwrap().warm.is_some())
            .collect();
        let start = |i: usize| {
            if warm {
                files[i].reference.as_ref().unwrap().warm.clone().unwrap()
            } else {
                vec![0.0; files[i].b.len()]
            }
        };
        let methods: Vec<(&str, Box<dyn Fn(usize) -> Vec<f64>>)> = vec![
            ("pgs", Box::new(|i| run_pgs(&files[i], &mats[i], &start(i)))),
            (
                "nncg",
                Box::new(|i| run_nncg(&files[i], &mats[i], &start(i), false)),
            ),
            (
                "nncg safe",
                Box::new(|i| run_nncg(&files[i], &mats[i], &start(i), true)),
            ),
            (
                "sub 1",
                Box::new(|i| run_sub(&files[i], &mats[i], &start(i), 1, false, false, 1.0)),
            ),
            (
                "sub 2",
                Box::new(|i| run_sub(&files[i], &mats[i], &start(i), 2, false, false, 1.0)),
            ),
            (
                "sub 4",
                Box::new(|i| run_sub(&files[i], &mats[i], &start(i), 4, false, false, 1.0)),
            ),
            (
                "sub 1 force",
                Box::new(|i| run_sub(&files[i], &mats[i], &start(i), 1, true, false, 1.0)),
            ),
            (
                "sub 2 force",
                Box::new(|i| run_sub(&files[i], &mats[i], &start(i), 2, true, false, 1.0)),
            ),
            (
                "sub 1 total",
                Box::new(|i| run_sub(&files[i], &mats[i], &start(i), 1, false, true, 1.0)),
            ),
            (
                "sub 2 total",
                Box::new(|i| run_sub(&files[i], &mats[i], &start(i), 2, false, true, 1.0)),
            ),
            (
                "sub 1 total force",
                Box::new(|i| run_sub(&files[i], &mats[i], &start(i), 1, true, true, 1.0)),
            ),
            (
                "sub 1 carry .9",
                Box::new(|i| run_sub(&files[i], &mats[i], &start(i), 1, false, false, 0.9)),
            ),
        ];
        println!("warm {warm}, {} files; share in % at K = {KS:?}", set.len());
        for (name, run) in methods {
            let errors: Vec<Vec<f64>> = set.iter().map(|&i| run(i)).collect();
            for level in [1e-1, 1e-2, 1e-3] {
                let shares: Vec<String> = (0..KS.len())
                    .map(|k| {
                        format!(
                            "{:3.0}",
                            100.0 * errors.iter().filter(|e| e[k] <= level).count() as f64
                                / set.len() as f64
                        )
                    })
                    .collect();
                println!("{name:20} {level:.0e} {}", shares.join(" "));
            }
        }
    }
}
