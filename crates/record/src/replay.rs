//! Replay of a flight from its raw bytes.

use crate::read::{Call, Record};
use hovernav::controls::Sticks;
use hovernav::ekf::Solution;
use hovernav::event::Event;
use hovernav::sensors::{SensorOutput, Sensors};
use hovernav::time::Time;
use hovernav_dataset::LogError;
use hovernav_dataset::utc;
use hovernav_dataset::{Dataset, Source};

/// Comparison of a replay with the flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reproduction {
    /// Number of solutions compared.
    pub compared: usize,
    /// First difference in any bit; `None` if all bits are equal.
    pub first_difference: Option<Difference>,
}

/// The first solution of a replay that differs from the flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Time of the solution in flight.
    pub time: Time,
    /// Differences of position, m, velocity, m/s, and attitude, rad; `None` if the replay has no solution at that time.
    pub distance: Option<[f64; 3]>,
}

impl Record {
    /// Dataset from the recorded bytes: the estimator's input in flight, in its order.
    ///
    /// # Errors
    /// [`LogError::Unusable`] for an impossible configuration of sensors.
    pub fn dataset(&self) -> Result<Dataset, LogError> {
        let (dmu, gps) = self.header.config.sensors().map_err(|error| LogError::Unusable {
            path: self.header.config.navigation.name.clone().into(),
            reason: error.to_string(),
        })?;
        let mut dataset = Dataset {
            manifest: self.header.config.navigation.clone(),
            controls: self.controls.clone(),
            injected: self.injected(),
            warnings: self.warnings.clone(),
            ..Dataset::default()
        };
        // The flight's clock reads zero at the start of the computer.
        let zero_ns = self.header.start_unix_ns.saturating_sub(self.header.start.nanoseconds());
        dataset.manifest.date = utc::moment(zero_ns).or(dataset.manifest.date);
        let mut sensors = Sensors::new(dmu, gps, self.header.start);
        for (time, call) in &self.calls {
            let take = |report| match report {
                SensorOutput::Event(Event::Imu(sample)) => {
                    dataset.imu.push(sample);
                    dataset.order.push(Source::Imu);
                }
                SensorOutput::Event(Event::Gps(fix)) => {
                    dataset.fixes.push(fix);
                    dataset.order.push(Source::Gps);
                }
                SensorOutput::Event(Event::AntennaHeading(heading)) => {
                    dataset.headings.push(heading);
                    dataset.order.push(Source::AntennaHeading);
                }
                _ => {}
            };
            match call {
                Call::Dmu(bytes) => {
                    sensors.dmu(bytes, *time, take);
                }
                Call::Gps(bytes) => sensors.gps(bytes, *time, take),
                Call::RestartGps => sensors.restart_gps(),
                Call::Servo(_) => {}
            }
        }
        Ok(dataset)
    }

    /// The test input on each of the sticks; empty without test inputs.
    fn injected(&self) -> Vec<[f64; 4]> {
        let mut injected: Vec<(Time, [f64; 4])> = self
            .cycles
            .iter()
            .filter(|recorded| recorded.cycle.injected != Sticks::NEUTRAL)
            .map(|recorded| (recorded.time, recorded.cycle.injected.to_array()))
            .collect();
        if injected.is_empty() {
            return Vec::new();
        }
        injected.sort_by_key(|(time, _)| *time);
        let at = |time: &Time| injected.binary_search_by_key(time, |(time, _)| *time);
        let of = |time| at(time).map_or([0.0; 4], |index| injected[index].1);
        self.controls.iter().map(|(time, _)| of(time)).collect()
    }

    /// Compares the `replayed` solutions with those of the flight, bit for bit. Solutions that are missing in the
    /// record, because it was cut off or had no room, are not compared.
    #[must_use]
    pub fn reproduced_by(&self, replayed: &[Solution]) -> Reproduction {
        let mut replayed = replayed.iter().peekable();
        let mut last = None;
        let first_difference = self.solutions.iter().find_map(|flown| {
            while replayed.next_if(|solution| solution.time < flown.time).is_some() {}
            // Without an accepted sample, the flight records its last solution again.
            last = replayed.next_if(|solution| solution.time == flown.time).or(last);
            let same_time = last.filter(|solution| solution.time == flown.time);
            let distance = same_time.map(|solution| distance(flown, solution));
            let is_same = same_time.is_some_and(|solution| bits(flown).eq(bits(solution)));
            (!is_same).then_some(Difference { time: flown.time, distance })
        });
        Reproduction { compared: self.solutions.len(), first_difference }
    }
}

fn distance(flown: &Solution, replayed: &Solution) -> [f64; 3] {
    let turned = replayed.body_to_ned.quaternion() * flown.body_to_ned.quaternion().inverse();
    [
        replayed.position.displacement_from(&flown.position).norm(),
        (replayed.velocity_mps - flown.velocity_mps).norm(),
        turned.to_scaled_axis().length(),
    ]
}

fn bits(solution: &Solution) -> impl Iterator<Item = u64> {
    let place = &solution.position;
    [place.latitude_rad, place.longitude_rad, place.height_m]
        .into_iter()
        .chain(solution.velocity_mps.to_array())
        .chain(solution.body_to_ned.quaternion().to_array())
        .chain(solution.angular_rate_radps.to_array())
        .chain([solution.heading_revision_rad])
        .chain(solution.position_sigma_m.to_array())
        .chain(solution.velocity_sigma_mps.to_array())
        .chain(solution.attitude_sigma_rad)
        .chain(solution.gyro_bias_radps.to_array())
        .chain(solution.accel_bias_mps2.to_array())
        .chain(solution.gyro_bias_sigma_radps.to_array())
        .chain(solution.accel_bias_sigma_mps2.to_array())
        .map(f64::to_bits)
}
