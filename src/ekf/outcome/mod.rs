//! Outcome of a prediction or an update, as reported to the user.

pub(super) mod group;
pub(super) mod innovation;
pub(super) mod prediction;
pub(super) mod report;
