//! The flight computer's own record, as channel values.

use std::path::Path;

use hovernav::autopilot::Mode;
use hovernav::earth::STANDARD_GRAVITY_MPS2;
use hovernav::ekf::Solution;
use hovernav::frames::Vector;
use hovernav::imu::Motion;
use hovernav::telemetry::SystemMode;
use hovernav::time::Time;
use hovernav_dataset::{Dataset, LogError};
use hovernav_record::{Cycle, Level, Record};

use crate::channel::{CHANNELS, Id};
use crate::store::{Batch, Store, TextLevel, TextLine};

type Values = Vec<(Id, f64)>;

/// Reads the flight computer's record `path`. Returns its content, and whether the record was cut off.
///
/// # Errors
/// As [`Record::open`].
pub fn read(path: &Path) -> Result<(Store, bool), LogError> {
    let record = Record::open(path)?;
    let start_s = 1e-9 * record.header.start_unix_ns as f64;
    let unix_s = |time: Time| start_s + (time - record.header.start);
    let mut store = Store::new(usize::MAX);
    let mut push = |time: Time, values: Values| {
        let plausible = |(id, value): (Id, f64)| (id, CHANNELS[id as usize].plausible(Some(value)));
        let values = values.into_iter().map(plausible).collect();
        store.push(&Batch { time_s: unix_s(time), values });
    };
    for solution in &record.solutions {
        push(solution.time, of_solution(solution));
    }
    for recorded in &record.cycles {
        push(recorded.time, of_cycle(&recorded.cycle));
    }
    if record.cycles.is_empty() {
        for (time, sticks) in &record.controls {
            push(*time, PILOT.into_iter().zip(sticks.map(|stick| 100.0 * stick)).collect());
        }
    }
    of_sensors(&record.dataset()?, push);
    for event in &record.events {
        let level = match event.level {
            Level::Info => TextLevel::Info,
            Level::Warning => TextLevel::Warning,
            Level::Error | Level::Critical => TextLevel::Error,
        };
        store.say(TextLine { time_s: unix_s(event.time), level, text: event.text.clone() });
    }
    Ok((store, !record.is_ended))
}

const PILOT: [Id; 4] =
    [Id::StickLateral, Id::StickLongitudinal, Id::StickCollective, Id::StickPedal];
const FLOWN: [Id; 4] =
    [Id::FlownLateral, Id::FlownLongitudinal, Id::FlownCollective, Id::FlownPedal];

fn three<F>(ids: [Id; 3], vector: Vector<F>, scale: f64) -> impl Iterator<Item = (Id, f64)> {
    ids.into_iter().zip(vector.to_array().map(|value| scale * value))
}

fn east_north_up<F>(ids: [Id; 3], vector: Vector<F>) -> impl Iterator<Item = (Id, f64)> {
    let [north, east, down] = vector.to_array();
    ids.into_iter().zip([east, north, -down])
}

fn of_solution(solution: &Solution) -> Values {
    use Id::*;
    const G: f64 = 1.0 / STANDARD_GRAVITY_MPS2;
    let degrees = 1f64.to_degrees();
    let [roll, pitch, yaw] = solution.body_to_ned.euler().to_degrees();
    let [north_m, east_m, down_m] = solution.position_sigma_m.to_array();
    let [north_mps, east_mps, down_mps] = solution.velocity_sigma_mps.to_array();
    let [roll_rad, pitch_rad, heading_rad] = solution.attitude_sigma_rad;
    let mut values = vec![
        (Roll, roll),
        (Pitch, pitch),
        (Yaw, yaw),
        (Latitude, solution.position.latitude_deg()),
        (Longitude, solution.position.longitude_deg()),
        (Height, solution.position.height_m),
        (SigmaHorizontal, north_m.max(east_m)),
        (SigmaVertical, down_m),
        (SigmaVelHorizontal, north_mps.max(east_mps)),
        (SigmaVelVertical, down_mps),
        (SigmaTilt, roll_rad.max(pitch_rad).to_degrees()),
        (SigmaHeading, heading_rad.to_degrees()),
    ];
    values.extend(east_north_up([VelE, VelN, VelU], solution.velocity_mps));
    values.extend(three([BodyU, BodyV, BodyW], solution.velocity_body_mps(), 1.0));
    values.extend(three([RateP, RateQ, RateR], solution.angular_rate_radps, degrees));
    let ids = [GyroBiasX, GyroBiasY, GyroBiasZ];
    values.extend(three(ids, solution.gyro_bias_radps, degrees));
    let ids = [GyroBiasSigmaX, GyroBiasSigmaY, GyroBiasSigmaZ];
    values.extend(three(ids, solution.gyro_bias_sigma_radps, degrees));
    let ids = [AccelBiasX, AccelBiasY, AccelBiasZ];
    values.extend(three(ids, solution.accel_bias_mps2, G));
    let ids = [AccelBiasSigmaX, AccelBiasSigmaY, AccelBiasSigmaZ];
    values.extend(three(ids, solution.accel_bias_sigma_mps2, G));
    values
}

fn of_cycle(cycle: &Cycle) -> Values {
    let system = match cycle.mode {
        Mode::Manual => SystemMode::Pilot,
        Mode::Neutral => SystemMode::Failsafe,
        _ => SystemMode::Autopilot,
    };
    let place = Mode::ALL.iter().position(|mode| *mode == cycle.mode);
    let mut values = vec![
        (Id::SystemMode, f64::from(system.code())),
        (Id::AutopilotMode, place.map_or(f64::NAN, |place| place as f64)),
        (Id::FailedChecks, f64::from(cycle.failed_checks)),
        (Id::AskedHeading, cycle.asked_heading_rad.to_degrees()),
        (Id::Work, cycle.work_s.map_or(f64::NAN, |work_s| 1e3 * work_s)),
    ];
    values.extend(east_north_up(
        [Id::AskedVelE, Id::AskedVelN, Id::AskedVelU],
        cycle.asked_velocity_mps,
    ));
    for (ids, sticks) in [(PILOT, cycle.pilot), (FLOWN, cycle.sticks)] {
        let percent =
            sticks.map_or([f64::NAN; 4], |sticks| sticks.to_array().map(|one| 100.0 * one));
        values.extend(ids.into_iter().zip(percent));
    }
    values
}

fn of_sensors(dataset: &Dataset, mut push: impl FnMut(Time, Values)) {
    use Id::*;
    const G: f64 = 1.0 / STANDARD_GRAVITY_MPS2;
    for sample in &dataset.imu {
        let mut values = Values::new();
        if let Motion::Rates { specific_force_mps2, .. } = sample.motion {
            values.extend(three([AccelX, AccelY, AccelZ], specific_force_mps2, G));
        }
        if let Some(field) = sample.magnetic_field_gauss {
            values.extend(three([MagX, MagY, MagZ], field, 1.0));
        }
        push(sample.time, values);
    }
    for fix in &dataset.fixes {
        let [north, east] = fix.horizontal_velocity_mps.unwrap_or([f64::NAN; 2]);
        let height_m = if fix.two_dimensional { f64::NAN } else { fix.position.height_m };
        let values = vec![
            (GpsLatitude, fix.position.latitude_deg()),
            (GpsLongitude, fix.position.longitude_deg()),
            (GpsHeight, height_m),
            (GpsVelN, north),
            (GpsVelE, east),
            (GpsVelU, fix.down_velocity_mps.map_or(f64::NAN, |down| -down)),
            (Satellites, fix.satellites.map_or(f64::NAN, f64::from)),
        ];
        push(fix.time, values);
    }
}
