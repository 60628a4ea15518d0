//! Test points during the flight: the size and duration of each stick step, and whether the data are sufficient for
//! identification.
//!
//! Source: Paw (2005), section 5.2: three repetitions of a step of 10 to 15 % of the control held for 1.5 s, the other
//! sticks at trim.

use hovernav_sysid::methods::frequency::{Band, SpectrumSettings, Window, spectra};
use hovernav_sysid::nalgebra::DMatrix;
use serde::Serialize;

use crate::channel::Id;
use crate::store::{Batch, Store};

/// The pilot's sticks, each with its main response.
const STICKS: [(Id, &str, Id); 4] = [
    (Id::StickLateral, "lateral", Id::RateP),
    (Id::StickLongitudinal, "longitudinal", Id::RateQ),
    (Id::StickCollective, "collective", Id::AccelZ),
    (Id::StickPedal, "pedal", Id::RateR),
];

/// Deviation from trim at which a step begins, %.
const BEGINS_PCT: f64 = 5.0;
/// Deviation from trim at which a step ends, %.
const ENDS_PCT: f64 = 3.0;
/// Longest step, s; a longer one is a new trim.
const LONGEST_S: f64 = 4.0;
/// Shortest step, s; a shorter one is ordinary flying.
const SHORTEST_S: f64 = 0.4;
/// Smallest step, %; a smaller one is ordinary flying.
const MIN_PCT: f64 = 7.0;
/// Averaging time of the trim, s.
const TRIM_S: f64 = 3.0;
/// Required size of a step, %.
const SIZE_PCT: (f64, f64) = (10.0, 15.0);
/// Required duration of a step, s.
const HELD_S: (f64, f64) = (1.3, 1.7);
/// Largest movement of another stick during a step, %.
const OTHERS_PCT: f64 = 5.0;
/// Largest drift of trim from the first to the last step, %.
const DRIFT_PCT: f64 = 4.0;
/// Number of steps per stick.
const REPETITIONS: usize = 3;
/// Minimum coherence: Tischler & Remple, section 7.5.2.
const COHERENCE: f64 = 0.6;
/// Decay time of the response to a step, s.
const TAIL_S: f64 = 4.0;
/// Largest number of stored steps.
const KEPT: usize = 60;

/// A finished step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// The stick.
    pub stick: &'static str,
    /// Start, seconds since the start of 1970.
    pub start_s: f64,
    /// Deviation from trim, % of full stick.
    pub size_pct: f64,
    /// Duration, s.
    pub held_s: f64,
    /// Trim position, %.
    pub trim_pct: f64,
    /// Why the step does not count; `None` if it counts.
    pub fault: Option<String>,
}

/// The progress of the test of one stick.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Progress {
    /// The stick.
    pub stick: &'static str,
    /// Number of valid steps.
    pub good: usize,
    /// Number of required steps.
    pub wanted: usize,
    /// Drift of trim from the first to the last step, %.
    pub drift_pct: f64,
    /// Coherence between the stick and its main response, 0 to 1, averaged over 0.3 to 2 Hz with the stick's power as
    /// weight.
    pub coherence: Option<f64>,
    /// The verdict in words.
    pub verdict: String,
}

/// A step in progress.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnderWay {
    /// The stick.
    pub stick: &'static str,
    /// Deviation from trim, %.
    pub size_pct: f64,
    /// Duration until now, s.
    pub held_s: f64,
}

/// Detects test points during the flight.
#[derive(Clone, Debug, Default)]
pub struct TestPoints {
    trim: [Option<f64>; 4],
    before_s: Option<f64>,
    flown: [Option<Flown>; 4],
    steps: Vec<Step>,
    judged: usize,
    /// Time at which the response to the last step has decayed, if that step is not yet evaluated.
    due_s: Option<f64>,
    progress: Vec<Progress>,
}

#[derive(Clone, Debug)]
struct Flown {
    start_s: f64,
    now_s: f64,
    /// Deviations of this stick from trim, %.
    deviations: Vec<f64>,
    /// Positions of all sticks at the start, %.
    began_at: [f64; 4],
    /// Largest movement of another stick since the start, %.
    others_pct: f64,
}

