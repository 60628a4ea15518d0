//! A solution without steps, for a controller: corrections by measurements are released over about a second.

use super::solution::Solution;
use crate::ekf::kernel::layout::{ATTITUDE, POSITION, VELOCITY};
use crate::ekf::kernel::trace::Trace;
use crate::frames::{Ned, Vector};
use crate::scalar::Scalar;
use crate::time::Time;

/// Largest held-back velocity correction, m/s. A larger one means that the solution was replaced: it is applied at
/// once. A replaced heading is released gradually, at any size of the turn.
const ANOTHER_MPS: f64 = 10.0;
/// Largest position correction not yet released, m. A larger one means that the solution was replaced: it is applied at
/// once.
const ANOTHER_M: f64 = 100.0;

/// Holds back the corrections by measurements, and releases them with a time constant of 0.35 s.
///
/// Give it to the estimator as its [`Trace`], and take the controller's solution from [`solution`](Self::solution).
/// That is the filter's own solution minus the corrections still held back. Motion passes through without delay, so at
/// the loop's frequencies the phase is that of the filter. Only the jumps by corrections are spread over time. The
/// held-back part is added to the one-sigma, so that the solution does not look more certain than it is.
///
/// ```
/// use hovernav::ekf::{Estimator, EstimatorConfig, SteplessSolution};
/// # use hovernav::event::Event;
/// # fn fly(events: &[Event]) {
/// let mut estimator = Estimator::new(EstimatorConfig::default());
/// let mut stepless = SteplessSolution::default();
/// for event in events {
///     estimator.push_traced(event, &mut stepless, |_| {});
///     let for_the_controller = estimator.solution().map(|solution| stepless.solution(&solution));
/// }
/// # }
/// ```
///
/// # Source
/// Equation (C11) of docs/equations.md.
#[derive(Clone, Copy, Debug, Default)]
pub struct SteplessSolution<T = f64> {
    /// Time of the previous solution.
    before: Option<Time>,
    attitude_rad: PendingCorrection<T>,
    /// Held-back part of [`Solution::heading_revision_rad`], rad, as the down component of a vector.
    heading_revision_rad: PendingCorrection<T>,
    /// Heading revision of the previous solution, rad.
    revised_rad: T,
    velocity_mps: PendingCorrection<T>,
    position_m: PendingCorrection<T>,
}

/// Time constant of the release, s: four fifths of a correction are released within a second.
const RELEASE_S: f64 = 0.35;

/// Limit below which a held-back correction and its rate are set to zero: rad, m/s or m, and rad/s, m/s² or m/s.
const FORGOTTEN: f64 = 1e-12;

/// Held-back correction of one quantity, and its rate of change. Critically damped, so that neither value nor rate
/// jumps during the release: a controller that differentiates sees no step either.
#[derive(Clone, Copy, Debug, Default)]
struct PendingCorrection<T> {
    left: Vector<Ned, T>,
    rate_per_s: Vector<Ned, T>,
}

impl<T: Scalar> PendingCorrection<T> {
    /// Releases part of the correction over `elapsed_s`, which is `times` time constants. `per_s` is the inverse of the
    /// time constant, and `share` is exp(−`times`).
    fn let_out(&mut self, elapsed_s: T, times: T, per_s: T, share: T) {
        let drive = self.rate_per_s + self.left * per_s;
        self.left = (self.left + drive * elapsed_s) * share;
        self.rate_per_s = (self.rate_per_s - drive * times) * share;
        // Without new corrections the held-back part would decay to denormal numbers, with which processors compute a
        // hundred times slower.
        let forgotten = T::of(FORGOTTEN);
        if self.left.is_shorter_than(forgotten) && self.rate_per_s.is_shorter_than(forgotten) {
            *self = Self::default();
        }
    }
}

impl<T: Scalar> SteplessSolution<T> {
    /// Held-back corrections: attitude, rad, velocity, m/s, and position, m, north, east, down.
    const fn kept_back(&self) -> [Vector<Ned, T>; 3] {
        [self.attitude_rad.left, self.velocity_mps.left, self.position_m.left]
    }

