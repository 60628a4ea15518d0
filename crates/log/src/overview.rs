//! Statistics of inertial samples, gathered sample by sample.

use crate::clock::Gaps;
use hovernav::imu::ImuSample;

/// Statistics of the samples.
#[derive(Clone, Debug, Default)]
pub(crate) struct Overview {
    pub count: usize,
    pub first: Option<ImuSample>,
    pub with_magnetic_field: usize,
    /// Time of the last sample, intervals between samples, and gaps.
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
