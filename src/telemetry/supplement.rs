//! Supplement: flight control in detail and biases, at a lower rate than the snapshots.

use super::wire::Codec;
use crate::autopilot::Mode;
use crate::ekf::Solution;
use crate::flight_control::{ControlOutputs, FlightControl};
use crate::frames::{Body, Ned, Vector};
use crate::scalar::Scalar;
use crate::time::Time;

// Number of steps per unit; each name ends with the unit.
const WIDTH_MS: f64 = 2e3;
const VELOCITY_MPS: f64 = 100.0;
const ANGLE_RAD: f64 = 1e4;
const GYRO_BIAS_RADPS: f64 = 1e5;
const ACCEL_BIAS_MPS2: f64 = 1e3;
const SHARE: f64 = 1e3;

/// The code of [`Supplement::mode`] without an autopilot.
const NO_AUTOPILOT: u8 = u8::MAX;

/// Flags of flight control at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ControlFlags {
    /// The pilot's switch is closed.
    pub switch_on: bool,
    /// The autopilot flies.
    pub engaged: bool,
    /// The switch has no effect until it has been opened: see [`FlightControl::is_refused`].
    pub refused: bool,
    /// The pilot's signal is lost while the autopilot flies: the autopilot holds.
    pub pilot_lost: bool,
    /// The pilot's signal did not return: the autopilot descends.
    pub descends: bool,
    /// The vehicle reached the geofence, and is not yet well inside again.
    pub outside_geofence: bool,
    /// A stick is at its end.
    pub at_end: bool,
    /// The autopilot flies a test input.
    pub excited: bool,
}

impl ControlFlags {
    /// The flags as bits, in the order of the fields; the first field is the lowest bit.
    #[must_use]
    pub fn bits(self) -> u8 {
        [
            self.switch_on,
            self.engaged,
            self.refused,
            self.pilot_lost,
            self.descends,
            self.outside_geofence,
            self.at_end,
            self.excited,
        ]
        .into_iter()
        .rev()
        .fold(0, |bits, flag| bits << 1 | u8::from(flag))
    }

    /// The inverse of [`ControlFlags::bits`].
    #[must_use]
    pub const fn from_bits(bits: u8) -> Self {
        Self {
            switch_on: bits & 1 != 0,
            engaged: bits & 1 << 1 != 0,
            refused: bits & 1 << 2 != 0,
            pilot_lost: bits & 1 << 3 != 0,
            descends: bits & 1 << 4 != 0,
            outside_geofence: bits & 1 << 5 != 0,
            at_end: bits & 1 << 6 != 0,
            excited: bits & 1 << 7 != 0,
        }
    }
}

/// Flight control and biases at one moment; unknown values are `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Supplement {
    /// Time of the supplement, on the flight's clock.
    pub time: Time,
    /// The autopilot's mode; `None` without an autopilot.
    pub mode: Option<Mode>,
    /// Flags of flight control.
    pub flags: ControlFlags,
    /// The failed checks of the autopilot's readiness: see
    /// [`Readiness::failed_bits`](crate::autopilot::Readiness::failed_bits).
    pub failed_checks: u16,
    /// Width of the pulse on the aux channel, ms.
    pub aux_ms: Option<f64>,
    /// Velocity commanded to the loops, m/s; only while the autopilot holds a velocity.
    pub asked_velocity_mps: Option<Vector<Ned>>,
    /// Heading commanded to the loops, rad; only while the autopilot flies.
    pub asked_heading_rad: Option<f64>,
    /// Gyro bias from the estimator, rad/s.
    pub gyro_bias_radps: Option<Vector<Body>>,
    /// Accelerometer bias from the estimator, m/s².
    pub accel_bias_mps2: Option<Vector<Body>>,
    /// One-sigma of the gyro bias, rad/s.
    pub gyro_bias_sigma_radps: Option<Vector<Body>>,
    /// One-sigma of the accelerometer bias, m/s².
    pub accel_bias_sigma_mps2: Option<Vector<Body>>,
    /// Distance from the centre of the geofence as a fraction of the distance to the geofence: the greater of the
    /// fractions to the side and to the top. 1 at the geofence; `None` without a geofence or a position.
    pub geofence_share: Option<f64>,
}

