//! Requests of ground stations on their way.

use std::collections::VecDeque;

/// Bytes received from ground stations, and answers in the queue.
#[derive(Clone, Debug, Default)]
pub(super) struct Requests {
    pub bytes: Vec<u8>,
    pub answers: VecDeque<Vec<u8>>,
}
