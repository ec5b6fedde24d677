#![doc = include_str!("../README.md")]

pub mod benchmarks;
mod error;
mod folders;
mod given_scene;
mod memory;
pub mod provenance;
mod stage_times;
mod token;

pub use benchmarks::BENCHMARKS;
pub use error::{Error, with_causes};
pub use folders::{results_of, user_cache};
pub use given_scene::GivenScene;
pub use memory::{forget_peak_memory, free_memory, peak_memory};
pub use stage_times::StageTimes;
pub use token::token;
