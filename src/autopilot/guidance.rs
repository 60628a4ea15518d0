//! Guidance: from set-points to references of velocity and heading.

use super::check::{ConfigError, within};
use crate::earth::{Geodetic, LocalEarth};
use crate::ekf::Solution;
use crate::frames::{Ned, Vector, wrap_angle};
use crate::scalar::Scalar;

/// Double pole of the reference velocity, 1/s: it follows the wanted velocity with this pole.
const FOLLOWS_PER_S: f64 = 8.0;
/// Double pole of the reference velocity, 1/s, while the vehicle stops after engagement. From 0.5 m/s, the largest tilt
/// is 1.1°.
const STOPS_PER_S: f64 = 1.0;
/// Difference of velocity, m/s, and acceleration, m/s², below which the reference is set to the wanted velocity.
const REACHED: f64 = 1e-9;
/// Largest rate of change of the commanded acceleration, m/s³: at 33 Hz, 0.7° of tilt a sample.
const HARDEST_JERK_MPS3: f64 = 4.0;

/// Largest acceleration of a turn at speed, as a fraction of the largest horizontal acceleration.
const TURNING: f64 = 0.8;

/// A set-point of the autopilot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SetPoint {
    /// Stop, and hold the position where the vehicle stops.
    Hold,
    /// Fly to a position and hold it.
    Position {
        /// The position.
        position: Geodetic,
        /// The heading to turn to, rad; `None` keeps the current heading.
        heading_rad: Option<f64>,
    },
    /// Fly at a steady velocity: slow forward flight.
    Velocity {
        /// Velocity in the direction of the heading, m/s.
        forward_mps: f64,
        /// Velocity to the right of the heading, m/s.
        right_mps: f64,
        /// Velocity downwards, m/s.
        down_mps: f64,
        /// Turn rate, rad/s, positive to the right. The velocity turns with the heading, so the limit of horizontal
        /// acceleration also limits the turn rate.
        yaw_rate_radps: f64,
    },
}

/// Reason for the rejection of a set-point; the previous set-point stays active.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetPointError {
    /// A value is NaN or infinite, or the position is not valid on Earth.
    NotFinite,
    /// The speed, climb or turn rate exceeds its configured limit.
    TooFast,
}

impl core::fmt::Display for SetPointError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NotFinite => {
                "set-point: a value is not finite, or the position is not valid on Earth"
            }
            Self::TooFast => "set-point: faster than the configuration allows",
        })
    }
}

impl core::error::Error for SetPointError {}

/// Limits and gains of guidance.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize, serde::Serialize),
    serde(default, deny_unknown_fields)
)]
pub struct GuidanceConfig<T = f64> {
    /// Horizontal speed per distance from the set-point's position, 1/s.
    pub position_gain_per_s: T,
    /// Vertical speed per height error, 1/s.
    pub height_gain_per_s: T,
    /// Largest horizontal speed, m/s.
    pub speed_mps: T,
    /// Largest climb and sink rate, m/s.
    pub climb_mps: T,
    /// Largest commanded horizontal acceleration, m/s².
    pub acceleration_mps2: T,
    /// Largest commanded vertical acceleration, m/s².
    pub climb_acceleration_mps2: T,
    /// Largest turn rate, rad/s.
    pub yaw_rate_radps: T,
}

impl Default for GuidanceConfig {
    fn default() -> Self {
        Self {
            position_gain_per_s: 0.25,
            height_gain_per_s: 0.3,
            speed_mps: 5.0,
            climb_mps: 1.5,
            acceleration_mps2: 1.0,
            climb_acceleration_mps2: 0.7,
            yaw_rate_radps: 0.6,
        }
    }
}

impl GuidanceConfig {
    /// Double pole of the commanded velocity, 1/s, at a sample period: the commanded velocity follows the wanted
    /// velocity with this pole. The pole is stable at any sample period.
    ///
    /// # Source
    /// λ of equation (C6) of docs/equations.md.
    #[must_use]
    pub fn follows_per_s(period_s: f64) -> f64 {
        FOLLOWS_PER_S.min(0.5 / period_s)
    }
}

