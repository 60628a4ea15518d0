//! The whole vehicle: airframe, servos, governor, ground.

use std::f64::consts::TAU;

use hovernav::glam::DVec3;

use super::airframe::{Airframe, Lateness};
use super::check::{Checked, ConfigError, finite, positive};
use super::crash::Crash;
use super::disturbance::{Disturbance, Push};
use super::engine::EngineConfig;
use super::ground;
use super::servo::{ServoConfig, SimulatedServo};
use super::skids;
use super::state::State;
use super::transport::Transport;
use hovernav::controls::Sticks;
use hovernav::earth::{Geodetic, LocalEarth};
use hovernav::frames::{Body, EulerAngles, Ned, Rotation, Vector};
use hovernav_model::helicopter::{
    Helicopter, HelicopterError, HelicopterParameters, HelicopterState, StateDerivative,
};
use hovernav_model::{LinearAirframe, StateSpace};

/// Settings of the vehicle apart from the airframe. The default is the thesis's helicopter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleConfig {
    /// The servos of cyclic and collective.
    pub servo: ServoConfig,
    /// The servo of the tail, which is faster than the other servos.
    pub tail_servo: ServoConfig,
    /// The engine and its governor.
    pub engine: EngineConfig,
    /// Height of the ground above the ellipsoid, m.
    pub ground_m: f64,
    /// Longest step of the integration, s.
    pub step_s: f64,
}

impl Default for VehicleConfig {
    fn default() -> Self {
        Self {
            servo: ServoConfig::default(),
            tail_servo: ServoConfig {
                bandwidth_hz: 12.0,
                rate_per_s: 20.0,
                ..ServoConfig::default()
            },
            engine: EngineConfig::default(),
            ground_m: 0.0,
            step_s: 0.01,
        }
    }
}

impl VehicleConfig {
    fn check(&self) -> Checked {
        const SENSOR: &str = "vehicle";
        self.engine.check()?;
        finite(SENSOR, "height of the ground", self.ground_m)?;
        positive(SENSOR, "step", self.step_s)
    }
}

/// Sink rate, m/s, above which a ground contact is a crash.
const HARD_MPS: f64 = 2.5;
/// Tilt, rad, above which a ground contact is a crash.
const TIPPED_RAD: f64 = 0.6;
/// Roll or pitch, rad, beyond which a vehicle in the air is lost.
const UPSET_RAD: f64 = 1.4;
/// Airspeed, m/s, above which a linear hover model is not valid.
const FASTEST_MPS: f64 = 20.0;

/// A flying helicopter, from sticks to motion.
#[derive(Clone, Debug)]
pub struct Vehicle {
    config: VehicleConfig,
    airframe: Airframe,
    servos: [SimulatedServo; 4],
    /// Transport delays of the sticks' commands.
    transports: [Transport; 4],
    /// Time since the start, s.
    time_s: f64,
    /// Servos that are jammed.
    jammed: [bool; 4],
    motion: HelicopterState,
    position: Geodetic,
    wind_mps: Vector<Ned>,
    pushes: Vec<Push>,
    /// Effect of the pushes in the current step: acceleration, m/s², and angular rate, rad/s.
    pushed: (Vector<Body>, Vector<Body>),
    crash: Option<Crash>,
}

impl Vehicle {
    /// A `helicopter` in hover at `position`, heading `heading_rad`.
    ///
    /// # Errors
    /// [`ConfigError`] with the invalid value of `config`.
    pub fn hovering(
        config: &VehicleConfig,
        helicopter: Helicopter,
        position: Geodetic,
        heading_rad: f64,
    ) -> Result<Self, ConfigError> {
        let airframe = Airframe::helicopter(helicopter, &config.engine);
        let late = [Lateness { delay_s: 0.0, lag_s: None }; 4];
        Self::of(config, airframe, late, position, heading_rad)
    }

    /// A linear hover model in hover at `position`, level, heading `heading_rad`. The delays and lags that the model
    /// states for its sticks replace the lags of the servos. These delays count from a command to its effect. They
    /// include the delay `period_s` of the flight computer.
    ///
    /// # Errors
    /// [`ConfigError`] with the invalid value of `config`.
    pub fn linear(
        config: &VehicleConfig,
        (airframe, model): (LinearAirframe, &StateSpace),
        position: Geodetic,
        heading_rad: f64,
        period_s: f64,
    ) -> Result<Self, ConfigError> {
        let late = Lateness::of(model, period_s);
        Self::of(config, Airframe::Linear(airframe), late, position, heading_rad)
    }

