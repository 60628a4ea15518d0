//! One pass of subspace identification.

use super::error::SubspaceError;
use super::projection::Projection;
use super::realization;
use super::scales::Scales;
use super::settings::{Identified, SubspaceSettings};
use crate::record::Experiment;

/// One pass of subspace identification over `experiment`, whose signals should be deviations from trim
/// ([`Experiment::about`]).
///
/// # Errors
/// [`SubspaceError`] where the record is too short, an input does not excite, an output is constant or the order does
/// not fit.
///
/// # Example
/// ```
/// use hovernav_sysid::record::Experiment;
/// use hovernav_sysid::methods::subspace::{SubspaceSettings, identify};
/// use nalgebra::DMatrix;
///
/// // A lag driven by a signal that never repeats.
/// let inputs = DMatrix::from_fn(400, 1, |k, _| (0.1 * (k * k) as f64).sin());
/// let mut outputs = DMatrix::zeros(400, 1);
/// for k in 1..400 {
///     outputs[(k, 0)] = 0.9 * outputs[(k - 1, 0)] + 0.5 * inputs[(k - 1, 0)];
/// }
/// let names = |name: &str| vec![name.to_owned()];
/// let lag = Experiment::new("lag", 0.03, names("u"), names("y"), inputs, outputs)?;
/// let settings = SubspaceSettings { order: Some(1), ..SubspaceSettings::default() };
/// let found = identify(&lag, &settings)?;
/// assert!((found.model.system.a[(0, 0)] - 0.9).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn identify(
    experiment: &Experiment,
    settings: &SubspaceSettings,
) -> Result<Identified, SubspaceError> {
    let scales = Scales::of(experiment)?;
    let unit = scales.applied(experiment);
    let signals = unit.inputs.ncols() + unit.outputs.ncols();
    let horizon = settings.horizon_for(unit.samples(), signals);
    let projection = Projection::of(&unit, horizon, settings.weighting)?;
    let order = match settings.order {
        Some(order) => order,
        None => order_from(&projection.singular_values, projection.largest_order()),
    };
    let mut found = realization::realize(&unit, &projection, order, settings)?;
    scales.restore(&mut found.model);
    Ok(found)
}

/// Number of singular values above the logarithmic mean of the largest and the smallest: those of the vehicle exceed
/// those of the noise. At least 1, at most `largest`.
fn order_from(singular_values: &[f64], largest: usize) -> usize {
    let top = singular_values.first().copied().unwrap_or(0.0);
    // Rounding is not noise: for a record without noise the mean would be near zero.
    let floor = 1e-12 * top;
    let bottom = singular_values.last().copied().unwrap_or(0.0).max(floor);
    let middle = (top * bottom).sqrt();
    singular_values.iter().filter(|&&value| value > middle).count().clamp(1, largest.max(1))
}
