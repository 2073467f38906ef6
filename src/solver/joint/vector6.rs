//! Six numbers, linear before angular, and blocks of six by six.

use glam::DVec3;

/// A velocity, an impulse or a row of one body: linear, then angular.
pub(crate) type Vector6 = [f64; 6];

/// Six by six, row by row.
pub(crate) type Block6 = [[f64; 6]; 6];

/// From its two halves.
#[inline(always)]
pub(crate) fn join(linear: DVec3, angular: DVec3) -> Vector6 {
    [
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    ]
}

/// Its two halves.
#[inline(always)]
pub(crate) fn split(v: &Vector6) -> [DVec3; 2] {
    [DVec3::new(v[0], v[1], v[2]), DVec3::new(v[3], v[4], v[5])]
}

/// Inner product.
#[inline(always)]
pub(crate) fn dot(a: &Vector6, b: &Vector6) -> f64 {
    let p: Vector6 = std::array::from_fn(|i| a[i] * b[i]);
    // As two lanes add up.
    ((p[0] + p[2]) + p[4]) + ((p[1] + p[3]) + p[5])
}

/// `to += s v`
#[inline(always)]
pub(crate) fn add_scaled(to: &mut Vector6, s: f64, v: &Vector6) {
    for (to, v) in to.iter_mut().zip(v) {
        *to += s * v;
    }
}

/// `to += s a b^T`
#[inline(always)]
pub(crate) fn add_outer(to: &mut Block6, s: f64, a: &Vector6, b: &Vector6) {
    for (row, a) in to.iter_mut().zip(a) {
        add_scaled(row, s * a, b);
    }
}

/// `A v` with a symmetric `A`.
#[inline(always)]
pub(crate) fn product(a: &Block6, v: &Vector6) -> Vector6 {
    let mut sum = [0.0; 6];
    for (row, v) in a.iter().zip(v) {
        add_scaled(&mut sum, *v, row);
    }
    sum
}

/// `A^-1` of a symmetric and positive definite `A` in its place, by Gauss-Jordan elimination.
#[inline(always)]
pub(crate) fn invert(a: &mut Block6) {
    for k in 0..6 {
        // Positive but for rounding: what is left of it then does not move.
        let inverse = if a[k][k] > 0.0 { a[k][k].recip() } else { 0.0 };
        let mut pivot = a[k].map(|x| x * inverse);
        pivot[k] = inverse;
        for (i, row) in a.iter_mut().enumerate() {
            if i != k {
                let share = row[k];
                row[k] = 0.0;
                add_scaled(row, -share, &pivot);
            }
        }
        a[k] = pivot;
    }
}
