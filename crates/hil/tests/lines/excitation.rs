//! Test inputs flown over the lines, and identification from the record.

use hovernav_model::Grade;
use hovernav_sysid::helicopter::{
    FlightRecord, FrequencyDomain, ModelStructure, Velocity, identify,
};

use crate::common::{Setup, all_flown, flown};
use hovernav_replay::smooth;

const PEDAL: &str = "[autopilot.excitation]\nfirst_s = 4.0\npause_s = 3.0\n\
    [[autopilot.excitation.inputs]]\nstick = 'pedal'\nkind = 'doublet'\ntimes = 2\n\
    [[autopilot.excitation.inputs]]\nstick = 'collective'\nkind = 'step'\namplitude = -0.08\n";

fn setup(acts: &[&str], duration_s: f64, keys: &str) -> Setup {
    Setup { keys: keys.to_owned(), ..Setup::new(duration_s, acts) }
}

#[test]
fn inputs_are_flown_and_recorded_and_a_stick_ends_them() {
    let scenes = [
        ("flown", vec!["engage@8:22"]),
        ("ended by a stick", vec!["engage@8:22", "stick-lateral=0.08@12.8:0.5"]),
        ("ended by the switch", vec!["engage@8:4.8"]),
    ];
    let flights = all_flown(&scenes, |(_, acts)| setup(acts, 31.0, PEDAL));
    let [whole, by_stick, by_switch] = &flights[..] else { panic!("three flights") };
    let injected = whole.record.dataset().unwrap().injected;
    assert_eq!(injected.len(), whole.record.controls.len());
    let cycles = |is: &dyn Fn(&[f64; 4]) -> bool| injected.iter().filter(|one| is(one)).count();
    // Two doublets of 1 s per direction, minus the transitions at 4 full travels per second.
    assert!((62..=68).contains(&cycles(&|one| one[3] > 0.09)), "{}", cycles(&|one| one[3] > 0.09));
    assert!((60..=68).contains(&cycles(&|one| one[3] < -0.09)));
    assert!((46..=51).contains(&cycles(&|one| one[2] < -0.07)));
    for text in ["test input 1: pedal", "test input 3: collective", "all test inputs are flown"] {
        assert!(whole.at(text).is_some(), "{text}");
    }
    // The doublet begins at 12.1 s; at 12.8 s the stick is moved or the switch is opened.
    for (flown, why) in
        [(by_stick, "the pilot moved a stick"), (by_switch, "velocity is no longer held")]
    {
        let after_s = flown.after(12.8, &format!("no more test inputs: {why}"));
        assert!(after_s < 0.1, "{why}: {after_s} s");
        let injected = flown.record.cycles.iter().map(|one| (one.time, one.cycle.injected));
        let mut injected = injected.rev();
        let last = injected.find(|(_, one)| one.pedal != 0.0).expect("it began");
        assert!(flown.second(last.0) < 12.9, "{why}");
    }
    assert!(by_stick.statistics().engaged_s > 20.0, "the autopilot flew on");
}

#[test]
fn a_model_is_identified_from_the_record_of_a_flight_with_test_inputs() {
    let mut keys = "[autopilot.excitation]\nfirst_s = 8.0\npause_s = 4.0\n".to_owned();
    for (stick, amplitude) in
        [("pedal", 0.12), ("collective", 0.1), ("lateral", 0.08), ("longitudinal", 0.08)]
    {
        keys += &format!(
            "[[autopilot.excitation.inputs]]\nstick = '{stick}'\nkind = '3211'\n\
             amplitude = {amplitude}\ntimes = 3\n"
        );
    }
    let flown = flown(&setup(&["engage@8:108"], 118.0, &keys));
    assert!(flown.at("all test inputs are flown").is_some());
    let mut dataset = flown.record.dataset().unwrap();
    let settings = dataset.settings().unwrap();
    let solutions = smooth(&dataset, &settings, |_| ()).solutions;
    for name in ["yaw", "heave", "roll-pitch", "hybrid"] {
        let structure = ModelStructure::built_in(name).unwrap();
        let found = identify(&dataset, &solutions, structure, Velocity::Estimated).unwrap();
        let flight = FlightRecord::new(&dataset, &solutions, Velocity::Estimated).unwrap();
        let frequency = FrequencyDomain::of(&found, &flight);
        let verdict = found.verdict(frequency.as_ref().ok());
        println!("{name}: {verdict:?}");
        assert_ne!(verdict.grade, Grade::DoNotFly, "{name}: {:?}", verdict.reasons);
    }
}
