//! Phases of an estimator.

/// Progress from the first sample to a navigating filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    Aligning,
    Searching,
    Navigating,
}

/// State of the check of roll and pitch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TiltCheck {
    /// No evidence against roll and pitch.
    Idle,
    /// A second alignment is running.
    Running,
    /// Roll and pitch were wrong, and are searched together with the heading.
    Failed,
}
