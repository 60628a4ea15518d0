//! Merging of rows with one time: batches of an inertial unit, or a clock coarser than the sample interval.

use crate::clock::Rows;
use crate::table::remarks::{REPEATED, Remarks};
use hovernav::imu::{ImuAxes, ImuSample, Motion};
use hovernav::time::Time;

/// Merged rows of one time, to which further rows of the same time can be added.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Batch<T> {
    line: u64,
    joined: T,
    last: T,
    rows: u32,
}

/// Type of rows that can be merged if their times are equal.
pub trait Join: Copy + PartialEq {
    /// Time of the sample.
    fn time(&self) -> Time;

    /// Access to the time of the sample.
    fn time_mut(&mut self) -> &mut Time;

    /// Merges `next` into `self`, which is merged from `rows` rows.
    #[must_use]
    fn joined(self, rows: u32, next: &Self) -> Self;
}

const TOGETHER: &str = "merged with the row before, at the same time";

impl<T: Join> Batch<T> {
    pub fn new(line: u64, row: T) -> Self {
        Self { line, joined: row, last: row, rows: 1 }
    }

    /// Merges the next row if it has the batch's time, otherwise returns it. A row identical to the one before is
    /// skipped.
    pub fn push(&mut self, line: u64, row: T, remarks: &mut Remarks) -> Option<(u64, T)> {
        if row.time() != self.last.time() {
            return Some((line, row));
        }
        if row == self.last {
            remarks.count(REPEATED, line);
        } else {
            remarks.count(TOGETHER, line);
            self.joined = self.joined.joined(self.rows, &row);
            self.rows += 1;
            self.last = row;
        }
        None
    }

    /// The line of the first row, and the merged row.
    pub fn row(&self) -> (u64, T) {
        (self.line, self.joined)
    }
}

impl<T: Join> Rows<T> {
    /// Merges successive rows of the same time: rates and forces are averaged, increments added. Rows identical to the
    /// one before are skipped.
    #[must_use]
    pub fn together(self, remarks: &mut Remarks) -> Self {
        let (mut together, mut batch) = (Self::new(), None::<Batch<T>>);
        for (line, row) in self.into_rows() {
            let other = match &mut batch {
                Some(batch) => batch.push(line, row, remarks),
                None => Some((line, row)),
            };
            if let Some((line, row)) = other
                && let Some(full) = batch.replace(Batch::new(line, row))
            {
                let (line, row) = full.row();
                together.push(line, row);
            }
        }
        if let Some((line, row)) = batch.map(|batch| batch.row()) {
            together.push(line, row);
        }
        together
    }
}

impl Join for ImuSample {
    fn time(&self) -> Time {
        self.time
    }

    fn time_mut(&mut self) -> &mut Time {
        &mut self.time
    }

    fn joined(self, rows: u32, next: &Self) -> Self {
        let share = 1.0 / f64::from(rows + 1);
        let motion = match (self.motion, next.motion) {
            (
                Motion::Rates { angular_rate_radps: rate, specific_force_mps2: force },
                Motion::Rates { angular_rate_radps, specific_force_mps2 },
            ) => Motion::Rates {
                angular_rate_radps: rate + (angular_rate_radps - rate) * share,
                specific_force_mps2: force + (specific_force_mps2 - force) * share,
            },
            (
                Motion::Increments { angle_rad: angle, velocity_mps: velocity },
                Motion::Increments { angle_rad, velocity_mps },
            ) => Motion::Increments {
                angle_rad: angle + angle_rad,
                velocity_mps: velocity + velocity_mps,
            },
            (motion, _) => motion,
        };
        Self {
            motion,
            attitude: next.attitude.or(self.attitude),
            magnetic_field_gauss: next.magnetic_field_gauss.or(self.magnetic_field_gauss),
            clipped: either(self.clipped, next.clipped),
            ..self
        }
    }
}

/// Axes at full scale in at least one of the two.
fn either(one: ImuAxes, other: ImuAxes) -> ImuAxes {
    let of = |one: [bool; 3], other: [bool; 3]| std::array::from_fn(|axis| one[axis] | other[axis]);
    ImuAxes { gyro: of(one.gyro, other.gyro), accel: of(one.accel, other.accel) }
}

impl Join for (Time, [f64; 3]) {
    fn time(&self) -> Time {
        self.0
    }

    fn time_mut(&mut self) -> &mut Time {
        &mut self.0
    }

    fn joined(mut self, rows: u32, next: &Self) -> Self {
        for (mean, value) in self.1.iter_mut().zip(next.1) {
            *mean += (value - *mean) / f64::from(rows + 1);
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::frames::Vector;

    fn together(
        motions: &[(i64, f64)],
        motion: fn(f64) -> Motion,
    ) -> (Vec<(i64, f64)>, Vec<String>) {
        let (mut rows, mut remarks) = (Rows::new(), Remarks::new("imu.csv"));
        for (line, (ms, value)) in (2..).zip(motions) {
            let time = Time::from_nanoseconds(ms * 1_000_000);
            rows.push(line, ImuSample::new(time, motion(*value)));
        }
        let rows = rows.together(&mut remarks).into_rows().map(|(_, sample)| {
            let (Motion::Rates { angular_rate_radps: vector, .. }
            | Motion::Increments { angle_rad: vector, .. }) = sample.motion;
            (sample.time.nanoseconds() / 1_000_000, vector.x())
        });
        (rows.collect(), remarks.into_warnings().collect())
    }

    fn rates(value: f64) -> Motion {
        let vector = Vector::new(value, 0.0, 0.0);
        Motion::Rates { angular_rate_radps: vector, specific_force_mps2: vector }
    }

    fn increments(value: f64) -> Motion {
        let vector = Vector::new(value, 0.0, 0.0);
        Motion::Increments { angle_rad: vector, velocity_mps: vector }
    }

    const BATCHES: [(i64, f64); 7] =
        [(0, 1.0), (0, 2.0), (0, 6.0), (10, 4.0), (20, 5.0), (20, 5.0), (20, 8.0)];

    #[test]
    fn rates_of_one_time_are_their_mean_and_increments_their_sum() {
        let (rows, warnings) = together(&BATCHES, rates);
        assert_eq!(rows, [(0, 3.0), (10, 4.0), (20, 6.5)]);
        assert_eq!(
            warnings,
            [
                "imu.csv: 3 rows, the first at line 3, merged with the row before, at the same time",
                "imu.csv: line 7 skipped: same time as the row before",
            ]
        );
        let (rows, _) = together(&BATCHES, increments);
        assert_eq!(rows, [(0, 9.0), (10, 4.0), (20, 13.0)]);
    }
}
