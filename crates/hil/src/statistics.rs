//! What a live flight came to while the autopilot flew.

use hovernav::frames::{Body, Vector, wrap_angle};

use crate::plant::LiveSample;

/// A control that differs by more than this from the pilot's was moved by the autopilot.
const MOVED: f64 = 0.002;
/// So long after it took over the autopilot has settled, s.
const SETTLED_S: f64 = 5.0;

/// What a live flight came to, over all spans in which the switch was closed and the controls were not the
/// pilot's, from 5 s after the beginning of each.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LiveStatistics {
    /// How long the autopilot flew, s, its first seconds included.
    pub engaged_s: f64,
    /// How often it took over.
    pub engagements: usize,
    /// Root mean squares of u, v and w, m/s.
    pub velocity_rms_mps: [f64; 3],
    /// Farthest from the heading at engagement, rad.
    pub heading_rad: f64,
    /// Farthest from the place at which it had settled, m.
    pub place_m: f64,
    /// Largest change of any command from one cycle to the next, first seconds included.
    pub stick_step: f64,
}

impl LiveStatistics {
    /// Of the samples of a flight.
    #[must_use]
    pub fn of(samples: &[LiveSample]) -> Self {
        let mut all = Self::default();
        let (mut squares, mut count) = ([0.0; 3], 0u32);
        let mut begun: Option<&LiveSample> = None;
        let mut settled: Option<&LiveSample> = None;
        for pair in samples.windows(2) {
            let [before, now] = pair else { continue };
            if !now.switch_on || !flies(now) {
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

fn flies(sample: &LiveSample) -> bool {
    apart(sample.commanded, sample.pilot) > MOVED
}

fn apart(one: hovernav::controls::Sticks, other: hovernav::controls::Sticks) -> f64 {
    let pairs = one.to_array().into_iter().zip(other.to_array());
    pairs.map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
}
