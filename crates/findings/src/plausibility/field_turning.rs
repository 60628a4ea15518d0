//! Check of the magnetometer against the gyros: the Earth's field does not turn with the vehicle.

use hovernav::frames::{Body, Rotation, Vector};
use hovernav::time::Time;

use crate::finding::{Sensor, SetupFinding};
use crate::rates::Rates;

/// Interval of the stored attitudes, s.
const NOTED_S: f64 = 0.05;
/// Interval over which fields are compared, s: longer than the lag of a magnetometer, too short for gyro drift.
const OVER_S: f64 = 1.0;
/// Smallest turn that is compared, rad.
const MIN_TURN_RAD: f64 = 0.03;
/// Smallest number of comparisons for a judgement.
const MIN: usize = 30;
/// Smallest sum of the squared relative changes of the field.
const MIN_TURNED: f64 = 0.2;
/// Largest squared residual of the right order and signs, relative to that of the present ones.
const BETTER: f64 = 0.2;
/// Largest squared residual of the right order and signs, relative to the field's changes.
const EXPLAINED: f64 = 0.3;
/// Largest squared residual with one gyro reversed, relative to that with other magnetometer axes, at which the gyro is
/// the cause.
const CLEARLY: f64 = 0.5;
/// Interval between samples above which a turn may be missed, s.
const GAP_S: f64 = 0.3;

/// Orders and signs of a magnetometer's axes to be tried. A change of all three signs at once cannot be observed, so
/// the list has one of each such pair.
const OTHERS: [([usize; 3], [f64; 3], &str); 7] = [
    ([0, 1, 2], [-1.0, 1.0, 1.0], "x of the wrong sign, or y and z"),
    ([0, 1, 2], [1.0, -1.0, 1.0], "y of the wrong sign, or x and z"),
    ([0, 1, 2], [1.0, 1.0, -1.0], "z of the wrong sign, or x and y"),
    ([1, 0, 2], [1.0, 1.0, 1.0], "x and y swapped"),
    ([1, 0, 2], [1.0, 1.0, -1.0], "x and y swapped and z of the wrong sign"),
    ([0, 2, 1], [1.0, 1.0, 1.0], "y and z swapped"),
    ([2, 1, 0], [1.0, 1.0, 1.0], "x and z swapped"),
];

/// Turns according to the gyros, and the magnetic fields measured during them.
#[derive(Default)]
pub(super) struct FieldTurning {
    /// Rotation from the current body axes to the first ones, from the gyros alone.
    body_to_start: Option<(Time, Rotation<Body, Body>)>,
    noted: Vec<(Time, Rotation<Body, Body>)>,
    fields: Vec<(Time, Vector<Body>)>,
}

impl FieldTurning {
    /// Adds a sample's rates, and the field that came with it.
    pub fn push(&mut self, at: &Rates, field_gauss: Option<Vector<Body>>) {
        let turn = Vector::<Body>::from(at.turn_radps) * at.interval_s;
        let body_to_start = match self.body_to_start {
            Some((before, body_to_start)) if at.time - before < GAP_S => {
                body_to_start.turned_in_from(turn)
            }
            // Attitudes on both sides of a gap are never compared.
            Some((_, body_to_start)) => body_to_start,
            None => Rotation::IDENTITY,
        };
        self.body_to_start = Some((at.time, body_to_start));
        let is_due = |last: &(Time, _)| at.time - last.0 >= NOTED_S;
        if self.noted.last().is_none_or(is_due) {
            self.noted.push((at.time, body_to_start));
            self.fields.extend(field_gauss.map(|field| (at.time, field)));
        }
    }

