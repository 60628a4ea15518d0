//! The nominal state and its propagation by inertial samples: equations (E1) to (E10), (S1) to (S8) and (S14).
//!
//! Vectors and quaternions are those of nalgebra; formulas are in the order of `docs/equations.md`.

use hovernav::earth::{
    ECCENTRICITY_SQUARED, EQUATORIAL_GRAVITY_MPS2, FLATTENING, GRAVITY_RATIO_M, Geodetic,
    SEMI_MAJOR_AXIS_M, SOMIGLIANA_K,
};
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

pub type Vector = Vector3<f64>;

/// Rotation rate of the Earth, rad/s.
const EARTH_RATE_RADPS: f64 = 7.292_115e-5;

/// Earth model at one position.
#[derive(Clone, Copy, Debug)]
pub struct Earth {
    latitude_rad: f64,
    /// R_N + h and R_E + h, m.
    radii_m: [f64; 2],
    pub gravity_mps2: f64,
    /// ω_ie in NED, rad/s.
    pub rate_radps: Vector,
}

impl Earth {
    /// The Earth at a position: (E1), (E6) and (E7).
    pub fn at(place: &Geodetic) -> Self {
        let (sine, cosine) = place.latitude_rad.sin_cos();
        let h = place.height_m;
        let root = (1.0 - ECCENTRICITY_SQUARED * sine * sine).sqrt();
        let prime_vertical_m = SEMI_MAJOR_AXIS_M / root;
        let meridian_m = SEMI_MAJOR_AXIS_M * (1.0 - ECCENTRICITY_SQUARED) / root.powi(3);
        let on_ellipsoid = EQUATORIAL_GRAVITY_MPS2 * (1.0 + SOMIGLIANA_K * sine * sine) / root;
        let first = 1.0 + FLATTENING + GRAVITY_RATIO_M - 2.0 * FLATTENING * sine * sine;
        let share = h / SEMI_MAJOR_AXIS_M;
        Self {
            latitude_rad: place.latitude_rad,
            radii_m: [meridian_m + h, prime_vertical_m + h],
            gravity_mps2: on_ellipsoid * (1.0 - 2.0 * first * share + 3.0 * share * share),
            rate_radps: EARTH_RATE_RADPS * Vector::new(cosine, 0.0, -sine),
        }
    }

    /// ω_en in NED, rad/s (E8).
    pub fn transport_rate(&self, velocity_mps: &Vector) -> Vector {
        let [north_m, east_m] = self.radii_m;
        let about_north = velocity_mps.y / east_m;
        let tangent = self.latitude_rad.tan();
        Vector::new(about_north, -velocity_mps.x / north_m, -about_north * tangent)
    }

    /// A position displaced by a small vector in NED, m (E9).
    pub fn displaced(&self, place: &Geodetic, by_m: &Vector) -> Geodetic {
        let [north_m, east_m] = self.radii_m;
        Geodetic {
            latitude_rad: place.latitude_rad + by_m.x / north_m,
            longitude_rad: wrapped(
                place.longitude_rad + by_m.y / (east_m * self.latitude_rad.cos()),
            ),
            height_m: place.height_m - by_m.z,
        }
    }

    /// A position displaced by a step, with radii and latitude at its middle (E10).
    pub fn carried(&self, place: &Geodetic, by_m: &Vector) -> Geodetic {
        let climbed = self.radii_m.map(|radius_m| radius_m - 0.5 * by_m.z);
        let middle = Self {
            radii_m: climbed,
            latitude_rad: self.latitude_rad + 0.5 * by_m.x / climbed[0],
            ..*self
        };
        middle.displaced(place, by_m)
    }

    /// Small displacement in NED from one position to another, m.
    pub fn displacement(&self, from: &Geodetic, to: &Geodetic) -> Vector {
        let [north_m, east_m] = self.radii_m;
        Vector::new(
            (to.latitude_rad - from.latitude_rad) * north_m,
            wrapped(to.longitude_rad - from.longitude_rad) * east_m * self.latitude_rad.cos(),
            from.height_m - to.height_m,
        )
    }
}

/// Wraps an angle to (−π, π].
pub fn wrapped(angle_rad: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if angle_rad.abs() <= PI { angle_rad } else { angle_rad - TAU * (angle_rad / TAU).round() }
}

