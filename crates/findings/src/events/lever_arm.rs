//! A wrong lever arm of the antenna: the residuals of the fixes turn with the vehicle.

use hovernav::ekf::{Channel, Notice};
use hovernav::frames::{Body, Vector};
use hovernav::time::Time;

use super::judged::Judged;
use crate::finding::{Finding, FindingKind, Sensor, Severity};

/// Smallest error of the lever arm, m, that is a warning.
const MIN_M: f64 = 0.3;
/// Smallest error of the lever arm that is reported, in one-sigmas.
const SURE: f64 = 3.5;
/// Longest time between two fixes that are compared, s.
const LONGEST_S: f64 = 3.0;
/// Largest innovation, in one-sigmas, that a lever arm explains; a larger one is ignored.
const OUTLIER: f64 = 4.0;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let Some((size, words)) = found(log).or_else(|| left(log)) else { return };
    let (start_s, end_s) = log.span_s().unwrap_or_default();
    findings.push(
        Finding::warning(Sensor::Gps, FindingKind::LeverArm, (start_s, end_s), words)
            .severity(if size < MIN_M { Severity::Info } else { Severity::Warning }),
    );
}

/// Size of the antenna offset that the filter has estimated, m, with the sentence of the finding. The innovations no
/// longer show this offset.
fn found(log: &Judged<'_>) -> Option<(f64, String)> {
    let mut notices = log.run.notices.iter().filter_map(|notice| match *notice {
        Notice::AntennaOffsetFound { time, offset_m, .. } => Some((time.seconds(), offset_m)),
        _ => None,
    });
    let (since_s, first) = notices.next()?;
    let offset = notices.next_back().map_or(first, |(_, last)| last);
    let [x, y, z] = likely(log, offset);
    let size = offset.norm();
    // The filter may still be converging, so the estimated offset may be too small.
    let words = format!(
        "gps antenna seems to be {size:.1} m or more from its declared lever arm, as turns show; the filter has used \
         the corrected position since {since_s:.0} s; is [gps] antenna_lever_arm_m about [{x}, {y}, {z}]? Turns do \
         not show the height"
    );
    Some((size, words))
}

/// Size of the antenna offset that explains the innovations, m, with the sentence of the finding; `None` if it is not
/// significant.
fn left(log: &Judged<'_>) -> Option<(f64, String)> {
    let (arm, sigma_m) = missing_arm(log)?;
    let size = arm.norm();
    if size < MIN_M.max(SURE * sigma_m) {
        return None;
    }
    let [x, y, z] = likely(log, arm);
    let words = format!(
        "gps antenna seems to be {size:.1} m from its declared lever arm (one-sigma {sigma_m:.1} m), throughout: the \
         residuals of position and velocity turn with the vehicle; is [gps] antenna_lever_arm_m about [{x}, {y}, {z}]?"
    );
    Some((size, words))
}

/// Declared lever arm plus the offset, rounded to 0.1 m.
fn likely(log: &Judged<'_>, off: Vector<Body>) -> [f64; 3] {
    let declared = log.dataset.manifest.gps.antenna_lever_arm_m;
    (declared + off).to_array().map(|metres| (10.0 * metres).round() / 10.0)
}

/// Offset of the lever arm, body axes, m, that explains the innovations best, and its one-sigma.
///
/// An offset δ of the antenna adds C δ to the position and C (ω × δ) to the velocity. The filter follows the
/// fixes, so a position innovation contains only the change of C δ since the fix before.
fn missing_arm(log: &Judged<'_>) -> Option<(Vector<Body>, f64)> {
    let mut information = [[0.0; 3]; 3];
    let mut known = [0.0; 3];
    let (mut squares, mut count) = (0.0, 0.0);
    let mut before: Option<(f64, [[f64; 3]; 3])> = None;
    for report in log.run.reports() {
        let Some(time_s) = report.time().map(Time::seconds) else { continue };
        let Some(solution) = log.solution_at(time_s) else { continue };
        let rate = solution.angular_rate_radps;
        let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(Vector::from);
        let place = unit.map(|axis| (solution.body_to_ned * axis).to_array());
        let speed = unit.map(|axis| (solution.body_to_ned * rate.cross(axis)).to_array());
        if !report.innovations().any(|axis| axis.channel == Channel::PositionNorth) {
            continue;
        }
        let last = before.replace((time_s, place));
        let Some((_, earlier)) = last.filter(|(then_s, _)| time_s - then_s < LONGEST_S) else {
            continue;
        };
        let place: [[f64; 3]; 3] = std::array::from_fn(|column| {
            std::array::from_fn(|row| place[column][row] - earlier[column][row])
        });
        for axis in report.innovations() {
            let row = match axis.channel {
                Channel::PositionNorth => place.map(|column| column[0]),
                Channel::PositionEast => place.map(|column| column[1]),
                Channel::PositionDown => place.map(|column| column[2]),
                Channel::VelocityNorth => speed.map(|column| column[0]),
                Channel::VelocityEast => speed.map(|column| column[1]),
                Channel::VelocityDown => speed.map(|column| column[2]),
                _ => continue,
            };
            if axis.normalised().abs() > OUTLIER {
                continue;
            }
            let weight = 1.0 / (axis.sigma * axis.sigma);
            for i in 0..3 {
                for j in 0..3 {
                    information[i][j] += weight * row[i] * row[j];
                }
                known[i] += weight * row[i] * axis.innovation;
            }
            squares += axis.normalised().powi(2);
            count += 1.0;
        }
    }
    let inverse = inverse(&information)?;
    let arm: [f64; 3] = std::array::from_fn(|i| {
        inverse[i].iter().zip(known).map(|(entry, known)| entry * known).sum()
    });
    // Innovations larger than expected make the offset less certain in proportion.
    let scale = (squares / f64::max(count, 1.0)).max(1.0);
    let variance = (0..3).map(|axis| inverse[axis][axis]).fold(0.0, f64::max);
    (count > 200.0).then(|| (arm.into(), (scale * variance).sqrt()))
}

/// Inverse of a symmetric matrix, by cofactors; `None` if it is singular.
fn inverse(m: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let cofactor = |i: usize, j: usize| {
        let [a, b] = [(i + 1) % 3, (i + 2) % 3];
        let [c, d] = [(j + 1) % 3, (j + 2) % 3];
        m[a][c] * m[b][d] - m[a][d] * m[b][c]
    };
    let determinant: f64 = (0..3).map(|j| m[0][j] * cofactor(0, j)).sum();
    let size = m[0][0] * m[1][1] * m[2][2];
    (determinant > 1e-9 * size.abs() && determinant > 0.0)
        .then(|| std::array::from_fn(|i| std::array::from_fn(|j| cofactor(j, i) / determinant)))
}