    fn of(
        config: &VehicleConfig,
        airframe: Airframe,
        late: [Lateness; 4],
        position: Geodetic,
        heading_rad: f64,
    ) -> Result<Self, ConfigError> {
        config.check()?;
        let sticks = airframe.hover_sticks().to_array();
        let servo = |stick: usize| {
            let own =
                if Sticks::NAMES[stick] == "pedal" { config.tail_servo } else { config.servo };
            let lagging = |lag_s: f64| ServoConfig { bandwidth_hz: (TAU * lag_s).recip(), ..own };
            SimulatedServo::new(&late[stick].lag_s.map_or(own, lagging), sticks[stick])
        };
        let mut motion = airframe.hover();
        let hover = motion.body_to_ned.euler();
        motion.body_to_ned = Rotation::from_euler(EulerAngles { yaw_rad: heading_rad, ..hover });
        Ok(Self {
            config: *config,
            servos: [servo(0)?, servo(1)?, servo(2)?, servo(3)?],
            transports: std::array::from_fn(|stick| {
                Transport::new(late[stick].delay_s, sticks[stick])
            }),
            time_s: 0.0,
            jammed: [false; 4],
            airframe,
            motion,
            position,
            wind_mps: Vector::ZERO,
            pushes: Vec::new(),
            pushed: (Vector::ZERO, Vector::ZERO),
            crash: None,
        })
    }

    /// Adds `disturbance` to the state immediately.
    pub fn disturb(&mut self, disturbance: &Disturbance) {
        let [roll, pitch, yaw] = disturbance.attitude_rad;
        let angles = self.motion.body_to_ned.euler();
        self.motion.body_to_ned = Rotation::from_euler(EulerAngles {
            roll_rad: angles.roll_rad + roll,
            pitch_rad: angles.pitch_rad + pitch,
            yaw_rad: angles.yaw_rad + yaw,
        });
        self.motion.rate_radps += disturbance.rate_radps;
        self.motion.velocity_mps += disturbance.velocity_mps;
    }

    /// Adds `disturbance` to the state such that inertial sensors measure it: rates immediately, velocity and attitude
    /// within 0.3 s.
    pub fn push(&mut self, disturbance: &Disturbance) {
        self.motion.rate_radps += disturbance.rate_radps;
        self.pushes.push(Push::new(*disturbance));
    }

    /// Jams the servo of `stick` (lateral, longitudinal, collective or pedal) at its current position. The position of
    /// a helicopter's tail servo includes the contribution of its gyro. Other numbers have no effect.
    pub fn jam(&mut self, stick: usize) {
        if let Some(jammed) = self.jammed.get_mut(stick) {
            *jammed = true;
        }
        let pedal = self.servos().pedal;
        if let Airframe::Helicopter { helicopter, .. } = &mut self.airframe
            && Sticks::NAMES.get(stick) == Some(&"pedal")
        {
            let pitch_rad = helicopter.tail_pitch_rad(&self.motion, pedal);
            *helicopter = helicopter.clone().with_stuck_tail(pitch_rad);
        }
    }

    /// Stops the engine: from now on the rotors turn freely, driven by the air alone. A linear model has no engine.
    pub const fn lose_power(&mut self) {
        if let Airframe::Helicopter { engine, .. } = &mut self.airframe {
            engine.stop();
        }
    }

    /// Speed of the main rotor divided by its nominal speed; 1 for a linear model.
    #[must_use]
    pub const fn rotor_speed(&self) -> f64 {
        match &self.airframe {
            Airframe::Helicopter { engine, .. } => engine.drive().speed,
            Airframe::Linear(_) => 1.0,
        }
    }

    /// Changes the mass to `mass_kg`; inertia and rigging stay. A linear model has no mass.
    ///
    /// # Errors
    /// [`HelicopterError`] for a mass that this helicopter cannot carry.
    pub fn set_mass(&mut self, mass_kg: f64) -> Result<(), HelicopterError> {
        if let Airframe::Helicopter { helicopter, .. } = &mut self.airframe {
            let parameters = HelicopterParameters { mass_kg, ..*helicopter.parameters() };
            *helicopter = helicopter.with_parameters(parameters)?;
        }
        Ok(())
    }

    /// Flies for `interval_s` under `sticks` in a wind of `wind_mps`. A crashed vehicle stays at its position.
    pub fn step(&mut self, sticks: Sticks, wind_mps: Vector<Ned>, interval_s: f64) {
        self.wind_mps = wind_mps;
        if self.has_crashed() {
            return;
        }
        for (transport, command) in self.transports.iter_mut().zip(sticks.to_array()) {
            transport.send(command, self.time_s);
        }
        let steps = (interval_s / self.config.step_s).ceil().max(1.0);
        let step_s = interval_s / steps;
        for _ in 0..steps as usize {
            for (stick, servo) in self.servos.iter_mut().enumerate() {
                let command = self.transports[stick].at(self.time_s);
                if !self.jammed[stick] {
                    servo.step(command, step_s);
                }
            }
            self.integrate(step_s);
            self.time_s += step_s;
        }
    }

