//! A fix: equations (M3) to (M6) and (M14).

use hovernav::ekf::layout::{ACCEL_BIAS, ATTITUDE, GYRO_BIAS, Layout, POSITION, VELOCITY};
use hovernav::ekf::{Channel, Learned};
use hovernav::gps::Fix;
use nalgebra::Matrix3;

use crate::filter::Filter;
use crate::history::Back;
use crate::mechanization::{Earth, Vector, skew};
use crate::noise::{self, Relaxation};
use crate::update::Row;

/// Largest time, s, from the time stamp of a fix to a later time at which the fix is valid.
const MAX_AHEAD_S: f64 = 0.3;
/// Learned factor on the stated one-sigmas up to which they are unchanged. A larger factor is divided by this value.
const BY_CHANCE: f64 = 1.15;
/// Stated one-sigmas count as unchanged if they change by less than this factor.
const STEADY: f64 = 1.25;

const POSITIONS: [Channel; 3] =
    [Channel::PositionNorth, Channel::PositionEast, Channel::PositionDown];
const VELOCITIES: [Channel; 3] =
    [Channel::VelocityNorth, Channel::VelocityEast, Channel::VelocityDown];

/// Times at which velocity and position of a fix are valid.
#[derive(Clone, Copy, Debug)]
pub struct Moments {
    velocity: Back,
    position: Back,
    /// Whether these times are at the end of the history, where the delay is unobservable.
    is_beyond: bool,
}

impl<L: Layout<N>, const N: usize> Filter<L, N> {
    /// The state when a fix was valid: at its time minus its delay, for the position also minus its latency.
    pub fn moments(&self, fix: &Fix) -> Option<Moments> {
        let parameter = |state: Option<usize>| state.map_or(0.0, |state| self.parameters[state]);
        let delay_s = parameter(L::GPS_DELAY).max(-MAX_AHEAD_S);
        let latency_s = L::LATENCY
            .map_or(0.0, |_| (parameter(L::GPS_DELAY) + parameter(L::LATENCY)).max(-MAX_AHEAD_S));
        let reach_s = self.history.reach_s(fix.time);
        let back = |late_s: f64| {
            self.history.look_back(&self.nominal, fix.time.offset_by(-late_s.min(reach_s)))
        };
        let velocity = back(delay_s)?;
        let position = if L::LATENCY.is_some() { back(latency_s)? } else { velocity };
        Some(Moments { velocity, position, is_beyond: delay_s.max(latency_s) > reach_s })
    }

    /// One-sigmas of position, m, and velocity, m/s, NED: stated or configured, by their learned size (M7).
    fn fix_sigmas(&self, fix: &Fix, learned: &Learned) -> [Vector; 2] {
        let gps = &self.config.gps;
        let [place, level, down] = learned.gps_size.map(|size| f64::from(size).sqrt());
        let stated = |size: f64| (size / BY_CHANCE).max(1.0);
        let position = fix.position_sigma_m.map_or_else(
            || {
                Vector::new(gps.horizontal_sigma_m, gps.horizontal_sigma_m, gps.vertical_sigma_m)
                    * place
            },
            |sigma| Vector::from(sigma.to_array()) * stated(place),
        );
        let horizontal = gps.horizontal_velocity_sigma_mps;
        let velocity = match fix.velocity_sigma_mps.map(|sigma| sigma.to_array()) {
            Some([n, e, d]) => {
                // A receiver that states one accuracy for all axes states the horizontal one. PX4 takes 1.5 times as
                // much for the vertical axis.
                let d = if n == e && e == d { 1.5 * d } else { d };
                Vector::new(n * stated(level), e * stated(level), d * stated(down))
            }
            None => Vector::new(
                horizontal * level,
                horizontal * level,
                gps.vertical_velocity_sigma_mps * down.max(level),
            ),
        };
        [position, velocity]
    }

    /// Fractions of the position and velocity errors that are slow, if the layout has states for them.
    fn wander_shares(&self) -> [f64; 2] {
        let share = |state: Option<usize>, share: f64| state.map_or(0.0, |_| share);
        let gps = &self.config.gps;
        [
            share(L::GPS_POSITION, gps.position_wander_share),
            share(L::GPS_VELOCITY, gps.velocity_wander_share),
        ]
    }

