//! Strapdown inertial navigation: increments in, position, velocity and attitude out.

mod alignment;
mod increments;
mod lever_arm;
mod mechanization;
mod mounting;

pub(crate) use alignment::{ALIGNABLE_S, UNKNOWN_HEIGHT_M};
pub use alignment::{Aligner, Alignment, AlignmentConfig, HeadingSource, Start};
// The parts of the strapdown mechanization, public for tests and benchmarks.
#[doc(hidden)]
pub use increments::{Increment, Integrator};
pub use lever_arm::LeverArm;
#[doc(hidden)]
pub use mechanization::Advance;
pub use mechanization::NavState;
pub use mounting::Mounting;
