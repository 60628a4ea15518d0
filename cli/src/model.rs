//! What `MODEL` on the command line means.

use std::path::Path;

use hovernav_model::{ModelError, StateSpace, shipped};

/// A shipped model by its name, or else the model of a file.
///
/// # Errors
/// Those of [`StateSpace::read`].
pub fn open(model: &str) -> Result<StateSpace, ModelError> {
    match shipped::by_name(model) {
        Some(model) => Ok(model),
        None => StateSpace::read(Path::new(model)),
    }
}
