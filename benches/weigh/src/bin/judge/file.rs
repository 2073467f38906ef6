//! The problem files; their format is described beside them.

use serde_json::Value;

/// A problem `w = A lambda - b`.
pub(crate) struct File {
    pub(crate) name: String,
    pub(crate) per_contact: usize,
    pub(crate) friction: Vec<f64>,
    /// Row by row.
    pub(crate) a: Vec<f64>,
    pub(crate) b: Vec<f64>,
    pub(crate) reference: Option<Reference>,
}

/// Bounds and velocities of the solution in the file.
pub(crate) struct Reference {
    pub(crate) lo: Vec<f64>,
    pub(crate) hi: Vec<f64>,
    pub(crate) w: Vec<f64>,
}

impl File {
    pub(crate) fn w(&self, lambda: &[f64]) -> Vec<f64> {
        let rows = self.a.chunks_exact(self.b.len()).zip(&self.b);
        rows.map(|(row, b)| row.iter().zip(lambda).map(|(a, l)| a * l).sum::<f64>() - b)
            .collect()
    }

    /// Largest difference relative to the fastest velocity with or without contacts.
    pub(crate) fn difference(&self, w: &[f64], other: &[f64]) -> f64 {
        let scale = self
            .b
            .iter()
            .chain(other)
            .fold(0.0, |m: f64, v| m.max(v.abs()));
        w.iter()
            .zip(other)
            .fold(0.0, |m: f64, (x, y)| m.max((x - y).abs()))
            / scale
    }
}

pub(crate) fn load_all() -> Vec<File> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/mlcp");
    let mut paths = Vec::new();
    for set in ["own", "fclib"] {
        let entries = std::fs::read_dir(format!("{folder}/{set}")).expect("the set is there");
        paths.extend(entries.map(|entry| entry.expect("readable").path()));
    }
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "json"));
    paths.sort();
    let read =
        |path| serde_json::from_slice(&std::fs::read(path).expect("readable")).expect("JSON");
    paths.iter().map(|path| parse(&read(path))).collect()
}

fn parse(file: &Value) -> File {
    let b = numbers(&file["b"]);
    let n = b.len();
    let a = if file["A_lower"].is_object() {
        from_triangle(&file["A_lower"], n)
    } else {
        from_bodies(file, n)
    };
    File {
        name: file["name"].as_str().expect("a name").into(),
        per_contact: file["dim"].as_u64().expect("a number") as usize,
        friction: numbers(&file["mu"]),
        a,
        reference: file["w"].is_array().then(|| Reference {
            lo: numbers(&file["lo"]),
            hi: numbers(&file["hi"]),
            w: numbers(&file["w"]),
        }),
        b,
    }
}

fn from_triangle(lower: &Value, n: usize) -> Vec<f64> {
    let mut a = vec![0.0; n * n];
    let places = numbers(&lower["i"]).into_iter().zip(numbers(&lower["j"]));
    for ((i, j), value) in places.zip(numbers(&lower["v"])) {
        let (i, j) = (i as usize, j as usize);
        a[i * n + j] = value;
        a[j * n + i] = value;
    }
    a
}

/// `J M^-1 J^T`.
fn from_bodies(file: &Value, n: usize) -> Vec<f64> {
    let bodies = file["bodies"].as_array().expect("bodies");
    let rows = file["rows"].as_array().expect("rows");
    let sides = |row: &Value| {
        [0, 1].map(|side| {
            (
                row[side].as_i64().expect("a number"),
                numbers(&row[2 + side]),
            )
        })
    };
    let rows: Vec<_> = rows.iter().map(sides).collect();
    let scaled = |body: i64, j: &[f64]| -> Vec<f64> {
        let Ok(body) = usize::try_from(body) else {
            return vec![0.0; 6];
        };
        let mass = bodies[body]["inv_mass"].as_f64().expect("a number");
        let i = numbers(&bodies[body]["inv_inertia"]);
        let [x, y, z] = [j[3], j[4], j[5]];
        let turn = |p: f64, q: f64, r: f64| p * x + q * y + r * z;
        vec![
            mass * j[0],
            mass * j[1],
            mass * j[2],
            turn(i[0], i[1], i[2]),
            turn(i[1], i[3], i[4]),
            turn(i[2], i[4], i[5]),
        ]
    };
    let mut a = vec![0.0; n * n];
    for (r, row) in rows.iter().enumerate() {
        for (body, j) in row.iter().filter(|(body, _)| *body >= 0) {
            let moved = scaled(*body, j);
            for (s, other) in rows.iter().enumerate() {
                for (_, j) in other.iter().filter(|(of, _)| of == body) {
                    a[r * n + s] += moved.iter().zip(j).map(|(m, j)| m * j).sum::<f64>();
                }
            }
        }
    }
    a
}

/// Numbers; `null` stands for infinity.
fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list");
    list.iter()
        .map(|v| v.as_f64().unwrap_or(f64::INFINITY))
        .collect()
}
