//! The covariance of the map, each number of it stored once.

use super::kernel::SubtractProduct;
use nalgebra::Matrix2;
use std::sync::Arc;

/// A symmetric matrix of 2 x 2 blocks, one row and column of blocks for each landmark.
///
/// New landmarks are appended at the end of both stores, so nothing moves when the map grows. The
/// large store is copied when it is written to while another copy of the filter still reads it.
#[derive(Debug, Clone, Default)]
pub(super) struct Triangle {
    /// Of each block on the diagonal the elements xx, xy, yy.
    diagonal: Vec<[f64; 3]>,
    /// Below it, for block row j two rows of length 2 j, one after the other.
    below: Arc<Vec<f64>>,
}

/// Where the rows of block row j begin.
fn start(j: usize) -> usize {
    2 * j * j.saturating_sub(1)
}

impl Triangle {
    /// Number of landmarks.
    pub(super) fn len(&self) -> usize {
        self.diagonal.len()
    }

    /// The block of landmarks `i` and `j`.
    pub(super) fn block(&self, i: usize, j: usize) -> Matrix2<f64> {
        if i == j {
            let [xx, xy, yy] = self.diagonal[i];
            return Matrix2::new(xx, xy, xy, yy);
        }
        if i < j {
            return self.block(j, i).transpose();
        }
        let first = start(i) + 2 * j;
        let (x, y) = (&self.below[first..first + 2], &self.below[first + 2 * i..]);
        Matrix2::new(x[0], x[1], y[0], y[1])
    }

    /// Sets the block of landmarks `i` and `j`, and with it that of `j` and `i`.
    pub(super) fn set_block(&mut self, i: usize, j: usize, block: &Matrix2<f64>) {
        if i == j {
            self.diagonal[i] = [block.m11, block.m21, block.m22];
        } else if i < j {
            self.set_block(j, i, &block.transpose());
        } else {
            let below = Arc::make_mut(&mut self.below);
            let first = start(i) + 2 * j;
            below[first..first + 2].copy_from_slice(&[block.m11, block.m12]);
            below[first + 2 * i..first + 2 * i + 2].copy_from_slice(&[block.m21, block.m22]);
        }
    }

    /// The two columns of landmark `j`, into vectors of two elements per landmark.
    pub(super) fn columns(&self, j: usize, x: &mut [f64], y: &mut [f64]) {
        let row = &self.below[start(j)..start(j) + 4 * j];
        x[..2 * j].copy_from_slice(&row[..2 * j]);
        y[..2 * j].copy_from_slice(&row[2 * j..]);
        let [xx, xy, yy] = self.diagonal[j];
        x[2 * j..2 * j + 2].copy_from_slice(&[xx, xy]);
        y[2 * j..2 * j + 2].copy_from_slice(&[xy, yy]);
        for i in j + 1..self.len() {
            let first = start(i) + 2 * j;
            let second = first + 2 * i;
            (x[2 * i], y[2 * i]) = (self.below[first], self.below[first + 1]);
            (x[2 * i + 1], y[2 * i + 1]) = (self.below[second], self.below[second + 1]);
        }
    }

    /// Appends a landmark: its rows with all landmarks before it, and its own block.
    pub(super) fn push(&mut self, x: &[f64], y: &[f64], own: &Matrix2<f64>) {
        let below = Arc::make_mut(&mut self.below);
        below.extend_from_slice(x);
        below.extend_from_slice(y);
        self.diagonal.push([own.m11, own.m21, own.m22]);
    }

    /// Keeps the landmarks for which `keep` holds.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        let kept: Vec<usize> = (0..self.len()).filter(|&i| keep[i]).collect();
        let mut below = Vec::with_capacity(start(kept.len()));
        for (count, &i) in kept.iter().enumerate() {
            for row in self.below[start(i)..start(i) + 4 * i].chunks_exact(2 * i.max(1)) {
                let blocks = kept[..count].iter();
                below.extend(blocks.flat_map(|&j| [row[2 * j], row[2 * j + 1]]));
            }
        }
        self.diagonal = kept.iter().map(|&i| self.diagonal[i]).collect();
        self.below = Arc::new(below);
    }

    /// The diagonal blocks after subtracting `sum_k left_k right_k^T`, symmetric by assumption.
    pub(super) fn diagonal_minus(&self, left: &[f64], right: &[f64]) -> Vec<[f64; 3]> {
        let length = 2 * self.len();
        let mut diagonal = self.diagonal.clone();
        if length == 0 {
            return diagonal;
        }
        for (left, right) in left.chunks_exact(length).zip(right.chunks_exact(length)) {
            for (block, k) in diagonal.iter_mut().zip((0..).step_by(2)) {
                block[0] -= left[k] * right[k];
                block[1] -= left[k + 1] * right[k];
                block[2] -= left[k + 1] * right[k + 1];
            }
        }
        diagonal
    }

    /// Subtracts `sum_k left_k right_k^T` below the diagonal, whose new blocks are given.
    pub(super) fn subtract(&mut self, left: &[f64], right: &[f64], diagonal: Vec<[f64; 3]>) {
        let length = 2 * self.len();
        self.diagonal = diagonal;
        let below = Arc::make_mut(&mut self.below).as_mut_slice();
        SubtractProduct { below, left, right, length }.run();
    }
}
