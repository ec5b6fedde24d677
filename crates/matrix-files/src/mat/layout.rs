//! Numbers of the format: types and classes of elements.

pub(super) const INT8: u32 = 1;
pub(super) const UINT8: u32 = 2;
pub(super) const INT16: u32 = 3;
pub(super) const UINT16: u32 = 4;
pub(super) const INT32: u32 = 5;
pub(super) const UINT32: u32 = 6;
pub(super) const SINGLE: u32 = 7;
pub(super) const DOUBLE: u32 = 9;
pub(super) const INT64: u32 = 12;
pub(super) const UINT64: u32 = 13;
pub(super) const MATRIX: u32 = 14;
pub(super) const COMPRESSED: u32 = 15;
pub(super) const UTF8: u32 = 16;
pub(super) const UTF16: u32 = 17;

pub(super) const CELL_CLASS: u32 = 1;
pub(super) const STRUCT_CLASS: u32 = 2;
pub(super) const CHAR_CLASS: u32 = 4;
pub(super) const SPARSE_CLASS: u32 = 5;
pub(super) const DOUBLE_CLASS: u32 = 6;
pub(super) const SINGLE_CLASS: u32 = 7;
pub(super) const INT64_CLASS: u32 = 14;
pub(super) const OPAQUE_CLASS: u32 = 17;

pub(super) const COMPLEX: u32 = 0x800;

/// Longest name, MATLAB's `namelengthmax`.
pub(super) const NAME_LENGTH: usize = 63;
/// Structures inside one another.
pub(super) const DEPTH: usize = 8;
