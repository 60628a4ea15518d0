//! Clock errors between inertial samples and fixes: time offset and clock rate.

use super::accelerations::{MeasuredVelocity, reported_changes};
use super::judged::Judged;
use crate::finding::{Finding, FindingKind, Sensor, SetupFinding, Severity};
use hovernav_dataset::LONGEST_LATENCY_S;
use hovernav_replay::FixTally;

/// Largest time offset of the fixes, s, that needs no declaration; a larger one is a warning.
const OFFSET_S: f64 = 0.1;
/// Range of the time offsets that the filter can estimate, s.
const FOLLOWED_S: std::ops::RangeInclusive<f64> = -0.28..=0.45;
/// Fraction of rejected fixes from which on the filter's estimate of the offset is not used.
const MANY_REJECTED: f64 = 0.1;
/// Smallest offset that is used if it comes from the accelerations, s.
const FAR_S: f64 = 0.25;
/// Difference from the filter's estimate, s, beyond which the offset according to the accelerations replaces it.
const AGREES_S: f64 = 0.1;
/// Fraction of the velocity changes that the filter's offset must explain to be used.
const UNEXPLAINED: f64 = 0.1;
/// Lead of GPS time over UTC, s.
const LEAP_SECONDS: f64 = 18.0;
/// Largest distance from [`LEAP_SECONDS`], s: the latency of a receiver.
const LEAP_WITHIN_S: f64 = 0.6;

/// Adds the clock errors of a run to `findings`. The result is an offset beyond the filter's range, the cause of others.
pub(super) fn find(
    log: &Judged<'_>,
    measured: &MeasuredVelocity,
    findings: &mut Vec<Finding>,
) -> Option<SetupFinding> {
    let (start_s, end_s) = log.span_s()?;
    let reported = reported_changes(&log.dataset.fixes);
    if let Some(drift) = measured.drift(&reported) {
        let percent = 100.0 * drift.abs();
        let fast = if drift < 0.0 { "fast" } else { "slow" };
        let words = format!(
            "inertial unit: its clock runs {percent:.2} % {fast} against the clock of the fixes, by their \
             accelerations: rates, forces and the times of all fixes are off; stamp samples with a correct clock, \
             not by counting them"
        );
        findings.push(Finding::warning(
            Sensor::InertialUnit,
            FindingKind::ClockRate,
            (start_s, end_s),
            words,
        ));
        // A growing delay cannot be declared.
        return None;
    }
    let FixTally { used, rejected } = log.run.fixes_compared;
    // Without significant accelerations no offset is rejected.
    let is_unexplained = |offset_s: f64| {
        measured
            .explained(&reported, |_| offset_s)
            .is_some_and(|found| found.fraction < UNEXPLAINED)
    };
    let is_trusted = |offset_s: f64| {
        FOLLOWED_S.contains(&offset_s)
            && (rejected as f64) < MANY_REJECTED * (used + rejected) as f64
            && !is_unexplained(offset_s)
    };
    let declared_s = log.dataset.manifest.gps.latency_s;
    let own_s = log.run.gps_offset.map(|(offset_s, _)| offset_s).filter(|&own_s| is_trusted(own_s));
    let far_s = measured.delay_s(&reported).filter(|far_s| {
        far_s.abs() > FAR_S && own_s.is_none_or(|own_s| (far_s - own_s).abs() > AGREES_S)
    });
    if let Some(far_s) = far_s {
        return Some(far(declared_s, far_s));
    }
    let (offset_s, sigma_s) = log.run.gps_offset?;
    let is_off = offset_s.abs() > OFFSET_S && offset_s.abs() > 4.0 * sigma_s;
    let side = side(declared_s + offset_s);
    let declared = format!("declared latency {declared_s:.3} s");
    let what = if is_off && !is_trusted(offset_s) {
        format!(
            "fixes may be valid at other times than their time stamps: the filter found {side}, {declared}, which is \
             beyond its range, or from fixes of which it rejected many; check the clocks"
        )
    } else {
        let mend =
            if is_off { format!("; {}", mend(declared_s + offset_s)) } else { String::new() };
        format!("fixes are valid {side} (one-sigma {sigma_s:.3} s), {declared}{mend}")
    };
    findings.push(
        Finding::warning(
            Sensor::Gps,
            FindingKind::TimeOffset,
            (start_s, end_s),
            format!("gps time offset: {what}"),
        )
        .severity(if is_off { Severity::Warning } else { Severity::Info }),
    );
    None
}

/// Error of the clocks by `offset_s`, in addition to the declared latency.
fn far(declared_s: f64, offset_s: f64) -> SetupFinding {
    let latency_s = declared_s + offset_s;
    let is_leap = (latency_s.abs() - LEAP_SECONDS).abs() < LEAP_WITHIN_S;
    let cause = match is_leap {
        true if latency_s > 0.0 => "fixes have GPS time, samples have UTC, 18 s less",
        true => "samples have GPS time, fixes have UTC, 18 s less",
        false => "two clocks, or fixes stamped late",
    };
    SetupFinding {
        sensor: Sensor::Clocks,
        is_certain: !FOLLOWED_S.contains(&offset_s),
        found: format!(
            "by the vehicle's accelerations, fixes are valid {} (declared latency {declared_s:.3} s)",
            side(latency_s)
        ),
        cause: cause.into(),
        mend: mend(latency_s),
    }
}

fn side(latency_s: f64) -> String {
    let side = if latency_s >= 0.0 { "earlier" } else { "later" };
    format!("{:.3} s {side} than their time stamps", latency_s.abs())
}

fn mend(latency_s: f64) -> String {
    if latency_s.abs() < LONGEST_LATENCY_S {
        return format!("set [gps] latency_s = {latency_s:.2}");
    }
    "stamp fixes and samples by one clock".into()
}
