//! Inputs of the vehicle in logs of other autopilots: outputs of controllers before the pilot's sticks.

use std::path::Path;

use approx::assert_abs_diff_eq;
use hovernav_formats::{Log, Options, open_bytes};

/// An ArduPilot log in which a system identification moves roll, then pitch, while the pilot's sticks rest.
fn identification() -> String {
    let mut text = String::from(
        "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n\
         FMT, 129, 40, IMU, Qffffff, TimeUS,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\n\
         FMT, 130, 30, RCIN, QHHHH, TimeUS,C1,C2,C3,C4\n\
         FMT, 131, 30, RATE, Qffffffffffff, TimeUS,RDes,R,ROut,PDes,P,POut,YDes,Y,YOut,ADes,A,AOut\n\
         FMT, 132, 30, SIDS, QBffff, TimeUS,Ax,Mag,FSt,FSp,TFin\n\
         FMT, 133, 30, SIDD, Qfff, TimeUS,Time,Targ,F\n",
    );
    for k in 0..400_u32 {
        let us = 1_000_000 + k * 2_500;
        let wave = 0.1 * (0.2 * f64::from(k)).sin();
        let (axis, start) = if k < 200 { (10, 0) } else { (11, 200) };
        if k == start {
            text += &format!("SIDS, {us}, {axis}, 0.1, 0.5, 15, 5\n");
        }
        let (roll, pitch) = if axis == 10 { (wave, 0.0) } else { (0.0, wave) };
        text += &format!("IMU, {us}, 0, 0, 0, 0, 0, -9.8\n");
        text += &format!("RCIN, {us}, 1500, 1500, 1500, 1500\n");
        text += &format!("SIDD, {us}, 0, {wave}, 1\n");
        text += &format!("RATE, {us}, 0, 0, {roll}, 0, 0, {pitch}, 0, 0, 0.01, 0, 0, 0.35\n");
    }
    text
}

fn read(input: Option<&str>) -> Result<Log, String> {
    let mut options = Options::default();
    options.input = input.map(str::to_owned);
    let log = open_bytes(identification().as_bytes(), Path::new("sid.log"), &options);
    log.map_err(|error| error.to_string())
}

#[test]
fn a_system_identification_gives_the_mixers_inputs_and_what_was_injected() {
    let dataset = read(None).unwrap().dataset;
    assert_eq!(dataset.controls.len(), 400);
    let (roll, pitch) = (50, 250);
    for (sample, stick, sign) in [(roll, 0, 1.0), (pitch, 1, -1.0)] {
        let wave = 0.1 * (0.2 * sample as f64).sin();
        let mut expected = [0.0, 0.0, 0.35, 0.01];
        expected[stick] = sign * wave;
        let (found, injected) = (dataset.controls[sample].1, dataset.injected[sample]);
        for axis in 0..4 {
            assert_abs_diff_eq!(found[axis], expected[axis], epsilon = 1e-6);
            let injected_here = if axis == stick { sign * wave } else { 0.0 };
            assert_abs_diff_eq!(injected[axis], injected_here, epsilon = 1e-6);
        }
    }
    let told = "inputs: RATE is read, nearest to the actuators; the log also has RCIN";
    assert!(dataset.notes.iter().any(|note| note == told), "{:?}", dataset.notes);
}

#[test]
fn another_input_is_read_where_it_is_named() {
    let sticks = read(Some("RCIN")).unwrap().dataset;
    assert!(sticks.controls.iter().all(|(_, sticks)| *sticks == [0.0; 4]));
    let message = read(Some("RCOU")).unwrap_err();
    assert!(message.contains("found no input RCOU; the log has RATE, RCIN"), "{message}");
}
