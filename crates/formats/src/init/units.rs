//! Units that no name states: those with which the readings agree.

use super::travel::{self, StatedUnits};
use super::turn::{self, DISAGREES, Found};
use crate::text::{BaroUnit, GpsColumns, LengthUnit, Mapping, RateUnit, SpeedUnit};
use hovernav::imu::Motion;
use hovernav_dataset::Dataset;
use hovernav_dataset::statistics::quantile;
use hovernav_findings::barometer_scale;

/// Factor by which the innovations with one unit must be smaller than with all others, in mean squares.
const DECISIVE: f64 = 2.0;
/// Mean square of the normalised innovations of the height below which the height fits.
const FITS: f64 = 2.0;
/// Largest ratio of a measured scale to that of a unit of height, or its inverse; metres and feet differ by 3.28.
const HEIGHT_TOLERANCE: f64 = 1.4;
/// Largest ratio of a measured scale to that of a unit of vertical speed, or its inverse; the units differ by 1.97.
const CLIMB_TOLERANCE: f64 = 1.3;

const HEIGHTS: [LengthUnit; 2] = [LengthUnit::Metres, LengthUnit::Feet];
const CLIMBS: [SpeedUnit; 5] = [
    SpeedUnit::MetresPerSecond,
    SpeedUnit::CentimetresPerSecond,
    SpeedUnit::MillimetresPerSecond,
    SpeedUnit::FeetPerSecond,
    SpeedUnit::FeetPerMinute,
];
/// Units of gyros whose names do not state them.
pub(super) const RATES: [RateUnit; 5] = [
    RateUnit::RadiansPerSecond,
    RateUnit::DegreesPerSecond,
    RateUnit::MilliradiansPerSecond,
    RateUnit::CentidegreesPerSecond,
    RateUnit::MillidegreesPerSecond,
];

/// Of `all`, the unit nearest to `factor` within `tolerance`.
fn nearest<U: Copy>(all: &[U], factor_of: fn(U) -> f64, factor: f64, tolerance: f64) -> Option<U> {
    let away = |unit: &U| (factor_of(*unit) / factor).ln().abs();
    let nearest = all.iter().copied().min_by(|a, b| away(a).total_cmp(&away(b)))?;
    (away(&nearest) < tolerance.ln()).then_some(nearest)
}

/// Changes the gyro's unit if the gyro's angles agree with those of the attitude only then. Returns whether the
/// attitude determines the unit.
pub(super) fn settle_gyro(
    mapping: &mut Mapping,
    dataset: &Dataset,
    findings: &mut Vec<String>,
    checks: &mut Vec<String>,
) -> bool {
    const INCREMENTS: [RateUnit; 2] = [RateUnit::Radians, RateUnit::Degrees];
    let steps = super::together::steps(&dataset.imu, crate::text::Axes::FORWARD_RIGHT_DOWN);
    let Some(ratio) = super::together::attitude_ratio(&steps) else { return false };
    let Some(gyro) = mapping.table.iter_mut().find_map(|table| table.gyro.as_mut()) else {
        return false;
    };
    let all = if gyro.unit.is_increment() { &INCREMENTS[..] } else { &RATES };
    let Some(unit) = nearest(all, RateUnit::factor, ratio * gyro.unit.factor(), 2.0) else {
        checks.push(format!(
            "gyro: read as {}, but the attitude turns {ratio:.3} times as fast, which is no known unit: \
             convert {} to rad/s",
            gyro.unit.name(),
            gyro.columns.join(", ")
        ));
        return true;
    };
    if unit != gyro.unit {
        gyro.unit = unit;
        findings.push(format!(
            "the gyro's angles agree with the attitude's if the gyro is in {}",
            unit.name()
        ));
    }
    true
}

/// Determines the unit of the receiver's height from a barometer or from the vertical velocity. Returns whether it is
/// known.
pub(super) fn settle_height(
    mapping: &mut Mapping,
    dataset: &Dataset,
    stated: StatedUnits,
    findings: &mut Vec<String>,
) -> bool {
    let baro = mapping.table.iter().find_map(|table| table.baro.clone());
    let Some(gps) = mapping.table.iter_mut().find_map(|table| table.gps.as_mut()) else {
        return true;
    };
    let mut is_known = stated.height;
    let climbed = travel::climb_ratio(&dataset.fixes);
    let as_read = gps.height_unit.factor();
    let mut settle = |scale: Option<f64>, with: &str| {
        let unit = scale.filter(|_| !is_known).and_then(|scale| {
            nearest(&HEIGHTS, LengthUnit::factor, as_read / scale, HEIGHT_TOLERANCE)
        });
        if let Some(unit) = unit {
            (gps.height_unit, is_known) = (unit, true);
            findings.push(format!(
                "{} agrees with {with} if its unit is {}",
                gps.height,
                unit.name()
            ));
        }
    };
    if let Some(baro) = baro.filter(|_| stated.baro) {
        settle(barometer_scale(dataset), &baro.column);
    }
    let column = if gps.down.is_empty() { gps.up.clone() } else { gps.down.clone() };
    if stated.vertical || gps.speed_unit == SpeedUnit::MetresPerSecond {
        settle(climbed, &column);
    }
    is_known
}

