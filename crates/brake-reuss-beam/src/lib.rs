//! The Brake-Reuss beam benchmark: geometry, block mesh and published data.
