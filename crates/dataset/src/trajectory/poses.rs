//! A trajectory in memory, in its own axes or on Earth.

use std::collections::BTreeMap;

use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::frames::{Body, Ned, Rotation, Vector};
use hovernav::glam::DQuat;
use hovernav::gps::Fix;
use hovernav::time::Time;

/// A trajectory of any origin, in time order; unknown values are NaN.
#[derive(Clone, Debug)]
pub struct Trajectory {
    /// Position, velocity and attitude at each time.
    pub solutions: Vec<Solution>,
    /// Position at each time, m, north, east and down of a local origin; empty if positions are on Earth.
    pub local_m: Vec<Vector<Ned>>,
    /// Position of the local origin, if a comment in the file states it, as in our own TUM export.
    pub origin: Option<Geodetic>,
    /// Repairs and skipped rows while reading, one plain sentence each.
    pub warnings: Vec<String>,
}

/// The axes of a file with local metres and quaternions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LocalAxes {
    /// East, north, up, with body axes forward, left, up: the axes of ROS and most visual odometry.
    #[default]
    EnuFlu,
    /// North, east, down, with body axes forward, right, down.
    NedFrd,
}

impl LocalAxes {
    /// Converts a vector from the file's reference axes to north, east, down.
    pub(crate) fn vector(self, [x, y, z]: [f64; 3]) -> Vector<Ned> {
        match self {
            Self::EnuFlu => Vector::new(y, x, -z),
            Self::NedFrd => Vector::new(x, y, z),
        }
    }

    /// Converts the file's quaternion x, y, z, w from body to reference axes, of any length above zero.
    pub(crate) fn attitude(self, quaternion: [f64; 4]) -> Rotation<Body, Ned> {
        let quaternion = DQuat::from_array(quaternion).normalize();
        Rotation::claim(match self {
            Self::EnuFlu => NED_FROM_ENU * quaternion * FLU_FROM_FRD,
            Self::NedFrd => quaternion,
        })
    }
}

/// Rotation from ENU to NED: half a turn about the line between north and east.
const NED_FROM_ENU: DQuat =
    DQuat::from_xyzw(std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0);
/// Rotation from forward, right, down to forward, left, up: half a turn about the nose.
const FLU_FROM_FRD: DQuat = DQuat::from_xyzw(1.0, 0.0, 0.0, 0.0);

impl Trajectory {
    /// Trajectory from positions with velocities and from attitudes, each with its own times or with the same.
    #[must_use]
    pub fn of_parts(
        fixes: &[Fix],
        attitudes: impl IntoIterator<Item = (Time, Rotation<Body, Ned>)>,
    ) -> Self {
        let mut moments: BTreeMap<Time, Solution> = BTreeMap::new();
        for fix in fixes {
            let moment = moments.entry(fix.time).or_insert_with(|| unknown(fix.time));
            let [north, east] = fix.horizontal_velocity_mps.unwrap_or([f64::NAN; 2]);
            let down = fix.down_velocity_mps.unwrap_or(f64::NAN);
            moment.position = fix.position;
            moment.velocity_mps = Vector::new(north, east, down);
        }
        for (time, body_to_ned) in attitudes {
            moments.entry(time).or_insert_with(|| unknown(time)).body_to_ned = body_to_ned;
        }
        Self::of_solutions(moments.into_values().collect())
    }

    /// The trajectory of an estimator's `solutions`, in order of time.
    #[must_use]
    pub fn of_solutions(solutions: Vec<Solution>) -> Self {
        Self { solutions, local_m: Vec::new(), origin: None, warnings: Vec::new() }
    }

    /// Whether the positions are metres from an unknown origin.
    #[must_use]
    pub fn is_local(&self) -> bool {
        !self.local_m.is_empty()
    }

    /// Whether the file contains positions on Earth, or the origin of its local positions.
    #[must_use]
    pub fn is_placed(&self) -> bool {
        !self.is_local() || self.origin.is_some()
    }

    /// Converts a local trajectory to positions on Earth, at the origin that its file states; without one, it stays
    /// local.
    pub fn place_as_named(&mut self) {
        if let Some(origin) = self.origin {
            self.place(&origin);
        }
    }

    /// Converts a local trajectory to positions on Earth, at `origin`; a trajectory on Earth stays unchanged.
    pub fn place(&mut self, origin: &Geodetic) {
        for (solution, offset_m) in self.solutions.iter_mut().zip(std::mem::take(&mut self.local_m))
        {
            solution.position = Geodetic::from_local_ned(origin, offset_m).unwrap_or(UNKNOWN);
        }
    }
}

const UNKNOWN: Geodetic =
    Geodetic { latitude_rad: f64::NAN, longitude_rad: f64::NAN, height_m: f64::NAN };

/// A solution at `time` with unknown values.
pub(super) fn unknown(time: Time) -> Solution {
    let nothing = [f64::NAN; 3];
    Solution {
        time,
        position: UNKNOWN,
        velocity_mps: nothing.into(),
        body_to_ned: Rotation::claim(DQuat::from_array([f64::NAN; 4])),
        angular_rate_radps: nothing.into(),
        heading_revision_rad: 0.0,
        position_sigma_m: nothing.into(),
        velocity_sigma_mps: nothing.into(),
        attitude_sigma_rad: nothing,
        gyro_bias_radps: nothing.into(),
        accel_bias_mps2: nothing.into(),
        gyro_bias_sigma_radps: nothing.into(),
        accel_bias_sigma_mps2: nothing.into(),
    }
}
