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
    /// Positions of the controls.
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
    /// Lowest position of each control, -1 to 0.
    pub lowest: Sticks,
    /// Highest position of each control, 0 to 1.
    pub highest: Sticks,
    /// Largest rate of each control, 1/s, above 0. The travel from neutral to a stop is 1.
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
    /// Largest horizontal speed, m/s.
    pub speed_mps: f64,
    /// Largest climb and sink rate, m/s.
    pub climb_mps: f64,
    /// Largest commanded horizontal acceleration, m/s^2.
    pub acceleration_mps2: f64,
    /// Largest commanded vertical acceleration, m/s^2.
    pub climb_acceleration_mps2: f64,
    /// Largest turn rate, rad/s.
    pub yaw_rate_radps: f64,
}

/// Accuracy of the estimate required to fly: one-sigmas and times.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct HealthLimits {
    /// Largest one-sigma of roll and pitch, rad.
    pub tilt_sigma_rad: f64,
    /// Largest one-sigma of heading, rad.
    pub heading_sigma_rad: f64,
    /// Largest one-sigma of horizontal velocity, m/s.
    pub velocity_sigma_mps: f64,
    /// Largest one-sigma of vertical velocity, m/s.
    pub vertical_velocity_sigma_mps: f64,
    /// Largest one-sigma of position on each axis, m.
    pub position_sigma_m: f64,
    /// Largest age of the estimate, s.
    pub age_s: f64,
    /// Time without an accepted fix, s, after which the estimate counts as dead reckoning.
    pub dead_reckoning_s: f64,
    /// Time, s, after which continually rejected fixes count as a contradiction to the estimate.
    pub disagreement_s: f64,
    /// Time, s, for which a quantity must be good before the autopilot returns to a better mode that uses it.
    pub recovery_s: f64,
}

/// Transitions between modes.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Transfer {
    /// Time constant, s, with which the difference between the commands of two modes fades out.
    pub fade_s: f64,
    /// Time constant, s, with which the difference between autopilot and pilot fades out when the pilot takes over.
    pub hand_back_s: f64,
    /// Time constant with which the sticks go to trim when attitude is unknown, s.
    pub neutral_s: f64,
    /// Deflection of a stick from its position at engagement that counts as the pilot's override.
    pub override_travel: f64,
    /// Time, s, for which the autopilot holds attitude without a good velocity before it descends.
    pub patience_s: f64,
    /// Sink rate of the descent, m/s.
    pub descent_mps: f64,
    /// Change of the collective from trim, in the sinking direction, during a descent without a good vertical velocity.
    pub descent_collective: f64,
    /// Time constant, s, with which trim is learned in a steady hover.
    pub trim_s: f64,
}

/// The complete configuration of the autopilot. hovernav_default_autopilot_config() sets it to the given gains, and to
/// defaults for everything else.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct AutopilotConfig {
    /// Period of the control loop, s, for which the gains were designed.
    pub period_s: f64,
    /// Initial trim; the autopilot learns a better trim in flight.
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
    /// Converts a configuration of the core to this structure.
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

    /// Converts this structure to a configuration of the core, without checks: the creation of an autopilot checks it.
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
