//! Receivers in static hold: they repeat a position or a velocity of zero while the vehicle moves.

use std::collections::BTreeMap;

/// Length of the parts of a flight that are compared, s.
pub(crate) const PART_S: f64 = 10.0;
/// Smallest distance between the first and the last position of a part that counts as motion, m. A receiver at rest
/// drifts less.
const MOVES_M: f64 = 6.0;
/// Metres per degree of latitude.
const METRES_PER_DEG: f64 = 111_000.0;

/// Positions and velocities of each receiver of a vehicle, in the order of the log.
#[derive(Debug)]
pub(crate) struct Tracks<K>(BTreeMap<K, Track>);

/// Positions and velocities of a receiver, in the order of the log.
#[derive(Debug, Default)]
struct Track(Vec<Reading>);

#[derive(Clone, Copy, Debug)]
struct Reading {
    time_s: f64,
    place_deg: [f64; 2],
    /// Velocity north and east, or the speed; NaN if unknown.
    velocity_mps: [f64; 2],
}

impl<K> Default for Tracks<K> {
    fn default() -> Self {
        Self(BTreeMap::new())
    }
}

impl<K: Ord> Tracks<K> {
    /// Adds a reading of `receiver`: time, latitude and longitude, velocity north and east, or the speed and NaN.
    pub fn push(&mut self, receiver: K, time_s: f64, place_deg: [f64; 2], velocity_mps: [f64; 2]) {
        let is_known = time_s.is_finite() && place_deg.iter().all(|angle| angle.is_finite());
        if is_known {
            let track = self.0.entry(receiver).or_default();
            track.0.push(Reading { time_s, place_deg, velocity_mps });
        }
    }

    /// Number of readings of `receiver` in static hold: those of parts of the flight in which the position stays exactly
    /// the same while another receiver moves, or the velocity is exactly zero while a position moves. At rest, nothing
    /// is in hold.
    pub fn held(&self, receiver: &K) -> usize {
        let others = self.0.iter().filter(|(other, _)| *other != receiver);
        let others = others.map(|(_, track)| track);
        self.0.get(receiver).map_or(0, |track| track.held(others))
    }
}

impl Track {
    fn held<'a>(&self, others: impl Iterator<Item = &'a Self> + Clone) -> usize {
        let part = |reading: &Reading| (reading.time_s / PART_S).floor();
        let parts = self.0.chunk_by(|a, b| part(a) == part(b));
        let is_held = |readings: &&[Reading]| {
            let [first, .., last] = readings else { return false };
            let is_same = readings.iter().all(|reading| reading.place_deg == first.place_deg);
            let is_still = readings.iter().all(Reading::is_still);
            let mut other = others.clone().map(|other| other.moved_m(first.time_s, last.time_s));
            (is_same || is_still) && other.any(|moved_m| moved_m > MOVES_M)
                || is_still && moved_m(readings) > MOVES_M
        };
        parts.filter(is_held).map(<[Reading]>::len).sum()
    }

    /// Distance between the first and the last position from `from_s` to `to_s`, m.
    fn moved_m(&self, from_s: f64, to_s: f64) -> f64 {
        let first = self.0.partition_point(|reading| reading.time_s < from_s);
        let last = self.0.partition_point(|reading| reading.time_s <= to_s);
        self.0.get(first..last).map_or(0.0, moved_m)
    }
}

impl Reading {
    /// Whether the velocity is known, and exactly zero.
    fn is_still(&self) -> bool {
        let [first, second] = self.velocity_mps;
        first == 0.0 && (second == 0.0 || second.is_nan())
    }
}

/// Distance between the first and the last position, m.
fn moved_m(readings: &[Reading]) -> f64 {
    let [first, .., last] = readings else { return 0.0 };
    let [north, east] = [0, 1].map(|axis| last.place_deg[axis] - first.place_deg[axis]);
    METRES_PER_DEG * north.hypot(east * first.place_deg[0].to_radians().cos())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A minute at rest, then a minute north at 3 m/s, at 5 Hz. `hold` maps the latitude and the speed to the readings.
    fn add(tracks: &mut Tracks<u8>, receiver: u8, hold: &dyn Fn(f64, f64) -> (f64, f64)) {
        for k in 0..600 {
            let time_s = 0.2 * f64::from(k);
            let moved_s = (time_s - 60.0).max(0.0);
            let speed_mps = if moved_s > 0.0 { 3.0 } else { 0.0 };
            let (lat, speed) = hold(47.0 + 3.0 * moved_s / METRES_PER_DEG, speed_mps);
            tracks.push(receiver, time_s, [lat, 8.5], [speed, 0.0]);
        }
    }

    #[test]
    fn only_what_repeats_in_motion_is_in_hold() {
        let right: fn(f64, f64) -> (f64, f64) = |lat, speed| (lat, speed);
        let noisy = |lat: f64, speed| (lat + 1e-5 * (1e9 * lat).sin(), speed + 0.1);
        for (what, held, expected) in [
            ("right, and exactly at rest for a minute", right, 0),
            ("position in hold", |_, speed| (47.0, speed + 0.1), 300),
            ("velocity in hold", |lat, _| (lat, 0.0), 300),
            ("both", |_, _| (47.0, 0.0), 300),
        ] {
            for other in [right, noisy] {
                let mut tracks = Tracks::default();
                add(&mut tracks, 0, &held);
                add(&mut tracks, 1, &other);
                let found = tracks.held(&0);
                assert!(found.abs_diff(expected) <= 50, "{what}: {found}");
            }
        }
        let mut alone = Tracks::default();
        add(&mut alone, 0, &right);
        assert_eq!(alone.held(&0), 0);
    }
}
