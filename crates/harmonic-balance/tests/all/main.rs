//! The tests of the public interface, in one program: one file for each subject.

mod common;

mod closed_forms;
mod forced_responses;
mod refusals;
mod stability;
