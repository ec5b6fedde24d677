//! The tests of the public interface, in one program: one file for each subject.

mod bolt;
mod mesh;
mod published;
mod vibration;
