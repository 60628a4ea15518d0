//! Effect of a fix on the sticks, separated from that of gusts and vibration.
//!
//! A flight is flown once. Then the same estimator and autopilot process its sensor data again, sample by sample. At
//! every fix a twin of both processes the data without this fix. Gusts and everything else are equal, so the
//! difference of the sticks is the effect of the fix.

use hovernav::autopilot::{HoverAutopilot, Inputs, Outputs};
use hovernav::controls::Sticks;
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, SteplessSolution};
use hovernav::event::{BaroReading, Event};
use hovernav::frames::{EulerAngles, wrap_angle};
use hovernav::time::Time;
use hovernav_sim::{Feedback, Flight, FlightConfig, FlightEvent};

use crate::autopilot;

/// Duration of a fix's effect before the next one, cycles.
const AFTER: usize = 33;

/// Estimator and autopilot as in the flight computer.
#[derive(Clone)]
struct Hearing {
    estimator: Estimator<Full, 28>,
    stepless: SteplessSolution,
    autopilot: HoverAutopilot,
}

impl Hearing {
    fn new(config: &FlightConfig) -> Self {
        Self {
            estimator: Estimator::new(config.settings().unwrap()),
            stepless: SteplessSolution::default(),
            autopilot: HoverAutopilot::new(config.autopilot).unwrap(),
        }
    }

    fn observe(&mut self, event: &Event) {
        let Self { estimator, stepless, autopilot } = self;
        autopilot.observe(event);
        estimator.push_traced(event, stepless, |notice| autopilot.observe_notice(&notice));
    }

    fn step(&mut self, now: Time, pilot: Sticks, engage: bool) -> Outputs {
        let solution = self.estimator.solution().map(|own| self.stepless.solution(&own));
        let inputs = Inputs { now, solution: solution.as_ref(), pilot: Some(pilot), engage };
        self.autopilot.step(&inputs)
    }
}

fn difference(one: Sticks, other: Sticks) -> [f64; 4] {
    let (one, other) = (one.to_array(), other.to_array());
    std::array::from_fn(|stick| one[stick] - other[stick])
}

fn largest(values: [f64; 4]) -> f64 {
    values.into_iter().fold(0.0, |most, value| most.max(value.abs()))
}

/// Largest changes of a stick from one cycle to the next, in full sticks.
#[derive(Clone, Copy, Debug, Default)]
struct Steps {
    /// Largest change in cycles with a fix.
    at_fixes: f64,
    between: f64,
    /// Largest change that the fix itself causes, in any cycle after it.
    by_fixes: f64,
    /// Root mean square of the changes on all axes, in cycles without a fix.
    usual: f64,
    fixes: u32,
}

fn steps(config: &FlightConfig, flight: &Flight) -> Steps {
    let mut hearing = Hearing::new(config);
    // Twins without the latest fix: each with its age in cycles, and the effect of the fix in the previous cycle.
    let mut twin: Option<(Hearing, usize, [f64; 4])> = None;
    let mut steps = Steps::default();
    let mut pilot = flight.samples[0].sticks;
    let mut before: Option<Sticks> = None;
    let (mut squares, mut count) = (0.0, 0u32);
    let mut fixes = flight.fixes.iter().peekable();
    for (sample, imu) in flight.samples.iter().zip(&flight.imu) {
        let now = sample.truth.time;
        let engage = now.seconds() >= config.engage_s - 1e-9;
        if !engage {
            pilot = sample.sticks;
        }
        let mut events = vec![Event::Imu(*imu)];
        hearing.observe(&events[0]);
        let without = hearing.clone();
        let fix = fixes.next_if(|fix| (fix.time - now).abs() < 1e-6);
        if let Some(fix) = fix {
            hearing.observe(&Event::Gps(*fix));
        }
        for (_, height_m) in flight.baro.iter().filter(|(measured, _)| *measured == now) {
            events.push(Event::Baro(BaroReading::new(now, *height_m)));
            hearing.observe(&events[1]);
        }
        let flown = hearing.step(now, pilot, engage).sticks;
        assert_eq!(flown, sample.sticks, "replayed as flown, {now}");

        // The evaluation begins after the transients of engagement.
        let judged = now.seconds() > config.engage_s + 5.0;
        let moved = before.replace(flown).map_or([0.0; 4], |before| difference(flown, before));
        if judged {
            let slot = if fix.is_some() { &mut steps.at_fixes } else { &mut steps.between };
            *slot = slot.max(largest(moved));
            if fix.is_none() {
                squares += moved.iter().map(|value| value * value).sum::<f64>();
                count += 1;
            }
        }
        if fix.is_some() {
            steps.fixes += u32::from(judged);
            // The twin already has this cycle's sample. It also gets the barometer's height, which is not an effect of
            // the fix.
            let mut other = without;
            events[1..].iter().for_each(|event| other.observe(event));
            let done = difference(flown, other.step(now, pilot, engage).sticks);
            if judged {
                steps.by_fixes = steps.by_fixes.max(largest(done));
            }
            twin = Some((other, 1, done));
        } else if let Some((other, cycles, done)) = twin.as_mut().filter(|(_, k, _)| *k < AFTER) {
            events.iter().for_each(|event| other.observe(event));
            let now_done = difference(flown, other.step(now, pilot, engage).sticks);
            let step = std::array::from_fn(|stick| now_done[stick] - done[stick]);
            if judged {
                steps.by_fixes = steps.by_fixes.max(largest(step));
            }
            (*cycles, *done) = (*cycles + 1, now_done);
        }
    }
    steps.usual = (squares / f64::from(count)).sqrt();
    steps
}

