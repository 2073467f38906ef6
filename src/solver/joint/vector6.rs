//! Six numbers, linear before angular, and blocks of six by six.

use glam::DVec3;

/// A velocity, an impulse or a row of one body: linear, then angular.
pub(crate) type Vector6 = [f64; 6];

/// Six by six, row by row.
pub(crate) type Block6 = [[f64; 6]; 6];

/// From its two halves.
pub(crate) fn join(linear: DVec3, angular: DVec3) -> Vector6 {
    [
        linear.x, linear.y, linear.z, angular.x, angular.y, angular.z,
    ]
}

/// Its two halves.
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

/// `A^-1` of a symmetric and positive definite `A` in its place, by halves: with `A = [P Q; Q^T R]` and `S = R - Q^T P^-1 Q`.
#[inline(always)]
pub(crate) fn invert(a: &mut Block6) {
    let of_p = invert_half(&quarter(a, 0, 0));
    let q = quarter(a, 0, 3);
    let turned = times(&of_p, &q);
    let (mut s, taken) = (quarter(a, 3, 3), times(&transpose(&q), &turned));
    for i in 0..3 {
        for j in 0..3 {
            s[i][j] -= taken[i][j];
        }
    }
    let of_s = invert_half(&s);
    let beside = times(&turned, &of_s);
    let added = times(&beside, &transpose(&turned));
    for i in 0..3 {
        for j in 0..3 {
            a[i][j] = of_p[i][j] + added[i][j];
            a[i][3 + j] = -beside[i][j];
            a[3 + j][i] = -beside[i][j];
            a[3 + i][3 + j] = of_s[i][j];
        }
    }
}

/// Three by three, row by row.
type Block3 = [[f64; 3]; 3];

#[inline(always)]
fn quarter(a: &Block6, row: usize, column: usize) -> Block3 {
    std::array::from_fn(|i| std::array::from_fn(|j| a[row + i][column + j]))
}

#[inline(always)]
fn transpose(a: &Block3) -> Block3 {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

#[inline(always)]
fn times(a: &Block3, b: &Block3) -> Block3 {
    let entry = |i: usize, j: usize| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
    std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
}

/// Inverse of a symmetric and positive definite one, by cofactors.
#[inline(always)]
fn invert_half(&[[xx, xy, xz], [_, yy, yz], [_, _, zz]]: &Block3) -> Block3 {
    let of_x = [yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy];
    let of_y = [of_x[1], xx * zz - xz * xz, xy * xz - xx * yz];
    let of_z = [of_x[2], of_y[2], xx * yy - xy * xy];
    let determinant = xx * of_x[0] + xy * of_x[1] + xz * of_x[2];
    // Positive but for rounding: what is left of it then does not move.
    let inverse = if determinant > 0.0 {
        determinant.recip()
    } else {
        0.0
    };
    [of_x, of_y, of_z].map(|row| row.map(|x| x * inverse))
}
