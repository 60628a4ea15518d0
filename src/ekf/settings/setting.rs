//! Settings of the filter's models: name, default, unit, ranges and description in one table.

/// A number among the settings of the estimator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Name, as in configuration files and in the interface for C.
    pub name: &'static str,
    /// Default value.
    pub default: f64,
    /// Unit, such as `m/s`; empty for a number without one.
    pub unit: &'static str,
    /// Smallest and largest value with which `hovernav fly` flies; an estimator accepts more.
    pub in_flight: [f64; 2],
    /// Whether 0, in the sense of "unknown", is also accepted for a flight.
    pub or_zero: bool,
}

/// A value out of its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfRange {
    /// Group of the setting, such as `imu` or `rangefinder.model`.
    pub group: &'static str,
    /// Name of the setting.
    pub name: &'static str,
    /// Value found.
    pub found: f64,
    /// Range expected.
    pub expected: &'static str,
}

/// Limit of every setting, in any unit; its square is finite in single precision too.
pub(in crate::ekf) const MAX_SETTING: f64 = 1e9;

/// The largest value of a setting, and its range in words.
macro_rules! most {
    () => {
        ($crate::ekf::settings::setting::MAX_SETTING, "0 to 1e9")
    };
    ($most:literal) => {
        (f64::from($most), concat!("0 to ", stringify!($most)))
    };
}

/// Whether 0 is permitted in addition to a range.
macro_rules! or_zero {
    () => {
        false
    };
    ($zero:literal) => {
        true
    };
}

/// Declares a group of settings. Each has its doc, its default, its range in flight, its unit, and its largest value if
/// that is less than [`MAX_SETTING`]. All are `f64`, and readable by name from a configuration file.
macro_rules! settings {
    ($(#[$group:meta])* $name:ident {
        $($(#[$field:meta])* $key:ident = $default:literal $(to $most:literal)?,
            $from:literal ..= $to:literal $(or $zero:literal)? $unit:literal;)*
    }) => {
        $(#[$group])*
        ///
        /// To change some settings, write them before `..Default::default()`, or take the default and assign to its
        /// fields. Both ways stay valid when a setting is added.
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[cfg_attr(
            feature = "serde",
            derive(serde::Deserialize, serde::Serialize),
            serde(default, deny_unknown_fields)
        )]
        pub struct $name { $($(#[$field])* pub $key: f64,)* }

        impl Default for $name {
            fn default() -> Self {
                Self { $($key: $default,)* }
            }
        }

        impl $name {
            /// All settings of the group.
            pub const SETTINGS: &[$crate::ekf::Setting] = &[$($crate::ekf::Setting {
                name: stringify!($key),
                default: $default,
                unit: $unit,
                in_flight: [$from, $to],
                or_zero: $crate::ekf::settings::setting::or_zero!($($zero)?),
            }),*];

            /// The first setting out of its range, with the value found and the range expected. The range is 0 to 1 if
            /// the setting's doc states that, otherwise 0 to 1e9.
            #[must_use]
            pub fn out_of_range(&self) -> Option<(&'static str, f64, &'static str)> {
                [$((stringify!($key), self.$key, $crate::ekf::settings::setting::most!($($most)?))),*]
                    .into_iter()
                    .find(|(_, value, (most, _))| !(0.0..=*most).contains(value))
                    .map(|(key, value, (_, expected))| (key, value, expected))
            }
        }
    };
}

pub(in crate::ekf) use {most, or_zero, settings};

#[cfg(test)]
mod tests {
    use super::super::config::ImuModel;
    use super::super::estimator_config::EstimatorConfig;
    use super::OutOfRange;

    #[test]
    fn every_default_permits_a_flight_and_every_name_is_unique_in_its_group() {
        for (group, settings) in EstimatorConfig::SETTINGS {
            for (index, setting) in settings.iter().enumerate() {
                let [from, to] = setting.in_flight;
                let is_zero = setting.or_zero && setting.default == 0.0;
                assert!((from..=to).contains(&setting.default) || is_zero, "{group}: {setting:?}");
                let before = &settings[..index];
                assert!(before.iter().all(|other| other.name != setting.name), "{setting:?}");
            }
        }
        assert_eq!(EstimatorConfig::default().out_of_range(), None);
    }

    #[test]
    fn a_number_out_of_range_is_named_with_its_group() {
        let mut config = EstimatorConfig::default();
        config.antenna_heading.wander_share = 1.5;
        let expected = OutOfRange {
            group: "second_antenna.model",
            name: "wander_share",
            found: 1.5,
            expected: "0 to 1",
        };
        assert_eq!(config.out_of_range(), Some(expected));
        config.ekf.imu = ImuModel { gap_s: f64::NAN, ..ImuModel::default() };
        let first = config.out_of_range().unwrap();
        assert!(first.group == "imu" && first.name == "gap_s" && first.found.is_nan());
    }
}
