//! Units, signs and clocks of foreign receivers: the mapped fixes equal the original ones.

use std::f64::consts::{PI, TAU};
use std::fs;

use hovernav::gps::Fix;
use hovernav_formats::Proposal;
use hovernav_testing::shared;

use crate::mapped::mapped;

/// One moment of a drive along a winding road, west of Greenwich and south of the equator.
#[derive(Clone, Copy)]
struct Moment {
    time_s: f64,
    latitude_deg: f64,
    longitude_deg: f64,
    speed_mps: f64,
    /// Course, clockwise from north, 0 to 2π.
    course_rad: f64,
}

/// Two minutes of driving with fixes at 4 Hz.
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

/// The drive as a table: the time in seconds, then the columns `names` with the fields of each moment.
fn table(names: &str, row: impl Fn(&Moment) -> String) -> String {
    let rows = drive().into_iter().map(|m| format!("{:.3},{}\n", m.time_s, row(&m)));
    format!("time_s,{names}\n{}", rows.collect::<String>())
}

/// The report of `init` on a receiver alone, and its fixes.
fn fixes(text: String) -> (String, Vec<Fix>) {
    let (report, _, dataset) = mapped(&[("gps.csv", text)]);
    (report, dataset.fixes)
}

/// Asserts that positions equal the drive's.
fn assert_places(fixes: &[Fix], report: &str) {
    let drive = drive();
    assert_eq!(fixes.len(), drive.len(), "{report}");
    for (fix, moment) in fixes.iter().zip(&drive) {
        let north_deg = fix.position.latitude_rad.to_degrees() - moment.latitude_deg;
        let east_deg = fix.position.longitude_rad.to_degrees() - moment.longitude_deg;
        assert!(north_deg.abs().max(east_deg.abs()) < 2e-7, "{north_deg} {east_deg}\n{report}");
    }
}

/// Asserts that velocities over ground equal the drive's.
fn assert_velocities(fixes: &[Fix], report: &str) {
    for (fix, moment) in fixes.iter().zip(drive()) {
        let [north, east] = fix.horizontal_velocity_mps.unwrap_or([f64::NAN; 2]);
        let (sine, cosine) = moment.course_rad.sin_cos();
        let apart_mps = (north - moment.speed_mps * cosine).hypot(east - moment.speed_mps * sine);
        assert!(apart_mps < 0.02, "{apart_mps} m/s apart\n{report}");
    }
}

/// A height, m, that rises and falls by at most 2 m/s, and the velocity downwards, m/s.
fn climb(time_s: f64) -> (f64, f64) {
    (500.0 + 40.0 * (0.05 * time_s).sin(), -2.0 * (0.05 * time_s).cos())
}

/// An unsigned angle as degrees and minutes in one number.
fn ddmm(angle_deg: f64, width: usize) -> String {
    let angle_deg = angle_deg.abs();
    let whole = angle_deg.trunc();
    format!("{whole:0width$.0}{:010.7}", (angle_deg - whole) * 60.0)
}

