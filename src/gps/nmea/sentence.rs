//! Contents of the sentences, range-checked.
//!
//! # Source
//! NMEA 0183, as u-blox documents it: *u-blox 8 / M8 Receiver Description*, UBX-13003221, section 31.

use super::fields::{Degrees, Fields, Malformed};
use crate::frames::{Ned, Vector};
use crate::gps::receiver_fix::{Horizontal, known_sigma, plausible_height};
use crate::gps::{Correction, DilutionOfPrecision, Dimension};

/// GGA or GNS: position with height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Position {
    pub place: Horizontal,
    pub altitude_msl_m: Option<f64>,
    pub geoid_separation_m: Option<f64>,
    pub satellites: Option<u8>,
    pub horizontal_dilution: Option<f64>,
    pub correction: Option<Correction>,
}

/// RMC: position with velocity and date.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RecommendedMinimum {
    pub place: Horizontal,
    pub ground_velocity: GroundVelocity,
    /// Days since the start of 1970.
    pub day: Option<i32>,
}

/// RMC or VTG: speed and direction over ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct GroundVelocity {
    pub speed_mps: Option<f64>,
    /// Direction over ground from true north, clockwise, rad.
    pub direction_rad: Option<f64>,
}

/// GSA: the geometry of the satellites used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Geometry {
    pub dimension: Dimension,
    pub dilution: DilutionOfPrecision,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Content {
    Gga(Position),
    Gns(Position),
    Rmc(RecommendedMinimum),
    Vtg(GroundVelocity),
    Gsa(Geometry),
    /// Sentence GST: one-sigma of position, north, east, down, m.
    Gst(Option<Vector<Ned>>),
    /// The receiver reports that it has no fix, or no usable fix.
    NoFix,
}

