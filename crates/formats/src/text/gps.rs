//! The columns of a receiver.

use super::columns::{Fields, Source};
use super::mapping::GpsColumns;
use super::units::HeightAbove;
use hovernav::earth::Geodetic;
use hovernav::frames::{Ned, Vector};
use hovernav::gps::Fix;
use hovernav::time::Time;
use hovernav_log::{LogError, Remarks, no_place, plausible_fix};

/// The column indices of a receiver.
pub(crate) struct GpsPlaces {
    mapping: GpsColumns,
    latency_s: f64,
    place: [usize; 3],
    /// Columns of the letters that give the signs of latitude and longitude.
    sides: [Option<usize>; 2],
    /// North and east, or speed and course.
    horizontal: Option<[usize; 2]>,
    vertical: Option<usize>,
    /// North, east and down.
    sigma_position: Option<[usize; 3]>,
    sigma_velocity: Option<[usize; 3]>,
    sigma_speed: Option<usize>,
    sigma_vertical_speed: Option<usize>,
    fix_type: Option<usize>,
    satellites: Option<usize>,
    /// Values of the previous fix.
    last: Option<[f64; 6]>,
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
            mapping: mapping.clone(),
            latency_s,
            last: None,
        })
    }

    /// The fix in a row that arrived at `time`; `None` where the row has no fix, or repeats the previous one.
    pub fn fix(
        &mut self,
        time: Time,
        fields: &Fields<'_>,
        remarks: &mut Remarks,
    ) -> Result<Option<Fix>, LogError> {
        let mapping = &self.mapping;
        let Some([latitude, longitude, height]) = fields.known_all(self.place)? else {
            return Ok(None);
        };
        let Some([latitude, longitude]) = self.signed(fields, [latitude, longitude])? else {
            return Ok(None);
        };
        let horizontal = match self.horizontal {
            Some(columns) => fields.known_all(columns)?,
            None => None,
        };
        let vertical = fields.known(self.vertical)?;
        let fix_type = fields.known(self.fix_type)?;
        if fix_type == Some(0.0) || [latitude, longitude] == [0.0; 2] {
            remarks.count("left out: no fix", fields.line);
            return Ok(None);
        }
        let [first, second] = horizontal.unwrap_or([f64::MAX; 2]);
        let values = [latitude, longitude, height, first, second, vertical.unwrap_or(f64::MAX)];
        if mapping.held && self.last == Some(values) {
            return Ok(None);
        }
        self.last = Some(values);
        let above = match mapping.height_above {
            HeightAbove::Ellipsoid => 0.0,
            HeightAbove::Sea => mapping.geoid_separation_m,
        };
        let height_m = height * mapping.height_unit.factor() + above;
        let [latitude_deg, longitude_deg] =
            [latitude, longitude].map(|angle| mapping.unit.degrees(angle));
        let Some(position) = Geodetic::from_degrees(latitude_deg, longitude_deg, height_m) else {
            remarks.count(no_place([latitude_deg, longitude_deg]), fields.line);
            return Ok(None);
        };
        let to_mps = mapping.speed_unit.factor();
        let horizontal_velocity_mps = horizontal.map(|[first, second]| {
            if mapping.north.is_empty() {
                let (sine, cosine) = (second * mapping.course_unit.factor()).sin_cos();
                [first * cosine * to_mps, first * sine * to_mps]
            } else {
                [first * to_mps, second * to_mps]
            }
        });
        let down = if mapping.down.is_empty() { -to_mps } else { to_mps };
        let [sigma_m, sigma_mps] = self.sigmas(fields)?;
        let satellites = fields.known(self.satellites)?;
        let satellites = satellites.filter(|count| (0.0..=255.0).contains(count));
        let fix = Fix {
            time: time.offset_by(-self.latency_s),
            position,
            position_sigma_m: sigma_m,
            horizontal_velocity_mps,
            down_velocity_mps: vertical.map(|vertical| vertical * down),
            velocity_sigma_mps: sigma_mps,
            satellites: satellites.map(|count| count as u8),
            two_dimensional: false,
        };
        Ok(Some(plausible_fix(fix, fields.line, remarks)))
    }

    /// The one-sigmas of position, m, and velocity, m/s.
    fn sigmas(&self, fields: &Fields<'_>) -> Result<[Option<Vector<Ned>>; 2], LogError> {
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
        Ok([0, 1].map(|k| [position, velocity][k].map(|sigma| Vector::from(sigma) * to[k])))
    }

    /// Latitude and longitude with the signs given by their letters; `None` where a letter is missing.
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
