//! Every failsafe of docs/flying.md in flights over the lines of a flight computer. The loss of the record is in
//! [`crate::full_record`] instead. Each failsafe is tested in hover, while a stick steers, and just after engagement.
//! The flight record contains the response, its time and its reason.

use hovernav::autopilot::Mode;
use hovernav::earth::Geodetic;
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, Solution, SteplessSolution};
use hovernav::event::Event;
use hovernav::frames::Vector;
use hovernav_hil::LiveSample;

use crate::common::{Flown, Setup, all_flown, autopilot};

/// Duration of a cycle, s.
const CYCLE_S: f64 = 1.0 / 33.0;
/// Delay of the lines, s. An act falls between two of the pilot's packets, which take 24 ms, and a sample is delayed by
/// its transmission.
const LINES_S: f64 = 0.025;
/// Time without pulses after which the pilot is lost: the default of `signal.stale_after_s`.
const STALE_S: f64 = 0.1;
/// Age of the estimate after which it is rejected, s: the default of `health.age_s`.
const AGE_S: f64 = 0.2;
/// Radius of the geofence, m.
const GEOFENCE_M: f64 = 5.0;

/// The moments of a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// The autopilot has held a hover for 6 s.
    Hover,
    /// The pilot holds a stick forward, and the vehicle moves there.
    Manoeuvre,
    /// The autopilot engaged 0.25 s ago.
    Engagement,
}

impl Moment {
    pub const ALL: [Self; 3] = [Self::Hover, Self::Manoeuvre, Self::Engagement];

    pub fn second(self) -> f64 {
        if self == Self::Engagement { 8.35 } else { 14.0 }
    }
}

/// The response to a failure.
struct Response {
    what: &'static str,
    /// The specified delay, s.
    within_s: f64,
    /// The measured delay, s.
    after_s: f64,
}

fn response(what: &'static str, within_s: f64, after_s: f64) -> Response {
    Response { what, within_s, after_s }
}

/// A row of the table of failsafes.
struct Failsafe {
    name: &'static str,
    /// Duration of the flight, s.
    watched_s: f64,
    /// Adds the failure to a flight, at a moment.
    stage: fn(&mut Setup, Moment),
    /// Finds the responses in the flight.
    measure: fn(&Flown, Moment) -> Vec<Response>,
    /// Whether neither pilot nor autopilot can keep the vehicle in the air.
    may_crash: bool,
}

