//! Directions of the sensor axes: from gravity, from rotation that several sensors measure, and from trial runs of the
//! filter.

use super::look::median;
use crate::text::Axes;
use hovernav::ekf::{Channel, Innovation, Solution, Verdict};
use hovernav::frames::{EulerAngles, Vector, wrap_angle};
use hovernav::imu::{ImuSample, Motion};
use hovernav::time::Time;
use hovernav_dataset::Dataset;
use hovernav_replay::estimate;

/// Largest number of samples that a trial of the filter uses.
const TRIAL_SAMPLES: usize = 60_000;
/// Smallest number of fixes with which a trial distinguishes the candidates.
const TRIAL_FIXES: usize = 15;

/// Smallest score of a trial at which the fixes contradict the axes.
pub(super) const DISAGREES: f64 = 1.0;
/// Factor by which the score of an unusual candidate must be smaller. Wrong axes also hide a part of a wrong unit, scale or
/// clock.
const CLEARLY: f64 = 3.0;

/// The axes of each sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turn {
    pub gyro: Axes,
    pub accel: Axes,
    pub mag: Axes,
    pub attitude_signs: [f64; 3],
    pub yaw_offset_deg: f64,
}

/// The axes with the messages about them.
pub(crate) struct Found {
    pub turn: Turn,
    /// Mean square of the normalised innovations with `turn`: about 1 if all is right, infinite without a trial.
    pub score: f64,
    /// The same of the heights alone.
    pub height_score: f64,
    pub findings: Vec<String>,
    pub checks: Vec<String>,
}

/// Determines the axes of the sensors of `dataset`, which was read without any change of axes.
///
/// `is_of_phone` means that the sensor's axes are those of a phone.
pub(crate) fn found(dataset: &Dataset, is_of_phone: bool) -> Found {
    let identity = Turn {
        gyro: Axes::FORWARD_RIGHT_DOWN,
        accel: Axes::FORWARD_RIGHT_DOWN,
        mag: Axes::FORWARD_RIGHT_DOWN,
        attitude_signs: [1.0; 3],
        yaw_offset_deg: 0.0,
    };
    let mut found = Found {
        turn: identity,
        score: f64::INFINITY,
        height_score: f64::INFINITY,
        findings: Vec::new(),
        checks: Vec::new(),
    };
    let Some(gravity) = median_force(&dataset.imu) else { return found };
    let norm = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    let [x, y, z] = gravity;
    let mean = format!("median specific force: {x:+.2} {y:+.2} {z:+.2} m/s²");
    let upward = (0..3).find(|&axis| gravity[axis].abs() > 0.85 * norm);
    let Some(axis) = upward.filter(|_| (6.0..14.0).contains(&norm)) else {
        found.checks.push(format!(
            "{mean}: expected 9.8 m/s² along one axis and little along the others. Check the unit \
             and the mounting; the axes are assumed to be forward, right, down"
        ));
        return found;
    };
    // A phone's y axis points to its upper edge.
    let forward = match axis {
        0 => 2,
        2 if is_of_phone => 1,
        _ => 0,
    };
    let first = upright(axis, forward, gravity[axis] > 0.0);
    let letter = ["x", "y", "z"][axis];
    let way = if gravity[axis] > 0.0 { "up" } else { "down" };
    found.findings.push(format!("{mean}: {letter} points {way}"));
    if axis == 2 && is_of_phone {
        found.checks.push(
            "the phone lay flat, and its upper edge, y, is read as forward: if another edge was forward, correct \
             `axes` under [table.gyro] and [table.accel], forward first"
                .into(),
        );
    }
    if axis != 2 {
        found.checks.push(
            "gravity does not determine the forward axis: check `axes` under [table.gyro] and \
             [table.accel], forward first"
                .into(),
        );
    }
    // The readings are the same if an IMU is mounted the other way up and its accelerometers have the opposite sign.
    let other = upright(axis, forward, gravity[axis] < 0.0);
    let candidates = [(first, first), (other, other.reversed())];
    let mut tried: Vec<([f64; 2], Turn, Vec<String>)> = Vec::new();
    for (gyro, accel) in candidates {
        for (turn, notes) in turns(dataset, gyro, accel) {
            tried.push((trial(dataset, &turn), turn, notes));
        }
    }
    // The first candidate is the usual one. It is chosen if the fixes do not contradict it; otherwise another candidate
    // must be clearly better.
    let usual = tried.first().filter(|([score, _], ..)| *score < DISAGREES);
    let Some(([score, height_score], turn, notes)) = usual.or_else(|| {
        let handicap = |index: usize| if index == 0 { 1.0 / CLEARLY } else { 1.0 };
        let scores = tried.iter().enumerate().map(|(index, one)| (one.0[0] * handicap(index), one));
        scores.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, best)| best)
    }) else {
        return found;
    };
    found.turn = *turn;
    (found.score, found.height_score) = (*score, *height_score);
    found.findings.extend(notes.iter().cloned());
    if turn.accel != turn.gyro {
        found.findings.push(format!(
            "the accelerometers have the opposite sign along the axes {}: the fixes agree only \
             with that",
            name(turn.gyro)
        ));
    }
    if score.is_finite() {
        found.findings.push(format!(
            "tried {} axis assignments on the first fixes of the log; with the chosen one the \
             innovations are {:.1} times as large as the filter expects",
            tried.len(),
            score.sqrt()
        ));
    }
    found
}

