//! The estimator's use of aids: sensors in addition to the inertial unit and the GPS receiver.

use super::phase::Phase;
use super::{Estimator, Notice};
use crate::ekf::heading_search::HeadingMethod;
use crate::ekf::kernel::layout::Layout;
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::report::{Aid, Report, Unusable};
use crate::ekf::watch::field_watch::{FieldChange, Turn};
use crate::event::{BaroReading, RangeReading};
use crate::frames::{Body, EulerAngles, Rotation, Vector};
use crate::gps::AntennaHeading;
use crate::scalar::Scalar;
use crate::time::Time;

impl<L: Layout<N>, const N: usize, T: Scalar, H: HeadingMethod<T>> Estimator<L, N, T, H> {
    #[inline(never)]
    pub(super) fn attitude(
        &mut self,
        time: Time,
        angles: EulerAngles,
        field_gauss: Option<Vector<Body>>,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        // Checked first: a sample that comes too soon then needs no sines of its angles.
        if angles.is_finite() && !self.filter.is_attitude_due(time) {
            notify(Notice::NotUsed { time, aid: Aid::Attitude, reason: Unusable::TooSoon });
            return;
        }
        if let Some(field) = field_gauss {
            self.watch_field(time, field, trace, notify);
        }
        let yaw_rad = angles.yaw_rad + self.aligner.config().attitude_declination_rad;
        let reference = Rotation::of_angles(EulerAngles { yaw_rad, ..angles });
        let mut report = Report::default();
        let result = self
            .navigating()
            .and_then(|filter| filter.fuse_attitude(time, reference, &mut report, trace));
        self.note_heading(&report);
        notify(Notice::of_report(time, Aid::Attitude, result, &report));
    }

    #[inline(never)]
    pub(super) fn magnetometer(
        &mut self,
        time: Time,
        field_gauss: Vector<Body>,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        if !self.aiding.magnetometer {
            return;
        }
        let checked = self.check_time(time);
        if checked.is_ok() && !self.watch_field(time, field_gauss, trace, notify) {
            let (aid, reason) = (Aid::Magnetometer, Unusable::Outlier);
            notify(Notice::NotUsed { time, aid, reason });
            return;
        }
        let declination_rad = self.aligner.config().declination_rad;
        let result = checked.and_then(|()| self.navigating()).and_then(|filter| {
            filter.update_magnetic_heading(time, field_gauss, declination_rad, trace)
        });
        if let Ok(report) = &result {
            self.note_heading(report);
        }
        notify(Notice::of_update(time, Aid::Magnetometer, result));
    }

    /// Checks whether the magnetic field is usual, before it gives a heading or while the inertial unit's own attitude
    /// depends on it. Returns whether the field can give a heading.
    #[inline(never)]
    pub(super) fn watch_field(
        &mut self,
        time: Time,
        field_gauss: Vector<Body>,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) -> bool {
        let filter = self.navigating().ok();
        let change = filter.and_then(|filter| filter.watch_field(time, field_gauss, trace));
        let Some(FieldChange { share, sigma_rad, turn: Some(turn) }) = change else {
            return true;
        };
        let (share, sigma_rad) = (f64::from(share), f64::from(sigma_rad));
        notify(match turn {
            Turn::Suspect => return false,
            Turn::Away | Turn::Lasting => Notice::MagneticFieldDisturbed {
                time,
                share,
                sigma_rad,
                lasts: turn == Turn::Lasting,
            },
            Turn::Back => Notice::MagneticFieldUsual { time, changed: false },
            Turn::Settled => Notice::MagneticFieldUsual { time, changed: true },
        });
        true
    }

    #[inline(never)]
    pub(super) fn barometer(
        &mut self,
        reading: &BaroReading,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        if !self.aiding.baro {
            return;
        }
        let &BaroReading { time, height_m } = reading;
        let result =
            self.check_time(time).and_then(|()| self.filter.update_baro(time, height_m, trace));
        notify(Notice::of_update(time, Aid::Baro, result));
    }

    #[inline(never)]
    pub(super) fn range(
        &mut self,
        reading: &RangeReading,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        if !self.aiding.rangefinder {
            return;
        }
        let result = self.filter.update_range(reading, &self.rangefinder, trace);
        notify(Notice::of_update(reading.time, Aid::Rangefinder, result));
    }

    /// Fuses a heading of two antennas, which also ends a heading search.
    #[inline(never)]
    pub(super) fn antenna_heading(
        &mut self,
        reading: &AntennaHeading,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        if !self.aiding.second_antenna {
            return;
        }
        let (baseline_m, model) = (self.aligner.config().baseline_m, self.antenna_heading);
        if self.phase == Phase::Searching && model.check_baseline(reading, baseline_m).is_ok() {
            let baseline = baseline_m.unwrap_or(Vector::new(1.0, 0.0, 0.0));
            let search = self.search.bank();
            if let Some(motion) =
                search.and_then(|search| search.motion_at(baseline, reading.heading_rad))
            {
                let min_rad = motion.heading_sigma_rad;
                self.accept_heading(&motion, (reading.time, min_rad), trace, notify);
            }
        }
        let result = self
            .navigating()
            .and_then(|filter| filter.update_antenna_heading(reading, baseline_m, &model, trace));
        if let Ok(report) = &result {
            self.note_heading(report);
        }
        notify(Notice::of_update(reading.time, Aid::SecondAntenna, result));
    }

    /// Updates search and monitor after a measured heading. An accepted heading ends a search that a gap had started.
    /// The monitor restarts if the filter was reset to the heading.
    fn note_heading(&mut self, report: &Report) {
        if self.phase == Phase::Searching && report.any_accepted() {
            self.filter.memory.attitude_lost = None;
            self.phase = Phase::Navigating;
            self.monitor_heading();
        } else if report.any_reset() {
            self.monitor_heading();
        }
    }
}