    /// The solution without steps at the time of `filtered`, the filter's own solution.
    pub fn solution(&mut self, filtered: &Solution<T>) -> Solution<T> {
        let elapsed_s = self
            .before
            .map_or(T::ZERO, |before| filtered.time.seconds_since::<T>(before).max(T::ZERO));
        self.before = Some(filtered.time);
        let revised_rad = filtered.heading_revision_rad - self.revised_rad;
        self.revised_rad = filtered.heading_revision_rad;
        self.heading_revision_rad.left += Vector::new(T::ZERO, T::ZERO, revised_rad);
        let (times, per_s) = (elapsed_s / T::of(RELEASE_S), T::ONE / T::of(RELEASE_S));
        let share = (-times).exp();
        for kept in [
            &mut self.attitude_rad,
            &mut self.heading_revision_rad,
            &mut self.velocity_mps,
            &mut self.position_m,
        ] {
            kept.let_out(elapsed_s, times, per_s, share);
        }
        let [attitude_rad, velocity_mps, position_m] = self.kept_back();
        // The conditions are written so that a NaN is dropped too.
        let small = velocity_mps.is_shorter_than(T::of(ANOTHER_MPS))
            && position_m.is_shorter_than(T::of(ANOTHER_M))
            && attitude_rad.is_shorter_than(T::of(core::f64::consts::PI));
        if !small {
            let Self { before, revised_rad, .. } = *self;
            *self = Self { before, revised_rad, ..Self::default() };
        }
        let [attitude_rad, velocity_mps, position_m] = self.kept_back();
        let turned = attitude_rad.dot(attitude_rad);
        let wider = |sigma: Vector<Ned, T>, kept: Vector<Ned, T>| {
            let [x, y, z] = sigma.to_array();
            let [a, b, c] = kept.to_array();
            Vector::new(Scalar::hypot(x, a), Scalar::hypot(y, b), Scalar::hypot(z, c))
        };
        Solution {
            body_to_ned: filtered.body_to_ned.turned_in_to(-attitude_rad),
            heading_revision_rad: filtered.heading_revision_rad
                - self.heading_revision_rad.left.z(),
            velocity_mps: filtered.velocity_mps - velocity_mps,
            position: filtered.position.displaced(-position_m),
            velocity_sigma_mps: wider(filtered.velocity_sigma_mps, velocity_mps),
            position_sigma_m: wider(filtered.position_sigma_m, position_m),
            attitude_sigma_rad: filtered
                .attitude_sigma_rad
                .map(|sigma| (sigma * sigma + turned).sqrt()),
            ..*filtered
        }
    }
}

impl<T: Scalar, U: Scalar, const N: usize> Trace<T, N> for SteplessSolution<U> {
    fn wants_updates(&self) -> bool {
        false
    }

    fn corrected(&mut self, correction: &[T; N]) {
        let at = |state: usize| correction.get(state).map_or(U::ZERO, |moved| U::of(moved.wide()));
        let block = |first: usize| Vector::new(at(first), at(first + 1), at(first + 2));
        self.attitude_rad.left += block(ATTITUDE);
        self.velocity_mps.left += block(VELOCITY);
        self.position_m.left += block(POSITION);
    }

