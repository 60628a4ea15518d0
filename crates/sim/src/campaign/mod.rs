//! Monte Carlo campaigns: the closed loop with random airframe, wind, sensors and GPS for each flight.
//!
//! The number of a flight seeds its own random stream. Every machine therefore flies it identically, on its own or
//! within ten thousand.
//!
//! ```
//! use hovernav::autopilot::HoverConfig;
//! use hovernav_design::hover::HoverDesign;
//! use hovernav_model::shipped;
//! use hovernav_sim::campaign::Campaign;
//!
//! let design = HoverDesign::default();
//! let gains = design.synthesise(&shipped::raptor60())?;
//! let campaign = Campaign { duration_s: 20.0, ..Campaign::new(HoverConfig::new(design.period_s, gains)) };
//! let draw = campaign.draw(7);
//! assert_eq!(draw, campaign.draw(7));
//! let result = campaign.fly(&draw)?;
//! assert_eq!(result.crash, None);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod airframe;
mod flights;
mod grade;
mod result;
mod table;

pub use airframe::{AirframeUncertainty, UNCERTAIN, UnknownSpread};
pub use flights::CampaignError;
pub use grade::SensorGrade;
pub use result::{CampaignResult, Draw, Failure, Outcome};
pub use table::{
    Cell, Column, Measure, PERCENTILES, count, failures, percentiles_csv, results_csv, seeds_of,
};

use std::ops::Range;

use super::axes::HorizontalVertical;
use super::dmu::DmuConfig;
use super::flight::{Flight, FlightConfig, FlightError, FlightEvent};
use super::noise::{Noise, Stream};
use hovernav::autopilot::{HoverConfig, Mode};
use hovernav::controls::Sticks;
use hovernav::frames::{Vector, wrap_angle};
use hovernav_dataset::Truth;
use hovernav_dataset::statistics::quantile;
use hovernav_model::{ModelError, StateSpace};

/// Settings of a campaign: the nominal flight, and the distributions of the variations.
#[derive(Clone, Debug, PartialEq)]
pub struct Campaign {
    /// The nominal flight, of which all flights are variations.
    pub nominal: FlightConfig,
    /// Duration of each flight, s.
    pub duration_s: f64,
    /// Time from which the hover is evaluated, s.
    pub judged_from_s: f64,
    /// Uncertainty of the airframe.
    pub airframe: AirframeUncertainty,
    /// Steady wind, uniform from 0 to this speed from any direction, m/s.
    pub max_wind_mps: f64,
    /// Standard deviation of the gusts relative to the wind speed; the gusts are at least
    /// [`min_gust_mps`](Self::min_gust_mps). A quarter is typical over open ground.
    pub gust_share: f64,
    /// Standard deviation of the weakest gusts, m/s.
    pub min_gust_mps: f64,
    /// Sensor grades, with equal probability.
    pub grades: Vec<SensorGrade>,
    /// Bounds within which a flight counts as a hover at its end.
    pub hover: HoverBounds,
    /// Fraction of the flights with one GPS outage.
    pub outage_share: f64,
    /// Shortest and longest outage, s.
    pub outage_s: Range<f64>,
    /// Fraction of the flights in which the engine stops once.
    pub power_loss_share: f64,
    /// Fraction of the flights in which one servo jams, each servo with equal probability.
    pub jam_share: f64,
    /// Fuel in a full tank, kg, half of it included in the nominal mass; 0 for constant mass. At the start of a flight
    /// the tank contains a random amount, at least the fuel that the flight burns. A full tank lasts twelve minutes, or
    /// the flight's own duration if that is longer.
    pub fuel_kg: f64,
}

/// Duration of a full tank, s.
const TANK_S: f64 = 720.0;
/// Interval at which the mass is updated, s.
const BURNT_S: f64 = 5.0;

