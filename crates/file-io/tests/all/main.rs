//! The tests of the public interface, in one program: one file for each subject.

mod durable;
mod input;
