//! Alignment, the events that it ignores, and the start of the filter: at a given heading, or at one from a search.

use super::lost_heading::open_about;
use super::phase::Phase;
use super::{Estimator, Notice};
use crate::ekf::heading_search::HeadingMethod;
use crate::ekf::kernel::layout::Layout;
use crate::ekf::outcome::prediction::ImuFault;
use crate::ekf::outcome::report::{Aid, Unusable};
use crate::event::Event;
use crate::ins::{ALIGNABLE_S, Alignment, HeadingSource, Start};
use crate::scalar::Scalar;

impl<L: Layout<N>, const N: usize, T: Scalar, H: HeadingMethod<T>> Estimator<L, N, T, H> {
    /// Reports the events that the alignment ignores and why: impossible readings, and fixes with a time far from that
    /// of the samples. A reading before the first samples is no fault.
    #[inline(never)]
    pub(super) fn report_ignored(&self, event: &Event, notify: &mut dyn FnMut(Notice)) {
        let time = event.time();
        let (aid, reason) = match event {
            Event::Imu(sample) => {
                let fault = match sample.motion.is_finite() {
                    false => Some(ImuFault::NotFinite),
                    true => self.aligner.is_late(time).then_some(ImuFault::NotLater),
                };
                if let Some(fault) = fault {
                    notify(Notice::SampleRejected { time, fault });
                }
                return;
            }
            Event::Gps(fix) => {
                let reason = match self.aligner.age_s(fix) {
                    _ if !fix.is_finite() => Unusable::NotFinite,
                    Some(age_s) if age_s > ALIGNABLE_S => Unusable::TooOld,
                    Some(age_s) if age_s < -ALIGNABLE_S => Unusable::AheadOfImu,
                    _ => return,
                };
                (Aid::Gps, reason)
            }
            other => {
                let aiding = &self.aiding;
                let (aid, is_used, is_possible) = match other {
                    Event::Baro(reading) if L::BARO.is_some() => {
                        (Aid::Baro, aiding.baro, reading.is_possible())
                    }
                    Event::Magnetometer(reading) => {
                        (Aid::Magnetometer, aiding.magnetometer, reading.field_gauss.is_finite())
                    }
                    Event::AntennaHeading(heading) => {
                        (Aid::SecondAntenna, aiding.second_antenna, heading.is_finite())
                    }
                    Event::Range(reading) if L::GROUND.is_some() => {
                        (Aid::Rangefinder, aiding.rangefinder, reading.is_possible())
                    }
                    _ => return,
                };
                if !is_used || is_possible {
                    return;
                }
                (aid, Unusable::NotFinite)
            }
        };
        notify(Notice::NotUsed { time, aid, reason });
    }

    #[inline(never)]
    pub(super) fn begin(&mut self, alignment: &Alignment, notify: &mut dyn FnMut(Notice)) {
        if alignment.heading != HeadingSource::Unknown {
            self.begin_at(&alignment.start);
        } else if H::SEARCHES {
            self.begin_at(&open_about(alignment.start, alignment.axis));
            self.search_all(&alignment.start, alignment.axis);
        } else {
            notify(Notice::HeadingMissing { time: alignment.start.state.time });
            return;
        }
        notify(Notice::Aligned(*alignment));
    }

    /// Starts the filter at a given state, without alignment and without heading search. Example: a second run over a
    /// log, with results of the first run.
    pub fn begin_at(&mut self, start: &Start) {
        self.filter.restart(start);
        self.wheels.forget();
        self.phase = Phase::Navigating;
        self.monitor_heading();
    }
}