/// Determines the unit of the receiver's vertical velocity from its height, whose unit is known. `dataset` is in the
/// units of `mapping`; both are changed.
pub(super) fn settle_vertical(
    mapping: &mut Mapping,
    dataset: &mut Dataset,
    stated: StatedUnits,
    findings: &mut Vec<String>,
) {
    let gps = mapping.table.iter_mut().find_map(|table| table.gps.as_mut());
    let Some(gps) = gps.filter(|_| stated.height && !stated.vertical) else { return };
    let Some(scale) = travel::climb_ratio(&dataset.fixes) else { return };
    let before = gps.vertical_unit();
    let unit = nearest(&CLIMBS, SpeedUnit::factor, scale * before.factor(), CLIMB_TOLERANCE);
    let Some(unit) = unit.filter(|unit| *unit != before) else { return };
    gps.vertical_unit = Some(unit);
    for down in dataset.fixes.iter_mut().filter_map(|fix| fix.down_velocity_mps.as_mut()) {
        *down *= unit.factor() / before.factor();
    }
    let column = if gps.down.is_empty() { &gps.up } else { &gps.down };
    findings.push(format!("{column} agrees with {} if its unit is {}", gps.height, unit.name()));
}

/// Determines the unit of a barometer's height from the receiver's height, whose unit is known.
pub(super) fn settle_baro(
    mapping: &mut Mapping,
    dataset: &Dataset,
    stated: StatedUnits,
    findings: &mut Vec<String>,
    checks: &mut Vec<String>,
) {
    const HEIGHTS: [BaroUnit; 2] = [BaroUnit::Metres, BaroUnit::Feet];
    let Some(baro) = mapping.table.iter_mut().find_map(|table| table.baro.as_mut()) else { return };
    if stated.baro {
        return;
    }
    let scale = barometer_scale(dataset).map(|scale| scale * baro.unit.factor());
    let column = &baro.column;
    match scale.and_then(|scale| nearest(&HEIGHTS, BaroUnit::factor, scale, HEIGHT_TOLERANCE)) {
        Some(unit) => {
            baro.unit = unit;
            findings.push(format!("{column} agrees with the receiver's height if its unit is {}", unit.name()));
        }
        None => checks.push(format!(
            "baro: the unit of {column} is not stated and is assumed to be {}; the vehicle climbs too \
             little to determine it. For feet set unit = \"ft\" under [table.baro]",
            baro.unit.name()
        )),
    }
}

/// Axes that were found with other units of gyro and height.
struct Tried {
    /// Factors on the heights and on the rates.
    height: f64,
    rate: f64,
    found: Found,
}

impl Tried {
    fn with(dataset: &Dataset, height: f64, rate: f64) -> Self {
        let mut other = turn::head(dataset);
        scale(&mut other, height, rate);
        Self { height, rate, found: turn::found(&other) }
    }
}

