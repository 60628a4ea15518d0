//! Trim: the state and controls of a steady flight.

use nalgebra::{SMatrix, SVector};

use super::dynamics::{Change, Constants, Drive, Motion, Rigging};
use super::{Helicopter, HelicopterError, HelicopterParameters, HelicopterState};
use crate::real::{Dual, Real};
use hovernav::controls::Sticks;
use hovernav::frames::{EulerAngles, Ned, Rotation, Vector};

/// Steady flight: a state and controls with which only the position changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trim {
    /// The state.
    pub state: HelicopterState,
    /// The controls.
    pub controls: Sticks,
}

/// Unknowns of a trim: roll, pitch, the two flapping angles, the two bar angles, then the four sticks.
type Unknowns = SVector<f64, 10>;

/// Largest number of iterations, of Newton's method and of the rigging.
const MAX_STEPS: usize = 50;
/// Norm of the derivatives below which a flight counts as steady, m/s² and rad/s².
const STEADY: f64 = 1e-10;

impl Helicopter {
    /// A helicopter with these parameters, rigged to hover with all sticks at zero.
    ///
    /// # Errors
    /// [`HelicopterError::Parameter`] for a value out of its physical range, and [`HelicopterError::NoTrim`] where the
    /// rotors are too small for the weight.
    pub fn new(parameters: HelicopterParameters) -> Result<Self, HelicopterError> {
        if let Some((name, value)) = parameters.out_of_range() {
            return Err(HelicopterError::Parameter { name, value });
        }
        let mut helicopter = Self {
            parameters,
            constants: Constants::new(&parameters),
            rigging: Rigging {
                collective_rad: 0.1,
                tail_pitch_rad: 0.1,
                longitudinal_rad: 0.0,
                lateral_rad: 0.0,
            },
            hover: HelicopterState::LEVEL,
            hover_sticks: Sticks::NEUTRAL,
            stuck_tail_rad: None,
        };
        // The sticks of each trim are added to the rigging until they are zero.
        for _ in 0..MAX_STEPS {
            let (trim, sticks) = helicopter.steady(Vector::ZERO, Vector::ZERO, 0.0)?;
            helicopter.hover = trim;
            let [lateral, longitudinal, collective, pedal] = sticks;
            let bar = &parameters.bar;
            let rigging = &mut helicopter.rigging;
            rigging.collective_rad += collective * parameters.collective_rad;
            rigging.tail_pitch_rad += pedal * parameters.pedal_rate_radps * parameters.gyro_gain_s;
            rigging.longitudinal_rad += longitudinal
                * (parameters.longitudinal_cyclic_rad
                    + bar.longitudinal_gain * bar.longitudinal_tilt_rad);
            rigging.lateral_rad +=
                lateral * (parameters.lateral_cyclic_rad + bar.lateral_gain * bar.lateral_tilt_rad);
            if sticks.iter().all(|stick| stick.abs() < 1e-14) {
                break;
            }
        }
        helicopter.hover.longitudinal_bar_rad = 0.0;
        helicopter.hover.lateral_bar_rad = 0.0;
        Ok(helicopter)
    }

