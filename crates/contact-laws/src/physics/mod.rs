//! Asperities and what happens at them beside friction: single contacts (Hertz, Mindlin), populations, distributions of
//! heights, adhesion and onset of yield.

pub mod adhesion;
pub(crate) mod heights;
pub mod hertz;
pub mod mindlin;
pub(crate) mod population;
