//! Settings as plain structures: each mirrors a structure of the core field by field, with the same defaults.

mod aids;

mod notch;

mod estimator;

mod autopilot;

mod gains;

mod lines;

mod mechanisms;

mod vehicle;

use crate::status::Fault;

pub use aids::*;
pub use autopilot::*;
pub use estimator::*;
pub use gains::*;
pub use lines::*;
pub use mechanisms::*;
pub use notch::*;
pub use vehicle::*;

/// Copies the named fields both ways between a structure here and its counterpart in the core.
macro_rules! mirror {
    ($ours:ty, $core:ty { $($field:ident)* }) => {
        impl $ours {
            /// Writes the fields to `into`.
            pub(crate) fn put(&self, into: &mut $core) {
                $(into.$field = self.$field;)*
            }
        }

        impl From<&$core> for $ours {
            fn from(core: &$core) -> Self {
                Self { $($field: core.$field,)* }
            }
        }
    };
}
use mirror;

/// Checks that every named field is finite and within `lowest` to `highest`.
macro_rules! within {
    ($group:literal, $of:expr, $lowest:expr, $highest:expr, $expected:literal; $($field:ident)*) => {
        $(
            let found = $of.$field;
            if !($lowest..=$highest).contains(&found) {
                let what = [concat!($group, stringify!($field))];
                return Err(Fault::new(&what, found, $expected).into());
            }
        )*
    };
}
use within;

fn flag(what: &str, value: u32) -> Result<bool, Fault> {
    match value {
        0 => Ok(false),
        1 => Ok(true),
        other => Err(Fault::new(&[what], f64::from(other), "0 or 1")),
    }
}
