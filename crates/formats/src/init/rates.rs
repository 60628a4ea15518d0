//! Units of gyros whose names state none: multiples of rad/s, and counts of the usual ranges.

use super::travel::StatedUnits;
use crate::text::{RateUnit, Triad};

/// Units of gyros whose names do not state them.
const UNITS: [RateUnit; 5] = [
    RateUnit::RadiansPerSecond,
    RateUnit::DegreesPerSecond,
    RateUnit::MilliradiansPerSecond,
    RateUnit::CentidegreesPerSecond,
    RateUnit::MillidegreesPerSecond,
];
/// Counts per °/s of the usual gyros: ranges of 2000 to 250 °/s in 16 bits, and counts of 0.07 to 0.00875 °/s.
const COUNTS: [f64; 8] = [16.4, 32.8, 65.5, 131.0, 14.286, 28.571, 57.143, 114.286];

/// Beginning of the check of a gyro whose unit is not stated.
pub(super) const GYRO_UNSTATED: &str = "gyro: rates reach";

/// The 99th percentile of the rate of a vehicle that flies, rad/s: from a calm hover to the limit of gyros.
pub(super) const HIGH_RADPS: std::ops::Range<f64> = 0.03..40.0;

/// Unit of the values of a gyro, which may be counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rate {
    pub unit: RateUnit,
    pub counts_per_unit: f64,
}

impl Rate {
    /// Counts of a gyro with the widest of the usual ranges.
    pub const WIDEST: Self = Self::counts(COUNTS[0]);

    const fn counts(counts_per_unit: f64) -> Self {
        Self { unit: RateUnit::DegreesPerSecond, counts_per_unit }
    }

    pub const fn plain(unit: RateUnit) -> Self {
        Self { unit, counts_per_unit: 1.0 }
    }

    pub fn of(gyro: &Triad<RateUnit>) -> Self {
        Self { unit: gyro.unit, counts_per_unit: gyro.counts_per_unit }
    }

    pub fn give(self, gyro: &mut Triad<RateUnit>) {
        (gyro.unit, gyro.counts_per_unit) = (self.unit, self.counts_per_unit);
    }

    /// Value in rad/s of 1.
    pub fn factor(self) -> f64 {
        self.unit.factor() / self.counts_per_unit
    }

    pub fn name(self) -> String {
        match self.counts_per_unit {
            1.0 => self.unit.name().to_owned(),
            counts => format!("counts, {counts} per {}", self.unit.name()),
        }
    }

    /// The rates that the values of `gyro` may have. Whole numbers may be counts, and are if those of the accelerometer
    /// are.
    pub fn candidates(gyro: &Triad<RateUnit>, stated: StatedUnits) -> Vec<Self> {
        let counts_per_unit = if stated.gyro { gyro.counts_per_unit } else { 1.0 };
        let plain = UNITS.map(|unit| Self { unit, counts_per_unit });
        let counts = COUNTS.map(Self::counts);
        if !stated.gyro && gyro.counts_per_unit != 1.0 {
            counts.to_vec()
        } else if stated.is_gyro_whole {
            [&plain[..], &counts[..]].concat()
        } else {
            plain.to_vec()
        }
    }
}

/// The unit of a gyro whose 99th percentile of the rate is `high`.
pub(super) fn by_size(high: f64) -> RateUnit {
    match high {
        // A rate of 7 rad/s is 400 °/s, a violent turn; 7 °/s is a calm one.
        ..=7.0 => RateUnit::RadiansPerSecond,
        // No gyro measures more than 4000 °/s.
        ..=4e3 => RateUnit::DegreesPerSecond,
        _ => RateUnit::MillidegreesPerSecond,
    }
}

/// The check of a gyro whose names state no unit: the highest rate in `rate`, and in every other unit in which it is that
/// of a vehicle.
pub(super) fn unstated(high: f64, rate: Rate) -> String {
    let high_degps = |rate: &Rate| (high * rate.factor()).to_degrees();
    let is_possible = |other: &Rate| {
        // A gyro in rad/s is most often mistaken for one in °/s. So °/s is listed even where its rates are low.
        let is_usual = high <= 7.0 && other.unit == RateUnit::DegreesPerSecond;
        *other != rate && (is_usual || HIGH_RADPS.contains(&(high * other.factor())))
    };
    let all = match rate.counts_per_unit {
        1.0 => UNITS.map(Rate::plain).to_vec(),
        _ => COUNTS[..4].iter().map(|counts| Rate::counts(*counts)).collect(),
    };
    let others = all.into_iter().filter(is_possible);
    let others = others.map(|other| format!("{} ({:.2} deg/s)", other.name(), high_degps(&other)));
    let others = others.collect::<Vec<_>>().join(" or ");
    let others = if others.is_empty() { "in another unit".to_owned() } else { others };
    format!(
        "{GYRO_UNSTATED} {high:.2}, read as {} ({:.2} deg/s); if they are {others}, set that unit under \
         [table.gyro]",
        rate.name(),
        high_degps(&rate)
    )
}