    /// Equation (V16) of docs/equations.md.
    fn integrate(&mut self, step_s: f64) {
        self.pushes.retain(|push| !push.is_over());
        self.pushed = (Vector::ZERO, Vector::ZERO);
        for push in &mut self.pushes {
            let (acceleration, turn) = push.advance(step_s);
            self.pushed = (self.pushed.0 + acceleration, self.pushed.1 + turn);
        }
        let before = self.motion;
        let torque_nm = self.derivative(&before).rotor_torque_nm;
        self.airframe.advance(self.servos().collective, torque_nm, step_s);

        let mut after = before.integrated(step_s, |motion| self.derivative(motion));
        after.body_to_ned = after.body_to_ned.turned_in_from(self.pushed.1 * step_s);
        let travel = (before.velocity_ned_mps() + after.velocity_ned_mps()) * (0.5 * step_s);
        self.position = LocalEarth::at(&self.position).carried(&self.position, travel);
        self.motion = after;
        self.crash = self.crash.or_else(|| self.strikes());
    }

    /// Derivative of the airframe's state, with the current rotor speed and the ground reaction on the skids.
    fn derivative(&self, motion: &HelicopterState) -> StateDerivative {
        let mut change = self.airframe.derivative(motion, &self.servos(), self.wind_mps);
        let height_m = self.position.height_m - self.config.ground_m;
        let parameters = match &self.airframe {
            Airframe::Helicopter { helicopter, .. } => Some(helicopter.parameters()),
            Airframe::Linear(_) => None,
        };
        if let Some(parameters) = parameters {
            let lift = ground::effect(parameters, motion, height_m);
            let more = change.specific_force_mps2 * (lift - 1.0);
            change.velocity_mps2 += more;
            change.specific_force_mps2 += more;
        }
        change.velocity_mps2 += self.pushed.0;
        change.specific_force_mps2 += self.pushed.0;
        if let Some(parameters) = parameters.filter(|_| height_m < 1.0) {
            let (force, moment) = skids::reaction(motion, height_m);
            let push = force * (1.0 / parameters.mass_kg);
            change.velocity_mps2 += push;
            change.specific_force_mps2 += push;
            let inertia = DVec3::from_array(parameters.inertia_kgm2);
            change.rate_radps2 += Vector::claim(moment.components() / inertia);
        }
        change
    }

    fn strikes(&self) -> Option<Crash> {
        let height_m = self.position.height_m - self.config.ground_m;
        let lowest = skids::lowest_foot_m(self.motion.body_to_ned);
        let angles = self.motion.body_to_ned.euler();
        let tilt_rad = angles.roll_rad.abs().max(angles.pitch_rad.abs());
        let velocity_mps = self.motion.velocity_ned_mps();
        let sinking_mps = velocity_mps.z();
        if !velocity_mps.is_finite() {
            return Some(Crash::Diverged);
        }
        if tilt_rad > UPSET_RAD {
            return Some(Crash::Upset);
        }
        let is_hard = match self.airframe {
            Airframe::Helicopter { .. } => tilt_rad > TIPPED_RAD || sinking_mps > HARD_MPS,
            Airframe::Linear(_) => {
                let airspeed_mps = (velocity_mps - self.wind_mps).norm();
                if airspeed_mps > FASTEST_MPS {
                    return Some(Crash::TooFast { airspeed_mps });
                }
                true
            }
        };
        (lowest > height_m && is_hard).then_some(Crash::Ground { sinking_mps, tilt_rad })
    }

    /// Positions of the servos.
    #[must_use]
    pub fn servos(&self) -> Sticks {
        Sticks::from_array(self.servos.map(|servo| servo.position()))
    }

    /// Whether the vehicle struck the ground too hard, turned over, or left the flight envelope.
    #[must_use]
    pub const fn has_crashed(&self) -> bool {
        self.crash.is_some()
    }

    /// The event that ended the flight, if one did.
    #[must_use]
    pub const fn crash(&self) -> Option<Crash> {
        self.crash
    }

