//! The whole estimator: alignment, the search for a heading, and the filter, behind one call.

use super::estimator_config::EstimatorConfig;
use super::filter::Ekf;
use super::heading_search::HeadingSearch;
use super::layout::{Full, Layout};
use super::measurement::{Aid, Report, Unusable};
use super::prediction::{ImuFault, Prediction, ResetCause};
use super::scalar::Scalar;
use super::solution::Solution;
use super::trace::Trace;
use crate::event::Event;
use crate::frames::{Body, EulerAngles, Rotation, Vector};
use crate::gps::Fix;
use crate::imu::ImuSample;
use crate::ins::{Aligner, Alignment, HeadingSource, Start};
use crate::time::Time;

/// Something worth telling that came of an event.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Notice {
    /// Alignment ended; the first solution is there.
    Aligned(Alignment),
    /// The heading, unknown at the start, is found.
    HeadingFound {
        /// When.
        time: Time,
        /// Which sector of the search won: see [`HeadingSearch::leader`].
        sector: usize,
        /// One-sigma of the heading, rad.
        sigma_rad: f64,
    },
    /// A measurement was compared: accepted, refused or reopened, axis by axis.
    Updated(Report),
    /// A measurement could not be compared at all. An aid that the configuration leaves out is not
    /// told of.
    NotUsed {
        /// When the measurement was true.
        time: Time,
        /// What was measured.
        aid: Aid,
        /// Why it was not used: see [`Unusable::is_fault`].
        reason: Unusable,
    },
    /// An inertial sample ended a gap, which was bridged.
    GapBridged {
        /// The sample's time.
        time: Time,
        /// Length of the gap, s.
        length_s: f64,
    },
    /// An inertial sample led to a reset of the covariance.
    CovarianceReset {
        /// The sample's time.
        time: Time,
        /// Why.
        cause: ResetCause,
    },
    /// An inertial sample was refused.
    SampleRefused {
        /// The sample's time.
        time: Time,
        /// Why.
        fault: ImuFault,
    },
}

impl Notice {
    fn of_update(time: Time, aid: Aid, result: Result<Report, Unusable>) -> Self {
        match result {
            Ok(report) => Self::Updated(report),
            Err(reason) => Self::NotUsed { time, aid, reason },
        }
    }
}

/// From events to solutions: aligns, searches the heading where it must, then filters.
#[derive(Clone, Debug)]
pub struct Estimator<L = Full, const N: usize = 26, T = f64> {
    config: EstimatorConfig,
    phase: Phase<L, N, T>,
    held: [Option<Fix>; HELD],
}

#[derive(Clone, Debug)]
// The phases follow each other in one place; boxing the large one would need an allocator.
#[allow(clippy::large_enum_variant)]
enum Phase<L, const N: usize, T> {
    Aligning(Aligner),
    Searching(HeadingSearch),
    Navigating(Ekf<L, N, T>),
}

/// Least one-sigma of a heading just found, rad (10°): the sectors share what their model lacks.
const FOUND_SIGMA_RAD: f64 = 0.175;

/// A fix further ahead of the inertial samples than this, s, is from another clock.
const HELD_S: f64 = 10.0;
/// Fixes that may wait for the inertial sample after them.
const HELD: usize = 4;

impl<L: Layout<N>, const N: usize, T: Scalar> Estimator<L, N, T> {
    /// An estimator that has seen nothing yet.
    #[must_use]
    pub fn new(config: EstimatorConfig) -> Self {
        let phase = Phase::Aligning(Aligner::new(config.alignment, config.mounting));
        Self { config, phase, held: [None; HELD] }
    }

    /// Takes in the next event in order of arrival; `notify` hears what came of it.
    ///
    /// A fix later than the last inertial sample waits for the sample after it.
    pub fn push(&mut self, event: &Event, notify: impl FnMut(Notice)) {
        self.push_traced(event, &mut (), notify);
    }

    /// [`push`](Self::push), the filter watched by `trace`.
    pub fn push_traced(
        &mut self,
        event: &Event,
        trace: &mut impl Trace<T, N>,
        mut notify: impl FnMut(Notice),
    ) {
        if let Phase::Aligning(aligner) = &mut self.phase {
            if let Some(alignment) = aligner.push(event) {
                self.begin(&alignment);
                notify(Notice::Aligned(alignment));
            }
            return;
        }
        match event {
            Event::Imu(sample) => self.imu(sample, trace, &mut notify),
            Event::Gps(fix) => {
                if fix.time > self.time() {
                    self.hold(fix, &mut notify);
                } else {
                    self.gps(fix, trace, &mut notify);
                }
            }
            Event::Baro { time, height_m } => {
                if self.config.aiding.baro {
                    let result = match &mut self.phase {
                        Phase::Navigating(filter) => filter.update_baro(*time, *height_m, trace),
                        _ => Err(Unusable::HeadingUnknown),
                    };
                    notify(Notice::of_update(*time, Aid::Baro, result));
                }
            }
            Event::Magnetometer { time, field_gauss } => {
                self.magnetometer(*time, *field_gauss, trace, &mut notify);
            }
        }
    }

