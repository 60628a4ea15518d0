//! The columns of a receiver.

use super::columns::{Fields, Source};
use super::mapping::GpsColumns;
use super::units::{HeightAbove, PlaceUnit};
use hovernav::earth::Geodetic;
use hovernav::frames::Vector;
use hovernav::time::Time;
use hovernav_dataset::{Dimensions, LogError, StatedFix, is_unknown, is_unknown_velocity};

/// The column indices of a receiver.
pub(crate) struct GpsPlaces {
    mapping: GpsColumns,
    latency_s: f64,
    place: [usize; 3],
    /// Columns of the letters that give the signs of latitude and longitude.
    sides: [Option<usize>; 2],
    /// Columns of the velocity north and east, or of speed and course.
    horizontal: Option<[usize; 2]>,
    vertical: Option<usize>,
    /// Columns of the one-sigmas north, east and down.
    sigma_position: Option<[usize; 3]>,
    sigma_velocity: Option<[usize; 3]>,
    sigma_speed: Option<usize>,
    sigma_vertical_speed: Option<usize>,
    fix_type: Option<usize>,
    satellites: Option<usize>,
    geoid_separation: Option<usize>,
}

impl GpsPlaces {
    pub fn of(source: &Source, mapping: &GpsColumns, latency_s: f64) -> Result<Self, LogError> {
        let pair = |a: &str, b: &str| -> Result<Option<[usize; 2]>, LogError> {
            Ok(source.find_optional(a)?.zip(source.find_optional(b)?).map(|(a, b)| [a, b]))
        };
        let triple = |names: [&str; 3]| -> Result<Option<[usize; 3]>, LogError> {
            let [north, east, down] = names.map(|name| source.find_optional(name));
            Ok(north?.zip(east?).zip(down?).map(|((north, east), down)| [north, east, down]))
        };
        let place = [&mapping.latitude, &mapping.longitude, &mapping.height];
        let [latitude, longitude, height] = place.map(|name| source.find(name));
        let vertical = if mapping.down.is_empty() { &mapping.up } else { &mapping.down };
        Ok(Self {
            place: [latitude?, longitude?, height?],
            sides: [
                source.find_optional(&mapping.north_south)?,
                source.find_optional(&mapping.east_west)?,
            ],
            horizontal: match pair(&mapping.north, &mapping.east)? {
                None => pair(&mapping.speed, &mapping.course)?,
                both => both,
            },
            vertical: source.find_optional(vertical)?,
            sigma_position: triple([
                &mapping.sigma_north,
                &mapping.sigma_east,
                &mapping.sigma_down,
            ])?
            .or(pair(&mapping.sigma_horizontal, &mapping.sigma_vertical)?.map(|[h, v]| [h, h, v])),
            sigma_velocity: triple([
                &mapping.sigma_velocity_north,
                &mapping.sigma_velocity_east,
                &mapping.sigma_velocity_down,
            ])?,
            sigma_speed: source.find_optional(&mapping.sigma_speed)?,
            sigma_vertical_speed: source.find_optional(&mapping.sigma_vertical_speed)?,
            fix_type: source.find_optional(&mapping.fix_type)?,
            satellites: source.find_optional(&mapping.satellites)?,
            geoid_separation: source.find_optional(&mapping.geoid_separation)?,
            mapping: mapping.clone(),
            latency_s,
        })
    }

