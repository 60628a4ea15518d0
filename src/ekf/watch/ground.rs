//! The ground beneath a rangefinder, and the readings of it.

use crate::event::RangeReading;
use crate::frames::{Ned, Vector};
use crate::scalar::Scalar;
use crate::time::Time;

/// Memory of the ground, and of its last reading.
#[derive(Clone, Copy, Debug)]
pub(in crate::ekf) struct Ground {
    /// Height of the ground above the ellipsoid, m, from the first reading; the state is the difference from it.
    pub height_m: Option<f64>,
    last: Option<LastReading>,
}

/// The last reading, and the time of the first reading with the same value.
#[derive(Clone, Copy, Debug)]
struct LastReading {
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

    /// Stores a reading. Its beam, in NED and of length one, hits the ground at `hit` from the inertial unit, which
    /// moves at `velocity_mps`. Returns the distance that the spot moved over the ground since the last reading, m.
    pub fn see(
        &mut self,
        reading: &RangeReading,
        beam: Vector<Ned>,
        hit: Vector<Ned>,
        velocity_mps: Vector<Ned>,
    ) -> f64 {
        let hit_m = [hit.x() as f32, hit.y() as f32];
        let beam = [beam.x() as f32, beam.y() as f32];
        let time = reading.time;
        let anew =
            LastReading { time, range_m: reading.range_m, hit_m, since: time, beam, moved_m: 0.0 };
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
            LastReading { time, hit_m, moved_m: last.moved_m + way_m as f32, ..last }
        } else {
            anew
        });
        wandered_m
    }

    /// Whether the last reading repeats the previous ones although the vehicle moves.
    pub fn is_stuck(&self, beam: Vector<Ned>) -> bool {
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
/// Smallest turn of the beam, rad, that counts as a motion of the vehicle.
const TURNED_RAD: f64 = 0.02;
/// Smallest path, m, that counts as a motion of the vehicle.
const MOVED_M: f64 = 0.3;
/// Speed, m/s, that is subtracted before the path is summed, so that a vehicle at rest has no path.
const STANDING_MPS: f64 = 0.3;