/// The right-handed axes of an IMU whose `axis` points up or down, and `forward` forward.
fn upright(axis: usize, forward: usize, upwards: bool) -> Axes {
    let sign = if upwards { -1.0 } else { 1.0 };
    let right = 3 - axis - forward;
    // Right = down × forward.
    let cyclic = (forward + 3 - axis) % 3 == 1;
    let right_sign = if cyclic { sign } else { -sign };
    Axes([(forward, 1.0), (right, right_sign), (axis, sign)])
}

/// Axes in words.
pub(crate) fn name(axes: Axes) -> String {
    if axes == Axes::FORWARD_RIGHT_DOWN {
        return "forward-right-down".into();
    }
    if axes == Axes::FORWARD_LEFT_UP {
        return "forward-left-up".into();
    }
    let names: [String; 3] = axes.into();
    format!("such that forward, right, down are {}", names.join(", "))
}

fn median_force(imu: &[ImuSample]) -> Option<[f64; 3]> {
    let forces: Vec<[f64; 3]> = imu
        .windows(2)
        .map(|pair| {
            let rates = pair[1].motion.mean_rates(pair[1].time - pair[0].time);
            rates.specific_force_mps2.to_array()
        })
        .collect();
    (!forces.is_empty())
        .then(|| std::array::from_fn(|axis| median(forces.iter().map(|f| f[axis]).collect())))
}

/// The candidates to try with these axes of gyro and accelerometers, each with its findings.
fn turns(dataset: &Dataset, gyro: Axes, accel: Axes) -> Vec<(Turn, Vec<String>)> {
    let mut notes = Vec::new();
    let turned = Turn { gyro, accel, mag: gyro, attitude_signs: [1.0; 3], yaw_offset_deg: 0.0 };
    let steps = super::together::steps(&dataset.imu, gyro);
    let signs = super::together::attitude_signs(&steps);
    if let Some(signs) = signs.filter(|signs| *signs != [1.0; 3]) {
        let names = ["roll", "pitch", "yaw"].into_iter().zip(signs).filter(|(_, sign)| *sign < 0.0);
        let names: Vec<&str> = names.map(|(name, _)| name).collect();
        notes.push(format!(
            "{} of the attitude has the opposite sign to the gyro: reversed",
            names.join(", ")
        ));
    }
    let mag = super::together::mag_axes(dataset, gyro);
    if let Some(mag) = mag.filter(|mag| *mag != gyro) {
        notes.push(format!("the magnetometer's axes are {}", name(mag)));
    }
    let base =
        Turn { attitude_signs: signs.unwrap_or([1.0; 3]), mag: mag.unwrap_or(gyro), ..turned };
    let mut turns = vec![(base, notes.clone())];
    // A yaw that increases anticlockwise may be measured from east.
    if base.attitude_signs[2] < 0.0 {
        notes.push("yaw is measured from east: converted to 90° − yaw".into());
        turns.push((Turn { yaw_offset_deg: 90.0, ..base }, notes));
    }
    turns
}

/// Scores of `turn`, of all together and of the heights; smaller is better. It is the mean square of the normalised innovations of the first fixes. A
/// heading that differs from the IMU's own adds a penalty. Infinite if the filter cannot run.
fn trial(dataset: &Dataset, turn: &Turn) -> [f64; 2] {
    const FAILED: [f64; 2] = [f64::INFINITY; 2];
    if dataset.fixes.is_empty() {
        return FAILED;
    }
    let mut trial = head(dataset);
    trial.magnetometer.clear();
    trial.imu.iter_mut().for_each(|sample| *sample = turned(sample, turn));
    let Ok(config) = trial.settings() else { return FAILED };
    let run = estimate(&trial, &config, |_| {});
    let [mut gps, mut heading, mut height] = [Tally::default(); 3];
    let mut fixes = 0usize;
    for report in run.reports() {
        for innovation in report.innovations() {
            match innovation.channel {
                Channel::PositionNorth
                | Channel::PositionEast
                | Channel::PositionDown
                | Channel::VelocityNorth
                | Channel::VelocityEast
                | Channel::VelocityDown => gps.add(innovation),
                // If the filter rejects a wrong heading, it runs without that heading and remains consistent with the
                // fixes. So heading innovations have their own tally.
                Channel::Yaw => heading.add(innovation),
                _ => {}
            }
            fixes += usize::from(innovation.channel == Channel::PositionNorth);
            if innovation.channel == Channel::PositionDown {
                height.add(innovation);
            }
        }
    }
    if fixes < TRIAL_FIXES {
        return FAILED;
    }
    let misfit = heading_misfit(&trial.imu, &run.solutions);
    [gps.mean() + heading.mean() + misfit, height.mean()]
}