    /// Adapts the slow errors to the stated accuracy of a fix (M5), or resets their variances.
    pub fn follow_wander(&mut self, fix: &Fix, learned: &Learned) {
        let [position, velocity] = self.fix_sigmas(fix, learned);
        let [slow_place, slow_velocity] = self.wander_shares();
        let level_and_down = |share: f64, sigma: &Vector| {
            let level = share * sigma.x.max(sigma.y);
            [level, level, share * sigma.z]
        };
        let place = level_and_down(slow_place, &position);
        let Some([level, down, ..]) = learned.gps_wander else {
            for (first, sigmas) in [
                (L::GPS_POSITION, place),
                (L::GPS_VELOCITY, level_and_down(slow_velocity, &velocity)),
            ] {
                for (axis, sigma) in sigmas.into_iter().enumerate() {
                    if let Some(first) = first {
                        self.open(first + axis, sigma);
                    }
                }
            }
            return;
        };
        let Some(first) = L::GPS_POSITION.filter(|_| fix.position_sigma_m.is_some()) else {
            return;
        };
        let mut change = Relaxation::none();
        for (axis, new) in place.into_iter().enumerate() {
            let old = f64::from(if axis < 2 { level } else { down });
            if new > old * STEADY || old > new * STEADY {
                // If the one-sigma shrinks, the same process runs backwards in time: w⁺ = ρ² w.
                let kept = (new / old).powi(2).min(1.0);
                change.decay[first + axis] = kept;
                change.noise[first + axis] = new.powi(2) - (kept * old).powi(2);
            }
        }
        self.apply(&change);
    }

    /// Rows of a fix: velocity north, east, down, then position. `antenna_m` is the offset of the antenna from its
    /// declared position, for velocity and for position, body axes.
    pub fn fix_rows(
        &self,
        fix: &Fix,
        moments: &Moments,
        learned: &Learned,
        antenna_m: [Vector; 2],
    ) -> Vec<Row<N>> {
        let declared_m = Vector::from(self.mounting.antenna_from_imu().0.to_array());
        let [for_velocity, for_position] = antenna_m.map(|off_m| declared_m + off_m);
        let mut rows = self.velocity_rows(fix, moments, learned, &for_velocity);
        rows.extend(self.position_rows(fix, moments, learned, &for_position));
        rows
    }

    /// Velocity rows (M4), with H by (M2).
    fn velocity_rows(
        &self,
        fix: &Fix,
        moments: &Moments,
        learned: &Learned,
        arm_m: &Vector,
    ) -> Vec<Row<N>> {
        let back = &moments.velocity;
        let cosines = back.state.cosines();
        let swing_mps = cosines * back.rate_radps.cross(arm_m);
        let wander = L::GPS_VELOCITY.map_or(Vector::zeros(), |first| self.block(first));
        let predicted = back.state.velocity_mps + swing_mps + wander;
        let level = fix.horizontal_velocity_mps;
        let measured = [
            level.map(|velocity| velocity[0]),
            level.map(|velocity| velocity[1]),
            fix.down_velocity_mps.filter(|_| !fix.two_dimensional),
        ];
        let force_integral_mps = of_motion(&back.force_mps, learned);
        // δv(t) = δv + F × δψ + J δb_a, minus the swing × δψ, and the swing due to the gyro biases.
        let by_attitude = skew(&force_integral_mps) - skew(&swing_mps);
        let by_gyro = cosines * skew(arm_m);
        let imu = &self.config.imu;
        let alike_s = imu.accel_vibration_time_s;
        let [_, vibration] = &learned.vibration;
        let (walk, share) = (imu.velocity_random_walk_mps, imu.accel_vibration_share);
        let acceleration_variance =
            noise::density(walk, share, alike_s, vibration).sum() / back.acceleration_over_s;
        let by_delay = significant(-back.acceleration_mps2, acceleration_variance);
        let sigmas = self.fix_sigmas(fix, learned);
        let [_, slow] = self.wander_shares();
        // Variance from the remaining antenna offset, for turns about the vertical of a nearly level vehicle; in single
        // precision.
        let turning_radps = (cosines * back.rate_radps).z as f32;
        let is_turn = turning_radps.abs() >= 0.1 && cosines[(2, 2)] as f32 >= 0.8;
        let unsure = f64::from(turning_radps * turning_radps * learned.antenna.1);
        let unsure = if is_turn && level.is_some() { unsure } else { 0.0 };
        let smoothing_s = self.config.gps.velocity_smoothing_s;
        let mut rows = Vec::new();
        for (axis, measured) in measured.into_iter().enumerate() {
            let Some(measured) = measured else { continue };
            let white = white_variance(slow, sigmas[1][axis], self.config.gps.velocity_floor_mps);
            let noise = white
                + self.lag_noise(back, 1.0)
                + (smoothing_s * back.acceleration_mps2[axis]).powi(2)
                + if axis < 2 { unsure } else { 0.0 };
            let mut row = Row::new(VELOCITIES[axis], measured - predicted[axis], noise)
                .sees(VELOCITY + axis, 1.0)
                .sees_block(ATTITUDE, line(&by_attitude, axis))
                .sees_block(GYRO_BIAS, line(&by_gyro, axis))
                .sees_block(ACCEL_BIAS, line(&back.turn_s, axis));
            if let Some(first) = L::GPS_VELOCITY {
                row = row.sees(first + axis, 1.0);
            }
            if let Some(state) = L::GPS_DELAY.filter(|_| !moments.is_beyond) {
                row = row.sees(state, by_delay[axis]);
            }
            rows.push(row);
        }
        rows
    }

