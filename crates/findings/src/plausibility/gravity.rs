//! Check of gravity: size and direction of the mean specific force.

use hovernav::earth::STANDARD_GRAVITY_MPS2 as G;
use hovernav::gps::Fix;
use hovernav::setup::ForceScale;
use hovernav::time::Time;

use super::regression::norm;
use crate::finding::{Sensor, SetupFinding};
use crate::rates::Rates;
use hovernav_dataset::statistics::quantile;

/// Time over which vibration averages out, s.
const MEAN_S: f64 = 1.0;
/// Possible range of the median of the one-second means in any flight, g; outside it an error is certain.
const POSSIBLE: (f64, f64) = (0.75, 1.6);
/// Usual range of that median, g; outside it an error is likely.
const USUAL: (f64, f64) = (0.85, 1.35);
/// Largest acceleration according to the fixes, m/s², at which the specific force counts as gravity.
const STEADY_MPS2: f64 = 0.3;
/// Interval over which the acceleration is computed from the fixes, s. Two fixes may be up to twice as far apart.
const STEADY_OVER_S: f64 = 2.0;
/// Smallest number of seconds with an acceleration below [`STEADY_MPS2`].
const MIN_STEADY: usize = 20;
/// Relative error of the specific force that exceeds the bias of any intact inertial unit.
const SCALE_OFF: f64 = 0.05;
/// Cosine of 60°, the angle from the vertical within which a vehicle spends its flight.
const UPRIGHT: f64 = 0.5;

/// Smallest length of the mean direction of the specific force, 0 to 1, at which the force has a usual direction.
const STEADY: f64 = 0.7;

/// Cosine of the angle from the vertical, 20°, beyond which the inertial unit is mounted askew.
const ASKEW: f64 = 0.94;
/// Smallest length of the mean direction, 0 to 1, at which a tilt comes from the mounting: no vehicle is tilted all the
/// time.
const ASKEW_STEADY: f64 = 0.97;

/// Mean specific force over a second.
struct Second {
    middle_s: f64,
    force_mps2: [f64; 3],
}

/// Means over seconds; those with fewer than three samples are skipped.
#[derive(Default)]
struct Means {
    first: Option<Time>,
    second: u64,
    /// Sum over the samples of the current second, and their number.
    force_mps2: [f64; 3],
    count: usize,
}

impl Means {
    /// Adds a sample; returns the mean of the previous second if the sample begins a new one.
    fn push(&mut self, at: &Rates) -> Option<Second> {
        let second = ((at.time - *self.first.get_or_insert(at.time)) / MEAN_S) as u64;
        let done = if second == self.second { None } else { self.finish() };
        self.second = second;
        self.force_mps2 = [0, 1, 2].map(|axis| self.force_mps2[axis] + at.force_mps2[axis]);
        self.count += 1;
        done
    }

    /// Ends the current second, and returns its mean.
    fn finish(&mut self) -> Option<Second> {
        let emptied = Self { first: self.first, ..Self::default() };
        let Self { second, force_mps2, count, .. } = std::mem::replace(self, emptied);
        let middle_s = self.first?.seconds() + (second as f64 + 0.5) * MEAN_S;
        let force_mps2 = force_mps2.map(|sum| sum / count as f64);
        (count >= 3).then_some(Second { middle_s, force_mps2 })
    }
}

/// Mean specific force, second by second.
pub(super) struct Gravity {
    means: Means,
    /// For each second: its middle, s, and the size of the mean specific force, m/s².
    seconds: Vec<(f64, f64)>,
    /// Sum of the directions of the means.
    directions: [f64; 3],
    /// Sum of the specific force over all samples, m/s².
    sum: [f64; 3],
}

impl Default for Gravity {
    fn default() -> Self {
        Self { means: Means::default(), seconds: Vec::new(), directions: [0.0; 3], sum: [0.0; 3] }
    }
}

impl Gravity {
    pub fn push(&mut self, at: &Rates) {
        self.sum = [0, 1, 2].map(|axis| self.sum[axis] + at.force_mps2[axis]);
        let mean = self.means.push(at);
        self.add(mean);
    }

    fn add(&mut self, mean: Option<Second>) {
        let Some(Second { middle_s, force_mps2, .. }) = mean else { return };
        let size = norm(force_mps2);
        self.seconds.push((middle_s, size));
        for (sum, value) in self.directions.iter_mut().zip(force_mps2) {
            *sum += value / size.max(1e-9);
        }
    }

    /// Mean up direction in the body; `None` without a steady direction, for example if the vehicle also flies on its
    /// back.
    pub fn up(&self) -> Option<[f64; 3]> {
        let is_steady = norm(self.directions) >= STEADY * self.seconds.len() as f64;
        is_steady.then(|| self.sum.map(|component| component / norm(self.sum).max(1e-12)))
    }