/// Bounds of a hover: the flight ends in a hover if the true state stays within them over its last
/// [`lasts_s`](Self::lasts_s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HoverBounds {
    /// Length of the evaluation, s.
    pub lasts_s: f64,
    /// Fastest motion over the ground, m/s.
    pub speed_mps: f64,
    /// Steepest tilt, √(roll² + pitch²), rad.
    pub tilt_rad: f64,
    /// Largest distance, m, from the position at the start of the evaluation; it allows for the drift of the receiver's
    /// position.
    pub distance_m: f64,
    /// Largest change, rad, from the heading at the start of the evaluation.
    pub turned_rad: f64,
}

impl Default for HoverBounds {
    /// The bounds 1.5 m/s, 15°, 15 m and 20° over the last 5 s.
    fn default() -> Self {
        Self { lasts_s: 5.0, speed_mps: 1.5, tilt_rad: 0.26, distance_m: 15.0, turned_rad: 0.35 }
    }
}

impl HoverBounds {
    /// Whether `flight` ended in a hover at `station`, the vehicle's state at the start of the evaluation.
    fn hold(&self, flight: &Flight, station: &Truth) -> bool {
        let end_s = flight.samples.last().map_or(0.0, |sample| sample.truth.time.seconds());
        let from_s = end_s - self.lasts_s;
        let worst = flight.excursion(from_s, f64::INFINITY);
        let last = || {
            let samples = flight.samples.iter().map(|sample| &sample.truth);
            samples.filter(|truth| truth.time.seconds() >= from_s)
        };
        let distance_m = last()
            .map(|truth| truth.position.displacement_from(&station.position).norm())
            .fold(0.0, f64::max);
        let heading_rad = |truth: &Truth| truth.body_to_ned.euler().yaw_rad;
        let turned_rad = last()
            .map(|truth| wrap_angle(heading_rad(truth) - heading_rad(station)).abs())
            .fold(0.0, f64::max);
        worst.speed_mps <= self.speed_mps
            && worst.tilt_rad <= self.tilt_rad
            && distance_m <= self.distance_m
            && turned_rad <= self.turned_rad
    }
}

impl Campaign {
    /// Flights of one minute of hover with the 60-class helicopter under `autopilot`. The wind is up to 5 m/s, all
    /// sensor grades occur, and every fourth flight has an outage of 5 to 20 s.
    #[must_use]
    pub fn new(autopilot: HoverConfig) -> Self {
        Self {
            nominal: FlightConfig::new(autopilot),
            duration_s: 60.0,
            judged_from_s: 25.0,
            airframe: AirframeUncertainty::default(),
            max_wind_mps: 5.0,
            gust_share: 0.25,
            min_gust_mps: 0.3,
            grades: SensorGrade::ALL.to_vec(),
            hover: HoverBounds::default(),
            outage_share: 0.25,
            outage_s: 5.0..20.0,
            power_loss_share: 0.0,
            jam_share: 0.0,
            fuel_kg: 0.4,
        }
    }

    /// Flights of the linear `model` instead of the 60-class helicopter. Its covariance, or else 10 % of every
    /// derivative, varies. It burns no fuel and has no engine. The inertial unit has the rate of the autopilot.
    ///
    /// # Errors
    /// [`ModelError`] for a model that does not take its own derivatives as parameters.
    pub fn linear(autopilot: HoverConfig, model: &StateSpace) -> Result<Self, ModelError> {
        let mut campaign = Self::new(autopilot);
        let (varied, airframe) = AirframeUncertainty::of_linear(model)?;
        campaign.nominal.model = Some(varied);
        campaign.nominal.dmu.rate_hz = 1.0 / autopilot.period_s;
        (campaign.airframe, campaign.fuel_kg) = (airframe, 0.0);
        Ok(campaign)
    }