impl TestPoints {
    /// Processes a batch of values.
    pub fn observe(&mut self, batch: &Batch) {
        let value =
            |id| batch.values.iter().find(|(other, _)| *other == id).map(|(_, value)| *value);
        let mut sticks = [0.0; 4];
        for (slot, (id, ..)) in sticks.iter_mut().zip(STICKS) {
            match value(id) {
                Some(value) if !value.is_nan() => *slot = value,
                // A batch without this stick: it is a supplement, or the pilot's signal is missing.
                None => return,
                Some(_) => return self.forget(),
            }
        }
        let elapsed_s =
            self.before_s.replace(batch.time_s).map_or(0.0, |before| batch.time_s - before);
        if !(0.0..=1.0).contains(&elapsed_s) {
            return self.forget();
        }
        self.step(batch.time_s, elapsed_s, sticks);
    }

    /// Forgets the trim and the steps in progress; an outage makes them invalid.
    fn forget(&mut self) {
        (self.trim, self.flown) = ([None; 4], [const { None }; 4]);
    }

    fn step(&mut self, now_s: f64, elapsed_s: f64, sticks: [f64; 4]) {
        for (stick, value) in sticks.into_iter().enumerate() {
            let trim = *self.trim[stick].get_or_insert(value);
            let away = value - trim;
            if let Some(flown) = &mut self.flown[stick] {
                flown.now_s = now_s;
                let others = (0..4).filter(|other| *other != stick);
                let moved = others.map(|other| (sticks[other] - flown.began_at[other]).abs());
                flown.others_pct = moved.fold(flown.others_pct, f64::max);
                if away.abs() <= ENDS_PCT {
                    if let Some(flown) = self.flown[stick].take() {
                        self.finish(stick, flown, trim);
                    }
                } else if now_s - flown.start_s > LONGEST_S {
                    (self.trim[stick], self.flown[stick]) = (None, None);
                } else {
                    flown.deviations.push(away);
                }
            } else if away.abs() > BEGINS_PCT {
                let (deviations, began_at) = (vec![away], sticks);
                let flown = Flown { start_s: now_s, now_s, deviations, began_at, others_pct: 0.0 };
                self.flown[stick] = Some(flown);
            } else {
                let share = (elapsed_s / TRIM_S).min(1.0);
                self.trim[stick] = Some(trim + share * away);
            }
        }
    }

    fn finish(&mut self, stick: usize, flown: Flown, trim_pct: f64) {
        let held_s = flown.now_s - flown.start_s;
        let mut deviations = flown.deviations;
        deviations.sort_by(f64::total_cmp);
        let size_pct = deviations[deviations.len() / 2];
        let (name, size) = (STICKS[stick].1, size_pct.abs());
        if held_s < SHORTEST_S || size < MIN_PCT {
            return;
        }
        let fault = if !(SIZE_PCT.0 - 0.5..=SIZE_PCT.1 + 0.5).contains(&size) {
            Some(format!("found {size:.1} %, expected 10 to 15 %"))
        } else if !(HELD_S.0..=HELD_S.1).contains(&held_s) {
            Some(format!("held {held_s:.2} s, expected 1.5 s"))
        } else if flown.others_pct > OTHERS_PCT {
            Some(format!("another stick moved by {:.1} % during the step", flown.others_pct))
        } else {
            None
        };
        if self.steps.len() == KEPT {
            self.steps.remove(0);
            self.judged = self.judged.saturating_sub(1);
        }
        self.due_s = Some(flown.now_s + TAIL_S);
        self.steps.push(Step {
            stick: name,
            start_s: flown.start_s,
            size_pct,
            held_s,
            trim_pct,
            fault,
        });
    }

