//! The shipped filter and the oracle side by side: every call goes to both, and both must give the same result.

use hovernav::ekf::layout::Layout;
use hovernav::ekf::{
    AntennaHeadingModel, Ekf, EkfConfig, Learned, Prediction, Rangefinder, Report, ResetCause,
    Unusable, Verdict,
};
use hovernav::event::RangeReading;
use hovernav::frames::{Body, Ned, Rotation, Vector as Framed};
use hovernav::gps::{AntennaHeading, Fix};
use hovernav::imu::ImuSample;
use hovernav::ins::{Mounting, Start};
use hovernav::scalar::Scalar;
use hovernav::time::Time;
use nalgebra::{Quaternion, UnitQuaternion};

use crate::compare::{Differences, Tolerance};
use crate::filter::{Filter, Step};
use crate::mechanization::Vector;
use crate::shipped::{Did, Recorder, Snapshot};
use crate::update::Row;

/// Both filters.
#[derive(Clone, Debug)]
pub struct Pair<L, const N: usize, T = f64> {
    pub shipped: Ekf<L, N, T>,
    pub oracle: Filter<L, N>,
    /// Whether the oracle starts each step from the shipped filter's state, or flies by itself.
    one_step: bool,
    tolerance: Tolerance,
    pub differences: Differences,
    /// Time of the last fused barometric height; before the first, a time earlier than all samples.
    baro_used: Time,
    pub counts: Counts,
}

/// Numbers of events.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    pub samples: usize,
    pub gaps: usize,
    pub resets: usize,
    pub measurements: usize,
    pub axes: usize,
    /// Number of axes that the shipped filter rejected.
    pub rejected: usize,
    /// Number of measurements for which the gates reset the covariance. The oracle then restarts from the shipped
    /// filter's state.
    pub reopened: usize,
}

fn body(v: &Framed<Body>) -> Vector {
    Vector::from(v.to_array())
}

impl<L: Layout<N>, const N: usize, T: Scalar> Pair<L, N, T> {
    pub fn new(
        config: EkfConfig,
        mounting: Mounting,
        start: Start,
        one_step: bool,
        tolerance: Tolerance,
    ) -> Self {
        let shipped = Ekf::new(config, mounting, start);
        let begun = Snapshot::of(&shipped);
        let mut pair = Self {
            shipped,
            oracle: Filter::new(config, mounting, begun.nominal),
            one_step,
            tolerance,
            differences: Differences::default(),
            baro_used: Time::from_nanoseconds(i64::MIN),
            counts: Counts::default(),
        };
        pair.take_over(&begun);
        pair
    }

    /// Copies the shipped filter's state to the oracle.
    fn take_over(&mut self, from: &Snapshot<N>) {
        self.differences.restart(&from.covariance);
        self.oracle.nominal = from.nominal;
        self.oracle.parameters = from.parameters;
        self.oracle.covariance = from.covariance;
    }

    /// Compares both filters. One-step comparisons then copy the shipped filter's state to the oracle.
    fn compare(&mut self, what: &str) {
        let shipped = Snapshot::of(&self.shipped);
        self.differences.of_states(what, &shipped, &self.oracle, &self.tolerance);
        if self.one_step {
            self.take_over(&shipped);
        }
    }

    pub fn predict(&mut self, sample: &ImuSample) {
        let result = self.shipped.predict_traced(sample, &mut Recorder::default());
        // A rejected sample changes nothing.
        let Ok(prediction) = result else { return };
        let learned = self.shipped.learned();
        let step = self.oracle.predict(sample, &learned);
        match prediction {
            Prediction::Stepped => assert_eq!(step, Step::Stepped),
            Prediction::BridgedGap { .. } => {
                assert_eq!(step, Step::Coasted);
                self.counts.gaps += 1;
            }
            Prediction::Reset(ResetCause::LongGap { .. }) => {
                assert_eq!(step, Step::Reset);
                self.oracle.open_heading_reference(&learned);
                self.counts.resets += 1;
            }
            other => panic!("{other:?}: not flown here"),
        }
        self.counts.samples += 1;
        let what = if step == Step::Stepped { "sample" } else { "gap" };
        self.compare(what);
    }

