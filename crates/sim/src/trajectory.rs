//! An error-free flight: position, velocity, attitude, and the measurements of ideal inertial sensors.
//!
//! The speeds in the level heading axes, the heading, the roll and the pitch are polynomials of time, four times
//! continuously differentiable. Velocity, acceleration, attitude, angular rate and angular acceleration follow from
//! them in closed form. Only position is integrated, on the rotating WGS-84 ellipsoid, and interpolated: accurate to
//! 1e-6 m over 300 s.

use std::fmt;

use hovernav::glam::{DVec2, DVec3, swizzles::Vec3Swizzles};

use hovernav::earth::{Geodetic, LocalEarth};
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector, wrap_angle};

use super::leg::{Leg, Level};
use super::state::State;

/// Longest flight, s.
const LONGEST_S: f64 = 4.0 * 3600.0;
/// Time between stored positions, s.
const KNOT_S: f64 = 0.02;
/// Longest interval of one application of the quadrature rule, s.
const QUADRATURE_S: f64 = 0.031;
/// Nodes in (0, 1) and weights of the four-point Gauss-Legendre rule (Abramowitz & Stegun, table
/// 25.4): exact for polynomials of degree 7.
const GAUSS_LEGENDRE: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Reasons why a plan cannot be flown.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TrajectoryError {
    /// North is undefined at the start, or a value of the start is not finite.
    #[error("invalid start {0:?}: north, east and down are undefined there")]
    Start(Geodetic),
    /// The heading at the start is not finite.
    #[error("found an initial heading of {0} rad, expected a finite one")]
    Heading(f64),
    /// A leg's duration is not above zero, one of its values is not finite, or its pitch is beyond
    /// ±1.5 rad.
    #[error("leg {index} cannot be flown: {leg:?}")]
    Leg {
        /// Index of the leg, from zero.
        index: usize,
        /// The leg.
        leg: Leg,
    },
    /// The flight is longer than four hours.
    #[error("found a flight of {0} s, expected at most 14400 s")]
    TooLong(f64),
    /// The flight leads to a position without north, east and down: a pole.
    #[error(
        "after {time_s} s the flight is at {place:?}, where north, east and down are undefined"
    )]
    NotNavigable {
        /// Time, s from the start.
        time_s: f64,
        /// Position.
        place: Geodetic,
    },
}

/// A flight of the centre of gravity from time 0 to [`duration_s`](Self::duration_s).
///
/// Made by [`FlightPlan::build`](super::FlightPlan::build). Before the start [`at`](Self::at) returns the first
/// state, after the end the last.
#[derive(Clone)]
pub struct Trajectory {
    stretches: Vec<Stretch>,
    knots: Vec<Knot>,
    duration_s: f64,
}

impl Trajectory {
    pub(super) fn new(
        start: Geodetic,
        heading_rad: f64,
        legs: &[Leg],
    ) -> Result<Self, TrajectoryError> {
        if !start.is_navigable() {
            return Err(TrajectoryError::Start(start));
        }
        if !heading_rad.is_finite() {
            return Err(TrajectoryError::Heading(heading_rad));
        }
        // The flight starts from a hover that ends at time 0.
        let hover = Leg { duration_s: 1.0, ..Leg::STEADY };
        let mut stretch = Stretch {
            start_s: -hover.duration_s,
            from: hover,
            to: hover,
            speed_mps: Vector::ZERO,
            yaw_rad: heading_rad,
        };
        let mut stretches = vec![stretch];
        for (index, leg) in legs.iter().enumerate() {
            let possible = leg.duration_s > 0.0
                && leg.duration_s.is_finite()
                && leg.acceleration_mps2.is_finite()
                && leg.yaw_rate_radps.is_finite()
                && leg.roll_rad.is_finite()
                && leg.pitch_rad.abs() <= 1.5;
            if !possible {
                return Err(TrajectoryError::Leg { index, leg: *leg });
            }
            stretch = stretch.followed_by(*leg);
            stretches.push(stretch);
        }
        let duration_s = stretch.start_s + stretch.to.duration_s;
        if duration_s > LONGEST_S {
            return Err(TrajectoryError::TooLong(duration_s));
        }
        // One more leg, because the last stored position is beyond the end.
        stretches.push(stretch.followed_by(Leg { duration_s: 2.0 * KNOT_S, ..stretch.to }));
        let mut trajectory = Self { stretches, knots: Vec::new(), duration_s };
        trajectory.integrate_position(start)?;
        Ok(trajectory)
    }