    /// Updates the progress, if there are new steps or data.
    pub fn judge(&mut self, store: &Store) {
        let now_s = store.span().map_or(f64::NEG_INFINITY, |(_, to_s)| to_s);
        let is_due = self.due_s.is_some_and(|due_s| now_s >= due_s);
        if self.progress.len() == STICKS.len() && self.judged == self.steps.len() && !is_due {
            return;
        }
        if is_due {
            self.due_s = None;
        }
        self.judged = self.steps.len();
        self.progress = STICKS.iter().map(|stick| self.progress_of(stick, store)).collect();
    }

    fn progress_of(&self, &(id, name, answer): &(Id, &'static str, Id), store: &Store) -> Progress {
        let good: Vec<&Step> =
            self.steps.iter().filter(|step| step.stick == name && step.fault.is_none()).collect();
        // The newest steps of a complete test point.
        let last = &good[good.len().saturating_sub(REPETITIONS)..];
        let trims = || last.iter().map(|step| step.trim_pct);
        let drift_pct =
            trims().fold(f64::NEG_INFINITY, f64::max) - trims().fold(f64::INFINITY, f64::min);
        let drift_pct = if drift_pct.is_finite() { drift_pct } else { 0.0 };
        let ends = last.first().zip(last.last());
        let coherence = ends.and_then(|(first, last)| {
            let (from_s, to_s) = (first.start_s - 2.0, last.start_s + last.held_s + TAIL_S);
            let to_s = store.span().map_or(to_s, |(_, end_s)| to_s.min(end_s));
            coherence(store, id, answer, from_s, to_s)
        });
        let verdict = match (last.len(), coherence) {
            (0, _) => "not flown".to_owned(),
            (count, _) if count < REPETITIONS => format!("{} more steps", REPETITIONS - count),
            _ if drift_pct > DRIFT_PCT => {
                format!(
                    "trim drifted by {drift_pct:.1} %, at most {DRIFT_PCT} % allowed: fly it again"
                )
            }
            (_, Some(found)) if found < COHERENCE => {
                format!("coherence {found:.2}, at least {COHERENCE} required: fly it again")
            }
            (_, None) => "flown; the record is too short to compute the coherence".to_owned(),
            _ => "good".to_owned(),
        };
        let (good, wanted) = (last.len(), REPETITIONS);
        Progress { stick: name, good, wanted, drift_pct, coherence, verdict }
    }

    /// The progress of each stick.
    #[must_use]
    pub fn progress(&self) -> &[Progress] {
        &self.progress
    }

    /// The newest steps, in order of time.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps[self.steps.len().saturating_sub(12)..]
    }

