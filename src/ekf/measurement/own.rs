//! Measurements of sensors that this crate does not know: the trait that a user implements.

use crate::earth::Geodetic;
use crate::ekf::kernel::covariance::MAX_AXES;
use crate::ekf::output::solution::Solution;
use crate::frames::{Body, Ned, Rotation, Vector};
use crate::time::Time;

/// A reading of a user's own sensor: airspeed, optical flow, a beacon, an odometer.
///
/// The filter compares the reading with the motion that it expects at the time of the reading, gates it and reports the
/// outcome. The reading gives one [`Row`] for each measured quantity. [`check_derivatives`](super::check_derivatives)
/// checks the derivatives of the rows.
///
/// The error of a reading counts as white. If readings share a slow error, enlarge the one-sigma by √(2 τ / interval),
/// with τ the correlation time.
///
/// # Examples
/// The forward speed of a wheel, m/s:
///
/// ```
/// use hovernav::ekf::{Expected, Measurement, Row, Rows, check_derivatives};
/// use hovernav::frames::Rotation;
/// use hovernav::prelude::*;
///
/// struct Wheel {
///     speed_mps: f64,
/// }
///
/// impl Measurement for Wheel {
///     fn compare(&self, expected: &Expected, rows: &mut Rows) {
///         let forward = Vector::new(1.0, 0.0, 0.0);
///         let residual_mps = self.speed_mps - expected.velocity_body_mps().dot(forward);
///         rows.push(Row::new(residual_mps, 0.1).with_velocity_body(expected, forward));
///     }
/// }
///
/// let home = Geodetic::from_degrees(48.1, 11.6, 520.0).ok_or("invalid position")?;
/// let mut expected = Expected::from(&Solution::at_rest(Time::ZERO, home));
/// // A motion without symmetry: some errors do not show at rest.
/// expected.velocity_mps = Vector::new(4.0, -3.0, 0.7);
/// expected.body_to_ned = Rotation::from_euler(EulerAngles::from_degrees(10.0, -20.0, 130.0));
/// expected.angular_rate_radps = Vector::new(0.1, -0.3, 0.2);
/// check_derivatives(&Wheel { speed_mps: 3.0 }, &expected, 1e-6).map_err(|_| "wrong rows")?;
///
/// let mut estimator = Estimator::new(EstimatorConfig::default());
/// // Before the alignment there is no motion to compare with.
/// assert!(estimator.update(&Wheel { speed_mps: 3.0 }, Time::ZERO).is_err());
/// # Ok::<(), &str>(())
/// ```
pub trait Measurement {
    /// Adds a row for each measured quantity. A reading without a row, for example out of the sensor's range, is not
    /// used. The rows of a reading are accepted or rejected together.
    fn compare(&self, expected: &Expected, rows: &mut Rows);

    /// Position of the sensor relative to the point of the solution, body axes, m. [`Expected`] is the motion there.
    fn lever_arm_m(&self) -> Vector<Body> {
        Vector::ZERO
    }

    /// Number of the sensor, which its innovations report: see [`Channel::Own`](crate::ekf::Channel::Own).
    fn sensor(&self) -> u8 {
        0
    }
}

/// The motion of a sensor that the filter expects at the time of a reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expected {
    /// Time of the reading.
    pub time: Time,
    /// Position of the sensor.
    pub position: Geodetic,
    /// Velocity of the sensor over ground, m/s.
    pub velocity_mps: Vector<Ned>,
    /// Attitude of the vehicle.
    pub body_to_ned: Rotation<Body, Ned>,
    /// Angular rate of the vehicle relative to inertial space, less bias, rad/s. The Earth's rate, 7e-5 rad/s, is part
    /// of it.
    pub angular_rate_radps: Vector<Body>,
}

impl Expected {
    /// Velocity of the sensor in body axes, m/s.
    #[must_use]
    pub fn velocity_body_mps(&self) -> Vector<Body> {
        self.body_to_ned.inverse() * self.velocity_mps
    }
}

impl From<&Solution> for Expected {
    /// The motion of the solution's point, for tests of a [`Measurement`].
    fn from(solution: &Solution) -> Self {
        Self {
            time: solution.time,
            position: solution.position,
            velocity_mps: solution.velocity_mps,
            body_to_ned: solution.body_to_ned,
            angular_rate_radps: solution.angular_rate_radps,
        }
    }
}

