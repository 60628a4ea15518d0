//! What the sentences say: read by the `nmea` crate's parsers, behind a check of each field's form
//! ([`Fields`]), and range-checked.

use chrono::{Datelike, NaiveDate, NaiveTime, Timelike};
use nmea::sentences::faa_mode::FaaMode;
use nmea::sentences::gns::NavigationStatus;
use nmea::sentences::gsa::GsaMode2;
use nmea::sentences::rmc::RmcStatusOfFix;
use nmea::sentences::{self, FixType};
use nmea::{NmeaSentence, SentenceType};

use super::fields::Fields;
use crate::frames::{Ned, Vector};
use crate::gps::receiver_fix::{Horizontal, known_sigma, plausible_height};
use crate::gps::{Correction, DilutionOfPrecision, Dimension};

/// GGA or GNS: position with height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Located {
    pub place: Horizontal,
    pub altitude_msl_m: Option<f64>,
    pub geoid_separation_m: Option<f64>,
    pub satellites: Option<u8>,
    pub horizontal_dilution: Option<f64>,
    pub correction: Option<Correction>,
}

/// RMC: position with velocity and date.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Minimum {
    pub place: Horizontal,
    pub course: Course,
    /// Days since the start of 1970.
    pub day: Option<i32>,
}

/// RMC or VTG: speed and direction over ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Course {
    pub speed_mps: Option<f64>,
    /// From true north, clockwise.
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
    Gga(Located),
    Gns(Located),
    Rmc(Minimum),
    Vtg(Course),
    Gsa(Geometry),
    /// One-sigma, m.
    Gst(Option<Vector<Ned>>),
    /// The receiver says that it has no fix, or none to be used.
    NoFix,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sentence {
    pub kind: SentenceType,
    /// Since midnight, where the sentence tells.
    pub time_of_day_ns: Option<u64>,
    pub content: Content,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// Not a sentence that makes a fix.
    Unknown,
    /// Its text is not what its name promises.
    Malformed,
    /// A value that cannot be.
    Impossible,
}

impl Sentence {
    /// Reads what stands between `$` and `*`.
    pub fn read(body: &str) -> Result<Self, Refusal> {
        let talker_id = body.get(..2).ok_or(Refusal::Malformed)?;
        let (name, data) = body.get(2..).and_then(|rest| rest.split_once(',')).unzip();
        let kind = match name {
            // A maker's own sentences begin with P: Garmin's PGRMC is no RMC.
            _ if talker_id.starts_with('P') => return Err(Refusal::Unknown),
            Some("GGA") => SentenceType::GGA,
            Some("GNS") => SentenceType::GNS,
            Some("RMC") => SentenceType::RMC,
            Some("VTG") => SentenceType::VTG,
            Some("GSA") => SentenceType::GSA,
            Some("GST") => SentenceType::GST,
            _ => return Err(Refusal::Unknown),
        };
        let fields = Fields::of(kind, data.unwrap_or_default()).ok_or(Refusal::Malformed)?;
        let sentence = NmeaSentence {
            talker_id,
            message_id: kind,
            data: fields.as_str(),
            // Checked by the framer, over the fields as they were sent.
            checksum: 0,
        };
        let (time, content) = match kind {
            SentenceType::GGA => gga(sentence),
            SentenceType::GNS => gns(sentence),
            SentenceType::RMC => rmc(sentence),
            SentenceType::VTG => vtg(sentence),
            SentenceType::GSA => gsa(sentence),
            _ => gst(sentence),
        }?;
        Ok(Self { kind, time_of_day_ns: time.map(time_of_day_ns), content })
    }
}

type Reading = Result<(Option<NaiveTime>, Content), Refusal>;

fn gga(sentence: NmeaSentence<'_>) -> Reading {
    let gga = sentences::parse_gga(sentence).or(Err(Refusal::Malformed))?;
    let quality = gga.fix_type.unwrap_or(FixType::Invalid);
    if !quality.is_valid() {
        return Ok((gga.fix_time, Content::NoFix));
    }
    let located = Located {
        place: place(gga.latitude, gga.longitude)?,
        altitude_msl_m: height(gga.altitude)?,
        geoid_separation_m: height(gga.geoid_separation)?,
        satellites: gga.fix_satellites.and_then(|count| u8::try_from(count).ok()),
        horizontal_dilution: dilution(gga.hdop),
        correction: correction(quality),
    };
    Ok((gga.fix_time, Content::Gga(located)))
}

fn gns(sentence: NmeaSentence<'_>) -> Reading {
    let gns = sentences::parse_gns(sentence).or(Err(Refusal::Malformed))?;
    let quality = FixType::from(gns.faa_modes);
    // "V" is no verdict: it stands for a receiver that does not judge safety, as nearly all do.
    if !quality.is_valid() || gns.nav_status == Some(NavigationStatus::Unsafe) {
        return Ok((gns.fix_time, Content::NoFix));
    }
    let located = Located {
        place: place(gns.lat, gns.lon)?,
        altitude_msl_m: height(gns.alt)?,
        geoid_separation_m: height(gns.geoid_separation)?,
        satellites: u8::try_from(gns.nsattelites).ok(),
        horizontal_dilution: dilution(gns.hdop),
        correction: correction(quality),
    };
    Ok((gns.fix_time, Content::Gns(located)))
}

