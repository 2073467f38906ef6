//! Every operation of every kind of lanes gives the bits of plain Rust.

use super::WIDTHS;
use crate::common::dice::Dice;
use bevy_cleave::testing::bodies::SolverBody;
use bevy_cleave::testing::simd::{F8, Kernel, LaneWidth, Lanes, WIDTH, run};
use glam::Vec3;
use std::cell::Cell;

/// Numbers at which implementations like to differ.
const SPECIAL: [f32; 18] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    0.1,
    -3.7,
    f32::EPSILON,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    1e-45,
    -1e-40,
    f32::MAX,
    f32::MIN,
    1e30,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    -f32::NAN,
];

/// All operations on two numbers in each lane.
struct Operations([F8; 2]);

/// What they give: those that compute, and those that choose.
#[derive(Debug, Default)]
struct Results {
    computed: [F8; 5],
    chosen: [F8; 4],
    is_any_above: bool,
}

impl Kernel for Operations {
    type Output = Results;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Results {
        let [a, b] = [L::load(&self.0[0]), L::load(&self.0[1])];
        let mut results = Results {
            is_any_above: a.is_any_above(b),
            ..Results::default()
        };
        let computed = [a + b, a - b, a * b, a / b, a.sqrt()];
        let one = L::splat(1.0);
        let chosen = [
            a.min(b),
            a.max(b),
            a.if_above(b, a, b),
            a.if_above(b, one, a),
        ];
        for (lanes, to) in computed.into_iter().zip(&mut results.computed) {
            lanes.store(to);
        }
        for (lanes, to) in chosen.into_iter().zip(&mut results.chosen) {
            lanes.store(to);
        }
        results
    }
}

/// What the operations are in terms of `f32`; see [`Lanes`].
fn expected(a: f32, b: f32) -> ([f32; 5], [f32; 4]) {
    let pick = |is_first, x, y| if is_first { x } else { y };
    (
        [a + b, a - b, a * b, a / b, a.sqrt()],
        [
            pick(a < b, a, b),
            pick(a > b, a, b),
            pick(a > b, a, b),
            pick(a > b, 1.0, a),
        ],
    )
}

/// Rust leaves open which NaN an operation gives, so any is as good as another. Nothing of the step looks at their bits.
fn is_same_number(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

fn check_operations(a: F8, b: F8) {
    for width in WIDTHS {
        let results = run(width, Operations(std::hint::black_box([a, b])));
        for lane in 0..WIDTH {
            let (x, y) = (a.0[lane], b.0[lane]);
            let (computed, chosen) = expected(x, y);
            for (k, expected) in computed.into_iter().enumerate() {
                let found = results.computed[k].0[lane];
                assert!(
                    is_same_number(found, expected),
                    "{width:?}, computed {k} of {x:e} and {y:e}: {found:e}, not {expected:e}"
                );
            }
            let bits = |numbers: [f32; 4]| numbers.map(f32::to_bits);
            let found = results.chosen.map(|lanes| lanes.0[lane]);
            assert_eq!(bits(found), bits(chosen), "{width:?}, {x:e} and {y:e}");
        }
        let is_any_above = a.0.iter().zip(b.0).any(|(&x, y)| x > y);
        assert_eq!(results.is_any_above, is_any_above, "{width:?}, {a:?} {b:?}");
    }
}

#[test]
fn operations_on_special_numbers_are_those_of_plain_rust() {
    for first in SPECIAL {
        for others in SPECIAL.chunks(WIDTH) {
            let mut b = F8([first; WIDTH]);
            b.0[..others.len()].copy_from_slice(others);
            check_operations(F8([first; WIDTH]), b);
            check_operations(b, F8([first; WIDTH]));
        }
    }
}

fn any_numbers(dice: &mut Dice) -> F8 {
    F8([(); WIDTH].map(|()| {
        let high = dice.below(1 << 16) as u32;
        f32::from_bits(high << 16 | dice.below(1 << 16) as u32)
    }))
}

#[test]
fn operations_on_any_bits_are_those_of_plain_rust() {
    let mut dice = Dice::new(1);
    for _ in 0..2000 {
        check_operations(any_numbers(&mut dice), any_numbers(&mut dice));
    }
}

/// Rows to columns.
struct Columns<'a>(&'a [F8; WIDTH]);

impl Kernel for Columns<'_> {
    type Output = [F8; 8];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [F8; 8] {
        stored(L::columns(self.0))
    }
}

