//! Whether a log is fit for inertial navigation.

use std::path::Path;

use crate::finding::{AIDS, Sensor, SetupFinding};
use crate::plausibility::{Unmeasured, denied_aid, ensure_possible};
use hovernav::ekf::{Aid, EstimatorConfig};
use hovernav_dataset::{Dataset, LogError};
use hovernav_replay::Run;

/// Checks that the filter can run over `dataset`, read from `log`. Returns the findings for [`ignore`].
///
/// # Errors
/// [`LogError::Unusable`] without inertial samples or fixes. [`LogError::Setup`] with impossible units, signs,
/// axes, clocks or rates: see [`check_setup`](crate::check_setup).
pub fn check_fitness(dataset: &Dataset, log: &Path) -> Result<Vec<SetupFinding>, LogError> {
    let rejected = |reason| Err(LogError::Unusable { path: log.to_path_buf(), reason });
    let why = || {
        let is_loss =
            |warning: &&String| ["skipped", "rejected"].iter().any(|word| warning.contains(word));
        dataset.warnings.iter().filter(is_loss).fold(String::new(), |why, warning| {
            format!("{why}{}{warning}", if why.is_empty() { ": " } else { "; " })
        })
    };
    if dataset.sample_count() == 0 {
        let needed = "found no inertial samples, and navigation needs them";
        return rejected(format!("{needed}{}", why()));
    }
    if dataset.fixes.is_empty() {
        let needed = "found no usable fix, expected at least one to start from";
        return rejected(format!("{needed}{}", why()));
    }
    ensure_possible(dataset, log)
}

/// Ignores the aids of these findings, as if `dataset` did not have them. Aids that the manifest's `[aiding]` sets to
/// `true` are kept. For [`Sensor::GpsVelocity`] it ignores velocities of exactly 0 from moving fixes. Returns the
/// findings that were applied, marked as not used.
pub fn ignore(dataset: &mut Dataset, denied: Vec<SetupFinding>) -> Vec<SetupFinding> {
    let mut ignored = Vec::new();
    for mut finding in denied {
        if finding.sensor == Sensor::GpsVelocity {
            let Some(zeros) = Unmeasured::of(&dataset.fixes) else { continue };
            zeros.take_out(&mut dataset.fixes);
            finding.found = format!("not used: {}", finding.found);
            ignored.push(finding);
            continue;
        }
        let of_finding = AIDS.iter().find(|(_, sensor, _)| *sensor == finding.sensor);
        let Some((aid, _, key)) = of_finding else { continue };
        if dataset.manifest.aiding.get(*key).and_then(toml::Value::as_bool) == Some(true) {
            continue;
        }
        match aid {
            Aid::Baro => dataset.baro.clear(),
            Aid::SecondAntenna => dataset.headings.clear(),
            Aid::Magnetometer => {
                dataset.magnetometer.clear();
                dataset.remove_sample_fields();
            }
            _ => dataset.remove_sample_attitudes(),
        }
        finding.found = format!("not used: {}", finding.found);
        finding.mend = format!("{}; [aiding] {key} = true uses it nevertheless", finding.mend);
        ignored.push(finding);
    }
    ignored
}

/// [Ignores](ignore) the source of heading without which the fixes become consistent with a `run`, if there
/// is one. If the result is not empty, the log must be estimated again.
pub fn ignore_inconsistent(
    dataset: &mut Dataset,
    config: &EstimatorConfig,
    run: &Run,
) -> Vec<SetupFinding> {
    let denied = denied_aid(dataset, config, run);
    ignore(dataset, denied.into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::earth::Geodetic;
    use hovernav::frames::Vector;
    use hovernav::gps::Fix;
    use hovernav::imu::{ImuSample, Motion};
    use hovernav::time::Time;

    fn of_rate(rate_hz: f64) -> Dataset {
        let sample = |index| {
            ImuSample::new(
                Time::ZERO.offset_by(f64::from(index) / rate_hz),
                Motion::Rates {
                    angular_rate_radps: Vector::ZERO,
                    specific_force_mps2: Vector::new(0.0, 0.0, -9.8),
                },
            )
        };
        let place = Geodetic::from_degrees(50.0, 10.0, 100.0).unwrap();
        Dataset {
            imu: (0..100).map(sample).collect(),
            fixes: vec![Fix::at(Time::ZERO, place)],
            ..Dataset::default()
        }
    }

    #[test]
    fn a_unit_that_is_too_slow_is_refused_with_its_rate() {
        let log = Path::new("slow.ulg");
        let error = check_fitness(&of_rate(8.6), log).unwrap_err().to_string();
        assert!(error.contains("found 8.600 samples a second, expected at least 18"), "{error}");
        assert!(check_fitness(&of_rate(33.0), log).is_ok());
        let without = Dataset { fixes: Vec::new(), ..of_rate(33.0) };
        assert!(check_fitness(&without, log).is_err());
        assert!(check_fitness(&Dataset::default(), log).is_err());
    }
}
