//! Events in a log and in a run over it, each with a sentence and its time.
//!
//! Inputs are the sensors' readings and the estimator's notices. Nothing is estimated again except for
//! [`alternative`], and no reference is read.

mod absent;
mod accelerations;
mod barometer;
mod contradiction;
mod course;
mod ends;
mod fixes;
mod gates;
mod ground;
mod heading;
mod inertial;
mod judged;
mod lever_arm;
mod slow;
mod smoothing;
pub(crate) mod spans;
mod steps;
mod timing;
mod understated;
mod unused;
mod walk;
mod wheels;

use hovernav::imu::ImuSample;

use crate::finding::{Finding, FindingKind, Sensor, SetupFinding};
use crate::plausibility::{SetupLook, alternative};
use crate::rates::with_rates;
use hovernav_dataset::Dataset;
use hovernav_replay::Run;

use absent::OfUnit;
use accelerations::MeasuredVelocity;
use ends::Ends;
use heading::FieldStrength;
use inertial::Inertial;
use judged::Judged;
use steps::Witness;

/// Events in a `run` over `dataset`, in order of time, each a span with a sentence. Kinds are outages, gaps,
/// rejections, repetitions, clipping, shocks, disturbances, and likely errors of the set-up.
///
/// If the fixes are inconsistent with the run, a part of it is run again with other set-ups: see [`alternative`].
#[must_use]
pub fn findings(dataset: &Dataset, run: &Run) -> Vec<Finding> {
    let (mut findings, setup) = events_and_setup(dataset, run);
    // Only correct axes and signs show an offset of the clocks.
    let is_apart = setup.iter().any(|found| found.sensor == Sensor::Clocks);
    let other = if is_apart { None } else { alternative(dataset, &run.config, run) };
    if is_apart || other.is_some() {
        // Consequences of a wrong attitude.
        use FindingKind::{LeverArm, TimeOffset};
        findings.retain(|found| !matches!(found.kind, LeverArm | TimeOffset));
    }
    let setup = setup.into_iter().chain(other);
    let (start_s, end_s) = Judged { dataset, run }.span_s().unwrap_or_default();
    findings.extend(setup.map(|found| found.finding(start_s, end_s)));
    findings.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    findings
}

/// Events in a `run` over `dataset`, in order of time. The second value has the errors of the set-up that need no
/// further run.
pub(crate) fn events_and_setup(dataset: &Dataset, run: &Run) -> (Vec<Finding>, Vec<SetupFinding>) {
    let log = Judged { dataset, run };
    let Looked { inertial, ends, field, witness, measured, setup, of_unit } = Looked::at(&log);
    let mut findings = Vec::new();
    inertial::find(&log, inertial, ends, &mut findings);
    fixes::find(&log, &mut findings);
    absent::find(&log, of_unit, &mut findings);
    barometer::find(&log, &mut findings);
    gates::find(&log, &mut findings);
    ground::find(&log, &mut findings);
    heading::find(&log, field, &mut findings);
    slow::find(&log, &mut findings);
    steps::find(&log, witness, &mut findings);
    let apart = timing::find(&log, &measured, &mut findings);
    lever_arm::find(&log, &mut findings);
    understated::find(&log, &mut findings);
    unused::find(&log, &mut findings);
    contradiction::find(&log, &mut findings);
    walk::find(&log, &mut findings);
    wheels::find(&log, &mut findings);
    findings.sort_by(|a, b| a.start_s.total_cmp(&b.start_s));
    let mut setup = setup.check(dataset);
    setup.extend(apart);
    setup.extend(course::find(&log));
    (findings, setup)
}

/// Results of one or two passes over the inertial samples.
struct Looked {
    inertial: Inertial,
    ends: Ends,
    field: FieldStrength,
    witness: Witness,
    measured: MeasuredVelocity,
    setup: SetupLook,
    of_unit: OfUnit,
}

impl Looked {
    fn at(log: &Judged<'_>) -> Self {
        let (mut inertial, mut ends) = (Inertial::of(log), Ends::of(log));
        let (mut field, mut witness) = (FieldStrength::default(), Witness::default());
        let (mut measured, mut setup) = (MeasuredVelocity::default(), SetupLook::default());
        let mut of_unit = OfUnit::default();
        let (dataset, apart) = (log.dataset, &log.dataset.magnetometer);
        let own = |sample: &ImuSample| sample.magnetic_field_gauss.filter(|_| apart.is_empty());
        for (sample, rates) in with_rates(dataset.samples()) {
            setup.push(&sample, rates.as_ref());
            of_unit.push(&sample);
            if let Some(field_gauss) = own(&sample) {
                field.look(field_gauss);
            }
            if let Some(rates) = rates {
                inertial.push(&rates);
                ends.look(&rates);
                witness.push(log, &rates, sample.attitude);
                measured.push(&rates);
            }
        }
        apart.iter().for_each(|(_, field_gauss)| field.look(*field_gauss));
        let (is_clipped, is_disturbed) = (ends.looked(), field.looked());
        if is_clipped || is_disturbed {
            for (sample, rates) in with_rates(dataset.samples()) {
                if let Some(field_gauss) = own(&sample) {
                    field.look_again(sample.time, field_gauss);
                }
                if let Some(rates) = rates {
                    ends.look_again(&rates);
                }
            }
            apart.iter().for_each(|(time, field_gauss)| field.look_again(*time, *field_gauss));
        }
        Self { inertial, ends, field, witness, measured, setup, of_unit }
    }
}
