//! The tests of the public interface, in one program: one file for each subject.

mod brake_reuss_interface;
mod ensemble;
mod evolution;
mod finish;
mod random_surfaces;
mod readings;
mod scan_files;
mod scan_refusals;
