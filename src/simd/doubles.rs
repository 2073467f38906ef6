//! Double precision, several numbers at a time, so that a calculation is written once for any number and gives the same bits.

use std::ops::{Add, Div, Mul, Sub};

/// Numbers by lane. Loops over them become vector instructions: of two in any program, of more where they are compiled for a
/// processor that has such.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Doubles<const N: usize>([f64; N]);

macro_rules! by_lane {
    ($($operator:ident $name:ident $sign:tt;)*) => {$(
        impl<const N: usize> $operator for Doubles<N> {
            type Output = Self;

            #[inline(always)]
            fn $name(mut self, other: Self) -> Self {
                for (x, y) in self.0.iter_mut().zip(other.0) {
                    *x $sign y;
                }
                self
            }
        }
    )*};
}

by_lane! {
    Add add +=;
    Sub sub -=;
    Mul mul *=;
    Div div /=;
}

impl<const N: usize> Doubles<N> {
    /// The same number in all lanes.
    #[inline(always)]
    pub(crate) fn splat(x: f64) -> Self {
        Self([x; N])
    }

    /// Writes a lane.
    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, x: f64) {
        self.0[lane] = x;
    }

    /// Reads a lane.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> f64 {
        self.0[lane]
    }

    /// Square root by lane.
    #[inline(always)]
    pub(crate) fn sqrt(mut self) -> Self {
        for x in &mut self.0 {
            *x = x.sqrt();
        }
        self
    }

    /// Whether all lanes are below a bound.
    #[inline(always)]
    pub(crate) fn is_below(self, bound: f64) -> bool {
        let mut all = true;
        for x in self.0 {
            all &= x < bound;
        }
        all
    }

    /// `yes` in lanes that are below a bound, else `no`.
    #[inline(always)]
    pub(crate) fn if_below(self, bound: f64, yes: Self, no: Self) -> Self {
        let mut chosen = no;
        for (lane, x) in self.0.into_iter().enumerate() {
            if x < bound {
                chosen.0[lane] = yes.0[lane];
            }
        }
        chosen
    }
}
