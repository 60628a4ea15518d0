//! Values of one sentence from either reader, in the same quantities and units.

use std::collections::BTreeMap;

use chrono::{Datelike, NaiveTime, Timelike};
use hovernav::gps::nmea::Decoder;
use hovernav::gps::{Correction, Dimension, ReceiverFix, ReceiverTime};
use hovernav::time::Time;
use hovernav_fly::devices::encode::nmea_sentence;
use nmea::ParseResult;
use nmea::sentences::FixType;
use nmea::sentences::gns::NavigationStatus;
use nmea::sentences::gsa::GsaMode2;
use nmea::sentences::rmc::RmcStatusOfFix;

use super::sentences::{Kind, Sentence};

/// Metres per second in a knot.
const KNOT_MPS: f64 = 1_852.0 / 3_600.0;
/// 1 January 1970, days since the start of year 1.
const DAY_1970: i32 = 719_163;

/// A value of a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    TimeOfDayNs,
    /// Days since the start of 1970.
    Day,
    LatitudeDeg,
    LongitudeDeg,
    AltitudeMslM,
    /// Height of the geoid; this project's reader gives it only together with the altitude.
    GeoidSeparationM,
    Satellites,
    /// The quality digit of GGA.
    Quality,
    SpeedMps,
    NorthMps,
    EastMps,
    /// Dimension of the fix, 2 or 3.
    Dimension,
    PositionDilution,
    HorizontalDilution,
    VerticalDilution,
    SigmaNorthM,
    SigmaEastM,
    SigmaDownM,
}

use Quantity::*;

/// The values of a sentence that reports a valid fix.
pub type Values = BTreeMap<Quantity, f64>;

fn present<const N: usize>(values: [(Quantity, Option<f64>); N]) -> Values {
    values.into_iter().filter_map(|(quantity, value)| Some((quantity, value?))).collect()
}

/// Values from the reader of this project; `None` where it rejects the sentence, or the sentence reports no valid
/// fix.
///
/// The reader delivers fixes, and VTG, GSA and GST alone give no fix: a GGA with only a position precedes them.
pub fn ours(sentence: &Sentence) -> Option<Values> {
    let kind = sentence.kind;
    let mut wire = Vec::new();
    let carried = kind.position().is_none();
    if carried {
        let time = if kind == Kind::Gst { sentence.field(0) } else { "120000" };
        wire = nmea_sentence(&format!("GPGGA,{time},0000.0,N,00000.0,E,1,,,,,,"));
    }
    wire.extend(sentence.text.bytes());
    wire.extend(b"\r\n");
    let mut decoder = Decoder::default();
    let mut rest = wire.as_slice();
    let mut fix = None;
    while let Some(found) = decoder.read(&mut rest, Time::ZERO) {
        fix = Some(found);
    }
    let fix = decoder.flush().or(fix)?;
    (decoder.counts().read == 1 + u32::from(carried)).then(|| values_of(kind, &fix))
}

fn values_of(kind: Kind, fix: &ReceiverFix) -> Values {
    let (day, time_of_day_ns) = match fix.time {
        Some(ReceiverTime::Utc { day, time_of_day_ns }) => (day, Some(time_of_day_ns as f64)),
        _ => (None, None),
    };
    let position = [
        (TimeOfDayNs, time_of_day_ns),
        (LatitudeDeg, Some(fix.latitude_rad.to_degrees())),
        (LongitudeDeg, Some(fix.longitude_rad.to_degrees())),
    ];
    let velocity = [
        (SpeedMps, fix.ground_speed_mps),
        (NorthMps, fix.horizontal_velocity_mps.map(|velocity| velocity[0])),
        (EastMps, fix.horizontal_velocity_mps.map(|velocity| velocity[1])),
    ];
    let mut values = Values::new();
    match kind {
        Kind::Gga | Kind::Gns => {
            values.extend(present(position));
            values.extend(present([
                (AltitudeMslM, fix.altitude_msl_m),
                (GeoidSeparationM, fix.height_m.zip(fix.altitude_msl_m).map(|(h, a)| h - a)),
                (Satellites, fix.satellites.map(f64::from)),
                (HorizontalDilution, fix.dilution.horizontal),
                (
                    Quality,
                    fix.correction.map(|correction| match correction {
                        Correction::None => 1.0,
                        Correction::Differential => 2.0,
                        Correction::RtkFixed => 4.0,
                        Correction::RtkFloat => 5.0,
                    }),
                ),
            ]));
        }
        Kind::Rmc => {
            values.extend(present(position));
            values.extend(present(velocity));
            values.extend(present([(Day, day.map(f64::from))]));
        }
        Kind::Vtg => values.extend(present(velocity)),
        Kind::Gsa => values.extend(present([
            (
                Dimension,
                fix.dimension.map(|dimension| match dimension {
                    self::Dimension::TwoD => 2.0,
                    self::Dimension::ThreeD => 3.0,
                }),
            ),
            (PositionDilution, fix.dilution.position),
            (HorizontalDilution, fix.dilution.horizontal),
            (VerticalDilution, fix.dilution.vertical),
        ])),
        Kind::Gst => {
            let [north, east, down] =
                fix.position_sigma_m.map_or([None; 3], |sigma| sigma.to_array().map(Some));
            values.extend(present([
                (TimeOfDayNs, time_of_day_ns),
                (SigmaNorthM, north),
                (SigmaEastM, east),
                (SigmaDownM, down),
            ]));
        }
    }
    values
}