impl Supplement {
    /// A supplement with only the time.
    #[must_use]
    pub const fn at(time: Time) -> Self {
        Self {
            time,
            mode: None,
            flags: ControlFlags::from_bits(0),
            failed_checks: 0,
            aux_ms: None,
            asked_velocity_mps: None,
            asked_heading_rad: None,
            gyro_bias_radps: None,
            accel_bias_mps2: None,
            gyro_bias_sigma_radps: None,
            accel_bias_sigma_mps2: None,
            geofence_share: None,
        }
    }

    /// Adds the biases of the estimator.
    #[must_use]
    pub const fn with_solution(self, solution: &Solution) -> Self {
        Self {
            gyro_bias_radps: Some(solution.gyro_bias_radps),
            accel_bias_mps2: Some(solution.accel_bias_mps2),
            gyro_bias_sigma_radps: Some(solution.gyro_bias_sigma_radps),
            accel_bias_sigma_mps2: Some(solution.accel_bias_sigma_mps2),
            ..self
        }
    }

    /// Adds the outputs of a cycle of `control`.
    #[must_use]
    pub fn with_control<T: Scalar>(
        self,
        control: &FlightControl<T>,
        outputs: &ControlOutputs,
    ) -> Self {
        let (velocity_mps, heading_rad) = control.autopilot().reference();
        let (velocity_mps, heading_rad) = (velocity_mps.cast(), heading_rad.wide());
        Self {
            mode: Some(outputs.mode),
            flags: ControlFlags {
                switch_on: outputs.switch_on,
                engaged: control.is_engaged(),
                refused: control.is_refused(),
                pilot_lost: control.pilot_is_lost(),
                descends: control.descends(),
                outside_geofence: control.is_outside_geofence(),
                at_end: control.is_at_end(),
                excited: control.autopilot().is_excited(),
            },
            failed_checks: outputs.readiness.failed_bits(),
            asked_velocity_mps: outputs.mode.holds_velocity().then_some(velocity_mps),
            asked_heading_rad: (outputs.mode != Mode::Manual).then_some(heading_rad),
            ..self
        }
    }

    /// Whether a flag or the mode differs from `other`.
    #[must_use]
    pub fn differs_from(&self, other: &Self) -> bool {
        (self.mode, self.flags, self.failed_checks)
            != (other.mode, other.flags, other.failed_checks)
    }

    /// Layout of a supplement: packs or unpacks all fields in their order. `None` for an unknown code of the mode.
    pub(super) fn walk(&mut self, codec: &mut Codec<'_>, header: &mut [u8; 2]) -> Option<()> {
        codec.bytes(header);
        let known = |mode| Mode::ALL.iter().position(|own| *own == mode);
        let code = self.mode.and_then(known).map_or(NO_AUTOPILOT, |code| code as u8);
        let mut codes = [code, self.flags.bits()];
        codec.bytes(&mut codes);
        let [code, flags] = codes;
        self.mode = match code {
            NO_AUTOPILOT => None,
            code => Some(*Mode::ALL.get(usize::from(code))?),
        };
        self.flags = ControlFlags::from_bits(flags);
        codec.time(&mut self.time);
        let mut checks = self.failed_checks.to_le_bytes();
        codec.bytes(&mut checks);
        self.failed_checks = u16::from_le_bytes(checks);
        codec.scaled::<u16>(&mut self.aux_ms, WIDTH_MS);
        codec.vector::<i16, _>(&mut self.asked_velocity_mps, VELOCITY_MPS);
        codec.scaled::<i16>(&mut self.asked_heading_rad, ANGLE_RAD);
        codec.vector::<i16, _>(&mut self.gyro_bias_radps, GYRO_BIAS_RADPS);
        codec.vector::<i16, _>(&mut self.accel_bias_mps2, ACCEL_BIAS_MPS2);
        codec.vector::<u16, _>(&mut self.gyro_bias_sigma_radps, GYRO_BIAS_RADPS);
        codec.vector::<u16, _>(&mut self.accel_bias_sigma_mps2, ACCEL_BIAS_MPS2);
        codec.scaled::<u16>(&mut self.geofence_share, SHARE);
        Some(())
    }
}
