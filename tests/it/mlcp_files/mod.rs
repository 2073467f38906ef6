//! Contact problems from files, with their certified solutions; the format is described beside the files.
#![allow(
    dead_code,
    reason = "each program that includes this uses a part of it"
)]

pub(crate) mod sweeps;

use bevy_cleave::testing::exact;
use bevy_cleave::testing::exact::{
    Body, Bounds, Certificate, Contact, ContactProblem, DenseProblem, ExactScratch,
};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The problem of a file: with its bodies where the file has them, else as a matrix.
#[derive(Clone)]
pub(crate) enum Problem {
    Bodies(ContactProblem),
    Dense(DenseProblem),
}

/// The stored solution of the problem with frozen friction bounds.
pub(crate) struct Reference {
    pub(crate) lambda: Vec<f64>,
    pub(crate) w: Vec<f64>,
    /// Mass norm of the velocity change that the contacts make.
    pub(crate) energy_norm: f64,
    pub(crate) bounds: Bounds,
    /// Solution of a step before.
    pub(crate) warm: Option<Vec<f64>>,
}

pub(crate) struct File {
    pub(crate) name: String,
    pub(crate) rows_per_contact: usize,
    pub(crate) friction: Vec<f64>,
    pub(crate) b: Vec<f64>,
    pub(crate) problem: Problem,
    /// Velocities of the bodies before forces acted, where known.
    pub(crate) velocity_before: Option<Vec<[f64; 6]>>,
    /// `None` for a problem without solution.
    pub(crate) reference: Option<Reference>,
}

impl Problem {
    pub(crate) fn w(&self, lambda: &[f64]) -> Vec<f64> {
        match self {
            Self::Bodies(p) => p.w(lambda),
            Self::Dense(p) => p.w(lambda),
        }
    }

    /// `A` row by row.
    pub(crate) fn matrix(&self) -> Vec<f64> {
        match self {
            Self::Bodies(p) => p.to_dense().a,
            Self::Dense(p) => p.a.clone(),
        }
    }

    /// Solves with the exact method from `lambda`.
    pub(crate) fn solve(&self, lambda: &mut [f64], scratch: &mut ExactScratch) -> Certificate {
        match self {
            Self::Bodies(p) => exact::solve_bodies(p, lambda, scratch),
            Self::Dense(p) => exact::solve_dense(p, lambda, scratch),
        }
    }

    /// For each row the sum of the absolute terms that the effect of `lambda` on it is added up from: what rounding is
    /// relative to.
    pub(crate) fn magnitude(&self, lambda: &[f64]) -> Vec<f64> {
        let absolute: Vec<f64> = lambda.iter().map(|l| l.abs()).collect();
        match self.clone() {
            Self::Bodies(mut p) => {
                for body in &mut p.bodies {
                    body.inverse_inertia = body.inverse_inertia.map(|row| row.map(f64::abs));
                    body.velocity = [0.0; 6];
                }
                for contact in &mut p.contacts {
                    contact.jacobian = contact.jacobian.map(|row| row.map(|j| j.map(f64::abs)));
                    contact.target_velocity = [0.0; 3];
                }
                p.w(&absolute)
            }
            Self::Dense(mut p) => {
                p.a.iter_mut().for_each(|a| *a = a.abs());
                p.b.fill(0.0);
                p.w(&absolute)
            }
        }
    }

    pub(crate) fn set_bounds(&mut self, bounds: Bounds) {
        match self {
            Self::Bodies(p) => p.bounds = bounds,
            Self::Dense(p) => p.bounds = bounds,
        }
    }
}

/// All files, sorted by name within each of the two sets.
pub(crate) fn load_all() -> Vec<File> {
    ["own", "fclib"].into_iter().flat_map(load_set).collect()
}

