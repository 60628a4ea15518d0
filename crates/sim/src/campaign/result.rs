//! Draw and result of one flight of a campaign.

use std::ops::Range;

use hovernav::controls::Sticks;

use super::SensorGrade;
use crate::{Crash, HoverStatistics};

/// Random draw of one flight.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    /// Number of the flight, which is its seed.
    pub seed: u64,
    /// Drawn properties of the airframe, in the order of
    /// [`AirframeUncertainty::columns`](super::AirframeUncertainty::columns).
    pub drawn: Vec<f64>,
    /// Velocity of the steady wind, north and east, m/s, in the direction to which it blows.
    pub wind_mps: [f64; 2],
    /// Horizontal gusts, one sigma, m/s.
    pub gust_mps: f64,
    /// Sensor grade.
    pub grade: SensorGrade,
    /// Time of the GPS outage, s, if there is one.
    pub outage_s: Option<Range<f64>>,
    /// Time of the engine stop, s, if it stops.
    pub power_loss_s: Option<f64>,
    /// Jammed servo (0 lateral to 3 pedal) and time, s, if one jams.
    pub jam: Option<(usize, f64)>,
    /// Fuel in the tank at the start, kg.
    pub fuel_kg: f64,
}

/// Failure drawn for a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failure {
    /// No failure.
    None,
    /// A GPS outage alone.
    Outage,
    /// The engine stops.
    PowerLoss,
    /// The servo of this stick, 0 lateral to 3 pedal, jams.
    Jam(usize),
}

impl Failure {
    /// All failures.
    pub const ALL: [Self; 7] = [
        Self::None,
        Self::Outage,
        Self::PowerLoss,
        Self::Jam(0),
        Self::Jam(1),
        Self::Jam(2),
        Self::Jam(3),
    ];

    /// Name in tables.
    #[must_use]
    pub fn name(self) -> String {
        match self {
            Self::None => "none".into(),
            Self::Outage => "GPS outage".into(),
            Self::PowerLoss => "engine stops".into(),
            Self::Jam(stick) => format!("{} jams", stick_name(stick)),
        }
    }
}

impl Draw {
    /// The worst failure of the flight. A jammed servo counts as worse than a stopped engine, a stopped engine as worse
    /// than a GPS outage.
    #[must_use]
    pub fn failure(&self) -> Failure {
        match (self.jam, self.power_loss_s, &self.outage_s) {
            (Some((stick, _)), ..) => Failure::Jam(stick),
            (None, Some(_), _) => Failure::PowerLoss,
            (None, None, Some(_)) => Failure::Outage,
            (None, None, None) => Failure::None,
        }
    }
}

/// Outcome of a flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Holds its position within [`HoverBounds`](super::HoverBounds).
    Hovered,
    /// Flies, but without holding its position, or outside the bounds.
    Degraded,
    /// The mode is manual at the end of the flight, for example because the autopilot could not engage without a
    /// navigation solution.
    NotEngaged,
    /// Struck the ground or left the flight envelope.
    Crashed,
}

impl Outcome {
    /// All outcomes, best first.
    pub const ALL: [Self; 4] = [Self::Hovered, Self::Degraded, Self::NotEngaged, Self::Crashed];

    /// Name in the results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hovered => "hovered",
            Self::Degraded => "degraded",
            Self::NotEngaged => "not_engaged",
            Self::Crashed => "crashed",
        }
    }
}

/// Result of one flight of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignResult {
    /// The draw of the flight.
    pub draw: Draw,
    /// The outcome.
    pub outcome: Outcome,
    /// Time of the crash, s, and the crash, if it crashed.
    pub crash: Option<(f64, Crash)>,
    /// Time at which the autopilot is to take over, s, from the nominal flight.
    pub engaged_s: f64,
    /// Hover quality from [`Campaign::judged_from_s`](super::Campaign::judged_from_s) on, if the flight lasted until
    /// then.
    pub hover: Option<HoverStatistics>,
    /// Steepest tilt from [`Campaign::judged_from_s`](super::Campaign::judged_from_s) on, °; 0 if the flight ended
    /// earlier.
    pub tilt_worst_deg: f64,
    /// Largest distance from the position at [`Campaign::judged_from_s`](super::Campaign::judged_from_s), m; 0 if the
    /// flight ended earlier.
    pub distance_worst_m: f64,
}

impl CampaignResult {
    /// Time of the crash, s, if it crashed.
    #[must_use]
    pub fn crashed_s(&self) -> Option<f64> {
        self.crash.map(|(at_s, _)| at_s)
    }

    /// The crash and the last event before it, in words; `None` without a crash.
    #[must_use]
    pub fn cause(&self) -> Option<String> {
        let (at_s, crash) = self.crash?;
        let draw = &self.draw;
        let jammed =
            draw.jam.map(|(stick, since_s)| (since_s, format!("{} jammed", stick_name(stick))));
        let stopped = draw.power_loss_s.map(|since_s| (since_s, "the engine stopped".to_owned()));
        let lost = draw.outage_s.as_ref().map(|outage| (outage.start, "GPS was lost".to_owned()));
        let engaged = Some((self.engaged_s, "the autopilot took over".to_owned()));
        let events = [jammed, stopped, lost, engaged].into_iter().flatten();
        let last = events.filter(|(since_s, _)| *since_s <= at_s);
        let last = last.max_by(|(one, _), (other, _)| one.total_cmp(other));
        let told = last.map_or_else(
            || "under the pilot, who flies with the autopilot\u{2019}s gains".to_owned(),
            |(since_s, event)| format!("{:.1} s after {event}", at_s - since_s),
        );
        Some(format!("{crash} at {at_s:.1} s, {told}"))
    }
}

fn stick_name(stick: usize) -> &'static str {
    Sticks::NAMES.get(stick).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn crashed(draw: Draw) -> CampaignResult {
        CampaignResult {
            draw,
            outcome: Outcome::Crashed,
            crash: Some((33.0, Crash::Upset)),
            engaged_s: 15.0,
            hover: None,
            tilt_worst_deg: 0.0,
            distance_worst_m: 0.0,
        }
    }

    #[test]
    fn a_crash_is_reported_with_the_event_before_it() {
        let draw = Draw {
            seed: 1,
            drawn: Vec::new(),
            wind_mps: [0.0; 2],
            gust_mps: 0.0,
            grade: SensorGrade::Thesis,
            outage_s: Some(28.0..40.0),
            power_loss_s: None,
            jam: Some((3, 31.0)),
            fuel_kg: 0.0,
        };
        assert_eq!(draw.failure().name(), "pedal jams");
        let told = |draw: &Draw| crashed(draw.clone()).cause().expect("a crash");
        assert_eq!(told(&draw), "rolled or pitched beyond 80° at 33.0 s, 2.0 s after pedal jammed");
        let later = Draw { jam: Some((3, 40.0)), ..draw.clone() };
        assert!(told(&later).ends_with("5.0 s after GPS was lost"), "{}", told(&later));
        let alone = Draw { jam: None, outage_s: None, ..draw };
        assert!(told(&alone).ends_with("18.0 s after the autopilot took over"));
        assert_eq!(alone.failure(), Failure::None);
        let early = CampaignResult { crash: Some((2.0, Crash::Upset)), ..crashed(alone) };
        assert!(early.cause().is_some_and(|cause| cause.contains("at 2.0 s, under the pilot")));
    }
}