    pub fn check(mut self, fixes: &[Fix], found: &mut Vec<SetupFinding>) {
        let last = self.means.finish();
        self.add(last);
        let mut sizes: Vec<f64> = self.seconds.iter().map(|(_, size)| *size).collect();
        let Some(size_mps2) = quantile(&mut sizes, 0.5) else { return };
        let known = found.len();
        size(size_mps2, found);
        if found.len() == known {
            scale(&self.seconds, fixes, found);
        }
        direction(self.directions, self.seconds.len(), found);
    }
}

/// Checks the size of the specific force in those `seconds` in which the fixes show no acceleration.
fn scale(seconds: &[(f64, f64)], fixes: &[Fix], found: &mut Vec<SetupFinding>) {
    let velocity = |fix: &Fix| {
        let [north, east] = fix.horizontal_velocity_mps?;
        Some([north, east, fix.down_velocity_mps?])
    };
    let near = |time_s: f64| {
        let after = fixes.partition_point(|fix| fix.time.seconds() < time_s);
        fixes.get(after).filter(|fix| fix.time.seconds() < time_s + STEADY_OVER_S)
    };
    let is_steady = |time_s: f64| {
        let ends = [near(time_s - 0.5 * STEADY_OVER_S), near(time_s + 0.5 * STEADY_OVER_S)];
        let [Some(from), Some(to)] = ends else { return false };
        let (Some(before), Some(after)) = (velocity(from), velocity(to)) else { return false };
        let over_s = to.time - from.time;
        let change_mps = norm([0, 1, 2].map(|axis| after[axis] - before[axis]));
        over_s >= 0.5 * STEADY_OVER_S && change_mps < STEADY_MPS2 * over_s
    };
    let steady = seconds.iter().filter(|(time_s, _)| is_steady(*time_s));
    let mut sizes: Vec<f64> = steady.map(|(_, size)| *size).collect();
    let count = sizes.len();
    let Some(size) = quantile(&mut sizes, 0.5).filter(|_| count >= MIN_STEADY) else { return };
    let in_g = size / G;
    if (in_g - 1.0).abs() > SCALE_OFF {
        found.push(SetupFinding {
            sensor: Sensor::InertialUnit,
            is_certain: false,
            found: format!(
                "specific force is {size:.2} m/s² in {count} s without acceleration according to the fixes, expected \
                 gravity, 9.81 m/s²"
            ),
            cause: format!(
                "accelerometer scale {in_g:.2} times the right one, or a bias of {:.1} m/s²",
                size - G
            ),
            mend: "calibrate the accelerometers, or correct the range with which the counts were converted".into(),
        });
    }
}

fn size(size: f64, found: &mut Vec<SetupFinding>) {
    let in_g = size / G;
    if !(USUAL.0..=USUAL.1).contains(&in_g) {
        let (cause, mend) = size_error(in_g);
        found.push(SetupFinding {
            sensor: Sensor::InertialUnit,
            is_certain: !(POSSIBLE.0..=POSSIBLE.1).contains(&in_g),
            found: format!(
                "mean specific force is {size:.3} m/s², expected gravity, about 9.81 m/s²"
            ),
            cause,
            mend,
        });
    }
}

/// Likely cause of a mean specific force of `in_g` times gravity, and its remedy.
fn size_error(in_g: f64) -> (String, String) {
    let key = |text: &str| format!("write {text} under [imu] in dataset.toml");
    match ForceScale::of(in_g * G) {
        ForceScale::InG => ("accelerations in g".into(), key("accel_unit = \"g\"")),
        ForceScale::InThousandthsOfG => {
            ("accelerations in thousandths of g".into(), key("accel_unit = \"mg\""))
        }
        ForceScale::TimesG => {
            ("accelerations multiplied by g once too often".into(), key("accel_unit = \"g\""))
        }
        ForceScale::OtherRange { factor } => (
            format!("accelerometer scale {factor} times the right one, as with another range setting (2 g for 4 g)"),
            "correct the range with which the counts were converted".into(),
        ),
        ForceScale::WithoutGravity => (
            "accelerations without gravity, which are not specific force, or a unit other than m/s²"
                .into(),
            "write the accelerometers' own readings in m/s²".into(),
        ),
        _ => (
            "accelerometers with a wrong unit, scale or range, or increments read as rates".into(),
            "write specific force in m/s²".into(),
        ),
    }
}

