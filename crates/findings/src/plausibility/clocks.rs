//! Checks of the sensors' clocks and of the sample rate.

use crate::finding::{Sensor, SetupFinding};
use crate::sampling::SampleRates;
use hovernav::imu::Motion;
use hovernav::time::Time;
use hovernav_dataset::Dataset;
use hovernav_dataset::statistics::median_interval_s;

/// Fraction of the declared rate below which samples are missing.
const WHOLE: f64 = 0.8;
/// Description of a log that holds only some of the samples.
const THINNED: &str =
    "a log thinned to save space, in which rotation and vibration between the samples are lost";

/// Effect of low rates on increments, in words.
const COARSE: &str = "increments at this rate lose the coning and sculling within each of them";
/// Longest plausible interval between fixes, s.
const SLOWEST_FIXES_S: f64 = 30.0;
/// Shortest apparent interval between fixes whose times are in milliseconds, s.
const IN_MILLISECONDS_S: f64 = 35.0;
/// Smallest overlap of fixes and samples, as a fraction of the longer span, at which both have one clock and unit.
const SHARED: f64 = 0.5;

pub(super) fn check(dataset: &Dataset, found: &mut Vec<SetupFinding>) {
    if let Some(interval_s) = dataset.sample_interval_s().filter(|interval_s| *interval_s > 0.0)
        && let Some(sample) = dataset.samples().next()
    {
        let unit = unit_of_times(dataset);
        match single_precision_s(dataset) {
            Some(rounded_s) if rounded_s > 0.5 * interval_s => found.push(rounded(rounded_s)),
            _ => rate(interval_s, &sample.motion, unit, dataset.manifest.imu.rate_hz, found),
        }
    }
    let fixes = &dataset.fixes;
    let gps = || Some((fixes.first()?.time, fixes.last()?.time));
    if let (Some(imu), Some(gps)) = (dataset.sample_span(), gps()) {
        overlap(imu, gps, found);
    }
}

/// Longest interval of any inertial unit, s.
const SLOWEST_UNIT_S: f64 = 0.05;
/// Number of samples whose times are examined for rounding.
const ROUNDED_SAMPLES: usize = 1000;

/// Interval between neighbouring single-precision numbers at the size of the times, s; `None` unless all times are such
/// numbers.
fn single_precision_s(dataset: &Dataset) -> Option<f64> {
    let mut times = dataset.samples().take(ROUNDED_SAMPLES).map(|sample| sample.time.seconds());
    let first_s = times.next().filter(|first_s| *first_s > 1.0)?;
    let are_single = times.all(|time_s| f64::from(time_s as f32) == time_s);
    let single = first_s as f32;
    are_single.then(|| f64::from(f32::from_bits(single.to_bits() + 1)) - f64::from(single))
}

fn rounded(to_s: f64) -> SetupFinding {
    SetupFinding {
        sensor: Sensor::InertialUnit,
        // The times of an inertial unit at 128 Hz are such numbers too.
        is_certain: to_s > SLOWEST_UNIT_S,
        found: format!("times rounded to {to_s} s: many samples have one time"),
        cause: "t_s in single precision (float32), which holds seven digits".into(),
        mend: "log the time in double precision, or in seconds since the log began".into(),
    }
}

/// Likely unit of the times of samples and fixes.
#[derive(Clone, Copy, Debug, PartialEq)]
enum TimeUnit {
    Seconds,
    Milliseconds,
}

/// Likely unit of the times, from the rate of the fixes. `None` if the unit is ambiguous, or if the spans of fixes and
/// samples overlap too little.
fn unit_of_times(dataset: &Dataset) -> Option<TimeUnit> {
    let times: Vec<Time> = dataset.fixes.iter().map(|fix| fix.time).collect();
    let interval_s = median_interval_s(&times)?;
    let (start, end) = dataset.sample_span()?;
    let (&first, &last) = (times.first()?, times.last()?);
    let shared_s = end.min(last) - start.max(first);
    if shared_s < SHARED * (end - start).max(last - first) {
        return None;
    }
    if interval_s <= SLOWEST_FIXES_S {
        Some(TimeUnit::Seconds)
    } else {
        (interval_s >= IN_MILLISECONDS_S).then_some(TimeUnit::Milliseconds)
    }
}

