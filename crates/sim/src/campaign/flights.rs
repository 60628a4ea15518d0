//! Many flights on all cores.

use hovernav::autopilot::HoverConfig;
use hovernav_model::StateSpace;
use rayon::prelude::*;

use super::{AirframeUncertainty, Campaign, CampaignResult};
use crate::flight::FlightError;

/// A flight of a campaign that is not possible.
#[derive(Debug, thiserror::Error)]
#[error("flight {seed}")]
pub struct CampaignError {
    /// Number of the flight.
    pub seed: u64,
    /// The reason.
    pub source: FlightError,
}

impl Campaign {
    /// A campaign for an `autopilot` designed for `model`: airframes are drawn from the covariance of the model, if it
    /// has one, and the inertial unit has the rate of the autopilot.
    #[must_use]
    pub fn of_model(model: &StateSpace, autopilot: HoverConfig) -> Self {
        let mut campaign = Self::new(autopilot);
        campaign.airframe = AirframeUncertainty::of_model(model);
        campaign.nominal.dmu.rate_hz = 1.0 / autopilot.period_s;
        campaign
    }

    /// Flies the flights `seeds` on all cores. The results are in the order of `seeds`; `flown` is called after each
    /// flight, by any thread.
    ///
    /// # Errors
    /// [`CampaignError`] for an invalid nominal flight or drawn airframe.
    pub fn fly_all(
        &self,
        seeds: &[u64],
        flown: impl Fn() + Sync,
    ) -> Result<Vec<CampaignResult>, CampaignError> {
        let fly = |&seed: &u64| {
            let result = self.fly(&self.draw(seed));
            flown();
            result.map_err(|source| CampaignError { seed, source })
        };
        seeds.par_iter().map(fly).collect()
    }
}
