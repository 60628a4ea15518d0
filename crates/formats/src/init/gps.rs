//! The columns of a receiver.

use super::columns::Reader;
use super::names::Quantity;
use crate::text::{GpsColumns, LengthUnit, PlaceUnit, SpeedUnit};

/// The largest latitude and longitude there can be, rad, with what rounding adds.
const RADIANS_MOST: [f64; 2] = [std::f64::consts::FRAC_PI_2 + 1e-3, std::f64::consts::PI + 1e-3];

impl Reader<'_> {
    /// The columns of a receiver, if there are latitude, longitude and height; `with_others` where the file
    /// has an inertial unit's as well.
    pub(super) fn gps(
        &mut self,
        with_others: bool,
        doubts: &mut Vec<String>,
    ) -> Option<GpsColumns> {
        let [mut lat, mut lon] = self.known.all([Quantity::Latitude, Quantity::Longitude])?;
        let (height, above) = self.known.height()?;
        let (mut lat_most, mut lon_most) = (self.look.largest(lat), self.look.largest(lon));
        if (90.0..=360.0).contains(&lat_most) && lon_most <= 90.0 {
            doubts.push(format!(
                "gps: {} reaches {lat_most:.1}, beyond any latitude, and {} does not: each is taken for \
                 the other",
                self.look.layout.names[lat], self.look.layout.names[lon]
            ));
            (lat, lon, lat_most, lon_most) = (lon, lat, lon_most, lat_most);
        }
        let unit = match self.known.unit(lat) {
            _ if lat_most > 360.0 || lon_most > 360.0 => PlaceUnit::ScaledDegrees,
            Some("rad") => PlaceUnit::Radians,
            Some("deg") => PlaceUnit::Degrees,
            _ if lat_most < RADIANS_MOST[0] && lon_most < RADIANS_MOST[1] => {
                doubts.push(
                    "gps: latitude and longitude are taken as radians; as degrees they would lie in \
                     the Gulf of Guinea"
                        .into(),
                );
                PlaceUnit::Radians
            }
            _ => PlaceUnit::Degrees,
        };
        let height_unit = match self.known.unit(height) {
            Some("ft") => LengthUnit::Feet,
            Some("mm") => LengthUnit::Millimetres,
            Some("cm") => LengthUnit::Centimetres,
            Some("m") => LengthUnit::Metres,
            _ if self.look.largest(height) > 2e4 => LengthUnit::Millimetres,
            _ => LengthUnit::Metres,
        };
        if above.is_none() {
            doubts.push(
                "gps: the height is taken as above the ellipsoid; where it is above the sea, set \
                 height_above = \"sea\" and geoid_separation_m under [table.gps]"
                    .into(),
            );
        }
        let held = with_others && self.look.is_held(&[lat, lon, height]);
        let speeds = [Quantity::Velocity(0), Quantity::Velocity(2), Quantity::Up, Quantity::Speed];
        let speed = speeds.into_iter().find_map(|quantity| self.known.column(quantity));
        let sigma = self.known.column(Quantity::SigmaHorizontal);
        let mut gps = GpsColumns {
            latitude: self.name(lat),
            longitude: self.name(lon),
            unit,
            height: self.name(height),
            height_unit,
            height_above: above.unwrap_or_default(),
            speed_unit: speed.map_or(SpeedUnit::default(), |column| self.speed_unit(column)),
            sigma_unit: match sigma.and_then(|column| self.known.unit(column)) {
                Some("mm") => LengthUnit::Millimetres,
                Some("cm") => LengthUnit::Centimetres,
                _ => LengthUnit::Metres,
            },
            held,
            ..GpsColumns::default()
        };
        if self.known.all([0, 1].map(Quantity::Velocity)).is_some() {
            gps.north = self.optional(Quantity::Velocity(0));
            gps.east = self.optional(Quantity::Velocity(1));
        } else if self.known.all([Quantity::Speed, Quantity::Course]).is_some() {
            gps.speed = self.optional(Quantity::Speed);
            gps.course = self.optional(Quantity::Course);
        }
        gps.down = self.optional(Quantity::Velocity(2));
        if gps.down.is_empty() {
            gps.up = self.optional(Quantity::Up);
        }
        if self.known.all([Quantity::SigmaHorizontal, Quantity::SigmaVertical]).is_some() {
            gps.sigma_horizontal = self.optional(Quantity::SigmaHorizontal);
            gps.sigma_vertical = self.optional(Quantity::SigmaVertical);
        }
        gps.sigma_speed = self.optional(Quantity::SigmaSpeed);
        gps.sigma_vertical_speed = self.optional(Quantity::SigmaVerticalSpeed);
        gps.fix_type = self.optional(Quantity::FixType);
        gps.satellites = self.optional(Quantity::Satellites);
        Some(gps)
    }

    fn speed_unit(&self, column: usize) -> SpeedUnit {
        match self.known.unit(column) {
            Some("cm/s") => SpeedUnit::CentimetresPerSecond,
            Some("mm/s") => SpeedUnit::MillimetresPerSecond,
            Some("km/h") => SpeedUnit::KilometresPerHour,
            Some("kn") => SpeedUnit::Knots,
            Some("m/s") => SpeedUnit::MetresPerSecond,
            _ if self.look.largest(column) > 300.0 => SpeedUnit::MillimetresPerSecond,
            _ => SpeedUnit::MetresPerSecond,
        }
    }
}
