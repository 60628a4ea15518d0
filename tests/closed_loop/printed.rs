//! The model printed by Paw (2005), flown by the autopilot's own code.

use hovernav::autopilot::{HoverAutopilot, HoverConfig, Inputs, Mode};
use hovernav::controls::Sticks;
use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::frames::{Body, EulerAngles, Rotation, Vector};
use hovernav::time::Time;
use hovernav_design::hover::HoverDesign;
use hovernav_model::{StateSpace, shipped};
use hovernav_sim::{Disturbance, ServoConfig, SimulatedServo};
use nalgebra::{DMatrix, DVector};

use crate::{STATES, STOP, allowed_s, disturbances, settled_s};

/// Steps of servo and model between two samples.
const STEPS: usize = 20;
/// Time of the disturbance, samples.
const DISTURBED: usize = 66;

/// The printed model with a heading, behind servos with bandwidth, range and rate, and one sample of
/// delay.
struct Printed {
    step: DMatrix<f64>,
    input: DMatrix<f64>,
    /// p, q, phi, theta, u, v, w, r, psi.
    state: DVector<f64>,
    servos: [SimulatedServo; 4],
    acting: Sticks,
    step_s: f64,
}

impl Printed {
    fn new(model: &StateSpace, design: &HoverDesign) -> Self {
        let names = ["p", "q", "phi", "theta", "u", "v", "w", "r"];
        let sticks = ["lateral", "longitudinal", "collective", "pedal"];
        let model = model.subsystem(&names, &sticks).unwrap();
        let step_s = design.period_s / STEPS as f64;
        let mut generator = DMatrix::zeros(13, 13);
        generator.view_mut((0, 0), (8, 8)).copy_from(model.a());
        generator[(8, 7)] = 1.0;
        // The model's inputs are in percent of stick.
        generator.view_mut((0, 9), (8, 4)).copy_from(&(model.b() * 100.0));
        let transition = (generator * step_s).exp();
        let servo = |lag_s: f64| {
            let bandwidth_hz = 1.0 / (core::f64::consts::TAU * lag_s);
            let config = ServoConfig {
                bandwidth_hz,
                dead_band: 0.0,
                resolution: 0.0,
                ..ServoConfig::default()
            };
            SimulatedServo::new(&config, 0.0).unwrap()
        };
        let cyclic = servo(design.servo_s);
        Self {
            step: transition.view((0, 0), (9, 9)).into(),
            input: transition.view((0, 9), (9, 4)).into(),
            state: DVector::zeros(9),
            servos: [cyclic, cyclic, cyclic, servo(design.tail_servo_s)],
            acting: Sticks::NEUTRAL,
            step_s,
        }
    }

    fn disturb(&mut self, disturbance: &Disturbance) {
        let [phi, theta, psi] = disturbance.attitude_rad;
        let [p, q, r] = disturbance.rate_radps.to_array();
        let [u, v, w] = disturbance.velocity_mps.to_array();
        self.state += DVector::from_vec(vec![p, q, phi, theta, u, v, w, r, psi]);
    }

    fn solution(&self, time: Time) -> Solution {
        let x = &self.state;
        let body_to_ned =
            Rotation::from_euler(EulerAngles { roll_rad: x[2], pitch_rad: x[3], yaw_rad: x[8] });
        let velocity: Vector<Body> = Vector::new(x[4], x[5], x[6]);
        Solution {
            velocity_mps: body_to_ned * velocity,
            body_to_ned,
            angular_rate_radps: Vector::new(x[0], x[1], x[7]),
            ..Solution::at_rest(time, Geodetic::from_degrees(1.35, 103.8, 50.0).unwrap())
        }
    }

    /// Advances to the next sample; `sticks` act one sample later.
    fn advance(&mut self, sticks: Sticks) {
        for _ in 0..STEPS {
            let mut stand = DVector::zeros(4);
            for (k, command) in self.acting.to_array().into_iter().enumerate() {
                stand[k] = self.servos[k].step(command, self.step_s);
            }
            self.state = &self.step * &self.state + &self.input * stand;
        }
        self.acting = sticks;
    }

    /// phi, theta, psi, p, q, r, u, v, w.
    fn states(&self) -> [f64; 9] {
        [2, 3, 8, 0, 1, 7, 4, 5, 6].map(|index: usize| self.state[index])
    }
}

fn fly(disturbance: &Disturbance) -> Vec<[f64; 9]> {
    let (design, model) = (HoverDesign::thesis(), shipped::thesis());
    let config = HoverConfig::new(design.period_s, design.synthesise(&model).unwrap());
    let mut autopilot = HoverAutopilot::new(config).unwrap();
    let mut plant = Printed::new(&model, &design);
    let mut history = Vec::new();
    for k in 0..DISTURBED + 660 {
        if k == DISTURBED {
            plant.disturb(disturbance);
        }
        let now = Time::ZERO + k as f64 * design.period_s;
        let solution = plant.solution(now);
        let inputs = Inputs { now, solution: Some(&solution), pilot: None, engage: k > 0 };
        if k == 2 {
            autopilot.set(STOP).unwrap();
        }
        let outputs = autopilot.step(&inputs);
        assert!(k == 0 || outputs.mode == Mode::Position);
        if k >= DISTURBED {
            history.push(plant.states());
        }
        plant.advance(outputs.sticks);
    }
    history
}

#[test]
fn each_disturbance_of_table_6_1_is_back_at_trim_in_time() {
    for (name, size, disturbance) in disturbances() {
        let history = fly(&disturbance);
        let period_s = HoverDesign::thesis().period_s;
        let state = STATES.iter().position(|state| *state == name).unwrap();
        let settled = settled_s(history.iter().map(|states| states[state]), period_s, 0.02 * size);
        println!("printed model, {name} {size}: {settled:.2} s");
        assert!(settled <= allowed_s(name), "{name}: {settled} s");
    }
}

#[test]
fn a_constant_climb_is_held_without_steady_error() {
    let (design, model) = (HoverDesign::thesis(), shipped::thesis());
    let config = HoverConfig::new(design.period_s, design.synthesise(&model).unwrap());
    let mut autopilot = HoverAutopilot::new(config).unwrap();
    let mut plant = Printed::new(&model, &design);
    for k in 0..330 {
        let now = Time::ZERO + f64::from(k) * design.period_s;
        let solution = plant.solution(now);
        let inputs = Inputs { now, solution: Some(&solution), pilot: None, engage: k > 0 };
        if k == 2 {
            autopilot
                .set(hovernav::autopilot::SetPoint::Velocity {
                    forward_mps: 0.0,
                    right_mps: 0.0,
                    down_mps: -1.0,
                    yaw_rate_radps: 0.0,
                })
                .unwrap();
        }
        plant.advance(autopilot.step(&inputs).sticks);
    }
    let error = plant.states()[8] + 1.0;
    println!("printed model, climb of 1 m/s: steady error {:.2} %", 100.0 * error.abs());
    assert!(error.abs() < 0.05);
}