    /// The random draw of flight `seed`.
    #[must_use]
    pub fn draw(&self, seed: u64) -> Draw {
        let mut noise = Noise::new(seed, Stream::Campaign);
        let drawn = self.airframe.draw(&mut noise);
        let speed = self.max_wind_mps * noise.uniform();
        let (sin, cos) = (std::f64::consts::TAU * noise.uniform()).sin_cos();
        let gust_mps = (self.gust_share * speed).max(self.min_gust_mps);
        let pick = (noise.uniform() * self.grades.len() as f64) as usize;
        let grade = self.grades.get(pick).copied().unwrap_or(SensorGrade::Thesis);
        let (has_outage, length, begin) = (noise.uniform(), noise.uniform(), noise.uniform());
        let Range { start: shortest, end: longest } = self.outage_s;
        let length_s = shortest + (longest - shortest) * length;
        // The outage ends before the flight does, so that the outcome includes the recovery.
        let latest_s = self.duration_s - length_s - 10.0;
        let outage_s =
            (has_outage < self.outage_share && latest_s > self.judged_from_s).then(|| {
                let from_s = self.judged_from_s + (latest_s - self.judged_from_s) * begin;
                from_s..from_s + length_s
            });
        let (loses_power, when) = (noise.uniform(), noise.uniform());
        let at_s = |when: f64| self.judged_from_s + (self.duration_s - self.judged_from_s) * when;
        let power_loss_s = (loses_power < self.power_loss_share).then_some(at_s(when));
        let (jams, which, when) = (noise.uniform(), noise.uniform(), noise.uniform());
        let stick = ((which * Sticks::NAMES.len() as f64) as usize).min(Sticks::NAMES.len() - 1);
        let jam = (jams < self.jam_share).then_some((stick, at_s(when)));
        let wind_mps = [speed * cos, speed * sin];
        let burnt_kg = self.burnt_kgps() * self.duration_s;
        let fuel_kg = burnt_kg + (self.fuel_kg - burnt_kg) * noise.uniform();
        Draw { seed, drawn, wind_mps, gust_mps, grade, outage_s, power_loss_s, jam, fuel_kg }
    }

    /// Fuel consumption, kg/s.
    fn burnt_kgps(&self) -> f64 {
        self.fuel_kg / TANK_S.max(self.duration_s)
    }

    /// Mass of the vehicle of `draw` at regular times, s and kg.
    fn masses_kg(&self, draw: &Draw) -> impl Iterator<Item = (f64, f64)> {
        let empty_kg = self.nominal.helicopter.mass_kg * draw.drawn.first().copied().unwrap_or(1.0)
            - 0.5 * self.fuel_kg;
        let (fuel_kg, burnt_kgps) = (draw.fuel_kg, self.burnt_kgps());
        let changes = if burnt_kgps > 0.0 { self.duration_s / BURNT_S } else { 0.0 };
        (0..=changes as u32).map(move |change| {
            let at_s = BURNT_S * f64::from(change);
            (at_s, empty_kg + fuel_kg - burnt_kgps * at_s)
        })
    }

