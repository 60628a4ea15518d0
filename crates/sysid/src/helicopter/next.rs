//! Advice for the next flight, at the end of the reasons of a verdict.

/// The stick that a parameter's derivative belongs to, by its name.
pub(super) fn stick_of(name: &str) -> &'static str {
    let by_end =
        [("lat", "lateral"), ("lon", "longitudinal"), ("col", "collective"), ("ped", "pedal")];
    let by_start = [
        (["L", "Y", "B"], "lateral"),
        (["M", "X", "A"], "longitudinal"),
        (["Z", "Z", "Z"], "collective"),
        (["N", "N", "N"], "pedal"),
    ];
    let by_end = by_end.into_iter().find(|(end, _)| name.ends_with(end)).map(|(_, stick)| stick);
    let by_start = || by_start.into_iter().find(|(s, _)| s.iter().any(|s| name.starts_with(s)));
    by_end.or_else(|| by_start().map(|(_, stick)| stick)).unwrap_or("lateral and longitudinal")
}

/// Advice for more and larger steps of `stick`.
pub(super) fn steps(stick: &str) -> String {
    format!(
        "Next: four doublets on {stick}, 1.5 times as large, each side held 1 to 1.5 s, in calm air"
    )
}

/// Advice for another flight with steps of `stick` of the same size.
pub(super) fn again(stick: &str) -> String {
    format!("Next: at least two doublets on {stick}, each side held 1 to 1.5 s")
}

/// Advice for as many repetitions as reduce a bound by `factor`.
pub(super) fn repetitions(stick: &str, factor: f64) -> String {
    /// Largest factor on the number of steps; beyond it larger steps are easier than more steps.
    const MAX: f64 = 10.0;
    let times = (factor * factor).ceil();
    if times.is_nan() || times > MAX {
        return steps(stick);
    }
    format!("Next: {times:.0} times as many doublets on {stick}, each side held 1 to 1.5 s")
}

/// Advice for a sweep over the frequency band of the rigid-body motion.
pub(super) fn sweep(stick: &str) -> String {
    format!("Next: two sweeps of {stick} from 0.1 to 4 Hz in 60 s each, 10 % of full travel")
}

/// Advice for a slow sweep, in which the speed varies.
pub(super) fn slow(stick: &str) -> String {
    format!("Next: a sweep of {stick} from 0.05 to 0.5 Hz in 60 s, within 2 m/s of the trim")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_derivative_has_its_stick() {
        for (name, stick) in [
            ("Llat", "lateral"),
            ("Mlon", "longitudinal"),
            ("Nr", "pedal"),
            ("Ncol", "collective"),
            ("Zw", "collective"),
            ("Lb", "lateral"),
            ("tau_ped", "pedal"),
            ("tau_f", "lateral and longitudinal"),
        ] {
            assert_eq!(stick_of(name), stick, "{name}");
        }
    }

    #[test]
    fn a_bound_twice_too_large_takes_four_times_the_flights() {
        assert!(repetitions("pedal", 2.0).contains("4 times"));
        assert!(repetitions("pedal", 9.0).contains("times as large"));
        assert!(repetitions("pedal", f64::NAN).contains("times as large"));
    }
}