    /// Judges the magnetometer's axes by the fields `apart` of a separate magnetometer, otherwise by the fields that
    /// came with the samples.
    pub fn check(&self, apart: &[(Time, Vector<Body>)], found: &mut Vec<SetupFinding>) {
        let fields = if apart.is_empty() { &self.fields[..] } else { apart };
        let mut left = [0.0; 1 + OTHERS.len()];
        // Residuals with one gyro of the opposite sign.
        let mut left_reversed = [0.0; 3];
        let (mut turned, mut count) = (0.0, 0);
        let mut before: Option<(Time, Rotation<Body, Body>, Vector<Body>)> = None;
        for &(time, field) in fields {
            if before.is_some_and(|(then, ..)| time - then < OVER_S) || !field.is_finite() {
                continue;
            }
            let Some(body_to_start) = self.at(time) else { continue };
            let last = before.replace((time, body_to_start, field));
            let Some((then, from, old)) = last.filter(|last| time - last.0 < 2.0 * OVER_S) else {
                continue;
            };
            let turn = body_to_start.inverse() * from;
            let strength = field.norm() * old.norm();
            if turn.rotation_vector().norm() < MIN_TURN_RAD
                || strength == 0.0
                || self.gap(then, time)
            {
                continue;
            }
            let off = |read: &dyn Fn(Vector<Body>) -> Vector<Body>| {
                let off = read(field) - turn * read(old);
                off.dot(off) / strength
            };
            left[0] += off(&|field| field);
            for (left, (order, signs, _)) in left[1..].iter_mut().zip(&OTHERS) {
                *left += off(&|field| {
                    let values = field.to_array();
                    [0, 1, 2].map(|axis| signs[axis] * values[order[axis]]).into()
                });
            }
            for (axis, left) in left_reversed.iter_mut().enumerate() {
                // The axis of the turn hardly moves within a second.
                let mut angle_rad = turn.rotation_vector().to_array();
                angle_rad[axis] = -angle_rad[axis];
                let turn = Rotation::<Body, Body>::IDENTITY.turned_in_from(angle_rad.into());
                let off = field - turn * old;
                *left += off.dot(off) / strength;
            }
            turned += (field - old).dot(field - old) / strength;
            count += 1;
        }
        let [present, others @ ..] = left;
        let best = others.iter().zip(&OTHERS).min_by(|a, b| a.0.total_cmp(b.0));
        let Some((&best, (.., name))) = best else { return };
        let is_right = |left: f64| left <= BETTER * present && left <= EXPLAINED * turned;
        if count < MIN || turned < MIN_TURNED {
            return;
        }
        let share = |left: f64| 100.0 * (left / turned).sqrt();
        let [x, y, z] = left_reversed;
        let reversed =
            [(x, "x"), (y, "y"), (z, "z")].into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((left, name)) =
            reversed.filter(|(left, _)| is_right(*left) && *left < CLEARLY * best)
        {
            found.push(SetupFinding {
                sensor: Sensor::InertialUnit,
                is_certain: false,
                found: format!(
                    "the gyros turn unlike the field (they leave {:.0} % of its turning, and {:.0} % with gyro {name} \
                     reversed)",
                    share(present),
                    share(left)
                ),
                cause: format!("gyro {name} of the wrong sign"),
                mend: format!("change the sign of gyro_{name}_radps"),
            });
            return;
        }
        if !is_right(best) {
            return;
        }
        found.push(SetupFinding {
            sensor: Sensor::Magnetometer,
            is_certain: true,
            found: format!(
                "the field turns unlike the gyros (they leave {:.0} % of its turning, and {:.0} % with other \
                 magnetometer axes)",
                share(present),
                share(best)
            ),
            cause: format!("magnetometer {name}, or the gyros' axes"),
            mend: "correct these columns".into(),
        });
    }

    /// Last attitude stored at or before `time`. `None` if it is missing or its age is at least `GAP_S`.
    fn at(&self, time: Time) -> Option<Rotation<Body, Body>> {
        let later = self.noted.partition_point(|(noted, _)| *noted <= time);
        let (noted, body_to_start) = *self.noted.get(later.checked_sub(1)?)?;
        (time - noted < GAP_S).then_some(body_to_start)
    }

    /// Whether a gap between two times may hide a turn.
    fn gap(&self, from: Time, to: Time) -> bool {
        let first = self.noted.partition_point(|(noted, _)| *noted < from).saturating_sub(1);
        let notes =
            self.noted[first..].iter().map(|(noted, _)| *noted).take_while(|noted| *noted <= to);
        notes.collect::<Vec<_>>().windows(2).any(|pair| pair[1] - pair[0] >= GAP_S)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::imu::ImuAxes;

    /// Findings for a minute of swaying about all axes, with a hard iron of a third of the field. `read` maps the true
    /// field to the readings.
    fn found(read: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<SetupFinding> {
        found_with([1.0; 3], read)
    }

    /// Findings as in [`found`], with the gyros multiplied by `signs`.
    fn found_with(signs: [f64; 3], read: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<SetupFinding> {
        let mut turning = FieldTurning::default();
        let mut body_to_earth = Rotation::<Body, Body>::IDENTITY;
        for step in 0..6000_u32 {
            let seconds = 0.01 * f64::from(step);
            let turn_radps =
                [0.4 * seconds.sin(), 0.3 * (0.7 * seconds).cos(), 0.6 * (0.3 * seconds).sin()];
            body_to_earth = body_to_earth.turned_in_from(Vector::from(turn_radps) * 0.01);
            let field = body_to_earth.inverse() * Vector::new(0.2, 0.0, 0.43);
            let field = field + Vector::new(0.05, -0.1, 0.1);
            let rates = Rates {
                time: Time::ZERO + seconds,
                interval_s: 0.01,
                turn_radps: [0, 1, 2].map(|axis| signs[axis] * turn_radps[axis]),
                force_mps2: [0.0, 0.0, -9.8],
                clipped: ImuAxes::default(),
            };
            turning.push(&rates, Some(read(field.to_array()).into()));
        }
        let mut found = Vec::new();
        turning.check(&[], &mut found);
        found
    }

    #[test]
    fn axes_in_the_wrong_order_or_of_the_wrong_sign_are_named() {
        let swapped = found(|[x, y, z]| [y, x, z]);
        assert!(swapped[0].cause.contains("x and y swapped"), "{swapped:?}");
        let turned = found(|[x, y, z]| [x, -y, z]);
        assert!(turned[0].cause.contains("y of the wrong sign"), "{turned:?}");
    }

    #[test]
    fn one_gyro_of_the_wrong_sign_is_named() {
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let mut signs = [1.0; 3];
            signs[axis] = -1.0;
            let findings = found_with(signs, |field| field);
            assert!(findings[0].mend.contains(&format!("sign of gyro_{name}_")), "{findings:?}");
        }
    }

    #[test]
    fn right_ones_are_not_even_all_of_the_other_sign_or_another_unit() {
        assert!(found(|field| field).is_empty());
        assert!(found(|field| field.map(|part| -50.0 * part)).is_empty());
    }
}
