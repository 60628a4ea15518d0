//! Validation.
mod fit;
pub use fit::fit_percent;
