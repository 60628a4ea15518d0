//! Distance between a solution and an independent one, and the harm of findings measured by that distance.

use hovernav::ekf::Solution;
use hovernav::time::Time;

use crate::score::{Axis, axis_errors};
use hovernav_dataset::Reference;
use hovernav_dataset::statistics::within;
use hovernav_findings::{Finding, FindingKind, Harm, Sensor, Severity, Span, spans};

/// Ratio of error to one-sigma above which a solution is contradicted. Errors of the models reach a few one-sigmas.
const CONTRADICTED: f64 = 10.0;
/// Smallest position difference, m, that counts as a contradiction: a smaller one harms no use of the solution.
const MIN_M: f64 = 3.0;
/// Smallest velocity difference, m/s, that counts as a contradiction.
const MIN_MPS: f64 = 1.0;
/// Shortest contradiction, s, that is reported: a shorter one is a timing error.
const LASTING_S: f64 = 0.5;
/// Longest time, s, between two contradictions that are reported as one.
const APART_S: f64 = 5.0;
/// Time, s, after a finding in which its harm shows.
const AFTER_S: f64 = 1.0;

/// Distances of a solution from an independent one: the reference, or the solution of the onboard estimator.
#[derive(Clone, Debug)]
pub struct Apart {
    /// Name of the independent solution in sentences.
    from: String,
    /// One-sigma of the independent solution on the axes of [`AXES`], m and m/s.
    own_sigmas: [f64; 6],
    /// Distances at the times of the solution, in order of time.
    moments: Vec<Moment>,
}

/// Axes of position and velocity.
const AXES: [Axis; 6] = [
    Axis::North,
    Axis::East,
    Axis::Down,
    Axis::VelocityNorth,
    Axis::VelocityEast,
    Axis::VelocityDown,
];

#[derive(Clone, Copy, Debug)]
struct Moment {
    time_s: f64,
    position: Size,
    velocity: Size,
}

/// Size of a position or velocity error; NaN if unknown.
#[derive(Clone, Copy, Debug)]
struct Size {
    /// Magnitude, m or m/s.
    magnitude: f64,
    /// Magnitude of the one-sigmas of the solution on the known axes, m or m/s.
    sigma: f64,
    /// Largest ratio of error to one-sigma.
    one_sigmas: f64,
}

impl Size {
    fn of(errors: &[f64], sigmas: [f64; 3], own_sigmas: &[f64]) -> Self {
        let (mut square, mut sigma_square, mut one_sigmas) = (0.0, 0.0, f64::NAN);
        for ((error, sigma), own) in errors.iter().zip(sigmas).zip(own_sigmas) {
            if error.is_finite() && sigma.is_finite() {
                square += error * error;
                sigma_square += sigma * sigma;
                one_sigmas = f64::max(one_sigmas, error.abs() / sigma.hypot(*own));
            }
        }
        let is_known = !one_sigmas.is_nan();
        let known = |square: f64| if is_known { square.sqrt() } else { f64::NAN };
        Self { magnitude: known(square), sigma: known(sigma_square), one_sigmas }
    }
}

impl Moment {
    fn one_sigmas(&self) -> f64 {
        self.position.one_sigmas.max(self.velocity.one_sigmas)
    }

    fn is_contradicted(&self) -> bool {
        let by = |size: Size, least| size.one_sigmas > CONTRADICTED && size.magnitude > least;
        by(self.position, MIN_M) || by(self.velocity, MIN_MPS)
    }
}

impl Apart {
    /// Creates an empty list of distances from the solution named `from`. `own_sigmas` are its one-sigmas north, east,
    /// down of position, m, and velocity, m/s.
    #[must_use]
    pub const fn new(from: String, own_sigmas: [f64; 6]) -> Self {
        Self { from, own_sigmas, moments: Vec::new() }
    }

