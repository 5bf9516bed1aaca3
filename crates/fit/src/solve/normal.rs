//! Normal equations that may not determine all.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// The least eigenvalue of parameters that can be distinguished, after normalisation.
const TELLS: f64 = 1e-9;
/// Share in an undetermined combination above which a parameter is named.
const NAMED: f64 = 0.2;

/// The solution of normal equations; nothing along what they do not determine.
pub(super) fn solved(normal: &DMatrix<f64>, right: &DVector<f64>) -> DVector<f64> {
    inverse(normal).0 * right
}

/// The inverse of a matrix JᵀJ, and the parameters that J does not tell apart.
pub(super) fn inverse(normal: &DMatrix<f64>) -> (DMatrix<f64>, Vec<usize>) {
    let scales = normal.diagonal().map(|diagonal| if diagonal > 0.0 { 1.0 / diagonal.sqrt() } else { 0.0 });
    let scaled = |matrix: &DMatrix<f64>| DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] * scales[i] * scales[j]);
    let (inverse, weak) = pseudo_inverse(scaled(normal));
    (scaled(&inverse), weak)
}

/// The inverse of a symmetric matrix with ones on its diagonal, and the rows that take part in what it does not determine.
fn pseudo_inverse(matrix: DMatrix<f64>) -> (DMatrix<f64>, Vec<usize>) {
    let count = matrix.nrows();
    if count == 0 {
        return (matrix, Vec::new());
    }
    let eigen = SymmetricEigen::new(matrix);
    let mut inverse = DMatrix::zeros(count, count);
    let mut weak = Vec::new();
    for (value, vector) in eigen.eigenvalues.iter().zip(eigen.eigenvectors.column_iter()) {
        if *value > TELLS {
            inverse += vector * vector.transpose() / *value;
        } else {
            weak.extend((0..count).filter(|i| vector[*i].abs() > NAMED));
        }
    }
    weak.sort_unstable();
    weak.dedup();
    (inverse, weak)
}
