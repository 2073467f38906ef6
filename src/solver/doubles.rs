//! Double precision one at a time or eight at a time, so that a calculation is written once for both and gives the same bits.

use std::ops::{Add, Div, Mul, Sub};

/// Numbers of an [`Eight`].
pub(super) const EIGHT: usize = 8;

/// One number or some, by lane.
pub(super) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The same number in all lanes.
    fn splat(x: f64) -> Self;
    /// Writes a lane.
    fn set(&mut self, lane: usize, x: f64);
    /// Reads a lane.
    fn get(&self, lane: usize) -> f64;
    /// Square root by lane.
    fn sqrt(self) -> Self;
    /// Whether all lanes are below a bound.
    fn is_below(self, bound: f64) -> bool;
    /// `yes` in lanes that are below a bound, else `no`.
    fn if_below(self, bound: f64, yes: Self, no: Self) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        x
    }

    #[inline(always)]
    fn set(&mut self, _: usize, x: f64) {
        *self = x;
    }

    #[inline(always)]
    fn get(&self, _: usize) -> f64 {
        *self
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn is_below(self, bound: f64) -> bool {
        self < bound
    }

    #[inline(always)]
    fn if_below(self, bound: f64, yes: Self, no: Self) -> Self {
        if self < bound { yes } else { no }
    }
}

/// Eight numbers. Loops over them become vector instructions where they are compiled for a processor that has such.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Eight([f64; EIGHT]);

macro_rules! by_lane {
    ($($operator:ident $name:ident $sign:tt;)*) => {$(
        impl $operator for Eight {
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

impl Number for Eight {
    #[inline(always)]
    fn splat(x: f64) -> Self {
        Self([x; EIGHT])
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, x: f64) {
        self.0[lane] = x;
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> f64 {
        self.0[lane]
    }

    #[inline(always)]
    fn sqrt(mut self) -> Self {
        for x in &mut self.0 {
            *x = x.sqrt();
        }
        self
    }

    #[inline(always)]
    fn is_below(self, bound: f64) -> bool {
        let mut all = true;
        for x in self.0 {
            all &= x < bound;
        }
        all
    }

    #[inline(always)]
    fn if_below(self, bound: f64, yes: Self, no: Self) -> Self {
        let mut chosen = no;
        for (lane, x) in self.0.into_iter().enumerate() {
            if x < bound {
                chosen.0[lane] = yes.0[lane];
            }
        }
        chosen
    }
}