    /// Motion of the centre of gravity, with the measurements of inertial sensors there. They include the Earth's
    /// rotation, which the airframe's own equations neglect.
    #[must_use]
    pub fn state(&self) -> State {
        let motion = &self.motion;
        let change = self.derivative(motion);
        let local = LocalEarth::at(&self.position);
        let velocity_mps = motion.velocity_ned_mps();
        let to_body = motion.body_to_ned.inverse();
        let transport = local.transport_rate(velocity_mps);
        let frame_rate = local.earth_rate_radps + transport;
        let coriolis = (local.earth_rate_radps * 2.0 + transport).cross(velocity_mps);
        let heavier = self.airframe.gravity_mps2() - local.gravity_mps2;
        let rate_radps = motion.rate_radps + self.pushed.1;
        State {
            position: self.position,
            velocity_mps,
            body_to_ned: motion.body_to_ned,
            angular_rate_radps: rate_radps,
            inertial_rate_radps: rate_radps + to_body * frame_rate,
            angular_acceleration_radps2: change.rate_radps2,
            specific_force_mps2: change.specific_force_mps2
                + to_body * (coriolis + Vector::new(0.0, 0.0, heavier)),
            local,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use hovernav_model::helicopter::HelicopterParameters;

    fn hovering_at(height_m: f64) -> Vehicle {
        with(VehicleConfig::default(), height_m)
    }

    fn with(config: VehicleConfig, height_m: f64) -> Vehicle {
        let helicopter = Helicopter::new(HelicopterParameters::raptor60()).unwrap();
        let place = Geodetic::from_degrees(1.35, 103.82, height_m).unwrap();
        Vehicle::hovering(&config, helicopter, place, 0.7).unwrap()
    }

    fn fly(vehicle: &mut Vehicle, collective: f64, seconds: f64) {
        let sticks = Sticks { collective, ..Sticks::NEUTRAL };
        for _ in 0..(seconds / 0.03) as usize {
            vehicle.step(sticks, Vector::ZERO, 0.03);
        }
    }

    #[test]
    fn in_hover_its_sensors_feel_gravity_and_the_turning_earth() {
        let vehicle = hovering_at(30.0);
        let state = vehicle.state();
        let local = LocalEarth::at(&state.position);
        let up = state.body_to_ned * state.specific_force_mps2;
        assert!((up + Vector::new(0.0, 0.0, local.gravity_mps2)).norm() < 1e-6);
        let turning = state.body_to_ned * state.inertial_rate_radps;
        assert!((turning - local.earth_rate_radps).norm() < 1e-12);
    }

    #[test]
    fn it_settles_on_its_skids_and_stays() {
        let mut vehicle = hovering_at(0.42);
        fly(&mut vehicle, -0.9, 5.0);
        let state = vehicle.state();
        assert!(!vehicle.has_crashed(), "{:?}", state.body_to_ned.euler().to_degrees());
        assert_abs_diff_eq!(state.position.height_m, 0.38, epsilon = 0.03);
        assert!(state.velocity_mps.norm() < 0.02);
    }

    #[test]
    fn a_fall_is_a_crash() {
        let mut vehicle = hovering_at(12.0);
        fly(&mut vehicle, -1.0, 10.0);
        assert!(vehicle.has_crashed());
    }

    #[test]
    fn droop_costs_lift_at_high_collective() {
        let climb = |droop| {
            let engine = EngineConfig { droop, ..EngineConfig::default() };
            let mut vehicle = with(VehicleConfig { engine, ..VehicleConfig::default() }, 30.0);
            fly(&mut vehicle, 0.3, 2.0);
            -vehicle.state().velocity_mps.z()
        };
        assert!(climb(0.0) > climb(0.03) + 0.05);
    }

    #[test]
    fn a_push_comes_to_its_size_and_the_sensors_feel_all_of_it() {
        let helicopter = Helicopter::new(HelicopterParameters::raptor60()).unwrap();
        let place = Geodetic::from_degrees(1.35, 103.8, 50.0).unwrap();
        let config = VehicleConfig::default();
        let hovering = Vehicle::hovering(&config, helicopter, place, 0.0).unwrap();
        let disturbance = Disturbance {
            attitude_rad: [0.3, 0.0, 0.0],
            velocity_mps: Vector::new(2.0, 0.0, 0.0),
            ..Disturbance::default()
        };
        let (mut calm, mut pushed) = (hovering.clone(), hovering);
        pushed.push(&disturbance);
        let (mut rolled, mut sped) = (0.0, 0.0);
        let step_s = 0.005;
        for _ in 0..60 {
            for vehicle in [&mut calm, &mut pushed] {
                vehicle.step(Sticks::NEUTRAL, Vector::ZERO, step_s);
            }
            let (with, without) = (pushed.state(), calm.state());
            rolled += step_s * (with.angular_rate_radps - without.angular_rate_radps).x();
            sped += step_s * (with.specific_force_mps2 - without.specific_force_mps2).x();
        }
        let roll = |vehicle: &Vehicle| vehicle.state().body_to_ned.euler().roll_rad;
        let forward = |vehicle: &Vehicle| vehicle.motion.velocity_mps.x();
        let (turned, faster) = (roll(&pushed) - roll(&calm), forward(&pushed) - forward(&calm));
        assert_abs_diff_eq!(turned, 0.3, epsilon = 0.05);
        assert_abs_diff_eq!(faster, 2.0, epsilon = 0.3);
        assert_abs_diff_eq!(rolled, turned, epsilon = 0.01);
        assert_abs_diff_eq!(sped, faster, epsilon = 0.3);
    }
}
