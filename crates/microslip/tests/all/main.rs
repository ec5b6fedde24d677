//! The tests of the public interface, in one program: one file for each subject.

mod common;
mod inputs;

mod book;
mod commands;
mod compare;
mod elements;
mod faults;
mod fields;
mod forced;
mod input_files;
mod instruction_sets;
mod limits;
mod messages;
mod new;
mod plot;
mod progress;
mod reference;
mod report;
mod results;
mod scenes;
mod study;
mod web;

/// The program that they run.
const PROGRAM: &str = env!("CARGO_BIN_EXE_microslip");
