//! Single contacts and what happens at them beside friction: Hertz, Mindlin, adhesion and onset of yield.

pub mod adhesion;
pub mod hertz;
pub mod mindlin;
