//! Conversion of samples with other axes and units to forward, right, down, rad/s and m/s².

use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use hovernav::earth::STANDARD_GRAVITY_MPS2;
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector};
use hovernav::glam::{DQuat, DVec3};
use hovernav::imu::{ImuAxes, ImuSample, Motion};

/// Directions of the axes x, y and z of a sensor, as three letters: **f**orward, **b**ack, **r**ight, **l**eft, **u**p,
/// **d**own. Right-handed.
///
/// ```
/// use hovernav_dataset::Axes;
/// use hovernav::frames::Vector;
/// let axes: Axes = "flu".parse()?;
/// assert_eq!(axes.to_body(Vector::new(1.0, 2.0, 3.0)).to_array(), [1.0, -2.0, -3.0]);
/// assert!("fru".parse::<Axes>().is_err());
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axes([u8; 3]);

impl Default for Axes {
    fn default() -> Self {
        Self(*b"frd")
    }
}

/// Components forward, right, down of the direction that `letter` names; `None` for another letter.
fn direction(letter: u8) -> Option<[f64; 3]> {
    Some(match letter {
        b'f' => [1.0, 0.0, 0.0],
        b'b' => [-1.0, 0.0, 0.0],
        b'r' => [0.0, 1.0, 0.0],
        b'l' => [0.0, -1.0, 0.0],
        b'd' => [0.0, 0.0, 1.0],
        b'u' => [0.0, 0.0, -1.0],
        _ => return None,
    })
}

impl std::str::FromStr for Axes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let rejected = |expected: &str| format!("found \"{text}\", expected {expected}");
        let &[x, y, z] = text.as_bytes() else {
            return Err(rejected("three letters of f, b, r, l, u, d, such as \"flu\""));
        };
        let axes = [x, y, z].map(direction);
        let [Some(x_axis), Some(y_axis), Some(z_axis)] = axes else {
            return Err(rejected("three letters of f, b, r, l, u, d, such as \"flu\""));
        };
        let [x_axis, y_axis, z_axis] = [x_axis, y_axis, z_axis].map(Vector::<Body>::from);
        if x_axis.cross(y_axis) != z_axis {
            return Err(rejected("three directions that make right-handed axes, such as \"flu\""));
        }
        Ok(Self([x, y, z]))
    }
}

impl Axes {
    /// Converts a vector from these axes to forward, right, down.
    #[must_use]
    pub fn to_body(self, vector: Vector<Body>) -> Vector<Body> {
        let components = vector.to_array().into_iter().zip(self.0);
        components.fold(Vector::ZERO, |sum, (component, letter)| {
            let along = direction(letter).unwrap_or_default();
            sum + Vector::from(along.map(|part| part * component))
        })
    }

    /// Whether these axes are forward, right, down.
    #[must_use]
    pub fn are_body(&self) -> bool {
        *self == Self::default()
    }
}

impl Serialize for Axes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&String::from_utf8_lossy(&self.0))
    }
}

impl<'de> Deserialize<'de> for Axes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(de::Error::custom)
    }
}

/// Unit of accelerations; increments of velocity have this unit times a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum AccelUnit {
    /// m/s².
    #[default]
    Mps2,
    /// Standard gravity.
    G,
    /// Thousandths of standard gravity.
    Mg,
}

/// Unit of angular rates; increments of angle have this unit times a second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum GyroUnit {
    /// rad/s.
    #[default]
    Radps,
    /// °/s.
    Degps,
}

/// Conversion of inertial samples with other axes and units: see [`ImuSection::take_reading`](crate::ImuSection).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Directions of the sensor's axes.
    pub(crate) axes: Axes,
    /// Rotation from the inertial unit's forward, right and down to the vehicle's, if they differ.
    pub(crate) mounting: Option<DQuat>,
    pub(crate) accel_unit: AccelUnit,
    pub(crate) gyro_unit: GyroUnit,
    pub(crate) accel_is_gravity: bool,
    /// Whether the magnetic field is ignored.
    pub(crate) without_field: bool,
    /// Whether the inertial unit's own attitude is ignored.
    pub(crate) without_attitude: bool,
}

/// Rotation from the roll, pitch and yaw of an inertial unit in its vehicle; `None` if all are zero.
pub(crate) fn rotation_of(mounting_deg: [f64; 3]) -> Option<DQuat> {
    let [roll, pitch, yaw] = mounting_deg;
    // The mounting angles of an inertial unit in a vehicle are defined like the attitude angles of a vehicle in NED.
    let turned = || Rotation::from_euler(EulerAngles::from_degrees(roll, pitch, yaw)).quaternion();
    (mounting_deg != [0.0; 3]).then(turned)
}