fn rate(
    interval_s: f64,
    motion: &Motion,
    unit: Option<TimeUnit>,
    stated_hz: Option<f64>,
    found: &mut Vec<SetupFinding>,
) {
    let rate_hz = 1.0 / interval_s;
    let rates = SampleRates::of(motion);
    if rate_hz > rates.poor_hz {
        if let Some(stated_hz) = stated_hz.filter(|stated_hz| rate_hz < WHOLE * stated_hz) {
            found.push(SetupFinding {
                sensor: Sensor::InertialUnit,
                is_certain: false,
                found: format!(
                    "found {rate_hz:.1} samples a second, expected [imu] rate_hz, {stated_hz}"
                ),
                cause: THINNED.into(),
                mend: "log every sample, or correct rate_hz; until then one-sigmas are too small"
                    .into(),
            });
        }
        return;
    }
    let is_certain = rate_hz < rates.least_hz;
    let expected_hz = if is_certain { rates.least_hz } else { rates.poor_hz };
    let (cause, mend) = slow(interval_s, motion, unit);
    found.push(SetupFinding {
        sensor: Sensor::InertialUnit,
        is_certain,
        found: format!(
            "found {rate_hz:.3} samples a second, expected at least {expected_hz:.0} for inertial navigation"
        ),
        cause,
        mend,
    });
}

/// Likely cause of samples every `interval_s`, and its remedy.
fn slow(interval_s: f64, motion: &Motion, unit: Option<TimeUnit>) -> (String, String) {
    let faster = "log the inertial unit at 50 Hz or more";
    if interval_s > 100.0 {
        let cause = "t_s in microseconds or nanoseconds";
        return (cause.into(), "write t_s in seconds".into());
    }
    let lost = match motion {
        Motion::Rates { .. } => THINNED,
        Motion::Increments { .. } => COARSE,
    };
    if interval_s < 1.0 || unit == Some(TimeUnit::Seconds) {
        return (lost.into(), faster.into());
    }
    let divided = format!("divide t_s by 1000, which gives {:.0} Hz", 1000.0 / interval_s);
    match unit {
        Some(_) => ("t_s in milliseconds".into(), divided),
        None => (
            "t_s may be in milliseconds, or the inertial unit was logged far too slowly".into(),
            format!("{divided}; otherwise {faster}"),
        ),
    }
}

fn overlap(imu: (Time, Time), gps: (Time, Time), found: &mut Vec<SetupFinding>) {
    let seconds = |(start, end): (Time, Time)| (start.seconds(), end.seconds());
    let ((imu_start, imu_end), (gps_start, gps_end)) = (seconds(imu), seconds(gps));
    let shared_s = imu_end.min(gps_end) - imu_start.max(gps_start);
    if shared_s >= 0.0 {
        return;
    }
    found.push(SetupFinding {
        sensor: Sensor::Clocks,
        is_certain: true,
        found: format!(
            "inertial samples from {imu_start:.3} to {imu_end:.3} s and fixes from {gps_start:.3} to \
             {gps_end:.3} s, expected spans that overlap"
        ),
        cause: clock_error((imu_start, imu_end), (gps_start, gps_end)),
        mend: "write t_s in seconds on one clock in all files".into(),
    });
}

