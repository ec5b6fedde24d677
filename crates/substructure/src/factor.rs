//! Sparse Cholesky factorisation with nested-dissection ordering and blocked solves.

use crate::Error;
use crate::ordering::nested_dissection;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};
use rayon::prelude::*;
use sprs::CsMat;

/// Right-hand sides solved together: wide enough to run at the speed of dense products, small enough to stay in cache.
pub const BLOCK: usize = 64;

/// `L L^T` of a symmetric positive definite sparse matrix.
pub struct SparseCholesky {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
}

impl std::fmt::Debug for SparseCholesky {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SparseCholesky")
            .field("n", &self.symbolic.nrows())
            .field("entries", &self.values.len())
            .finish()
    }
}

impl SparseCholesky {
    /// Factors `matrix` (full symmetric storage); `positions` (one per row) guide the ordering, `name` is for messages.
    ///
    /// # Errors
    /// [`Error::NotPositiveDefinite`], or [`Error::LinearAlgebra`] if memory runs out.
    pub fn try_new(matrix: &CsMat<f64>, positions: &[[f64; 3]], name: &'static str) -> Result<Self, Error> {
        let size = matrix.rows();
        let fail = |reason: String| Error::LinearAlgebra {
            operation: "sparse Cholesky factorisation",
            size,
            reason,
        };
        let order = nested_dissection(matrix, positions);
        let mut inverse = vec![0; size];
        for (position, &row) in order.iter().enumerate() {
            inverse[row] = position;
        }
        let indptr = matrix.indptr();
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, indptr.raw_storage(), None, matrix.indices());
        let symbolic = factorize_symbolic_cholesky(
            pattern,
            Side::Upper,
            SymmetricOrdering::Custom(PermRef::new_checked(&order, &inverse, size)),
            CholeskySymbolicParams::default(),
        )
        .map_err(|e| fail(format!("{e:?}")))?;
        let mut values = vec![0.0; symbolic.len_val()];
        let par = Par::Seq;
        let scratch = symbolic.factorize_numeric_llt_scratch::<f64>(par, Spec::default());
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| fail("out of memory".into()))?;
        symbolic
            .factorize_numeric_llt(
                &mut values,
                SparseColMatRef::new(pattern, matrix.data()),
                Side::Upper,
                LltRegularization::default(),
                par,
                MemStack::new(&mut memory),
                Spec::default(),
            )
            .map_err(|LltError::NonPositivePivot { index }| Error::NotPositiveDefinite {
                matrix: name,
                pivot: index,
                size,
            })?;
        Ok(Self { symbolic, values })
    }

    /// Number of stored entries of the factor.
    pub fn entries(&self) -> usize {
        self.values.len()
    }

    /// Solves for all columns in place, in parallel over blocks of [`BLOCK`] columns.
    ///
    /// # Panics
    /// If the number of rows differs from that of the factor.
    pub fn solve_in_place(&self, rhs: MatMut<'_, f64>) {
        let solve = |mut block: MatMut<'_, f64>| {
            let scratch = self.symbolic.solve_in_place_scratch::<f64>(block.ncols(), Par::Seq);
            let mut memory = MemBuffer::new(scratch);
            LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
                Conj::No,
                block.as_mut(),
                Par::Seq,
                MemStack::new(&mut memory),
            );
        };
        if rhs.ncols() <= BLOCK {
            solve(rhs);
        } else {
            let blocks: Vec<_> = rhs.par_col_chunks_mut(BLOCK).collect();
            blocks.into_par_iter().for_each(solve);
        }
    }
}