    pub fn fix(&mut self, fix: &Fix) {
        let moments = self.oracle.moments(fix);
        let before = self.shipped.learned();
        let antenna_before = Vector::from(before.antenna.0);
        self.measure(
            "fix",
            |shipped, recorder| shipped.update_gps_traced(fix, recorder),
            |oracle, before| oracle.follow_wander(fix, before),
            true,
            |oracle, after, _| {
                let antenna = [antenna_before, Vector::from(after.antenna.0)];
                let moments = moments.as_ref().expect("looked back");
                oracle.fix_rows(fix, moments, &before, antenna)
            },
        );
    }

    pub fn attitude(&mut self, time: Time, reference: Rotation<Body, Ned>) {
        let reference = reference.cast::<T>();
        let [x, y, z, w] = reference.to_array().map(Scalar::wide);
        let dense = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let since_s = Filter::<L, N>::since_s(time, self.shipped.learned().attitude_used);
        self.measure(
            "attitude",
            |shipped, recorder| shipped.update_attitude(time, reference, recorder),
            |_, _| {},
            false,
            |oracle, after, axes| oracle.attitude_rows(&dense, since_s, after, axes == 3),
        );
    }

    pub fn magnetic(&mut self, time: Time, field: Framed<Body>, declination_rad: f64) {
        self.measure(
            "magnetic field",
            |shipped, recorder| {
                shipped.update_magnetic_heading(time, field, declination_rad, recorder)
            },
            |_, _| {},
            false,
            |oracle, _, _| oracle.magnetic_rows(&body(&field.cast::<T>().cast()), declination_rad),
        );
    }

    pub fn baro(&mut self, time: Time, height_m: f64) {
        let since_s = time - self.baro_used;
        let accepted = self.measure(
            "barometric height",
            |shipped, recorder| shipped.update_baro(time, height_m, recorder),
            |_, _| {},
            false,
            |oracle, after, _| oracle.baro_rows(height_m, since_s, after),
        );
        if accepted {
            self.baro_used = time;
        }
    }

    pub fn range(&mut self, reading: &RangeReading, rangefinder: &Rangefinder) {
        self.measure(
            "range",
            |shipped, recorder| shipped.update_range(reading, rangefinder, recorder),
            |oracle, before| {
                if let Some(state) = L::GROUND.filter(|_| before.ground_height_m.is_none()) {
                    oracle.open(state, 0.0);
                    oracle.parameters[state] = 0.0;
                }
            },
            false,
            |oracle, after, _| oracle.range_rows(reading, rangefinder, after),
        );
    }

    pub fn antenna_heading(
        &mut self,
        reading: &AntennaHeading,
        mounted: Option<Framed<Body>>,
        model: &AntennaHeadingModel,
    ) {
        let baseline_m = mounted.map_or(Vector::x(), |baseline| body(&baseline));
        let used = self.shipped.learned().antenna_heading_used;
        let since_s = Filter::<L, N>::since_s(reading.time, used);
        self.measure(
            "heading of two antennas",
            |shipped, recorder| shipped.update_antenna_heading(reading, mounted, model, recorder),
            |_, _| {},
            false,
            |oracle, _, _| oracle.antenna_heading_rows(reading, &baseline_m, model, since_s),
        );
    }

    pub fn rest(&mut self) {
        let before = self.shipped.learned();
        self.measure(
            "rest",
            |shipped, recorder| shipped.update_at_rest(recorder).ok_or(Unusable::RepeatedReading),
            |_, _| {},
            false,
            |oracle, _, _| oracle.rest_rows(&before),
        );
    }

