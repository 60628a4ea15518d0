//! Comparison of a measurement's derivatives with differences of its residuals.

use core::error::Error;
use core::fmt;

use super::own::{Expected, Measurement, Row, Rows};

/// Rows of a [`Measurement`] that the filter would use wrongly or not at all.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum WrongRows {
    /// No row, more than six rows, or a row with a number out of its range. The filter would not use the reading.
    Unusable,
    /// A slightly different motion has another number of rows, or unusable ones.
    Unsteady {
        /// The changed component of the motion.
        by: &'static str,
    },
    /// A derivative differs from the difference of the residuals.
    Derivative {
        /// Index of the row, from 0.
        row: usize,
        /// Component of the motion.
        by: &'static str,
        /// The derivative in the row.
        stated: f64,
        /// The derivative from central differences of the residuals.
        numeric: f64,
    },
}

impl fmt::Display for WrongRows {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unusable => {
                f.write_str("found no usable rows, expected one to six with numbers in range")
            }
            Self::Unsteady { by } => write!(f, "found other rows after a small change of {by}"),
            Self::Derivative { row, by, stated, numeric } => {
                write!(f, "row {row} by {by}: found {stated}, expected {numeric}")
            }
        }
    }
}

impl Error for WrongRows {}

/// Components of a motion, block by block.
const COMPONENTS: [[&str; 3]; 4] = [
    ["position north, per m", "position east, per m", "position down, per m"],
    ["velocity north, per m/s", "velocity east, per m/s", "velocity down, per m/s"],
    [
        "rotation about north, per rad",
        "rotation about east, per rad",
        "rotation about down, per rad",
    ],
    [
        "angular rate forward, per rad/s",
        "angular rate right, per rad/s",
        "angular rate down, per rad/s",
    ],
];
/// Step size of the differences in each block: m, m/s, rad, rad/s. A position in degrees of 64 bits is exact to 1e-9 m.
const STEPS: [f64; 4] = [0.1, 1e-2, 1e-4, 1e-3];
/// Rounding error of a residual r, divided by 1 + |r|. Division by the step size gives the error of a numeric
/// derivative.
const ROUNDING: f64 = 1e-9;

impl Expected {
    /// The motion with one component of one block moved by `by`.
    fn moved(&self, block: usize, axis: usize, by: f64) -> Self {
        let step: [f64; 3] = core::array::from_fn(|of| if of == axis { by } else { 0.0 });
        let mut moved = *self;
        match block {
            0 => moved.position = self.position.displaced(step.into()),
            1 => moved.velocity_mps += step.into(),
            2 => moved.body_to_ned = self.body_to_ned.turned_in_to(step.into()),
            _ => moved.angular_rate_radps += step.into(),
        }
        moved
    }
}

impl Row {
    /// Derivatives with respect to one block of the motion.
    fn block(&self, block: usize) -> [f64; 3] {
        match block {
            0 => self.position.to_array(),
            1 => self.velocity.to_array(),
            2 => self.attitude.to_array(),
            _ => self.angular_rate.to_array(),
        }
    }
}