/// The known errors of the inertial unit (S1): a bias of each gyro and accelerometer.
#[derive(Clone, Copy, Debug)]
pub struct UnitErrors {
    pub bias: [Vector; 2],
}

impl UnitErrors {
    /// Angular rate (`sensor` 0) or specific force (1) without errors, or its integral over `seconds`.
    fn removed(&self, sensor: usize, measured: &Vector, seconds: f64) -> Vector {
        measured - self.bias[sensor] * seconds
    }
}

/// Rotation vector and velocity change of a step, both resolved in the body axes at its start.
#[derive(Clone, Copy, Debug)]
pub struct Increment {
    pub seconds: f64,
    pub rotation_rad: Vector,
    pub velocity_mps: Vector,
    /// Angular rate at its end, rad/s, relative to inertial space; for increments the mean.
    pub last_rate_radps: Vector,
}

/// The previous sample, with the length of the interval that it ended.
#[derive(Clone, Copy, Debug)]
pub struct Previous {
    pub time: Time,
    motion: Motion,
    seconds: Option<f64>,
}

impl Previous {
    pub fn of(sample: &ImuSample, before: Option<&Self>) -> Self {
        let seconds = before.map(|before| sample.time - before.time);
        Self { time: sample.time, motion: sample.motion, seconds }
    }
}

impl Increment {
    /// Increment from the previous sample, if any, to `sample`, `seconds` later.
    pub fn between(
        before: Option<&Previous>,
        sample: &ImuSample,
        seconds: f64,
        errors: &UnitErrors,
    ) -> Self {
        let vector =
            |v: hovernav::frames::Vector<hovernav::frames::Body>| Vector::from(v.to_array());
        match sample.motion {
            Motion::Rates { angular_rate_radps, specific_force_mps2 } => {
                let w1 = errors.removed(0, &vector(angular_rate_radps), 1.0);
                let f1 = errors.removed(1, &vector(specific_force_mps2), 1.0);
                match before.map(|before| before.motion) {
                    // Without a previous sample, the rates of the first sample count for the whole interval, without
                    // coning or sculling.
                    None => Self {
                        seconds,
                        rotation_rad: w1 * seconds,
                        velocity_mps: f1 * seconds,
                        last_rate_radps: w1,
                    },
                    Some(Motion::Rates { angular_rate_radps, specific_force_mps2 }) => {
                        let w0 = errors.removed(0, &vector(angular_rate_radps), 1.0);
                        let f0 = errors.removed(1, &vector(specific_force_mps2), 1.0);
                        Self::of_rates(seconds, [w0, w1], [f0, f1])
                    }
                    Some(Motion::Increments { .. }) => Self::of_rates(seconds, [w1, w1], [f1, f1]),
                }
            }
            Motion::Increments { angle_rad, velocity_mps } => {
                let angle = errors.removed(0, &vector(angle_rad), seconds);
                let velocity = errors.removed(1, &vector(velocity_mps), seconds);
                let mean_rate_radps = |rotation_rad: Vector| rotation_rad / seconds;
                let Some(before) = before else {
                    return Self {
                        seconds,
                        rotation_rad: angle,
                        velocity_mps: velocity,
                        last_rate_radps: mean_rate_radps(angle),
                    };
                };
                // The previous increment is scaled to the length of this one.
                let (angle_before, velocity_before) = match (before.motion, before.seconds) {
                    (Motion::Increments { angle_rad, velocity_mps }, Some(then_s)) => (
                        errors.removed(0, &(vector(angle_rad) * (seconds / then_s)), seconds),
                        errors.removed(1, &(vector(velocity_mps) * (seconds / then_s)), seconds),
                    ),
                    _ => (angle, velocity),
                };
                // Coning and sculling: (S4) and (S5).
                let sculling = angle_before.cross(&velocity) + velocity_before.cross(&angle);
                let rotation_rad = angle + angle_before.cross(&angle) / 12.0;
                Self {
                    seconds,
                    rotation_rad,
                    velocity_mps: velocity
                        + angle.cross(&velocity) / 2.0
                        + sculling / 12.0
                        + angle.cross(&angle.cross(&velocity)) / 6.0,
                    last_rate_radps: mean_rate_radps(rotation_rad),
                }
            }
        }
    }

