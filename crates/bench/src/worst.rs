//! Search for the worst case: the longest cycle of the estimator over combinations of inputs.

use std::hint::black_box;
use std::time::Instant;

use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, NoHeadingSearch};
use hovernav::event::{BaroReading, Event, MagneticReading, RangeReading};
use hovernav::frames::Vector;
use hovernav::gps::AntennaHeading;
use hovernav::imu::{ImuSample, Motion};
use serde::Serialize;

use crate::PERIOD_S;
use crate::distribution::Pace;
use crate::flight::{FIX_EVERY, Flight};

/// The longest cycle of the estimator among all tested combinations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst {
    /// Time, ns: the minimum over many repetitions, which excludes interruptions.
    pub time_ns: f64,
    /// The inputs of the cycle.
    pub inputs: String,
    /// Number of tested combinations.
    pub tried: usize,
    /// Time of a cycle with one inertial sample only, measured in the same way, ns.
    pub ordinary_ns: f64,
}

const REPEATS: usize = 60;

/// A combination of inputs in one cycle.
#[derive(Clone, Copy, Debug)]
struct Inputs {
    /// Fixes in the cycle.
    fixes: u64,
    /// Age of each fix, cycles.
    late: u64,
    /// Jump of the fixes, m; large jumps are rejected or reset the filter.
    jump_m: f64,
    attitude: bool,
    aids: bool,
    /// Cycles without a sample before this cycle.
    gap: u64,
    /// Angular rate, rad/s.
    rate_radps: f64,
}

impl Inputs {
    fn all() -> impl Iterator<Item = Self> {
        let fixes = [0, 1, 4];
        fixes.into_iter().flat_map(|fixes| {
            [0, 6, 12, 18].into_iter().flat_map(move |late| {
                [0.0, 15.0, 500.0].into_iter().flat_map(move |jump_m| {
                    [(false, false), (true, false), (true, true)].into_iter().flat_map(
                        move |(attitude, aids)| {
                            [0, 7, 33].into_iter().flat_map(move |gap| {
                                [0.2, 3.0].into_iter().map(move |rate_radps| Self {
                                    fixes,
                                    late,
                                    jump_m,
                                    attitude,
                                    aids,
                                    gap,
                                    rate_radps,
                                })
                            })
                        },
                    )
                })
            })
        })
    }

    fn described(&self) -> String {
        let mut words = vec!["a sample".to_owned()];
        if self.attitude {
            words.push("attitude".into());
        }
        if self.aids {
            words.push("barometer, magnetometer, rangefinder and two antennas".into());
        }
        if self.fixes > 0 {
            let late_s = self.late as f64 * PERIOD_S;
            words.push(format!("{} fixes {late_s:.2} s old", self.fixes));
        }
        if self.fixes > 0 && self.jump_m > 0.0 {
            words.push(format!("{} m off", self.jump_m));
        }
        if self.gap > 0 {
            words.push(format!("after {:.1} s without samples", self.gap as f64 * PERIOD_S));
        }
        words.push(format!("turning {} rad/s", self.rate_radps));
        words.join(", ")
    }

    /// The events of the cycle.
    fn events(&self, flight: &mut Flight, now: u64) -> Vec<Event> {
        let mut events = Vec::new();
        for fix in 0..self.fixes {
            let cycle = now.saturating_sub(self.late + fix);
            let mut fix = flight.fix(cycle);
            fix.position = fix.position.displaced(Vector::new(self.jump_m, 0.0, 0.0));
            events.push(Event::Gps(fix));
        }
        let sample = flight.sample(now);
        let rate = Vector::new(self.rate_radps, 0.5 * self.rate_radps, 0.2);
        let motion = match sample.motion {
            Motion::Rates { specific_force_mps2, .. } => {
                Motion::Rates { angular_rate_radps: rate, specific_force_mps2 }
            }
            other => other,
        };
        let attitude = sample.attitude.filter(|_| self.attitude);
        let magnetic_field_gauss = None;
        events.push(Event::Imu(ImuSample { motion, attitude, magnetic_field_gauss, ..sample }));
        if self.aids {
            let time = sample.time;
            events.push(Event::Baro(BaroReading::new(time, flight.height_m())));
            let field_gauss = Flight::field_gauss(now);
            events.push(Event::Magnetometer(MagneticReading::new(time, field_gauss)));
            events.push(Event::Range(RangeReading::new(time, 7.0)));
            let yaw_rad = Flight::angles(now).yaw_rad;
            events.push(Event::AntennaHeading(AntennaHeading::new(time, yaw_rad, None)));
        }
        events
    }
}

type Flown = Estimator<Full, 28, f64, NoHeadingSearch>;

/// The minimum of the time over many repetitions from the same state, ns.
fn least(from: &Flown, events: &[Event], clock_ns: f64) -> f64 {
    let mut least = f64::INFINITY;
    let mut estimator = Box::new(from.clone());
    for _ in 0..REPEATS {
        (*estimator).clone_from(from);
        let start = Instant::now();
        for event in events {
            black_box(&mut *estimator).push(black_box(event), |notice| {
                black_box(notice);
            });
        }
        black_box(estimator.solution());
        least = least.min(start.elapsed().as_nanos() as f64 - clock_ns);
    }
    least
}

/// Searches all combinations of inputs.
pub fn search(clock_ns: f64) -> Result<Worst, String> {
    let mut flight = Flight::new()?;
    let mut estimator = Flown::with_layout(Flight::config());
    let settled = 1_000;
    for cycle in 0..settled {
        // The last attitude is old enough for the next one to be due.
        let mut sample = flight.sample(cycle);
        sample.attitude = sample.attitude.filter(|_| cycle < settled - 20);
        estimator.push(&Event::Imu(ImuSample { magnetic_field_gauss: None, ..sample }), |_| {});
        if cycle % FIX_EVERY == 0 {
            estimator.push(&Event::Gps(flight.fix(cycle)), |_| {});
        }
    }
    if estimator.filter().is_none() {
        return Err("the synthetic flight does not align".into());
    }
    let mut worst = Worst { time_ns: 0.0, inputs: String::new(), tried: 0, ordinary_ns: f64::NAN };
    let mut pace = Pace::begin();
    for inputs in Inputs::all() {
        pace.rest();
        // Age and jump have no effect without a fix.
        if inputs.fixes == 0 && (inputs.late > 0 || inputs.jump_m > 0.0) {
            continue;
        }
        let events = inputs.events(&mut flight, settled + inputs.gap);
        let time_ns = least(&estimator, &events, clock_ns);
        worst.tried += 1;
        if worst.tried == 1 {
            worst.ordinary_ns = time_ns;
        }
        if time_ns > worst.time_ns {
            (worst.time_ns, worst.inputs) = (time_ns, inputs.described());
        }
    }
    Ok(worst)
}
