//! A minute of `datasets/heli-hover`, compiled in, through estimator and autopilot. The same code runs on a
//! microcontroller and on the host, and gives a hash of all results.
#![no_std]

mod controller;

pub use controller::{Computer, Controller};

use hovernav::autopilot::{Gains, HoverAutopilot, HoverConfig, SteeringConfig};
use hovernav::earth::{Geodetic, STANDARD_GRAVITY_MPS2};
use hovernav::ekf::layout::Layout;
use hovernav::scalar::Scalar;
use hovernav::ekf::{
    Aid, Estimator, EstimatorConfig, HeadingMethod, Notice, Solution, SteplessSolution,
};
use hovernav::event::Event;
use hovernav::flight_control::{Geofence, FlightControl, FlightControlConfig};
use hovernav::frames::{EulerAngles, Vector};
use hovernav::gps::Fix;
use hovernav::imu::{ImuSample, Motion};
use hovernav::ins::{HeadingSource, Mounting};
use hovernav::servo::SwashplateKind;
use hovernav::time::Time;

include!(concat!(env!("OUT_DIR"), "/flight.rs"));

/// The vehicle's settings from `datasets/heli-hover/dataset.toml`.
#[must_use]
pub fn config() -> EstimatorConfig {
    let mut config = EstimatorConfig::default().with_mounting(
        Mounting::default()
            .with_imu_lever_arm_m(Vector::new(0.03, -0.02, 0.28))
            .with_antenna_lever_arm_m(Vector::new(-0.35, 0.0, 0.2)),
    );
    let imu = &mut config.ekf.imu;
    imu.angle_random_walk_rad = 2.25_f64.to_radians() / 60.0;
    imu.velocity_random_walk_mps = 0.45 / 60.0;
    imu.gyro_bias_sigma_radps = 0.25_f64.to_radians();
    imu.accel_bias_sigma_mps2 = 0.09;
    imu.gyro_range_radps = 200.0_f64.to_radians();
    imu.accel_range_mps2 = 4.0 * STANDARD_GRAVITY_MPS2;
    config.alignment.declination_rad = 0.42_f64.to_radians();
    config
}

/// The vehicle's settings for a flight with an unknown heading.
#[must_use]
pub fn config_without_heading() -> EstimatorConfig {
    let mut config = config();
    config.alignment.heading = Some(HeadingSource::Unknown);
    config.aiding.attitude = false;
    config.aiding.magnetometer = false;
    config
}

/// Gains that damp rates: the cost of a step does not depend on their values.
fn hover_config() -> HoverConfig {
    let mut gains = Gains::default();
    gains.heave.tracking_time_s = 1.0;
    gains.roll_pitch.measured = [[0.1, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.1, 0.0, 0.0, 0.0, 0.0]];
    gains.yaw.measured = [[0.2, 0.0]];
    HoverConfig::new(0.0303, gains)
}

/// The autopilot alone.
#[must_use]
pub fn autopilot<T: Scalar>() -> Option<HoverAutopilot<T>> {
    HoverAutopilot::new(hover_config().cast()).ok()
}

/// Flight control with the pilot's sticks as requests, a geofence, and a mixed swashplate.
#[must_use]
pub fn flight_control<T: Scalar>() -> Option<Computer<T>> {
    let mut config = FlightControlConfig::new(hover_config());
    config.steering = Some(SteeringConfig::default());
    let [_, latitude, longitude, height, ..] = GPS[0];
    let centre = Geodetic::from_degrees(latitude, longitude, height)?;
    config.geofence = Some(Geofence { centre, radius_m: 500.0, height_m: 100.0 });
    config.swashplate.kind = SwashplateKind::Ccpm120;
    FlightControl::new(config).ok().map(Computer::new)
}

fn sample(row: &[f64; 13]) -> Option<Event> {
    let [t, p, q, r, x, y, z, roll, pitch, yaw, mx, my, mz] = *row;
    let motion = Motion::Rates {
        angular_rate_radps: Vector::new(p, q, r),
        specific_force_mps2: Vector::new(x, y, z),
    };
    Some(Event::Imu(ImuSample {
        attitude: Some(EulerAngles::from_degrees(roll, pitch, yaw)),
        magnetic_field_gauss: Some(Vector::new(mx, my, mz)),
        ..ImuSample::new(Time::try_from_seconds(t)?, motion)
    }))
}

fn fix(row: &[f64; 11]) -> Option<Event> {
    let [t, latitude, longitude, height, vn, ve, vd, h, v, vh, vv] = *row;
    let place = Geodetic::from_degrees(latitude, longitude, height)?;
    Some(Event::Gps(Fix {
        position_sigma_m: Some(Vector::new(h, h, v)),
        horizontal_velocity_mps: Some([vn, ve]),
        down_velocity_mps: Some(vd),
        velocity_sigma_mps: Some(Vector::new(vh, vh, vv)),
        ..Fix::at(Time::try_from_seconds(t)?, place)
    }))
}

/// The flight in order of arrival, at most `most` samples.
pub fn events(most: usize) -> impl Iterator<Item = Event> {
    let mut fixes = GPS.iter().peekable();
    let mut samples = IMU.iter().take(most).peekable();
    core::iter::from_fn(move || {
        let row = samples.peek()?;
        if let Some(due) = fixes.next_if(|fix| fix[0] < row[0]) {
            return fix(due);
        }
        samples.next().and_then(sample)
    })
}

