//! What inertial samples are as a whole, gathered as they pass.

use crate::clock::Gaps;
use hovernav::imu::ImuSample;

/// What the samples are as a whole.
#[derive(Clone, Debug, Default)]
pub(crate) struct Overview {
    pub count: usize,
    pub first: Option<ImuSample>,
    pub with_magnetic_field: usize,
    /// The time of the last, the intervals from each to the next, and which of them are gaps.
    pub gaps: Gaps,
}

impl Overview {
    pub fn push(&mut self, sample: &ImuSample) {
        self.count += 1;
        self.first.get_or_insert(*sample);
        self.gaps.push(sample.time);
        self.with_magnetic_field += usize::from(sample.magnetic_field_gauss.is_some());
    }
}
