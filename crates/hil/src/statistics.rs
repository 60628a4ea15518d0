//! Statistics of a live flight while the autopilot flew.

use hovernav::frames::{Body, Vector, wrap_angle};

use crate::plant::LiveSample;

/// Smallest difference between a command and the pilot's control that shows that the autopilot moves it.
const MOVED: f64 = 0.002;
/// Largest delay, cycles, from the pilot's sticks to the servos on a busy machine.
const LATELY: usize = 12;
/// Time from engagement until the autopilot has settled, s.
const SETTLED_S: f64 = 5.0;

/// Statistics of a live flight over the spans in which the switch was closed and the autopilot moved the controls.
/// Unless stated otherwise, the first 5 s of each engagement are excluded.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LiveStatistics {
    /// Total time flown by the autopilot, s, including the first 5 s of each engagement.
    pub engaged_s: f64,
    /// Number of engagements.
    pub engagements: usize,
    /// Root mean squares of u, v and w, m/s.
    pub velocity_rms_mps: [f64; 3],
    /// Largest difference from the heading at engagement, rad.
    pub heading_rad: f64,
    /// Largest horizontal distance from the position at which the autopilot had settled, m.
    pub place_m: f64,
    /// Largest change of any command from one cycle to the next, including the first 5 s of each engagement.
    pub stick_step: f64,
}

impl LiveStatistics {
    /// The statistics of the samples of a flight.
    #[must_use]
    pub fn of(samples: &[LiveSample]) -> Self {
        let mut all = Self::default();
        let (mut squares, mut count) = ([0.0; 3], 0u32);
        let mut begun: Option<&LiveSample> = None;
        let mut settled: Option<&LiveSample> = None;
        for (at, pair) in samples.windows(2).enumerate() {
            let [before, now] = pair else { continue };
            let lately = samples.get((at + 1).saturating_sub(LATELY)..=at + 1).unwrap_or_default();
            if !now.switch_on || !flies(now, lately) {
                if !now.switch_on {
                    (begun, settled) = (None, None);
                }
                continue;
            }
            let start = *begun.get_or_insert_with(|| {
                all.engagements += 1;
                now
            });
            all.engaged_s += now.truth.time - before.truth.time;
            all.stick_step = all.stick_step.max(apart(before.commanded, now.commanded));
            if now.truth.time - start.truth.time < SETTLED_S {
                continue;
            }
            let place = settled.get_or_insert(now).truth.position;
            let [north, east, _] = now.truth.position.displacement_from(&place).to_array();
            all.place_m = all.place_m.max(north.hypot(east));
            let velocity: Vector<Body> = now.truth.body_to_ned.inverse() * now.truth.velocity_mps;
            for (sum, component) in squares.iter_mut().zip(velocity.to_array()) {
                *sum += component * component;
            }
            count += 1;
            let yaw = |sample: &LiveSample| sample.truth.body_to_ned.euler().yaw_rad;
            all.heading_rad = all.heading_rad.max(wrap_angle(yaw(now) - yaw(start)).abs());
        }
        all.velocity_rms_mps = squares.map(|sum| (sum / f64::from(count.max(1))).sqrt());
        all
    }
}

/// Whether the autopilot flies: the commanded controls differ from each of the pilot's sticks in `lately`. The pilot's
/// sticks reach the servos some cycles late.
fn flies(now: &LiveSample, lately: &[LiveSample]) -> bool {
    lately.iter().all(|sample| apart(now.commanded, sample.pilot) > MOVED)
}

fn apart(one: hovernav::controls::Sticks, other: hovernav::controls::Sticks) -> f64 {
    let pairs = one.to_array().into_iter().zip(other.to_array());
    pairs.map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::controls::Sticks;
    use hovernav::earth::Geodetic;
    use hovernav::frames::Rotation;
    use hovernav::time::Time;
    use hovernav_dataset::Truth;

    #[test]
    fn delayed_sticks_of_the_pilot_do_not_count_as_the_autopilot() {
        let stick = |cycle: usize| Sticks { pedal: 0.01 * cycle as f64, ..Sticks::NEUTRAL };
        let sample = |cycle: usize, pilot: Sticks, commanded: Sticks| LiveSample {
            truth: Truth {
                time: Time::ZERO + 0.03 * cycle as f64,
                position: Geodetic::from_degrees(1.35, 103.82, 50.0).unwrap(),
                velocity_mps: Vector::ZERO,
                body_to_ned: Rotation::IDENTITY,
                angular_rate_radps: Vector::ZERO,
            },
            pilot,
            commanded,
            switch_on: true,
            wind_mps: Vector::ZERO,
        };
        let by_hand: Vec<LiveSample> = (0..40)
            .map(|cycle| sample(cycle, stick(cycle), stick(cycle.saturating_sub(3))))
            .collect();
        assert_eq!(LiveStatistics::of(&by_hand), LiveStatistics::default());
        let flown: Vec<LiveSample> =
            (0..40).map(|cycle| sample(cycle, Sticks::NEUTRAL, stick(cycle))).collect();
        let found = LiveStatistics::of(&flown);
        assert_eq!(found.engagements, 1);
        assert!((found.engaged_s - 39.0 * 0.03).abs() < 0.05, "{found:?}");
    }
}
