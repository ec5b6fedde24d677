//! The tests of the public interface, in one program: one file for each subject.

mod files_of_others;
mod nastran;
mod refusals;
mod round_trips;