#[test]
fn degrees_and_minutes_with_letters_are_positions() {
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
fn degrees_and_minutes_with_signs_are_positions_to_check() {
    let signed =
        |m: &Moment| format!("-{},-{},1601.5", ddmm(m.latitude_deg, 2), ddmm(m.longitude_deg, 3));
    let (report, fixes) = fixes(table("lat,lon,alt", signed));
    assert_places(&fixes, &report);
    assert!(report.contains("check: gps: latitude and longitude are read as ddmm"), "{report}");
}

#[test]
fn positions_of_unknown_unit_are_ignored_with_a_message() {
    let grads = |m: &Moment| {
        format!("{:.5},{:.5},1601.5,0,0,0", m.latitude_deg * 1e3, m.longitude_deg * 1e3)
    };
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("gps.csv");
    fs::write(&file, table("lat,lon,alt,gyro_x,gyro_y,gyro_z", grads)).unwrap();
    let report = Proposal::of(&[file]).unwrap().to_string();
    assert!(
        report.contains("or degrees and minutes as ddmm.mmmm: the receiver is ignored"),
        "{report}"
    );
}

/// A moment's latitude, longitude and height as whole numbers, 1e-7° and mm.
fn scaled(m: &Moment) -> String {
    format!("{:.0},{:.0},1601500", m.latitude_deg * 1e7, m.longitude_deg * 1e7)
}

fn plain(m: &Moment) -> String {
    format!("{:.8},{:.8},1601.5", m.latitude_deg, m.longitude_deg)
}

#[test]
fn the_units_of_speed_and_course_follow_from_the_positions() {
    let written = |per_mps: f64, per_deg: f64| {
        move |m: &Moment| {
            let (speed, course) = (m.speed_mps * per_mps, m.course_rad.to_degrees() * per_deg);
            format!("{},{speed:.4},{course:.4}", plain(m))
        }
    };
    for (unit, per_mps) in [
        ("m/s", 1.0),
        ("km/h", 3.6),
        ("kn", 3600.0 / 1852.0),
        ("mph", 3600.0 / 1609.344),
        ("cm/s", 100.0),
    ] {
        let (report, fixes) = fixes(table("lat,lon,alt,speed,bearing", written(per_mps, 1.0)));
        assert_velocities(&fixes, &report);
        let told = "speed with bearing agrees with the distances between the fixes if the unit is";
        assert!(report.contains(&format!("{told} {unit}")), "{report}");
    }
    for per_deg in [100.0, 1e5, PI / 180.0] {
        let (report, fixes) = fixes(table("lat,lon,alt,speed,course", written(1.0, per_deg)));
        assert_velocities(&fixes, &report);
    }
    let whole = |m: &Moment| {
        let course_cdeg = m.course_rad.to_degrees() * 100.0;
        format!("{},{:.0},{course_cdeg:.0}", scaled(m), m.speed_mps * 100.0)
    };
    for names in ["lat,lon,alt,speed,course", "lat_1e7,lon_1e7,alt_mm,speed_cm_s,course_cdeg"] {
        let (report, fixes) = fixes(table(names, whole));
        assert_places(&fixes, &report);
        assert_velocities(&fixes, &report);
    }
}

#[test]
fn whole_numbers_of_ublox_are_millimetres() {
    let row = |m: &Moment| {
        let (sine, cosine) = m.course_rad.sin_cos();
        let (north, east) = (m.speed_mps * cosine * 1e3, m.speed_mps * sine * 1e3);
        format!("{},14,20,{north:.0},{east:.0},-9,60,3", scaled(m))
    };
    let (report, fixes) = fixes(table("lat,lon,height,hAcc,vAcc,velN,velE,velD,sAcc,fixType", row));
    assert_velocities(&fixes, &report);
    let fix = &fixes[7];
    let sigmas = fix.position_sigma_m.zip(fix.velocity_sigma_mps).unwrap();
    let expected = ([0.014, 0.014, 0.02], [0.06; 3]);
    let off = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-9);
    let is_off = off(sigmas.0.to_array(), expected.0) || off(sigmas.1.to_array(), expected.1);
    assert!(!is_off && (fix.position.height_m - 1601.5).abs() < 1e-6, "{sigmas:?}\n{report}");
}

#[test]
fn mavlink_dilutions_of_precision_are_not_sigmas() {
    let row = |m: &Moment| {
        let course_cdeg = m.course_rad.to_degrees() * 100.0;
        format!("3,{},80,120,{:.0},{course_cdeg:.0},15", scaled(m), m.speed_mps * 100.0)
    };
    let names = "fix_type,lat,lon,alt,eph,epv,vel,cog,satellites_visible";
    let (report, fixes) = fixes(table(names, row));
    assert_velocities(&fixes, &report);
    assert!(fixes.iter().all(|fix| fix.position_sigma_m.is_none()), "{report}");
    assert!(report.contains("eph and epv are ignored: together with degrees × 10⁷"), "{report}");
}

#[test]
fn a_speed_that_contradicts_the_positions_is_to_check() {
    let kmh = |m: &Moment| {
        format!("{},{:.4},{:.3}", plain(m), m.speed_mps * 3.6, m.course_rad.to_degrees())
    };
    let (report, _) = fixes(table("lat,lon,alt,speed_mps,course", kmh));
    assert!(
        report.contains("read as m/s, gives 3.59 times the distances between the fixes"),
        "{report}"
    );
    assert!(report.contains("as km/h they would agree"), "{report}");

    let reversed = |m: &Moment| {
        let (east, north) = m.course_rad.sin_cos();
        format!("{},{:.4},{:.4}", plain(m), m.speed_mps * east, m.speed_mps * north)
    };
    let (report, _) = fixes(table("lat,lon,alt,vn_mps,ve_mps", reversed));
    assert!(
        report.contains("direction of motion differs from vn_mps with ve_mps by a median of"),
        "{report}"
    );

    let standing = |_: &Moment| "-40.0,-105.1,1601.5,0.02,17.5".to_owned();
    let (report, _) = fixes(table("lat,lon,alt,speed,course", standing));
    assert!(
        report.contains("the unit of speed with course is not stated and is assumed to be m/s"),
        "{report}"
    );
}

