//! Variables and constants of the equations of motion, and the inflow of a rotor. They are generic over plain numbers
//! and numbers with a derivative.

use super::parameters::{HelicopterParameters, Rotor};
use crate::real::Real;

/// Variables on which the forces depend, all in body axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion<T> {
    pub velocity: [T; 3],
    pub wind: [T; 3],
    /// Unit vector of the vertical, pointing down.
    pub down: [T; 3],
    pub rate: [T; 3],
    /// Longitudinal and lateral flapping, rad.
    pub flapping: [T; 2],
    pub bar: [T; 2],
    pub drive: Drive<T>,
}

/// Drive of the rotors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drive<T> {
    /// Speed of the rotors divided by the nominal speed, above 0; the tail rotor is geared to the main rotor.
    pub speed: T,
    /// Whether an engine drives the rotors. If so, the reaction to its torque acts on the fuselage.
    pub powered: bool,
}

impl<T: Real> Drive<T> {
    /// Drive at the nominal speed, with engine power.
    pub fn nominal() -> Self {
        Self { speed: T::constant(1.0), powered: true }
    }
}

/// Rates of change.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change<T> {
    pub velocity: [T; 3],
    pub rate: [T; 3],
    pub flapping: [T; 2],
    pub bar: [T; 2],
    pub specific_force: [T; 3],
    /// Torque at the main shaft that keeps both rotors at constant speed, N·m.
    pub torque_nm: T,
}

/// Positions of the controls with all sticks at zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Rigging {
    pub collective_rad: f64,
    pub tail_pitch_rad: f64,
    pub longitudinal_rad: f64,
    pub lateral_rad: f64,
}

/// Constants of one rotor; its thrust is `coefficient · scale_n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Disc {
    /// Thrust slope aσ/2, with lift slope a and solidity σ.
    pub slope: f64,
    /// Thrust scale ρA(ΩR)², N.
    pub scale_n: f64,
    pub tip_speed_mps: f64,
    pub per_tip_speed: f64,
    /// Torque scale ρA(ΩR)²R, N·m.
    pub torque_scale_nm: f64,
    /// Profile torque coefficient σ Cd0/8.
    pub profile_torque: f64,
}

impl Disc {
    fn new(rotor: &Rotor, air_density_kgpm3: f64) -> Self {
        let tip_speed_mps = rotor.tip_speed_mps();
        let scale_n = air_density_kgpm3 * rotor.disc_area_m2() * tip_speed_mps * tip_speed_mps;
        Self {
            slope: 0.5 * rotor.lift_slope_per_rad * rotor.solidity(),
            scale_n,
            tip_speed_mps,
            per_tip_speed: 1.0 / tip_speed_mps,
            torque_scale_nm: scale_n * rotor.radius_m,
            profile_torque: rotor.solidity() * rotor.profile_drag / 8.0,
        }
    }

    /// Inflow ratio in axial flow, where the momentum balance 2(x − m)|x| = slope·(pitch − x/2) is a
    /// quadratic: `pitch` is θ/3, `climb` is m.
    ///
    /// The chosen root is that of a rotor whose thrust opposes its induced velocity. It is continuous up to a steep
    /// descent, where momentum theory is invalid.
    ///
    /// # Source
    /// Equation (V4) of docs/equations.md.
    pub fn axial_inflow<T: Real>(&self, pitch: T, climb: T) -> T {
        let k = self.slope;
        let reversed = (pitch - climb * 0.5).value() < 0.0;
        let (pitch, climb) = if reversed { (-pitch, -climb) } else { (pitch, climb) };
        let root = if pitch.value() > 0.0 {
            // 2x² + 2hx − k·pitch = 0, the root above zero.
            let h = climb * -1.0 + 0.25 * k;
            ((h * h + pitch * (2.0 * k)).sqrt() - h) * 0.5
        } else {
            // The rotor windmills: 2x² − 2hx + k·pitch = 0, the root below zero.
            let h = climb + 0.25 * k;
            (h - (h * h - pitch * (2.0 * k)).sqrt()) * 0.5
        };
        if reversed { -root } else { root }
    }