    /// The step in progress. If several sticks are away from trim, it is the largest step.
    #[must_use]
    pub fn under_way(&self) -> Option<UnderWay> {
        let flown = self.flown.iter().zip(STICKS);
        let of = |(flown, (_, stick, _)): (&Option<Flown>, (Id, &'static str, Id))| {
            let flown = flown.as_ref()?;
            let size_pct = flown.deviations.last().copied().unwrap_or_default();
            Some(UnderWay { stick, size_pct, held_s: flown.now_s - flown.start_s })
        };
        flown.filter_map(of).max_by(|a, b| a.size_pct.abs().total_cmp(&b.size_pct.abs()))
    }
}

/// Sample rate for the coherence, Hz.
const RATE_HZ: f64 = 33.0;

/// The coherence between two channels, averaged with the power of the first as weight.
fn coherence(store: &Store, stick: Id, answer: Id, from_s: f64, to_s: f64) -> Option<f64> {
    let samples = ((to_s - from_s) * RATE_HZ) as usize;
    let at = |id: Id, k: usize| store.series(id).at(from_s + k as f64 / RATE_HZ);
    let record: Option<Vec<f64>> =
        (0..samples).map(|k| at(stick, k)).chain((0..samples).map(|k| at(answer, k))).collect();
    let record = DMatrix::from_vec(samples, 2, record?);
    let settings = SpectrumSettings {
        window_s: (0.5 * (to_s - from_s)).min(10.0),
        overlap: 0.8,
        window: Window::Hann,
        band: Band { first_hz: 0.3, last_hz: 2.0, points: 18 },
    };
    let found = spectra(&[&record], 1.0 / RATE_HZ, &settings).ok()?;
    let (mut weighted, mut power) = (0.0, 0.0);
    for density in &found.densities {
        let (input, output) = (density[(0, 0)].re, density[(1, 1)].re);
        if input * output > 0.0 {
            weighted += input * density[(0, 1)].norm_sqr() / (input * output);
            power += input;
        }
    }
    (power > 0.0).then(|| weighted / power)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Flies the lateral stick through `steps` (size, duration), 6 s apart, with a first-order roll rate as the
    /// response.
    fn flown(steps: &[(f64, f64)], noise: f64) -> TestPoints {
        heard_from(0.0, steps, noise)
    }

    /// The same flight as [`flown`], without telemetry before `first_s`.
    fn heard_from(first_s: f64, steps: &[(f64, f64)], noise: f64) -> TestPoints {
        let (mut store, mut points) = (Store::new(100_000), TestPoints::default());
        let (mut rate, mut seed) = (0.0, 1u32);
        for k in 0..(33 * (10 + 6 * steps.len())) {
            let time_s = k as f64 / 33.0;
            let place = ((time_s - 5.0) / 6.0).floor();
            let inside = time_s - 5.0 - 6.0 * place;
            let step = steps.get(place as usize).filter(|_| place >= 0.0);
            let stick =
                step.map_or(0.0, |(size, held_s)| if inside < *held_s { *size } else { 0.0 });
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let random = f64::from(seed >> 8) / f64::from(1u32 << 24) - 0.5;
            rate += (stick - 5.0 * rate) / 33.0;
            let values = vec![
                (Id::StickLateral, 2.0 + stick),
                (Id::StickLongitudinal, -3.0),
                (Id::StickCollective, 10.0),
                (Id::StickPedal, 0.0),
                (Id::RateP, rate + noise * random),
            ];
            let batch = Batch { time_s, values };
            if time_s < first_s {
                continue;
            }
            store.push(&batch);
            points.observe(&batch);
        }
        points.judge(&store);
        points
    }

    #[test]
    fn a_link_that_comes_back_during_a_step_does_not_turn_steps_and_trim_around() {
        let points = heard_from(5.7, &[(12.0, 1.5); 6], 0.02);
        let lateral = &points.progress()[0];
        assert_eq!((lateral.good, lateral.verdict.as_str()), (3, "good"), "{lateral:?}");
    }

    #[test]
    fn three_good_steps_are_a_test_point() {
        let points = flown(&[(12.0, 1.5), (-11.0, 1.5), (13.0, 1.5)], 0.02);
        assert_eq!(points.steps().len(), 3, "{:?}", points.steps());
        let lateral = &points.progress()[0];
        assert_eq!((lateral.good, lateral.verdict.as_str()), (3, "good"), "{lateral:?}");
        assert!(lateral.coherence.unwrap() > 0.9, "{lateral:?}");
        assert_eq!(points.progress()[3].verdict, "not flown");
    }

    #[test]
    fn a_step_that_does_not_count_says_why() {
        let points = flown(&[(8.0, 1.5), (12.0, 0.8), (12.0, 1.5)], 0.0);
        let faults: Vec<_> = points.steps().iter().map(|step| step.fault.clone()).collect();
        assert!(faults[0].as_ref().unwrap().contains("8.0 %, expected 10 to 15"), "{faults:?}");
        assert!(faults[1].as_ref().unwrap().contains("expected 1.5 s"), "{faults:?}");
        assert_eq!(faults[2], None);
        assert_eq!(points.progress()[0].verdict, "2 more steps");
    }

    #[test]
    fn an_answer_that_drowns_in_noise_is_not_good_enough() {
        let points = flown(&[(12.0, 1.5), (-12.0, 1.5), (12.0, 1.5)], 200.0);
        let lateral = &points.progress()[0];
        assert!(lateral.verdict.contains("fly it again"), "{lateral:?}");
    }
}