const FAILSAFES: [Failsafe; 14] = [
    Failsafe {
        name: "pilot's signal, by silence",
        watched_s: 13.0,
        stage: |setup, moment| pilot_lost(setup, moment, "pilot-lost"),
        measure: pilot_lost_response,
        may_crash: false,
    },
    Failsafe {
        name: "pilot's signal, by the receiver's word",
        watched_s: 13.0,
        stage: |setup, moment| pilot_lost(setup, moment, "failsafe"),
        measure: pilot_lost_response,
        may_crash: false,
    },
    Failsafe {
        name: "aux channel alone",
        watched_s: 4.0,
        stage: |setup, moment| happens(setup, moment, "aux-lost", 2.0),
        measure: |flown, moment| {
            let told_s =
                flown.after(moment.second(), "the pilot flies: the switch's channel is lost");
            vec![
                response("the pilot flies", STALE_S + CYCLE_S, told_s),
                hand_back(flown, moment, told_s),
            ]
        },
        may_crash: false,
    },
    Failsafe {
        name: "position, then velocity",
        watched_s: 50.0,
        stage: |setup, moment| {
            // With the default limits, velocity becomes invalid before position does.
            setup.autopilot.health.position_sigma_m = 3.3;
            setup.autopilot.transfer.patience_s = 6.0;
            happens(setup, moment, "gps-cut", 60.0);
        },
        measure: |flown, moment| {
            let limits = autopilot_of(flown).health;
            let beyond = |is: &dyn Fn(&Solution) -> bool| {
                let from =
                    flown.record.solutions.iter().find(|solution| {
                        flown.second(solution.time) > moment.second() && is(solution)
                    });
                flown.second(from.expect("beyond its limit").time)
            };
            let position =
                beyond(&|solution| greatest(solution.position_sigma_m) > limits.position_sigma_m);
            let velocity = beyond(&|solution| {
                let [north, east, _] = solution.velocity_sigma_mps.to_array();
                north.max(east) > limits.velocity_sigma_mps
            });
            let held = mode_from(flown, position, Mode::Velocity);
            let attitude = mode_from(flown, velocity, Mode::Attitude);
            let descent = mode_from(flown, attitude, Mode::Descent);
            vec![
                response("velocity is held", CYCLE_S, held - position),
                response("attitude is held", CYCLE_S, attitude - velocity),
                response("it descends", 6.0 + CYCLE_S, descent - attitude),
            ]
        },
        may_crash: false,
    },
    Failsafe {
        name: "receiver that repeats itself",
        watched_s: 6.0,
        stage: |setup, moment| happens(setup, moment, "frozen-fix", 4.0),
        measure: |flown, moment| {
            let attitude = mode_from(flown, moment.second(), Mode::Attitude);
            vec![response("attitude is held", 2.2 + CYCLE_S, attitude - moment.second())]
        },
        may_crash: false,
    },
    Failsafe {
        name: "inertial unit, by its wire",
        watched_s: 5.0,
        stage: |setup, moment| happens(setup, moment, "dmu-cut", 3.0),
        measure: no_attitude,
        may_crash: false,
    },
    Failsafe {
        name: "inertial unit, by its port",
        watched_s: 5.0,
        stage: |setup, moment| happens(setup, moment, "dmu-pulled", 3.0),
        measure: no_attitude,
        may_crash: false,
    },
    Failsafe {
        name: "inertial unit, by repeating itself",
        watched_s: 5.0,
        stage: |setup, moment| happens(setup, moment, "frozen-imu", 3.0),
        measure: no_attitude,
        may_crash: false,
    },
    Failsafe {
        name: "inertial unit without a pilot",
        watched_s: 2.0,
        stage: |setup, moment| {
            happens(setup, moment, "pilot-lost", 2.0);
            happens(setup, moment, "dmu-cut", 2.0);
        },
        measure: |flown, moment| {
            let neutral = mode_from(flown, moment.second(), Mode::Neutral);
            vec![response("sticks go to trim", AGE_S + CYCLE_S, neutral - moment.second())]
        },
        may_crash: true,
    },
    Failsafe {
        name: "the loop's time",
        watched_s: 4.0,
        // The processor runs just long enough to request and receive a packet, too late each time.
        stage: |setup, moment| {
            setup.held = (0..20).map(|k| (moment.second() + 0.05 * f64::from(k), 0.04)).collect();
        },
        measure: |flown, moment| {
            let late = flown.record.cycles.iter().find(|one| one.cycle.late_cycles >= 3);
            let late_s = flown.second(late.expect("three cycles late").time);
            let told_s = flown.after(moment.second(), "late several times in a row");
            vec![response("the pilot flies", CYCLE_S, moment.second() + told_s - late_s)]
        },
        may_crash: false,
    },
    Failsafe {
        name: "the telemetry",
        watched_s: 5.0,
        stage: |setup, moment| setup.ground_lost_s = Some(moment.second()),
        measure: |flown, moment| {
            let sent = flown.report.telemetry.sent as f64;
            assert!(sent > 30.0 * (moment.second() - 2.0), "{sent} frames");
            assert!(flown.statistics().engaged_s > moment.second() - 4.0, "it flies on");
            assert!(flown.at("telemetry: port lost").is_some());
            vec![]
        },
        may_crash: false,
    },
    Failsafe {
        name: "the geofence",
        watched_s: 20.0,
        stage: |setup, moment| {
            // In hover, gusts carry the vehicle over the geofence; otherwise a stick is held outwards until it is well
            // beyond.
            setup.pilot = if moment == Moment::Hover { "override" } else { "steer" };
            let south_m = match moment {
                Moment::Hover => 4.6,
                Moment::Manoeuvre => {
                    setup.acts.push("stick-longitudinal=0.3@14.5:6".to_owned());
                    1.0
                }
                Moment::Engagement => {
                    setup.acts.push("stick-longitudinal=0.3@8.35:8".to_owned());
                    3.0
                }
            };
            let middle = middle(setup, south_m);
            let (latitude_rad, longitude_rad) = (middle.latitude_rad, middle.longitude_rad);
            setup.keys = format!(
                "[site]\nlatitude_deg = {:.9}\nlongitude_deg = {:.9}\nheight_m = 0.0\n\
                 [autopilot.geofence]\nradius_m = {GEOFENCE_M:?}\nheight_m = 100.0\n",
                latitude_rad.to_degrees(),
                longitude_rad.to_degrees()
            );
        },
        measure: |flown, _| {
            let site = flown.record.header.config.site.expect("a site");
            let middle = Geodetic::from_degrees(site.latitude_deg, site.longitude_deg, 0.0);
            let middle = middle.expect("a place");
            let engaged_s = flown.at("the autopilot flies").expect("engaged");
            let away = |solution: &Solution| {
                let [north, east, _] = solution.position.displacement_from(&middle).to_array();
                north.hypot(east)
            };
            let mut flight = stepless(flown)
                .into_iter()
                .filter(|solution| flown.second(solution.time) > engaged_s - CYCLE_S);
            let crossed = flight.find(|solution| away(solution) >= GEOFENCE_M);
            let crossed_s = flown.second(crossed.expect("it reached the geofence").time);
            let farthest_m = flight.map(|solution| away(&solution)).fold(0.0, f64::max);
            assert!(farthest_m < GEOFENCE_M + 2.5, "it went on to {farthest_m} m");
            let told = "the geofence is reached: the autopilot goes back";
            vec![response("it goes back", CYCLE_S, flown.after(crossed_s, told))]
        },
        may_crash: false,
    },
    Failsafe {
        name: "a control at its end",
        watched_s: 8.0,
        stage: |setup, moment| {
            // The pedal's range is smaller than a turn needs.
            setup.pilot = "steer";
            setup.autopilot.limits.lowest.pedal = -0.02;
            setup.autopilot.limits.highest.pedal = 0.02;
            happens(setup, moment, "stick-pedal=0.6", 6.0);
        },
        measure: |flown, _| {
            let limits = autopilot_of(flown).limits;
            let told_s = flown.at("a control is at its end").expect("told");
            let mut since_s = None;
            for recorded in &flown.record.cycles {
                let second = flown.second(recorded.time);
                if second > told_s {
                    break;
                }
                let pedal = recorded.cycle.sticks.map_or(0.0, |sticks| sticks.pedal);
                let at_end = recorded.cycle.mode != Mode::Manual
                    && (pedal >= 0.995 * limits.highest.pedal
                        || pedal <= 0.995 * limits.lowest.pedal);
                since_s = at_end.then(|| since_s.unwrap_or(second));
            }
            let since_s = since_s.expect("at its end");
            vec![response("told", 1.0 + CYCLE_S, told_s - since_s)]
        },
        may_crash: false,
    },
    Failsafe {
        name: "pilot's signal while the pilot flies",
        watched_s: 2.0,
        stage: |setup, moment| {
            let released_s = moment.second() - 0.25;
            setup.acts = match moment {
                Moment::Hover => vec![],
                Moment::Manoeuvre => vec!["stick-lateral=0.05@13.8:1".to_owned()],
                Moment::Engagement => vec![format!("engage@6:{}", released_s - 6.0)],
            };
            setup.keys =
                "[servo]\nhold_s = 0.5\n[servo.channels.lateral]\nfailsafe_ms = 1.6\n".into();
            happens(setup, moment, "pilot-lost", 2.0);
        },
        measure: |flown, moment| {
            let lost_s = moment.second() + STALE_S + CYCLE_S + LINES_S;
            let lateral = |sample: &LiveSample| sample.commanded.lateral;
            let mut held = flown.samples.iter().filter(|sample| second(sample) > lost_s);
            let first = lateral(held.next().expect("a sample"));
            let left = held.find(|sample| (lateral(sample) - first).abs() > 1e-6);
            let left_s = second(left.expect("it goes to its failsafe width"));
            let told_s = flown.after(moment.second(), "no pulses on the pilot's");
            let held_s = left_s - moment.second() - told_s;
            vec![
                response("widths are held", STALE_S + CYCLE_S, told_s),
                response("channels go to failsafe_ms", 0.5 + 2.0 * CYCLE_S, held_s),
            ]
        },
        may_crash: true,
    },
];

