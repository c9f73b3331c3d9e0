//! The loops over all pairs of landmarks, for the widest vectors of the processor.

use pulp::{Arch, Simd, WithSimd};

/// `to += factor * of`, for vectors of the same length.
pub(in crate::slam) fn add_scaled(to: &mut [f64], factor: f64, of: &[f64]) {
    Arch::new().dispatch(AddScaled { to, factor, of });
}

struct AddScaled<'a> {
    to: &'a mut [f64],
    factor: f64,
    of: &'a [f64],
}

impl WithSimd for AddScaled<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let factor = simd.splat_f64s(self.factor);
        let (to, to_rest) = S::as_mut_simd_f64s(self.to);
        let (of, of_rest) = S::as_simd_f64s(self.of);
        for (to, of) in to.iter_mut().zip(of) {
            *to = simd.mul_add_e_f64s(factor, *of, *to);
        }
        let rest = simd.partial_load_f64s(to_rest);
        let sum = simd.mul_add_e_f64s(factor, simd.partial_load_f64s(of_rest), rest);
        simd.partial_store_f64s(to_rest, sum);
    }
}

/// Subtracts `sum_k left_k right_k^T` from a matrix of which only the part below the 2 x 2 blocks
/// of its diagonal is stored: two rows of length 2 j for block row j, one after the other. Each
/// element is read and written once.
pub(super) struct SubtractProduct<'a> {
    /// The matrix.
    pub(super) below: &'a mut [f64],
    /// Vectors of `length` elements, one after the other.
    pub(super) left: &'a [f64],
    /// As many of the same length.
    pub(super) right: &'a [f64],
    /// Rows of the matrix, two for each block row.
    pub(super) length: usize,
}

impl SubtractProduct<'_> {
    pub(super) fn run(self) {
        if self.length > 0 && !self.left.is_empty() {
            Arch::new().dispatch(self);
        }
    }
}

impl WithSimd for SubtractProduct<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let SubtractProduct { mut below, left, right, length } = self;
        let mut factors = Vec::new();
        let mut row = 0;
        // Two block rows at a time, of lengths `row` and `row + 2`.
        while row + 4 <= length {
            let (block, rest) = below.split_at_mut(4 * row + 4);
            below = rest;
            let (first, second) = block.split_at_mut(2 * row);
            let (a, b) = first.split_at_mut(row);
            let (c, d) = second.split_at_mut(row + 2);
            let ((c, c_end), (d, d_end)) = (c.split_at_mut(row), d.split_at_mut(row));
            let product = Product { left, right, length };
            product.factors_of(row, 4, &mut factors);
            product.subtract_corner(row, c_end, d_end);
            product.subtract_from::<S, 4>(simd, [a, b, c, d], &factors);
            row += 4;
        }
        if row < length {
            let (a, b) = below.split_at_mut(row);
            let product = Product { left, right, length };
            product.factors_of(row, 2, &mut factors);
            product.subtract_from::<S, 2>(simd, [a, b], &factors);
        }
    }
}

/// The product that is subtracted.
#[derive(Clone, Copy)]
struct Product<'a> {
    left: &'a [f64],
    right: &'a [f64],
    length: usize,
}

