//! The tests of the public interface, in one program: one file for each subject.

mod interface;
mod mortar;
