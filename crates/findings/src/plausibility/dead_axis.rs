//! Check for an axis of the inertial unit that never changes, or repeats another one.

use crate::finding::{Sensor, SetupFinding};
use crate::rates::{AXES, Rates};

/// Smallest number of samples from which an axis without any change is not connected.
const MIN: usize = 1000;

/// Changes of each axis in all samples.
#[derive(Default)]
pub(super) struct DeadAxis {
    last: Option<[f64; 6]>,
    count: usize,
    changes: [usize; 6],
    /// Number of samples in which each axis equals the next one of its triad.
    twins: [usize; 6],
}

impl DeadAxis {
    pub fn push(&mut self, rates: &Rates) {
        let values = rates.six();
        for (axis, twins) in self.twins.iter_mut().enumerate() {
            *twins += usize::from(values[axis] == values[next(axis)]);
        }
        if let Some(last) = self.last.replace(values) {
            self.count += 1;
            for (axis, changes) in self.changes.iter_mut().enumerate() {
                *changes += usize::from(values[axis] != last[axis]);
            }
        }
    }

    /// Reports each axis that is constant while the other two of its triad change, and each that repeats another one.
    pub fn check(&self, found: &mut Vec<SetupFinding>) {
        let Some(values) = self.last.filter(|_| self.count >= MIN) else { return };
        for (axis, changes) in self.changes.iter().enumerate() {
            let triad = &self.changes[axis / 3 * 3..][..3];
            if *changes > 0 || triad.iter().filter(|changes| 2 * **changes > self.count).count() < 2
            {
                continue;
            }
            found.push(SetupFinding {
                sensor: Sensor::InertialUnit,
                is_certain: false,
                found: format!(
                    "{} is {} in all {} samples, while the other two axes change",
                    AXES[axis], values[axis], self.count + 1
                ),
                cause: "the axis is not connected or not logged: its motion is missing from the solution".into(),
                mend: String::new(),
            });
        }
        for (axis, twins) in self.twins.iter().enumerate() {
            if 2 * self.changes[axis] <= self.count || *twins <= self.count {
                continue;
            }
            found.push(SetupFinding {
                sensor: Sensor::InertialUnit,
                is_certain: true,
                found: format!(
                    "{} equals {} in all {} samples",
                    AXES[axis],
                    AXES[next(axis)],
                    self.count + 1
                ),
                cause:
                    "one column was written twice, and the motion about the other axis is missing"
                        .into(),
                mend: "write the reading of each axis".into(),
            });
        }
    }
}

/// The next axis of the same triad.
const fn next(axis: usize) -> usize {
    axis / 3 * 3 + (axis + 1) % 3
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::imu::ImuAxes;
    use hovernav::time::Time;

    fn found(of: impl Fn(f64) -> [f64; 3]) -> Vec<SetupFinding> {
        let (mut axis, mut found) = (DeadAxis::default(), Vec::new());
        for sample in 0..2000 {
            let time_s = 0.01 * f64::from(sample);
            axis.push(&Rates {
                time: Time::from_seconds(time_s),
                interval_s: 0.01,
                turn_radps: of(time_s),
                force_mps2: [0.0, 0.0, -9.81],
                clipped: ImuAxes::NONE,
            });
        }
        axis.check(&mut found);
        found
    }

    #[test]
    fn an_axis_that_never_changes_while_the_others_do_is_named() {
        let dead = found(|t| [(3.0 * t).sin(), t.cos(), 0.0]);
        assert!(
            dead.len() == 1 && dead[0].found.contains("gyro z is 0 in all 2000 samples"),
            "{dead:?}"
        );
        let twice = found(|t| [t.cos(), (3.0 * t).sin(), (3.0 * t).sin()]);
        assert!(
            twice.len() == 1 && twice[0].found.contains("gyro y equals gyro z in all 2000"),
            "{twice:?}"
        );
        // Readings at rest of a coarse sensor, and a simulation in a plane.
        assert!(found(|_| [0.0; 3]).is_empty());
        assert!(found(|t| [0.0, 0.0, t.sin()]).is_empty());
    }
}