/// Likely cause of two spans, s, that do not overlap.
fn clock_error(imu: (f64, f64), gps: (f64, f64)) -> String {
    let ratio = (gps.1 - gps.0) / (imu.1 - imu.0).max(1e-9);
    for (factor, unit) in [(1e3, "milliseconds"), (1e6, "microseconds"), (1e9, "nanoseconds")] {
        for (ratio, whose) in [(ratio, "the fixes'"), (1.0 / ratio, "the inertial unit's")] {
            if (0.3..3.0).contains(&(ratio / factor)) {
                return format!("{whose} times are in {unit}, not in seconds");
            }
        }
    }
    /// 6 January 1980 in seconds since 1970.
    const GPS_EPOCH_S: f64 = 315_964_800.0;
    /// Length of a week, s.
    const WEEK_S: f64 = 604_800.0;
    let length_s = (imu.1 - imu.0).max(gps.1 - gps.0).max(60.0);
    let apart_s = (gps.0 - imu.0).abs();
    let near = |value_s: f64, what_s: f64| (value_s - what_s).abs() < length_s + 60.0;
    if near(apart_s, GPS_EPOCH_S) {
        return "one clock counts from 1970 (UTC), the other from 1980 (GPS time)".into();
    }
    let weeks = (apart_s / WEEK_S).round();
    if weeks >= 1.0 && near(apart_s, weeks * WEEK_S) && apart_s < 20.0 * 365.25 * 86_400.0 {
        return format!(
            "the clocks are {weeks:.0} whole weeks apart: one counts seconds of the GPS week"
        );
    }
    let hours = (apart_s / 3600.0).round();
    if (1.0..=14.0).contains(&hours) && near(apart_s, hours * 3600.0) && length_s < 1500.0 {
        return format!(
            "the clocks are {hours:.0} whole hours apart: one is in local time, the other in UTC"
        );
    }
    let (low, high) = (imu.0.min(gps.0), imu.0.max(gps.0));
    if high > 1e8 && low < 1e7 {
        return "one clock has the time of day or GPS time, the other counts from the start of the computer"
            .into();
    }
    if high < WEEK_S && low < 1e5 {
        return "one clock counts from the start of the computer or of its own file".into();
    }
    "two clocks, or files of two flights".into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::earth::Geodetic;
    use hovernav::frames::Vector;
    use hovernav::gps::Fix;
    use hovernav::imu::ImuSample;

    #[test]
    fn the_likely_clock_error_is_named() {
        for (imu, gps, expected) in [
            ((1.0, 300.0), (1000.0, 300_000.0), "milliseconds"),
            ((1e6, 300e6), (1.0, 300.0), "microseconds"),
            ((1e9, 1e9 + 300.0), (1e9 - 315_964_800.0, 1e9 - 315_964_500.0), "1980"),
            ((1.4e9, 1.4e9 + 300.0), (5.0, 305.0), "start of the computer"),
            ((7200.0, 7500.0), (0.0, 300.0), "2 whole hours"),
        ] {
            let cause = clock_error(imu, gps);
            assert!(cause.contains(expected), "{cause}");
        }
    }

    const RATES: Motion = Motion::Rates {
        angular_rate_radps: Vector::ZERO,
        specific_force_mps2: Vector::new(0.0, 0.0, -9.8),
    };
    const INCREMENTS: Motion =
        Motion::Increments { angle_rad: Vector::ZERO, velocity_mps: Vector::new(0.0, 0.0, -0.8) };

    #[test]
    fn samples_too_slow_or_in_milliseconds_are_said() {
        use TimeUnit::{Milliseconds, Seconds};
        for (interval_ms, motion, unit, certain, cause, least) in [
            (116, RATES, None, true, "thinned", "at least 18 "),
            (50, RATES, None, false, "thinned", "at least 24 "),
            (67, RATES, None, true, "thinned", "at least 18 "),
            (67, INCREMENTS, None, false, "coning", "at least 24 "),
            (83, INCREMENTS, None, false, "coning", "at least 24 "),
            (116, INCREMENTS, None, true, "coning", "at least 10 "),
            (10_000, RATES, Some(Milliseconds), true, "t_s in milliseconds", "at least 18 "),
            (1000, RATES, None, true, "may be in milliseconds", "at least 18 "),
            (1000, RATES, Some(Seconds), true, "thinned", "at least 18 "),
        ] {
            let mut found = Vec::new();
            rate(1e-3 * f64::from(interval_ms), &motion, unit, None, &mut found);
            assert_eq!(found.len(), 1);
            assert_eq!(found[0].is_certain, certain);
            assert!(found[0].cause.contains(cause), "{}", found[0]);
            assert!(found[0].found.contains(least), "{}", found[0]);
        }
    }

    #[test]
    fn fixes_tell_the_unit_of_the_times() {
        let place = Geodetic::from_degrees(50.0, 10.0, 100.0).unwrap();
        let unit = |sample_s: f64, fix_s: f64| {
            let at =
                |index: u32, interval_s: f64| Time::ZERO.offset_by(f64::from(index) * interval_s);
            let length_s = 200.0 * sample_s.max(fix_s);
            let count = |interval_s: f64| (length_s / interval_s) as u32;
            unit_of_times(&Dataset {
                imu: (0..count(sample_s)).map(|k| ImuSample::new(at(k, sample_s), RATES)).collect(),
                fixes: (0..count(fix_s)).map(|k| Fix::at(at(k, fix_s), place)).collect(),
                ..Dataset::default()
            })
        };
        assert_eq!(unit(1.0, 1.0), Some(TimeUnit::Seconds));
        assert_eq!(unit(1.0, 0.2), Some(TimeUnit::Seconds));
        assert_eq!(unit(10.0, 1000.0), Some(TimeUnit::Milliseconds));
        assert_eq!(unit(30.0, 200.0), Some(TimeUnit::Milliseconds));
        // The samples alone are in milliseconds, or there are no fixes.
        let apart = Dataset {
            imu: (0..100)
                .map(|k| ImuSample::new(Time::ZERO.offset_by(10.0 * f64::from(k)), RATES))
                .collect(),
            fixes: (0..5).map(|k| Fix::at(Time::ZERO.offset_by(f64::from(k)), place)).collect(),
            ..Dataset::default()
        };
        assert_eq!(unit_of_times(&apart), None);
        assert_eq!(unit_of_times(&Dataset { fixes: Vec::new(), ..apart }), None);
    }

    #[test]
    fn samples_at_less_than_the_stated_rate_are_said() {
        for (interval_s, stated_hz, is_said) in
            [(0.02, Some(100.0), true), (0.02, Some(52.0), false), (0.02, None, false)]
        {
            let mut found = Vec::new();
            rate(interval_s, &RATES, None, stated_hz, &mut found);
            assert_eq!(!found.is_empty(), is_said, "{found:?}");
        }
    }
}