    /// Increment from rates and specific forces at both ends: (S2) and (S3).
    fn of_rates(seconds: f64, [w0, w1]: [Vector; 2], [f0, f1]: [Vector; 2]) -> Self {
        let (dw, df) = (w1 - w0, f1 - f0);
        let alpha = (w0 + w1) * (seconds / 2.0);
        let velocity = (f0 + f1) * (seconds / 2.0);
        let turning = w0.cross(&(f0 / 2.0 + df / 3.0)) + dw.cross(&(f0 / 6.0 + df / 8.0));
        Self {
            seconds,
            rotation_rad: alpha + w0.cross(&w1) * (seconds * seconds / 12.0),
            velocity_mps: velocity
                + turning * (seconds * seconds)
                + alpha.cross(&alpha.cross(&velocity)) / 6.0,
            last_rate_radps: w1,
        }
    }
}

/// Position, velocity and attitude of the inertial unit.
#[derive(Clone, Copy, Debug)]
pub struct Nominal {
    pub time: Time,
    pub place: Geodetic,
    pub velocity_mps: Vector,
    /// Attitude, body to NED.
    pub attitude: UnitQuaternion<f64>,
}

/// Intermediate results of a step of the mechanization.
#[derive(Clone, Copy, Debug)]
pub struct Advance {
    /// C at the start of the step.
    pub cosines: Matrix3<f64>,
    /// Velocity change by specific force, Δv_f, and by gravity and Coriolis, NED, m/s.
    pub force_mps: Vector,
    pub fall_mps: Vector,
    /// Angular rate of NED relative to inertial space, rad/s.
    pub frame_rate_radps: Vector,
}

impl Nominal {
    /// C, the direction cosines from body to NED.
    pub fn cosines(&self) -> Matrix3<f64> {
        *self.attitude.to_rotation_matrix().matrix()
    }

    /// One step of the mechanization to `time`: (S6), (S7) and (S8).
    pub fn advance(&mut self, time: Time, step: &Increment) -> Advance {
        let seconds = step.seconds;
        let earth = Earth::at(&self.place);
        let cosines = self.cosines();
        let force = cosines * step.velocity_mps;
        let before = self.velocity_mps;
        let gravity = earth.gravity_mps2 * (1.0 + before.z * seconds / earth.radii_m[0]);
        let gravity_mps = Vector::new(0.0, 0.0, gravity * seconds);
        let middle_mps = before + (force + gravity_mps) / 2.0;
        let transport = earth.transport_rate(&middle_mps);
        let frame_rate_radps = earth.rate_radps + transport;
        let coriolis_mps = (2.0 * earth.rate_radps + transport).cross(&middle_mps) * seconds;
        let zeta = frame_rate_radps * seconds;
        let force_mps = force - zeta.cross(&force) / 2.0;
        let fall_mps = gravity_mps - coriolis_mps;
        self.velocity_mps = before + force_mps + fall_mps;
        let way_m = (before + self.velocity_mps) * (seconds / 2.0);
        self.place = earth.carried(&self.place, &way_m);
        self.attitude = UnitQuaternion::from_scaled_axis(-zeta)
            * self.attitude
            * UnitQuaternion::from_scaled_axis(step.rotation_rad);
        self.attitude.renormalize();
        self.time = time;
        Advance { cosines, force_mps, fall_mps, frame_rate_radps }
    }

    /// Propagates over a gap in the samples (S14): velocity stays, the rotation fades. Returns the rotation vector,
    /// body axes, rad.
    pub fn coast(&mut self, time: Time, rate_radps: &Vector) -> Vector {
        let seconds = time - self.time;
        let lasting_s = |memory_s: f64| seconds / (1.0 + seconds / memory_s);
        let way_m = self.velocity_mps * seconds;
        self.place = Earth::at(&self.place).carried(&self.place, &way_m);
        let rate = self.attitude * rate_radps;
        let tilted = rate.xy() * lasting_s(0.3);
        let tilted = tilted * (0.35 / tilted.norm().max(0.35));
        let turned = (rate.z * lasting_s(1.0)).clamp(-1.0, 1.0);
        let rotation_rad = self.attitude.inverse() * Vector::new(tilted.x, tilted.y, turned);
        self.attitude *= UnitQuaternion::from_scaled_axis(rotation_rad);
        self.attitude.renormalize();
        self.time = time;
        rotation_rad
    }
}

/// The matrix [v×]: its product with w is v × w.
pub fn skew(v: &Vector) -> Matrix3<f64> {
    v.cross_matrix()
}