    fn turned(&mut self, turn_rad: Vector<Ned>) {
        self.attitude_rad.left += turn_rad.cast();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::earth::Geodetic;
    use crate::ekf::estimator::Estimator;
    use crate::ekf::settings::estimator_config::EstimatorConfig;
    use crate::event::Event;
    use crate::frames::EulerAngles;
    use crate::gps::Fix;
    use crate::imu::{ImuSample, Motion};

    /// A minute at rest with fixes that scatter by metres. The filter's solution steps at each fix, the controller's
    /// does not, and both reach the same value.
    #[test]
    fn fixes_move_it_without_a_step_and_to_the_same_place() {
        let mut estimator = Estimator::new(EstimatorConfig::default());
        let mut stepless = SteplessSolution::default();
        let place = Geodetic::from_degrees(48.1, 11.6, 520.0).unwrap();
        let mut before: Option<(Solution, Solution)> = None;
        let (mut step, mut drawn_out) = (0.0f64, 0.0f64);
        let scatter = [2.0, -3.0, 1.0, 4.0, -2.0];
        for k in 0..3_000i64 {
            let time = Time::from_nanoseconds(k * 20_000_000);
            let sample = ImuSample {
                attitude: Some(EulerAngles::from_degrees(0.0, 0.0, 45.0)),
                ..ImuSample::new(
                    time,
                    Motion::Rates {
                        angular_rate_radps: Vector::ZERO,
                        specific_force_mps2: Vector::new(0.0, 0.0, -9.807),
                    },
                )
            };
            estimator.push_traced(&Event::Imu(sample), &mut stepless, |_| {});
            if k % 50 == 0 {
                let north = scatter[usize::try_from(k / 50).unwrap() % scatter.len()];
                let fix = Fix::at(time, place.displaced(Vector::new(north, 0.0, 0.0)));
                estimator.push_traced(&Event::Gps(fix), &mut stepless, |_| {});
            }
            let Some(filtered) = estimator.solution() else { continue };
            let calm = stepless.solution(&filtered);
            if let Some((filtered_before, calm_before)) = before.filter(|_| k > 500) {
                let moved = |a: &Solution, b: &Solution| a.position.displacement_from(&b.position);
                step = step.max(moved(&filtered, &filtered_before).norm());
                drawn_out = drawn_out.max(moved(&calm, &calm_before).norm());
            }
            before = Some((filtered, calm));
        }
        assert!(step > 0.05 && drawn_out < 0.1 * step, "{step} m becomes {drawn_out} m a sample");
        let (filtered, calm) = before.unwrap();
        let apart = filtered.position.displacement_from(&calm.position);
        let [_, _, kept] = stepless.kept_back();
        assert!((apart - kept).norm() < 1e-6);
        assert!(calm.position_sigma_m.x() >= filtered.position_sigma_m.x());
    }

    fn at_rest() -> Solution {
        Solution::at_rest(Time::ZERO, Geodetic::from_degrees(48.1, 11.6, 520.0).unwrap())
    }

    #[test]
    fn a_heading_that_was_replaced_is_fed_in() {
        let turn_rad = Vector::new(0.0, 0.0, 1.5);
        let mut stepless = SteplessSolution::default();
        let mut filtered = at_rest();
        let before = stepless.solution(&filtered).body_to_ned.euler().yaw_rad;
        filtered.body_to_ned = filtered.body_to_ned.turned_in_to(turn_rad);
        Trace::<f64, 28>::turned(&mut stepless, turn_rad);
        let at_once = stepless.solution(&filtered);
        assert!((at_once.body_to_ned.euler().yaw_rad - before).abs() < 1e-9);
        assert!((at_once.attitude_sigma_rad[2] - 1.5).abs() < 1e-9);
        filtered.time = filtered.time + 10.0;
        let later = stepless.solution(&filtered);
        assert!((later.body_to_ned.euler().yaw_rad - before - 1.5).abs() < 1e-3);
    }

    /// A correction of 1 m is released as (1 + t/τ) e^(−t/τ), at any sample rate.
    #[test]
    fn a_correction_begins_without_a_step_of_its_rate() {
        for rate_hz in [33, 200] {
            let mut stepless = SteplessSolution::default();
            let mut filtered = at_rest();
            let start = filtered.position;
            stepless.solution(&filtered);
            stepless.position_m.left = Vector::new(1.0, 0.0, 0.0);
            filtered.position = start.displaced(stepless.position_m.left);
            for step in 1..=2 * rate_hz {
                let time_s = f64::from(step) / f64::from(rate_hz);
                filtered.time = Time::ZERO + time_s;
                let north = stepless.solution(&filtered).position.displacement_from(&start).x();
                let in_units = time_s / 0.35;
                let expected = 1.0 - (1.0 + in_units) * (-in_units).exp();
                assert!((north - expected).abs() < 1e-6, "{time_s} s: {north}, not {expected} m");
            }
        }
    }

    #[test]
    fn another_solution_is_taken_at_once() {
        let fast =
            PendingCorrection { left: Vector::new(50.0, 0.0, 0.0), ..PendingCorrection::default() };
        let mut stepless = SteplessSolution { velocity_mps: fast, ..Default::default() };
        let filtered = at_rest();
        assert_eq!(stepless.solution(&filtered).velocity_mps, Vector::ZERO);
    }
}