/// Compares the derivatives of every row with central differences of the residuals about `expected`. For tests of a
/// user's [`Measurement`], at a motion without symmetry: turned, moving and turning.
///
/// `tolerance` is relative to the largest derivative of the row with respect to position, velocity, attitude or angular
/// rate. A value of 1e-5 suits measurements that are nearly linear over 0.1 m, 0.01 m/s, 1e-4 rad and 1e-3 rad/s.
///
/// # Errors
/// [`WrongRows`], the first that is found.
pub fn check_derivatives(
    measurement: &(impl Measurement + ?Sized),
    expected: &Expected,
    tolerance: f64,
) -> Result<(), WrongRows> {
    let usable = |at: &Expected| {
        let mut rows = Rows::default();
        measurement.compare(at, &mut rows);
        (!rows.is_empty() && rows.are_possible()).then_some(rows)
    };
    let rows = usable(expected).ok_or(WrongRows::Unusable)?;
    for (block, (names, step)) in COMPONENTS.iter().zip(STEPS).enumerate() {
        for (axis, by) in names.iter().enumerate() {
            let moved = |by| usable(&expected.moved(block, axis, by));
            let (below, above) = moved(-step).zip(moved(step)).ok_or(WrongRows::Unsteady { by })?;
            let count = rows.iter().count();
            if below.iter().count() != count || above.iter().count() != count {
                return Err(WrongRows::Unsteady { by });
            }
            for (index, (row, (below, above))) in
                rows.iter().zip(below.iter().zip(above.iter())).enumerate()
            {
                // Rows contain derivatives of the expected value, which have the opposite sign of those of the
                // residual.
                let numeric = (below.residual - above.residual) / (2.0 * step);
                let stated = row.block(block).get(axis).copied().unwrap_or(f64::NAN);
                let largest = row
                    .block(block)
                    .iter()
                    .fold(libm::fabs(numeric), |most, d| most.max(libm::fabs(*d)));
                let rounding = ROUNDING * (1.0 + libm::fabs(row.residual)) / step;
                if libm::fabs(stated - numeric) > tolerance * largest + rounding {
                    return Err(WrongRows::Derivative { row: index, by, stated, numeric });
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::earth::Geodetic;
    use crate::frames::{EulerAngles, Rotation, Vector};
    use crate::time::Time;

    /// The distance to a beacon, and the forward speed, with a factor on the derivatives of the speed.
    struct Both {
        beacon: Geodetic,
        factor: f64,
    }

    impl Measurement for Both {
        fn compare(&self, expected: &Expected, rows: &mut Rows) {
            let to_beacon = crate::earth::LocalEarth::at(&expected.position)
                .displacement(&expected.position, &self.beacon);
            let distance_m = to_beacon.norm();
            let away = to_beacon * (-1.0 / distance_m);
            rows.push(Row::new(100.0 - distance_m, 0.2).with_position(away));
            let forward = Vector::new(1.0, 0.0, 0.0);
            let residual_mps = 3.0 - expected.velocity_body_mps().x();
            let row = Row::new(residual_mps, 0.1).with_velocity_body(expected, forward);
            rows.push(row.with_velocity(row.velocity * self.factor));
            let pitch = Row::new(-expected.angular_rate_radps.y(), 0.01);
            rows.push(pitch.with_angular_rate(Vector::new(0.0, 1.0, 0.0)));
        }
    }

    fn expected() -> Expected {
        Expected {
            time: Time::ZERO,
            position: Geodetic::from_degrees(48.1, 11.6, 520.0).unwrap(),
            velocity_mps: Vector::new(4.0, -3.0, 0.7),
            body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(10.0, -20.0, 130.0)),
            angular_rate_radps: Vector::new(0.1, -0.3, 0.2),
        }
    }

    #[test]
    fn right_derivatives_pass_and_wrong_ones_are_named() {
        let beacon = expected().position.displaced(Vector::new(60.0, -80.0, 12.0));
        let right = Both { beacon, factor: 1.0 };
        assert_eq!(check_derivatives(&right, &expected(), 1e-4), Ok(()));
        let wrong = check_derivatives(&Both { beacon, factor: 1.01 }, &expected(), 1e-4);
        let WrongRows::Derivative { row, by, stated, numeric } = wrong.unwrap_err() else {
            panic!("{wrong:?}");
        };
        assert_eq!((row, by), (1, "velocity north, per m/s"));
        assert!((stated / numeric - 1.01).abs() < 1e-6, "{stated} {numeric}");
    }

    /// As many rows as given, of one-sigma `sigma`; one more above a velocity north of 4 m/s.
    struct Count {
        rows: usize,
        sigma: f64,
        grows: bool,
    }

    impl Measurement for Count {
        fn compare(&self, expected: &Expected, rows: &mut Rows) {
            let more = usize::from(self.grows && expected.velocity_mps.x() > 4.0);
            for _ in 0..self.rows + more {
                rows.push(Row::new(0.0, self.sigma));
            }
        }
    }

    #[test]
    fn rows_that_vanish_appear_or_are_never_used_are_wrong() {
        let found = |rows, sigma, grows| {
            check_derivatives(&Count { rows, sigma, grows }, &expected(), 1e-4)
        };
        assert_eq!(found(1, 1.0, false), Ok(()));
        for unusable in [found(0, 1.0, false), found(7, 1.0, false), found(1, 0.0, false)] {
            assert_eq!(unusable, Err(WrongRows::Unusable));
        }
        let by = "velocity north, per m/s";
        for rows in [0, 1, 6] {
            let unsteady = found(rows, 1.0, true).unwrap_err();
            let expected = if rows == 0 { WrongRows::Unusable } else { WrongRows::Unsteady { by } };
            assert_eq!(unsteady, expected);
        }
    }
}