    /// Distances of `solutions` from `reference`, from the time `start` on.
    #[must_use]
    pub fn of_reference(solutions: &[Solution], reference: &Reference, start: Time) -> Self {
        let mut apart = Self::new("reference".into(), AXES.map(|axis| axis.own_sigma(reference)));
        for solution in solutions.iter().filter(|solution| solution.time >= start) {
            let errors = axis_errors(solution, reference);
            apart.push(solution.time, solution, AXES.map(|axis| errors[axis as usize]));
        }
        apart
    }

    /// Adds the `errors` of `solution` at `time`, which is after the previous one. They are north, east, down of
    /// position, m, and of velocity, m/s; an unknown error is NaN.
    pub fn push(&mut self, time: Time, solution: &Solution, errors: [f64; 6]) {
        let (position, velocity) = errors.split_at(3);
        let (own_position, own_velocity) = self.own_sigmas.split_at(3);
        let moment = Moment {
            time_s: time.seconds(),
            position: Size::of(position, solution.position_sigma_m.to_array(), own_position),
            velocity: Size::of(velocity, solution.velocity_sigma_mps.to_array(), own_velocity),
        };
        if !moment.one_sigmas().is_nan() {
            self.moments.push(moment);
        }
    }

    /// The moments from `start_s` to `end_s`.
    fn within(&self, start_s: f64, end_s: f64) -> &[Moment] {
        within(&self.moments, |moment| moment.time_s, start_s, end_s)
    }

    /// Spans in which the independent solution contradicts this one, each a finding.
    #[must_use]
    pub fn contradictions(&self) -> Vec<Finding> {
        let against = self.moments.iter().filter(|moment| moment.is_contradicted());
        let spans = spans(against.map(|moment| (moment.time_s, moment.one_sigmas())), APART_S);
        let lasting = spans.into_iter().filter(|span| span.end_s - span.start_s >= LASTING_S);
        lasting.map(|span| self.contradiction(span)).collect()
    }

    fn contradiction(&self, Span { start_s, end_s, count, .. }: Span) -> Finding {
        let moments = self.within(start_s, end_s);
        let largest = |part: fn(&Moment) -> Size, unit: &str, digits: usize| {
            let sizes = moments.iter().map(part).filter(|size| !size.magnitude.is_nan());
            let Size { magnitude, sigma, .. } =
                sizes.max_by(|a, b| a.magnitude.total_cmp(&b.magnitude))?;
            Some(format!(
                "by {magnitude:.digits$} {unit} at a one-sigma of {sigma:.digits$} {unit}"
            ))
        };
        let position = largest(|moment| moment.position, "m", 1);
        let velocity = largest(|moment| moment.velocity, "m/s", 2);
        let parts = [("position", position), ("velocity", velocity)];
        let parts: Vec<String> =
            parts.into_iter().filter_map(|(name, by)| Some(format!("{name} {}", by?))).collect();
        let words = format!(
            "solution contradicted by the {} from {start_s:.1} to {end_s:.1} s: it differs in {}; one of the two is \
             wrong: compare both with the fixes, and read the findings of this span",
            self.from,
            parts.join(", in ")
        );
        Finding::warning(Sensor::Filter, FindingKind::Contradicted, (start_s, end_s), words)
            .severity(Severity::Error)
            .of(count)
    }
}

