//! A flight of sines and noise, with estimate, measurements and reference.

use hovernav::earth::Geodetic;
use hovernav::ekf::{Channel, Innovation, Solution, Verdict};
use hovernav::frames::{EulerAngles, Ned, Rotation, Vector, wrap_angle};
use hovernav::gps::Fix;
use hovernav::time::Time;
use hovernav_dataset::{Outage, ReferenceMoment};
use hovernav_score::{Axis, AxisScore, ErrorPoint, Score, Statistics};

use super::super::data::FlightData;

/// Normally distributed numbers, identical in every run: the sum of twelve uniform numbers (Knuth's generator).
struct Noise(u64);

impl Noise {
    fn uniform(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    fn vector<F>(&mut self, sigma: f64) -> Vector<F> {
        Vector::new(self.normal(), self.normal(), self.normal()) * sigma
    }
}

fn outage(start_s: f64, duration_s: f64) -> Outage {
    Outage { start: Time::from_seconds(start_s), duration_s }
}

/// A flight with estimate, measurements and reference.
#[derive(Default)]
pub struct SyntheticFlight {
    pub solutions: Vec<Solution>,
    pub smoothed: Vec<Solution>,
    pub fixes: Vec<Fix>,
    pub innovations: Vec<Innovation>,
    pub reference: Vec<(Time, ReferenceMoment)>,
    pub score: Option<Score>,
    pub outages: Vec<Outage>,
}

fn truth(t: f64) -> (Vector<Ned>, Vector<Ned>, EulerAngles) {
    let at = |t: f64| {
        let climb = 25.0 / (1.0 + (-(t - 60.0) / 8.0).exp());
        Vector::new(60.0 * (t / 23.0).sin(), 40.0 * (t / 31.0).cos() + 0.1 * t, -climb)
    };
    let velocity = (at(t + 0.01) - at(t - 0.01)) * 50.0;
    let attitude = EulerAngles {
        roll_rad: 0.12 * (t / 4.0).sin() + 0.03 * (t * 1.3).sin(),
        pitch_rad: -0.05 + 0.09 * (t / 5.3).cos(),
        yaw_rad: wrap_angle(t / 40.0),
    };
    (at(t), velocity, attitude)
}

pub fn fly(duration_s: f64, rate_hz: f64) -> SyntheticFlight {
    let origin = Geodetic::from_degrees(46.123_456, 8.654_321, 312.0).unwrap();
    let place = |offset| Geodetic::from_local_ned(&origin, offset).unwrap();
    let mut noise = Noise(7);
    let mut flight = SyntheticFlight {
        outages: vec![
            outage(0.4 * duration_s, 0.05 * duration_s),
            outage(0.7 * duration_s, 0.1 * duration_s),
        ],
        ..SyntheticFlight::default()
    };
    let mut errors: Vec<[[f64; 3]; 3]> = Vec::new();
    let (mut position_error, mut velocity_error) = (Vector::<Ned>::ZERO, Vector::<Ned>::ZERO);
    let mut last_fix_s = 0.0;
    let mut next_fix_s = 0.0;
    for sample in 0..(duration_s * rate_hz) as usize {
        let t = sample as f64 / rate_hz;
        let time = Time::from_seconds(t);
        let (position, velocity, attitude) = truth(t);
        let age = t - last_fix_s;
        let position_sigma = 0.5 + 0.9 * (-t / 4.0).exp() + 0.1 * age + 0.01 * age * age;
        let velocity_sigma = 0.12 + 0.6 * (-t / 6.0).exp() + 0.02 * age;
        let attitude_sigma = [0.3, 0.3, 0.9 + 6.0 * (-t / 30.0).exp()].map(f64::to_radians);
        position_error = position_error * 0.999 + noise.vector(0.045 * position_sigma);
        velocity_error = velocity_error * 0.999 + noise.vector(0.045 * velocity_sigma);
        let attitude_error = [0, 1, 2].map(|axis| {
            0.8 * attitude_sigma[axis] * (t / (7.0 + axis as f64)).sin() + 1e-4 * noise.normal()
        });
        let estimated = EulerAngles {
            roll_rad: attitude.roll_rad + attitude_error[0],
            pitch_rad: attitude.pitch_rad + attitude_error[1],
            yaw_rad: wrap_angle(attitude.yaw_rad + attitude_error[2]),
        };
        let learnt = 1.0 - (-t / 40.0).exp();
        let solution = Solution {
            time,
            position: place(position + position_error),
            velocity_mps: velocity + velocity_error,
            body_to_ned: Rotation::from_euler(estimated),
            angular_rate_radps: noise.vector(0.01),
            heading_revision_rad: 0.0,
            position_sigma_m: Vector::new(1.0, 1.0, 1.6) * position_sigma,
            velocity_sigma_mps: Vector::new(1.0, 1.0, 1.3) * velocity_sigma,
            attitude_sigma_rad: attitude_sigma,
            gyro_bias_radps: Vector::new(0.004, -0.003, 0.002) * learnt + noise.vector(2e-5),
            accel_bias_mps2: Vector::new(0.06, -0.09, 0.03) * learnt + noise.vector(4e-4),
            gyro_bias_sigma_radps: Vector::new(1.0, 1.0, 1.5) * (3e-4 + 4e-3 * (-t / 40.0).exp()),
            accel_bias_sigma_mps2: Vector::new(1.0, 1.0, 0.4) * (0.02 + 0.08 * (-t / 40.0).exp()),
        };
        let smooth = Solution {
            position: place(position + position_error * 0.4),
            velocity_mps: velocity + velocity_error * 0.4,
            ..solution
        };
        if t >= next_fix_s {
            next_fix_s += 1.0;
            if !flight.outages.iter().any(|outage| outage.covers(time)) {
                last_fix_s = t;
                fix(&mut flight, &mut noise, &solution, position, velocity, place);
            }
        }
        flight.solutions.push(solution);
        flight.smoothed.push(smooth);
        let place = place(position);
        flight.reference.push((
            time,
            ReferenceMoment {
                position: [place.latitude_rad, place.longitude_rad, place.height_m],
                velocity_mps: velocity.to_array(),
                attitude_rad: [attitude.roll_rad, attitude.pitch_rad, attitude.yaw_rad],
                body_velocity_mps: (Rotation::from_euler(attitude).inverse() * velocity).to_array(),
            },
        ));
        let attitude_error_deg = attitude_error.map(f64::to_degrees);
        errors.push([position_error.to_array(), velocity_error.to_array(), attitude_error_deg]);
    }
    flight.score = Some(scored(&errors, &flight.solutions));
    flight
}

fn scored(errors: &[[[f64; 3]; 3]], solutions: &[Solution]) -> Score {
    use Axis::{Down, East, North, Pitch, Roll, VelocityDown, VelocityEast, VelocityNorth, Yaw};
    let groups =
        [[North, East, Down], [VelocityNorth, VelocityEast, VelocityDown], [Roll, Pitch, Yaw]];
    let axes = groups.into_iter().enumerate().flat_map(|(group, axes)| {
        (0..3).map(move |component| {
            let points = errors.iter().zip(solutions).map(|(error, solution)| {
                let sigma = match group {
                    0 => solution.position_sigma_m.to_array(),
                    1 => solution.velocity_sigma_mps.to_array(),
                    _ => solution.attitude_sigma_rad.map(f64::to_degrees),
                };
                let (error, sigma) = (error[group][component], Some(sigma[component]));
                ErrorPoint { time: solution.time, error, sigma }
            });
            let series: Vec<ErrorPoint> = points.collect();
            let errors: Vec<f64> = series.iter().map(|point| point.error).collect();
            AxisScore {
                axis: axes[component],
                statistics: Statistics::of(&errors).unwrap(),
                samples: errors.len(),
                within_3_sigma: Some(0.987),
                error_over_sigma: Some(1.1),
                series,
            }
        })
    });
    Score { from: Time::ZERO, heading_known: None, axes: axes.collect() }
}

/// Adds a noisy fix and its six innovations. Some fixes are far off; the filter rejects them or is reset to them.
fn fix(
    flight: &mut SyntheticFlight,
    noise: &mut Noise,
    solution: &Solution,
    position: Vector<Ned>,
    velocity: Vector<Ned>,
    place: impl Fn(Vector<Ned>) -> Geodetic,
) {
    let number = flight.fixes.len();
    let (offset, verdict) = match number % 97 {
        40 => (Vector::new(35.0, -60.0, 12.0), Verdict::Rejected),
        80 => (Vector::new(9.0, 9.0, 14.0), Verdict::Reset),
        _ => (Vector::ZERO, Verdict::Accepted),
    };
    let speed = velocity + noise.vector(0.15);
    flight.fixes.push(Fix {
        horizontal_velocity_mps: Some([speed.x(), speed.y()]),
        down_velocity_mps: Some(speed.z()),
        satellites: Some(9),
        ..Fix::at(solution.time, place(position + offset + noise.vector(1.0)))
    });
    let position_sigma = solution.position_sigma_m.to_array().map(|sigma| sigma.hypot(1.2));
    let velocity_sigma = solution.velocity_sigma_mps.to_array().map(|sigma| sigma.hypot(0.2));
    let channels = [
        (Channel::PositionNorth, position_sigma[0], offset.x(), verdict),
        (Channel::PositionEast, position_sigma[1], offset.y(), verdict),
        (Channel::PositionDown, position_sigma[2], offset.z(), verdict),
        (Channel::VelocityNorth, velocity_sigma[0], 0.0, Verdict::Accepted),
        (Channel::VelocityEast, velocity_sigma[1], 0.0, Verdict::Accepted),
        (Channel::VelocityDown, velocity_sigma[2], 0.0, Verdict::Accepted),
    ];
    flight.innovations.extend(channels.map(|(channel, sigma, far, verdict)| Innovation {
        time: solution.time,
        channel,
        innovation: far + sigma * noise.normal(),
        sigma,
        verdict,
    }));
}

impl SyntheticFlight {
    pub fn data(&self) -> FlightData<'_> {
        FlightData {
            title: "A flight of sines",
            outages: &self.outages,
            solutions: &self.solutions,
            smoothed: &self.smoothed,
            fixes: &self.fixes,
            innovations: &self.innovations,
            reference: &self.reference,
            score: self.score.as_ref(),
            ..FlightData::default()
        }
    }
}