/// One measured quantity: its residual, and the derivatives of the expected value with respect to the motion of the
/// sensor.
///
/// The unit of the quantity is free. All numbers must be finite: residual and one-sigma at most 1e9, derivatives at
/// most 1e6, and the one-sigma at least 1e-9. Otherwise the reading is not used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Measured minus expected.
    pub residual: f64,
    /// One-sigma of the measurement's white error.
    pub sigma: f64,
    /// Derivative of the expected value with respect to the position north, east and down, per m.
    pub position: Vector<Ned>,
    /// Derivative of the expected value with respect to the velocity north, east and down, per m/s.
    pub velocity: Vector<Ned>,
    /// Derivative of the expected value with respect to a small rotation of the body about north, east and down, per
    /// rad.
    pub attitude: Vector<Ned>,
    /// Derivative of the expected value with respect to the angular rate about the body axes, per rad/s.
    pub angular_rate: Vector<Body>,
}

/// Largest residual and one-sigma of a row, far below the overflow of products in single precision.
const LARGEST: f64 = 1e9;
/// Largest derivative of a row, far below the overflow of products in single precision.
const LARGEST_DERIVATIVE: f64 = 1e6;
/// Smallest one-sigma of a row.
const MIN_SIGMA: f64 = 1e-9;

impl Row {
    /// A quantity with this residual, measured minus expected, and the one-sigma `sigma`. Its derivatives are zero.
    #[must_use]
    pub const fn new(residual: f64, sigma: f64) -> Self {
        Self {
            residual,
            sigma,
            position: Vector::ZERO,
            velocity: Vector::ZERO,
            attitude: Vector::ZERO,
            angular_rate: Vector::ZERO,
        }
    }

    /// This quantity with a derivative with respect to the position, per m.
    #[must_use]
    pub const fn with_position(mut self, derivative: Vector<Ned>) -> Self {
        self.position = derivative;
        self
    }

    /// This quantity with a derivative with respect to the velocity, per m/s.
    #[must_use]
    pub const fn with_velocity(mut self, derivative: Vector<Ned>) -> Self {
        self.velocity = derivative;
        self
    }

    /// This quantity with a derivative with respect to a small rotation of the body about north, east and down, per
    /// rad.
    #[must_use]
    pub const fn with_attitude(mut self, derivative: Vector<Ned>) -> Self {
        self.attitude = derivative;
        self
    }

    /// This quantity with a derivative with respect to the angular rate, per rad/s.
    #[must_use]
    pub const fn with_angular_rate(mut self, derivative: Vector<Body>) -> Self {
        self.angular_rate = derivative;
        self
    }

    /// This quantity with a derivative with respect to the velocity in body axes, per m/s. It then depends on velocity
    /// and attitude; both derivatives are replaced.
    ///
    /// # Source
    /// Equation (M20) of docs/equations.md.
    #[must_use]
    pub fn with_velocity_body(self, expected: &Expected, derivative: Vector<Body>) -> Self {
        let direction = expected.body_to_ned * derivative;
        self.with_velocity(direction).with_attitude(direction.cross(expected.velocity_mps))
    }

    /// Whether every number is in its range.
    pub(super) fn is_possible(&self) -> bool {
        // Written so that a NaN is rejected.
        let within = |vector: [f64; 3]| vector.iter().all(|&d| libm::fabs(d) <= LARGEST_DERIVATIVE);
        libm::fabs(self.residual) <= LARGEST
            && (MIN_SIGMA..=LARGEST).contains(&self.sigma)
            && within(self.position.to_array())
            && within(self.velocity.to_array())
            && within(self.attitude.to_array())
            && within(self.angular_rate.to_array())
    }
}

/// The rows of one reading, at most six.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rows {
    rows: [Option<Row>; MAX_AXES],
    overflowed: bool,
}

impl Rows {
    /// Adds a row. A reading with more than six rows is not used.
    pub fn push(&mut self, row: Row) {
        match self.rows.iter_mut().find(|slot| slot.is_none()) {
            Some(slot) => *slot = Some(row),
            None => self.overflowed = true,
        }
    }

    /// The rows, in the order in which they were added.
    pub fn iter(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().flatten()
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.iter().next().is_none()
    }

    /// Whether there are at most six rows, and each one is possible.
    pub(super) fn are_possible(&self) -> bool {
        !self.overflowed && self.iter().all(Row::is_possible)
    }
}