/// Sets the harm of each of `findings`. The harm is the growth of the one-sigmas of `solutions`, and the distances in
/// `apart`, if given. Without distances, a reset keeps its own harm. `solutions` are in order of time.
///
/// Findings are ranked by their harm outside the spans of much shorter warnings. So a finding about the whole flight
/// does not get the rank of an event within it.
pub fn set_harms(findings: &mut [Finding], solutions: &[Solution], apart: Option<&Apart>) {
    let is_event =
        |finding: &&Finding| finding.is_warning() && finding.kind != FindingKind::Contradicted;
    let span = |finding: &Finding| (finding.start_s, finding.end_s + AFTER_S);
    let events: Vec<(f64, f64)> = findings.iter().filter(is_event).map(span).collect();
    for finding in findings {
        let (start_s, end_s) = span(finding);
        let shorter: Vec<&(f64, f64)> =
            events.iter().filter(|(from, to)| SHORTER * (to - from) < end_s - start_s).collect();
        let is_own =
            |time_s: f64| !shorter.iter().any(|(from, to)| (*from..=*to).contains(&time_s));
        let moments = apart.map_or(&[][..], |apart| apart.within(start_s, end_s));
        let largest = |size: fn(&Moment) -> f64| {
            moments.iter().map(size).filter(|size| !size.is_nan()).reduce(f64::max)
        };
        let one_sigmas = largest(Moment::one_sigmas);
        let of_reset = finding
            .harm
            .filter(|_| one_sigmas.is_none() && finding.kind == FindingKind::ResetToReadings);
        let growths = growths(solutions, start_s, end_s);
        let growth = |is_own: &dyn Fn(f64) -> bool| {
            let own = growths.iter().filter(|(time_s, _)| is_own(*time_s));
            own.map(|(_, ratio)| *ratio).fold(1.0, f64::max)
        };
        let own_sigmas = moments.iter().filter(|moment| is_own(moment.time_s));
        let size = match (one_sigmas, of_reset) {
            (None, Some(reset)) => reset.size,
            (None, None) => growth(&is_own),
            (Some(_), _) => own_sigmas.map(Moment::one_sigmas).fold(0.0, f64::max),
        };
        finding.harm = (!growths.is_empty()).then(|| Harm {
            position_m: largest(|moment| moment.position.magnitude)
                .or(of_reset.and_then(|reset| reset.position_m)),
            velocity_mps: largest(|moment| moment.velocity.magnitude),
            one_sigmas: one_sigmas.or(of_reset.and_then(|reset| reset.one_sigmas)),
            growth: growth(&|_| true),
            size,
        });
    }
}

/// Ratio of the spans of two findings above which the shorter one explains the harm within it.
const SHORTER: f64 = 2.0;