    /// A helicopter with `parameters` and the rigging of this one, for example heavier or lighter. Its hover needs
    /// sticks other than zero.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_parameters(
        &self,
        parameters: HelicopterParameters,
    ) -> Result<Self, HelicopterError> {
        if let Some((name, value)) = parameters.out_of_range() {
            return Err(HelicopterError::Parameter { name, value });
        }
        let constants = Constants::new(&parameters);
        let mut other = Self { parameters, constants, stuck_tail_rad: None, ..self.clone() };
        let (hover, sticks) = other.steady(Vector::ZERO, Vector::ZERO, 0.0)?;
        other.stuck_tail_rad = self.stuck_tail_rad;
        (other.hover, other.hover_sticks) = (hover, Sticks::from_array(sticks));
        Ok(other)
    }

    /// Steady straight flight over the ground at `velocity_mps` in the steady wind `wind_mps`, with the heading
    /// `yaw_rad`.
    ///
    /// # Errors
    /// [`HelicopterError::NoTrim`] where no trim exists, [`HelicopterError::ControlAtStop`] where a control would have
    /// to exceed its stop.
    pub fn trim(
        &self,
        velocity_mps: Vector<Ned>,
        wind_mps: Vector<Ned>,
        yaw_rad: f64,
    ) -> Result<Trim, HelicopterError> {
        let (state, sticks) = self.steady(velocity_mps, wind_mps, yaw_rad)?;
        let names = Sticks::NAMES;
        if let Some((control, value)) =
            names.into_iter().zip(sticks).find(|(_, value)| value.abs() > 1.0)
        {
            return Err(HelicopterError::ControlAtStop { control, value });
        }
        Ok(Trim { state, controls: Sticks::from_array(sticks) })
    }

    /// Newton's method on the ten derivatives that are zero in steady flight. The sticks found may exceed their stops.
    ///
    /// # Source
    /// Equation (V13) of docs/equations.md.
    fn steady(
        &self,
        velocity_mps: Vector<Ned>,
        wind_mps: Vector<Ned>,
        yaw_rad: f64,
    ) -> Result<(HelicopterState, [f64; 4]), HelicopterError> {
        let mut unknowns = Unknowns::zeros();
        let mut residual = f64::INFINITY;
        for _ in 0..MAX_STEPS {
            let mut jacobian = SMatrix::<f64, 10, 10>::zeros();
            let mut remaining = Unknowns::zeros();
            for column in 0..10 {
                let mut dual = [Dual::constant(0.0); 10];
                for (dual, &value) in dual.iter_mut().zip(&unknowns) {
                    dual.value = value;
                }
                dual[column].slope = 1.0;
                let along = self.steady_change(&dual, velocity_mps, wind_mps, yaw_rad);
                for (row, change) in along.iter().enumerate() {
                    jacobian[(row, column)] = change.slope;
                    remaining[row] = change.value;
                }
            }
            // A norm propagates a NaN; a maximum over the elements would not.
            residual = remaining.norm();
            if residual < STEADY {
                return Ok((
                    steady_state(&unknowns, velocity_mps, yaw_rad),
                    [unknowns[6], unknowns[7], unknowns[8], unknowns[9]],
                ));
            }
            let Some(step) = jacobian.lu().solve(&remaining) else { break };
            // The step is limited to half a radian or half a stick, because the tangent is inaccurate beyond.
            let longest = step.norm();
            if !longest.is_finite() {
                break;
            }
            unknowns -= step * (0.5 / longest).min(1.0);
        }
        let [north_mps, east_mps, down_mps] = (velocity_mps - wind_mps).to_array();
        Err(HelicopterError::NoTrim { north_mps, east_mps, down_mps, residual })
    }

    fn steady_change(
        &self,
        unknowns: &[Dual; 10],
        velocity_mps: Vector<Ned>,
        wind_mps: Vector<Ned>,
        yaw_rad: f64,
    ) -> [Dual; 10] {
        let zero = Dual::constant(0.0);
        let [roll, pitch, a, b, c, d, lateral, longitudinal, collective, pedal] = *unknowns;
        let axes = body_axes([roll, pitch, Dual::constant(yaw_rad)]);
        let motion = Motion {
            velocity: in_body(&axes, velocity_mps),
            wind: in_body(&axes, wind_mps),
            down: axes.map(|axis| axis[2]),
            rate: [zero; 3],
            flapping: [a, b],
            bar: [c, d],
            drive: Drive::nominal(),
        };
        let sticks = [lateral, longitudinal, collective, pedal];
        let Change { velocity, rate, flapping, bar, .. } = self.unstopped(&motion, &sticks);
        [
            velocity[0],
            velocity[1],
            velocity[2],
            rate[0],
            rate[1],
            rate[2],
            flapping[0],
            flapping[1],
            bar[0],
            bar[1],
        ]
    }
}

/// Body axes in north, east, down, one per row, for the 3-2-1 angles roll, pitch, yaw.
pub(super) fn body_axes<T: Real>([roll, pitch, yaw]: [T; 3]) -> [[T; 3]; 3] {
    let (sr, cr) = roll.sin_cos();
    let (sp, cp) = pitch.sin_cos();
    let (sy, cy) = yaw.sin_cos();
    [
        [cp * cy, cp * sy, -sp],
        [sr * sp * cy - cr * sy, sr * sp * sy + cr * cy, sr * cp],
        [cr * sp * cy + sr * sy, cr * sp * sy - sr * cy, cr * cp],
    ]
}

pub(super) fn in_body<T: Real>(axes: &[[T; 3]; 3], vector: Vector<Ned>) -> [T; 3] {
    let [north, east, down] = vector.to_array();
    axes.map(|axis| axis[0] * north + axis[1] * east + axis[2] * down)
}

fn steady_state(unknowns: &Unknowns, velocity_mps: Vector<Ned>, yaw_rad: f64) -> HelicopterState {
    let body_to_ned = Rotation::from_euler(EulerAngles {
        roll_rad: unknowns[0],
        pitch_rad: unknowns[1],
        yaw_rad,
    });
    HelicopterState {
        velocity_mps: body_to_ned.inverse() * velocity_mps,
        body_to_ned,
        longitudinal_flapping_rad: unknowns[2],
        lateral_flapping_rad: unknowns[3],
        longitudinal_bar_rad: unknowns[4],
        lateral_bar_rad: unknowns[5],
        ..HelicopterState::LEVEL
    }
}
