//! Distance to the ground, along the beam of a rangefinder.

use super::super::covariance::Sensitivity;
use super::super::estimator_config::Rangefinder;
use super::super::filter::Ekf;
use super::super::gate::Group;
use super::super::innovation::Channel;
use super::super::layout::{ATTITUDE, Layout, POSITION};
use super::super::scalar::Scalar;
use super::super::square;
use super::super::trace::Trace;
use super::{Report, ScalarMeasurement, Unusable};
use crate::event::RangeReading;
use crate::frames::{Ned, Vector};
use crate::time::Time;

/// Memory of the ground, and of its last reading.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    /// Height of the ground above the ellipsoid, m, from the first reading; the state is the difference from it.
    pub height_m: Option<f64>,
    last: Option<Seen>,
}

/// The last reading, and the time since which its value has been the same.
#[derive(Clone, Copy, Debug)]
struct Seen {
    time: Time,
    range_m: f64,
    /// Point where the beam hit the ground, north and east of the inertial unit, m.
    hit_m: [f32; 2],
    since: Time,
    /// Horizontal part of the beam's direction at `since`.
    beam: [f32; 2],
    /// Distance travelled since `since`, m.
    moved_m: f32,
}

impl Ground {
    /// The memory before the first reading.
    pub const UNKNOWN: Self = Self { height_m: None, last: None };

    /// Notes a reading. Its beam, in NED and of length one, hits the ground at `hit` from the inertial unit, which
    /// moves at `velocity_mps`. Returns the distance that the spot moved over the ground since the last reading, m.
    fn see(
        &mut self,
        reading: &RangeReading,
        beam: Vector<Ned>,
        hit: Vector<Ned>,
        velocity_mps: Vector<Ned>,
    ) -> f64 {
        let hit_m = [hit.x() as f32, hit.y() as f32];
        let beam = [beam.x() as f32, beam.y() as f32];
        let time = reading.time;
        let anew = Seen { time, range_m: reading.range_m, hit_m, since: time, beam, moved_m: 0.0 };
        let Some(last) = self.last else {
            self.last = Some(anew);
            return 0.0;
        };
        let elapsed_s = (time - last.time).clamp(0.0, LONGEST_S);
        let [from_north, from_east] = last.hit_m.map(f64::from);
        let wandered_m = Scalar::hypot(
            velocity_mps.x() * elapsed_s + hit.x() - from_north,
            velocity_mps.y() * elapsed_s + hit.y() - from_east,
        );
        let same = reading.range_m.to_bits() == last.range_m.to_bits();
        let way_m = (velocity_mps.norm() - STANDING_MPS).max(0.0) * elapsed_s;
        self.last = Some(if same {
            Seen { time, hit_m, moved_m: last.moved_m + way_m as f32, ..last }
        } else {
            anew
        });
        wandered_m
    }

    /// Whether the last reading repeats the previous ones although the vehicle moves.
    fn is_stuck(&self, beam: Vector<Ned>) -> bool {
        self.last.is_some_and(|last| {
            let [north, east] = last.beam.map(f64::from);
            let turned = Scalar::hypot(beam.x() - north, beam.y() - east);
            last.time - last.since >= STUCK_S
                && (turned > TURNED_RAD || f64::from(last.moved_m) > MOVED_M)
        })
    }
}

