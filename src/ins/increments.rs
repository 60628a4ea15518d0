//! Samples to increments: coning and sculling.
//!
//! The axes of an inertial unit turn while it integrates. The rotation between two samples is therefore not the
//! integral of rate: coning. The velocity change is not the integral of specific force: rotation and sculling. Both are
//! corrected here to second order in the change of rate and third order in its size.
//!
//! # Source
//! P. G. Savage (1998), Strapdown inertial navigation integration algorithm design, *Journal of
//! Guidance, Control, and Dynamics* 21: part 1, attitude (1), 19–28; part 2, velocity and position
//! (2), 208–221. Groves, second edition, sections 5.5.4 and 5.5.5.

use crate::frames::{Body, Vector};
use crate::imu::{ImuErrors, ImuSample, Motion};
use crate::scalar::Scalar;
use crate::time::Time;

/// Motion of the inertial unit between two samples, compensated and ready for the mechanization.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Increment<T = f64> {
    /// Length of the interval, s, positive.
    pub interval_s: T,
    /// Rotation vector from the body axes at the end to those at the start, rad.
    pub rotation_rad: Vector<Body, T>,
    /// Integral of specific force, m/s, resolved in the body axes at the start.
    pub velocity_mps: Vector<Body, T>,
}

impl<T: Scalar> Increment<T> {
    /// The increment of a sample without predecessor: its rates count as constant over `interval_s`.
    #[must_use]
    pub fn of_first_sample(motion: &Motion<T>, interval_s: T, errors: &ImuErrors<T>) -> Self {
        let (rotation_rad, velocity_mps) = match *motion {
            Motion::Rates { angular_rate_radps, specific_force_mps2 } => (
                errors.rate(angular_rate_radps, T::ONE) * interval_s,
                errors.force(specific_force_mps2, T::ONE) * interval_s,
            ),
            Motion::Increments { angle_rad, velocity_mps } => {
                (errors.rate(angle_rad, interval_s), errors.force(velocity_mps, interval_s))
            }
        };
        Self { interval_s, rotation_rad, velocity_mps }
    }

    /// Angular rate at the end of the interval, rad/s, from the sample that ended it; for increments the mean over the
    /// interval.
    #[must_use]
    pub fn angular_rate(&self, motion: &Motion<T>, errors: &ImuErrors<T>) -> Vector<Body, T> {
        match *motion {
            Motion::Rates { angular_rate_radps, .. } => errors.rate(angular_rate_radps, T::ONE),
            Motion::Increments { .. } => self.rotation_rad * (T::ONE / self.interval_s),
        }
    }
}

/// Converts samples to [`Increment`]s. Keeps the previous sample, which coning and sculling need.
#[derive(Clone, Copy, Debug, Default)]
pub struct Integrator<T = f64> {
    previous: Option<Previous<T>>,
}

#[derive(Clone, Copy, Debug)]
struct Previous<T> {
    time: Time,
    motion: Motion<T>,
    interval_s: T,
}

impl<T: Scalar> Integrator<T> {
    /// State before the first sample.
    pub const EMPTY: Self = Self { previous: None };

    /// The time of the last accepted sample.
    #[must_use]
    pub fn time(&self) -> Option<Time> {
        self.previous.map(|previous| previous.time)
    }

    /// Feeds the next sample. Returns the increment since the previous one, with the known errors of the inertial unit
    /// removed.
    ///
    /// Rates count as linear between samples. Increments count as integrals of rates that are linear over this interval
    /// and the previous one.
    ///
    /// Returns `None` for the first sample. Returns `None` also for a sample that is not finite or not later than the
    /// previous one. Such a sample leaves the integrator unchanged; the first sample is stored.
    pub fn push(&mut self, sample: &ImuSample, errors: &ImuErrors<T>) -> Option<Increment<T>> {
        let motion = sample.motion.cast::<T>();
        if !motion.is_finite() {
            return None;
        }
        self.push_finite(sample.time, motion, errors)
    }