impl Product<'_> {
    /// What the rows from `row` on are multiplied by, negated: `count` factors for each term.
    #[inline(always)]
    fn factors_of(&self, row: usize, count: usize, factors: &mut Vec<f64>) {
        factors.clear();
        for left in self.left.chunks_exact(self.length) {
            factors.extend(left[row..row + count].iter().map(|factor| -factor));
        }
    }

    /// The block between two block rows, which the second has beyond the first.
    #[inline(always)]
    fn subtract_corner(&self, row: usize, c: &mut [f64], d: &mut [f64]) {
        let terms = self.left.chunks_exact(self.length).zip(self.right.chunks_exact(self.length));
        for (left, right) in terms {
            for k in 0..2 {
                c[k] -= left[row + 2] * right[row + k];
                d[k] -= left[row + 3] * right[row + k];
            }
        }
    }

    /// Subtracts from `N` rows of the same length.
    #[inline(always)]
    fn subtract_from<S: Simd, const N: usize>(
        self,
        simd: S,
        rows: [&mut [f64]; N],
        factors: &[f64],
    ) {
        match factors.len() / N {
            1 => self.few::<S, N, 1>(simd, rows, factors),
            2 => self.few::<S, N, 2>(simd, rows, factors),
            4 => self.few::<S, N, 4>(simd, rows, factors),
            _ => self.many::<S, N>(simd, rows, factors),
        }
    }

    /// `K` terms, whose factors stay in registers.
    #[inline(always)]
    fn few<S: Simd, const N: usize, const K: usize>(
        self,
        simd: S,
        rows: [&mut [f64]; N],
        factors: &[f64],
    ) {
        let columns = rows[0].len();
        let factors: [[S::f64s; N]; K] =
            std::array::from_fn(|k| std::array::from_fn(|n| simd.splat_f64s(factors[N * k + n])));
        let right: [&[f64]; K] =
            std::array::from_fn(|k| &self.right[k * self.length..k * self.length + columns]);
        let whole: [&[S::f64s]; K] = right.map(|right| S::as_simd_f64s(right).0);
        let rows = rows.map(|row| S::as_mut_simd_f64s(row));
        let mut rests = [(); N].map(|()| &mut [][..]);
        let mut heads = [(); N].map(|()| &mut [][..]);
        for (n, (head, rest)) in rows.into_iter().enumerate() {
            (heads[n], rests[n]) = (head, rest);
        }
        let vectors = columns / S::F64_LANES;
        let whole = whole.map(|whole| &whole[..vectors]);
        let heads = heads.map(|head| &mut head[..vectors]);
        for c in 0..vectors {
            let right: [S::f64s; K] = std::array::from_fn(|k| whole[k][c]);
            for n in 0..N {
                let mut sum = heads[n][c];
                for k in 0..K {
                    sum = simd.mul_add_e_f64s(factors[k][n], right[k], sum);
                }
                heads[n][c] = sum;
            }
        }
        for (n, rest) in rests.into_iter().enumerate() {
            let mut sum = simd.partial_load_f64s(rest);
            for k in 0..K {
                let right = simd.partial_load_f64s(S::as_simd_f64s(right[k]).1);
                sum = simd.mul_add_e_f64s(factors[k][n], right, sum);
            }
            simd.partial_store_f64s(rest, sum);
        }
    }

    /// Any number of terms: a tile of `N` rows and [`TILE`] vectors stays in registers while all
    /// terms are subtracted from it.
    #[inline(always)]
    fn many<S: Simd, const N: usize>(self, simd: S, mut rows: [&mut [f64]; N], factors: &[f64]) {
        let columns = rows[0].len();
        let width = TILE * S::F64_LANES;
        let mut start = 0;
        while start + width <= columns {
            let mut tile = [(); N].map(|()| [simd.splat_f64s(0.0); TILE]);
            for (tile, row) in tile.iter_mut().zip(&rows) {
                tile.copy_from_slice(S::as_simd_f64s(&row[start..start + width]).0);
            }
            let terms = self.right.chunks_exact(self.length).zip(factors.chunks_exact(N));
            for (right, factors) in terms {
                let right = S::as_simd_f64s(&right[start..start + width]).0;
                for n in 0..N {
                    let factor = simd.splat_f64s(factors[n]);
                    for c in 0..TILE {
                        tile[n][c] = simd.mul_add_e_f64s(factor, right[c], tile[n][c]);
                    }
                }
            }
            for (tile, row) in tile.iter().zip(&mut rows) {
                S::as_mut_simd_f64s(&mut row[start..start + width]).0.copy_from_slice(tile);
            }
            start += width;
        }
        while start < columns {
            let end = (start + S::F64_LANES).min(columns);
            let terms = || self.right.chunks_exact(self.length).zip(factors.chunks_exact(N));
            for (n, row) in rows.iter_mut().enumerate() {
                let mut sum = simd.partial_load_f64s(&row[start..end]);
                for (right, factors) in terms() {
                    let right = simd.partial_load_f64s(&right[start..end]);
                    sum = simd.mul_add_e_f64s(simd.splat_f64s(factors[n]), right, sum);
                }
                simd.partial_store_f64s(&mut row[start..end], sum);
            }
            start = end;
        }
    }
}

/// Vectors of a tile's width.
const TILE: usize = 3;
