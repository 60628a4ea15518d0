//! Settings of the autopilot.

use hovernav::autopilot as core;
use hovernav::controls::Sticks as CoreSticks;

use super::{Gains, mirror};
use crate::access::{input, output};
use crate::object::HOVERNAV_ABI;
use crate::status::Status;

/// The four controls about hover trim, each -1 to 1 of full travel.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub struct Sticks {
    /// Lateral cyclic.
    pub lateral: f64,
    /// Longitudinal cyclic.
    pub longitudinal: f64,
    /// Collective.
    pub collective: f64,
    /// Pedal.
    pub pedal: f64,
}

impl From<CoreSticks> for Sticks {
    fn from(core: CoreSticks) -> Self {
        let [lateral, longitudinal, collective, pedal] = core.to_array();
        Self { lateral, longitudinal, collective, pedal }
    }
}

impl From<Sticks> for CoreSticks {
    fn from(ours: Sticks) -> Self {
        Self::from_array([ours.lateral, ours.longitudinal, ours.collective, ours.pedal])
    }
}

/// Positions of the sticks in a steady hover, and the roll and pitch of the vehicle.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Trim {
    /// The controls.
    pub sticks: Sticks,
    /// Roll, rad.
    pub roll_rad: f64,
    /// Pitch, rad.
    pub pitch_rad: f64,
}

/// Range and rate limits of the autopilot's commands, for each control.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct StickLimits {
    /// Lowest, -1 to 0.
    pub lowest: Sticks,
    /// Highest, 0 to 1.
    pub highest: Sticks,
    /// Fastest, full travels (of 1) a second; above 0.
    pub rate_per_s: Sticks,
}

/// Limits and gains of guidance.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Guidance {
    /// Horizontal speed per distance from the set-point's position, 1/s.
    pub position_gain_per_s: f64,
    /// Vertical speed per height error, 1/s.
    pub height_gain_per_s: f64,
    /// Fastest horizontal speed, m/s.
    pub speed_mps: f64,
    /// Fastest climb and descent, m/s.
    pub climb_mps: f64,
    /// Largest commanded horizontal acceleration, m/s^2.
    pub acceleration_mps2: f64,
    /// Largest commanded vertical acceleration, m/s^2.
    pub climb_acceleration_mps2: f64,
    /// Fastest turn, rad/s.
    pub yaw_rate_radps: f64,
}

/// Accuracy of the estimate required to fly: one-sigmas and times.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct HealthLimits {
    /// Roll and pitch, rad.
    pub tilt_sigma_rad: f64,
    /// Heading, rad.
    pub heading_sigma_rad: f64,
    /// Horizontal velocity, m/s.
    pub velocity_sigma_mps: f64,
    /// Vertical velocity, m/s.
    pub vertical_velocity_sigma_mps: f64,
    /// Position, each axis, m.
    pub position_sigma_m: f64,
    /// Age of the estimate, s.
    pub age_s: f64,
    /// Time without an accepted fix, s, after which the estimate counts as dead reckoning.
    pub dead_reckoning_s: f64,
    /// Time of rejected fixes, s, after which they contradict the estimate.
    pub disagreement_s: f64,
    /// Time, s, for which a quantity must be good before a better mode is flown on it again.
    pub recovery_s: f64,
}

/// Transitions between modes.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Transfer {
    /// Time constant, s, of the fade of the difference between two modes' commands.
    pub fade_s: f64,
    /// Time constant of the same fade when the pilot takes over, s.
    pub hand_back_s: f64,
    /// Time constant with which the sticks go to trim when attitude is unknown, s.
    pub neutral_s: f64,
    /// Deflection of a stick that counts as the pilot's override.
    pub override_travel: f64,
    /// Time for which attitude is held without velocity before the descent begins, s.
    pub patience_s: f64,
    /// Sink rate of the descent, m/s.
    pub descent_mps: f64,
    /// Stick by which the trimmed collective changes, in the sinking direction, in a descent without vertical
    /// velocity.
    pub descent_collective: f64,
    /// Time constant of learning trim in a steady hover, s.
    pub trim_s: f64,
}

/// The complete configuration of the autopilot. hovernav_default_autopilot_config() sets it to the given gains, and to
/// defaults for everything else.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct AutopilotConfig {
    /// Period of the control loop, s, for which the gains were designed.
    pub period_s: f64,
    /// Initial trim; a better one is learned in flight.
    pub trim: Trim,
    /// Range and rate of the commands.
    pub limits: StickLimits,
    /// Limits and gains of guidance.
    pub guidance: Guidance,
    /// Accuracy of the estimate required to fly.
    pub health: HealthLimits,
    /// Transitions between modes.
    pub transfer: Transfer,
    /// The gains.
    pub gains: Gains,
}

mirror!(Guidance, core::GuidanceConfig {
    position_gain_per_s height_gain_per_s speed_mps climb_mps acceleration_mps2
    climb_acceleration_mps2 yaw_rate_radps
});
mirror!(HealthLimits, hovernav::health::HealthLimits {
    tilt_sigma_rad heading_sigma_rad velocity_sigma_mps vertical_velocity_sigma_mps
    position_sigma_m age_s dead_reckoning_s disagreement_s recovery_s
});
mirror!(Transfer, core::TransferConfig {
    fade_s hand_back_s neutral_s override_travel patience_s descent_mps descent_collective trim_s
});

impl AutopilotConfig {
    /// The structure of a configuration of the core.
    #[must_use]
    pub fn of(core: &core::HoverConfig) -> Self {
        Self {
            period_s: core.period_s,
            trim: Trim {
                sticks: core.trim.sticks.into(),
                roll_rad: core.trim.roll_rad,
                pitch_rad: core.trim.pitch_rad,
            },
            limits: StickLimits {
                lowest: core.limits.lowest.into(),
                highest: core.limits.highest.into(),
                rate_per_s: core.limits.rate_per_s.into(),
            },
            guidance: (&core.guidance).into(),
            health: (&core.health).into(),
            transfer: (&core.transfer).into(),
            gains: (&core.gains).into(),
        }
    }

    /// The core's configuration; it is checked when an autopilot is created from it.
    #[must_use]
    pub fn core(&self) -> core::HoverConfig {
        let mut config = core::HoverConfig::new(self.period_s, self.gains.core());
        config.trim.sticks = self.trim.sticks.into();
        config.trim.roll_rad = self.trim.roll_rad;
        config.trim.pitch_rad = self.trim.pitch_rad;
        config.limits.lowest = self.limits.lowest.into();
        config.limits.highest = self.limits.highest.into();
        config.limits.rate_per_s = self.limits.rate_per_s.into();
        self.guidance.put(&mut config.guidance);
        self.health.put(&mut config.health);
        self.transfer.put(&mut config.transfer);
        config
    }
}

/// Fills `config` with `gains`, designed for `period_s`, and defaults for everything else. `abi` is
/// HOVERNAV_ABI.
///
/// # Safety
/// Pointers follow the rules of the crate.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hovernav_default_autopilot_config(
    config: *mut AutopilotConfig,
    period_s: f64,
    gains: *const Gains,
    abi: u32,
) -> Status {
    if abi != HOVERNAV_ABI {
        return Status::AbiMismatch;
    }
    // SAFETY: guaranteed by the caller.
    let slot = unsafe { output(config) };
    // SAFETY: guaranteed by the caller.
    let gains = unsafe { input(gains) };
    Status::of(slot.and_then(|slot| {
        slot.write(AutopilotConfig::of(&core::HoverConfig::new(period_s, gains?.core())));
        Ok(())
    }))
}