    /// [`push`](Self::push) for a motion known to be finite.
    #[inline(always)]
    pub(crate) fn push_finite(
        &mut self,
        time: Time,
        motion: Motion<T>,
        errors: &ImuErrors<T>,
    ) -> Option<Increment<T>> {
        let Some(previous) = self.previous else {
            self.previous = Some(Previous { time, motion, interval_s: T::ZERO });
            return None;
        };
        if time <= previous.time {
            return None;
        }
        let interval_s = time.seconds_since(previous.time);
        self.previous = Some(Previous { time, motion, interval_s });
        Some(match motion {
            Motion::Rates { angular_rate_radps, specific_force_mps2 } => {
                let read = |rate, force| (errors.rate(rate, T::ONE), errors.force(force, T::ONE));
                let (rate, force) = read(angular_rate_radps, specific_force_mps2);
                let (rate_before, force_before) = match previous.motion {
                    Motion::Rates { angular_rate_radps, specific_force_mps2 } => {
                        read(angular_rate_radps, specific_force_mps2)
                    }
                    Motion::Increments { .. } => (rate, force),
                };
                from_rates(interval_s, [rate_before, rate], [force_before, force])
            }
            Motion::Increments { angle_rad, velocity_mps } => {
                let read = |angle, velocity| {
                    (errors.rate(angle, interval_s), errors.force(velocity, interval_s))
                };
                let (angle, velocity) = read(angle_rad, velocity_mps);
                // The previous increment is scaled to the present interval. The first increment of a log has no known
                // length.
                let (angle_before, velocity_before) = match previous.motion {
                    Motion::Increments { angle_rad, velocity_mps }
                        if previous.interval_s > T::ZERO =>
                    {
                        let scale = interval_s / previous.interval_s;
                        read(angle_rad * scale, velocity_mps * scale)
                    }
                    _ => (angle, velocity),
                };
                from_increments(interval_s, [angle_before, angle], [velocity_before, velocity])
            }
        })
    }
}

/// Increment from rates that are linear over the interval: the integrals in closed form.
///
/// # Source
/// Equations (S2) and (S3) of docs/equations.md.
fn from_rates<T: Scalar>(
    interval_s: T,
    w: [Vector<Body, T>; 2],
    f: [Vector<Body, T>; 2],
) -> Increment<T> {
    let number = T::of;
    let angle = (w[0] + w[1]) * (number(0.5) * interval_s);
    let velocity = (f[0] + f[1]) * (number(0.5) * interval_s);
    let square = interval_s * interval_s;
    let (dw, df) = (w[1] - w[0], f[1] - f[0]);
    let turning = w[0].cross(f[0] * number(0.5) + df * number(1.0 / 3.0))
        + dw.cross(f[0] * number(1.0 / 6.0) + df * number(1.0 / 8.0));
    Increment {
        interval_s,
        rotation_rad: angle + w[0].cross(w[1]) * (square / number(12.0)),
        velocity_mps: velocity
            + turning * square
            + angle.cross(angle.cross(velocity)) * number(1.0 / 6.0),
    }
}

/// Increment from the integrals of rates that are linear over this interval and the previous one.
///
/// # Source
/// Equations (S4) and (S5) of docs/equations.md.
fn from_increments<T: Scalar>(
    interval_s: T,
    angle: [Vector<Body, T>; 2],
    velocity: [Vector<Body, T>; 2],
) -> Increment<T> {
    let sculling = angle[0].cross(velocity[1]) + velocity[0].cross(angle[1]);
    let twelfth = T::of(1.0 / 12.0);
    Increment {
        interval_s,
        rotation_rad: angle[1] + angle[0].cross(angle[1]) * twelfth,
        velocity_mps: velocity[1]
            + angle[1].cross(velocity[1]) * T::of(0.5)
            + sculling * twelfth
            + angle[1].cross(angle[1].cross(velocity[1])) * T::of(1.0 / 6.0),
    }
}