fn happens(setup: &mut Setup, moment: Moment, act: &str, lasts_s: f64) {
    setup.acts.push(format!("{act}@{}:{lasts_s}", moment.second()));
}

fn pilot_lost(setup: &mut Setup, moment: Moment, act: &str) {
    setup.keys = "[autopilot.failsafe]\npilot_lost_hold_s = 2.0\n".into();
    happens(setup, moment, act, 10.0);
}

fn pilot_lost_response(flown: &Flown, moment: Moment) -> Vec<Response> {
    let lost_s = moment.second();
    let held_s = flown.after(lost_s, "the pilot's signal is lost: the autopilot holds");
    let descends_s = flown.after(lost_s, "no pilot: the autopilot descends");
    let back_s = flown.after(lost_s + 10.0, "the pilot's signal is back");
    let sinks_mps = flown.samples.iter().filter_map(|sample| {
        let at_s = second(sample) - lost_s;
        (4.0..10.0).contains(&at_s).then(|| sample.truth.velocity_mps.z())
    });
    let (sum, count) = sinks_mps.fold((0.0, 0.0), |(sum, count), sink| (sum + sink, count + 1.0));
    let sinks_mps = sum / count;
    // The commanded descent is 0.5 m/s, and the estimate with a 1 Hz receiver errs by 0.25 m/s.
    assert!((0.1..0.9).contains(&sinks_mps), "sinks at {sinks_mps} m/s");
    vec![
        response("it holds", STALE_S + CYCLE_S, held_s),
        response("it descends", 2.0 + 2.0 * CYCLE_S, descends_s - held_s),
        response("it holds again with the signal", CYCLE_S, back_s),
    ]
}

