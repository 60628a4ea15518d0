//! Output of the filter: solution, solution without steps, smoother, learned quantities.

pub(super) mod learned;
#[cfg(feature = "alloc")]
pub(super) mod smoother;
pub(super) mod solution;
pub(super) mod stepless;
