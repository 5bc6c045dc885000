//! What the benches share: reproducible balls, meshes and pairs, a clock, and interleaved timing.
//!
//! | run | measures |
//! |---|---|
//! | `cargo run --release -p fieldstone-bench --bin pairs` | nanoseconds per partially overlapping pair, kernel against decomposition |
//! | `cargo run --release -p fieldstone-bench --bin jobs` | whole jobs: balls in meshes, 1 and 2 threads |
//! | `cargo run --release -p fieldstone-bench --bin fields` | coarse graining: the 29 standard fields on grids |
//! | `cargo run --release -p fieldstone-bench --bin flow` | fluid-particle-steps per second of a dam break, 1 and 2 threads |
//! | `cargo bench -p fieldstone-bench` | the same operations under criterion, to compare two versions of the code |
//!
//! Times on a shared machine wander by tens of percent, so the binaries take turns between the rivals and
//! report the median over the turns of the *ratio*, which wanders far less.

mod arithmetic;
mod clock;
mod interleaved;
mod jobs;
mod packing;
mod pairs;

pub use arithmetic::arithmetic_seconds;
pub use clock::{process_seconds, thread_seconds};
pub use interleaved::{median, take_turns};
pub use jobs::{box_of_hexahedra, random_balls};
pub use packing::Packing;
pub use pairs::{Pairs, Shape};
