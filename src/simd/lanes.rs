//! Eight numbers at a time, whatever the registers.
//!
//! A loop over [`Lanes`] is written once and compiled for each kind of them; [`dispatch`](crate::simd::dispatch) says which
//! runs. All kinds round every operation on its own, in the same order, and none fuses a multiplication with an addition, so
//! all give the same bits.

use std::cell::Cell;
use std::ops::{Add, Div, Mul, Sub};

/// Number of lanes of everything that is laid out for [`Lanes`].
pub const WIDTH: usize = 8;

/// Eight numbers in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct F8(pub [f32; WIDTH]);

/// How many lanes a register may have. All widths give the same bits; the choice is for tests and measurements.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub enum LaneWidth {
    /// As many as the processor has: 8 with AVX2, else 4; in WebAssembly 4 if it is built with `simd128`, else 1.
    #[default]
    Widest,
    /// At most 4.
    Four,
    /// One: plain Rust.
    One,
}

/// Eight numbers in registers.
pub trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The same number in all lanes.
    fn splat(x: f32) -> Self;
    /// Reads eight numbers.
    fn load(from: &F8) -> Self;
    /// Writes eight numbers.
    fn store(self, to: &mut F8);
    /// The smaller one by lane; `other` if either is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger one by lane; `other` if either is NaN.
    fn max(self, other: Self) -> Self;
    /// Square root by lane.
    fn sqrt(self) -> Self;
    /// `yes` in lanes where `self > bound`, else `no`.
    fn if_above(self, bound: Self, yes: Self, no: Self) -> Self;
    /// Whether `self > bound` in any lane.
    fn is_any_above(self, bound: Self) -> bool;
    /// Eight rows, one of each lane, as columns; or columns as rows.
    fn transpose(rows: [Self; 8]) -> [Self; 8];

    /// Eight rows of eight numbers, one row for each lane, as columns.
    #[inline(always)]
    fn columns(rows: &[F8; WIDTH]) -> [Self; 8] {
        Self::transpose([
            Self::load(&rows[0]),
            Self::load(&rows[1]),
            Self::load(&rows[2]),
            Self::load(&rows[3]),
            Self::load(&rows[4]),
            Self::load(&rows[5]),
            Self::load(&rows[6]),
            Self::load(&rows[7]),
        ])
    }

    /// The rows that the lanes refer to, as columns.
    #[inline(always)]
    fn gather<R: ReadRow>(rows: &[R], index: &[u32; WIDTH]) -> [Self; 8] {
        Self::transpose([
            read(rows, index[0]),
            read(rows, index[1]),
            read(rows, index[2]),
            read(rows, index[3]),
            read(rows, index[4]),
            read(rows, index[5]),
            read(rows, index[6]),
            read(rows, index[7]),
        ])
    }

    /// Writes what [`gather`](Self::gather) reads, of the first `used` lanes. Those that share a row must hold the same numbers.
    #[inline(always)]
    fn scatter<R: WriteRow>(
        columns: [Self; 8],
        rows: &[Cell<R>],
        index: &[u32; WIDTH],
        used: usize,
    ) {
        let from = Self::transpose(columns);
        for lane in 0..WIDTH {
            if lane >= used {
                break;
            }
            let mut numbers = F8::default();
            from[lane].store(&mut numbers);
            rows[index[lane] as usize].set(R::of(numbers.0));
        }
    }
}

#[inline(always)]
fn read<R: ReadRow, L: Lanes>(rows: &[R], index: u32) -> L {
    L::load(&F8(rows[index as usize].numbers()))
}

/// Eight numbers that lie in a row in memory.
pub trait ReadRow {
    /// The numbers.
    fn numbers(&self) -> [f32; 8];
}

/// Eight numbers that can be written too.
pub trait WriteRow: ReadRow + Copy {
    /// A row of these numbers.
    fn of(numbers: [f32; 8]) -> Self;
}

impl<R: WriteRow> ReadRow for Cell<R> {
    #[inline(always)]
    fn numbers(&self) -> [f32; 8] {
        self.get().numbers()
    }
}

impl ReadRow for F8 {
    #[inline(always)]
    fn numbers(&self) -> [f32; 8] {
        self.0
    }
}

impl WriteRow for F8 {
    #[inline(always)]
    fn of(numbers: [f32; 8]) -> Self {
        Self(numbers)
    }
}

/// A loop that is compiled for each kind of registers. `run` and all that it calls must be `#[inline(always)]`, so that they
/// become part of the function that has the processor's features. It may leave its lanes alone, if it is written such that
/// the compiler finds wide instructions for it by itself.
pub trait Kernel {
    /// What the loop comes to.
    type Output;
    /// Whether it gains from 32 registers instead of 16: two bodies and the frame of a contact do not fit 16.
    const NEEDS_32_REGISTERS: bool = true;
    /// The loop.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Lanes in plain Rust.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plain([f32; WIDTH]);

impl Plain {
    #[inline(always)]
    fn zip(mut self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        // A loop, because calls of the library within the kernels are not always inlined.
        for (x, y) in self.0.iter_mut().zip(other.0) {
            *x = f(*x, y);
        }
        self
    }
}

/// The operators of a kind of lanes, from expressions.
macro_rules! operators {
    ($type:ty, $($trait:ident $name:ident: |$a:ident, $b:ident| $value:expr;)*) => {$(
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                $value
            }
        }
    )*};
}
#[cfg(any(
    target_arch = "x86_64",
    all(target_arch = "wasm32", target_feature = "simd128")
))]
pub(super) use operators;

operators! { Plain,
    Add add: |a, b| a.zip(b, |x, y| x + y);
    Sub sub: |a, b| a.zip(b, |x, y| x - y);
    Mul mul: |a, b| a.zip(b, |x, y| x * y);
    Div div: |a, b| a.zip(b, |x, y| x / y);
}

impl Lanes for Plain {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; WIDTH])
    }

    #[inline(always)]
    fn load(from: &F8) -> Self {
        Self(from.0)
    }

    #[inline(always)]
    fn store(self, to: &mut F8) {
        to.0 = self.0;
    }

    // The comparisons are those of the x86 instructions, which are not those of `f32::min` and `f32::max` for NaN.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |x, y| if x < y { x } else { y })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |x, y| if x > y { x } else { y })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f32::sqrt))
    }

    #[inline(always)]
    fn if_above(self, bound: Self, yes: Self, no: Self) -> Self {
        Self(std::array::from_fn(|i| {
            if self.0[i] > bound.0[i] {
                yes.0[i]
            } else {
                no.0[i]
            }
        }))
    }

    #[inline(always)]
    fn is_any_above(self, bound: Self) -> bool {
        self.0.iter().zip(&bound.0).any(|(x, bound)| x > bound)
    }

    #[inline(always)]
    fn transpose(rows: [Self; 8]) -> [Self; 8] {
        std::array::from_fn(|column| Self(rows.map(|row| row.0[column])))
    }
}
