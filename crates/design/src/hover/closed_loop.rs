//! The closed loops, for the margins at each actuator.

use nalgebra::DMatrix;

use super::config::HoverDesign;
use super::estimator::late;
use super::plant::{places, stepped};
use crate::disturbance::FreeResponse;
use crate::{DISTURBED, DesignError, DisturbanceResponse, Loop};
use hovernav::autopilot::{Gains, GuidanceConfig, PidGains, RegulatorGains};
use hovernav::earth::STANDARD_GRAVITY_MPS2;
use hovernav_model::linalg::exponential;
use hovernav_model::{LinearModel, Signal, StateSpace, TimeDomain};

/// The measured states, in the order of the loops' inputs.
const MEASURED: [&str; 9] = ["p", "q", "phi", "theta", "u", "v", "w", "r", "psi"];

/// Quantity that the autopilot holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlightMode {
    /// Velocity, heading and climb.
    Velocity,
    /// Position, by a commanded velocity towards it.
    Position,
    /// Attitude, heading and climb, for flight without GPS and for the descent that follows.
    Attitude,
}

impl FlightMode {
    /// All modes.
    pub const ALL: [Self; 3] = [Self::Velocity, Self::Position, Self::Attitude];

    /// Name in summaries.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Velocity => "velocity",
            Self::Position => "position",
            Self::Attitude => "attitude",
        }
    }
}

/// Plant and controller of a mode. The plant leads from sticks to measurements, the controller from measurements to
/// sticks.
pub(super) struct Parts {
    pub plant: StateSpace,
    pub controller: StateSpace,
}

/// Model, servos and one sample of delay, with the autopilot in `mode`.
pub(super) fn parts(
    design: &HoverDesign,
    whole: &StateSpace,
    gains: &Gains,
    mode: FlightMode,
) -> Result<Parts, DesignError> {
    let plant = plant(design, whole, mode)?;
    let controller = controller(design, whole.inputs(), gains, mode)?;
    Ok(Parts { plant, controller })
}

/// The model `whole` with the states that `mode` controls. Holding position adds the position error to the states.
pub(super) fn flown(whole: &StateSpace, mode: FlightMode) -> Result<StateSpace, DesignError> {
    match mode {
        FlightMode::Velocity => Ok(whole.clone()),
        FlightMode::Position => with_place(whole),
        FlightMode::Attitude => {
            let names = whole.states().iter().map(|state| state.name.as_str());
            let kept: Vec<&str> = names.filter(|name| !["u", "v"].contains(name)).collect();
            Ok(whole.subsystem(&kept, &hovernav::controls::Sticks::NAMES)?)
        }
    }
}

/// Model, servos, one sample of delay and the lag of the estimator, with the guidance of `mode`.
///
/// When attitude is held, the vehicle drifts freely: velocity is not part of the plant.
pub(super) fn plant(
    design: &HoverDesign,
    whole: &StateSpace,
    mode: FlightMode,
) -> Result<StateSpace, DesignError> {
    plant_behind(design, servos_s(design), whole, mode)
}

/// Time constants of the servos of `design`, in the order of the controls.
pub(super) fn servos_s(design: &HoverDesign) -> [f64; 4] {
    [design.servo_s, design.servo_s, design.servo_s, design.tail_servo_s]
}

/// As [`plant`], with servos of the time constants `servos_s`, s.
pub(super) fn plant_behind(
    design: &HoverDesign,
    servos_s: [f64; 4],
    whole: &StateSpace,
    mode: FlightMode,
) -> Result<StateSpace, DesignError> {
    let time = TimeDomain::Discrete { period_s: design.period_s };
    let sticks = whole.inputs().to_vec();
    let flown = flown(whole, mode)?;
    let LinearModel { a: step, b: input, .. } = stepped(&flown, &servos_s, design.period_s)?;
    let moving = step.nrows();
    // Guidance: a commanded velocity and acceleration for each axis.
    let guided = if mode == FlightMode::Position { 6 } else { 0 };
    let size = moving + 4 + guided;
    let mut a = DMatrix::zeros(size, size);
    a.view_mut((0, 0), (moving, moving)).copy_from(&step);
    a.view_mut((0, moving), (moving, 4)).copy_from(&input);
    let mut b = DMatrix::zeros(size, 4);
    b.view_mut((moving, 0), (4, 4)).fill_with_identity();
    let mut c = DMatrix::zeros(MEASURED.len(), size);
    for (row, name) in MEASURED.into_iter().enumerate() {
        if let Ok(state) = flown.state(name) {
            c[(row, state)] = 1.0;
        }
    }
    if mode == FlightMode::Position {
        let guidance = &design.guidance;
        let towards = [
            guidance.position_gain_per_s,
            guidance.position_gain_per_s,
            guidance.height_gain_per_s,
        ];
        let period_s = design.period_s;
        let rate = GuidanceConfig::follows_per_s(period_s);
        for (axis, gain_per_s) in towards.into_iter().enumerate() {
            let place = whole.states().len() + axis;
            let velocity = moving + 4 + 2 * axis;
            let acceleration = velocity + 1;
            // For a position error x the target velocity is −k x; the commanded velocity follows it.
            a[(acceleration, place)] = -period_s * rate * rate * gain_per_s;
            a[(acceleration, velocity)] = -period_s * rate * rate;
            a[(acceleration, acceleration)] = 1.0 - 2.0 * rate * period_s;
            a[(velocity, velocity)] = 1.0;
            for state in [place, velocity, acceleration] {
                a[(velocity, state)] += period_s * a[(acceleration, state)];
                // The loops receive the velocity minus the commanded velocity, and the tilt minus that of the commanded
                // acceleration.
                c[(4 + axis, state)] = -a[(velocity, state)];
                let tilt = a[(acceleration, state)] / STANDARD_GRAVITY_MPS2;
                match axis {
                    0 => c[(3, state)] += tilt,
                    1 => c[(2, state)] -= tilt,
                    _ => {}
                }
            }
        }
    }
    let plant = StateSpace::new("plant", time, numbered(size), sticks, a, b)?;
    let plant = plant.with_outputs(measured(), c, DMatrix::zeros(MEASURED.len(), 4))?;
    late(plant, design.estimator.and(design.notch_s), design.period_s)
}