    /// Duration, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.duration_s
    }

    /// The motion of the centre of gravity `time_s` after the start.
    ///
    /// # Source
    /// Equation (W3) of docs/equations.md.
    #[must_use]
    pub fn at(&self, time_s: f64) -> State {
        let time_s = time_s.clamp(0.0, self.duration_s);
        let Channels { speed, acceleration, yaw, pitch, roll } = self.channels(time_s);
        let position = self.position(time_s);
        let local = LocalEarth::at(&position);

        let (sin_r, cos_r) = libm::sincos(roll.value);
        let (sin_p, cos_p) = libm::sincos(pitch.value);
        let heading = DVec2::from_angle(yaw.value);
        let velocity_mps = level_to_ned(heading, speed);
        let turning = DVec3::new(-speed.y, speed.x, 0.0) * yaw.rate;
        let acceleration_mps2 = level_to_ned(heading, acceleration + turning);
        let body_to_ned = Rotation::from_euler(EulerAngles {
            roll_rad: roll.value,
            pitch_rad: pitch.value,
            yaw_rad: yaw.value,
        });

        // Euler rates to body rates, and their derivatives.
        let angular_rate_radps = Vector::new(
            roll.rate - yaw.rate * sin_p,
            pitch.rate * cos_r + yaw.rate * cos_p * sin_r,
            yaw.rate * cos_p * cos_r - pitch.rate * sin_r,
        );
        let [_, q, r] = angular_rate_radps.to_array();
        let angular_acceleration = Vector::new(
            roll.curvature - yaw.curvature * sin_p - yaw.rate * pitch.rate * cos_p,
            pitch.curvature * cos_r
                + (yaw.curvature * cos_p - yaw.rate * pitch.rate * sin_p) * sin_r
                + roll.rate * r,
            (yaw.curvature * cos_p - yaw.rate * pitch.rate * sin_p) * cos_r
                - pitch.curvature * sin_r
                - roll.rate * q,
        );

        let earth_rate = local.earth_rate_radps;
        let transport_rate = local.transport_rate(velocity_mps);
        let ned_to_body = body_to_ned.inverse();
        let frame_rate = ned_to_body * (earth_rate + transport_rate);
        let frame_acceleration =
            local.transport_rate(acceleration_mps2) - transport_rate.cross(earth_rate);
        let gravity = Vector::new(0.0, 0.0, local.gravity_mps2);
        let coriolis = (earth_rate * 2.0 + transport_rate).cross(velocity_mps);
        State {
            position,
            velocity_mps,
            body_to_ned,
            angular_rate_radps,
            inertial_rate_radps: angular_rate_radps + frame_rate,
            angular_acceleration_radps2: angular_acceleration + ned_to_body * frame_acceleration
                - angular_rate_radps.cross(frame_rate),
            specific_force_mps2: ned_to_body * (acceleration_mps2 + coriolis - gravity),
            local,
        }
    }

    /// Output of an ideal integrating inertial unit at `lever_arm_m` from the centre of gravity. It consists of the
    /// integrals of angular rate, rad, and of specific force, m/s, from `from_s` to `to_s`. Each is resolved in the
    /// body axes of its own time. Accurate to 1e-13 rad and 1e-12 m/s for every 0.03 s of a manoeuvre of the test
    /// flight. `to_s` must be after `from_s`.
    #[must_use]
    pub fn increments(
        &self,
        from_s: f64,
        to_s: f64,
        lever_arm_m: Vector<Body>,
    ) -> (Vector<Body>, Vector<Body>) {
        self.increments_between((from_s, &self.at(from_s)), (to_s, &self.at(to_s)), lever_arm_m)
    }

    /// As [`increments`](Self::increments), for known states at both ends.
    pub(super) fn increments_between(
        &self,
        (from_s, from): (f64, &State),
        (to_s, to): (f64, &State),
        lever_arm_m: Vector<Body>,
    ) -> (Vector<Body>, Vector<Body>) {
        let mut angle_rad = Vector::ZERO;
        let mut velocity_mps =
            (to.inertial_rate_radps - from.inertial_rate_radps).cross(lever_arm_m);
        let mut start_s = from_s;
        while start_s < to_s {
            let piece_s = self.smooth_until(start_s).min(to_s) - start_s;
            for (node, weight) in GAUSS_LEGENDRE {
                let state = self.at(start_s + node * piece_s);
                angle_rad += state.inertial_rate_radps * (weight * piece_s);
                velocity_mps += state.steady_specific_force(lever_arm_m) * (weight * piece_s);
            }
            start_s += piece_s;
        }
        (angle_rad, velocity_mps)
    }

    /// End of the interval from `time_s` that one application of the quadrature rule may cover.
    fn smooth_until(&self, time_s: f64) -> f64 {
        let later = self.stretches.partition_point(|stretch| stretch.start_s <= time_s);
        let joint_s = self.stretches.get(later).map_or(f64::INFINITY, |stretch| stretch.start_s);
        let moving = time_s >= 0.0 && time_s < self.duration_s;
        if moving { joint_s.min(time_s + QUADRATURE_S) } else { joint_s }
    }

    fn channels(&self, time_s: f64) -> Channels {
        let later = self.stretches.partition_point(|stretch| stretch.start_s <= time_s);
        self.stretches[later.saturating_sub(1)].at(time_s)
    }

    fn velocity(&self, time_s: f64) -> Vector<Ned> {
        let Channels { speed, yaw, .. } = self.channels(time_s);
        level_to_ned(DVec2::from_angle(yaw.value), speed)
    }

    /// Stores the position every [`KNOT_S`]. Between knots the velocity is integrated by Simpson's rule, with the radii
    /// of curvature at the midpoint.
    fn integrate_position(&mut self, start: Geodetic) -> Result<(), TrajectoryError> {
        let mut place = DVec3::new(start.latitude_rad, start.longitude_rad, start.height_m);
        let mut velocity = self.velocity(0.0);
        let last = (self.duration_s / KNOT_S).ceil() as u32;
        for knot in 0..=last {
            let time_s = f64::from(knot) * KNOT_S;
            if !geodetic(place).is_navigable() {
                return Err(TrajectoryError::NotNavigable { time_s, place: geodetic(place) });
            }
            self.knots.push(Knot { place, step: geodetic_step(place, velocity * KNOT_S) });
            let halfway = self.velocity(time_s + 0.5 * KNOT_S);
            let next = self.velocity(time_s + KNOT_S);
            let way = (velocity + halfway * 4.0 + next) * (KNOT_S / 6.0);
            place += geodetic_step(place + 0.5 * geodetic_step(place, way), way);
            velocity = next;
        }
        Ok(())
    }

    /// Cubic interpolation between the knots, from positions and velocities.
    fn position(&self, time_s: f64) -> Geodetic {
        let knots = time_s / KNOT_S;
        let before = (knots as usize).min(self.knots.len().saturating_sub(2));
        let (a, b) = (&self.knots[before], &self.knots[(before + 1).min(self.knots.len() - 1)]);
        let x = knots - before as f64;
        let y = 1.0 - x;
        let way = b.place - a.place;
        let mut place = a.place + x * x * (3.0 - 2.0 * x) * way;
        place += x * y * (y * a.step - x * b.step);
        geodetic(DVec3::new(place.x, wrap_angle(place.y), place.z))
    }
}