/// Work of one call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// A sample only.
    Step,
    /// A sample and the IMU's own attitude.
    StepAttitude,
    /// A sample and a fix.
    StepFix,
    /// A sample, the attitude and a fix: all measurements at once.
    StepAll,
    /// A sample before the heading is known.
    Search,
    /// A sample and a fix before the heading is known.
    SearchFix,
    /// The solution without jumps for the controller, and a step of the autopilot.
    Autopilot,
    /// The solution without jumps, and a step of all of flight control: the pilot's pulses, the checks, the choice
    /// between pilot and autopilot, and the widths.
    Control,
}

impl Work {
    /// All kinds of work.
    pub const ALL: [Self; 8] = [
        Self::Step,
        Self::StepAttitude,
        Self::StepFix,
        Self::StepAll,
        Self::Search,
        Self::SearchFix,
        Self::Autopilot,
        Self::Control,
    ];

    /// Name of the work in the table.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Step => "sample",
            Self::StepAttitude => "sample and attitude",
            Self::StepFix => "sample and fix",
            Self::StepAll => "sample, attitude and fix",
            Self::Search => "sample while the heading is searched",
            Self::SearchFix => "sample and fix while the heading is searched",
            Self::Autopilot => "solution and autopilot",
            Self::Control => "solution and flight control",
        }
    }
}

/// Results of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Number of solutions.
    pub solutions: u32,
    /// FNV-1a over the bits of each solution and of the sticks.
    pub hash: u64,
}

impl Outcome {
    fn add(&mut self, values: &[f64]) {
        for byte in values.iter().flat_map(|value| value.to_bits().to_le_bytes()) {
            self.hash = (self.hash ^ u64::from(byte)).wrapping_mul(1_099_511_628_211);
        }
    }

    fn add_solution(&mut self, solution: &Solution) {
        self.solutions += 1;
        let place = &solution.position;
        self.add(&[
            solution.time.seconds(),
            place.latitude_rad,
            place.longitude_rad,
            place.height_m,
        ]);
        self.add(&solution.velocity_mps.to_array());
        self.add(&solution.body_to_ned.quaternion().to_array());
        self.add(&solution.angular_rate_radps.to_array());
        self.add(&solution.position_sigma_m.to_array());
        self.add(&solution.velocity_sigma_mps.to_array());
        self.add(&solution.attitude_sigma_rad);
        self.add(&solution.gyro_bias_radps.to_array());
        self.add(&solution.accel_bias_mps2.to_array());
    }
}

/// Flies at most `most` samples. `clock` returns a count that grows with the instructions, and `note` receives the
/// count of each call. For a [`Computer`], only the calls of flight control are noted. The estimator's calls are equal
/// in all variants.
pub fn fly<L: Layout<N>, const N: usize, T: Scalar, H: HeadingMethod<T>, C: Controller<T>>(
    estimator: &mut Estimator<L, N, T, H>,
    controller: &mut C,
    most: usize,
    clock: impl Fn() -> u32,
    mut note: impl FnMut(Work, u32, u32),
) -> Outcome {
    let mut stepless = SteplessSolution::default();
    let mut outcome = Outcome { solutions: 0, hash: 14_695_981_039_346_656_037 };
    for event in events(most) {
        let (mut attitude, mut fix, mut aligned) = (false, false, false);
        let before = clock();
        controller.observe(&event);
        estimator.push_traced(&event, &mut stepless, |notice| {
            controller.observe_notice(&notice);
            match notice {
                Notice::Updated(ref report) => {
                    let axes = report.innovations().count();
                    attitude |= axes == 3;
                    fix |= axes == 6;
                }
                Notice::NotUsed { aid: Aid::Gps, .. } => fix = true,
                Notice::Aligned(_) => aligned = true,
                _ => {}
            }
        });
        let after = clock();
        let Event::Imu(ImuSample { time, .. }) = event else { continue };
        let searching = estimator.filter().is_none();
        let solution_began = clock();
        let solution = estimator.solution();
        let flown = solution.map(|own| stepless.solution(&own));
        let sticks = controller.step(time, flown.as_ref(), outcome.solutions > 100);
        let solution_ended = clock();
        if let (Some(solution), false) = (&solution, aligned) {
            let work = match (searching, attitude, fix) {
                (true, _, false) => Work::Search,
                (true, _, true) => Work::SearchFix,
                (false, false, false) => Work::Step,
                (false, true, false) => Work::StepAttitude,
                (false, false, true) => Work::StepFix,
                (false, true, true) => Work::StepAll,
            };
            if C::WORK == Work::Autopilot {
                note(work, before, after);
            }
            note(C::WORK, solution_began, solution_ended);
            outcome.add_solution(&solution.cast());
        }
        outcome.add(&sticks.cast().to_array());
    }
    outcome
}

/// The variants: their name, and the controller that flies them.
#[macro_export]
macro_rules! variants {
    ($fly:ident) => {
        $fly!("26 states, f64", [WithoutHeightAids, 26, f64, NoHeadingSearch], config, autopilot, 1_980);
        $fly!("26 states, f32", [WithoutHeightAids, 26, f32, NoHeadingSearch], config, autopilot, 1_980);
        $fly!("15 states, f64", [Base, 16, f64, NoHeadingSearch], config, autopilot, 1_980);
        $fly!("15 states, f32", [Base, 16, f32, NoHeadingSearch], config, autopilot, 1_980);
        $fly!(
            "search, f64",
            [WithoutHeightAids, 26, f64, HeadingSearch<f64>],
            config_without_heading,
            autopilot,
            330
        );
        $fly!(
            "search, f32",
            [WithoutHeightAids, 26, f32, HeadingSearch<f32>],
            config_without_heading,
            autopilot,
            330
        );
        $fly!("28 states, f64", [Full, 28, f64, NoHeadingSearch], config, flight_control, 990);
        $fly!("28 states, f32", [Full, 28, f32, NoHeadingSearch], config, flight_control, 990);
    };
}