/// Times from `start_s` to `end_s`, with the one-sigmas of position or velocity, the larger one, divided by their
/// values at the start.
fn growths(solutions: &[Solution], start_s: f64, end_s: f64) -> Vec<(f64, f64)> {
    let sigmas = |solution: &Solution| {
        [solution.position_sigma_m, solution.velocity_sigma_mps].map(|sigma| sigma.norm())
    };
    let solutions = within(solutions, |solution| solution.time.seconds(), start_s, end_s);
    let Some(first) = solutions.first().map(sigmas) else { return Vec::new() };
    let ratio = |solution: &Solution| {
        let [position, velocity] = sigmas(solution);
        let ratios = [position / first[0], velocity / first[1]];
        ratios.into_iter().filter(|ratio| ratio.is_finite()).fold(1.0, f64::max)
    };
    solutions.iter().map(|solution| (solution.time.seconds(), ratio(solution))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::earth::Geodetic;
    use hovernav::frames::Vector;

    /// A solution each tenth of a second for 20 s; its one-sigma of position is 0.5 m, and 2 m from 15 s on.
    fn solutions() -> Vec<Solution> {
        let of = |tenth: u32| {
            let time_s = 0.1 * f64::from(tenth);
            let place = Geodetic::from_degrees(47.0, 8.0, 400.0).unwrap();
            let position_sigma_m = if time_s < 15.0 { 0.5 } else { 2.0 };
            Solution {
                position_sigma_m: Vector::new(1.0, 1.0, 1.0) * position_sigma_m,
                velocity_sigma_mps: Vector::new(0.2, 0.2, 0.2),
                ..Solution::at_rest(Time::from_seconds(time_s), place)
            }
        };
        (0..200).map(of).collect()
    }

    /// Distances from an independent solution: 27 m and 9.5 m/s within `far_s`, and 1 m elsewhere.
    fn apart(solutions: &[Solution], far_s: std::ops::Range<f64>) -> Apart {
        let mut apart = Apart::new("reference".into(), [0.5; 6]);
        for solution in solutions {
            let is_far = far_s.contains(&solution.time.seconds());
            let (position, velocity) = if is_far { (27.0, 9.5) } else { (1.0, f64::NAN) };
            apart.push(solution.time, solution, [0.0, 0.0, position, 0.0, 0.0, velocity]);
        }
        apart
    }

    #[test]
    fn a_solution_many_one_sigmas_away_for_seconds_is_contradicted() {
        let solutions = solutions();
        let found = apart(&solutions, 5.0..8.4).contradictions();
        let [finding] = &found[..] else { panic!("{found:?}") };
        assert!((finding.start_s - 5.0).abs() < 0.11 && (finding.end_s - 8.4).abs() < 0.11);
        assert_eq!((finding.severity, finding.sensor), (Severity::Error, Sensor::Filter));
        for words in ["27.0 m at", "9.50 m/s at", "from 5.0 to 8.3 s"] {
            assert!(finding.words.contains(words), "{}", finding.words);
        }
        // A contradiction at a single time, or errors of a few one-sigmas, are not reported.
        assert!(apart(&solutions, 5.0..5.2).contradictions().is_empty());
        assert!(apart(&solutions, 30.0..31.0).contradictions().is_empty());
    }

    #[test]
    fn harm_is_the_largest_error_in_the_span_and_without_one_the_growth() {
        let solutions = solutions();
        let apart = apart(&solutions, 5.0..8.4);
        let span = |start_s, end_s| Finding { start_s, end_s, ..apart.contradictions()[0].clone() };
        let mut findings = [span(6.0, 6.0), span(9.0, 12.0), span(14.0, 16.0), span(90.0, 91.0)];
        set_harms(&mut findings, &solutions, Some(&apart));
        let harms = findings.each_ref().map(|finding| finding.harm);
        let far = harms[0].unwrap();
        assert_eq!((far.position_m, far.velocity_mps), (Some(27.0), Some(9.5)));
        assert!((far.one_sigmas.unwrap() - 27.0 / 0.5f64.hypot(0.5)).abs() < 1e-9, "{far:?}");
        let near = harms[1].unwrap();
        assert_eq!((near.position_m, near.growth), (Some(1.0), 1.0));
        assert_eq!(harms[2].unwrap().growth, 4.0);
        assert!(harms[3].is_none());
        set_harms(&mut findings, &solutions, None);
        assert_eq!(findings[2].harm.map(|harm| (harm.one_sigmas, harm.size)), Some((None, 4.0)));
    }

    #[test]
    fn a_finding_over_the_whole_flight_ranks_by_its_harm_outside_shorter_ones() {
        let solutions = solutions();
        let apart = apart(&solutions, 5.0..8.4);
        let mut findings = [(0.0, 20.0), (5.0, 8.4)]
            .map(|span_s| Finding::warning(Sensor::Gps, FindingKind::Rejected, span_s, "rejected"));
        set_harms(&mut findings, &solutions, Some(&apart));
        let [whole, short] = findings.each_ref().map(|finding| finding.harm.unwrap());
        assert_eq!(whole.one_sigmas, short.one_sigmas);
        assert!(whole.size < 0.1 * short.size, "{whole:?} {short:?}");
    }

    #[test]
    fn a_reset_of_the_position_is_harm_without_an_independent_solution() {
        let reset = Finding {
            harm: Some(Harm::of_reset(490.0, 1.4)),
            ..Finding::warning(Sensor::Gps, FindingKind::ResetToReadings, (3.0, 4.0), "reset")
        };
        let grown = Finding::warning(Sensor::Gps, FindingKind::Outage, (14.0, 16.0), "outage");
        let mut findings = [grown, reset];
        set_harms(&mut findings, &solutions(), None);
        findings.sort_by(|a, b| a.by_harm(b));
        assert_eq!(findings[0].words, "reset");
        assert_eq!(findings[0].harm.unwrap().position_m, Some(490.0));
    }
}
