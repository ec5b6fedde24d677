//! The tests of the public interface, in one program: one file for each subject.

mod files_of_others;
mod filter;
mod identification;
mod refusals;
mod stepped_sine;
mod swept_sine;
