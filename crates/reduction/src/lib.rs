//! Relative interface coordinates, zero-energy modes and Craig-Bampton reduction.
