//! Check of the barometer's heights against those of the fixes: units and sign.

use std::collections::BTreeMap;
use std::ops::Range;

use super::fixes::HEIGHT_IN_FEET;
use super::regression::Scale;
use crate::finding::{Sensor, SetupFinding};
use hovernav_dataset::Dataset;

/// Length of the parts over which heights are averaged, s; changes between successive parts are compared.
const PART_S: f64 = 10.0;
/// Smallest number of changes that are compared.
const MIN_COUNT: usize = 6;
/// Smallest rms of the changes of the fixes' heights, m.
const MIN_M: f64 = 1.5;
/// Smallest fraction of the fixes' height changes that the barometer explains.
const EXPLAINED: f64 = 0.7;
/// Smallest deviation of the scale from 1, in one-sigmas.
const SIGMAS: f64 = 6.0;

/// Scales, the sensor at fault, and the cause with the remedy.
type Cause = (Range<f64>, Sensor, (&'static str, &'static str));

const fn barometer(scales: Range<f64>, cause: &'static str, mend: &'static str) -> Cause {
    (scales, Sensor::Barometer, (cause, mend))
}

/// Likely contents of a column: range of the scale, description, remedy. The scale is the change of the fixes' heights
/// divided by the change of the column.
const CAUSES: [Cause; 9] = [
    (2.7..4.0, Sensor::Gps, HEIGHT_IN_FEET),
    barometer(0.25..0.37, "altitude_m in feet, expected metres", "multiply altitude_m by 0.3048"),
    barometer(
        0.0085..0.0115,
        "altitude_m in centimetres, expected metres",
        "divide altitude_m by 100",
    ),
    barometer(
        0.000_85..0.001_15,
        "altitude_m in millimetres, expected metres",
        "divide altitude_m by 1000",
    ),
    barometer(-1.3..-0.75, "a height that counts downwards", "change the sign of altitude_m"),
    barometer(
        -0.37..-0.25,
        "a height in feet that counts downwards",
        "multiply altitude_m by -0.3048",
    ),
    barometer(
        -130.0..-70.0,
        "a pressure in kPa, expected a height",
        "name the column pressure_pa and multiply it by 1000",
    ),
    barometer(
        -13.0..-7.0,
        "a pressure in hPa, expected a height",
        "name the column pressure_pa and multiply it by 100",
    ),
    barometer(-0.13..-0.07, "a pressure in Pa, expected a height", "name the column pressure_pa"),
];

/// Change of the fixes' heights divided by that of the barometer's heights: 1 if their units agree. `None` if the
/// vehicle climbs too little to decide, or if the two are not proportional.
#[must_use]
pub fn barometer_scale(dataset: &Dataset) -> Option<f64> {
    scale(dataset).map(|found| found.scale)
}

fn scale(dataset: &Dataset) -> Option<Scale> {
    let changes = changes(dataset);
    let squares: f64 = changes.iter().map(|(_, fixes)| fixes * fixes).sum();
    if changes.len() < MIN_COUNT || (squares / changes.len() as f64).sqrt() < MIN_M {
        return None;
    }
    // The barometer is the independent variable of the regression, because it scatters less.
    Scale::of(&changes).filter(|found| found.explained >= EXPLAINED)
}

pub(super) fn check(dataset: &Dataset, found: &mut Vec<SetupFinding>) {
    let Some(Scale { scale, sigma, .. }) = scale(dataset) else { return };
    if (scale - 1.0).abs() < SIGMAS * sigma {
        return;
    }
    let Some((_, sensor, (cause, mend))) = CAUSES.iter().find(|(range, ..)| range.contains(&scale))
    else {
        return;
    };
    // The vertical velocity may have shown it too.
    if found.iter().any(|known| known.cause == *cause) {
        return;
    }
    found.push(SetupFinding {
        sensor: *sensor,
        is_certain: true,
        found: format!(
            "the heights of the fixes change by {scale:.3} times the change of the barometer's (one-sigma {sigma:.3}), \
             expected 1"
        ),
        cause: (*cause).into(),
        mend: (*mend).into(),
    });
}

/// Changes of the barometer's height and of the fixes' height between successive parts of the log, m.
fn changes(dataset: &Dataset) -> Vec<(f64, f64)> {
    let part = |time_s: f64| (time_s / PART_S).floor() as i64;
    let baro = dataset.baro.iter().map(|(time, height_m)| (part(time.seconds()), *height_m));
    let fixes = dataset.fixes.iter().filter(|fix| !fix.two_dimensional);
    let fixes = fixes.map(|fix| (part(fix.time.seconds()), fix.position.height_m));
    let (baro, fixes) = (means(baro), means(fixes));
    let change = |of: &BTreeMap<i64, (f64, f64)>, part: i64| {
        let mean = |part: i64| of.get(&part).map(|(sum, count)| sum / count);
        Some(mean(part + 1)? - mean(part)?)
    };
    baro.keys().filter_map(|&part| Some((change(&baro, part)?, change(&fixes, part)?))).collect()
}

/// Sum and count of the values of each part.
fn means(values: impl Iterator<Item = (i64, f64)>) -> BTreeMap<i64, (f64, f64)> {
    let mut parts = BTreeMap::new();
    for (part, value) in values {
        let (sum, count) = parts.entry(part).or_insert((0.0, 0.0));
        *sum += value;
        *count += 1.0;
    }
    parts
}