/// Checks that the mean specific force points up, along minus z.
fn direction(sum: [f64; 3], count: usize, found: &mut Vec<SetupFinding>) {
    // Steadiness of the direction, 0 to 1, and the direction itself.
    let steady = norm(sum) / count.max(1) as f64;
    let up = sum.map(|component| component / norm(sum).max(1e-9));
    if steady > ASKEW_STEADY && (UPRIGHT..ASKEW).contains(&-up[2]) {
        found.push(askew(up));
    }
    if steady < STEADY || -up[2] > UPRIGHT {
        return;
    }
    let axis = (0..3).max_by(|&a, &b| up[a].abs().total_cmp(&up[b].abs())).unwrap_or(2);
    let names = ["x", "y", "z"];
    let sign = if up[axis] > 0.0 { "+" } else { "−" };
    let (cause, mend) = match (axis, up[axis] > 0.0) {
        (2, _) => (
            "axes forward, left, up, or accelerometers of the wrong sign (gravity instead of specific \
             force)"
                .to_owned(),
            "write axes = \"flu\" under [imu] in dataset.toml; if only the accelerometers are wrong, accel_is_gravity \
             = true; if only accelerometer z is wrong, change its sign"
                .to_owned(),
        ),
        _ => {
            let letters: [&str; 3] = match (axis, up[axis] > 0.0) {
                (0, true) => ["u", "r", "f"],
                (0, false) => ["d", "l", "f"],
                (1, true) => ["f", "u", "r"],
                _ => ["f", "d", "l"],
            };
            (
                format!(
                    "the inertial unit's {} axis is vertical: its axes are swapped, or it is mounted on its side",
                    names[axis]
                ),
                format!(
                    "write axes = \"{}\" under [imu] in dataset.toml, with the directions of the inertial unit's x, y \
                     and z: f, b, l, r, u or d",
                    letters.concat()
                ),
            )
        }
    };
    // An inertial unit may be mounted half-way between two axes.
    let is_certain = up[axis].abs() > 0.85;
    found.push(SetupFinding {
        sensor: Sensor::InertialUnit,
        is_certain,
        found: format!(
            "mean specific force points along {sign}{} ({:.2}, {:.2}, {:.2} of its size), expected −z for axes \
             forward, right, down",
            names[axis], up[0], up[1], up[2]
        ),
        cause,
        mend,
    });
}

/// Finding for an inertial unit mounted askew, from the direction `up`. Gravity shows its roll and pitch, not its yaw.
fn askew(up: [f64; 3]) -> SetupFinding {
    let (roll_deg, pitch_deg) =
        (f64::atan2(-up[1], -up[2]).to_degrees(), up[0].asin().to_degrees());
    SetupFinding {
        sensor: Sensor::InertialUnit,
        is_certain: false,
        found: format!(
            "mean specific force is {:.0}° off −z ({:.2}, {:.2}, {:.2} of its size) from start to end",
            (-up[2]).acos().to_degrees(),
            up[0],
            up[1],
            up[2]
        ),
        cause: "an inertial unit mounted askew in the vehicle".into(),
        mend: format!(
            "write mounting_deg = [{roll_deg:.1}, {pitch_deg:.1}, 0.0] under [imu] in dataset.toml, in addition to \
             angles already there; the third is the inertial unit's heading in the vehicle, which gravity does not \
             show"
        ),
    }
}

#[cfg(test)]
mod tests {
    use hovernav::earth::Geodetic;
    use hovernav::time::Time;

    use super::*;

    /// Findings for a vehicle that stands, then circles with 1.33 times gravity. Its accelerometers read `scale_by`
    /// times the specific force.
    fn found(scale_by: f64) -> Vec<SetupFinding> {
        let place = Geodetic::from_degrees(48.0, 11.0, 500.0).unwrap();
        let (mut seconds, mut fixes, mut found) = (Vec::new(), Vec::new(), Vec::new());
        for second in 0..120 {
            let circles = second >= 40;
            let angle_rad = 0.4 * f64::from(second);
            let speed_mps = if circles { 22.0 } else { 0.0 };
            let force = if circles { 1.34 * G } else { G };
            seconds.push((f64::from(second) + 0.5, scale_by * force));
            fixes.push(Fix {
                horizontal_velocity_mps: Some([
                    speed_mps * angle_rad.cos(),
                    speed_mps * angle_rad.sin(),
                ]),
                down_velocity_mps: Some(0.0),
                ..Fix::at(Time::ZERO + f64::from(second), place)
            });
        }
        scale(&seconds, &fixes, &mut found);
        found
    }

    #[test]
    fn a_scale_is_determined_by_what_is_measured_while_nothing_accelerates() {
        assert!(found(1.0).is_empty() && found(1.03).is_empty());
        for scale_by in [0.9, 1.1, 1.3] {
            let [finding] = &found(scale_by)[..] else { panic!("{scale_by}") };
            assert!(!finding.is_certain);
            assert!(finding.cause.contains(&format!("{scale_by:.2} times the right one")));
        }
    }
}