impl<T: Scalar> GuidanceConfig<T> {
    /// The same configuration in another number type.
    #[must_use]
    pub fn cast<U: Scalar>(&self) -> GuidanceConfig<U> {
        let number = |value: T| U::of(value.wide());
        GuidanceConfig {
            position_gain_per_s: number(self.position_gain_per_s),
            height_gain_per_s: number(self.height_gain_per_s),
            speed_mps: number(self.speed_mps),
            climb_mps: number(self.climb_mps),
            acceleration_mps2: number(self.acceleration_mps2),
            climb_acceleration_mps2: number(self.climb_acceleration_mps2),
            yaw_rate_radps: number(self.yaw_rate_radps),
        }
    }

    pub(super) fn check(&self) -> Result<(), ConfigError> {
        let gain = "0 to 2 1/s";
        within("guidance.position_gain_per_s", self.position_gain_per_s, 0.0, 2.0, gain)?;
        within("guidance.height_gain_per_s", self.height_gain_per_s, 0.0, 2.0, gain)?;
        within("guidance.speed_mps", self.speed_mps, 0.0, 15.0, "0 to 15 m/s")?;
        within("guidance.climb_mps", self.climb_mps, 0.0, 5.0, "0 to 5 m/s")?;
        let hardest = "0.05 to 5 m/s²";
        within("guidance.acceleration_mps2", self.acceleration_mps2, 0.05, 5.0, hardest)?;
        let climb = self.climb_acceleration_mps2;
        within("guidance.climb_acceleration_mps2", climb, 0.05, 5.0, hardest)?;
        within("guidance.yaw_rate_radps", self.yaw_rate_radps, 0.01, 3.0, "0.01 to 3 rad/s")
    }
}

/// References for the control loops at one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Reference<T> {
    pub velocity_mps: Vector<Ned, T>,
    pub acceleration_mps2: Vector<Ned, T>,
    pub heading_rad: T,
    pub yaw_rate_radps: T,
}

/// Turns set-points into references without jumps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guidance<T> {
    config: GuidanceConfig<T>,
    period_s: T,
    /// Double pole of the commanded velocity, 1/s: [`GuidanceConfig::follows_per_s`].
    follows_per_s: T,
    set_point: SetPoint,
    /// Position to hold, once the vehicle has stopped.
    station: Option<Station<T>>,
    heading_rad: T,
    /// Whether a set-point gave the heading; otherwise the vehicle's own heading is held.
    heading_is_given: bool,
    /// Sum of the solution's heading revisions up to the previous step, rad.
    revised_rad: T,
    reference: Reference<T>,
    /// Whether the motion at engagement is still being brought to rest.
    stops: bool,
}

/// A position to hold, and the Earth model there, computed once instead of at every step.
#[derive(Clone, Copy, Debug)]
struct Station<T> {
    position: Geodetic,
    earth: LocalEarth<T>,
}

impl<T: Scalar> Station<T> {
    fn at(position: Geodetic) -> Self {
        Self { position, earth: LocalEarth::about(&position) }
    }
}

/// Quantities that guidance may use.
#[derive(Clone, Copy, Debug)]
pub(super) struct Trusted<T> {
    pub position: bool,
    pub heading: bool,
    /// Downward speed that overrides the set-point, m/s.
    pub sink_mps: Option<T>,
}

impl<T: Scalar> Guidance<T> {
    pub fn new(config: GuidanceConfig<T>, period_s: f64) -> Self {
        Self {
            config,
            period_s: T::of(period_s),
            follows_per_s: T::of(GuidanceConfig::follows_per_s(period_s)),
            set_point: SetPoint::Hold,
            station: None,
            heading_rad: T::ZERO,
            heading_is_given: false,
            revised_rad: T::ZERO,
            reference: Reference::default(),
            stops: false,
        }
    }