    /// The nominal flight with the variations of `draw`.
    ///
    /// # Errors
    /// [`FlightError::Model`] for drawn derivatives that are not finite.
    pub fn flight(&self, draw: &Draw) -> Result<FlightConfig, FlightError> {
        let (dmu, mut gps) = draw.grade.sensors();
        gps.outages_s.extend(draw.outage_s.clone());
        let [north, east] = draw.wind_mps;
        let mut masses_kg = self.masses_kg(draw);
        let (mut helicopter, mut model) = (self.nominal.helicopter, self.nominal.model.clone());
        if let Some(model) = &mut model {
            *model = self.airframe.moved(model, &draw.drawn)?;
        } else {
            helicopter = airframe::airframe(&helicopter, &draw.drawn);
            helicopter.mass_kg = masses_kg.next().map_or(helicopter.mass_kg, |(_, own)| own);
        }
        let mut flight = FlightConfig {
            helicopter,
            model,
            // The sticks' trim is that of the nominal airframe: a difference in mass appears in the sticks.
            rigged_for: Some(self.nominal.rigged_for.unwrap_or(self.nominal.helicopter)),
            dmu: DmuConfig { rate_hz: self.nominal.dmu.rate_hz, ..dmu },
            gps,
            duration_s: self.duration_s,
            seed: draw.seed,
            ..self.nominal.clone()
        };
        flight.events.extend(draw.power_loss_s.map(|at_s| (at_s, FlightEvent::PowerLoss)));
        flight.events.extend(draw.jam.map(|(stick, at_s)| (at_s, FlightEvent::Jam(stick))));
        if flight.model.is_none() {
            let masses = masses_kg.map(|(at_s, mass_kg)| (at_s, FlightEvent::Mass(mass_kg)));
            flight.events.extend(masses);
        }
        flight.events.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        let wind = &mut flight.wind;
        wind.steady_mps = Vector::new(north, east, 0.0);
        wind.gust_sigma_mps = HorizontalVertical::new(draw.gust_mps, 0.5 * draw.gust_mps);
        wind.passing_mps = north.hypot(east).max(1.0);
        Ok(flight)
    }

    /// Flies `draw` and evaluates the flight.
    ///
    /// # Errors
    /// [`FlightError`] for an invalid nominal flight or drawn airframe.
    pub fn fly(&self, draw: &Draw) -> Result<CampaignResult, FlightError> {
        let flight = self.flight(draw)?.fly()?;
        let judged = flight
            .samples
            .partition_point(|sample| sample.truth.time.seconds() < self.judged_from_s);
        let judged = flight.samples.get(judged..).unwrap_or_default();
        let tilt = |angles: hovernav::frames::EulerAngles| angles.roll_rad.hypot(angles.pitch_rad);
        let largest = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let station = judged.first().map(|sample| sample.truth);
        let outcome = match flight.samples.last().map(|sample| sample.mode) {
            _ if flight.crashed_s.is_some() => Outcome::Crashed,
            Some(Mode::Position)
                if station.is_some_and(|station| self.hover.hold(&flight, &station)) =>
            {
                Outcome::Hovered
            }
            Some(Mode::Manual) | None => Outcome::NotEngaged,
            Some(_) => Outcome::Degraded,
        };
        Ok(CampaignResult {
            draw: draw.clone(),
            outcome,
            crash: flight.crashed_s.zip(flight.crash),
            engaged_s: self.nominal.engage_s,
            hover: (!judged.is_empty()).then(|| flight.statistics(self.judged_from_s)),
            tilt_worst_deg: largest(
                &mut judged.iter().map(|m| tilt(m.truth.body_to_ned.euler()).to_degrees()),
            ),
            distance_worst_m: largest(&mut station.iter().flat_map(|station| {
                judged.iter().map(|m| m.truth.position.displacement_from(&station.position).norm())
            })),
        })
    }

    /// Numbers of the flights for machine `shard` of `shards`. Of `flights` flights from `first` on, these are the
    /// numbers with the same remainder by `shards` as `shard`. Numbers beyond the largest integer are omitted.
    pub fn seeds(first: u64, flights: u64, shard: u64, shards: u64) -> impl Iterator<Item = u64> {
        (first..=u64::MAX)
            .zip(0..flights)
            .map(|(seed, _)| seed)
            .filter(move |seed| seed % shards.max(1) == shard % shards.max(1))
    }
}