/// The autopilot in `mode`, from the measurements to `sticks`.
pub(super) fn controller(
    design: &HoverDesign,
    sticks: &[Signal],
    gains: &Gains,
    mode: FlightMode,
) -> Result<StateSpace, DesignError> {
    let time = TimeDomain::Discrete { period_s: design.period_s };
    let cyclic = match mode {
        FlightMode::Attitude => regulator(&gains.attitude, design.period_s),
        _ => regulator(&gains.roll_pitch, design.period_s),
    };
    let LinearModel { a, b, mut c, mut d, .. } = together(
        time,
        &[
            (cyclic, 0),
            (pid(&gains.heave, design.period_s), 6),
            (regulator(&gains.yaw, design.period_s), 7),
        ],
    );
    for sticks in [&mut c, &mut d] {
        let pedal = sticks.row(3) + sticks.row(2) * gains.pedal_per_collective;
        sticks.set_row(3, &pedal);
    }
    // A loop has the sign convention u = −(controller) y.
    Ok(StateSpace::new("autopilot", time, numbered(a.nrows()), measured(), a, b)?.with_outputs(
        sticks.to_vec(),
        -c,
        -d,
    )?)
}

fn measured() -> Vec<Signal> {
    MEASURED.map(|name| Signal::new(name, "SI")).to_vec()
}

fn numbered(count: usize) -> Vec<Signal> {
    (0..count).map(|k| Signal::new(&format!("x{k}"), "")).collect()
}

/// Point at which the loops are broken for their margins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cut {
    /// Commands to the actuators: lateral, longitudinal, collective, pedal.
    Actuators,
    /// Measurements: p, q, phi, theta, u, v, w, r, psi.
    Outputs,
}

/// `whole` with the position error in the axes of the heading as additional states: the integrals of u, v and w.
fn with_place(whole: &StateSpace) -> Result<StateSpace, DesignError> {
    let n = whole.states().len();
    let mut a = whole.a().clone().resize(n + 3, n + 3, 0.0);
    for (axis, state) in places(whole, ["u", "v", "w"])?.into_iter().enumerate() {
        a[(n + axis, state)] = 1.0;
    }
    let b = whole.b().clone().resize_vertically(n + 3, 0.0);
    let mut states = whole.states().to_vec();
    states.extend(["x", "y", "z"].map(|name| Signal::new(name, "m")));
    Ok(StateSpace::new(whole.name(), whole.time(), states, whole.inputs().to_vec(), a, b)?)
}

/// Response to an initial value `size` of `state`, with all other states at trim. The loops that hold velocity are
/// closed.
pub(super) fn respond(
    design: &HoverDesign,
    whole: &StateSpace,
    gains: &Gains,
    (state, size): (&str, f64),
    duration_s: f64,
) -> Result<DisturbanceResponse, DesignError> {
    let Parts { plant, controller } = parts(design, whole, gains, FlightMode::Velocity)?;
    let cut = Loop::at_plant_input(&plant, &controller)?;
    let open = cut.open();
    // The plant has no direct feedthrough: it moves only through its servos.
    let sticks = -open.c();
    let step = open.a() + open.b() * &sticks;
    let states = places(whole, DISTURBED)?;
    let response =
        FreeResponse { step: &step, interval_s: design.period_s, states, sticks: &sticks };
    response.respond(state, size, duration_s)
}