fn no_attitude(flown: &Flown, moment: Moment) -> Vec<Response> {
    let told_s = flown.after(moment.second(), "the pilot flies: the attitude is not known");
    vec![response("the pilot flies", AGE_S + CYCLE_S, told_s), hand_back(flown, moment, told_s)]
}

/// After the event the servos follow the pilot, within 2 % of travel. The time constant with which the difference fades
/// is 0.25 s. The pilot, who had released the sticks, moves them during this time.
fn hand_back(flown: &Flown, moment: Moment, told_s: f64) -> Response {
    // In the manoeuvre the pilot holds the stick forward until 14.5 s. The check begins after that.
    let told_s =
        (moment.second() + told_s).max(if moment == Moment::Manoeuvre { 14.5 } else { 0.0 });
    let follows = flown.samples.iter().find(|sample| {
        let mut pairs = sample.commanded.to_array().into_iter().zip(sample.pilot.to_array());
        second(sample) > told_s && pairs.all(|(one, other)| (one - other).abs() < 0.02)
    });
    response("servos follow the pilot", 0.8, second(follows.expect("the pilot flies")) - told_s)
}

fn second(sample: &LiveSample) -> f64 {
    sample.truth.time.seconds()
}

fn greatest<F>(vector: Vector<F>) -> f64 {
    vector.to_array().into_iter().fold(0.0, f64::max)
}