/// The part of `dataset` that a trial uses: from shortly before the first fix, without barometer and controls.
pub(super) fn head(dataset: &Dataset) -> Dataset {
    let first = dataset.fixes.first().map_or(Time::ZERO, |fix| fix.time);
    let begin = dataset.imu.partition_point(|sample| sample.time < first.offset_by(-5.0));
    let samples = dataset.imu.iter().skip(begin).take(TRIAL_SAMPLES);
    let imu: Vec<ImuSample> = samples.copied().collect();
    let until = imu.last().map_or(Time::ZERO, |sample| sample.time);
    Dataset {
        manifest: dataset.manifest.clone(),
        fixes: dataset.fixes.iter().filter(|fix| fix.time <= until).copied().collect(),
        magnetometer: dataset.magnetometer.clone(),
        imu,
        ..Dataset::default()
    }
}

/// Difference between the filter's heading and the IMU's own, divided by 10° and squared. The difference is the median
/// over the last quarter of the run.
fn heading_misfit(imu: &[ImuSample], solutions: &[Solution]) -> f64 {
    const TOLERATED_RAD: f64 = 0.17;
    // There is one solution per sample, up to the last sample.
    let pairs = imu.iter().rev().zip(solutions.iter().rev()).take(solutions.len() / 4);
    let off = pairs.filter_map(|(sample, solution)| {
        let yaw_rad = solution.body_to_ned.euler().yaw_rad;
        Some(wrap_angle(sample.attitude?.yaw_rad - yaw_rad).abs())
    });
    let off = median(off.collect());
    if off.is_finite() { (off / TOLERATED_RAD).powi(2) } else { 0.0 }
}

/// Sum and count of squared normalised innovations.
#[derive(Clone, Copy, Default)]
struct Tally {
    squares: f64,
    count: usize,
}

impl Tally {
    fn add(&mut self, innovation: &Innovation) {
        // The cap prevents one measurement that is always rejected from hiding the others. Each rejection also adds a
        // penalty.
        self.squares += innovation.normalised().powi(2).min(100.0);
        self.squares += if innovation.verdict == Verdict::Accepted { 0.0 } else { 10.0 };
        self.count += 1;
    }

    /// The mean square; 0 without innovations.
    fn mean(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.squares / self.count as f64 }
    }
}

fn turned(sample: &ImuSample, turn: &Turn) -> ImuSample {
    let by = |axes: Axes, vector: [f64; 3]| Vector::from(axes.turned(vector));
    let motion = match sample.motion {
        Motion::Rates { angular_rate_radps, specific_force_mps2 } => Motion::Rates {
            angular_rate_radps: by(turn.gyro, angular_rate_radps.to_array()),
            specific_force_mps2: by(turn.accel, specific_force_mps2.to_array()),
        },
        Motion::Increments { angle_rad, velocity_mps } => Motion::Increments {
            angle_rad: by(turn.gyro, angle_rad.to_array()),
            velocity_mps: by(turn.accel, velocity_mps.to_array()),
        },
    };
    let [roll, pitch, yaw] = turn.attitude_signs;
    ImuSample {
        attitude: sample.attitude.map(|angles| EulerAngles {
            roll_rad: roll * angles.roll_rad,
            pitch_rad: pitch * angles.pitch_rad,
            yaw_rad: wrap_angle(yaw * angles.yaw_rad + turn.yaw_offset_deg.to_radians()),
        }),
        magnetic_field_gauss: sample
            .magnetic_field_gauss
            .map(|field| by(turn.mag, field.to_array())),
        ..ImuSample::new(sample.time, motion)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_stay_right_handed_whichever_is_up() {
        for (axis, forward) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)] {
            for upwards in [true, false] {
                let Axes(rows) = upright(axis, forward, upwards);
                let row = |(axis, sign): (usize, f64)| {
                    let mut row = [0.0; 3];
                    row[axis] = sign;
                    Vector::<hovernav::frames::Body>::from(row)
                };
                let [forward, right, down] = rows.map(row);
                assert!((forward.cross(right) - down).norm() < 1e-12, "{axis} {upwards}");
                let mut force = [0.0; 3];
                force[axis] = if upwards { 9.8 } else { -9.8 };
                assert_eq!(Axes(rows).turned(force)[2], -9.8, "{axis} {upwards}");
            }
        }
        assert_eq!(upright(2, 0, true), Axes::FORWARD_LEFT_UP);
    }
}
