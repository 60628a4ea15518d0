//! Faults of the inertial unit.

use std::f64::consts::{PI, TAU};

use hovernav::earth::STANDARD_GRAVITY_MPS2;

use super::catalogue::Kind;
use super::fault::Fault;
use super::shaking::Vibration;
use super::table::Table;
use super::window::Window;
use crate::noise::Noise;

const RATES: [&str; 6] = [
    "gyro_x_radps",
    "gyro_y_radps",
    "gyro_z_radps",
    "accel_x_mps2",
    "accel_y_mps2",
    "accel_z_mps2",
];
const INCREMENTS: [&str; 6] =
    ["dtheta_x_rad", "dtheta_y_rad", "dtheta_z_rad", "dvel_x_mps", "dvel_y_mps", "dvel_z_mps"];

const GYRO: [usize; 3] = [0, 1, 2];
const ACCEL: [usize; 3] = [3, 4, 5];

/// The table `imu.csv`, with the columns of gyros and accelerometers.
pub(super) struct Inertial<'a> {
    table: &'a mut Table,
    time: usize,
    /// Columns of the three gyros and the three accelerometers.
    axes: [usize; 6],
    /// Duration that each row's value covers, s: the time since the previous sample for increments, 1 for rates.
    interval_s: Vec<f64>,
    median_s: f64,
}

impl<'a> Inertial<'a> {
    /// The columns of the gyros and accelerometers in `table`; `None` if they are missing.
    pub fn of(table: &'a mut Table) -> Option<Self> {
        let time = table.column("t_s")?;
        let rates = table.columns(RATES);
        let axes = rates.or_else(|| table.columns(INCREMENTS))?;
        let times: Vec<f64> = (0..table.len()).map(|row| table.get(row, time)).collect();
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.retain(|step| *step > 0.0);
        steps.sort_by(f64::total_cmp);
        let median_s = steps.get(steps.len() / 2).copied().unwrap_or(0.01);
        let step = |row: usize| match row.checked_sub(1).map(|before| times[row] - times[before]) {
            Some(step) if step > 0.0 => step,
            _ => median_s,
        };
        let interval_s =
            (0..times.len()).map(|row| if rates.is_some() { 1.0 } else { step(row) }).collect();
        Some(Self { table, time, axes, interval_s, median_s })
    }

    /// Applies `fault`; false where it is not a fault of the inertial unit.
    pub fn make(&mut self, fault: &Fault, window: Window, noise: &mut Noise) -> bool {
        let rows = self.table.rows_in(window);
        let number = fault.number;
        match fault.kind {
            Kind::Vibration => self.vibrate(&rows, number, noise),
            Kind::ClipAccel => self.clip(&rows, ACCEL, number * STANDARD_GRAVITY_MPS2),
            Kind::ClipGyro => self.clip(&rows, GYRO, number.to_radians()),
            Kind::ClipBurst => self.burst(&rows, number * STANDARD_GRAVITY_MPS2, noise),
            Kind::Stuck => self.stick(&rows, fault.word),
            Kind::Gap => rows.iter().for_each(|row| self.table.drop_row(*row)),
            Kind::Interpolated => self.interpolate(&rows),
            Kind::PacketLoss => {
                for row in rows {
                    if noise.uniform() < 0.01 * number {
                        self.table.drop_row(row);
                    }
                }
            }
            Kind::Jitter => self.jitter(&rows, 1e-3 * number, noise),
            Kind::GyroBias => self.add(&rows, GYRO, noise.direction(), number.to_radians()),
            Kind::AccelBias => self.add(&rows, ACCEL, noise.direction(), number),
            Kind::AccelScale => self.scale(&rows, ACCEL, [number; 3]),
            Kind::AccelSign => self.scale(&rows, ACCEL, signs(fault.word)),
            Kind::GyroSign => self.scale(&rows, GYRO, signs(fault.word)),
            Kind::SwapAxes => self.swap(&rows, fault.word),
            Kind::Unit if fault.word == "g" => {
                self.scale(&rows, ACCEL, [1.0 / STANDARD_GRAVITY_MPS2; 3]);
            }
            Kind::Unit => self.scale(&rows, GYRO, [180.0 / PI; 3]),
            _ => return false,
        }
        true
    }

    /// Changes one axis of one row. `change` receives its value and the duration of the sample, s (1 for rates).
    fn change(&mut self, row: usize, axis: usize, change: impl FnOnce(f64, f64) -> f64) {
        let interval_s = self.interval_s[row];
        self.table.change(row, self.axes[axis], |value| change(value, interval_s));
    }

    fn add(&mut self, rows: &[usize], axes: [usize; 3], direction: [f64; 3], size: f64) {
        for &row in rows {
            for (axis, part) in axes.into_iter().zip(direction) {
                self.change(row, axis, |value, interval_s| value + size * part * interval_s);
            }
        }
    }

    fn scale(&mut self, rows: &[usize], axes: [usize; 3], factors: [f64; 3]) {
        for &row in rows {
            for (axis, factor) in axes.into_iter().zip(factors) {
                if factor != 1.0 {
                    self.change(row, axis, |value, _| factor * value);
                }
            }
        }
    }

    fn clip(&mut self, rows: &[usize], axes: [usize; 3], range: f64) {
        for &row in rows {
            for axis in axes {
                self.change(row, axis, |value, interval_s| {
                    value.clamp(-range * interval_s, range * interval_s)
                });
            }
        }
    }

