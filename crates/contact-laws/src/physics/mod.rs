//! Asperities and what happens at them beside friction: single contacts (Hertz, Mindlin), populations, distributions of
//! heights, adhesion, yield and what limits tangential forces.

pub mod adhesion;
pub(crate) mod bins;
pub mod elastic_plastic;
pub(crate) mod heights;
pub mod hertz;
pub mod mindlin;
pub(crate) mod population;
pub(crate) mod sliding_yield;
pub mod slip_limit;