impl fmt::Debug for Trajectory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Thousands of positions are omitted.
        f.debug_struct("Trajectory").field("duration_s", &self.duration_s).finish_non_exhaustive()
    }
}

/// A stored position, and the change of position in [`KNOT_S`] at the velocity there.
#[derive(Clone, Copy, Debug)]
struct Knot {
    place: DVec3,
    step: DVec3,
}

fn geodetic(place: DVec3) -> Geodetic {
    Geodetic { latitude_rad: place.x, longitude_rad: place.y, height_m: place.z }
}

/// Change of latitude, longitude and height for a small displacement from the position `place`.
fn geodetic_step(place: DVec3, way_m: Vector<Ned>) -> DVec3 {
    let local = LocalEarth::at(&geodetic(place));
    let parallel_m = local.east_radius_m * libm::cos(place.x);
    DVec3::new(way_m.x() / local.north_radius_m, way_m.y() / parallel_m, -way_m.z())
}

/// Resolves level heading axes in north, east and down; `heading` contains cosine and sine.
fn level_to_ned(heading: DVec2, level: DVec3) -> Vector<Ned> {
    Vector::claim(heading.rotate(level.xy()).extend(level.z))
}

/// A quantity with its first and second time derivatives.
#[derive(Clone, Copy, Debug)]
struct Channel {
    value: f64,
    rate: f64,
    curvature: f64,
}