fn autopilot_of(flown: &Flown) -> hovernav::autopilot::HoverConfig {
    let section = flown.record.header.config.autopilot.as_ref().expect("an autopilot");
    section.flown.expect("what flew")
}

/// Time of the first cycle in this mode after `from_s`, s.
fn mode_from(flown: &Flown, from_s: f64, mode: Mode) -> f64 {
    let seconds = flown.record.cycles.iter().filter(|recorded| recorded.cycle.mode == mode);
    let mut seconds = seconds.map(|recorded| flown.second(recorded.time));
    seconds.find(|second| *second > from_s - CYCLE_S).unwrap_or_else(|| {
        panic!("never {mode:?}: {:#?}", flown.told().collect::<Vec<_>>());
    })
}

/// A position at this distance south of the start, on the ground.
fn middle(setup: &Setup, south_m: f64) -> Geodetic {
    let start = Geodetic { height_m: 0.0, ..setup.flight.start };
    start.displaced(Vector::new(-south_m, 0.0, 0.0))
}

/// The estimate without the jumps by corrections, as flight control uses it.
fn stepless(flown: &Flown) -> Vec<Solution> {
    let record = &flown.record;
    let mut estimator = Estimator::<Full, 28>::new(record.header.settings().unwrap());
    let mut stepless = SteplessSolution::default();
    let mut solutions = Vec::new();
    for event in record.dataset().unwrap().events() {
        estimator.push_traced(&event, &mut stepless, |_| {});
        if matches!(event, Event::Imu(_)) {
            solutions.extend(estimator.solution().map(|solution| stepless.solution(&solution)));
        }
    }
    solutions
}

fn staged(failsafe: &Failsafe, moment: Moment) -> Setup {
    let mut setup = engaged_at(moment, moment.second() + failsafe.watched_s + 1.0);
    (failsafe.stage)(&mut setup, moment);
    setup
}

/// A flight of `length_s` with the autopilot, prepared for `moment`.
pub fn engaged_at(moment: Moment, length_s: f64) -> Setup {
    let mut setup = Setup::new(length_s, &[&format!("engage@8:{}", length_s - 9.0)]);
    setup.autopilot = autopilot();
    if moment == Moment::Manoeuvre {
        setup.pilot = "steer";
        setup.acts.push("stick-longitudinal=0.3@12.5:2".to_owned());
    }
    setup
}

/// Flies every failsafe at `moments`.
fn every_failsafe(failsafes: &[&Failsafe], moments: &[Moment]) {
    let scenes: Vec<(&Failsafe, Moment)> = failsafes
        .iter()
        .flat_map(|failsafe| moments.iter().map(|moment| (*failsafe, *moment)))
        .collect();
    let flights = all_flown(&scenes, |(failsafe, moment)| staged(failsafe, *moment));
    let mut late = Vec::new();
    for ((failsafe, moment), flown) in scenes.iter().zip(&flights) {
        let Failsafe { name, may_crash, .. } = failsafe;
        assert!(
            *may_crash || flown.crashed_s.is_none(),
            "{name}, {moment:?}: {:#?}",
            flown.record.events
        );
        for Response { what, within_s, after_s } in (failsafe.measure)(flown, *moment) {
            println!("{name:<38} {moment:<12?} {what:<32} within {within_s:.2} s: {after_s:.3} s");
            if !(-LINES_S..within_s + LINES_S).contains(&after_s) {
                late.push(format!("{name}, {moment:?}: {what} after {after_s:.3} s"));
            }
        }
    }
    assert!(late.is_empty(), "{late:#?}");
}

#[test]
fn every_failsafe_responds_within_its_delay_at_three_moments() {
    let failsafes: Vec<&Failsafe> = FAILSAFES.iter().collect();
    every_failsafe(&failsafes, &Moment::ALL);
}
