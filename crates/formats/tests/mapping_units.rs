//! Units, signs and clocks of foreign receivers, from a first look to the fixes that the original gives.

use std::f64::consts::{PI, TAU};
use std::fs;

use hovernav::gps::Fix;
use hovernav_formats::{Options, Proposal, open};
use hovernav_log::Dataset;

/// A moment of a drive along a winding road, west of Greenwich and south of the equator.
#[derive(Clone, Copy)]
struct Moment {
    time_s: f64,
    latitude_deg: f64,
    longitude_deg: f64,
    speed_mps: f64,
    /// Clockwise from north, 0 to 2π.
    course_rad: f64,
}

/// Two minutes of driving, four fixes a second.
fn drive() -> Vec<Moment> {
    const INTERVAL_S: f64 = 0.25;
    let (mut latitude_deg, mut longitude_deg) = (-40.0_f64, -105.15);
    (0..480)
        .map(|k| {
            let time_s = 5.0 + f64::from(k) * INTERVAL_S;
            let speed_mps = 8.0 + 4.0 * (0.1 * time_s).sin();
            let course_rad = (PI * (0.03 * time_s).sin()).rem_euclid(TAU);
            let (east, north) = course_rad.sin_cos();
            let step_deg = (speed_mps * INTERVAL_S / 6_370_000.0).to_degrees();
            latitude_deg += north * step_deg;
            longitude_deg += east * step_deg / latitude_deg.to_radians().cos();
            Moment { time_s, latitude_deg, longitude_deg, speed_mps, course_rad }
        })
        .collect()
}

/// The drive as `names` and the fields of each moment, behind its time in seconds.
fn table(names: &str, row: impl Fn(&Moment) -> String) -> String {
    let rows = drive().into_iter().map(|m| format!("{:.3},{}\n", m.time_s, row(&m)));
    format!("time_s,{names}\n{}", rows.collect::<String>())
}

/// What `init` says of `files`, and the dataset that its mapping gives.
fn mapped(files: &[(&str, String)]) -> (String, Dataset) {
    let place = tempfile::tempdir().unwrap();
    let paths = files.iter().map(|(name, text)| {
        let path = place.path().join(name);
        fs::write(&path, text).unwrap();
        path
    });
    let proposal = Proposal::of(&paths.collect::<Vec<_>>()).unwrap();
    let out = place.path().join("mapped");
    proposal.write(&out, false).unwrap();
    (proposal.to_string(), open(&out, &Options::default()).unwrap().dataset)
}

/// The fixes of a receiver alone, and what `init` says of it.
fn fixes(text: String) -> (String, Vec<Fix>) {
    let (report, dataset) = mapped(&[("gps.csv", text)]);
    (report, dataset.fixes)
}

/// Holds places against the drive's.
fn assert_places(fixes: &[Fix], report: &str) {
    let drive = drive();
    assert_eq!(fixes.len(), drive.len(), "{report}");
    for (fix, moment) in fixes.iter().zip(&drive) {
        let north_deg = fix.position.latitude_rad.to_degrees() - moment.latitude_deg;
        let east_deg = fix.position.longitude_rad.to_degrees() - moment.longitude_deg;
        assert!(north_deg.abs().max(east_deg.abs()) < 2e-7, "{north_deg} {east_deg}\n{report}");
    }
}

/// Holds velocities over ground against the drive's.
fn assert_velocities(fixes: &[Fix], report: &str) {
    for (fix, moment) in fixes.iter().zip(drive()) {
        let [north, east] = fix.horizontal_velocity_mps.unwrap_or([f64::NAN; 2]);
        let (sine, cosine) = moment.course_rad.sin_cos();
        let apart_mps = (north - moment.speed_mps * cosine).hypot(east - moment.speed_mps * sine);
        assert!(apart_mps < 0.02, "{apart_mps} m/s apart\n{report}");
    }
}

/// Degrees and minutes in one number, without a sign.
fn ddmm(angle_deg: f64, width: usize) -> String {
    let angle_deg = angle_deg.abs();
    let whole = angle_deg.trunc();
    format!("{whole:0width$.0}{:010.7}", (angle_deg - whole) * 60.0)
}

#[test]
fn degrees_and_minutes_with_letters_are_places() {
    let lettered = |m: &Moment| {
        let (lat, lon) = (ddmm(m.latitude_deg, 2), ddmm(m.longitude_deg, 3));
        let (speed_kn, course_deg) = (m.speed_mps * 3600.0 / 1852.0, m.course_rad.to_degrees());
        format!("{lat},S,{lon},W,1601.5,{speed_kn:.4},{course_deg:.3}")
    };
    let names = "latitude,NS,longitude,EW,altitude,speed_knots,course";
    let (report, fixes) = fixes(table(names, lettered));
    assert_places(&fixes, &report);
    assert_velocities(&fixes, &report);
    assert!(report.contains("latitude NS longitude EW altitude") && report.contains("ddmm"));
}

#[test]
fn letters_are_the_signs_of_plain_degrees() {
    let lettered =
        |m: &Moment| format!("{:.8},{:.8},1601.5,S,W", m.latitude_deg.abs(), m.longitude_deg.abs());
    let (report, fixes) = fixes(table("lat,lon,alt,lat_dir,lon_dir", lettered));
    assert_places(&fixes, &report);
}

#[test]
fn degrees_and_minutes_with_signs_are_places_and_a_doubt() {
    let signed =
        |m: &Moment| format!("-{},-{},1601.5", ddmm(m.latitude_deg, 2), ddmm(m.longitude_deg, 3));
    let (report, fixes) = fixes(table("lat,lon,alt", signed));
    assert_places(&fixes, &report);
    assert!(report.contains("check: gps: latitude and longitude are taken as ddmm"), "{report}");
}

#[test]
fn places_of_no_known_unit_are_left_out_and_told() {
    let grads = |m: &Moment| {
        format!("{:.5},{:.5},1601.5,0,0,0", m.latitude_deg * 1e3, m.longitude_deg * 1e3)
    };
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("gps.csv");
    fs::write(&file, table("lat,lon,alt,gyro_x,gyro_y,gyro_z", grads)).unwrap();
    let report = Proposal::of(&[file]).unwrap().to_string();
    assert!(
        report.contains("nor degrees and minutes as ddmm.mmmm: the receiver is left out"),
        "{report}"
    );
}