fn load_set(set: &str) -> Vec<File> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/mlcp");
    let entries = fs::read_dir(folder.join(set)).expect("the set is there");
    let mut paths: Vec<_> = entries.map(|e| e.expect("readable").path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "json"));
    paths.sort();
    let read = |p| serde_json::from_slice(&fs::read(p).expect("readable")).expect("JSON");
    paths.iter().map(|p| parse(&read(p))).collect()
}

fn parse(file: &Value) -> File {
    let rows_per_contact = file["dim"].as_u64().expect("rows per contact") as usize;
    let friction = numbers(&file["mu"]);
    let b = numbers(&file["b"]);
    let reference = file["lambda"].is_array().then(|| parse_reference(file));
    // Set for each use; files without a solution have none to take from.
    let bounds = Bounds::Coupled(Default::default());
    let has_bodies = file["rows"].is_array();
    let problem = if has_bodies {
        Problem::Bodies(ContactProblem {
            bodies: list(&file["bodies"], parse_body),
            contacts: parse_contacts(file, &friction),
            bounds,
        })
    } else {
        Problem::Dense(DenseProblem {
            rows_per_contact,
            a: parse_matrix(&file["A_lower"], b.len()),
            b: b.clone(),
            friction: friction.clone(),
            bounds,
        })
    };
    let before = |body: &Value| body["v0"].is_array().then(|| six(&body["v0"]));
    File {
        name: file["name"].as_str().expect("name").to_string(),
        rows_per_contact,
        friction,
        b,
        problem,
        velocity_before: has_bodies
            .then(|| list(&file["bodies"], before).into_iter().collect())
            .flatten(),
        reference,
    }
}

fn parse_reference(file: &Value) -> Reference {
    Reference {
        lambda: numbers(&file["lambda"]),
        w: numbers(&file["w"]),
        energy_norm: file["energy_norm"].as_f64().expect("a number"),
        bounds: Bounds::Frozen {
            lo: numbers(&file["lo"]),
            hi: numbers(&file["hi"]),
        },
        warm: file["warm"].is_array().then(|| numbers(&file["warm"])),
    }
}

fn parse_body(body: &Value) -> Body {
    let i = numbers(&body["inv_inertia"]);
    Body {
        inverse_mass: body["inv_mass"].as_f64().expect("a number"),
        inverse_inertia: [[i[0], i[1], i[2]], [i[1], i[3], i[4]], [i[2], i[4], i[5]]],
        velocity: six(&body["v_free"]),
    }
}

fn parse_contacts(file: &Value, friction: &[f64]) -> Vec<Contact> {
    let bias = numbers(&file["bias"]);
    let rows = file["rows"].as_array().expect("rows");
    let contacts = rows.chunks_exact(3).zip(bias.chunks_exact(3)).zip(friction);
    contacts
        .map(|((rows, bias), &friction)| Contact {
            bodies: [0, 1].map(|side| rows[0][side].as_u64().map(|i| i as u32)),
            jacobian: [0, 1, 2].map(|k| [six(&rows[k][2]), six(&rows[k][3])]),
            target_velocity: [-bias[0], -bias[1], -bias[2]],
            friction,
        })
        .collect()
}

fn parse_matrix(lower: &Value, n: usize) -> Vec<f64> {
    let mut a = vec![0.0; n * n];
    let index = |v: &Value| v.as_u64().expect("an index") as usize;
    let (i, j) = (list(&lower["i"], index), list(&lower["j"], index));
    for ((&i, &j), v) in i.iter().zip(&j).zip(numbers(&lower["v"])) {
        a[i * n + j] = v;
        a[j * n + i] = v;
    }
    a
}

fn list<T>(value: &Value, read: impl Fn(&Value) -> T) -> Vec<T> {
    value.as_array().expect("a list").iter().map(read).collect()
}

/// Numbers; `null` stands for infinity.
fn numbers(value: &Value) -> Vec<f64> {
    list(value, |v| v.as_f64().unwrap_or(f64::INFINITY))
}

fn six(value: &Value) -> [f64; 6] {
    numbers(value).try_into().expect("six numbers")
}
