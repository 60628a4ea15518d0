//! What inertial samples are as a whole, gathered as they pass.

use crate::distribution::Distribution;
use hovernav::imu::ImuSample;
use hovernav::time::Time;

/// What the samples are as a whole.
#[derive(Clone, Debug, Default)]
pub(crate) struct Overview {
    pub count: usize,
    pub first: Option<ImuSample>,
    pub last: Option<Time>,
    pub with_magnetic_field: usize,
    /// From each to the next, s.
    pub intervals: Distribution,
}

impl Overview {
    pub fn push(&mut self, sample: &ImuSample) {
        self.count += 1;
        self.first.get_or_insert(*sample);
        if let Some(last) = self.last.replace(sample.time) {
            self.intervals.push(sample.time - last);
        }
        self.with_magnetic_field += usize::from(sample.magnetic_field_gauss.is_some());
    }
}
