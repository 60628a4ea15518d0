//! Files, output and errors of the subcommands, as a user runs them.

#[cfg(feature = "lab")]
mod ablate;
#[cfg(feature = "lab")]
mod campaign;
mod command;
mod common;
#[cfg(feature = "lab")]
mod control;
mod features;
#[cfg(feature = "lab")]
mod forward;
mod full_disk;
#[cfg(all(feature = "ground", feature = "lines", target_os = "linux"))]
mod ground;
#[cfg(feature = "lab")]
mod identify;
#[cfg(feature = "lab")]
mod inject;
#[cfg(all(feature = "lines", unix))]
mod lines;
mod long_logs;
mod manners;
mod mavlink;
mod play;
mod record;
#[cfg(feature = "lab")]
mod robustness;
mod signals;
#[cfg(feature = "export")]
mod trajectories;
mod validate;
