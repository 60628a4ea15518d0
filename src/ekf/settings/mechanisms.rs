//! Switches of the mechanisms beyond a textbook filter.

/// Declares [`Mechanisms`]: a switch for each mechanism.
macro_rules! switches {
    ($group:ident { $($(#[doc = $doc:literal])+ $name:ident,)* }) => {
        /// Switches of the mechanisms that the estimator has beyond a Kalman filter with fixed noise. All are on by
        /// default. Without mechanisms ([`Mechanisms::NONE`]), the states, gates and resets of the filter remain.
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
        /// Larger uncertainty of the gyro biases when a rest ends; the bias change is learned (M11).
        rested_bias,
        /// Learned factor on the noise of the inertial unit, from successive innovations (K18).
        excess_noise,
        /// Detection of bias steps, from growing innovations (K19).
        bias_steps,
        /// Learned one-sigmas of the fixes, from their innovations (M7).
        fix_errors,
        /// Learned white noise of the positions of fixes without velocity, from their second differences (M21).
        position_scatter,
        /// Heading information only from horizontal force that exceeds its own error (K23).
        level_force,
        /// Larger uncertainty of the accelerometer biases while vibration changes (K24).
        rectification,
        /// Offset of the antenna from its stated position, estimated while the vehicle turns (M16).
        antenna_offset,
        /// Wheel constraint while fixes are absent: velocity only along the road (M17).
        wheels,
        /// Rejection of a receiver whose fixes contradict each other (K15).
        self_contradiction,
        /// Rejection of a height whose innovations are biased while another sensor of height agrees.
        biased_heights,
        /// Reports of positions that drift from their velocity. The one-sigma then covers the drift since its start
        /// (K25).
        drifting_positions,
        /// Second hypothesis of the position: the previous position after a jump was accepted, or a position that
        /// contradicts the start.
        previous_position,
        /// Rejection of fixes that repeat the previous one bit for bit.
        repeated_fixes,
        /// Correction of a heading by the heading bank (H2 to H5).
        heading_monitor,
        /// No reset to a heading sensor while the heading bank confirms the filter's heading.
        confirmed_heading,
        /// Second alignment in flight after gaps (H7).
        lost_level,
        /// Monitor of the magnetic field for changes (M15).
        field_monitor,
        /// Comparison of the inertial unit's own attitude with the gyros (M8).
        attitude_monitor,
        /// Learned noise of the barometer, from the scatter of its readings (M18).
        barometer_scatter,
        /// Barometer error caused by the airflow at the vehicle's speed (M10).
        barometer_wind,
        /// Shocks: the specific force is held close to its value before the shock, and noise is added (S13, S16).
        shocks,
        /// Larger uncertainty for readings at full scale (S13).
        clipping,
        /// Detection of single axes that repeat one reading (S13).
        stuck_axes,
        /// Rejection of samples that repeat all six readings.
        stuck_samples,
        /// Rejection of samples on a straight line, which a logger has interpolated (S17).
        interpolated_samples,
    }
}
