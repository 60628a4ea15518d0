//! Forces, moments and flapping, generic over plain numbers and numbers with a derivative.

use super::Helicopter;
use super::dynamics::{Change, Drive, Motion};
use super::parameters::Fin;
use crate::real::Real;

impl Helicopter {
    /// The equations of motion; `sticks` are lateral, longitudinal, collective, pedal, limited at their stops.
    pub(super) fn change<T: Real>(&self, motion: &Motion<T>, sticks: &[T; 4]) -> Change<T> {
        self.unstopped(motion, &sticks.map(|stick| stick.clamp(-1.0, 1.0)))
    }

    /// Pitch of the tail blades under `pedal` at the yaw rate `r`, rad.
    pub(super) fn tail_pitch<T: Real>(&self, pedal: T, r: T) -> T {
        if let Some(stuck_rad) = self.stuck_tail_rad {
            return T::constant(stuck_rad);
        }
        let par = &self.parameters;
        let [lowest, highest] = par.tail_pitch_limits_rad;
        ((pedal * par.pedal_rate_radps - r) * par.gyro_gain_s + self.rigging.tail_pitch_rad)
            .clamp(lowest, highest)
    }

    /// The equations of motion without stick stops.
    ///
    /// # Source
    /// Equations (V1), (V2), (V5), (V6), (V7), (V8) and (V10) of docs/equations.md, with all tip speeds multiplied by
    /// the rotor's relative speed.
    pub(super) fn unstopped<T: Real>(&self, motion: &Motion<T>, sticks: &[T; 4]) -> Change<T> {
        let (par, con, rigging) = (&self.parameters, &self.constants, &self.rigging);
        let [lateral, longitudinal, collective, pedal] = *sticks;
        let [u, v, w] = motion.velocity;
        let [p, q, r] = motion.rate;
        let [a, b] = motion.flapping;
        let [c, d] = motion.bar;
        let (ua, va, wa) = (u - motion.wind[0], v - motion.wind[1], w - motion.wind[2]);

        let main = &con.main;
        let Drive { speed, powered } = motion.drive;
        let per_tip_speed = T::constant(main.per_tip_speed) / speed;
        let speed_squared = speed * speed;
        let pitch = collective * par.collective_rad + rigging.collective_rad;
        let advance_squared = (ua * ua + va * va) * (per_tip_speed * per_tip_speed);
        let effective_pitch = pitch * (advance_squared * 0.5 + 1.0 / 3.0);
        let climb = -wa * per_tip_speed;
        let hover = T::constant(con.hover_inflow) / speed;
        let inflow = main.inflow(effective_pitch, climb, advance_squared, hover);
        let coefficient = (effective_pitch - inflow * 0.5) * main.slope;
        let thrust = coefficient * speed_squared * main.scale_n;
        let torque = (coefficient * inflow
            + (advance_squared * (7.0 / 3.0) + 1.0) * main.profile_torque)
            * speed_squared
            * main.torque_scale_nm;

        let tail_speed = va - r * par.tail_arm_m + p * par.tail_height_m;
        let tail_pitch = self.tail_pitch(pedal, r) * (1.0 / 3.0);
        let tail_climb = -tail_speed * (T::constant(con.tail.per_tip_speed) / speed);
        let tail_inflow = con.tail.axial_inflow(tail_pitch, tail_climb);
        let tail_coefficient = tail_pitch - tail_inflow * 0.5;
        let tail_thrust = tail_coefficient * speed_squared * (con.tail.slope * con.tail.scale_n);
        let tail_torque = (tail_coefficient * tail_inflow * con.tail.slope
            + con.tail.profile_torque)
            * speed_squared
            * (con.tail.torque_scale_nm * con.tail_gear);
        // The reaction to the engine's torque on the main rotor acts on the fuselage. Without engine power the rotor
        // turns freely.
        let borne = if powered { torque } else { T::constant(0.0) };

        let half_density = 0.5 * par.air_density_kgpm3;
        let wake = wa - (inflow - climb) * speed * main.tip_speed_mps;
        let pressure = (ua * ua + va * va + wake * wake).sqrt() * -half_density;
        let [front, side, top] = par.fuselage_area_m2;
        let side_by_side = va - r * par.vertical_fin.arm_m;
        let fin_y = fin_force(&par.vertical_fin, half_density, ua, side_by_side);
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
            tail_thrust * par.tail_arm_m - borne - fin_y * par.vertical_fin.arm_m,
        ];

        let [ixx, iyy, izz] = par.inertia_kgm2;
        let [gravity_x, gravity_y, gravity_z] = motion.down.map(|down| down * par.gravity_mps2);
        let flap_back = (pitch * (4.0 / 3.0) - inflow) * (per_tip_speed * (2.0 * par.flap_back));
        let coupling = T::constant(con.flapping_coupling) / speed_squared;
        let longitudinal_tilt = a * -1.0 - b * coupling
            + c * par.bar.longitudinal_gain
            + flap_back * ua
            + longitudinal * par.longitudinal_cyclic_rad
            + rigging.longitudinal_rad;
        let lateral_tilt = a * coupling - b + d * par.bar.lateral_gain - flap_back * va
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
                longitudinal_tilt * speed * con.per_flapping_time - q,
                lateral_tilt * speed * con.per_flapping_time - p,
            ],
            bar: [
                (longitudinal * par.bar.longitudinal_tilt_rad - c) * con.per_bar_time - q,
                (lateral * par.bar.lateral_tilt_rad - d) * con.per_bar_time - p,
            ],
            specific_force,
            torque_nm: torque + tail_torque,
        }
    }
}

/// Force on a fin from the flow across it: lift, proportional to the flow along the fin, and drag.
fn fin_force<T: Real>(fin: &Fin, half_density: f64, along: T, across: T) -> T {
    (along.abs() * fin.lift_slope_per_rad + across.abs()) * across * (-half_density * fin.area_m2)
}
