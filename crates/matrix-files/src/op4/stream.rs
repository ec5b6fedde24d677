//! What the text and the binary encoding have in common.

use crate::Error;
use crate::columns::{Header, Position};

/// The records of a file one after another.
pub(super) trait Stream: Position {
    /// Bytes read so far.
    fn at(&self) -> usize;

    /// The next matrix, if there is one.
    fn header(&mut self) -> Result<Option<Header>, Error>;

    /// Column, first row and number of words of the next column.
    fn column(&mut self) -> Result<[usize; 3], Error>;

    /// The integers ahead of a string.
    fn string<const N: usize>(&mut self) -> Result<[usize; N], Error>;

    /// Words that a number counts as, in a dense column or in a sparse one.
    fn words(&self, is_double: bool, is_dense: bool) -> usize;

    /// The next numbers, appended to `values`.
    fn numbers(&mut self, count: usize, is_double: bool, values: &mut Vec<f64>) -> Result<(), Error>;

    /// The end of a column.
    fn finish(&mut self) -> Result<(), Error>;
}
