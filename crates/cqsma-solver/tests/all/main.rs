//! The tests of the public interface, in one program: one file for each subject.

mod exact_answers;
mod frictional_bar;
mod methods;
mod random;
mod robustness;
mod sensitivity;
mod transient;