fn flown(seed: u64, duration_s: f64) -> Steps {
    let config = FlightConfig { seed, duration_s, ..FlightConfig::new(autopilot()) };
    let flight = config.fly().unwrap();
    assert_eq!(flight.crashed_s, None);
    let steps = steps(&config, &flight);
    println!(
        "seed {seed}: {} fixes, steps at them up to {:.2} %, between them {:.2} % ({:.2} % RMS), \
         of the fixes' own doing {:.2} %",
        steps.fixes,
        100.0 * steps.at_fixes,
        100.0 * steps.between,
        100.0 * steps.usual,
        100.0 * steps.by_fixes,
    );
    steps
}

#[test]
fn no_fix_moves_a_stick_by_more_than_3_percent() {
    for seed in 1..=3 {
        let steps = flown(seed, 80.0);
        assert!(steps.fixes > 40 && steps.by_fixes < 0.03, "{steps:?}");
    }
}

/// The same check for twenty complete flights.
#[test]
#[ignore = "a minute"]
fn no_fix_of_twenty_flights_moves_a_stick_by_more_than_3_percent() {
    for seed in 1..=20 {
        let steps = flown(seed, 300.0);
        assert!(steps.fixes > 200 && steps.by_fixes < 0.03, "{steps:?}");
    }
}

/// The pilot flies the hover, closes the switch, and opens it 8 s later; fifty times, in gusts. At each takeover the
/// sticks start from their current positions.
#[test]
fn fifty_engagements_and_releases_move_no_stick_by_more_than_3_percent() {
    let (engage_s, release_s) = (12.0, 20.0);
    // Largest changes of a stick: in the cycle of a mode change, in the half second after engagement, after release,
    // and during flight.
    let mut largest_step = [0.0f64; 4];
    for seed in 1..=50 {
        let events = vec![(release_s, FlightEvent::Engage(false))];
        let flight = FlightConfig {
            seed,
            engage_s,
            events,
            duration_s: 20.6,
            ..FlightConfig::new(autopilot())
        };
        let flight = flight.fly().unwrap();
        assert_eq!((flight.crashed_s, flight.transitions.len()), (None, 2), "seed {seed}");
        for pair in flight.samples.windows(2) {
            let moved = largest(difference(pair[1].sticks, pair[0].sticks));
            let now_s = pair[1].truth.time.seconds();
            let place = match (now_s - engage_s, now_s - release_s) {
                (-0.015..0.015, _) | (_, -0.015..0.015) => 0,
                (0.0..0.5, _) => 1,
                (_, 0.0..0.5) => 2,
                (5.0.., ..0.0) => 3,
                _ => continue,
            };
            largest_step[place] = largest_step[place].max(moved);
        }
    }
    let [change, engaged, released, flown] = largest_step.map(|step| 100.0 * step);
    println!(
        "steps in the cycle of a change up to {change:.2} %, in the half second after engagement \
         {engaged:.2} %, after release {released:.2} %, in flight {flown:.2} %"
    );
    assert!(change < 3.0 && engaged < 3.0 && released < 3.0, "{largest_step:?}");
}

/// The largest difference of roll, pitch or heading between two attitudes, rad.
fn between_rad(one: EulerAngles, other: EulerAngles) -> f64 {
    let [roll, pitch] = [one.roll_rad - other.roll_rad, one.pitch_rad - other.pitch_rad];
    roll.abs().max(pitch.abs()).max(wrap_angle(one.yaw_rad - other.yaw_rad).abs())
}