/// Longest interval between two readings that counts, s: beyond it the path of the beam is unknown.
const LONGEST_S: f64 = 10.0;
/// Time, s, for which a distance must repeat bit for bit during a motion before the sensor counts as stuck.
const STUCK_S: f64 = 1.0;
/// Smallest turn of the beam, rad, that counts as such a motion.
const TURNED_RAD: f64 = 0.02;
/// Smallest path, m, that counts as such a motion.
const MOVED_M: f64 = 0.3;
/// Speed, m/s, that adds nothing to that path.
const STANDING_MPS: f64 = 0.3;
/// Minimum downward component of the beam's direction: the cosine of 60°.
const LEAST_DOWN: f64 = 0.5;
/// Factor by which the initial one-sigma of the ground's height exceeds that of height and first reading. The first
/// reading then changes the variance of the height by at most a hundredth.
const OPENED: f64 = 10.0;
/// Smallest innovation, in one-sigmas, of a reading within the gate that counts as a step of the ground.
const STEP_SIGMAS: f64 = 4.0;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Fuses a distance to the ground. A distance that jumps is rejected at first, then attributed to other ground.
    ///
    /// # Errors
    /// [`Unusable`] if the distance cannot be compared.
    ///
    /// # Source
    /// Equation (M12) of docs/equations.md.
    // Not inlined, so that its stack frame is not part of a caller's that updates several sensors.
    #[inline(never)]
    pub fn update_range(
        &mut self,
        reading: &RangeReading,
        rangefinder: &Rangefinder,
        trace: &mut impl Trace<T, N>,
    ) -> Result<Report, Unusable> {
        let state = L::GROUND.ok_or(Unusable::NoState)?;
        let model = &rangefinder.model;
        let RangeReading { time, range_m, .. } = *reading;
        if !reading.is_possible() {
            return Err(Unusable::NotFinite);
        }
        let body_to_ned = self.state.body_to_ned.cast();
        let velocity_mps = self.state.velocity_mps.cast();
        let from_imu = rangefinder.lever_arm_m - self.mounting.imu_lever_arm_m;
        let beam = body_to_ned * rangefinder.beam;
        let hit = body_to_ned * from_imu + beam * range_m;
        let wandered_m = self.ground.see(reading, beam, hit, velocity_mps);
        if self.ground.is_stuck(beam) {
            return Err(Unusable::Stuck);
        }
        let vouched = reading.quality.is_none_or(|quality| quality >= model.least_quality);
        if !(model.least_m..=model.most_m).contains(&range_m) || !vouched {
            return Err(Unusable::OutOfRange);
        }
        if beam.z() < LEAST_DOWN {
            return Err(Unusable::TooTilted);
        }
        let age_s = self.age_s(time)?;
        self.relax(trace);
        // The height at the time of the reading.
        let own_m = self.state.position.height_m + velocity_mps.z() * age_s;
        let white_m = reading.sigma_m.unwrap_or(model.noise_m).max(LEAST_NOISE_M);
        let noise = square(white_m) + square(model.noise_share * range_m);
        let height_m = if let Some(height_m) = self.ground.height_m {
            self.open_parameter(state, square(model.ground_walk_m) * wandered_m, trace);
            height_m
        } else {
            let variance = self.covariance.variance(POSITION + 2) + noise;
            self.covariance.set_variance(state, 0.0);
            self.open_parameter(state, square(OPENED) * variance, trace);
            if let Some(parameter) = self.parameters.get_mut(state) {
                *parameter = T::ZERO;
            }
            *self.ground.height_m.insert(own_m - hit.z())
        };
        let per_metre = 1.0 / beam.z();
        // If the reading is too long, the spot lies below the ground there.
        let innovation = (hit.z() - (own_m - height_m - self.parameter(state))) * per_metre;
        let sensitivity = Sensitivity::default()
            .with_block(ATTITUDE, [-hit.y() * per_metre, hit.x() * per_metre, 0.0].map(T::of))
            .with(POSITION + 2, T::of(-per_metre))
            .with(state, T::of(-per_metre));
        let variance = self.covariance.project(&sensitivity).1.wide() + noise;
        let steps = square(STEP_SIGMAS)..=square(self.config.gate.sigmas);
        if steps.contains(&(square(innovation) / variance)) {
            self.open_parameter(state, square(innovation), trace);
        }
        let mut scalars: [Option<ScalarMeasurement<T>>; 6] = [None; 6];
        let channel = (Channel::Range, Group::Range);
        scalars[0] = Some(ScalarMeasurement {
            sensitivity,
            ..ScalarMeasurement::new(channel, T::of(innovation), T::of(noise))
        });
        let mut report = Report::default();
        self.update_sequentially(time, &scalars, &mut report, trace);
        Ok(report)
    }
}

/// Minimum one-sigma of a reading, m.
const LEAST_NOISE_M: f64 = 0.005;
