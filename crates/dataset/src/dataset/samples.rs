//! The inertial samples of a dataset, from memory or from their file.

use std::borrow::Cow;
use std::slice;

use crate::clock::Gap;
use crate::dataset::Dataset;
use crate::error::LogError;
use crate::sensors::sample_file::{FromFile, Overview};
use hovernav::imu::ImuSample;
use hovernav::time::Time;

/// Iterator over the inertial samples of a dataset.
#[derive(Clone, Debug)]
pub struct Samples<'a>(Where<'a>);

#[derive(Clone, Debug)]
enum Where<'a> {
    Memory(slice::Iter<'a, ImuSample>),
    File(Box<FromFile<'a>>),
}

impl Iterator for Samples<'_> {
    type Item = ImuSample;

    fn next(&mut self) -> Option<ImuSample> {
        match &mut self.0 {
            Where::Memory(samples) => samples.next().copied(),
            Where::File(samples) => samples.next(),
        }
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        match &self.0 {
            Where::Memory(samples) => samples.size_hint(),
            Where::File(samples) => (0, Some(samples.remaining())),
        }
    }
}

impl Dataset {
    /// The inertial samples, in order of time, from memory or from their file. If the file can no longer be read, they
    /// end early, which [`ensure_read`](Self::ensure_read) reports.
    #[must_use]
    pub fn samples(&self) -> Samples<'_> {
        Samples(match &self.imu_file {
            Some(file) => Where::File(Box::new(file.samples())),
            None => Where::Memory(self.imu.iter()),
        })
    }

    /// Number of inertial samples.
    #[must_use]
    pub fn sample_count(&self) -> usize {
        self.imu_file.as_ref().map_or(self.imu.len(), |file| file.overview().count)
    }

    /// Times of the first and the last inertial sample; `None` without samples.
    #[must_use]
    pub fn sample_span(&self) -> Option<(Time, Time)> {
        match &self.imu_file {
            Some(file) => Some((file.overview().first?.time, file.overview().gaps.last?)),
            None => Some((self.imu.first()?.time, self.imu.last()?.time)),
        }
    }

    /// Whether the inertial unit has a magnetometer.
    #[must_use]
    pub fn has_magnetic_samples(&self) -> bool {
        match &self.imu_file {
            Some(file) => file.has_field(),
            None => self.imu.iter().any(|sample| sample.magnetic_field_gauss.is_some()),
        }
    }

    /// Median interval between inertial samples, s; `None` with fewer than two.
    #[must_use]
    pub fn sample_interval_s(&self) -> Option<f64> {
        self.overview().gaps.intervals.quantile(0.5)
    }

    /// Rate of the inertial samples, Hz: the larger of their number over their span and one over their median
    /// interval. `None` with fewer than two samples.
    #[must_use]
    pub fn imu_rate_hz(&self) -> Option<f64> {
        let usual_hz = 1.0 / self.sample_interval_s()?;
        let (first, last) = self.sample_span()?;
        Some(usual_hz.max((self.sample_count() - 1) as f64 / (last - first)))
    }

    /// Gaps between inertial samples: see [`gaps`](crate::gaps).
    #[must_use]
    pub fn sample_gaps(&self) -> Vec<Gap> {
        self.overview().gaps.found()
    }

    /// Checks that every pass over the samples was complete.
    ///
    /// # Errors
    /// The first failure since the dataset was opened or since the last call: the file has changed, or can no longer be
    /// read.
    pub fn ensure_read(&self) -> Result<(), LogError> {
        self.imu_file.as_ref().map_or(Ok(()), |file| file.ensure_read())
    }

    fn overview(&self) -> Cow<'_, Overview> {
        match &self.imu_file {
            Some(file) => Cow::Borrowed(file.overview()),
            None => {
                let mut overview = Overview::default();
                self.imu.iter().for_each(|sample| overview.push(sample));
                Cow::Owned(overview)
            }
        }
    }
}