/// The value that a fraction `share`, 0 to 1, of `values` does not exceed, by linear interpolation between ranks; NaN
/// for no values. NaN values are ignored.
#[must_use]
pub fn percentile(values: &[f64], share: f64) -> f64 {
    let mut finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    quantile(&mut finite, share).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use nalgebra::DMatrix;

    use hovernav::autopilot::Gains;
    use hovernav_model::{Parameter, Signal, TimeDomain, shipped};

    fn campaign() -> Campaign {
        Campaign::new(HoverConfig::new(1.0 / 33.0, Gains::default()))
    }

    #[test]
    fn shards_share_the_flights_among_them_and_leave_none_out() {
        let mut all: Vec<u64> = (1..=3).flat_map(|k| Campaign::seeds(7, 100, k, 3)).collect();
        all.sort_unstable();
        assert_eq!(all, (7..=106).collect::<Vec<_>>());
        assert_eq!(Campaign::seeds(u64::MAX, 100, 1, 1).count(), 1);
    }

    #[test]
    fn draws_have_the_standard_deviation_asked_for() {
        let campaign = campaign();
        let draws: Vec<Draw> = (1..=4000).map(|seed| campaign.draw(seed)).collect();
        for (index, name) in UNCERTAIN.into_iter().enumerate() {
            let squares = draws.iter().map(|draw| (draw.drawn[index] - 1.0).powi(2));
            let sigma = (squares.sum::<f64>() / 4000.0).sqrt();
            let expected = if name == "mass" { 0.05 } else { 0.1 };
            assert!((sigma / expected - 1.0).abs() < 0.05, "{name} {sigma}");
        }
        let outages = draws.iter().filter(|draw| draw.outage_s.is_some()).count();
        assert!((900..1100).contains(&outages), "{outages}");
        assert!(draws.iter().all(|draw| draw.wind_mps[0].hypot(draw.wind_mps[1]) <= 5.0));
    }

    #[test]
    fn every_servo_jams_as_often_and_nothing_else_is_drawn_otherwise_for_it() {
        let without = campaign();
        let with = Campaign { jam_share: 0.5, ..campaign() };
        let mut jams = [0; 4];
        for seed in 1..=4000 {
            let draw = with.draw(seed);
            assert_eq!(Draw { jam: None, ..draw.clone() }, without.draw(seed));
            let Some((stick, at_s)) = draw.jam else { continue };
            jams[stick] += 1;
            assert!((with.judged_from_s..=with.duration_s).contains(&at_s));
            let events = with.flight(&draw).unwrap().events;
            assert!(events.contains(&(at_s, FlightEvent::Jam(stick))));
        }
        assert!(jams.iter().all(|&own| (430..570).contains(&own)), "{jams:?}");
    }

    #[test]
    fn fuel_is_drawn_and_burnt_in_flight_and_changes_nothing_else() {
        let (with, without) = (campaign(), Campaign { fuel_kg: 0.0, ..campaign() });
        let burnt_kg = 0.4 * with.duration_s / 720.0;
        let (mut least, mut most) = (f64::INFINITY, 0.0);
        for seed in 1..=1000 {
            let draw = with.draw(seed);
            assert_eq!(Draw { fuel_kg: 0.0, ..draw.clone() }, without.draw(seed));
            (least, most) = (f64::min(least, draw.fuel_kg), f64::max(most, draw.fuel_kg));
            let flight = with.flight(&draw).unwrap();
            let dry = without.flight(&without.draw(seed)).unwrap();
            assert_eq!(dry.events, Vec::new());
            let start_kg = flight.helicopter.mass_kg;
            assert_abs_diff_eq!(
                start_kg - dry.helicopter.mass_kg,
                draw.fuel_kg - 0.2,
                epsilon = 1e-9
            );
            let Some((end_s, FlightEvent::Mass(end_kg))) = flight.events.last() else {
                panic!("it burns")
            };
            assert_eq!(*end_s, with.duration_s);
            assert_abs_diff_eq!(start_kg - end_kg, burnt_kg, epsilon = 1e-9);
        }
        assert!(least >= burnt_kg && least < burnt_kg + 0.01 && most > 0.39 && most <= 0.4);
        let long = Campaign { duration_s: 3600.0, ..campaign() };
        assert_eq!(long.draw(1).fuel_kg, 0.4);
    }

    #[test]
    fn an_identified_covariance_is_drawn_with_its_correlations() {
        let parameter = |name: &str, value| Parameter { name: name.into(), value, unit: "".into() };
        let identity = DMatrix::identity(1, 1);
        let signal = || vec![Signal::new("r", "rad/s")];
        let model = StateSpace::new(
            "yaw",
            TimeDomain::Continuous,
            signal(),
            signal(),
            identity.clone(),
            identity,
        )
        .unwrap()
        .with_parameters(
            vec![parameter("Nr", -10.0), parameter("Nped", 20.0)],
            Some(DMatrix::from_row_slice(2, 2, &[0.25, -0.45, -0.45, 1.0])),
        )
        .unwrap();
        let airframe = AirframeUncertainty::of_model(&model);
        assert_eq!(airframe.identified(), ["Nr", "Nped"]);
        let campaign = Campaign { airframe, ..campaign() };
        let draws: Vec<[f64; 2]> = (1..=4000)
            .map(|seed| campaign.draw(seed).drawn)
            .map(|drawn| [drawn[6] - 1.0, drawn[7] - 1.0])
            .collect();
        let mean = |value: &dyn Fn(&[f64; 2]) -> f64| draws.iter().map(value).sum::<f64>() / 4000.0;
        let (one, other) = (mean(&|d| d[0] * d[0]).sqrt(), mean(&|d| d[1] * d[1]).sqrt());
        assert_abs_diff_eq!(one, 0.05, epsilon = 0.003);
        assert_abs_diff_eq!(other, 0.05, epsilon = 0.003);
        // −0.45/(−10 · 20) over 0.05²: the signs of the values reverse that of the correlation.
        let correlation = mean(&|d| d[0] * d[1]) / (one * other);
        assert_abs_diff_eq!(correlation, 0.9, epsilon = 0.02);
    }

    #[test]
    fn a_linear_model_by_hand_varies_in_every_derivative_but_not_in_its_kinematics() {
        let model = shipped::mettler_r50();
        let (varied, airframe) = AirframeUncertainty::of_linear(&model).unwrap();
        assert!(airframe.columns().any(|name| name == "p_b") && airframe.identified().is_empty());
        assert!(!airframe.columns().any(|name| ["u_theta", "phi_p", "b_p"].contains(&&*name)));
        let unknown = airframe.clone().with_spread("mass", 0.1).unwrap_err();
        assert!(unknown.to_string().starts_with("found \"mass\", expected one of"), "{unknown}");
        let exact = airframe.columns().filter(|name| name != "w_w");
        let mut only = airframe.clone();
        for name in exact {
            only = only.with_spread(&name, 0.0).unwrap();
        }
        let only = only.with_spread("w_w", 0.2).unwrap();
        let campaign = Campaign {
            airframe: only,
            ..Campaign::linear(campaign().nominal.autopilot, &model).unwrap()
        };
        let w = model.state("w").unwrap();
        let offs: Vec<f64> = (1..=500)
            .map(|seed| {
                let flown = campaign.flight(&campaign.draw(seed)).unwrap().model.unwrap();
                let mut off = flown.a() - model.a();
                let own = off[(w, w)] / model.a()[(w, w)];
                off[(w, w)] = 0.0;
                assert_eq!(off.amax(), 0.0);
                own
            })
            .collect();
        let sigma = (offs.iter().map(|off| off * off).sum::<f64>() / 500.0).sqrt();
        assert_abs_diff_eq!(sigma, 0.2, epsilon = 0.02);
        assert_eq!(varied.a(), model.a());
    }

    #[test]
    fn percentiles_interpolate_between_ranks() {
        assert_eq!(percentile(&[4.0, 1.0, f64::NAN, 3.0, 2.0], 0.5), 2.5);
        assert_eq!(percentile(&[4.0, 1.0], 1.0), 4.0);
        assert!(percentile(&[], 0.5).is_nan());
    }
}
