//! The process model: the transition of the error state over one step, and the noise it adds.
#![expect(clippy::indexing_slicing, reason = "axes count from 0 to 2, in arrays of three")]

use super::covariance::Transition;
use super::filter::Ekf;
use super::layout::{ACCEL_BIAS, GYRO_BIAS, Layout, POSITION};
use super::scalar::Scalar;
use super::square;
use crate::frames::{Body, Ned, Rotation};
use crate::imu::ImuSample;
use crate::ins::{Advance, Increment};

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    pub(super) fn watch_vibration(&mut self, sample: &ImuSample, interval_s: f64, gap: bool) {
        if gap {
            self.samples.gyro_vibration.interrupt();
            self.samples.accel_vibration.interrupt();
        }
        let mean = sample.motion.mean_rates(interval_s);
        self.samples.gyro_vibration.push(mean.angular_rate_radps, interval_s);
        self.samples.accel_vibration.push(mean.specific_force_mps2, interval_s);
    }

    /// Equations (K4) and (K5) of docs/equations.md.
    pub(super) fn transition(
        &self,
        increment: &Increment,
        advance: &Advance,
        body_to_ned: Rotation<Body, Ned>,
        gap: bool,
    ) -> Transition<T, N> {
        let interval_s = increment.interval_s;
        let imu = &self.config.imu;
        let c = body_to_ned.matrix().transpose().to_cols_array_2d();
        let scaled =
            |factors: [f64; 3]| c.map(|row| core::array::from_fn(|k| T::of(row[k] * factors[k])));
        let mut decay = [T::ONE; N];
        let mut noise = [T::ZERO; N];
        let mut markov = |first: usize, sigmas: [f64; 3], time_s: f64| {
            let lost = interval_s / time_s;
            for (axis, sigma) in sigmas.into_iter().enumerate() {
                if let (Some(decay), Some(noise)) =
                    (decay.get_mut(first + axis), noise.get_mut(first + axis))
                {
                    // exp(−x) to second order; steps are far shorter than any correlation time.
                    *decay = T::of((1.0 - lost * (1.0 - 0.5 * lost)).max(0.0));
                    *noise = T::of(2.0 * sigma * sigma * lost.min(0.5));
                }
            }
        };
        markov(GYRO_BIAS, [imu.gyro_bias_sigma_radps; 3], imu.gyro_bias_time_s);
        markov(ACCEL_BIAS, [imu.accel_bias_sigma_mps2; 3], imu.accel_bias_time_s);
        let [position_h, position_v, velocity_h, velocity_v] = self.gps_wander.unwrap_or_default();
        if let Some(first) = L::GPS_POSITION {
            let sigmas = [position_h, position_h, position_v];
            markov(first, sigmas, self.config.gps.position_wander_time_s);
        }
        if let Some(first) = L::GPS_VELOCITY {
            let sigmas = [velocity_h, velocity_h, velocity_v];
            markov(first, sigmas, self.config.gps.velocity_wander_time_s);
        }
        if let Some(first) = L::ATTITUDE_REFERENCE {
            let attitude = &self.config.attitude;
            let (tilt, heading) = (attitude.tilt_wander_rad, attitude.heading_wander_rad);
            markov(first, [tilt, tilt, heading], attitude.wander_time_s);
        }
        if let Some(state) = L::BARO {
            let (wander, time_s) = (self.config.baro.wander_m, self.config.baro.wander_time_s);
            markov(state, [wander, 0.0, 0.0], time_s);
        }
        let hidden_velocity = if gap { imu.gap_acceleration_mps2 * interval_s } else { 0.0 };
        let hidden_angle =
            if gap { (imu.gap_rate_radps * interval_s).min(MOST_HIDDEN_RAD) } else { 0.0 };
        for state in noise.iter_mut().skip(POSITION).take(3) {
            *state = T::of(square(0.5 * hidden_velocity * interval_s));
        }
        let sensed = |walk: f64, share: f64, alike_s: f64, vibration: [f64; 3], hidden: f64| {
            let alike_s = alike_s.max(interval_s);
            vibration.map(|variance| {
                square(walk).max(square(share) * variance * alike_s) * interval_s + square(hidden)
            })
        };
        let gyro = sensed(
            imu.angle_random_walk_rad,
            imu.gyro_vibration_share,
            interval_s,
            self.samples.gyro_vibration.variance(),
            hidden_angle,
        );
        let accel = sensed(
            imu.velocity_random_walk_mps,
            imu.accel_vibration_share,
            imu.accel_vibration_time_s,
            self.samples.accel_vibration.variance(),
            hidden_velocity,
        );
        Transition {
            interval_s: T::of(interval_s),
            turn: scaled([interval_s; 3]),
            force: advance.from_specific_force_mps.to_array().map(T::of),
            scaled_rotation: scaled(increment.rotation_rad.to_array()),
            scaled_velocity: scaled(increment.velocity_mps.to_array()),
            decay,
            attitude_noise: turned(&c, gyro),
            velocity_noise: turned(&c, accel),
            noise,
        }
    }
}

/// No gap opens the attitude further than this, rad: beyond it no linearisation holds.
pub(super) const MOST_HIDDEN_RAD: f64 = 0.5;

/// C diag(v) Cᵀ, upper triangle by rows.
fn turned<T: Scalar>(c: &[[f64; 3]; 3], variance: [f64; 3]) -> [T; 6] {
    let entry = |i: usize, j: usize| {
        T::of(
            c[i][0] * variance[0] * c[j][0]
                + c[i][1] * variance[1] * c[j][1]
                + c[i][2] * variance[2] * c[j][2],
        )
    };
    [entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)]
}