fn rmc(sentence: NmeaSentence<'_>) -> Reading {
    let rmc = sentences::parse_rmc(sentence).or(Err(Refusal::Malformed))?;
    let no_fix = matches!(
        rmc.faa_mode,
        Some(
            FaaMode::DataNotValid
                | FaaMode::Estimated
                | FaaMode::Manual
                | FaaMode::Simulator
                | FaaMode::Unsafe
        )
    );
    if no_fix || rmc.status_of_fix == RmcStatusOfFix::Invalid {
        return Ok((rmc.fix_time, Content::NoFix));
    }
    let minimum = Minimum {
        place: place(rmc.lat, rmc.lon)?,
        course: course(rmc.speed_over_ground, rmc.true_course)?,
        day: rmc.fix_date.map(day),
    };
    Ok((rmc.fix_time, Content::Rmc(minimum)))
}

fn vtg(sentence: NmeaSentence<'_>) -> Reading {
    let vtg = sentences::parse_vtg(sentence).or(Err(Refusal::Malformed))?;
    Ok((None, Content::Vtg(course(vtg.speed_over_ground, vtg.true_course)?)))
}

fn gsa(sentence: NmeaSentence<'_>) -> Reading {
    let gsa = sentences::parse_gsa(sentence).or(Err(Refusal::Malformed))?;
    let dimension = match gsa.mode2 {
        GsaMode2::NoFix => return Ok((None, Content::NoFix)),
        GsaMode2::Fix2D => Dimension::TwoD,
        GsaMode2::Fix3D => Dimension::ThreeD,
    };
    let dilution = DilutionOfPrecision {
        position: dilution(gsa.pdop),
        horizontal: dilution(gsa.hdop),
        vertical: dilution(gsa.vdop),
    };
    Ok((None, Content::Gsa(Geometry { dimension, dilution })))
}

fn gst(sentence: NmeaSentence<'_>) -> Reading {
    let gst = sentences::parse_gst(sentence).or(Err(Refusal::Malformed))?;
    let [north, east, down] =
        [gst.lat_sd, gst.long_sd, gst.alt_sd].map(|sigma| f64::from(sigma.unwrap_or(0.0)));
    Ok((gst.time, Content::Gst(known_sigma(Vector::new(north, east, down)))))
}

/// The place of a sentence that claims to have one.
fn place(latitude_deg: Option<f64>, longitude_deg: Option<f64>) -> Result<Horizontal, Refusal> {
    latitude_deg
        .zip(longitude_deg)
        .filter(|(_, longitude_deg)| libm::fabs(*longitude_deg) <= 180.0)
        .and_then(|(latitude_deg, longitude_deg)| {
            Horizontal::new(latitude_deg.to_radians(), longitude_deg.to_radians())
        })
        .ok_or(Refusal::Impossible)
}

fn height(height_m: Option<f32>) -> Result<Option<f64>, Refusal> {
    height_m
        .map(|height_m| plausible_height(f64::from(height_m)).ok_or(Refusal::Impossible))
        .transpose()
}

fn course(speed_knots: Option<f32>, direction_deg: Option<f32>) -> Result<Course, Refusal> {
    const METRES_PER_SECOND: f64 = 1_852.0 / 3_600.0;
    let speed_mps = speed_knots.map(|knots| f64::from(knots) * METRES_PER_SECOND);
    let direction_deg = direction_deg.map(f64::from);
    let possible = speed_mps.is_none_or(|speed| (0.0..=600.0).contains(&speed))
        && direction_deg.is_none_or(|direction| (0.0..=360.0).contains(&direction));
    possible
        .then_some(Course { speed_mps, direction_rad: direction_deg.map(f64::to_radians) })
        .ok_or(Refusal::Impossible)
}

/// Receivers send 0, 50 or 99.9 for a dilution they do not have; the limit on use is for the quality
/// checks, this one keeps out what is none.
fn dilution(value: Option<f32>) -> Option<f64> {
    value.map(f64::from).filter(|value| *value > 0.0 && *value < 1e3)
}

fn correction(quality: FixType) -> Option<Correction> {
    match quality {
        FixType::Gps => Some(Correction::None),
        FixType::DGps => Some(Correction::Differential),
        FixType::Rtk => Some(Correction::RtkFixed),
        FixType::FloatRtk => Some(Correction::RtkFloat),
        _ => None,
    }
}

fn time_of_day_ns(time: NaiveTime) -> u64 {
    u64::from(time.num_seconds_from_midnight()) * 1_000_000_000 + u64::from(time.nanosecond())
}

fn day(date: NaiveDate) -> i32 {
    const DAYS_TO_1970: i32 = 719_163;
    date.num_days_from_ce() - DAYS_TO_1970
}
