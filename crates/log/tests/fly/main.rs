//! What `fly` takes of its configuration, and what it refuses.

mod refusals;
mod settings;
