//! Settings of the notch before the estimator.

use hovernav::imu::NotchConfig;

use crate::status::Fault;

/// A notch filter at the speed of a rotor. It removes the rotor's vibration from the inertial samples before all other
/// processing. It delays slow motion by width_hz / (2 pi frequency_hz^2) seconds, and corrects the times of the samples
/// by this delay.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Notch {
    /// Speed of the rotor, turns a second, Hz; 0 until hovernav_push_rotor_speed() sets it.
    pub frequency_hz: f64,
    /// Width of the notch at half power, Hz, the same at each harmonic.
    pub width_hz: f64,
    /// Lowest frequency that the notch removes from the samples, Hz; lower frequencies are motion of the vehicle.
    pub least_hz: f64,
    /// Number of harmonics of the rotor speed that the notch removes, 1 to 4. 0 for no notch, and then frequency_hz
    /// must be 0.
    pub harmonics: u32,
}

impl Notch {
    pub(super) fn of(core: Option<NotchConfig>) -> Self {
        let NotchConfig { frequency_hz, width_hz, harmonics, least_hz, .. } =
            core.unwrap_or(NotchConfig::default().with_harmonics(0));
        Self { frequency_hz, width_hz, least_hz, harmonics }
    }

    pub(super) fn core(&self) -> Result<Option<NotchConfig>, Fault> {
        if self.harmonics == 0 && self.frequency_hz == 0.0 {
            return Ok(None);
        }
        let mut core = NotchConfig::at_hz(self.frequency_hz)
            .with_width_hz(self.width_hz)
            .with_harmonics(self.harmonics);
        core.least_hz = self.least_hz;
        match core.out_of_range() {
            None => Ok(Some(core)),
            Some((key, found, expected)) => {
                let expected = match key {
                    "harmonics" => "1 to 4, or 0 and no frequency for no notch",
                    _ => expected,
                };
                Err(Fault::new(&["notch.", key], found, expected))
            }
        }
    }
}
