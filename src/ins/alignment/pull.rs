//! Direction of the specific force of a vehicle that accelerates, from two fixes.

use crate::earth::STANDARD_GRAVITY_MPS2;
use crate::frames::{Body, EulerAngles, Ned, Rotation, Vector};
use crate::gps::Fix;
use crate::imu::MeanRates;
use crate::scalar::Scalar;

/// Usable time between two fixes, s. Over a shorter time the acceleration is too inaccurate; over a longer time gyro
/// errors accumulate.
const USABLE_S: core::ops::Range<f32> = 0.15..6.0;
/// Possible unreported delay of a receiver's velocity, s, during which a vehicle turns.
const LATE_S: f64 = 0.15;
/// Smallest specific force, m/s², whose direction the fixes show; in near free fall the force is smaller.
const WEAK_MPS2: f64 = 5.0;
/// Fraction of the specific force by which the magnitudes from the inertial unit and the fixes may differ.
const ALIKE_SHARE: f64 = 0.1;

/// Cosine of 4°, half of the angle of 8° above which the body counts as turned.
const TURNED_COSINE: f64 = 0.997_56;

/// Motion measured since a fix; without a fix, its velocity is NaN.
#[derive(Clone, Copy, Debug)]
pub(super) struct SinceFix {
    /// Rotation from the present body axes to those at the fix.
    now_to_then: Rotation<Body, Body, f32>,
    /// Integral of specific force in the axes at the fix, m/s.
    force_integral_mps: Vector<Body, f32>,
    force_integral_s: f32,
    /// The fix's velocity; its down component is NaN if not measured.
    velocity_mps: Vector<Ned, f32>,
}

/// A mean specific force, m/s², from the inertial unit and from the fixes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pull {
    pub body: Vector<Body>,
    pub ned: Vector<Ned>,
    /// One-sigma of the direction, rad.
    pub sigma_rad: f64,
    /// Whether both forces have the same magnitude.
    pub agrees: bool,
    /// Whether the body turned so far that the mean force belongs to no single attitude.
    pub has_turned: bool,
}

impl Default for SinceFix {
    fn default() -> Self {
        Self {
            now_to_then: Rotation::IDENTITY,
            force_integral_mps: Vector::ZERO,
            force_integral_s: 0.0,
            velocity_mps: Vector::new(f32::NAN, f32::NAN, f32::NAN),
        }
    }
}

impl SinceFix {
    /// Starts at a fix, if it has a velocity.
    pub fn begin(fix: &Fix) -> Self {
        velocity(fix).map_or_else(Self::default, |velocity_mps| Self {
            velocity_mps: velocity_mps.cast(),
            ..Self::default()
        })
    }

    /// Whether there was a fix with velocity.
    pub fn is_begun(&self) -> bool {
        self.velocity_mps.x().is_finite()
    }

    /// Adds the motion over a sample's interval.
    pub fn observe_sample(&mut self, mean: MeanRates, interval_s: f64) {
        let now_to_then: Rotation<Body, Body> = self.now_to_then.cast();
        let turn_rad = mean.angular_rate_radps * interval_s;
        let halfway = now_to_then.turned_in_from(turn_rad * 0.5);
        self.force_integral_mps += (halfway * mean.specific_force_mps2 * interval_s).cast();
        self.force_integral_s += interval_s as f32;
        self.now_to_then = now_to_then.turned_in_from(turn_rad).renormalised().cast();
    }

    /// Whether there was no fix, or the last one is too old to give an acceleration.
    pub fn is_old(&self) -> bool {
        !self.is_begun() || self.force_integral_s >= USABLE_S.end
    }

    /// Mean specific force from the stored fix to `fix`. Both velocities have the one-sigma `sigma_mps`, and the body
    /// turns at `rate_radps`. `None` if the two fixes do not determine it.
    ///
    /// # Source
    /// Equation (A4) of docs/equations.md.
    pub fn pull(&self, fix: &Fix, rate_radps: Vector<Body>, sigma_mps: f64) -> Option<Pull> {
        let now_mps = velocity(fix).filter(|_| USABLE_S.contains(&self.force_integral_s))?;
        let force_integral_s = f64::from(self.force_integral_s);
        let now_to_then: Rotation<Body, Body> = self.now_to_then.cast();
        let body =
            now_to_then.inverse() * self.force_integral_mps.cast() * (1.0 / force_integral_s);
        let [north, east, down] =
            ((now_mps - self.velocity_mps.cast()) * (1.0 / force_integral_s)).to_array();
        // Without a vertical velocity, the magnitude of the force comes from the inertial unit.
        let up = if down.is_finite() {
            STANDARD_GRAVITY_MPS2 - down
        } else {
            Scalar::sqrt((body.dot(body) - north * north - east * east).max(0.0))
        };
        let ned = Vector::new(north, east, -up);
        let (length, strength) = (ned.norm(), body.norm());
        let noise = core::f64::consts::SQRT_2 * sigma_mps / (length * force_integral_s);
        let late = rate_radps.norm() * LATE_S;
        let sigma_rad = if length < WEAK_MPS2 { 1.0 } else { Scalar::hypot(noise, late) };
        let apart = libm::fabs(strength - length);
        let agrees = up > 0.0 && apart <= (ALIKE_SHARE + 2.0 * noise) * length;
        let is_usable = strength > 0.0 && length > 0.0 && (strength + sigma_rad).is_finite();
        let [.., half_turn_cosine] = now_to_then.to_array();
        let has_turned = libm::fabs(half_turn_cosine) < TURNED_COSINE;
        is_usable.then_some(Pull { body, ned, sigma_rad, agrees, has_turned })
    }
}

