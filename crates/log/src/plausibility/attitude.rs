//! The gyros against the unit's own attitude, and against gravity where it has none.

use hovernav::frames::Rotation;

use super::regression::Regression;
use super::{Judged, norm};
use crate::finding::SetupFinding;

/// Over how long rotations are compared, s: longer than an attitude lags, shorter than a turn.
const OVER_S: f64 = 0.5;
/// Gyros that move less than this, rad/s rms, tell nothing.
const LEAST_RADPS: f64 = 0.02;
/// So much of the attitude's motion has to be explained before anything is concluded.
const EXPLAINED: f64 = 0.5;
const NAMES: [&str; 3] = ["x", "y", "z"];

pub(super) fn check(log: &Judged<'_>, found: &mut Vec<SetupFinding>) {
    if !with_attitude(log, found) {
        against_gravity(log, found);
    }
}

/// Compares mean rates with the turning of the attitude; false where there is none to compare with.
fn with_attitude(log: &Judged<'_>, found: &mut Vec<SetupFinding>) -> bool {
    let imu = &log.dataset.imu;
    let skipped = imu.len() - log.rates.len();
    let mut regression = Regression::<3>::NONE;
    let mut first = 0;
    while first < log.rates.len() {
        let start = &log.rates[first];
        let count =
            log.rates[first..].iter().take_while(|at| at.time - start.time < OVER_S).count();
        let last = first + count;
        let end = log.rates.get(last).filter(|end| end.time - start.time < 1.5 * OVER_S);
        if let (Some(end), Some(from)) = (end, imu[skipped + first].attitude)
            && let Some(to) = imu[skipped + last].attitude
        {
            let length_s = end.time - start.time;
            // Trapezoids over the samples between.
            let mut turn = [0.0; 3];
            for pair in log.rates[first..=last].windows(2) {
                for ((turn, a), b) in
                    turn.iter_mut().zip(pair[0].turn_radps).zip(pair[1].turn_radps)
                {
                    *turn += 0.5 * (a + b) * (pair[1].time - pair[0].time) / length_s;
                }
            }
            let change =
                (Rotation::from_euler(from).inverse() * Rotation::from_euler(to)).rotation_vector();
            regression.push(turn, change.to_array().map(|angle_rad| angle_rad / length_s));
        }
        first = last.max(first + 1);
    }
    let Some(fit) = regression.fit(LEAST_RADPS) else { return false };
    if fit.explained.iter().any(|&explained| explained < EXPLAINED) {
        return false;
    }
    let diagonal = [0, 1, 2].map(|axis| fit.matrix[axis][axis]);
    let key = |text: &str| format!("write {text} under [imu] in dataset.toml");
    if diagonal.iter().all(|scale| (0.012..0.025).contains(scale)) {
        found.push(SetupFinding {
            sensor: "inertial unit",
            is_certain: true,
            found: format!(
                "the gyros turn {:.0} times as fast as the unit's own attitude",
                3.0 / diagonal.iter().sum::<f64>()
            ),
            cause: "angular rates in °/s, expected rad/s".into(),
            mend: key("gyro_unit = \"degps\""),
        });
        return true;
    }
    let wrong: Vec<&str> =
        (0..3).filter(|&axis| diagonal[axis] < -0.5).map(|axis| NAMES[axis]).collect();
    if !wrong.is_empty() {
        let all_but_x = wrong == ["y", "z"];
        found.push(SetupFinding {
            sensor: "inertial unit",
            is_certain: true,
            found: format!(
                "gyro {} turns against the unit's own attitude ({:.2}, {:.2}, {:.2} times as fast about \
                 x, y, z; expected 1)",
                wrong.join(" and "),
                diagonal[0],
                diagonal[1],
                diagonal[2]
            ),
            cause: if all_but_x {
                "axes forward, left, up, or gyros of the wrong sign".into()
            } else {
                "gyros of the wrong sign".into()
            },
            mend: if all_but_x { key("axes = \"flu\"") } else { "turn the sign of these columns".into() },
        });
        return true;
    }
    for (a, b) in [(0, 1), (1, 2), (0, 2)] {
        let [ab, ba] = [fit.matrix[a][b], fit.matrix[b][a]];
        if ab.abs() > 0.6 && ba.abs() > 0.6 && diagonal[a].abs() < 0.4 && diagonal[b].abs() < 0.4 {
            found.push(SetupFinding {
                sensor: "inertial unit",
                is_certain: true,
                found: format!(
                    "gyro {} turns as the unit's own attitude does about {}, and gyro {} as about {} \
                     ({ab:.2} and {ba:.2} times as fast)",
                    NAMES[b], NAMES[a], NAMES[a], NAMES[b]
                ),
                cause: "two axes of the unit swapped".into(),
                mend: format!("swap the columns of {} and {}, or set axes under [imu]", NAMES[a], NAMES[b]),
            });
            return true;
        }
    }
    let off = diagonal.iter().find(|scale| !(0.6..1.6).contains(*scale));
    if let Some(scale) = off {
        found.push(SetupFinding {
            sensor: "inertial unit",
            is_certain: false,
            found: format!(
                "the unit's own attitude turns {scale:.2} times as fast as its gyros, expected 1"
            ),
            cause: "gyros of a wrong range or unit".into(),
            mend: String::new(),
        });
    }
    true
}

/// Gravity turns in the body as the gyros say, the other way; where it hardly turns while the gyros
/// say it goes round and round, they are in °/s.
fn against_gravity(log: &Judged<'_>, found: &mut Vec<SetupFinding>) {
    let means = log.means(OVER_S);
    let (mut predicted, mut seen, mut count) = (0.0, 0.0, 0.0);
    for pair in means.windows(2) {
        let force = pair[0].force_mps2;
        let size = norm(force).max(1e-9);
        let [x, y, z] = force.map(|component| component / size);
        let mid = [0, 1, 2].map(|axis| 0.5 * (pair[0].turn_radps[axis] + pair[1].turn_radps[axis]));
        let [p, q, r] = mid;
        let turned = norm([q * z - r * y, r * x - p * z, p * y - q * x]) * OVER_S;
        let change = [0, 1, 2].map(|axis| (pair[1].force_mps2[axis] - force[axis]) / size);
        predicted += turned * turned;
        seen += norm(change).powi(2);
        count += 1.0;
    }
    let (predicted, seen) = ((predicted / count).sqrt(), (seen / count).sqrt());
    // Half a radian in half a second, all the time, is no flight.
    if predicted > 0.5 && seen < 0.3 * predicted.min(2.0) {
        found.push(SetupFinding {
            sensor: "inertial unit",
            is_certain: true,
            found: format!(
                "the gyros say that the unit tilts by {predicted:.1} rad each {OVER_S} s, while gravity \
                 turns by {seen:.2} rad"
            ),
            cause: "angular rates in °/s, expected rad/s".into(),
            mend: "write gyro_unit = \"degps\" under [imu] in dataset.toml".into(),
        });
    }
}