    /// Inflow ratio in any flow, from Glauert's balance 2(x − m)√(μ² + x²) = slope·(pitch − x/2). Newton's method
    /// starts at the axial solution, which is exact in axial flow.
    ///
    /// # Source
    /// Equation (V3) of docs/equations.md.
    pub fn inflow<T: Real>(&self, pitch: T, climb: T, advance_squared: T, hover: T) -> T {
        let k = self.slope;
        let disturbed = disturbed((climb / hover).value());
        if disturbed > 0.0 {
            return self.descent_inflow(pitch, climb, advance_squared, disturbed);
        }
        let mut x = self.axial_inflow(pitch, climb);
        if advance_squared.value() > 1e-12 {
            for _ in 0..NEWTON_STEPS {
                let through = (advance_squared + x * x).sqrt();
                let induced = x - climb;
                let excess = induced * through * 2.0 - (pitch - x * 0.5) * k;
                let slope = (through + induced * x / through) * 2.0 + 0.5 * k;
                x = x - excess / slope;
            }
        }
        x
    }
}

impl Disc {
    /// Inflow ratio in a steep descent, from a momentum balance with a turbulence term s²: 2(x − m)√(μ² + x² + s²) =
    /// slope·(pitch − x/2). The term s² is |C_T|/6 times `share`, the disturbance of the balance, 0 to 1.
    ///
    /// The flow through the disc reverses without a jump. Without the turbulence term it would jump, because the left
    /// side decreases where the flow through the disc vanishes. The root is found by bisection with a fixed number of
    /// steps.
    ///
    /// # Source
    /// The turbulence term is an assumption of this project; [`TURBULENT`] is its size. Equation (V19) of
    /// docs/equations.md.
    fn descent_inflow<T: Real>(&self, pitch: T, climb: T, advance_squared: T, share: f64) -> T {
        const HALVINGS: usize = 50;
        let k = self.slope;
        let excess = |x: f64| {
            let coefficient = k * (pitch.value() - 0.5 * x);
            let carried = TURBULENT * share * 0.5 * coefficient.abs();
            let through = libm::sqrt(advance_squared.value() + x * x + carried);
            2.0 * (x - climb.value()) * through - coefficient
        };
        let (mut low, mut high) = (-1.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if excess(middle) < 0.0 { low = middle } else { high = middle }
        }
        // One Newton step adds the derivative of the root.
        let x = T::constant(0.5 * (low + high));
        let coefficient = (pitch - x * 0.5) * k;
        let through =
            (advance_squared + x * x + coefficient.abs() * (0.5 * TURBULENT * share)).sqrt();
        let balance = (x - climb) * through * 2.0 - coefficient;
        let reach = 1e-7;
        let at = x.value();
        let slope = (excess(at + reach) - excess(at - reach)) / (2.0 * reach);
        x - balance * (1.0 / slope)
    }
}

/// Descent rates, in units of the hover inflow, at which recirculation of the wake through the disc starts and is
/// complete.
const DISTURBED: [f64; 2] = [0.5, 1.5];
/// Size of the turbulence term in a steep descent, relative to |C_T|/2, the squared hover inflow. One third gives a
/// vertical autorotation at about 1.8 times the induced velocity of hover.
///
/// # Source
/// Leishman, *Principles of Helicopter Aerodynamics* (2006), equations 12.7 to 12.11, after Harris (2003). The force on
/// an autorotating rotor is 1.25 times its disc area times the dynamic pressure of the descent. The rotor therefore
/// sinks at 2/√1.25 = 1.79 induced velocities.
const TURBULENT: f64 = 1.0 / 3.0;

