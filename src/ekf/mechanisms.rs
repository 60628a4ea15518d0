//! Switches of the mechanisms beyond a textbook filter.

/// Declares [`Mechanisms`]: a switch for each mechanism.
macro_rules! switches {
    ($group:ident { $($(#[doc = $doc:literal])+ $name:ident,)* }) => {
        /// Switches of the mechanisms that the estimator has beyond a Kalman filter with fixed noise. All are on by
        /// default. Without any, see [`Mechanisms::NONE`], the states, gates and resets of the filter remain.
        ///
        /// ```
        /// use hovernav::ekf::{EkfConfig, Mechanisms};
        ///
        /// let mechanisms = Mechanisms { antenna_offset: false, ..Mechanisms::ALL };
        /// let config = EkfConfig { mechanisms, ..EkfConfig::default() };
        /// assert!(config.mechanisms.rest && !config.mechanisms.antenna_offset);
        /// ```
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[cfg_attr(
            feature = "serde",
            derive(serde::Deserialize, serde::Serialize),
            serde(default, deny_unknown_fields)
        )]
        pub struct $group { $($(#[doc = $doc])+ pub $name: bool,)* }

        impl $group {
            /// All mechanisms.
            pub const ALL: Self = Self { $($name: true),* };
            /// No mechanism.
            pub const NONE: Self = Self { $($name: false),* };
            /// Names, as in configuration files, and descriptions.
            pub const LIST: &[(&str, &str)] = &[$((stringify!($name), concat!($($doc),+))),*];

            /// Switches the mechanism of this name in [`LIST`](Self::LIST). Returns `false` for an unknown name.
            pub fn set(&mut self, name: &str, on: bool) -> bool {
                match name {
                    $(stringify!($name) => self.$name = on,)*
                    _ => return false,
                }
                true
            }
        }
    };
}

impl Default for Mechanisms {
    fn default() -> Self {
        Self::ALL
    }
}

switches! {
    Mechanisms {
        /// Zero velocity and the Earth's rate at rest (M11).
        rest,
        /// Smaller gyro biases after a rest: the change of the bias between rest and motion is learned (M11).
        rested_bias,
        /// Factor on the noise of the inertial unit, from successive innovations (K18).
        excess_noise,
        /// Steps of a bias, from growing innovations (K19).
        bias_steps,
        /// Sizes of the errors of fixes, from their innovations (M7).
        fix_errors,
        /// Heading from horizontal force only beyond the force's own error (K23).
        level_force,
        /// Larger accelerometer biases while vibration changes (K24).
        rectification,
        /// Offset of the antenna from its stated position, from turns (M16).
        antenna_offset,
        /// Motion along the road while fixes are absent, for vehicles on wheels (M17).
        wheels,
        /// Rejection of a receiver whose fixes contradict each other (K15).
        self_contradiction,
        /// Rejection of a height whose innovations are biased while another sensor of height agrees.
        biased_heights,
        /// Reports of positions that drift from their own velocity; the one-sigma reaches back to the start (K25).
        drifting_positions,
        /// A previous position as second hypothesis, after a position that jumped was accepted.
        previous_position,
        /// No fusion of fixes that repeat the previous one bit for bit.
        repeated_fixes,
        /// Correction of a heading by the heading bank (H2 to H5).
        heading_monitor,
        /// No reset by a sensor of heading while the heading bank confirms the heading.
        confirmed_heading,
        /// Second alignment after gaps (H7).
        lost_level,
        /// Changes of the magnetic field (M15).
        field_monitor,
        /// Comparison of the unit's own attitude with the gyros (M8).
        attitude_monitor,
        /// Scatter of the barometer (M18).
        barometer_scatter,
        /// Error of the barometer by the wind of the vehicle's own speed (M10).
        barometer_wind,
        /// Shocks and lost samples: force is withheld, and noise is added (S13, S16).
        shocks,
        /// Readings at full scale (S13).
        clipping,
        /// Single axes that repeat one reading (S13).
        stuck_axes,
        /// No use of samples that repeat all six readings.
        stuck_samples,
        /// No use of samples on a straight line, which a logger has interpolated (S17).
        interpolated_samples,
    }
}
