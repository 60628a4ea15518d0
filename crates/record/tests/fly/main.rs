//! Configurations that `fly` accepts and rejects.

mod refusals;
mod settings;
