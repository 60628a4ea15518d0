//! The hover autopilot.

use hovernav::autopilot::{
    HoverAutopilot, Inputs, Mode as CoreMode, Outputs, Reason, SetPoint as CoreSetPoint,
};
use hovernav::controls::Sticks as CoreSticks;
use hovernav::earth::Geodetic;
use hovernav::ekf::SteplessSolution;
use hovernav::scalar::Scalar;
use hovernav::time::Time;

use crate::access::{input, object, optional, output};
use crate::health::{Distrust, distrust};
use crate::object::{Flight, Hovernav};
use crate::settings::{AutopilotConfig, Sticks};
use crate::status::{Fault, Status};

/// Mode of the autopilot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Mode {
    /// The pilot flies.
    Manual = 0,
    /// Holds a position or flies to it, and holds the heading.
    Position = 1,
    /// Holds a velocity over ground, and the heading.
    Velocity = 2,
    /// Holds roll, pitch, heading and, if possible, height.
    Attitude = 3,
    /// As Attitude, but descends at the configured sink rate.
    Descent = 4,
    /// Moves the sticks to trim, because attitude is unknown.
    Neutral = 5,
}

/// Reason for the change of mode in this step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum ModeReason {
    /// The mode did not change.
    Unchanged = 0,
    /// The pilot's switch.
    Switch = 1,
    /// The pilot moved a stick.
    Override = 2,
    /// The estimate is not good enough for the mode: see `distrust`.
    Distrust = 3,
    /// The estimate is good enough for a better mode again.
    Recovered = 4,
    /// Velocity did not recover within the configured time.
    Patience = 5,
    /// A reason unknown to this header.
    Other = 6,
}

/// Inputs of one step of the autopilot.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct AutopilotInputs {
    /// Time of the step, ns, on the clock of the samples.
    pub now_ns: i64,
    /// 1 if the pilot's sticks are received, else 0.
    pub has_pilot: u32,
    /// The pilot's switch: 1 if the autopilot is to fly, else 0.
    pub engage: u32,
    /// The pilot's sticks. If one value is not finite, all four sticks count as not received.
    pub pilot: Sticks,
}

/// The result of one step of the autopilot.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct AutopilotOutputs {
    /// Positions of the controls, -1 to 1; while the pilot flies, up to the pilot's own deflection, at most 1.25.
    pub sticks: Sticks,
    /// The active mode.
    pub mode: Mode,
    /// Reason of the change of mode in this step, if it changed.
    pub reason: ModeReason,
    /// Reason why the estimate is not good enough.
    pub distrust: Distrust,
}

const fn mode(mode: CoreMode) -> Mode {
    match mode {
        CoreMode::Manual => Mode::Manual,
        CoreMode::Position => Mode::Position,
        CoreMode::Velocity => Mode::Velocity,
        CoreMode::Attitude => Mode::Attitude,
        CoreMode::Descent => Mode::Descent,
        CoreMode::Neutral => Mode::Neutral,
    }
}

impl<T: Scalar> From<&Outputs<T>> for AutopilotOutputs {
    fn from(core: &Outputs<T>) -> Self {
        let (reason, why) = match core.transition.map(|transition| transition.reason) {
            None => (ModeReason::Unchanged, Distrust::None),
            Some(Reason::Switch) => (ModeReason::Switch, Distrust::None),
            Some(Reason::Override) => (ModeReason::Override, Distrust::None),
            Some(Reason::Distrust(why)) => (ModeReason::Distrust, distrust(why)),
            Some(Reason::Recovered) => (ModeReason::Recovered, Distrust::None),
            Some(Reason::VelocityNotRecovered) => (ModeReason::Patience, Distrust::None),
            Some(_) => (ModeReason::Other, Distrust::None),
        };
        Self { sticks: core.sticks.cast().into(), mode: mode(core.mode), reason, distrust: why }
    }
}

/// Starts an autopilot inside the object, or restarts it, with the sticks at trim and not engaged. `fault`, unless
/// null, receives the first invalid value of the configuration. With an invalid configuration the previous autopilot
/// stays active.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_start_autopilot(
    nav: *mut Hovernav,
    config: *const AutopilotConfig,
    fault: *mut Fault,
) -> Status {
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: guaranteed by the caller.
    let config = unsafe { input(config) };
    // SAFETY: guaranteed by the caller.
    let fault = unsafe { optional(fault) };
    Status::of(nav.and_then(|nav| {
        let (config, fault) = (config?, fault?);
        let autopilot = HoverAutopilot::new(config.core().cast()).map_err(|error| {
            Status::reject(Fault::new(&[error.what], error.found, error.expected), fault)
        })?;
        nav.flight.autopilot = Some(autopilot);
        nav.flight.stepless = SteplessSolution::default();
        Ok(())
    }))
}

