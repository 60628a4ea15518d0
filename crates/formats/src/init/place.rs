//! Columns and unit of latitude and longitude.

use super::columns::Reader;
use super::known::EARTH_CENTRED;
use super::quantity::Quantity;
use crate::text::PlaceUnit;

/// The largest possible latitude and longitude, rad, plus a margin for rounding.
const RADIANS_MAX: [f64; 2] = [std::f64::consts::FRAC_PI_2 + 1e-3, std::f64::consts::PI + 1e-3];

/// Smallest coordinate in degrees × 10⁷. Smaller numbers would lie in the Gulf of Guinea, within about a kilometre of
/// 0° N 0° E.
const MIN_SCALED: f64 = 1e5;

/// The columns of latitude and longitude.
pub(super) struct Place {
    /// Columns of the latitude and of the longitude.
    pub columns: [usize; 2],
    pub unit: PlaceUnit,
    /// Columns of the letters N and S, and of E and W.
    pub letters: [Option<usize>; 2],
}

impl Reader<'_> {
    /// The columns of the position and their unit. `None` if they are missing, or if their values fit no known unit. In
    /// the second case, `checks` receives a sentence.
    pub(super) fn place(&self, checks: &mut Vec<String>) -> Option<Place> {
        let [mut lat, mut lon] = self.known.all([Quantity::Latitude, Quantity::Longitude])?;
        if self.known.unit(lat) == Some(EARTH_CENTRED) {
            let unit = PlaceUnit::EarthCentred;
            return Some(Place { columns: [lat, lon], unit, letters: [None; 2] });
        }
        let letters = [self.letters(lat, *b"NS"), self.letters(lon, *b"EW")];
        let (mut lat_most, mut lon_most) = (self.look.largest(lat), self.look.largest(lon));
        let is_swapped = (90.0..=360.0).contains(&lat_most) && lon_most <= 90.0;
        if is_swapped && letters == [None; 2] {
            checks.push(format!(
                "gps: {} reaches {lat_most:.1}°, more than any latitude, and {} does not: latitude \
                 and longitude are exchanged",
                self.look.layout.names[lat], self.look.layout.names[lon]
            ));
            (lat, lon, lat_most, lon_most) = (lon, lat, lon_most, lat_most);
        }
        let is_beyond_degrees = lat_most > 360.0 || lon_most > 360.0;
        let is_padded = self.look.are_padded[lat] || self.look.are_padded[lon];
        let has_letter_in_cells = matches!(&*self.look.cell_units[lat], "N" | "S");
        let is_lettered = letters != [None; 2] || has_letter_in_cells;
        let unit = match self.known.unit(lat) {
            Some("ddmm") => PlaceUnit::DegreesMinutes,
            Some("deg1e7") => PlaceUnit::ScaledDegrees,
            _ if (is_beyond_degrees || is_lettered && (is_padded || lat_most > 90.0))
                && self.are_degrees_and_minutes([lat, lon], is_lettered) =>
            {
                if !is_lettered {
                    checks.push(
                        "gps: latitude and longitude are read as ddmm.mmmm; there are no columns \
                         of N/S and E/W, so unsigned values are read as north and east"
                            .into(),
                    );
                }
                PlaceUnit::DegreesMinutes
            }
            _ if lat_most.max(lon_most) > MIN_SCALED
                && self.look.is_whole(lat)
                && self.look.is_whole(lon) =>
            {
                PlaceUnit::ScaledDegrees
            }
            _ if is_beyond_degrees => {
                checks.push(format!(
                    "gps: {} reaches {lat_most} and {} reaches {lon_most}, expected degrees, \
                     radians, degrees × 10⁷, or degrees and minutes as ddmm.mmmm: the receiver is \
                     ignored",
                    self.look.layout.names[lat], self.look.layout.names[lon]
                ));
                return None;
            }
            Some("rad") => PlaceUnit::Radians,
            Some("deg") => PlaceUnit::Degrees,
            _ if !is_lettered && lat_most < RADIANS_MAX[0] && lon_most < RADIANS_MAX[1] => {
                checks.push(
                    "gps: latitude and longitude are read as radians; as degrees they would lie in \
                     the Gulf of Guinea"
                        .into(),
                );
                PlaceUnit::Radians
            }
            _ => PlaceUnit::Degrees,
        };
        Some(Place { columns: [lat, lon], unit, letters })
    }

    /// The column of the `letters` that give the sign of `column`, if its values are unsigned. It is the column after
    /// or before `column`, otherwise the only such column of the file.
    fn letters(&self, column: usize, letters: [u8; 2]) -> Option<usize> {
        if self.look.known(column).any(|value| value < 0.0) {
            return None;
        }
        let has = |other: &usize| self.look.has_only_letters(*other, &letters);
        let mut beside = [Some(column + 1), column.checked_sub(1)].into_iter().flatten();
        beside.find(has).or_else(|| {
            let mut all = (0..self.look.columns.len()).filter(has);
            all.next().filter(|_| all.next().is_none())
        })
    }

    /// Whether latitude and longitude can be ddmm.mmmm: minutes below 60, degrees within 90 and 180. Without
    /// columns of letters, they must also have fractions of a minute, which scaled degrees do not have.
    fn are_degrees_and_minutes(&self, columns: [usize; 2], is_lettered: bool) -> bool {
        let fits = |column: usize, most: f64| {
            let mut values = self.look.known(column).map(f64::abs);
            values.all(|value| value % 100.0 < 60.0 && value <= most)
        };
        fits(columns[0], 9000.0)
            && fits(columns[1], 18_000.0)
            && (is_lettered || !columns.iter().all(|&column| self.look.is_whole(column)))
    }
}