    fn begin(&mut self, alignment: &Alignment) {
        self.phase = if alignment.heading == HeadingSource::Unknown {
            Phase::Searching(HeadingSearch::new(
                self.config.ekf,
                self.config.mounting,
                alignment.start,
            ))
        } else {
            Phase::Navigating(Ekf::new(self.config.ekf, self.config.mounting, alignment.start))
        };
    }

    /// Starts the filter at a given state, without an alignment or a search of its own: to go over
    /// a log again with what was found out later.
    pub fn begin_at(&mut self, start: &Start) {
        self.phase = Phase::Navigating(Ekf::new(self.config.ekf, self.config.mounting, *start));
    }

    fn hold(&mut self, fix: &Fix, notify: &mut impl FnMut(Notice)) {
        let time = self.time();
        match self.held.iter_mut().find(|slot| slot.is_none() && fix.time - time <= HELD_S) {
            Some(slot) => *slot = Some(*fix),
            None => notify(Notice::NotUsed {
                time: fix.time,
                aid: Aid::Gps,
                reason: Unusable::AheadOfImu,
            }),
        }
    }

    fn imu(
        &mut self,
        sample: &ImuSample,
        trace: &mut impl Trace<T, N>,
        notify: &mut impl FnMut(Notice),
    ) {
        let result = match &mut self.phase {
            Phase::Aligning(_) => return,
            Phase::Searching(search) => search.predict(sample),
            Phase::Navigating(filter) => filter.predict_traced(sample, trace),
        };
        let time = sample.time;
        match result {
            Ok(Prediction::Stepped) => {}
            Ok(Prediction::BridgedGap { length_s }) => {
                notify(Notice::GapBridged { time, length_s });
            }
            Ok(Prediction::Reset(cause)) => notify(Notice::CovarianceReset { time, cause }),
            Err(fault) => {
                notify(Notice::SampleRefused { time, fault });
                return;
            }
        }
        for slot in 0..HELD {
            let due = self.held.get(slot).copied().flatten().filter(|fix| fix.time <= sample.time);
            if let Some(fix) = due {
                if let Some(slot) = self.held.get_mut(slot) {
                    *slot = None;
                }
                self.gps(&fix, trace, notify);
            }
        }
        if let Some(angles) = sample.attitude.filter(|_| self.config.aiding.attitude) {
            self.attitude(sample.time, angles, trace, notify);
        } else if let Some(field) = sample.magnetic_field_gauss {
            self.magnetometer(sample.time, field, trace, notify);
        }
    }

    fn gps(&mut self, fix: &Fix, trace: &mut impl Trace<T, N>, notify: &mut impl FnMut(Notice)) {
        let result = match &mut self.phase {
            Phase::Aligning(_) => return,
            Phase::Searching(search) => search.update_gps(fix),
            Phase::Navigating(filter) => filter.update_gps_traced(fix, trace),
        };
        notify(Notice::of_update(fix.time, Aid::Gps, result));
        if let Phase::Searching(search) = &self.phase
            && let Some(found) = search.found()
        {
            let (sector, sigma_rad) = (search.leader(), search.heading_sigma_rad());
            let mut filter = found.grown();
            filter.open_heading(FOUND_SIGMA_RAD);
            self.phase = Phase::Navigating(filter);
            notify(Notice::HeadingFound { time: fix.time, sector, sigma_rad });
        }
    }

    fn attitude(
        &mut self,
        time: Time,
        angles: EulerAngles,
        trace: &mut impl Trace<T, N>,
        notify: &mut impl FnMut(Notice),
    ) {
        let yaw_rad = angles.yaw_rad + self.config.alignment.attitude_declination_rad;
        let reference = Rotation::from_euler(EulerAngles { yaw_rad, ..angles });
        let result = match &mut self.phase {
            Phase::Navigating(filter) => filter.update_attitude(time, reference, trace),
            _ => Err(Unusable::HeadingUnknown),
        };
        notify(Notice::of_update(time, Aid::Attitude, result));
    }

    fn magnetometer(
        &mut self,
        time: Time,
        field_gauss: Vector<Body>,
        trace: &mut impl Trace<T, N>,
        notify: &mut impl FnMut(Notice),
    ) {
        if !self.config.aiding.magnetometer {
            return;
        }
        let declination_rad = self.config.alignment.declination_rad;
        let result = match &mut self.phase {
            Phase::Navigating(filter) => {
                filter.update_magnetic_heading(time, field_gauss, declination_rad, trace)
            }
            _ => Err(Unusable::HeadingUnknown),
        };
        notify(Notice::of_update(time, Aid::Magnetometer, result));
    }

    /// The filter, once alignment and the search for a heading are over.
    #[must_use]
    pub const fn filter(&self) -> Option<&Ekf<L, N, T>> {
        match &self.phase {
            Phase::Navigating(filter) => Some(filter),
            _ => None,
        }
    }

    /// The solution now; `None` until alignment ends.
    #[must_use]
    pub fn solution(&self) -> Option<Solution> {
        match &self.phase {
            Phase::Aligning(_) => None,
            Phase::Searching(search) => search.solution(),
            Phase::Navigating(filter) => Some(filter.solution()),
        }
    }

    fn time(&self) -> Time {
        match &self.phase {
            Phase::Aligning(_) => Time::ZERO,
            Phase::Searching(search) => search.time(),
            Phase::Navigating(filter) => filter.state().time,
        }
    }
}
