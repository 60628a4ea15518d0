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

/// What is remembered of the ground, and of the last reading of it.
#[derive(Clone, Copy, Debug)]
pub struct Ground {
    /// Its height above the ellipsoid, m, as the first reading had it; the state is what it differs by.
    pub height_m: Option<f64>,
    last: Option<Seen>,
}

/// A reading, and since when it has been the same.
#[derive(Clone, Copy, Debug)]
struct Seen {
    time: Time,
    range_m: f64,
    /// Where the beam hit, north and east of the inertial unit, m.
    hit_m: [f32; 2],
    since: Time,
    /// Horizontal part of the beam's direction then.
    beam: [f32; 2],
    /// Way since, m.
    moved_m: f32,
}

impl Ground {
    /// Nothing is known.
    pub const UNKNOWN: Self = Self { height_m: None, last: None };

    /// Notes a reading whose beam, in NED and of length one, hits at `hit_m` from the inertial unit, which
    /// moves at `velocity_mps`. Gives how far the spot has wandered over the ground since the last reading, m.
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

    /// Whether the last reading is the one before again, and again, of a vehicle that moves.
    fn is_stuck(&self, beam: Vector<Ned>) -> bool {
        self.last.is_some_and(|last| {
            let [north, east] = last.beam.map(f64::from);
            let turned = Scalar::hypot(beam.x() - north, beam.y() - east);
            last.time - last.since >= STUCK_S
                && (turned > TURNED_RAD || f64::from(last.moved_m) > MOVED_M)
        })
    }
}

/// No more than this, s, is counted between two readings: nobody knows where the beam went.
const LONGEST_S: f64 = 10.0;
/// No sensor tells the same distance to the last bit for this long, s, of a vehicle that has turned by
/// so much, rad, or gone so far, m, at more than this speed, m/s.
const STUCK_S: f64 = 1.0;
const TURNED_RAD: f64 = 0.02;
const MOVED_M: f64 = 0.3;
const STANDING_MPS: f64 = 0.3;
/// The beam leads down by at least the cosine of 60°.
const LEAST_DOWN: f64 = 0.5;
/// The height of the ground opens by so many times what the first reading leaves it: what that costs the
/// height is a hundredth of its variance.
const OPENED: f64 = 10.0;
/// An innovation beyond so many one-sigmas, but within the gate, is taken for a step of the ground.
const STEP_SIGMAS: f64 = 4.0;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Takes in a distance to the ground. Where it jumps it is refused, then taken for another ground.
    ///
    /// # Errors
    /// [`Unusable`] when it cannot be compared.
    ///
    /// # Source
    /// Equation (M12) of docs/equations.md.
    // Its frame would stand beneath the other sensors of whoever calls all of them.
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
        // The height when the reading was true.
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
        // The spot lies further down than the ground there, where the reading is too long.
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

/// No reading is better than this, m.
const LEAST_NOISE_M: f64 = 0.005;
