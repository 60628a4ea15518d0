//! The columns of a receiver.

use super::columns::Reader;
use super::known::device_of;
use super::quantity::Quantity;
use super::travel::StatedUnits;
use crate::text::{CourseUnit, GpsColumns, HeightAbove, LengthUnit, PlaceUnit, SpeedUnit};

/// A full turn, rad, plus a margin for rounding.
const TURN_RAD_MAX: f64 = std::f64::consts::TAU + 1e-3;

/// Form in which a receiver writes numbers without units. `Scaled` means degrees × 10⁷ and whole numbers.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Written {
    Plain,
    Scaled,
}

impl Reader<'_> {
    /// The columns of a receiver, if the file has latitude, longitude and height, and which of the units are stated.
    /// `with_others` means that the file also has IMU columns.
    pub(super) fn gps(
        &mut self,
        with_others: bool,
        checks: &mut Vec<String>,
    ) -> Option<(GpsColumns, StatedUnits)> {
        let place = self.place(checks)?;
        let [lat, lon] = place.columns;
        let Some((height, above)) = self.known.height() else {
            let [lat, lon] = [lat, lon].map(|column| &self.look.layout.names[column]);
            checks.push(format!(
                "gps: {lat} and {lon} have no height among the columns: the receiver is ignored; name a column height"
            ));
            return None;
        };
        let written = match place.unit {
            PlaceUnit::ScaledDegrees => Written::Scaled,
            _ => Written::Plain,
        };
        let height_unit = self.height_unit(height, written, checks);
        let sources = [lat, height].map(|column| device_of(&self.look.layout.names[column]));
        if let [Some(of_place), Some(of_height)] = sources
            && of_place != of_height
        {
            checks.push(format!(
                "gps: the position is that of {of_place}, but the height that of {of_height}, because \
                 {of_place} has none"
            ));
        }
        // A receiver that states the height of the geoid states heights above it, unless their name says otherwise.
        let undulation = self.known.column(Quantity::Undulation);
        let undulation = undulation.filter(|_| above != Some(HeightAbove::Ellipsoid));
        let above = if undulation.is_some() { Some(HeightAbove::Sea) } else { above };
        if let Some(undulation) = undulation {
            checks.push(format!(
                "gps: {} is read as above the sea, and {} is added to it, for the height above the ellipsoid",
                self.look.layout.names[height], self.look.layout.names[undulation]
            ));
        }
        if above.is_none() {
            checks.push(
                "gps: the height is read as above the ellipsoid; if it is above sea level, set \
                 height_above = \"sea\" and geoid_separation_m under [table.gps]"
                    .into(),
            );
        }
        let held = with_others && self.look.is_held(&[lat, lon, height]);
        let mut gps = GpsColumns {
            latitude: self.name(lat),
            longitude: self.name(lon),
            unit: place.unit,
            north_south: place.letters[0].map_or_else(String::new, |column| self.name(column)),
            east_west: place.letters[1].map_or_else(String::new, |column| self.name(column)),
            height: self.name(height),
            height_unit,
            height_above: above.unwrap_or_default(),
            geoid_separation: undulation.map_or_else(String::new, |column| self.name(column)),
            held,
            ..GpsColumns::default()
        };
        let stated = self.velocity(&mut gps, written, checks);
        let is_height_stated =
            self.known.unit(height).is_some() || height_unit != LengthUnit::Metres;
        let stated = StatedUnits { height: is_height_stated, ..stated };
        let is_in_mm = written == Written::Scaled || height_unit == LengthUnit::Millimetres;
        self.sigmas(&mut gps, is_in_mm, checks);
        for (name, quantity) in
            [(&mut gps.fix_type, Quantity::FixType), (&mut gps.satellites, Quantity::Satellites)]
        {
            // Some receivers write `11(11)`, and some loggers 0 satellites throughout.
            let is_stated = |column: &usize| match quantity {
                Quantity::FixType => self.look.are_fix_types[*column],
                _ => self.look.largest(*column) > 0.0,
            };
            let column = self.known.column(quantity).filter(is_stated);
            *name = column.map_or_else(String::new, |column| self.name(column));
        }
        Some((gps, stated))
    }

    fn height_unit(&self, height: usize, written: Written, checks: &mut Vec<String>) -> LengthUnit {
        /// Smallest value of a height in mm: one metre above the ellipsoid.
        const MIN_MM: f64 = 1e3;
        /// Largest height of a vehicle with a receiver, m; larger values are in mm.
        const MAX_M: f64 = 2e4;
        let largest = self.look.largest(height);
        match self.known.unit(height) {
            Some("ft") => LengthUnit::Feet,
            Some("mm") => LengthUnit::Millimetres,
            Some("cm") => LengthUnit::Centimetres,
            Some("m") => LengthUnit::Metres,
            _ if largest > MAX_M => LengthUnit::Millimetres,
            _ if written == Written::Scaled && self.look.is_whole(height) && largest > MIN_MM => {
                checks.push(format!(
                    "gps: the height in {} is read as mm, the unit that receivers use together \
                     with degrees × 10⁷",
                    self.look.layout.names[height]
                ));
                LengthUnit::Millimetres
            }
            _ => LengthUnit::Metres,
        }
    }

    /// Fills in the velocity: north and east, otherwise speed and course; and down or up.
    fn velocity(
        &mut self,
        gps: &mut GpsColumns,
        written: Written,
        checks: &mut Vec<String>,
    ) -> StatedUnits {
        let north_east = self.known.all([0, 1].map(Quantity::Velocity));
        let speed_course = self.known.all([Quantity::Speed, Quantity::Course]);
        let course_unit = speed_course.map(|[_, course]| self.course_unit(course));
        let down = self.known.column(Quantity::Velocity(2));
        let vertical = down.or_else(|| self.known.column(Quantity::Up));
        let mut course_stated = true;
        let speed = match (north_east, speed_course, course_unit) {
            (Some([north, east]), ..) => {
                (gps.north, gps.east) = (self.name(north), self.name(east));
                Some(north)
            }
            (None, Some([_, course]), Some(None)) => {
                checks.push(format!(
                    "gps: {} reaches {}, which fits no known unit of a course: the velocity over \
                     ground is ignored",
                    self.look.layout.names[course],
                    self.look.largest(course)
                ));
                None
            }
            (None, Some([speed, course]), Some(Some(unit))) => {
                (gps.speed, gps.course) = (self.name(speed), self.name(course));
                gps.course_unit = unit;
                course_stated = self.known.unit(course).is_some();
                Some(speed)
            }
            _ => None,
        };
        let (unit, stated) = speed
            .or(vertical)
            .map_or((SpeedUnit::default(), true), |column| self.speed_unit(column, written));
        gps.speed_unit = unit;
        let vertical_unit = vertical.map(|column| self.speed_unit(column, written));
        let vertical_stated = vertical_unit.is_some_and(|(_, stated)| stated);
        if let Some((column, (other, is_stated))) = vertical.zip(vertical_unit) {
            let name = self.name(column);
            if down.is_some() {
                gps.down = name;
            } else {
                gps.up = name;
            }
            gps.vertical_unit =
                Some(other).filter(|other| is_stated && !(stated && *other == unit));
        }
        StatedUnits {
            speed: stated,
            course: course_stated,
            vertical: vertical_stated,
            ..StatedUnits::default()
        }
    }

    fn named_speed_unit(&self, column: usize) -> Option<SpeedUnit> {
        Some(match self.known.unit(column)? {
            "cm/s" => SpeedUnit::CentimetresPerSecond,
            "mm/s" => SpeedUnit::MillimetresPerSecond,
            "km/h" => SpeedUnit::KilometresPerHour,
            "kn" => SpeedUnit::Knots,
            "mph" => SpeedUnit::MilesPerHour,
            "m/s" => SpeedUnit::MetresPerSecond,
            "ft/s" => SpeedUnit::FeetPerSecond,
            "ft/min" => SpeedUnit::FeetPerMinute,
            _ => return None,
        })
    }

    /// The unit of a speed, and whether a name or a known format states it.
    fn speed_unit(&self, column: usize, written: Written) -> (SpeedUnit, bool) {
        let name = self.look.layout.names[column].to_lowercase();
        let is_format = written == Written::Scaled && self.look.is_whole(column);
        match self.named_speed_unit(column) {
            Some(unit) => (unit, true),
            // GPS_RAW_INT of MAVLink.
            None if is_format && name == "vel" => (SpeedUnit::CentimetresPerSecond, true),
            // NAV-PVT of UBX.
            None if is_format && matches!(&*name, "veln" | "veld" | "gspeed") => {
                (SpeedUnit::MillimetresPerSecond, true)
            }
            None if self.look.usual_largest(column) > 300.0 => {
                (SpeedUnit::MillimetresPerSecond, false)
            }
            None => (SpeedUnit::MetresPerSecond, false),
        }
    }

    /// The unit of the velocity of a file without positions.
    pub(super) fn speed_unit_alone(&self, column: usize) -> SpeedUnit {
        let is_whole = self.look.is_whole(column);
        self.speed_unit(column, if is_whole { Written::Scaled } else { Written::Plain }).0
    }

    /// The unit of a course, from its column's name or from its largest value. `None` if that value exceeds a full turn
    /// in every unit.
    fn course_unit(&self, column: usize) -> Option<CourseUnit> {
        let largest = self.look.largest(column);
        Some(match self.known.unit(column) {
            Some("deg") => CourseUnit::Degrees,
            Some("rad") => CourseUnit::Radians,
            Some("cdeg") => CourseUnit::Centidegrees,
            Some("deg1e5") => CourseUnit::ScaledDegrees,
            _ if largest <= TURN_RAD_MAX && !self.look.is_whole(column) => CourseUnit::Radians,
            _ if largest <= 360.0 => CourseUnit::Degrees,
            _ if largest <= 36_000.0 => CourseUnit::Centidegrees,
            _ if largest <= 36_000_000.0 => CourseUnit::ScaledDegrees,
            _ => return None,
        })
    }

    /// Fills in the one-sigmas. `is_in_mm` means that the receiver writes whole millimetres.
    fn sigmas(&mut self, gps: &mut GpsColumns, is_in_mm: bool, checks: &mut Vec<String>) {
        let position = [Quantity::SigmaHorizontal, Quantity::SigmaVertical];
        let is_whole = |reader: &Self, column: usize| is_in_mm && reader.look.is_whole(column);
        if let Some(columns) = self.known.all([0, 1, 2].map(Quantity::SigmaPosition)) {
            if let Some(unit) = self.sigma_unit(columns[0], is_whole(self, columns[0])) {
                gps.sigma_unit = unit;
                [gps.sigma_north, gps.sigma_east, gps.sigma_down] =
                    columns.map(|column| self.name(column));
            } else {
                checks.push(format!(
                    "gps: the unit of {} is not a length: the one-sigmas of position are ignored",
                    self.look.layout.names[columns[0]]
                ));
            }
        } else if let Some([horizontal, vertical]) = self.known.all(position) {
            let name = self.look.layout.names[horizontal].to_lowercase();
            if name.contains("eph") && is_whole(self, horizontal) {
                checks.push(format!(
                    "gps: {} and {} are ignored: together with degrees × 10⁷ they are dilutions of \
                     precision × 100, as in MAVLink, not one-sigmas",
                    self.look.layout.names[horizontal], self.look.layout.names[vertical]
                ));
            } else {
                let unit = self.sigma_unit(horizontal, is_whole(self, horizontal));
                gps.sigma_unit = unit.unwrap_or_default();
                gps.sigma_horizontal = self.name(horizontal);
                gps.sigma_vertical = self.name(vertical);
            }
        }
        let velocity = self.known.all([0, 1, 2].map(Quantity::SigmaVelocity));
        let Some(first) = velocity.map_or(self.known.column(Quantity::SigmaSpeed), |v| Some(v[0]))
        else {
            return;
        };
        let unit = match self.named_speed_unit(first) {
            Some(unit) => Some(unit),
            None if is_whole(self, first) => Some(SpeedUnit::MillimetresPerSecond),
            None => None,
        };
        gps.sigma_speed_unit = unit.filter(|unit| *unit != gps.speed_unit);
        if let Some(columns) = velocity {
            [gps.sigma_velocity_north, gps.sigma_velocity_east, gps.sigma_velocity_down] =
                columns.map(|column| self.name(column));
        } else {
            gps.sigma_speed = self.name(first);
            gps.sigma_vertical_speed = self.optional(Quantity::SigmaVerticalSpeed);
        }
    }

    /// The unit of a one-sigma of position, metres unless stated; `None` if the stated unit is not a length.
    fn sigma_unit(&self, column: usize, is_in_mm: bool) -> Option<LengthUnit> {
        Some(match self.known.unit(column) {
            Some("mm") => LengthUnit::Millimetres,
            Some("cm") => LengthUnit::Centimetres,
            Some("ft") => LengthUnit::Feet,
            Some("m") => LengthUnit::Metres,
            Some(_) => return None,
            None if is_in_mm => LengthUnit::Millimetres,
            None => LengthUnit::Metres,
        })
    }
}
