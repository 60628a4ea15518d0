//! Scenes flown in the loop: the vehicle stays in the air after every failure.

use hovernav_record::Level;

use crate::common::{Flown, Setup, all_flown};

const LENGTH_S: f64 = 24.0;
const ENGAGED: &str = "engage@8:13";

/// Delay from an act to its event, in addition to the delay of the act: one of the pilot's packets and a cycle.
const SLACK_S: f64 = 0.055;

#[test]
fn every_failsafe_responds_in_time_and_nothing_crashes() {
    let scenes: Vec<(&str, Vec<&str>, &'static str)> = vec![
        ("held", vec![ENGAGED], "override"),
        ("silence", vec![ENGAGED, "pilot-lost@12:4"], "override"),
        ("failsafe", vec![ENGAGED, "failsafe@12:4"], "override"),
        ("aux", vec![ENGAGED, "aux-lost@12"], "override"),
        ("unit", vec![ENGAGED, "dmu-cut@12:3"], "override"),
        ("frozen unit", vec![ENGAGED, "frozen-imu@12:3"], "override"),
        ("satellites", vec!["engage@8:15", "gps-cut@10:11"], "override"),
        ("hands", vec![ENGAGED, "stick-pedal=0.3@12:1"], "override"),
        ("steered", vec![ENGAGED, "stick-longitudinal=0.3@12:3"], "steer"),
        ("not ready", vec!["no-fix@3", "engage@9:8"], "override"),
    ];
    let flights =
        all_flown(&scenes, |(_, acts, pilot)| Setup { pilot, ..Setup::new(LENGTH_S, acts) });
    let flights: Vec<(&str, Flown)> = scenes.iter().map(|(name, ..)| *name).zip(flights).collect();
    let of = |wanted: &str| &flights.iter().find(|(name, _)| *name == wanted).unwrap().1;
    for (name, flown) in &flights {
        assert_eq!(flown.crashed_s, None, "{name}: {:#?}", flown.record.events);
        let engaged = flown.at("the autopilot flies").is_some();
        assert_eq!(engaged, *name != "not ready", "{name}: {:#?}", flown.record.events);
    }
    let in_time = |name: &str, act_s: f64, delay_s: f64, text: &str| {
        let after_s = of(name).after(act_s, text);
        assert!(
            (-0.1..delay_s + SLACK_S).contains(&after_s),
            "{name}: \"{text}\" {after_s} s later"
        );
    };
    for name in ["silence", "failsafe"] {
        in_time(name, 12.0, 0.1, "the pilot's signal is lost: the autopilot holds");
        in_time(name, 16.0, 0.1, "the pilot's signal is back");
        assert!(of(name).statistics().engaged_s > 11.0, "{name}");
    }
    in_time("aux", 12.0, 0.1, "the pilot flies: the switch's channel is lost");
    in_time("unit", 12.0, 0.2, "the pilot flies: the attitude is not known");
    in_time("frozen unit", 12.0, 0.2, "the pilot flies: the attitude is not known");
    in_time("hands", 12.0, 0.0, "the pilot flies: a stick was moved");
    in_time("satellites", 10.0, 9.5, "drift");
    assert!(of("satellites").at("the pilot flies: the attitude").is_none());
    in_time("not ready", 9.0, 0.1, "the autopilot does not take over");
    in_time("not ready", 9.0, 0.1, "age of the last fix");
    assert!(of("steered").at("a stick was moved").is_none());
    assert!(of("steered").statistics().place_m > 2.0, "it went where the stick pointed");
    // The record has the cause and the severity.
    let handed = |name: &str| {
        let mut events = of(name).record.events.iter();
        let event = events.find(|event| event.text.contains("the attitude is not known")).unwrap();
        (event.level, event.part.clone())
    };
    for name in ["unit", "frozen unit"] {
        assert_eq!(handed(name), (Level::Critical, "inertial unit".into()), "{name}");
    }
    // The first valid estimate is not "good again"; gains without a model cause a warning at the start.
    assert_eq!(of("held").at("is good again"), None);
    assert!(of("held").at("the autopilot's gains are not checked").is_some());
    let held = of("held").statistics();
    assert!(held.velocity_rms_mps.iter().all(|mps| *mps < 0.5), "{held:?}");
    assert!(held.heading_rad < 0.15, "{held:?}");
}
