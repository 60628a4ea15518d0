//! The columns of a receiver.

use super::columns::Reader;
use super::names::Quantity;
use crate::text::{GpsColumns, LengthUnit, SpeedUnit};

impl Reader<'_> {
    /// The columns of a receiver, if there are latitude, longitude and height; `with_others` where the file
    /// has an inertial unit's as well.
    pub(super) fn gps(
        &mut self,
        with_others: bool,
        doubts: &mut Vec<String>,
    ) -> Option<GpsColumns> {
        let place = self.place(doubts)?;
        let (height, above) = self.known.height()?;
        let [lat, lon] = place.columns;
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
            unit: place.unit,
            north_south: place.letters[0].map_or_else(String::new, |column| self.name(column)),
            east_west: place.letters[1].map_or_else(String::new, |column| self.name(column)),
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