/// Response to an initial value `size` of `state`, with all other states and every stick at trim.
pub(super) fn drift(
    whole: &StateSpace,
    period_s: f64,
    (state, size): (&str, f64),
    duration_s: f64,
) -> Result<DisturbanceResponse, DesignError> {
    let step = exponential(whole.a(), period_s);
    let sticks = DMatrix::zeros(4, whole.states().len());
    let states = places(whole, DISTURBED)?;
    let response = FreeResponse { step: &step, interval_s: period_s, states, sticks: &sticks };
    response.respond(state, size, duration_s)
}

/// Parallel connection of controllers, each with the index of its first measurement.
fn together(time: TimeDomain, parts: &[(LinearModel, usize)]) -> LinearModel {
    let states = parts.iter().map(|(part, _)| part.a.nrows()).sum();
    let sticks = parts.iter().map(|(part, _)| part.c.nrows()).sum();
    let mut all = LinearModel {
        time,
        a: DMatrix::zeros(states, states),
        b: DMatrix::zeros(states, MEASURED.len()),
        c: DMatrix::zeros(sticks, states),
        d: DMatrix::zeros(sticks, MEASURED.len()),
    };
    let (mut state, mut stick) = (0, 0);
    for (part, measured) in parts {
        all.a.view_mut((state, state), part.a.shape()).copy_from(&part.a);
        all.b.view_mut((state, *measured), part.b.shape()).copy_from(&part.b);
        all.c.view_mut((stick, state), part.c.shape()).copy_from(&part.c);
        all.d.view_mut((stick, *measured), part.d.shape()).copy_from(&part.d);
        state += part.a.nrows();
        stick += part.c.nrows();
    }
    all
}

/// The regulator as a linear model. Its states are the hidden states in use, the pending commands and the integrals.
fn regulator<const Y: usize, const H: usize, const U: usize>(
    gains: &RegulatorGains<Y, H, U>,
    period_s: f64,
) -> LinearModel {
    let is_used = |h: usize| {
        gains.hidden_from_hidden[h].iter().any(|&gain| gain != 0.0)
            || gains.hidden_from_measured[h].iter().any(|&gain| gain != 0.0)
            || gains.hidden_from_pending[h].iter().any(|&gain| gain != 0.0)
    };
    let used = (0..H).rev().find(|&h| is_used(h)).map_or(0, |last| last + 1);
    let states = used + 2 * U;
    let mut c = DMatrix::zeros(U, states);
    let mut d = DMatrix::zeros(U, Y);
    for u in 0..U {
        for h in 0..used {
            c[(u, h)] = -gains.hidden[u][h];
        }
        for other in 0..U {
            c[(u, used + other)] = -gains.pending[u][other];
        }
        c[(u, used + U + u)] = 1.0;
        for y in 0..Y {
            d[(u, y)] = -gains.measured[u][y];
        }
    }
    let mut a = DMatrix::zeros(states, states);
    let mut b = DMatrix::zeros(states, Y);
    for h in 0..used {
        for other in 0..used {
            a[(h, other)] = gains.hidden_from_hidden[h][other];
        }
        for u in 0..U {
            a[(h, used + u)] = gains.hidden_from_pending[h][u];
        }
        for y in 0..Y {
            b[(h, y)] = gains.hidden_from_measured[h][y];
        }
    }
    a.view_mut((used, 0), (U, states)).copy_from(&c);
    b.view_mut((used, 0), (U, Y)).copy_from(&d);
    for u in 0..U {
        a[(used + U + u, used + U + u)] = 1.0;
        for y in 0..Y {
            b[(used + U + u, y)] = -gains.integral_per_s[u][y] * period_s;
        }
    }
    LinearModel { time: TimeDomain::Discrete { period_s }, a, b, c, d }
}

/// The PID controller as a linear model. Its state is the integral; with a derivative gain also the derivative's filter
/// and the previous measurement.
fn pid(gains: &PidGains, period_s: f64) -> LinearModel {
    let time = TimeDomain::Discrete { period_s };
    if gains.derivative_s == 0.0 {
        return LinearModel {
            time,
            a: DMatrix::identity(1, 1),
            b: DMatrix::from_element(1, 1, -gains.integral_per_s * period_s),
            c: DMatrix::identity(1, 1),
            d: DMatrix::from_element(1, 1, -gains.proportional),
        };
    }
    let per = 1.0 / (gains.derivative_filter_s + period_s);
    let keep = gains.derivative_filter_s * per;
    let slope = gains.derivative_s * per;
    LinearModel {
        time,
        a: DMatrix::from_row_slice(3, 3, &[1.0, 0.0, 0.0, 0.0, keep, slope, 0.0, 0.0, 0.0]),
        b: DMatrix::from_row_slice(3, 1, &[-gains.integral_per_s * period_s, -slope, 1.0]),
        c: DMatrix::from_row_slice(1, 3, &[1.0, keep, slope]),
        d: DMatrix::from_row_slice(1, 1, &[-gains.proportional - slope]),
    }
}
