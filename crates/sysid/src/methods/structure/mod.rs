//! A continuous-time state space whose entries are products of named parameters.
//!
//! A [`Structure`] is written in textbook equations and computes its own derivatives:
//!
//! ```
//! use hovernav_sysid::methods::structure::{Parameter, Structure};
//!
//! let heave = Structure::new(
//!     "heave",
//!     vec![
//!         Parameter::new("Zw", "1/s", -0.5).within(-5.0, 0.5),
//!         Parameter::new("Zcol", "m/s²", -10.0),
//!     ],
//!     "inputs  collective
//!      noise   n_w
//!      outputs w
//!      offsets w
//!      w' = Zw*w + Zcol*collective + n_w",
//! )?;
//! assert_eq!(heave.at(&[-0.6, -14.0]).b[(0, 0)], -14.0);
//! # Ok::<(), hovernav_sysid::methods::structure::StructureError>(())
//! ```

mod equations;
mod error;
mod parametrised;
mod terms;

pub use error::StructureError;
pub use parametrised::Structure;
pub use terms::Parameter;
pub(crate) use terms::Term;