    /// Passes a measurement to the shipped filter by `call`, repeats the filter's steps with the oracle, and compares
    /// innovations and states. `prepare` increases the oracle's covariance before the measurement. With
    /// `prepares_alone` this replaces the increases by the shipped filter; otherwise both are applied. `rows` gives the
    /// measurement's rows from the quantities learned after it and the number of compared axes. Returns whether any
    /// axis was fused.
    fn measure(
        &mut self,
        what: &str,
        call: impl FnOnce(&mut Ekf<L, N, T>, &mut Recorder<N>) -> Result<Report, Unusable>,
        prepare: impl FnOnce(&mut Filter<L, N>, &Learned),
        prepares_alone: bool,
        rows: impl Fn(&Filter<L, N>, &Learned, usize) -> Vec<Row<N>>,
    ) -> bool {
        let before = self.shipped.learned();
        let mut recorder = Recorder::default();
        let report = call(&mut self.shipped, &mut recorder).unwrap_or_default();
        let after = self.shipped.learned();
        let mut prepare = Some(prepare);
        let turned = recorder.0.iter().any(|did| matches!(did, Did::Turned(_)));
        let (mut measured, mut updates) = (0, 0);
        if report.any_reset() && !turned || report.covariance_was_reset() {
            self.give_way(&recorder, &before, &report);
            return report.any_accepted();
        }
        for did in &recorder.0 {
            if !matches!(did, Did::Propagated | Did::Relaxed)
                && let Some(prepare) = prepare.take()
            {
                prepare(&mut self.oracle, &before);
            }
            match did {
                Did::Propagated => {
                    assert!(self.oracle.pending.is_some(), "{what}: nothing to be propagated");
                    self.oracle.catch_up(&before);
                }
                Did::Relaxed => self.oracle.relax(&before),
                Did::Opened(_) if prepares_alone && measured == 0 => {}
                Did::Opened(opening) => opening.apply(&mut self.oracle),
                Did::Reset(states) => {
                    states.clone().for_each(|state| self.oracle.open(state, 0.5));
                }
                Did::Turned(turn) => {
                    let attitude = &mut self.oracle.nominal.attitude;
                    *attitude = UnitQuaternion::from_scaled_axis(*turn) * *attitude;
                }
                Did::Updated => updates += 1,
                Did::Corrected if measured == 0 => {
                    let axes = report.innovations().count();
                    let rows = rows(&self.oracle, &after, axes);
                    self.compare_axes(what, &rows, &report, turned);
                    (measured, updates) = (1, 0);
                }
                Did::Corrected => {
                    let rows = self.oracle.climb_rows();
                    self.oracle.fuse(&rows, &[updates == 1]);
                }
            }
        }
        if !recorder.0.is_empty() {
            self.compare(what);
        }
        report.any_accepted()
    }

    fn compare_axes(&mut self, what: &str, rows: &[Row<N>], report: &Report, taken: bool) {
        assert_eq!(rows.len(), report.innovations().count(), "{what}: axes");
        let accepted: Vec<bool> =
            report.innovations().map(|axis| axis.verdict != Verdict::Rejected).collect();
        self.counts.measurements += 1;
        self.counts.axes += accepted.len();
        self.counts.rejected += accepted.iter().filter(|accepted| !**accepted).count();
        let compared = self.oracle.fuse(rows, &accepted);
        // For an attitude that replaced the filter's own, the report contains the innovation before the replacement.
        for (shipped, oracle) in report.innovations().zip(&compared).filter(|_| !taken) {
            self.differences.of_innovations(what, shipped, oracle, &self.tolerance);
        }
    }

    /// Handles a reset of the covariance by the gates: the oracle restarts from the shipped filter's state.
    fn give_way(&mut self, recorder: &Recorder<N>, before: &Learned, report: &Report) {
        for did in &recorder.0 {
            match did {
                Did::Propagated => self.oracle.catch_up(before),
                Did::Relaxed => self.oracle.relax(before),
                _ => {}
            }
        }
        if report.covariance_was_reset() {
            self.oracle.reset();
        }
        self.counts.reopened += 1;
        self.take_over(&Snapshot::of(&self.shipped));
    }
}