    /// The fix in a row that arrived at `time`, as the file states it; `None` if the row has no position.
    pub fn fix(&self, time: Time, fields: &Fields<'_>) -> Result<Option<StatedFix>, LogError> {
        let mapping = &self.mapping;
        let [latitude, longitude, height] = self.place;
        let Some(mut place) = fields.known_all([latitude, longitude])? else { return Ok(None) };
        if place.iter().any(|angle| mapping.unknown.contains(angle)) {
            place = [f64::NAN; 2];
        }
        let Some([latitude, longitude]) = self.signed(fields, place)? else { return Ok(None) };
        let height = unknown_as_nan(fields.number(height)?);
        let horizontal =
            self.horizontal.map_or(Ok([f64::NAN; 2]), |columns| fields.numbers(columns))?;
        let vertical = fields.known(self.vertical)?.map_or(f64::NAN, unknown_velocity_as_nan);
        let above = match mapping.height_above {
            HeightAbove::Ellipsoid => 0.0,
            HeightAbove::Sea => match self.geoid_separation {
                Some(column) => {
                    unknown_as_nan(fields.number(column)?) * mapping.height_unit.factor()
                }
                None => mapping.geoid_separation_m,
            },
        };
        let height_m = height * mapping.height_unit.factor() + above;
        let [latitude_deg, longitude_deg] = match is_unknown(latitude) || is_unknown(longitude) {
            true => [latitude, longitude],
            false => [latitude, longitude].map(|angle| mapping.unit.degrees(angle)),
        };
        let to_mps = mapping.speed_unit.factor();
        let vertical_to_mps = mapping.vertical_unit().factor();
        let down = if mapping.down.is_empty() { -vertical_to_mps } else { vertical_to_mps };
        let [first, second] = horizontal.map(unknown_velocity_as_nan);
        let [position_sigma_m, velocity_sigma_mps] = self.sigmas(fields)?;
        let fix_type = fields.fix_type(self.fix_type);
        let satellites = fields.known(self.satellites)?.unwrap_or(f64::NAN);
        let stated = StatedFix {
            dimensions: match fix_type {
                fix_type if fix_type.is_nan() => Dimensions::Three,
                fix_type => Dimensions::Type(fix_type),
            },
            position_sigma_m,
            velocity_mps: [first * to_mps, second * to_mps, vertical * down],
            velocity_sigma_mps,
            satellites,
            ..StatedFix::at(
                Some(time.offset_by(-self.latency_s)),
                [latitude_deg, longitude_deg, height_m],
            )
        };
        if mapping.unit == PlaceUnit::EarthCentred {
            return Ok(Some(from_earth_centred(stated, mapping.height_unit.factor())));
        }
        Ok(Some(match mapping.north.is_empty() && !mapping.speed.is_empty() {
            true => stated.moving(first * to_mps, second * mapping.course_unit.factor()),
            false => stated,
        }))
    }

    /// The one-sigmas of position, m, and velocity, m/s.
    fn sigmas(&self, fields: &Fields<'_>) -> Result<[[f64; 3]; 2], LogError> {
        let mapping = &self.mapping;
        let known = |columns: Option<[usize; 3]>| match columns {
            Some(columns) => fields.known_all(columns),
            None => Ok(None),
        };
        let position = known(self.sigma_position)?;
        let velocity = match known(self.sigma_velocity)? {
            None => {
                let vertical = fields.known(self.sigma_vertical_speed)?;
                fields.known(self.sigma_speed)?.map(|s| [s, s, vertical.unwrap_or(s)])
            }
            per_axis => per_axis,
        };
        let to_mps = mapping.sigma_speed_unit.unwrap_or(mapping.speed_unit).factor();
        let to = [mapping.sigma_unit.factor(), to_mps];
        let scaled = |sigma: Option<[f64; 3]>, to: f64| {
            sigma.map_or([f64::NAN; 3], |sigma| sigma.map(|sigma| sigma * to))
        };
        Ok([scaled(position, to[0]), scaled(velocity, to[1])])
    }

    /// Latitude and longitude with the signs given by their letters; `None` if a letter is missing.
    fn signed(&self, fields: &Fields<'_>, place: [f64; 2]) -> Result<Option<[f64; 2]>, LogError> {
        const LETTERS: [([u8; 2], &str); 2] = [([b'N', b'S'], "N or S"), ([b'E', b'W'], "E or W")];
        let mut signed = place;
        for ((angle, side), (letters, expected)) in signed.iter_mut().zip(self.sides).zip(LETTERS) {
            if let Some(column) = side {
                let Some(sign) = fields.sign(column, letters, expected)? else { return Ok(None) };
                *angle = sign * angle.abs();
            }
        }
        Ok(Some(signed))
    }
}

/// The fix whose position and velocity are along Earth-centred axes. Its x and y are in units of `to_m`, z is in m.
fn from_earth_centred(stated: StatedFix, to_m: f64) -> StatedFix {
    let [x, y, z] = stated.position;
    let Some(place) = Geodetic::from_ecef(Vector::new(x * to_m, y * to_m, z)) else {
        return StatedFix { position: [f64::NAN; 3], ..stated };
    };
    let [latitude_deg, longitude_deg] =
        [place.latitude_rad, place.longitude_rad].map(f64::to_degrees);
    let velocity = place.ecef_to_ned() * Vector::from(stated.velocity_mps);
    StatedFix {
        position: [latitude_deg, longitude_deg, place.height_m],
        velocity_mps: velocity.to_array(),
        ..stated
    }
}

fn unknown_as_nan(value: f64) -> f64 {
    if is_unknown(value) { f64::NAN } else { value }
}

fn unknown_velocity_as_nan(value: f64) -> f64 {
    if is_unknown_velocity(value) { f64::NAN } else { value }
}
