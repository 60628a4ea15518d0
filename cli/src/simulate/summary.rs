//! `summary.json` of a closed-loop flight.

use super::velocity::VelocitySummary;
use hovernav::autopilot::Transition;
use hovernav_formats::RunSummary;
use hovernav_sim::{Excursion, Feedback, Flight, FlightConfig, FlightEvent};
use serde::Serialize;

/// Start of the evaluation of the hover, s.
const JUDGED_FROM_S: f64 = 25.0;

/// Time after a disturbance, s, in which the largest excursion is searched.
const FOLLOWED_S: f64 = 20.0;

/// The summary of a simulated flight: of the filter, and of the closed loop.
#[derive(Debug, Serialize)]
pub struct Summary {
    #[serde(flatten)]
    pub run: RunSummary,
    pub flight: ClosedLoopSummary,
}

/// The behaviour of the closed loop.
#[derive(Debug, Serialize)]
pub struct ClosedLoopSummary {
    /// The state that the autopilot used.
    feedback: &'static str,
    /// Time of the crash, s.
    crashed_s: Option<f64>,
    /// The mode at the end.
    last_mode: String,
    transitions: Vec<TransitionSummary>,
    disturbances: Vec<DisturbanceSummary>,
    /// Set-points of velocity.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    velocities: Vec<VelocitySummary>,
    judged_from_s: f64,
    /// `None` for a flight that ends before, and for one with set-points of velocity.
    #[serde(flatten)]
    held: Option<HeldSummary>,
}

/// Accuracy of the hover from `judged_from_s` on.
#[derive(Debug, Serialize)]
struct HeldSummary {
    velocity_rms_mps: [f64; 3],
    attitude_rms_deg: [f64; 2],
    heading_worst_deg: f64,
    position_rms_m: [f64; 3],
    sticks_rms: [f64; 4],
}

#[derive(Debug, Serialize)]
pub struct TransitionSummary {
    pub time_s: f64,
    pub from: String,
    pub to: String,
    pub reason: String,
}

#[derive(Debug, Serialize)]
pub struct DisturbanceSummary {
    pub time_s: f64,
    /// Largest tilt, °, and speed, m/s, in the 20 s after the disturbance.
    pub tilt_worst_deg: f64,
    pub speed_worst_mps: f64,
}

impl ClosedLoopSummary {
    pub fn new(config: &FlightConfig, flight: &Flight) -> Self {
        let velocities = VelocitySummary::of(config, flight);
        let is_judged = velocities.is_empty()
            && flight.samples.last().is_some_and(|last| last.truth.time.seconds() >= JUDGED_FROM_S);
        let held = is_judged.then(|| flight.statistics(JUDGED_FROM_S)).map(|held| HeldSummary {
            velocity_rms_mps: held.velocity_rms_mps,
            attitude_rms_deg: held.attitude_rms_deg,
            heading_worst_deg: held.heading_worst_deg,
            position_rms_m: held.position_rms_m,
            sticks_rms: held.sticks_rms,
        });
        let change = |change: &Transition| TransitionSummary {
            time_s: change.time.seconds(),
            from: format!("{:?}", change.from).to_lowercase(),
            to: format!("{:?}", change.to).to_lowercase(),
            reason: format!("{:?}", change.reason).to_lowercase(),
        };
        let is_disturbance = |event: &FlightEvent| {
            !matches!(
                event,
                FlightEvent::AddSticks(_) | FlightEvent::Excite(_) | FlightEvent::SetPoint(_)
            )
        };
        let disturbances = config.events.iter().filter(|(_, event)| is_disturbance(event));
        let disturbances = disturbances.map(|(at_s, _)| {
            let Excursion { tilt_rad, speed_mps } = flight.excursion(*at_s, FOLLOWED_S);
            DisturbanceSummary {
                time_s: *at_s,
                tilt_worst_deg: tilt_rad.to_degrees(),
                speed_worst_mps: speed_mps,
            }
        });
        Self {
            feedback: match config.feedback {
                Feedback::Estimator => "estimator",
                Feedback::Truth => "truth",
            },
            crashed_s: flight.crashed_s,
            last_mode: flight
                .samples
                .last()
                .map_or_else(|| "none".into(), |last| format!("{:?}", last.mode).to_lowercase()),
            transitions: flight.transitions.iter().map(change).collect(),
            disturbances: disturbances.collect(),
            velocities,
            judged_from_s: JUDGED_FROM_S,
            held,
        }
    }

    pub fn transitions(&self) -> &[TransitionSummary] {
        &self.transitions
    }

    /// The accuracy of the hover in one line; for set-points of velocity, one line for each. After a crash, the time of
    /// the crash.
    pub fn in_words(&self) -> String {
        if let Some(crashed_s) = self.crashed_s {
            return format!("crashed at {crashed_s:.2} s");
        }
        if !self.velocities.is_empty() {
            let each = self.velocities.iter().map(VelocitySummary::in_words);
            return each.collect::<Vec<_>>().join("\n");
        }
        let from_s = self.judged_from_s;
        let Some(held) = &self.held else {
            return format!(
                "no statistics: the evaluation of the hover begins at {from_s:.0} s, after the end of the flight"
            );
        };
        let [u, v, w] = held.velocity_rms_mps;
        let [roll, pitch] = held.attitude_rms_deg;
        let [north, east, down] = held.position_rms_m;
        format!(
            "from {from_s:.0} s on: u, v, w {u:.2}, {v:.2}, {w:.2} m/s, roll, pitch {roll:.1}°, {pitch:.1}°, \
             position {north:.1}, {east:.1}, {down:.1} m RMS, heading within {:.1}°",
            held.heading_worst_deg
        )
    }
}
