//! Switches of the mechanisms.

use hovernav::ekf::Mechanisms as Core;

use super::flag;
use crate::status::Fault;

/// Switches of the mechanisms that the estimator has beyond a Kalman filter with fixed noise: 1 on, 0 off. All are on
/// by default. Equations such as (M11) are in docs/equations.md.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Mechanisms {
    /// Zero velocity and the Earth's rate at rest (M11).
    pub rest: u32,
    /// Larger uncertainty of the gyro biases when a rest ends; the bias change is learned (M11).
    pub rested_bias: u32,
    /// Learned factor on the noise of the inertial unit, from successive innovations (K18).
    pub excess_noise: u32,
    /// Detection of bias steps, from growing innovations (K19).
    pub bias_steps: u32,
    /// Learned one-sigmas of the fixes, from their innovations (M7).
    pub fix_errors: u32,
    /// Learned white noise of the positions of fixes without velocity, from their second differences (M21).
    pub position_scatter: u32,
    /// Heading information only from horizontal force that exceeds its own error (K23).
    pub level_force: u32,
    /// Larger uncertainty of the accelerometer biases while vibration changes (K24).
    pub rectification: u32,
    /// Offset of the antenna from its stated position, estimated in turns (M16).
    pub antenna_offset: u32,
    /// Wheel constraint while fixes are absent: velocity only along the road (M17).
    pub wheels: u32,
    /// Rejection of a receiver whose fixes contradict each other (K15).
    pub self_contradiction: u32,
    /// Rejection of a height whose innovations are biased while another sensor of height agrees.
    pub biased_heights: u32,
    /// Reports of positions that drift from their velocity; the one-sigma reaches back to the start of the drift (K25).
    pub drifting_positions: u32,
    /// A second position as a hypothesis: the previous one after a jump was accepted, and one that contradicts the
    /// start.
    pub previous_position: u32,
    /// Rejection of fixes that repeat the previous one bit for bit.
    pub repeated_fixes: u32,
    /// Correction of a heading by the heading bank (H2 to H5).
    pub heading_monitor: u32,
    /// No reset to a heading sensor while the heading bank confirms the filter's heading.
    pub confirmed_heading: u32,
    /// Second alignment in flight after gaps (H7).
    pub lost_level: u32,
    /// Monitor of the magnetic field for changes (M15).
    pub field_monitor: u32,
    /// Comparison of the inertial unit's own attitude with the gyros (M8).
    pub attitude_monitor: u32,
    /// Learned noise of the barometer, from the scatter of its readings (M18).
    pub barometer_scatter: u32,
    /// Barometer error caused by the airflow at the vehicle's speed (M10).
    pub barometer_wind: u32,
    /// Shocks: the specific force is held close to its value before the shock, and noise is added (S13, S16).
    pub shocks: u32,
    /// Larger uncertainty for readings at full scale (S13).
    pub clipping: u32,
    /// Detection of single axes that repeat one reading (S13).
    pub stuck_axes: u32,
    /// Rejection of samples that repeat all six readings.
    pub stuck_samples: u32,
    /// Rejection of samples on a straight line, which a logger has interpolated (S17).
    pub interpolated_samples: u32,
}

/// Copies the named switches both ways.
macro_rules! switches {
    ($($name:ident)*) => {
        impl Mechanisms {
            pub(super) fn core(&self) -> Result<Core, Fault> {
                Ok(Core { $($name: flag(concat!("mechanisms.", stringify!($name)), self.$name)?,)* })
            }
        }

        impl From<&Core> for Mechanisms {
            fn from(core: &Core) -> Self {
                Self { $($name: u32::from(core.$name),)* }
            }
        }
    };
}

switches! {
    rest rested_bias excess_noise bias_steps fix_errors position_scatter level_force rectification antenna_offset
    wheels self_contradiction biased_heights drifting_positions previous_position repeated_fixes
    heading_monitor confirmed_heading lost_level field_monitor attitude_monitor barometer_scatter
    barometer_wind shocks clipping stuck_axes stuck_samples interpolated_samples
}