#[test]
fn vertical_and_horizontal_speeds_may_have_two_units() {
    let row = |m: &Moment| {
        let speed_kn = m.speed_mps * 3600.0 / 1852.0;
        format!("{},{speed_kn:.4},{:.3},0.25", plain(m), m.course_rad.to_degrees())
    };
    let (report, fixes) = fixes(table("lat,lon,alt,speed_knots,course,vd_mps", row));
    assert_velocities(&fixes, &report);
    assert!(fixes.iter().all(|fix| fix.down_velocity_mps == Some(0.25)), "{report}");
}

#[test]
fn a_height_without_a_position_is_barometric_or_to_check() {
    let height = |m: &Moment| format!("{:.3}", 100.0 + 0.01 * m.time_s);
    let receiver = || ("gps.csv", table("lat,lon,alt", plain));
    let (report, _, dataset) = mapped(&[receiver(), ("baro.csv", table("altitude", height))]);
    assert_eq!(dataset.baro.len(), 480, "{report}");

    let (report, _, dataset) =
        mapped(&[receiver(), ("log.csv", table("altitude,foo", |m| format!("{},1", height(m))))]);
    assert!(dataset.baro.is_empty(), "{report}");
    assert!(
        report.contains("check: altitude of log.csv is ignored: the file has no latitude"),
        "{report}"
    );

    let both = |m: &Moment| format!("{},{:.5}", height(m), 1001.0 - 1e-3 * m.time_s);
    let (report, _, dataset) =
        mapped(&[receiver(), ("baro.csv", table("altitude,pressure", both))]);
    assert_eq!(dataset.baro.len(), 480, "{report}");
    assert!(report.contains("no position belongs to it, and pressure is used"), "{report}");
}

#[test]
fn a_vertical_velocity_that_contradicts_the_heights_is_to_check() {
    let rising = |sign: f64| {
        move |m: &Moment| {
            let (height_m, down_mps) = climb(m.time_s);
            let (sine, cosine) = m.course_rad.sin_cos();
            let (north, east) = (m.speed_mps * cosine, m.speed_mps * sine);
            let place = format!("{:.8},{:.8},{height_m:.3}", m.latitude_deg, m.longitude_deg);
            format!("{place},{north:.4},{east:.4},{:.4}", sign * down_mps)
        }
    };
    let names = "lat,lon,alt,vn_mps,ve_mps,vd_mps";
    let (report, _) = fixes(table(names, rising(1.0)));
    assert!(!report.contains("change of height"), "{report}");
    for sign in [-1.0, 3.6] {
        let (report, _) = fixes(table(names, rising(sign)));
        assert!(
            report.contains(&format!("gives {sign:.2} times the change of height")),
            "{report}"
        );
    }
}

#[test]
fn a_hover_that_fits_all_axes_keeps_those_from_gravity() {
    let Some(dir) = shared("datasets/quad-hover-aided") else { return };
    let place = tempfile::tempdir().unwrap();
    let paths = [
        ("imu.csv", "time_s,gyro_x,gyro_y,gyro_z,acc_x,acc_y,acc_z"),
        ("gps.csv", "time_s,lat,lon,alt,vel_n,vel_e,vel_d"),
    ]
    .map(|(file, names)| {
        let text = fs::read_to_string(dir.join(file)).unwrap();
        let rows = text
            .lines()
            .skip(1)
            .map(|row| row.split(',').take(7).collect::<Vec<_>>().join(",") + "\n");
        let path = place.path().join(file);
        fs::write(&path, format!("{names}\n{}", rows.collect::<String>())).unwrap();
        path
    });
    let report = Proposal::of(&paths).unwrap().to_string();
    // Mirrored gyros fit the fixes of this flight equally well.
    for sensor in ["gyro  ", "accel  "] {
        let told = report.lines().find(|line| line.contains(sensor)).unwrap();
        assert!(told.contains("forward-right-down"), "{report}");
    }
}