fn single(value: Option<f32>) -> Option<f64> {
    value.map(f64::from)
}

fn nanoseconds(time: NaiveTime) -> f64 {
    // A leap second is a nanosecond count beyond 10⁹.
    f64::from(time.num_seconds_from_midnight()) * 1e9 + f64::from(time.nanosecond())
}

fn velocity(speed_knots: Option<f32>, course_deg: Option<f32>) -> Values {
    let speed_mps = single(speed_knots).map(|knots| knots * KNOT_MPS);
    // At rest the velocity is zero with any course or without one.
    let course_deg = single(course_deg).or(speed_mps.filter(|speed| *speed == 0.0));
    let course_rad = course_deg.map(f64::to_radians);
    let component = |of: fn(f64) -> f64| Some(speed_mps? * of(course_rad?));
    present([
        (SpeedMps, speed_mps),
        (NorthMps, component(f64::cos)),
        (EastMps, component(f64::sin)),
    ])
}

/// The digit of GGA for a valid fix; 0 for one with unknown corrections.
fn quality(fix: FixType) -> Option<f64> {
    match fix {
        FixType::Gps => Some(1.0),
        FixType::DGps => Some(2.0),
        FixType::Pps => Some(0.0),
        FixType::Rtk => Some(4.0),
        FixType::FloatRtk => Some(5.0),
        FixType::Invalid | FixType::Estimated | FixType::Manual | FixType::Simulation => None,
    }
}

/// Values from the `nmea` crate; `None` where it rejects the sentence, or the sentence reports no valid fix.
pub fn oracle(sentence: &Sentence) -> Option<Values> {
    let values = match nmea::parse_str(&sentence.text).ok()? {
        ParseResult::GGA(data) => present([
            (TimeOfDayNs, data.fix_time.map(nanoseconds)),
            (LatitudeDeg, data.latitude),
            (LongitudeDeg, data.longitude),
            (AltitudeMslM, single(data.altitude)),
            (GeoidSeparationM, single(data.geoid_separation).filter(|_| data.altitude.is_some())),
            (Satellites, data.fix_satellites.map(f64::from)),
            (HorizontalDilution, single(data.hdop)),
            (Quality, Some(quality(data.fix_type?)?).filter(|quality| *quality > 0.0)),
        ]),
        ParseResult::GNS(data) => {
            if data.nav_status == Some(NavigationStatus::Unsafe) {
                return None;
            }
            present([
                (TimeOfDayNs, data.fix_time.map(nanoseconds)),
                (LatitudeDeg, data.lat),
                (LongitudeDeg, data.lon),
                (AltitudeMslM, single(data.alt)),
                (GeoidSeparationM, single(data.geoid_separation).filter(|_| data.alt.is_some())),
                (Satellites, Some(f64::from(data.nsattelites))),
                (HorizontalDilution, single(data.hdop)),
                (Quality, Some(quality(data.faa_modes.into())?)),
            ])
        }
        ParseResult::GSA(data) => present([
            (
                Dimension,
                Some(match data.mode2 {
                    GsaMode2::NoFix => return None,
                    GsaMode2::Fix2D => 2.0,
                    GsaMode2::Fix3D => 3.0,
                }),
            ),
            (PositionDilution, single(data.pdop)),
            (HorizontalDilution, single(data.hdop)),
            (VerticalDilution, single(data.vdop)),
        ]),
        ParseResult::GST(data) => present([
            (TimeOfDayNs, data.time.map(nanoseconds)),
            (SigmaNorthM, single(data.lat_sd)),
            (SigmaEastM, single(data.long_sd)),
            (SigmaDownM, single(data.alt_sd)),
        ]),
        ParseResult::RMC(data) => {
            if data.status_of_fix == RmcStatusOfFix::Invalid {
                return None;
            }
            if let Some(mode) = data.faa_mode {
                quality(mode.into())?;
            }
            let mut values = velocity(data.speed_over_ground, data.true_course);
            values.extend(present([
                (TimeOfDayNs, data.fix_time.map(nanoseconds)),
                (Day, data.fix_date.map(|date| f64::from(date.num_days_from_ce() - DAY_1970))),
                (LatitudeDeg, data.lat),
                (LongitudeDeg, data.lon),
            ]));
            values
        }
        ParseResult::VTG(data) => velocity(data.speed_over_ground, data.true_course),
        _ => return None,
    };
    Some(values)
}
