//! The operations of the library.

use crate::kernel::{self, Ops, Scene};
use bevy_cleave::testing::simd::{F8, Kernel, LaneWidth, Lanes, run};
use std::marker::PhantomData;

struct Ours<L>(PhantomData<L>);

impl<L> Clone for Ours<L> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<L> Copy for Ours<L> {}

impl<L: Lanes> Ops for Ours<L> {
    type V = L;

    #[inline(always)]
    fn splat(self, x: f32) -> L {
        L::splat(x)
    }

    #[inline(always)]
    fn load(self, from: &F8) -> L {
        L::load(from)
    }

    #[inline(always)]
    fn store(self, x: L, to: &mut F8) {
        x.store(to);
    }

    #[inline(always)]
    fn add(self, a: L, b: L) -> L {
        a + b
    }

    #[inline(always)]
    fn sub(self, a: L, b: L) -> L {
        a - b
    }

    #[inline(always)]
    fn mul(self, a: L, b: L) -> L {
        a * b
    }

    #[inline(always)]
    fn div(self, a: L, b: L) -> L {
        a / b
    }

    #[inline(always)]
    fn max(self, a: L, b: L) -> L {
        a.max(b)
    }

    #[inline(always)]
    fn sqrt(self, a: L) -> L {
        a.sqrt()
    }

    #[inline(always)]
    fn if_above(self, a: L, b: L, yes: L, no: L) -> L {
        a.if_above(b, yes, no)
    }

    #[inline(always)]
    fn transpose(self, rows: [L; 8]) -> [L; 8] {
        L::transpose(rows)
    }
}

struct Sweep<'s>(&'s mut Scene);

impl Kernel for Sweep<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        kernel::sweep(Ours::<L>(PhantomData), self.0);
    }
}

pub(crate) fn sweep(scene: &mut Scene, width: LaneWidth) {
    run(width, Sweep(scene));
}