#[test]
fn one_sigmas_per_axis_are_read_in_their_unit() {
    for (names, to_m, to_mps) in [
        ("std_n,std_e,std_d,std_vn,std_ve,std_vd", 1.0, 1.0),
        ("lat_std_mm,lon_std_mm,alt_std_mm,sdvn_mm_s,sdve_mm_s,sdvu_mm_s", 1e3, 1e3),
        ("sdn(m),sde(m),sdu(m),sigma_vn_mps,sigma_ve_mps,sigma_vd_mps", 1.0, 1.0),
    ] {
        let text = table(&format!("lat_deg,lon_deg,height_m,{names}"), |m| {
            let position = [1.0, 2.0, 3.0].map(|sigma_m| format!("{}", sigma_m * to_m)).join(",");
            let velocity = [0.1, 0.2, 0.3].map(|sigma| format!("{}", sigma * to_mps)).join(",");
            format!("{},{position},{velocity}", plain(m))
        });
        let (report, fixes) = fixes(text);
        assert_places(&fixes, &report);
        for fix in &fixes {
            let sigmas = [fix.position_sigma_m, fix.velocity_sigma_mps];
            let [position, velocity] = sigmas.map(|sigma| sigma.expect(&report).to_array());
            for axis in 0..3 {
                let expected = (axis + 1) as f64;
                assert!((position[axis] - expected).abs() < 1e-9, "{position:?}\n{report}");
                assert!((velocity[axis] - 0.1 * expected).abs() < 1e-9, "{velocity:?}\n{report}");
            }
        }
    }
}

#[test]
fn one_sigmas_of_position_in_degrees_are_ignored_with_a_message() {
    let text = table("lat_deg,lon_deg,height_m,std_lat_deg,std_lon_deg,std_alt_m", |m| {
        format!("{},1e-5,1e-5,2.0", plain(m))
    });
    let (report, fixes) = fixes(text);
    assert!(fixes.iter().all(|fix| fix.position_sigma_m.is_none()), "{report}");
    assert!(report.contains("the unit of std_lat_deg is not a length"), "{report}");
}

#[test]
fn the_vertical_velocity_or_a_pressure_states_the_unit_of_the_height() {
    const FOOT_M: f64 = 0.3048;
    for per_m in [1.0, 1.0 / FOOT_M] {
        for with in ["vd_mps", "vspeed (fpm)", "vspd", "pressure_hPa", "baro_alt_m"] {
            let row = |m: &Moment| {
                let (height_m, down_mps) = climb(m.time_s);
                let beside = match with {
                    "vd_mps" => down_mps,
                    "vspeed (fpm)" | "vspd" => -down_mps * 60.0 / FOOT_M,
                    "baro_alt_m" => height_m - 37.0,
                    _ => 1013.25 * (1.0 - 2.25577e-5 * height_m).powf(5.25588),
                };
                let [lat, lon] = [m.latitude_deg, m.longitude_deg];
                format!("{lat:.8},{lon:.8},{:.3},{beside:.4}", height_m * per_m)
            };
            let (report, fixes) = fixes(table(&format!("lat,lon,alt,{with}"), row));
            // Without a stated unit the two cannot settle each other.
            if with == "vspd" {
                assert!(report.contains("the unit of alt is not stated"), "{report}");
                continue;
            }
            for (fix, moment) in fixes.iter().zip(drive()) {
                let (height_m, down_mps) = climb(moment.time_s);
                let off_m = (fix.position.height_m - height_m).abs();
                assert!(off_m < 1e-3, "{with} {per_m}: {off_m} m\n{report}");
                if let Some(down) = fix.down_velocity_mps {
                    assert!((down - down_mps).abs() < 1e-3, "{with} {down}\n{report}");
                }
            }
        }
    }
}

#[test]
fn the_receiver_states_the_unit_of_a_barometric_height() {
    let row = |m: &Moment| {
        let (height_m, _) = climb(m.time_s);
        format!(
            "{:.8},{:.8},{height_m:.2},{:.2}",
            m.latitude_deg,
            m.longitude_deg,
            height_m / 0.3048
        )
    };
    let (report, _, dataset) = mapped(&[("log.csv", table("lat,lon,alt_m,baro_alt", row))]);
    let moved_m = dataset.baro[200].1 - dataset.baro[0].1;
    let moment = |k: usize| climb(dataset.baro[k].0.seconds()).0;
    assert!((moved_m - (moment(200) - moment(0))).abs() < 0.02, "{moved_m}\n{report}");
}

#[test]
fn a_height_of_unknown_unit_is_reported_in_both() {
    let level = |m: &Moment| format!("{:.8},{:.8},1046.0", m.latitude_deg, m.longitude_deg);
    let (report, _) = fixes(table("lat,lon,alt", level));
    assert!(report.contains("it reaches 1046 m, or 319 m if it is in feet"), "{report}");
}
