//! Outputs of PX4's controllers to the mixer, and of the mixer to the motors.

use std::collections::HashMap;

use super::topics::Topic;
use crate::assembly::Assembly;
use hovernav::time::Time;

/// Largest number of motors that are mapped.
const MOTORS: usize = 8;

/// The state between rows.
#[derive(Debug, Default)]
pub(super) struct Inputs {
    /// Contributions of each motor to roll, pitch, throttle and yaw; empty without the geometry of the rotors.
    mixer: Vec<[f64; 4]>,
    /// The last thrust upwards; its topic is separate from that of the torques.
    thrust: f64,
}

impl Inputs {
    /// The mixer from the log's `parameters`.
    ///
    /// # Source
    /// PX4, `ActuatorEffectivenessRotors`: the moment of a rotor at (x, y) with thrust upwards and moment ratio k is
    /// (−y, x, k).
    pub fn of(parameters: &HashMap<String, f64>) -> Self {
        let count = parameters.get("CA_ROTOR_COUNT").map_or(0, |count| *count as usize);
        let of_rotor = |rotor: usize| {
            let own = |name: &str| parameters.get(&format!("CA_ROTOR{rotor}_{name}")).copied();
            Some([-own("PY")?, own("PX")?, 1.0, own("KM").unwrap_or(0.05)])
        };
        let mut mixer: Vec<[f64; 4]> = (0..count.min(MOTORS)).filter_map(of_rotor).collect();
        if mixer.len() != count || count < 3 {
            return Self::default();
        }
        for axis in 0..4 {
            // Full deflection of an axis means one motor at full thrust and its opposite at zero.
            let part = if axis == 2 { 1.0 } else { 0.5 };
            let total: f64 = mixer.iter().map(|shares| shares[axis].abs()).sum();
            let scale = if total > 0.0 { (part * total).recip() } else { 0.0 };
            mixer.iter_mut().for_each(|shares| shares[axis] *= scale);
        }
        Self { mixer, thrust: 0.0 }
    }

    /// Reads a row without its time.
    pub fn take(&mut self, topic: Topic, time: Time, row: &[f64], place: u64, to: &mut Assembly) {
        let &[x, y, z, fourth, ..] = row else { return };
        // PX4 counts nose up as positive, hovernav the forward stick. PX4's thrust is positive downwards.
        let inputs = match topic {
            Topic::Thrust => {
                self.thrust = -z;
                return;
            }
            Topic::Torque => [x, -y, self.thrust, z],
            Topic::RateControls => [x, -y, fourth, z],
            Topic::Motors => {
                let mut sums = [0.0; 4];
                for (shares, motor) in self.mixer.iter().zip(row) {
                    sums.iter_mut().zip(shares).for_each(|(sum, share)| *sum += share * motor);
                }
                let [roll, pitch, throttle, yaw] = sums;
                [roll, -pitch, throttle, yaw]
            }
            _ => return,
        };
        if topic != Topic::Motors || !self.mixer.is_empty() {
            to.controls(topic.name(), place, time, inputs);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_motors_of_a_quadcopter_give_back_its_torques_and_thrust() {
        let mut parameters = HashMap::from([("CA_ROTOR_COUNT".to_owned(), 4.0)]);
        let rotors = [(1.0, 1.0, 0.05), (-1.0, -1.0, 0.05), (1.0, -1.0, -0.05), (-1.0, 1.0, -0.05)];
        for (rotor, (x, y, ratio)) in rotors.into_iter().enumerate() {
            for (name, value) in [("PX", x), ("PY", y), ("KM", ratio)] {
                parameters.insert(format!("CA_ROTOR{rotor}_{name}"), value);
            }
        }
        let mixer = Inputs::of(&parameters).mixer;
        let of = |motors: [f64; 4]| {
            [0, 1, 2, 3].map(|axis| mixer.iter().zip(motors).map(|(own, u)| own[axis] * u).sum())
        };
        let near = |found: [f64; 4], expected: [f64; 4]| {
            found.iter().zip(expected).all(|(one, other): (&f64, f64)| (one - other).abs() < 1e-12)
        };
        // The motors are front right, rear left, front left, rear right.
        assert!(near(of([0.4, 0.6, 0.6, 0.4]), [0.2, 0.0, 0.5, 0.0]));
        assert!(near(of([0.6, 0.4, 0.6, 0.4]), [0.0, 0.2, 0.5, 0.0]));
        assert!(near(of([0.6, 0.6, 0.4, 0.4]), [0.0, 0.0, 0.5, 0.2]));
        assert!(Inputs::of(&HashMap::new()).mixer.is_empty());
    }
}