/// Runs one step of the autopilot. Call it once every period of its configuration. The autopilot uses the solution
/// without the latest corrections, which fade in over about a second. A fix therefore never causes a jump of a stick.
/// Each call counts as one period, independent of `now_ns`. A call at a rate other than the design rate of the gains is
/// an error that cannot be detected here. `now_ns` gives the age of the solution and the duration of a mode.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_step_autopilot(
    nav: *mut Hovernav,
    inputs: *const AutopilotInputs,
    outputs: *mut AutopilotOutputs,
) -> Status {
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: guaranteed by the caller.
    let inputs = unsafe { input(inputs) };
    // SAFETY: guaranteed by the caller.
    let slot = unsafe { output(outputs) };
    Status::of(nav.and_then(|nav| {
        let (inputs, slot) = (inputs?, slot?);
        if inputs.has_pilot > 1 || inputs.engage > 1 {
            return Err(Status::UnknownCode);
        }
        let Flight { estimator, stepless, autopilot, .. } = &mut nav.flight;
        let autopilot = autopilot.as_mut().ok_or(Status::NoAutopilot)?;
        let solution = estimator.solution().map(|own| stepless.solution(&own));
        let stepped = autopilot.step(&Inputs {
            now: Time::from_nanoseconds(inputs.now_ns),
            solution: solution.as_ref(),
            pilot: (inputs.has_pilot == 1).then(|| CoreSticks::from(inputs.pilot).cast()),
            engage: inputs.engage == 1,
        });
        slot.write(AutopilotOutputs::from(&stepped));
        Ok(())
    }))
}

/// In HovernavSetPoint.kind: stop, and hold the position where the vehicle stops.
pub const HOVERNAV_SET_POINT_HOLD: u32 = 0;
/// In HovernavSetPoint.kind: fly to a position and hold it, with the current heading.
pub const HOVERNAV_SET_POINT_PLACE: u32 = 1;
/// In HovernavSetPoint.kind: fly to a position and hold it, and turn to a heading.
pub const HOVERNAV_SET_POINT_PLACE_AND_HEADING: u32 = 2;
/// In HovernavSetPoint.kind: fly at a steady velocity.
pub const HOVERNAV_SET_POINT_VELOCITY: u32 = 3;

/// A set-point; the kind determines which fields count.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct SetPoint {
    /// Kind of the set-point: one of HOVERNAV_SET_POINT_.
    pub kind: u32,
    /// Latitude, degrees.
    pub latitude_deg: f64,
    /// Longitude, degrees.
    pub longitude_deg: f64,
    /// Height above the ellipsoid, m.
    pub height_m: f64,
    /// Heading, rad, clockwise from true north.
    pub heading_rad: f64,
    /// Velocity in the direction of the heading, m/s.
    pub forward_mps: f64,
    /// Velocity to the right of the heading, m/s.
    pub right_mps: f64,
    /// Velocity downwards, m/s.
    pub down_mps: f64,
    /// Turn rate, rad/s, positive to the right.
    pub yaw_rate_radps: f64,
}

impl SetPoint {
    fn core(&self) -> Result<CoreSetPoint, Status> {
        let hold_at = |heading_rad| {
            Geodetic::from_degrees(self.latitude_deg, self.longitude_deg, self.height_m)
                .map(|position| CoreSetPoint::Position { position, heading_rad })
                .ok_or(Status::SetPointRefused)
        };
        match self.kind {
            HOVERNAV_SET_POINT_HOLD => Ok(CoreSetPoint::Hold),
            HOVERNAV_SET_POINT_PLACE => hold_at(None),
            HOVERNAV_SET_POINT_PLACE_AND_HEADING => hold_at(Some(self.heading_rad)),
            HOVERNAV_SET_POINT_VELOCITY => Ok(CoreSetPoint::Velocity {
                forward_mps: self.forward_mps,
                right_mps: self.right_mps,
                down_mps: self.down_mps,
                yaw_rate_radps: self.yaw_rate_radps,
            }),
            _ => Err(Status::UnknownCode),
        }
    }
}

/// Sets the set-point. Engagement resets it to HOVERNAV_SET_POINT_HOLD.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_set(nav: *mut Hovernav, set_point: *const SetPoint) -> Status {
    // SAFETY: guaranteed by the caller.
    let nav = unsafe { object(nav) };
    // SAFETY: guaranteed by the caller.
    let set_point = unsafe { input(set_point) };
    Status::of(nav.and_then(|nav| {
        let set_point = set_point?.core()?;
        let autopilot = nav.flight.autopilot.as_mut().ok_or(Status::NoAutopilot)?;
        autopilot.set(set_point).map_err(|_| Status::SetPointRefused)
    }))
}