impl Reading {
    /// Converts `motion` to forward, right, down, rad/s and m/s².
    pub(crate) fn motion(&self, motion: Motion) -> Motion {
        // Without a conversion the samples stay bit-identical.
        if *self == Self::default() {
            return motion;
        }
        let gyro = match self.gyro_unit {
            GyroUnit::Radps => 1.0,
            GyroUnit::Degps => 1f64.to_radians(),
        };
        let accel = match self.accel_unit {
            AccelUnit::Mps2 => 1.0,
            AccelUnit::G => STANDARD_GRAVITY_MPS2,
            AccelUnit::Mg => 1e-3 * STANDARD_GRAVITY_MPS2,
        } * if self.accel_is_gravity { -1.0 } else { 1.0 };
        let turn = |vector: Vector<Body>| self.turned(vector) * gyro;
        let push = |vector: Vector<Body>| self.turned(vector) * accel;
        match motion {
            Motion::Rates { angular_rate_radps, specific_force_mps2 } => Motion::Rates {
                angular_rate_radps: turn(angular_rate_radps),
                specific_force_mps2: push(specific_force_mps2),
            },
            Motion::Increments { angle_rad, velocity_mps } => {
                Motion::Increments { angle_rad: turn(angle_rad), velocity_mps: push(velocity_mps) }
            }
        }
    }

    /// Converts `sample`, with its magnetic field in gauss, to forward, right, down, rad/s and m/s².
    #[must_use]
    pub fn applied(&self, sample: ImuSample) -> ImuSample {
        let field = sample.magnetic_field_gauss.filter(|_| !self.without_field);
        let field = field.map(|field| self.field(field));
        let attitude = sample.attitude.filter(|_| !self.without_attitude);
        ImuSample {
            motion: self.motion(sample.motion),
            attitude: attitude.map(|attitude| self.attitude(attitude)),
            magnetic_field_gauss: field,
            clipped: self.marks(sample.clipped),
            ..sample
        }
    }

    /// Converts a vector from the inertial unit's axes to the vehicle's.
    fn turned(&self, vector: Vector<Body>) -> Vector<Body> {
        let vector = self.axes.to_body(vector);
        match self.mounting {
            Some(mounting) => mounting.mul_vec3(DVec3::from(vector.to_array())).to_array().into(),
            None => vector,
        }
    }

    /// The vehicle's attitude from the inertial unit's own attitude, whose axes are already forward, right and down.
    pub(crate) fn attitude(&self, attitude: EulerAngles) -> EulerAngles {
        let Some(mounting) = self.mounting else { return attitude };
        let unit = Rotation::<Body, Ned>::from_euler(attitude).quaternion();
        Rotation::<Body, Ned>::claim(unit * mounting.inverse()).euler()
    }

    /// Converts the marks of sensor axes at full scale to the vehicle's axes. If the inertial unit is mounted askew, a
    /// mark goes to several vehicle axes. These are the axes on which the marked axis has a component of at least 0.1.
    pub(crate) fn marks(&self, marks: ImuAxes) -> ImuAxes {
        const DETERMINED: f64 = 0.1;
        let of_axis = |axis: usize| {
            let mut along = [0.0; 3];
            along[axis] = 1.0;
            self.turned(along.into()).to_array().map(|share| share.abs() >= DETERMINED)
        };
        let turned = |marks: [bool; 3]| {
            let mut all = [false; 3];
            for axis in (0..3).filter(|&axis| marks[axis]) {
                for (mark, marked) in all.iter_mut().zip(of_axis(axis)) {
                    *mark |= marked;
                }
            }
            all
        };
        ImuAxes { gyro: turned(marks.gyro), accel: turned(marks.accel) }
    }

    /// Converts a magnetic field from the inertial unit's axes to the vehicle's.
    pub(crate) fn field(&self, field: Vector<Body>) -> Vector<Body> {
        // Without a conversion the field stays bit-identical.
        if self.axes.are_body() && self.mounting.is_none() { field } else { self.turned(field) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn reading(mounting_deg: [f64; 3]) -> Reading {
        Reading { mounting: rotation_of(mounting_deg), ..Reading::default() }
    }

    fn assert_near(found: [f64; 3], expected: [f64; 3]) {
        assert_abs_diff_eq!(found[..], expected[..], epsilon = 1e-9);
    }

    #[test]
    fn a_unit_that_stands_askew_in_a_level_vehicle_measures_its_own_tilt() {
        // Nose up by 30°: the specific force at rest, up, has a component along x.
        let (sin, cos) = 30f64.to_radians().sin_cos();
        let unit = Vector::new(9.81 * sin, 0.0, -9.81 * cos);
        assert_near(reading([0.0, 30.0, 0.0]).turned(unit).to_array(), [0.0, 0.0, -9.81]);
        // If the inertial unit is turned right by 90°, its left is the vehicle's forward.
        let left = Vector::new(0.0, -1.0, 0.0);
        assert_near(reading([0.0, 0.0, 90.0]).turned(left).to_array(), [1.0, 0.0, 0.0]);
        assert_eq!(rotation_of([0.0; 3]), None);
    }

    #[test]
    fn the_vehicle_is_level_where_the_unit_says_its_own_mounting() {
        let mounting = [12.0, -7.0, 40.0];
        let [roll, pitch, yaw] = mounting;
        let unit = EulerAngles::from_degrees(roll, pitch, yaw);
        assert_near(reading(mounting).attitude(unit).to_degrees(), [0.0; 3]);
    }

    #[test]
    fn marks_go_to_the_axes_that_a_clipped_one_reports() {
        let marks = ImuAxes { gyro: [false; 3], accel: [true, false, false] };
        assert_eq!(reading([0.0, 2.0, 0.0]).marks(marks).accel, [true, false, false]);
        assert_eq!(reading([0.0, 0.0, 45.0]).marks(marks).accel, [true, true, false]);
    }
}