impl Pull {
    /// Angle of the force from straight up, rad.
    pub fn tilt_of_force_rad(&self) -> f64 {
        let [north, east, down] = self.ned.to_array();
        libm::atan2(Scalar::hypot(north, east), -down)
    }

    /// Unit vector of the direction about which the attitude stays unknown: down without acceleration.
    pub fn axis(&self) -> Vector<Ned> {
        self.ned * (-1.0 / self.ned.norm())
    }

    /// Acceleration of the vehicle, m/s².
    pub fn acceleration_mps2(&self) -> Vector<Ned> {
        self.ned + Vector::new(0.0, 0.0, STANDARD_GRAVITY_MPS2)
    }

    /// An attitude that turns the measured force of the body to the direction from the fixes. Any turn about
    /// [`axis`](Self::axis) gives another such attitude.
    ///
    /// # Source
    /// Equation (A4) of docs/equations.md.
    pub fn attitude(&self) -> Rotation<Body, Ned> {
        // The NED axes are levelled like body axes: with the specific force from the fixes, resolved in NED. Both
        // levelled frames then have the same force straight up.
        let [north, east, down] = self.ned.to_array();
        let hung = level(Vector::new(north, east, down));
        Rotation::claim((hung.inverse() * level(self.body)).quaternion())
    }
}

/// Velocity of a fix with finite values, its down component NaN if not measured; `None` without a horizontal velocity.
fn velocity(fix: &Fix) -> Option<Vector<Ned>> {
    let [north, east] = fix.horizontal_velocity_mps?;
    let down = fix.measured_down_mps().unwrap_or(f64::NAN);
    Some(Vector::new(north, east, down))
}

/// The attitude at which a specific force points straight up, with heading zero (Groves 5.101).
///
/// # Source
/// Equation (A1) of docs/equations.md.
pub(super) fn level(force: Vector<Body>) -> Rotation<Body, Ned> {
    let [x, y, z] = force.to_array();
    Rotation::from_euler(EulerAngles {
        roll_rad: libm::atan2(-y, -z),
        pitch_rad: libm::atan2(x, Scalar::hypot(y, z)),
        yaw_rad: 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::earth::Geodetic;
    use crate::time::Time;

    fn fix(time_s: f64, velocity_mps: [f64; 3]) -> Fix {
        let place = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        let mut fix = Fix::at(Time::from_seconds(time_s), place);
        fix.horizontal_velocity_mps = Some([velocity_mps[0], velocity_mps[1]]);
        fix.down_velocity_mps = Some(velocity_mps[2]);
        fix
    }

    /// A coordinated turn at 25 m/s and 40 °/s, banked by 60.6°, over one second.
    fn turn() -> (SinceFix, Fix, Vector<Body>, Rotation<Body, Ned>) {
        let (speed, turn_radps) = (25.0, 40f64.to_radians());
        let roll = libm::atan(speed * turn_radps / STANDARD_GRAVITY_MPS2);
        let attitude = |time_s: f64| {
            let yaw_rad = turn_radps * time_s;
            Rotation::from_euler(EulerAngles { roll_rad: roll, pitch_rad: 0.0, yaw_rad })
        };
        let velocity = |time_s: f64| {
            let (sin, cos) = (libm::sin(turn_radps * time_s), libm::cos(turn_radps * time_s));
            [speed * cos, speed * sin, 0.0]
        };
        let rate = attitude(0.0).inverse() * Vector::new(0.0, 0.0, turn_radps);
        let force = Vector::new(0.0, 0.0, -STANDARD_GRAVITY_MPS2 / libm::cos(roll));
        let mut since = SinceFix::begin(&fix(0.0, velocity(0.0)));
        for _ in 0..50 {
            since.observe_sample(
                MeanRates { angular_rate_radps: rate, specific_force_mps2: force },
                0.02,
            );
        }
        (since, fix(1.0, velocity(1.0)), rate, attitude(1.0))
    }

    #[test]
    fn a_banked_turn_is_seen_as_one() {
        let (since, fix, rate, truth) = turn();
        let pull = since.pull(&fix, rate, 0.1).unwrap();
        assert!(
            (pull.tilt_of_force_rad().to_degrees() - 60.0).abs() < 2.0,
            "{}",
            pull.tilt_of_force_rad()
        );
        assert!(pull.agrees);
        let base = pull.attitude();
        // The attitude turns the measured force to the direction from the fixes, for any heading.
        let off = (base * pull.body).cross(pull.ned).norm() / (pull.body.norm() * pull.ned.norm());
        assert!(off < 1e-6, "{off}");
        // The true attitude is one of the turns about the axis.
        let rest =
            (truth * pull.body).cross(pull.ned).norm() / (pull.body.norm() * pull.ned.norm());
        assert!(rest < 0.03, "{rest}");
    }

    #[test]
    fn without_a_vertical_velocity_the_unit_measures_how_strong_the_force_is() {
        let (mut since, mut fix, rate, _) = turn();
        since.velocity_mps = Vector::new(since.velocity_mps.x(), since.velocity_mps.y(), f32::NAN);
        fix.down_velocity_mps = None;
        let pull = since.pull(&fix, rate, 0.1).unwrap();
        assert!(
            (pull.tilt_of_force_rad().to_degrees() - 60.0).abs() < 2.0,
            "{}",
            pull.tilt_of_force_rad()
        );
    }

    #[test]
    fn fixes_that_the_unit_contradicts_are_found() {
        let (since, mut fix, rate, _) = turn();
        fix.horizontal_velocity_mps = Some([200.0, -90.0]);
        let pull = since.pull(&fix, rate, 0.1).unwrap();
        assert!(!pull.agrees && pull.tilt_of_force_rad() > 1.0, "{pull:?}");
        fix.horizontal_velocity_mps = None;
        assert!(since.pull(&fix, rate, 0.1).is_none());
    }
}