/// Determines the axes of the sensors, and the units of gyro and height that are not `known`. It selects the axes and
/// units with clearly the smallest innovations of the filter. `dataset` is in the units of `mapping`; the function
/// changes both.
pub(super) fn settle_by_filter(
    mapping: &mut Mapping,
    dataset: &mut Dataset,
    known: &mut StatedUnits,
    findings: &mut Vec<String>,
    checks: &mut Vec<String>,
) -> Found {
    let foot = LengthUnit::Feet.factor();
    let as_read = Tried { height: 1.0, rate: 1.0, found: turn::found(dataset) };
    let gyro = mapping.table.iter().find_map(|table| table.gyro.as_ref()).map(|gyro| gyro.unit);
    let rates = match gyro {
        Some(unit) if !known.gyro && as_read.found.score >= DISAGREES => {
            possible_rates(dataset, unit)
        }
        _ => Vec::new(),
    };
    if as_read.found.score < DISAGREES && gyro == Some(RateUnit::DegreesPerSecond) {
        checks.retain(|check| !check.starts_with(GYRO_UNSTATED));
    }
    // Heights that fit as read need no other unit, and heights that only scatter have none: a smaller unit makes their
    // innovations smaller in any case.
    let climbs = travel::climbs(&dataset.fixes);
    let is_height_tried = !known.height && climbs && as_read.found.height_score >= turn::DISAGREES;
    let heights = if is_height_tried { &[1.0, foot][..] } else { &[1.0] };
    let factor = gyro.map_or(1.0, RateUnit::factor);
    let mut tried = vec![as_read];
    for &height in heights {
        for rate in std::iter::once(1.0).chain(rates.iter().map(|unit| unit.factor() / factor)) {
            if height != 1.0 || rate != 1.0 {
                tried.push(Tried::with(dataset, height, rate));
            }
        }
    }
    let handicap = |index: usize| if index == 0 { 1.0 / DECISIVE } else { 1.0 };
    let scores = tried.iter().enumerate().map(|(at, one)| (one.found.score * handicap(at), at));
    let best = scores.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, index)| index);
    let Tried { height, rate, found } = tried.swap_remove(best);
    let is_rate_found =
        tried.iter().any(|one| one.rate != rate && one.found.score > DECISIVE * found.score);
    // Heights in feet that are read as metres would move by 3.28 times what the inertial samples measure. The heights as
    // read are in metres if they fit, but would not fit at 3.28 times their size.
    let is_height_found = climbs
        && found.height_score < FITS
        && (height != 1.0 || {
            let larger = Tried::with(dataset, 1.0 / foot, rate);
            larger.found.height_score > DECISIVE * found.height_score.max(1.0)
        });
    scale(dataset, height, rate);
    for table in &mut mapping.table {
        if let Some(gyro) = table.gyro.as_mut().filter(|_| is_rate_found) {
            gyro.unit = nearest(&RATES, RateUnit::factor, factor * rate, 1.01).unwrap_or(gyro.unit);
            findings
                .push(format!("the fixes agree with the gyro if it is in {}", gyro.unit.name()));
            checks.retain(|check| !check.starts_with(GYRO_UNSTATED));
        }
        let Some(gps) = table.gps.as_mut().filter(|_| !known.height) else { continue };
        if height != 1.0 {
            gps.height_unit = LengthUnit::Feet;
        }
        if is_height_found {
            findings.push(format!(
                "the inertial samples agree with {} if its unit is {}",
                gps.height,
                gps.height_unit.name()
            ));
        } else {
            checks.push(unknown_height(gps, dataset));
        }
        known.height = is_height_found;
    }
    found
}

/// Both readings of a height whose unit is unknown.
fn unknown_height(gps: &GpsColumns, dataset: &Dataset) -> String {
    let high_m = dataset.fixes.iter().map(|fix| fix.position.height_m).fold(f64::NAN, f64::max);
    let high = high_m / gps.height_unit.factor();
    format!(
        "gps: the unit of {} is not stated and is assumed to be {}: it reaches {high:.0} m, or {:.0} m if \
         it is in feet. The vehicle climbs too little to determine it. For feet set height_unit = \"ft\" \
         under [table.gps]",
        gps.height,
        gps.height_unit.name(),
        high * LengthUnit::Feet.factor()
    )
}

/// Beginning of the check of a gyro whose unit is not stated.
pub(super) const GYRO_UNSTATED: &str = "gyro: rates reach";

/// The 99th percentile of the rate of a vehicle that flies, rad/s: from a calm hover to the limit of gyros.
pub(super) const HIGH_RADPS: std::ops::Range<f64> = 0.03..40.0;

/// The units, other than `unit`, with which the highest rates of `dataset` are those of a vehicle. The dataset was read
/// in `unit`.
fn possible_rates(dataset: &Dataset, unit: RateUnit) -> Vec<RateUnit> {
    let rate = |motion: &Motion| match motion {
        Motion::Rates { angular_rate_radps, .. } => angular_rate_radps.norm(),
        Motion::Increments { .. } => f64::NAN,
    };
    let mut rates: Vec<f64> = dataset.imu.iter().map(|sample| rate(&sample.motion)).collect();
    rates.retain(|rate| rate.is_finite());
    let Some(high) = quantile(&mut rates, 0.99) else { return Vec::new() };
    let is_possible = |other: &RateUnit| {
        *other != unit && HIGH_RADPS.contains(&(high * other.factor() / unit.factor()))
    };
    RATES.into_iter().filter(is_possible).collect()
}

/// Multiplies the heights and the rates of `dataset` by these factors.
fn scale(dataset: &mut Dataset, height: f64, rate: f64) {
    for fix in &mut dataset.fixes {
        fix.position.height_m *= height;
    }
    for sample in &mut dataset.imu {
        if let Motion::Rates { angular_rate_radps, .. } = &mut sample.motion {
            *angular_rate_radps = *angular_rate_radps * rate;
        }
    }
}