    pub fn accept(&mut self, set_point: SetPoint) -> Result<(), SetPointError> {
        match set_point {
            SetPoint::Hold => self.station = None,
            SetPoint::Position { position, heading_rad } => {
                if !position.is_navigable() || heading_rad.is_some_and(|angle| !angle.is_finite()) {
                    return Err(SetPointError::NotFinite);
                }
                if let Some(heading_rad) = heading_rad {
                    self.heading_rad = T::of(wrap_angle(heading_rad));
                    self.heading_is_given = true;
                }
                self.station = Some(Station::at(position));
            }
            SetPoint::Velocity { forward_mps, right_mps, down_mps, yaw_rate_radps } => {
                let all = [forward_mps, right_mps, down_mps, yaw_rate_radps];
                if !all.iter().all(|value| value.is_finite()) {
                    return Err(SetPointError::NotFinite);
                }
                if T::of(Scalar::hypot(forward_mps, right_mps)) > self.config.speed_mps
                    || T::of(down_mps).abs() > self.config.climb_mps
                    || T::of(yaw_rate_radps).abs() > self.config.yaw_rate_radps
                {
                    return Err(SetPointError::TooFast);
                }
                self.heading_is_given = false;
            }
        }
        self.set_point = set_point;
        self.stops = false;
        Ok(())
    }

    /// Starts with the current motion as reference, and brings it to rest.
    pub fn engage(&mut self, solution: &Solution<T>, yaw_rad: T) {
        self.set_point = SetPoint::Hold;
        self.station = None;
        self.heading_rad = yaw_rad;
        self.heading_is_given = false;
        self.revised_rad = solution.heading_revision_rad;
        let velocity_mps = solution.velocity_mps;
        self.reference = Reference { velocity_mps, heading_rad: yaw_rad, ..Reference::default() };
        self.stops = true;
    }

    /// Last references for the loops: velocity, m/s, and heading, rad.
    pub fn reference(&self) -> (Vector<Ned, T>, T) {
        (self.reference.velocity_mps, self.reference.heading_rad)
    }

    /// The references of velocity and heading for this sample.
    ///
    /// # Source
    /// Equation (C6) of docs/equations.md.
    pub fn step(
        &mut self,
        solution: &Solution<T>,
        yaw_rad: T,
        trusted: Trusted<T>,
    ) -> Reference<T> {
        self.revise_heading(solution.heading_revision_rad);
        self.steer_heading(yaw_rad, trusted.heading);
        let wanted = self.wanted_velocity(solution, trusted);
        self.follow(wanted);
        if self.set_point == SetPoint::Hold
            && self.station.is_none()
            && self.reference.velocity_mps.is_shorter_than(T::of(0.05))
        {
            self.stops = false;
            self.station = trusted.position.then(|| Station::at(solution.position));
        }
        self.reference
    }

    /// Moves the reference towards the velocity `wanted` with critical damping: velocity and acceleration stay
    /// continuous when `wanted` jumps.
    fn follow(&mut self, wanted: Vector<Ned, T>) {
        let Reference { velocity_mps, acceleration_mps2, .. } = self.reference;
        // Without this end of the decay both values would become denormal numbers, which processors compute about 100
        // times slower.
        let reached = T::of(REACHED);
        if (wanted - velocity_mps).is_shorter_than(reached)
            && acceleration_mps2.is_shorter_than(reached)
        {
            self.reference.velocity_mps = wanted;
            self.reference.acceleration_mps2 = Vector::ZERO;
            return;
        }
        let rate_per_s = self.follows_per_s;
        let rate_per_s = if self.stops { rate_per_s.min(T::of(STOPS_PER_S)) } else { rate_per_s };
        let jerk = (wanted - velocity_mps) * (rate_per_s * rate_per_s)
            - acceleration_mps2 * (T::of(2.0) * rate_per_s);
        let jerk = within_sizes(jerk, T::of(HARDEST_JERK_MPS3), T::of(HARDEST_JERK_MPS3));
        let acceleration = within_sizes(
            acceleration_mps2 + jerk * self.period_s,
            self.config.acceleration_mps2,
            self.config.climb_acceleration_mps2,
        );
        self.reference.acceleration_mps2 = acceleration;
        self.reference.velocity_mps = velocity_mps + acceleration * self.period_s;
    }