/// Times and attitudes of a flight in the `until_s` after `from_s`.
fn attitudes(
    flight: &Flight,
    from_s: f64,
    until_s: f64,
) -> impl Iterator<Item = (Time, EulerAngles)> {
    let attitudes =
        flight.samples.iter().map(|sample| (sample.truth.time, sample.truth.body_to_ned.euler()));
    attitudes.filter(move |(time, _)| (0.0..=until_s).contains(&(time.seconds() - from_s)))
}

/// Largest difference of roll, pitch or heading between two flights in the `until_s` after `from_s`, °.
fn apart_deg(one: &Flight, other: &Flight, from_s: f64, until_s: f64) -> f64 {
    let [one, other] = [one, other].map(|flight| attitudes(flight, from_s, until_s));
    let apart_rad = one.zip(other).map(|((time, one), (same, other))| {
        assert_eq!(time, same);
        between_rad(one, other)
    });
    apart_rad.fold(0.0, f64::max).to_degrees()
}

/// Largest change of roll, pitch or heading of a flight in the `until_s` after `from_s`, °.
fn moved_deg(flight: &Flight, from_s: f64, until_s: f64) -> f64 {
    let (_, first) = attitudes(flight, from_s, until_s).next().unwrap();
    let moved_rad = attitudes(flight, from_s, until_s).map(|(_, now)| between_rad(now, first));
    moved_rad.fold(0.0, f64::max).to_degrees()
}

/// Effect of fifty engagements and releases on the attitude, °, median and worst.
struct Excursions {
    engaged: [f64; 2],
    released: [f64; 2],
}

/// Every flight is flown twice in the same gusts, with and without the change. The difference of their attitudes is
/// the effect of the change. With the true state as feedback this is the effect of the transfer itself. With the
/// estimate the autopilot also corrects the velocity for the estimate's error.
fn excursions(feedback: Feedback, engage_s: f64) -> Excursions {
    let release_s = engage_s + 8.0;
    let mut apart = [const { Vec::new() }; 5];
    for seed in 1..=50 {
        let fly = |engage_s: f64, events: Vec<(f64, FlightEvent)>| {
            let flown = FlightConfig { seed, feedback, ..FlightConfig::new(autopilot()) };
            let duration_s = release_s + 0.6;
            FlightConfig { engage_s, events, duration_s, ..flown }.fly().unwrap()
        };
        let flown = fly(engage_s, Vec::new());
        let by_pilot = fly(f64::INFINITY, Vec::new());
        let handed_back = fly(engage_s, vec![(release_s, FlightEvent::Engage(false))]);
        apart[0].push(apart_deg(&flown, &by_pilot, engage_s, 2.0));
        apart[1].push(apart_deg(&flown, &handed_back, release_s, 0.6));
        apart[2].push(moved_deg(&flown, engage_s, 2.0));
        apart[3].push(moved_deg(&by_pilot, engage_s, 2.0));
        // For comparison: changes of attitude in a hold long after engagement.
        apart[4].extend([4.0, 6.0].map(|later_s| moved_deg(&flown, engage_s + later_s, 2.0)));
    }
    let [engaged, released, moved, by_pilot, held] = apart.map(|mut apart| {
        apart.sort_by(f64::total_cmp);
        [apart[apart.len() / 2], apart[apart.len() - 1]]
    });
    println!(
        "by the {feedback:?}, {engage_s} s after the start, median and worst, deg: apart from the flight without the \
         change: engaged {engaged:.2?}, released {released:.2?}; from where it was: engaged {moved:.2?}, by the \
         pilot {by_pilot:.2?}, in 2 s of holding {held:.2?}"
    );
    Excursions { engaged, released }
}

/// The flight is as with the serial lines, where the pilot has flown for three quarters of a minute.
#[test]
fn fifty_engagements_and_releases_move_the_attitude_by_no_more_than_3_degrees() {
    for feedback in [Feedback::Truth, Feedback::Estimator] {
        let Excursions { engaged, released } = excursions(feedback, 45.0);
        assert!(engaged[1] < 3.0 && released[1] < 3.0, "{feedback:?}: {engaged:?} {released:?}");
    }
}

/// Twelve seconds after the filter's first sample its errors and the vehicle are still in motion.
#[test]
fn an_engagement_soon_after_the_start_moves_the_attitude_by_little_more() {
    for (feedback, max_deg) in [(Feedback::Truth, 4.0), (Feedback::Estimator, 5.0)] {
        let Excursions { engaged, released } = excursions(feedback, 12.0);
        assert!(
            engaged[1] < max_deg && released[1] < 3.0,
            "{feedback:?}: {engaged:?} {released:?}"
        );
    }
}
