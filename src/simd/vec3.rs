//! Vectors of whatever adds and multiplies: one number, or one of each lane.

use crate::simd::lanes::{F8, Lanes};
use std::ops::{Add, Div, Mul, Sub};

/// Three numbers in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct V3<T>(pub(crate) [T; 3]);

impl<L: Lanes> V3<L> {
    #[inline(always)]
    pub(crate) fn load(from: &[F8; 3]) -> Self {
        Self([L::load(&from[0]), L::load(&from[1]), L::load(&from[2])])
    }

    #[inline(always)]
    pub(crate) fn store(self, to: &mut [F8; 3]) {
        let [x, y, z] = self.0;
        x.store(&mut to[0]);
        y.store(&mut to[1]);
        z.store(&mut to[2]);
    }
}

impl<T> V3<T>
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<Output = T> + Div<Output = T>,
{
    #[inline(always)]
    pub(crate) fn plus(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a + x, b + y, c + z])
    }

    #[inline(always)]
    pub(crate) fn minus(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a - x, b - y, c - z])
    }

    #[inline(always)]
    pub(crate) fn times(self, factor: T) -> Self {
        let [x, y, z] = self.0;
        Self([x * factor, y * factor, z * factor])
    }

    /// Product by component.
    #[inline(always)]
    pub(crate) fn scaled(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a * x, b * y, c * z])
    }

    /// Quotient by component.
    #[inline(always)]
    pub(crate) fn over(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([a / x, b / y, c / z])
    }

    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> T {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        a * x + b * y + c * z
    }

    #[inline(always)]
    pub(crate) fn cross(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }
}
