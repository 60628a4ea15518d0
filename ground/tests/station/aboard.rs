//! The flight computer's own record on the page.

use crate::common::{Client, get, serve};
use hovernav::earth::Geodetic;
use hovernav::ekf::Solution;
use hovernav::frames::{EulerAngles, Rotation, Vector};
use hovernav::time::Time;
use hovernav_record::{Entry, FlyConfig, Header, Level, Recorder};

const START: Time = Time::from_nanoseconds(86_412_345_678_901);
const START_UNIX_NS: i64 = 1_790_000_000_123_456_789;

#[test]
fn the_record_of_the_flight_computer_opens_with_its_solutions_and_events() {
    let served = serve(None);
    let mut config = FlyConfig::default();
    config.navigation.imu.magnetic_declination_deg = Some(0.3);
    let header = Header::new(config, START, START_UNIX_NS);
    let file = served.place.path().join("records/aboard.mcap");
    let mut recorder = Recorder::create(&file, &header).unwrap();
    let place = Geodetic::from_degrees(1.35, 103.82, 50.0).unwrap();
    for k in 0..330 {
        let time = START + f64::from(k) / 33.0;
        let solution = Solution {
            body_to_ned: Rotation::from_euler(EulerAngles::from_degrees(5.0, -2.0, 40.0)),
            velocity_mps: Vector::new(1.5, -0.5, 0.25),
            ..Solution::at_rest(time, place)
        };
        recorder.push(time, solution);
    }
    let time = START + 5.0;
    recorder.push(time, Entry::event(Level::Critical, "test", "the pilot flies: \u{1b}[2J\nland"));
    recorder.finish();

    let mut client = Client::connect(&served, "").unwrap();
    client.ask(r#"{"do":"open","name":"aboard"}"#);
    let state = loop {
        let state = client.observe("state");
        if !state["record"].is_null() {
            break state;
        }
    };
    assert_eq!(
        (&state["record"]["name"], &state["record"]["is_cut"]),
        (&"aboard".into(), &false.into())
    );
    let span = [0, 1].map(|end| state["what"]["span"][end].as_f64().unwrap());
    let begun_s = 1e-9 * START_UNIX_NS as f64;
    assert!((span[0] - begun_s).abs() < 1e-3 && (span[1] - span[0] - 329.0 / 33.0).abs() < 1e-3);
    assert_eq!(state["texts"][0]["level"], "error", "{state}");
    // A line end in an event starts no second one.
    assert_eq!(state["texts"][0]["text"], r"the pilot flies: \u{1b}[2J\nland", "{state}");
    let path = format!(
        "/export.csv?record=aboard&channels=roll_deg,yaw_deg,vel_n_mps,vel_u_mps,height_m&from={}&to={}",
        span[0], span[1]
    );
    let csv = get(&served, &path);
    let rows = csv.lines().filter(|line| line.ends_with(",5,40,1.5,-0.25,50")).count();
    assert!(rows > 320, "{rows} rows of {csv:.2000}");
    // A file of another program is refused by its kind.
    std::fs::write(served.place.path().join("records/other.mcap"), [0x89; 100]).unwrap();
    client.ask(r#"{"do":"open","name":"other"}"#);
    let error = client.observe("error");
    assert!(error.as_str().unwrap().contains("expected an MCAP file"), "{error}");
}