/// Speeds and accelerations in the level heading axes, and the Euler angles.
struct Channels {
    speed: DVec3,
    acceleration: DVec3,
    yaw: Channel,
    pitch: Channel,
    roll: Channel,
}

/// A leg with its initial state.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    start_s: f64,
    from: Leg,
    to: Leg,
    speed_mps: Vector<Level>,
    yaw_rad: f64,
}

impl Stretch {
    fn followed_by(&self, leg: Leg) -> Self {
        let start_s = self.start_s + self.to.duration_s;
        let end = self.at(start_s);
        Self {
            start_s,
            from: self.to,
            to: leg,
            speed_mps: Vector::claim(end.speed),
            yaw_rad: end.yaw.value,
        }
    }

    fn at(&self, time_s: f64) -> Channels {
        let (from, to, duration_s) = (&self.from, &self.to, self.to.duration_s);
        let elapsed_s = (time_s - self.start_s).min(duration_s);
        let blend = Blend::at(elapsed_s / duration_s);
        let blended = |from: f64, to: f64| Channel {
            value: from + (to - from) * blend.value,
            rate: (to - from) * blend.slope / duration_s,
            curvature: (to - from) * blend.bend / (duration_s * duration_s),
        };
        let acceleration = from.acceleration_mps2.components();
        let gain = to.acceleration_mps2.components() - acceleration;
        let yaw_rate = blended(from.yaw_rate_radps, to.yaw_rate_radps);
        let yaw_gain = to.yaw_rate_radps - from.yaw_rate_radps;
        Channels {
            speed: self.speed_mps.components()
                + acceleration * elapsed_s
                + gain * (duration_s * blend.integral),
            acceleration: acceleration + gain * blend.value,
            yaw: Channel {
                value: self.yaw_rad
                    + from.yaw_rate_radps * elapsed_s
                    + yaw_gain * duration_s * blend.integral,
                rate: yaw_rate.value,
                curvature: yaw_rate.rate,
            },
            pitch: blended(from.pitch_rad, to.pitch_rad),
            roll: blended(from.roll_rad, to.roll_rad),
        }
    }
}

/// The polynomial of degree 9 from 0 to 1 whose first four derivatives vanish at both ends.
struct Blend {
    value: f64,
    slope: f64,
    bend: f64,
    integral: f64,
}

impl Blend {
    fn at(x: f64) -> Self {
        let bump = x * (1.0 - x);
        let x5 = x.powi(5);
        Self {
            value: x5 * (126.0 - x * (420.0 - x * (540.0 - x * (315.0 - x * 70.0)))),
            slope: 630.0 * bump.powi(4),
            bend: 2520.0 * bump.powi(3) * (1.0 - 2.0 * x),
            integral: x5 * x * (21.0 - x * (60.0 - x * (67.5 - x * (35.0 - x * 7.0)))),
        }
    }
}