#[inline(always)]
fn stored<L: Lanes>(columns: [L; 8]) -> [F8; 8] {
    let mut to = [F8::default(); 8];
    for (lanes, to) in columns.into_iter().zip(&mut to) {
        lanes.store(to);
    }
    to
}

fn bits<const N: usize>(rows: [F8; N]) -> [[u32; WIDTH]; N] {
    rows.map(|row| row.0.map(f32::to_bits))
}

fn transposed(rows: &[F8; WIDTH]) -> [F8; 8] {
    std::array::from_fn(|column| F8(rows.map(|row| row.0[column])))
}

#[test]
fn columns_are_the_transposed_rows_bit_for_bit() {
    let mut dice = Dice::new(2);
    for _ in 0..200 {
        let rows = [(); WIDTH].map(|()| any_numbers(&mut dice));
        for width in WIDTHS {
            assert_eq!(bits(run(width, Columns(&rows))), bits(transposed(&rows)));
        }
    }
}

/// Gathers rows, and scatters them to others.
struct Move<'a> {
    rows: &'a mut [SolverBody],
    from: [u32; WIDTH],
    to: [u32; WIDTH],
    used: usize,
}

impl Kernel for Move<'_> {
    type Output = [F8; 8];

    #[inline(always)]
    fn run<L: Lanes>(self) -> [F8; 8] {
        let rows = Cell::from_mut(self.rows).as_slice_of_cells();
        let columns = L::gather(rows, &self.from);
        L::scatter(columns, rows, &self.to, self.used);
        stored(columns)
    }
}

fn body(F8([x, y, z, inverse_mass, p, q, r, unused]): F8) -> SolverBody {
    SolverBody {
        linear: Vec3::new(x, y, z),
        inverse_mass,
        angular: Vec3::new(p, q, r),
        unused,
    }
}

fn numbers(body: &SolverBody) -> F8 {
    let (v, w) = (body.linear, body.angular);
    F8([v.x, v.y, v.z, body.inverse_mass, w.x, w.y, w.z, body.unused])
}

#[test]
fn gather_reads_and_scatter_writes_the_rows_that_are_named_bit_for_bit() {
    let mut dice = Dice::new(3);
    for count in [8, 9, 33] {
        let rows: Vec<F8> = (0..count).map(|_| any_numbers(&mut dice)).collect();
        for _ in 0..50 {
            // What is read may be the same row in several lanes, what is written may not.
            let from = [(); WIDTH].map(|()| dice.below(count) as u32);
            let first = dice.below(count);
            let to: [u32; WIDTH] = std::array::from_fn(|lane| ((first + lane) % count) as u32);
            for (width, used) in WIDTHS
                .into_iter()
                .flat_map(|w| (0..=WIDTH).map(move |used| (w, used)))
            {
                check_move(width, &rows, from, &to[..used]);
            }
        }
    }
}

/// `to`: of the lanes in use.
fn check_move(width: LaneWidth, rows: &[F8], from: [u32; WIDTH], to: &[u32]) {
    let mut bodies: Vec<SolverBody> = rows.iter().copied().map(body).collect();
    let mut all = [u32::MAX; WIDTH];
    all[..to.len()].copy_from_slice(to);
    let kernel = Move {
        rows: &mut bodies,
        from,
        to: all,
        used: to.len(),
    };
    let columns = run(width, kernel);
    let read = from.map(|i| rows[i as usize]);
    assert_eq!(bits(columns), bits(transposed(&read)), "{width:?}");
    for (i, (row, body)) in rows.iter().zip(&bodies).enumerate() {
        let lane = to.iter().position(|&to| to as usize == i);
        let expected = lane.map_or(*row, |lane| read[lane]);
        assert_eq!(
            bits([numbers(body)]),
            bits([expected]),
            "{width:?}, row {i}"
        );
    }
}

#[test]
fn scatter_of_lanes_that_share_a_row_writes_it_once() {
    let rows = [F8([1.0; 8]), F8([2.0; 8])];
    for width in WIDTHS {
        check_move(width, &rows, [1; WIDTH], &[0; WIDTH]);
    }
}

#[test]
#[should_panic(expected = "index out of bounds")]
fn gather_beyond_the_rows_panics_in_four_lanes() {
    check_move(
        LaneWidth::Four,
        &[F8::default(); 4],
        [4; WIDTH],
        &[0; WIDTH],
    );
}

#[test]
#[should_panic(expected = "index out of bounds")]
fn scatter_beyond_the_rows_panics_in_the_widest_lanes() {
    let to = [0, 0, 0, 0, 0, 0, 0, 9];
    check_move(LaneWidth::Widest, &[F8::default(); 4], [0; WIDTH], &to);
}
