//! The first attitude. Tilt comes from the inertial unit's own attitude, from levelling, or from the acceleration
//! between two fixes. Heading comes from a source, if there is one.

use super::pull::level;
use super::{Aligner, HeadingSource};
use crate::frames::{Body, EulerAngles, Ned, Rotation, Vector, wrap_angle};
use crate::gps::Fix;
use crate::scalar::Scalar;

/// One-sigma of a completely unknown angle, rad.
const ANY_ANGLE_RAD: f64 = core::f64::consts::PI / 1.732_050_807_568_877_2;
/// Minimum one-sigma of a two-antenna heading at the start, rad: the vehicle may have turned since the heading.
const MIN_ANTENNA_SIGMA_RAD: f64 = 0.02;

/// The first attitude and its uncertainty.
pub(super) struct Oriented {
    pub body_to_ned: Rotation<Body, Ned>,
    pub heading: HeadingSource,
    pub tilt_sigma_rad: f64,
    /// One-sigma of the attitude about `axis`, rad.
    pub heading_sigma_rad: f64,
    /// Direction about which the attitude is unknown until a source gives the heading.
    pub axis: Vector<Ned>,
    /// Acceleration of the vehicle, m/s²; zero if unknown.
    pub acceleration_mps2: Vector<Ned>,
}

/// Largest difference, rad, between the direction's azimuth and the wanted azimuth at which the turn is complete.
const POINTED_RAD: f64 = 1e-6;
/// Largest number of turns towards an azimuth. If the axis is not vertical, each turn only comes closer to the azimuth.
const MAX_TURNS: usize = 100;
/// Unit vector down.
const DOWN: Vector<Ned> = Vector::new(0.0, 0.0, 1.0);
/// Forward axis of the body.
const FORWARD: Vector<Body> = Vector::new(1.0, 0.0, 0.0);

impl Aligner {
    /// Attitude at a fix with a velocity one-sigma of `sigma_mps`, once the window is long enough. `None` if the next
    /// fix will give a better one.
    pub(super) fn orient<const WEIGH: bool>(
        &self,
        fix: &Fix,
        at_rest: bool,
        sigma_mps: f64,
    ) -> Option<Oriented> {
        let config = &self.config;
        let mut oriented = Oriented {
            body_to_ned: Rotation::IDENTITY,
            heading: HeadingSource::Unknown,
            tilt_sigma_rad: config.level_sigma_rad,
            heading_sigma_rad: ANY_ANGLE_RAD,
            axis: DOWN,
            acceleration_mps2: Vector::ZERO,
        };
        if let Some(angles) = self.attitude {
            let yaw_rad = angles.yaw_rad + config.attitude_declination_rad;
            oriented.body_to_ned = Rotation::from_euler(EulerAngles { yaw_rad, ..angles });
            oriented.tilt_sigma_rad = config.attitude_tilt_sigma_rad;
        } else {
            oriented.body_to_ned = level(self.window.force);
            if !at_rest {
                oriented.tilt_sigma_rad = config.moving_level_sigma_rad;
                if WEIGH {
                    self.tilt(&mut oriented, fix, sigma_mps)?;
                }
            }
        }
        let time = self.window.last()?;
        let antennas = self.antenna_heading.filter(|(told, ..)| libm::fabs(time - *told) < 1.0);
        if let Some((_, heading_rad, sigma_rad)) = antennas
            && self.allows(HeadingSource::SecondAntenna)
            && oriented.point(config.baseline_m.unwrap_or(FORWARD), heading_rad.into())
        {
            oriented.heading = HeadingSource::SecondAntenna;
            oriented.heading_sigma_rad = f64::from(sigma_rad).max(MIN_ANTENNA_SIGMA_RAD);
        } else if self.attitude.is_some() && self.allows(HeadingSource::Attitude) {
            oriented.heading = HeadingSource::Attitude;
            oriented.heading_sigma_rad = config.heading_sigma_rad;
        } else if let Some(field) = self.field_gauss
            && self.allows(HeadingSource::Magnetometer)
            && oriented.point(field, config.declination_rad)
        {
            oriented.heading = HeadingSource::Magnetometer;
            oriented.heading_sigma_rad = config.heading_sigma_rad + oriented.tilt_sigma_rad;
        } else if config.heading == Some(HeadingSource::Course) {
            let [north, east] = fix.horizontal_velocity_mps?;
            let is_fast = Scalar::hypot(north, east) >= config.course_speed_mps;
            if !(is_fast && oriented.point(FORWARD, libm::atan2(east, north))) {
                return None;
            }
            oriented.heading = HeadingSource::Course;
            oriented.heading_sigma_rad = config.heading_sigma_rad;
        }
        Some(oriented)
    }

    /// Refines the tilt of a levelled vehicle in motion. Sets its uncertainty or, for a vehicle that accelerates, the
    /// attitude from the specific force between two fixes.
    fn tilt(&self, oriented: &mut Oriented, fix: &Fix, sigma_mps: f64) -> Option<()> {
        let usual_rad = oriented.tilt_sigma_rad;
        let since_fix = &self.window.since_fix;
        let has_velocity = fix.horizontal_velocity_mps.is_some();
        if has_velocity && !since_fix.is_begun() && self.window.is_manoeuvring() {
            return None;
        }
        let Some(pull) = since_fix.pull(fix, self.window.rate, sigma_mps) else { return Some(()) };
        let tilt_of_force_rad = pull.tilt_of_force_rad();
        if !pull.agrees {
            oriented.tilt_sigma_rad = usual_rad.max(tilt_of_force_rad + pull.sigma_rad);
        } else if tilt_of_force_rad > usual_rad.max(2.0 * pull.sigma_rad) {
            oriented.body_to_ned = pull.attitude();
            oriented.tilt_sigma_rad = usual_rad.max(pull.sigma_rad);
            oriented.axis = pull.axis();
            oriented.acceleration_mps2 = pull.acceleration_mps2();
        } else if pull.has_turned {
            oriented.body_to_ned = level(pull.body);
        }
        Some(())
    }

    fn allows(&self, source: HeadingSource) -> bool {
        self.config.heading.is_none_or(|only| only == source)
    }
}

impl Oriented {
    /// Turns about the axis until `direction` in the body points to `azimuth_rad`. Returns `false` if it cannot, or if
    /// less than 2 % of `direction` is horizontal.
    ///
    /// # Source
    /// Equation (A2) of docs/equations.md.
    fn point(&mut self, direction: Vector<Body>, azimuth_rad: f64) -> bool {
        for _ in 0..MAX_TURNS {
            let pointing = self.body_to_ned * direction;
            let off_rad = wrap_angle(azimuth_rad - pointing.azimuth_rad());
            if libm::fabs(off_rad) < POINTED_RAD {
                let [north, east, _] = pointing.to_array();
                return Scalar::hypot(north, east) > 0.02 * pointing.norm();
            }
            self.body_to_ned = self.body_to_ned.turned_in_to(self.axis * off_rad);
        }
        false
    }
}
