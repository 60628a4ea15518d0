//! Forces, moments and flapping, written once for plain and for differentiating numbers.

use super::Helicopter;
use super::parameters::{Fin, HelicopterParameters, Rotor};
use crate::real::Real;

/// What the forces depend on, all in body axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion<T> {
    pub velocity: [T; 3],
    pub wind: [T; 3],
    /// The unit vector down.
    pub down: [T; 3],
    pub rate: [T; 3],
    /// Longitudinal, lateral.
    pub flapping: [T; 2],
    pub bar: [T; 2],
}

/// How it changes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change<T> {
    pub velocity: [T; 3],
    pub rate: [T; 3],
    pub flapping: [T; 2],
    pub bar: [T; 2],
    pub specific_force: [T; 3],
}

/// Where the controls stand with all sticks at zero.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Rigging {
    pub collective_rad: f64,
    pub tail_pitch_rad: f64,
    pub longitudinal_rad: f64,
    pub lateral_rad: f64,
}

/// One rotor's constants: thrust is `coefficient · scale_n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Disc {
    /// aσ/2.
    slope: f64,
    /// ρA(ΩR)², N.
    scale_n: f64,
    tip_speed_mps: f64,
    per_tip_speed: f64,
    /// ρA(ΩR)²R, N·m.
    torque_scale_nm: f64,
    /// σ Cd0/8.
    profile_torque: f64,
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
    /// The branch is the rotor that thrusts against its own inflow. It continues into a steep
    /// descent, where momentum theory has no answer, without a jump.
    ///
    /// # Source
    /// Equation (V4) of docs/equations.md.
    fn axial_inflow<T: Real>(&self, pitch: T, climb: T) -> T {
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

    /// Inflow ratio in any flow, from Glauert's balance 2(x − m)√(μ² + x²) = slope·(pitch − x/2), by
    /// Newton's rule from the axial solution; exact in axial flow.
    ///
    /// # Source
    /// Equation (V3) of docs/equations.md.
    fn inflow<T: Real>(&self, pitch: T, climb: T, advance_squared: T) -> T {
        let k = self.slope;
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

/// Enough for rounding up to 20 m/s: Newton's rule doubles the digits, and the axial start is good.
const NEWTON_STEPS: usize = 4;

/// What the parameters come to, worked out once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Constants {
    main: Disc,
    tail: Disc,
    per_flapping_time: f64,
    flapping_coupling: f64,
    per_bar_time: f64,
    per_mass: f64,
    per_inertia: [f64; 3],
}

impl Constants {
    pub fn new(parameters: &HelicopterParameters) -> Self {
        Self {
            main: Disc::new(&parameters.main_rotor, parameters.air_density_kgpm3),
            tail: Disc::new(&parameters.tail_rotor, parameters.air_density_kgpm3),
            per_flapping_time: 1.0 / parameters.flapping_time_constant_s(),
            flapping_coupling: parameters.flapping_coupling(),
            per_bar_time: 1.0 / parameters.bar.time_constant_s,
            per_mass: 1.0 / parameters.mass_kg,
            per_inertia: parameters.inertia_kgm2.map(|inertia| 1.0 / inertia),
        }
    }
}

impl Helicopter {
    /// The equations of motion; `sticks` are lateral, longitudinal, collective, pedal, held at their
    /// stops.
    pub(super) fn change<T: Real>(&self, motion: &Motion<T>, sticks: &[T; 4]) -> Change<T> {
        self.unstopped(motion, &sticks.map(|stick| stick.clamp(-1.0, 1.0)))
    }

    /// The equations of motion with sticks that go as far as they are asked to.
    ///
    /// # Source
    /// Equations (V1), (V2), (V5), (V6), (V7), (V8) and (V10) of docs/equations.md.
    pub(super) fn unstopped<T: Real>(&self, motion: &Motion<T>, sticks: &[T; 4]) -> Change<T> {
        let (par, con, rigging) = (&self.parameters, &self.constants, &self.rigging);
        let [lateral, longitudinal, collective, pedal] = *sticks;
        let [u, v, w] = motion.velocity;
        let [p, q, r] = motion.rate;
        let [a, b] = motion.flapping;
        let [c, d] = motion.bar;
        let (ua, va, wa) = (u - motion.wind[0], v - motion.wind[1], w - motion.wind[2]);

        let main = &con.main;
        let pitch = collective * par.collective_rad + rigging.collective_rad;
        let advance_squared = (ua * ua + va * va) * (main.per_tip_speed * main.per_tip_speed);
        let effective_pitch = pitch * (advance_squared * 0.5 + 1.0 / 3.0);
        let climb = wa * -main.per_tip_speed;
        let inflow = main.inflow(effective_pitch, climb, advance_squared);
        let coefficient = (effective_pitch - inflow * 0.5) * main.slope;
        let thrust = coefficient * main.scale_n;
        let torque = (coefficient * inflow
            + (advance_squared * (7.0 / 3.0) + 1.0) * main.profile_torque)
            * main.torque_scale_nm;

        let tail_speed = va - r * par.tail_arm_m + p * par.tail_height_m;
        let [lowest, highest] = par.tail_pitch_limits_rad;
        let tail_pitch = ((pedal * par.pedal_rate_radps - r) * par.gyro_gain_s
            + rigging.tail_pitch_rad)
            .clamp(lowest, highest)
            * (1.0 / 3.0);
        let tail_climb = tail_speed * -con.tail.per_tip_speed;
        let tail_inflow = con.tail.axial_inflow(tail_pitch, tail_climb);
        let tail_thrust = (tail_pitch - tail_inflow * 0.5) * (con.tail.slope * con.tail.scale_n);

        let half_density = 0.5 * par.air_density_kgpm3;
        let wake = wa - (inflow - climb) * main.tip_speed_mps;
        let pressure = (ua * ua + va * va + wake * wake).sqrt() * -half_density;
        let [front, side, top] = par.fuselage_area_m2;
        let beside = va - r * par.vertical_fin.arm_m;
        let fin_y = fin_force(&par.vertical_fin, half_density, ua, beside);
        let below = wa + q * par.horizontal_fin.arm_m;
        let fin_z = fin_force(&par.horizontal_fin, half_density, ua, below);

        let specific_force = [
            (pressure * ua * front - thrust * a) * con.per_mass,
            (pressure * va * side + thrust * b - tail_thrust + fin_y) * con.per_mass,
            (pressure * wake * top - thrust + fin_z) * con.per_mass,
        ];
        let tilt_moment = thrust * par.hub_height_m + par.hub_stiffness_nmprad;
        let moment = [
            tilt_moment * b - tail_thrust * par.tail_height_m,
            tilt_moment * a + fin_z * par.horizontal_fin.arm_m,
            tail_thrust * par.tail_arm_m - torque - fin_y * par.vertical_fin.arm_m,
        ];

        let [ixx, iyy, izz] = par.inertia_kgm2;
        let [gravity_x, gravity_y, gravity_z] = motion.down.map(|down| down * par.gravity_mps2);
        let flap_back = (pitch * (4.0 / 3.0) - inflow) * (2.0 * par.flap_back * main.per_tip_speed);
        let longitudinal_tilt = a * -1.0 - b * con.flapping_coupling
            + c * par.bar.longitudinal_gain
            + flap_back * ua
            + longitudinal * par.longitudinal_cyclic_rad
            + rigging.longitudinal_rad;
        let lateral_tilt = a * con.flapping_coupling - b + d * par.bar.lateral_gain
            - flap_back * va
            + lateral * par.lateral_cyclic_rad
            + rigging.lateral_rad;
        Change {
            velocity: [
                v * r - w * q + specific_force[0] + gravity_x,
                w * p - u * r + specific_force[1] + gravity_y,
                u * q - v * p + specific_force[2] + gravity_z,
            ],
            rate: [
                (moment[0] - q * r * (izz - iyy)) * con.per_inertia[0],
                (moment[1] - p * r * (ixx - izz)) * con.per_inertia[1],
                (moment[2] - p * q * (iyy - ixx)) * con.per_inertia[2],
            ],
            flapping: [
                longitudinal_tilt * con.per_flapping_time - q,
                lateral_tilt * con.per_flapping_time - p,
            ],
            bar: [
                (longitudinal * par.bar.longitudinal_tilt_rad - c) * con.per_bar_time - q,
                (lateral * par.bar.lateral_tilt_rad - d) * con.per_bar_time - p,
            ],
            specific_force,
        }
    }
}

/// Force of a surface against the flow across it: lift that grows with the flow along it, and drag.
fn fin_force<T: Real>(fin: &Fin, half_density: f64, along: T, across: T) -> T {
    (along.abs() * fin.lift_slope_per_rad + across.abs()) * across * (-half_density * fin.area_m2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn main_disc() -> Disc {
        let parameters = HelicopterParameters::raptor60();
        Disc::new(&parameters.main_rotor, parameters.air_density_kgpm3)
    }

    proptest! {
        #[test]
        fn blade_element_and_momentum_thrust_agree(
            pitch in 0.02..0.07_f64, climb in -0.02..0.05_f64, advance in 0.0..0.17_f64,
        ) {
            let disc = main_disc();
            let x = disc.inflow(pitch, climb, advance * advance);
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
        assert!((x - (0.5 * coefficient).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn inflow_has_no_jump_between_climb_and_descent() {
        let disc = main_disc();
        for advance in [0.0, 0.05, 0.15_f64] {
            let mut before: f64 = disc.inflow(0.0357, 0.06, advance * advance);
            for index in 1..=1000 {
                let climb = 0.06 - 1e-4 * f64::from(index);
                let x = disc.inflow(0.0357, climb, advance * advance);
                assert!((x - before).abs() < 2e-4, "{advance} {climb}: {x} after {before}");
                before = x;
            }
        }
    }
}
