//! Ground effect on the rotor.

use hovernav_model::helicopter::{HelicopterParameters, HelicopterState};

/// Lift near the ground divided by the lift away from it: 1 above three rotor radii. The ratio decreases with
/// speed, because the vehicle leaves its ground cushion behind.
///
/// # Source
/// Cheeseman and Bennett (1955), *The effect of the ground on a helicopter rotor in forward flight*, ARC
/// R&M 3021. Equation (V18) of docs/equations.md.
pub(super) fn effect(
    parameters: &HelicopterParameters,
    motion: &HelicopterState,
    height_m: f64,
) -> f64 {
    /// Height in rotor radii above which the ground has no effect.
    const REACH: f64 = 3.0;
    /// Height in rotor radii below which the effect is constant.
    const MIN: f64 = 0.5;
    let rotor = &parameters.main_rotor;
    let radii = (height_m + parameters.hub_height_m) / rotor.radius_m;
    if radii >= REACH {
        return 1.0;
    }
    let quarter = |radii: f64| 1.0 / (16.0 * radii * radii);
    let weight_n = parameters.mass_kg * parameters.gravity_mps2;
    let momentum_kgps2 = 2.0 * parameters.air_density_kgpm3 * rotor.disc_area_m2();
    let [u, v, _] = motion.velocity_mps.to_array();
    let advance = (u * u + v * v) * momentum_kgps2 / weight_n;
    1.0 / (1.0 - (quarter(radii.max(MIN)) - quarter(REACH)) / (1.0 + advance))
}