    /// Position rows (M3), with H by (M2).
    fn position_rows(
        &self,
        fix: &Fix,
        moments: &Moments,
        learned: &Learned,
        arm_m: &Vector,
    ) -> Vec<Row<N>> {
        let back = &moments.position;
        let cosines = back.state.cosines();
        let lever_m = cosines * arm_m;
        let wander = L::GPS_POSITION.map_or(Vector::zeros(), |first| self.block(first));
        let earth = Earth::at(&self.nominal.place);
        let off_m = earth.displacement(&back.state.place, &fix.position) - lever_m - wander;
        // δp(t) = δp − a δv − G × δψ − ½ a J δb_a, minus the lever × δψ(t), δψ(t) = δψ + J δb_g.
        let fallen_m = of_motion(&back.force_m, learned);
        let by_attitude = -skew(&fallen_m) - skew(&lever_m);
        let by_gyro = -skew(&lever_m) * back.turn_s;
        let by_accel = back.turn_s * (-0.5 * back.age_s);
        let velocity_variance = self.covariance.fixed_view::<3, 3>(VELOCITY, VELOCITY).trace();
        let antenna_mps = back.state.velocity_mps + cosines * back.rate_radps.cross(arm_m);
        let by_delay = significant(-antenna_mps, velocity_variance);
        let [sigmas, _] = self.fix_sigmas(fix, learned);
        let [slow, _] = self.wander_shares();
        let axes = if fix.two_dimensional { 2 } else { 3 };
        let mut rows = Vec::new();
        for axis in 0..axes {
            let scatter = learned.position_scatter * sigmas[axis].powi(2);
            let white = white_variance(slow, sigmas[axis], self.config.gps.position_floor_m);
            let white = white.max(scatter);
            let noise = white + self.lag_noise(back, back.age_s);
            let mut row = Row::new(POSITIONS[axis], off_m[axis], noise)
                .sees(POSITION + axis, 1.0)
                .sees(VELOCITY + axis, -back.age_s)
                .sees_block(ATTITUDE, line(&by_attitude, axis))
                .sees_block(GYRO_BIAS, line(&by_gyro, axis))
                .sees_block(ACCEL_BIAS, line(&by_accel, axis));
            if let Some(first) = L::GPS_POSITION {
                row = row.sees(first + axis, 1.0);
            }
            for state in [L::LATENCY, L::GPS_DELAY].into_iter().flatten() {
                if !moments.is_beyond {
                    row = row.sees(state, by_delay[axis]);
                }
            }
            rows.push(row);
        }
        rows
    }

    /// Noise by the latency (M6), times the square of the velocity's factor.
    fn lag_noise(&self, back: &Back, lever: f64) -> f64 {
        let imu = &self.config.imu;
        let walk = imu.velocity_random_walk_mps.powi(2) * back.age_s.max(0.0);
        (walk + (imu.gap_acceleration_mps2 * back.hidden_s).powi(2)) * lever.powi(2)
    }
}

/// White part of R (M5).
fn white_variance(slow: f64, sigma: f64, floor: f64) -> f64 {
    ((1.0 - slow * slow) * sigma * sigma).max(floor * floor)
}

/// Part of a specific force that makes the heading observable. Its horizontal part counts by the fraction that is
/// motion (K23).
fn of_motion(force: &Vector, learned: &Learned) -> Vector {
    let share = learned.level_share;
    Vector::new(share * force.x, share * force.y, force.z)
}

/// The function s(x) of (M14).
fn significant(x: Vector, variance: f64) -> Vector {
    x * (1.0 - variance / x.norm_squared()).max(0.0)
}

/// One row of a matrix.
fn line(of: &Matrix3<f64>, row: usize) -> [f64; 3] {
    of.row(row).transpose().into()
}