/// The kinds of sentences that contribute to a fix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Gga,
    Gns,
    Rmc,
    Vtg,
    Gsa,
    Gst,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sentence {
    pub kind: Kind,
    /// Time of day since midnight, ns, if the sentence contains it.
    pub time_of_day_ns: Option<u64>,
    pub content: Content,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rejection {
    /// A sentence of a kind that does not contribute to a fix.
    Unknown,
    /// The text does not have the format of the sentence's type.
    Malformed,
    /// A value of the sentence is impossible.
    Impossible,
}

impl From<Malformed> for Rejection {
    fn from(_: Malformed) -> Self {
        Self::Malformed
    }
}

impl Sentence {
    /// Reads the text between `$` and `*`.
    pub fn read(body: &[u8]) -> Result<Self, Rejection> {
        let (kind, data) = match body {
            [] | [_] => return Err(Rejection::Malformed),
            // Names of proprietary sentences begin with P: Garmin's PGRMC is not an RMC.
            [b'P', ..] => return Err(Rejection::Unknown),
            [_, _, b'G', b'G', b'A', b',', data @ ..] => (Kind::Gga, data),
            [_, _, b'G', b'N', b'S', b',', data @ ..] => (Kind::Gns, data),
            [_, _, b'R', b'M', b'C', b',', data @ ..] => (Kind::Rmc, data),
            [_, _, b'V', b'T', b'G', b',', data @ ..] => (Kind::Vtg, data),
            [_, _, b'G', b'S', b'A', b',', data @ ..] => (Kind::Gsa, data),
            [_, _, b'G', b'S', b'T', b',', data @ ..] => (Kind::Gst, data),
            _ => return Err(Rejection::Unknown),
        };
        let mut fields = Fields::new(data);
        let time_of_day_ns = match kind {
            Kind::Vtg | Kind::Gsa => None,
            Kind::Gga | Kind::Gns | Kind::Rmc | Kind::Gst => fields.time_of_day_ns()?,
        };
        let content = match kind {
            Kind::Gga => gga(fields),
            Kind::Gns => gns(fields),
            Kind::Rmc => rmc(fields),
            Kind::Vtg => vtg(fields),
            Kind::Gsa => gsa(fields),
            Kind::Gst => gst(fields),
        }?;
        Ok(Self { kind, time_of_day_ns, content })
    }
}

type Reading = Result<Content, Rejection>;

/// Reads GGA: position, quality, satellites, HDOP, altitude, `M`, separation, `M`.
fn gga(mut fields: Fields<'_>) -> Reading {
    let place = fields.place()?;
    let quality = fields.digit()?.filter(|quality| *quality <= b'8').ok_or(Malformed)?;
    let satellites = fields.count()?;
    let horizontal_dilution = fields.number()?;
    let altitude_msl_m = fields.number()?;
    fields.unit(b'M')?;
    let geoid_separation_m = fields.number()?;
    fields.unit(b'M')?;
    let correction = match quality {
        b'1' => Some(Correction::None),
        b'2' => Some(Correction::Differential),
        // The precise positioning service, which does not report corrections.
        b'3' => None,
        b'4' => Some(Correction::RtkFixed),
        b'5' => Some(Correction::RtkFloat),
        // The other qualities: no fix, dead reckoning, manual input, simulation.
        _ => return Ok(Content::NoFix),
    };
    Ok(Content::Gga(Position {
        place: on_earth(place)?,
        altitude_msl_m: height(altitude_msl_m)?,
        geoid_separation_m: height(geoid_separation_m)?,
        satellites: satellites.and_then(|count| u8::try_from(count).ok()),
        horizontal_dilution: dilution(horizontal_dilution),
        correction,
    }))
}

/// Reads GNS: position, a mode for each satellite system, satellites, HDOP, altitude, separation, age of the
/// corrections, their station, status.
fn gns(mut fields: Fields<'_>) -> Reading {
    let place = fields.place()?;
    let mode = best_mode(fields.text()?).ok_or(Malformed)?;
    let satellites = fields.count()?.ok_or(Malformed)?;
    let horizontal_dilution = fields.number()?;
    let altitude_msl_m = fields.number()?;
    let geoid_separation_m = fields.number()?;
    fields.skip(2)?;
    let status = fields.optional_letter()?;
    let correction = match mode {
        b'A' => Correction::None,
        b'D' | b'P' => Correction::Differential,
        b'R' => Correction::RtkFixed,
        b'F' => Correction::RtkFloat,
        _ => return Ok(Content::NoFix),
    };
    // "V" is not a rejection: it marks a receiver without integrity monitoring, which is nearly every receiver.
    if status == Some(b'U') {
        return Ok(Content::NoFix);
    }
    Ok(Content::Gns(Position {
        place: on_earth(place)?,
        altitude_msl_m: height(altitude_msl_m)?,
        geoid_separation_m: height(geoid_separation_m)?,
        satellites: u8::try_from(satellites).ok(),
        horizontal_dilution: dilution(horizontal_dilution),
        correction: Some(correction),
    }))
}

/// Reads RMC: status, position, speed in knots, course, date, magnetic variation and its letter, mode (since version
/// 2.3), navigational status (since version 4.1).
fn rmc(mut fields: Fields<'_>) -> Reading {
    let status = fields.letter()?.filter(|status| b"ADV".contains(status)).ok_or(Malformed)?;
    let place = fields.place()?;
    let (speed_knots, direction_deg) = (fields.number()?, fields.number()?);
    let day = fields.day()?;
    // The magnetic variation is not used, and receivers send it in too many forms for a check of the sentence.
    fields.skip(2)?;
    let mode = fields.optional_letter()?;
    let is_unsafe = fields.optional_letter()? == Some(b'U');
    // Status or mode of no data, dead reckoning, manual input, simulation, or unsafe.
    if status == b'V' || is_unsafe || mode.is_some_and(|mode| b"NEMSU".contains(&mode)) {
        return Ok(Content::NoFix);
    }
    Ok(Content::Rmc(RecommendedMinimum {
        place: on_earth(place)?,
        ground_velocity: ground_velocity(speed_knots, direction_deg)?,
        day,
    }))
}

/// Reads VTG: true course, `T`, magnetic course, `M`, speed in knots, `N`, speed in km/h, `K`.
fn vtg(mut fields: Fields<'_>) -> Reading {
    let direction_deg = fields.number()?;
    fields.unit(b'T')?;
    fields.number()?;
    fields.unit(b'M')?;
    let speed_knots = fields.number()?;
    fields.unit(b'N')?;
    fields.skip(1)?;
    Ok(Content::Vtg(ground_velocity(speed_knots, direction_deg)?))
}

/// Reads GSA: selection of the dimension, dimension, twelve satellites, PDOP, HDOP, VDOP, satellite system (one digit,
/// since version 4.1).
fn gsa(mut fields: Fields<'_>) -> Reading {
    fields.letter()?.filter(|choice| b"MA".contains(choice)).ok_or(Malformed)?;
    let dimension = match fields.digit()? {
        Some(b'1') => return Ok(Content::NoFix),
        Some(b'2') => Dimension::TwoD,
        Some(b'3') => Dimension::ThreeD,
        _ => return Err(Rejection::Malformed),
    };
    // Some receivers send more or fewer satellites; without a check the satellite numbers would be read as dilutions.
    for _ in 0..12 {
        fields.count()?;
    }
    let dilution = DilutionOfPrecision {
        position: dilution(fields.number()?),
        horizontal: dilution(fields.number()?),
        vertical: dilution(fields.number()?),
    };
    let system = fields.text().unwrap_or_default();
    if system.len() > 1 || !fields.is_empty() {
        return Err(Rejection::Malformed);
    }
    Ok(Content::Gsa(Geometry { dimension, dilution }))
}

/// Reads GST: RMS of the residuals, the error ellipse (two axes, orientation), one-sigma north, east, up.
fn gst(mut fields: Fields<'_>) -> Reading {
    for _ in 0..4 {
        fields.number()?;
    }
    let sigma = [fields.number()?, fields.number()?, fields.number()?];
    let [north, east, down] = sigma.map(Option::unwrap_or_default);
    Ok(Content::Gst(known_sigma(Vector::new(north, east, down))))
}

/// The mode of the best satellite system; `None` unless all characters are letters.
fn best_mode(modes: &[u8]) -> Option<u8> {
    let known = modes.iter().all(u8::is_ascii_alphabetic);
    let best = b"RFPDA".iter().find(|good| modes.contains(good)).or(modes.first());
    best.copied().filter(|_| known)
}

/// The range-checked position of a sentence with a fix.
fn on_earth(place: Option<Degrees>) -> Result<Horizontal, Rejection> {
    place
        .filter(|(_, longitude_deg)| libm::fabs(*longitude_deg) <= 180.0)
        .and_then(|(latitude_deg, longitude_deg)| {
            Horizontal::new(latitude_deg.to_radians(), longitude_deg.to_radians())
        })
        .ok_or(Rejection::Impossible)
}

fn height(height_m: Option<f64>) -> Result<Option<f64>, Rejection> {
    height_m.map(|height_m| plausible_height(height_m).ok_or(Rejection::Impossible)).transpose()
}

fn ground_velocity(
    speed_knots: Option<f64>,
    direction_deg: Option<f64>,
) -> Result<GroundVelocity, Rejection> {
    const METRES_PER_SECOND: f64 = 1_852.0 / 3_600.0;
    let speed_mps = speed_knots.map(|knots| knots * METRES_PER_SECOND);
    let possible = speed_mps.is_none_or(|speed| (0.0..=600.0).contains(&speed))
        && direction_deg.is_none_or(|direction| (0.0..=360.0).contains(&direction));
    possible
        .then_some(GroundVelocity { speed_mps, direction_rad: direction_deg.map(f64::to_radians) })
        .ok_or(Rejection::Impossible)
}

/// A dilution above 0 and below 1000. Receivers send 0, 50 or 99.9 for an unknown dilution; the quality checks apply
/// the limit for use.
fn dilution(value: Option<f64>) -> Option<f64> {
    value.filter(|value| *value > 0.0 && *value < 1e3)
}