    /// Adds a tone of 1.2 times the range to each accelerometer, then limits the sum to the range. The random frequency
    /// is between 1/5 and 9/20 of the sampling rate, and the phase of each axis is random. The tone integrates to
    /// almost zero, except for the part that the limit removes on one side.
    fn burst(&mut self, rows: &[usize], range: f64, noise: &mut Noise) {
        let turn_rad = TAU * (0.2 + 0.25 * noise.uniform());
        let phases_rad = [(); 3].map(|()| TAU * noise.uniform());
        for (place, &row) in rows.iter().enumerate() {
            for (axis, phase_rad) in ACCEL.into_iter().zip(phases_rad) {
                let shaking = 1.2 * range * (phase_rad + turn_rad * place as f64).sin();
                self.change(row, axis, |value, interval_s| {
                    (value / interval_s + shaking).clamp(-range, range) * interval_s
                });
            }
        }
    }

    fn stick(&mut self, rows: &[usize], word: &str) {
        let [Some(&first), Some(_)] = [rows.first(), rows.last()] else { return };
        let last = first.saturating_sub(1);
        let columns: Vec<usize> = match word {
            "gyro" => GYRO.map(|axis| self.axes[axis]).to_vec(),
            "accel" => ACCEL.map(|axis| self.axes[axis]).to_vec(),
            "all" => (self.axes.into_iter())
                .chain(
                    ["roll_deg", "pitch_deg", "yaw_deg"]
                        .iter()
                        .filter_map(|n| self.table.column(n)),
                )
                .chain(super::magnetic::FIELD.iter().filter_map(|n| self.table.column(n)))
                .collect(),
            axis => {
                let names = ["gx", "gy", "gz", "ax", "ay", "az"];
                let place = names.iter().position(|name| *name == axis);
                place.map(|axis| self.axes[axis]).into_iter().collect()
            }
        };
        for column in columns {
            let held = self.table.get(last, column);
            for &row in rows {
                self.table.change(row, column, |_| held);
            }
        }
    }

    /// Interpolates linearly between the row before and the row after.
    fn interpolate(&mut self, rows: &[usize]) {
        let [Some(&first), Some(&last)] = [rows.first(), rows.last()] else { return };
        let ends = [first.saturating_sub(1), (last + 1).min(self.table.len() - 1)];
        let [from_s, to_s] = ends.map(|row| self.table.get(row, self.time));
        for axis in self.axes {
            let [from, to] = ends.map(|row| self.table.get(row, axis));
            for &row in rows {
                let share = (self.table.get(row, self.time) - from_s) / (to_s - from_s);
                self.table.change(row, axis, |_| from + share * (to - from));
            }
        }
    }

    fn swap(&mut self, rows: &[usize], pair: &str) {
        let place = |letter: u8| usize::from(letter.saturating_sub(b'x'));
        let [Some(a), Some(b)] =
            [pair.bytes().next(), pair.as_bytes().get(1).copied()].map(|l| l.map(place))
        else {
            return;
        };
        for &row in rows {
            for triad in [GYRO, ACCEL] {
                let (a, b) = (self.axes[triad[a]], self.axes[triad[b]]);
                let (first, second) = (self.table.get(row, a), self.table.get(row, b));
                self.table.change(row, a, |_| second);
                self.table.change(row, b, |_| first);
            }
        }
    }

    /// Scatters the time stamps, each at most half-way to its neighbour.
    fn jitter(&mut self, rows: &[usize], sigma_s: f64, noise: &mut Noise) {
        let times: Vec<f64> =
            (0..self.table.len()).map(|row| self.table.get(row, self.time)).collect();
        for &row in rows {
            let step = |other: Option<usize>| {
                let other = other.and_then(|other| times.get(other)).copied();
                other.map_or(self.median_s, |other| (times[row] - other).abs())
            };
            let room_s = 0.49 * step(row.checked_sub(1)).min(step(Some(row + 1)));
            let error_s = (sigma_s * noise.normal()).clamp(-room_s, room_s);
            let time_s = ((times[row] + error_s) * 1e9).round() * 1e-9;
            self.table.set(row, self.time, time_s);
        }
    }

    /// Multiplies the vibration by `factor`.
    fn vibrate(&mut self, rows: &[usize], factor: f64, noise: &mut Noise) {
        let vibration = Vibration::drawn(factor, self.median_s, noise);
        let (Some(&first), Some(&last)) = (rows.first(), rows.last()) else { return };
        let all = self.table.rows_in(Window::ALL);
        for column in self.axes {
            let is_known = |row: &usize| self.table.get(*row, column).is_finite();
            let known: Vec<usize> = all.iter().copied().filter(is_known).collect();
            let values: Vec<f64> = known.iter().map(|row| self.table.get(*row, column)).collect();
            let within = known.partition_point(|row| *row < first)
                ..known.partition_point(|row| *row <= last);
            for (place, added) in within.clone().zip(vibration.added(&values, within)) {
                if added != 0.0 {
                    self.table.change(known[place], column, |value| value + added);
                }
            }
        }
    }
}

/// Factor of each axis: −1 for the axes in `word`, 1 for the others.
fn signs(word: &str) -> [f64; 3] {
    ['x', 'y', 'z'].map(|axis| if word.contains(axis) { -1.0 } else { 1.0 })
}
