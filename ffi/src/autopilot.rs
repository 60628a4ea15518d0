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

/// What the autopilot is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Mode {
    /// The pilot flies.
    Manual = 0,
    /// Holds or moves to a position, holds the heading.
    Position = 1,
    /// Holds a velocity over ground and the heading.
    Velocity = 2,
    /// Holds roll, pitch and heading, and if it can the height.
    Attitude = 3,
    /// The same, sinking at a set rate.
    Descent = 4,
    /// The sticks go to trim, as not even attitude is known.
    Neutral = 5,
}

/// Why the mode changed in this step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum ModeReason {
    /// It did not.
    Unchanged = 0,
    /// The pilot's switch.
    Switch = 1,
    /// The pilot moved a stick.
    Override = 2,
    /// The estimate is not good enough for the mode: see `distrust`.
    Distrust = 3,
    /// The estimate is good enough for a better mode again.
    Recovered = 4,
    /// Velocity did not come back within the configured time.
    Patience = 5,
    /// A reason that this header does not know.
    Other = 6,
}

/// What one step of the autopilot goes by.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct AutopilotInputs {
    /// The moment of the step, on the clock of the samples, ns.
    pub now_ns: i64,
    /// 1 if the pilot's sticks are received, else 0.
    pub has_pilot: u32,
    /// The pilot's switch: 1 if the autopilot shall fly, else 0.
    pub engage: u32,
    /// The pilot's sticks. Where one is not finite, all are taken for not received.
    pub pilot: Sticks,
}

/// The result of one step of the autopilot.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct AutopilotOutputs {
    /// Where the controls go, -1 to 1; while the pilot flies as far as the pilot's go, to 1.25.
    pub sticks: Sticks,
    /// What it is doing.
    pub mode: Mode,
    /// Why the mode changed in this step, if it did.
    pub reason: ModeReason,
    /// What was not good enough.
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
            Some(Reason::Patience) => (ModeReason::Patience, Distrust::None),
            Some(_) => (ModeReason::Other, Distrust::None),
        };
        Self { sticks: core.sticks.cast().into(), mode: mode(core.mode), reason, distrust: why }
    }
}

/// Starts an autopilot inside the object, or starts it anew; it has not taken over, the sticks at trim.
/// `fault`, unless null, receives which value of the configuration cannot be flown; what flew before then
/// goes on.
///
/// # Safety
/// Pointers as the crate's rules say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_start_autopilot(
    nav: *mut Hovernav,
    config: *const AutopilotConfig,
    fault: *mut Fault,
) -> Status {
    // SAFETY: the caller's promise.
    let nav = unsafe { object(nav) };
    // SAFETY: the caller's promise.
    let config = unsafe { input(config) };
    // SAFETY: the caller's promise.
    let fault = unsafe { optional(fault) };
    Status::of(nav.and_then(|nav| {
        let (config, fault) = (config?, fault?);
        let autopilot = HoverAutopilot::new(config.core().cast()).map_err(|error| {
            Status::refuse(Fault::new(&[error.what], error.found, error.expected), fault)
        })?;
        nav.flight.autopilot = Some(autopilot);
        nav.flight.stepless = SteplessSolution::default();
        Ok(())
    }))
}

/// One step of the autopilot: call it once every period of its configuration. It flies on the solution as it
/// stands less what measurements have just corrected, which is let in over about a second, so that no fix
/// moves a stick by a step. Each call is taken for one period, whatever `now_ns` says: gains designed for
/// another rate are other gains, and nothing here can tell. `now_ns` says how old the solution is, and how long
/// a mode has lasted.
///
/// # Safety
/// Pointers as the crate's rules say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_step_autopilot(
    nav: *mut Hovernav,
    inputs: *const AutopilotInputs,
    outputs: *mut AutopilotOutputs,
) -> Status {
    // SAFETY: the caller's promise.
    let nav = unsafe { object(nav) };
    // SAFETY: the caller's promise.
    let inputs = unsafe { input(inputs) };
    // SAFETY: the caller's promise.
    let place = unsafe { output(outputs) };
    Status::of(nav.and_then(|nav| {
        let (inputs, place) = (inputs?, place?);
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
        place.write(AutopilotOutputs::from(&stepped));
        Ok(())
    }))
}

/// In HovernavSetPoint.kind: stop, and stay where it stops.
pub const HOVERNAV_SET_POINT_HOLD: u32 = 0;
/// Go to a place and stay, the heading as it is.
pub const HOVERNAV_SET_POINT_PLACE: u32 = 1;
/// Go to a place and stay, and turn to a heading.
pub const HOVERNAV_SET_POINT_PLACE_AND_HEADING: u32 = 2;
/// Fly at a steady velocity.
pub const HOVERNAV_SET_POINT_VELOCITY: u32 = 3;

/// What the vehicle shall do; the kind says which fields count.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct SetPoint {
    /// One of HOVERNAV_SET_POINT_.
    pub kind: u32,
    /// Latitude, degrees.
    pub latitude_deg: f64,
    /// Longitude, degrees.
    pub longitude_deg: f64,
    /// Height above the ellipsoid, m.
    pub height_m: f64,
    /// Heading, rad, from true north clockwise.
    pub heading_rad: f64,
    /// Velocity forward of the heading, m/s.
    pub forward_mps: f64,
    /// Velocity right of the heading, m/s.
    pub right_mps: f64,
    /// Velocity downwards, m/s.
    pub down_mps: f64,
    /// Turn rate, right positive, rad/s.
    pub yaw_rate_radps: f64,
}

impl SetPoint {
    fn core(&self) -> Result<CoreSetPoint, Status> {
        let place = |heading_rad| {
            Geodetic::from_degrees(self.latitude_deg, self.longitude_deg, self.height_m)
                .map(|position| CoreSetPoint::Place { position, heading_rad })
                .ok_or(Status::SetPointRefused)
        };
        match self.kind {
            HOVERNAV_SET_POINT_HOLD => Ok(CoreSetPoint::Hold),
            HOVERNAV_SET_POINT_PLACE => place(None),
            HOVERNAV_SET_POINT_PLACE_AND_HEADING => place(Some(self.heading_rad)),
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

/// Says what the vehicle shall do from now on. Taking over resets it to HOVERNAV_SET_POINT_HOLD.
///
/// # Safety
/// Pointers as the crate's rules say.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_set(nav: *mut Hovernav, set_point: *const SetPoint) -> Status {
    // SAFETY: the caller's promise.
    let nav = unsafe { object(nav) };
    // SAFETY: the caller's promise.
    let set_point = unsafe { input(set_point) };
    Status::of(nav.and_then(|nav| {
        let set_point = set_point?.core()?;
        let autopilot = nav.flight.autopilot.as_mut().ok_or(Status::NoAutopilot)?;
        autopilot.set(set_point).map_err(|_| Status::SetPointRefused)
    }))
}