    /// Shifts the held heading by the revision of the solution's heading: the estimate was wrong, so the vehicle must
    /// not turn.
    ///
    /// # Source
    /// Equation (C12) of docs/equations.md.
    fn revise_heading(&mut self, revised_rad: T) {
        let more_rad = revised_rad - self.revised_rad;
        self.revised_rad = revised_rad;
        if !self.heading_is_given {
            self.heading_rad = wrap_angle(self.heading_rad + more_rad);
            self.reference.heading_rad = wrap_angle(self.reference.heading_rad + more_rad);
        }
    }

    fn steer_heading(&mut self, yaw_rad: T, trusted: bool) {
        let fastest = self.config.yaw_rate_radps;
        let reference = &mut self.reference;
        if let SetPoint::Velocity { yaw_rate_radps, .. } = self.set_point {
            // The velocity turns with the heading. The turn rate is limited so that this turn of the velocity takes at
            // most [`TURNING`] of the largest horizontal acceleration.
            let [north, east, _] = reference.velocity_mps.to_array();
            let speed = (north * north + east * east).sqrt();
            let turning = T::of(TURNING) * self.config.acceleration_mps2;
            let fastest = if speed * fastest > turning { turning / speed } else { fastest };
            let turn_rad = within_size(T::of(yaw_rate_radps), fastest) * self.period_s;
            self.heading_rad = wrap_angle(self.heading_rad + turn_rad);
        }
        if !trusted {
            self.heading_rad = yaw_rad;
            self.heading_is_given = false;
            reference.heading_rad = yaw_rad;
        }
        let missing = wrap_angle(self.heading_rad - reference.heading_rad) / self.period_s;
        reference.yaw_rate_radps = within_size(missing, fastest);
        let turned = reference.heading_rad + reference.yaw_rate_radps * self.period_s;
        reference.heading_rad = wrap_angle(turned);
    }

    /// Velocity that leads to the set-point: equation (C5) of docs/equations.md.
    fn wanted_velocity(&self, solution: &Solution<T>, trusted: Trusted<T>) -> Vector<Ned, T> {
        let config = &self.config;
        let wanted = match self.set_point {
            SetPoint::Velocity { forward_mps, right_mps, down_mps, .. } => {
                let [forward_mps, right_mps, down_mps] =
                    [forward_mps, right_mps, down_mps].map(T::of);
                let (sin, cos) = solution.body_to_ned.heading_sincos();
                let north = cos * forward_mps - sin * right_mps;
                let east = sin * forward_mps + cos * right_mps;
                Vector::new(north, east, down_mps)
            }
            SetPoint::Hold | SetPoint::Position { .. } => match self.station {
                Some(station) if trusted.position => {
                    let missing = station.earth.displacement(&solution.position, &station.position);
                    let [north, east, down] = missing.to_array();
                    let distance = (north * north + east * east).sqrt();
                    // Braking uses half of the largest deceleration; the rest is a margin for wind.
                    let braking = (config.acceleration_mps2 * distance).sqrt();
                    let speed =
                        (config.position_gain_per_s * distance).min(config.speed_mps).min(braking);
                    let per_distance =
                        if distance > T::of(1e-6) { speed / distance } else { T::ZERO };
                    let down = within_size(config.height_gain_per_s * down, config.climb_mps);
                    Vector::new(north * per_distance, east * per_distance, down)
                }
                _ => Vector::ZERO,
            },
        };
        match trusted.sink_mps {
            Some(sink_mps) => Vector::new(T::ZERO, T::ZERO, sink_mps),
            None => wanted,
        }
    }
}

/// `vector` with the length of its horizontal part limited to `horizontal`, and its down component to ±`vertical`.
fn within_sizes<T: Scalar>(vector: Vector<Ned, T>, horizontal: T, vertical: T) -> Vector<Ned, T> {
    let [north, east, down] = vector.to_array();
    let square = north * north + east * east;
    let longer = square > horizontal * horizontal;
    let share = if longer { horizontal / square.sqrt() } else { T::ONE };
    Vector::new(north * share, east * share, within_size(down, vertical))
}

/// `value` limited to ±`size`.
fn within_size<T: Scalar>(value: T, size: T) -> T {
    value.max(-size).min(size)
}

#[cfg(test)]
mod tests;