/// Degree to which a descent disturbs the momentum balance, 0 to 1. `climb` is the climb rate in units of the hover
/// inflow, negative in a descent.
fn disturbed(climb: f64) -> f64 {
    let [from, to] = DISTURBED;
    let part = ((-climb - from) / (to - from)).clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}

/// Number of steps of Newton's method: enough for rounding accuracy up to 20 m/s, because the axial start is close.
const NEWTON_STEPS: usize = 4;

/// Constants of the equations of motion, derived once from the parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Constants {
    pub main: Disc,
    pub tail: Disc,
    /// Inflow ratio of the main rotor in hover at its nominal speed.
    pub hover_inflow: f64,
    /// Speed of the tail rotor divided by that of the main rotor.
    pub tail_gear: f64,
    pub per_flapping_time: f64,
    pub flapping_coupling: f64,
    pub per_bar_time: f64,
    pub per_mass: f64,
    pub per_inertia: [f64; 3],
}

impl Constants {
    pub fn new(parameters: &HelicopterParameters) -> Self {
        let main = Disc::new(&parameters.main_rotor, parameters.air_density_kgpm3);
        let weight_n = parameters.mass_kg * parameters.gravity_mps2;
        Self {
            main,
            tail: Disc::new(&parameters.tail_rotor, parameters.air_density_kgpm3),
            hover_inflow: libm::sqrt(0.5 * weight_n / main.scale_n),
            tail_gear: parameters.tail_rotor.speed_radps / parameters.main_rotor.speed_radps,
            per_flapping_time: 1.0 / parameters.flapping_time_constant_s(),
            flapping_coupling: parameters.flapping_coupling(),
            per_bar_time: 1.0 / parameters.bar.time_constant_s,
            per_mass: 1.0 / parameters.mass_kg,
            per_inertia: parameters.inertia_kgm2.map(|inertia| 1.0 / inertia),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    fn main_disc() -> Disc {
        let parameters = HelicopterParameters::raptor60();
        Disc::new(&parameters.main_rotor, parameters.air_density_kgpm3)
    }

    proptest! {
        #[test]
        fn blade_element_and_momentum_thrust_agree(
            pitch in 0.02..0.07_f64, climb in -0.017..0.05_f64, advance in 0.0..0.17_f64,
        ) {
            let disc = main_disc();
            let x = disc.inflow(pitch, climb, advance * advance, 0.0355);
            let momentum = 2.0 * (x - climb) * (advance * advance + x * x).sqrt();
            prop_assert!((momentum - disc.slope * (pitch - 0.5 * x)).abs() < 1e-13);
        }

        #[test]
        fn a_rotor_turned_upside_down_thrusts_the_other_way(
            pitch in -0.07..0.07_f64, climb in -0.05..0.05_f64,
        ) {
            let disc = main_disc();
            let (up, down) = (disc.axial_inflow(pitch, climb), disc.axial_inflow(-pitch, -climb));
            prop_assert!((up + down).abs() < 1e-15);
        }
    }

    #[test]
    fn hover_inflow_is_that_of_momentum_theory() {
        let disc = main_disc();
        let x: f64 = disc.axial_inflow(0.0357, 0.0);
        let coefficient = disc.slope * (0.0357 - 0.5 * x);
        assert_abs_diff_eq!(x, (0.5 * coefficient).sqrt(), epsilon = 1e-15);
    }

    #[test]
    fn inflow_has_no_jump_between_climb_and_descent() {
        let disc = main_disc();
        for advance in [0.0, 0.05, 0.15_f64] {
            let mut before: f64 = disc.inflow(0.0357, 0.06, advance * advance, 0.0355);
            for index in 1..=1000 {
                let climb = 0.06 - 1e-4 * f64::from(index);
                let x = disc.inflow(0.0357, climb, advance * advance, 0.0355);
                assert!((x - before).abs() < 2e-4, "{advance} {climb}: {x} after {before}");
                before = x;
            }
        }
    }
}
