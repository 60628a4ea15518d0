//! Units that no name states: those with which the readings agree.

use super::columns::Understood;
use super::rates::{GYRO_UNSTATED, HIGH_RADPS, Rate};
use super::travel::{self, StatedUnits};
use super::turn::{self, DISAGREES, Found};
use crate::text::{BaroUnit, GpsColumns, LengthUnit, Mapping, RateUnit, SpeedUnit, Triad};
use hovernav::imu::Motion;
use hovernav_dataset::statistics::quantile;
use hovernav_dataset::{Dataset, LogError};
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
/// Largest ratio of two units of a gyro that the angles of an attitude may not tell apart.
const RATE_TOLERANCE: f64 = 1.2;

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
    stated: StatedUnits,
    findings: &mut Vec<String>,
    checks: &mut Vec<String>,
) -> bool {
    const INCREMENTS: [RateUnit; 2] = [RateUnit::Radians, RateUnit::Degrees];
    let steps = super::together::steps(&dataset.imu, crate::text::Axes::FORWARD_RIGHT_DOWN);
    let Some(ratio) = super::together::attitude_ratio(&steps) else { return false };
    let Some(gyro) = mapping.table.iter_mut().find_map(|table| table.gyro.as_mut()) else {
        return false;
    };
    let all = match gyro.unit.is_increment() {
        true => INCREMENTS.map(Rate::plain).to_vec(),
        false => Rate::candidates(gyro, stated),
    };
    let measured = ratio * Rate::of(gyro).factor();
    let Some(rate) = nearest(&all, Rate::factor, measured, 2.0) else {
        checks.push(format!(
            "gyro: read as {}, but the attitude turns {ratio:.3} times as fast, which is no known unit: \
             convert {} to rad/s",
            Rate::of(gyro).name(),
            gyro.columns.join(", ")
        ));
        return true;
    };
    if rate != Rate::of(gyro) {
        rate.give(gyro);
        findings.push(format!(
            "the gyro's angles agree with the attitude's if the gyro is in {}",
            rate.name()
        ));
    }
    let is_close = |other: &&Rate| {
        **other != rate && (other.factor() / measured).ln().abs() < RATE_TOLERANCE.ln()
    };
    let close: Vec<String> = all.iter().filter(is_close).map(|other| other.name()).collect();
    if !close.is_empty() {
        checks.push(format!(
            "gyro: the attitude agrees with {}, as read, and about equally with {}: check the data sheet, and set \
             unit and counts_per_unit under [table.gyro]",
            rate.name(),
            close.join(" or ")
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

/// Selects the gyro among the triples of unnamed columns that may be it: the one with clearly the smallest innovations of
/// the filter. Otherwise the user is asked.
pub(super) fn settle_gyro_columns(
    mapping: &mut Mapping,
    understood: &[Understood],
    findings: &mut Vec<String>,
    checks: &mut Vec<String>,
) -> Result<(), LogError> {
    for (at, one) in understood.iter().enumerate().filter(|(_, one)| !one.other_gyros.is_empty()) {
        let Some(gyro) = one.mapping.gyro.clone() else { continue };
        let as_read = checks.iter().find(|check| check.starts_with(GYRO_UNSTATED)).cloned();
        let mut readings = vec![(gyro, as_read.unwrap_or_default())];
        readings.extend(one.other_gyros.iter().cloned());
        let mut tried = Vec::new();
        for (gyro, unstated) in readings {
            let mut trial = mapping.clone();
            trial.table[at].gyro = Some(gyro.clone());
            let score = turn::found(&turn::head(&super::read(&trial)?), one.is_of_phone).score;
            tried.push((score, gyro, unstated));
        }
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        let is_decisive = tried[0].0 * DECISIVE.powi(2) < tried[1].0;
        let columns = |gyro: &Triad<RateUnit>| gyro.columns.join(" ");
        let shown: Vec<String> = tried
            .iter()
            .map(|(score, gyro, _)| match score.is_finite() {
                true => format!(
                    "columns {} (innovations of {:.1} of their one-sigmas)",
                    columns(gyro),
                    score.sqrt()
                ),
                false => format!("columns {} (no fixes to test them with)", columns(gyro)),
            })
            .collect();
        let (_, gyro, unstated) = tried.swap_remove(0);
        if is_decisive {
            findings.push(format!(
                "the fixes agree with the gyro in {}, not in {}",
                shown[0],
                shown[1..].join(" or ")
            ));
        } else {
            checks.push(format!(
                "gyro: the columns have no names: read as {}; if it is {}, set these under [table.gyro]",
                shown[0], shown[1..].join(" or ")
            ));
        }
        checks.retain(|check| !check.starts_with(GYRO_UNSTATED));
        checks.push(unstated);
        mapping.table[at].gyro = Some(gyro);
    }
    Ok(())
}

/// Axes that were found with other units of gyro and height.
struct Tried {
    /// Factors on the heights and on the rates.
    height: f64,
    rate: f64,
    found: Found,
}

impl Tried {
    fn with(dataset: &Dataset, is_of_phone: bool, height: f64, rate: f64) -> Self {
        let mut other = turn::head(dataset);
        scale(&mut other, height, rate);
        Self { height, rate, found: turn::found(&other, is_of_phone) }
    }
}

/// Determines the axes of the sensors, and the units of gyro and height that are not `known`. It selects the axes and
/// units with clearly the smallest innovations of the filter. `dataset` is in the units of `mapping`; the function
/// changes both.
pub(super) fn settle_by_filter(
    mapping: &mut Mapping,
    dataset: &mut Dataset,
    is_of_phone: bool,
    known: &mut StatedUnits,
    findings: &mut Vec<String>,
    checks: &mut Vec<String>,
) -> Found {
    let foot = LengthUnit::Feet.factor();
    let as_read = Tried { height: 1.0, rate: 1.0, found: turn::found(dataset, is_of_phone) };
    let gyro = mapping.table.iter().find_map(|table| table.gyro.as_ref());
    let as_read_in = gyro.map(Rate::of);
    let is_counted = as_read_in.is_some_and(|rate| rate.counts_per_unit != 1.0);
    let rates = match gyro {
        Some(gyro) if !known.gyro && (is_counted || as_read.found.score >= DISAGREES) => {
            possible_rates(dataset, gyro, *known)
        }
        _ => Vec::new(),
    };
    if as_read.found.score < DISAGREES
        && as_read_in == Some(Rate::plain(RateUnit::DegreesPerSecond))
    {
        checks.retain(|check| !check.starts_with(GYRO_UNSTATED));
    }
    // Heights that fit as read need no other unit, and heights without a climb fit any unit.
    let climbs = travel::climbs(&dataset.fixes);
    let is_height_tried = !known.height && climbs && as_read.found.height_score >= turn::DISAGREES;
    let heights = if is_height_tried { &[1.0, foot][..] } else { &[1.0] };
    let factor = as_read_in.map_or(1.0, Rate::factor);
    let mut tried = vec![as_read];
    for &height in heights {
        for rate in std::iter::once(1.0).chain(rates.iter().map(|unit| unit.factor() / factor)) {
            if height != 1.0 || rate != 1.0 {
                tried.push(Tried::with(dataset, is_of_phone, height, rate));
            }
        }
    }
    let handicap = |index: usize| if index == 0 { 1.0 / DECISIVE } else { 1.0 };
    let scores = tried.iter().enumerate().map(|(at, one)| (one.found.score * handicap(at), at));
    let best = scores.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, index)| index);
    let Tried { height, rate, found } = tried.swap_remove(best);
    // The other units of the gyro, and those among them that fit about as well.
    let others: Vec<&Tried> = tried.iter().filter(|one| one.rate != rate).collect();
    let is_close = |one: &&&Tried| one.found.score <= DECISIVE * found.score;
    let mut close: Vec<&Tried> = others.iter().filter(is_close).copied().collect();
    // Each unit may have been tried with two units of the height.
    close.sort_by(|a, b| a.rate.total_cmp(&b.rate).then(a.found.score.total_cmp(&b.found.score)));
    close.dedup_by(|later, one| later.rate == one.rate);
    close.sort_by(|a, b| a.found.score.total_cmp(&b.found.score));
    let name = |ratio: f64| {
        let rate = nearest(&rates, Rate::factor, factor * ratio, 1.01).or(as_read_in);
        rate.map_or_else(String::new, Rate::name)
    };
    // Smaller heights have smaller innovations, unless the inertial samples measure the climbs. Then heights in metres
    // would not fit as feet.
    let is_height_found = climbs
        && found.height_score < FITS
        && (height != 1.0 || {
            let smaller = Tried::with(dataset, is_of_phone, foot, rate);
            smaller.found.height_score > DECISIVE * found.height_score
        });
    scale(dataset, height, rate);
    for table in &mut mapping.table {
        if let Some(gyro) =
            table.gyro.as_mut().filter(|_| !others.is_empty() && found.score.is_finite())
        {
            nearest(&rates, Rate::factor, factor * rate, 1.01).unwrap_or(Rate::of(gyro)).give(gyro);
            checks.retain(|check| !check.starts_with(GYRO_UNSTATED));
            if close.is_empty() {
                findings.push(format!("the fixes agree with the gyro if it is in {}", name(rate)));
            } else {
                let all = close
                    .iter()
                    .map(|one| format!("{} ({:.2})", name(one.rate), one.found.score.sqrt()));
                checks.push(format!(
                    "gyro: the unit is not stated: read as {} (innovations of {:.2} of their one-sigmas), but the fixes \
                     agree about equally with {}. Check the data sheet, and set unit and counts_per_unit under \
                     [table.gyro]",
                    name(rate),
                    found.score.sqrt(),
                    all.collect::<Vec<_>>().join(" or ")
                ));
            }
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

/// The units other than that of `gyro`, in which `dataset` was read, with which the highest rates are those of a
/// vehicle.
fn possible_rates(dataset: &Dataset, gyro: &Triad<RateUnit>, stated: StatedUnits) -> Vec<Rate> {
    let as_read = Rate::of(gyro);
    let rate = |motion: &Motion| match motion {
        Motion::Rates { angular_rate_radps, .. } => angular_rate_radps.norm(),
        Motion::Increments { .. } => f64::NAN,
    };
    let mut rates: Vec<f64> = dataset.imu.iter().map(|sample| rate(&sample.motion)).collect();
    rates.retain(|rate| rate.is_finite());
    let Some(high) = quantile(&mut rates, 0.99) else { return Vec::new() };
    let is_possible = |other: &Rate| {
        *other != as_read && HIGH_RADPS.contains(&(high * other.factor() / as_read.factor()))
    };
    Rate::candidates(gyro, stated).into_iter().filter(is_possible).collect()
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
