//! Prestress, linearised modes and coupled quasi-static modal analysis of hysteretic systems.
