//! Cells of foreign text without a value: numbers and words for unknown values, units, marks of validity.

use crate::mapped::mapped;

const IMU: &str = "gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z";

/// Cells of a fix near 33.9° S 151.2° E, `second` seconds after the start, that moves north at 1 m/s.
fn fix(second: u32) -> [String; 3] {
    let latitude = -33.856_802 + 9e-6 * f64::from(second);
    [format!("{latitude:.7}"), "151.2152974".to_owned(), format!("{:.2}", 49.7)]
}

/// A flight of 40 s at 25 Hz with constant velocity. Each row has the time and six inertial cells, then the cells of
/// `gps`.
fn flight(gps_names: &str, gps: impl Fn(u32) -> String) -> String {
    let row = |k: u32| {
        let (time, noise) = (f64::from(k) * 0.04, 1e-4 * f64::from(k % 7));
        format!("{time:.2},{noise:.5},0.001,-0.002,0.01,0.02,-9.81,{}\n", gps(k))
    };
    format!("time,{IMU},{gps_names}\n{}", (0..1000).map(row).collect::<String>())
}

/// The cells that `of` makes from a fix, in one row per second; `blank` in all other rows.
fn each_second(k: u32, of: impl Fn([String; 3]) -> String, blank: &str) -> String {
    if k % 25 == 24 { of(fix(k / 25)) } else { blank.to_owned() }
}

#[test]
fn numbers_for_unknown_positions_cost_their_rows_only() {
    for unknown in ["1000", "655.35", "1e10", "1e9", "1e6", "99999999", "999", "-1", "1.797e308"] {
        let blank = [unknown; 3].join(",");
        let names = "latitude (deg),longitude (deg),altitude (m)";
        let text = flight(names, |k| each_second(k, |cells| cells.join(","), &blank));
        let (report, mapping, dataset) = mapped(&[("flight.csv", text)]);
        assert_eq!(dataset.fixes.len(), 40, "{unknown}: {report}\n{mapping}");
        let position = dataset.fixes[3].position;
        assert!((position.latitude_deg() + 33.8568).abs() < 1e-3, "{unknown}: {report}");
        assert!((position.height_m - 49.7).abs() < 1e-3, "{unknown}: {report}");
        assert!(
            dataset.warnings.iter().any(|warning| warning.contains("960 rows")),
            "{unknown}: {:?}",
            dataset.warnings
        );
    }
}

#[test]
fn numbers_for_an_unknown_latitude_do_not_change_its_unit() {
    let text = flight("latitude (deg),longitude (deg),altitude (m)", |k| {
        let [lat, lon, height] = fix(k / 25);
        let lat = if k % 250 < 25 { "1000".to_owned() } else { lat };
        if k % 25 == 24 { format!("{lat},{lon},{height}") } else { ",,".to_owned() }
    });
    let (report, _, dataset) = mapped(&[("flight.csv", text)]);
    assert_eq!(dataset.fixes.len(), 36, "{report}");
}

#[test]
fn minutes_and_scaled_degrees_are_found_among_numbers_for_unknown_ones() {
    for (unit, cells, blank) in [
        ("ddmm", "-3351.408D,15112.9178,49.7", "1e9,1e9,1e9"),
        ("ddmm", "-3351.408D,15112.9178,49.7", "-1,-1,-1"),
        ("deg1e7", "-33856802D,1512152974,49700", "99999999,99999999,99999999"),
        ("deg1e7", "-33856802D,1512152974,49700", "10000000000,10000000000,0"),
    ] {
        let moved = |k: u32, cells: &str| cells.replace('D', &(k / 25 % 10).to_string());
        let text = flight("lat,lon,alt", |k| each_second(k, |_| moved(k, cells), blank));
        let (report, mapping, dataset) = mapped(&[("flight.csv", text)]);
        assert!(mapping.contains(&format!("unit = \"{unit}\"")), "{blank}: {report}");
        assert_eq!(dataset.fixes.len(), 40, "{blank}: {report}\n{:?}", dataset.warnings);
        assert!((dataset.fixes[3].position.latitude_deg() + 33.8568).abs() < 1e-2, "{report}");
        assert!((dataset.fixes[3].position.height_m - 49.7).abs() < 1e-3, "{report}");
    }
}

#[test]
fn words_in_place_of_numbers_are_missing_values() {
    for word in ["?", "*", "invalid", "x", "No Fix", "1.#QNAN", "-1.#IND", "-nan(ind)", "1.#INF"] {
        let names = "lat,lon,alt,comment";
        let text = flight(names, |k| {
            let blank = [word; 4].join(",");
            each_second(k, |cells| cells.join(",") + ",ok", &blank)
        });
        // The gyro also has cells with words.
        let text = text.replacen("0.00020,", &format!("{word},"), 30);
        let (report, _, dataset) = mapped(&[("flight.csv", text)]);
        assert_eq!((dataset.imu.len(), dataset.fixes.len()), (970, 40), "{word}: {report}");
        let is_counted = dataset.warnings.iter().any(|w| w.contains("text in place of a number"));
        let is_word = !word.contains(['1', '(']);
        assert_eq!(is_counted, is_word, "{word}: {:?}", dataset.warnings);
    }
}

#[test]
fn units_and_hemispheres_in_cells_are_read() {
    let text = flight("lat,lon,alt", |k| {
        each_second(k, |[lat, lon, alt]| format!("{}S,{lon}E,{alt}m", &lat[1..]), ",,")
    });
    let arc = flight("lat,lon,alt", |k| {
        let seconds = 24.5 - f64::from(k) / 775.0;
        each_second(k, |_| format!("33°51'{seconds:.4}\"S,151°12'55.0708\"E,49.7 m"), ",,")
    });
    let minutes = flight("lat,lon,alt", |k| {
        each_second(k, |_| format!("3351.40{:02}S,15112.91784E,49.7m", 99 - k / 25), ",,")
    });
    for text in [text, arc, minutes] {
        let text = text.replace("-9.81,", "-1.0g,");
        let (report, mapping, dataset) = mapped(&[("flight.csv", text)]);
        assert_eq!((dataset.imu.len(), dataset.fixes.len()), (1000, 40), "{report}");
        let position = dataset.fixes[3].position;
        assert!((position.latitude_deg() + 33.8568).abs() < 1e-3, "{report}");
        assert!((position.longitude_deg() - 151.215297).abs() < 1e-5, "{report}");
        assert!(mapping.contains("unit = \"g\""), "{mapping}");
    }
}

#[test]
fn rows_may_end_with_a_comma_that_the_names_lack() {
    let text = flight("lat,lon,alt", |k| each_second(k, |cells| cells.join(",") + ",", ",,,"));
    let (report, _, dataset) = mapped(&[("flight.csv", text)]);
    assert_eq!((dataset.imu.len(), dataset.fixes.len()), (1000, 40), "{report}");
}

#[test]
fn marks_of_validity_reject_fixes() {
    for (name, good, bad) in [
        ("VALID", "SPS", "NO FIX"),
        ("gps_valid", "1", "0"),
        ("fix", "3D", "none"),
        ("fix", "2D", "no fix"),
        ("numSV", "12", "0"),
        ("fix_type", "3", "0"),
    ] {
        let text = flight(&format!("lat,lon,alt,{name}"), |k| {
            let mark = if (250..500).contains(&k) { bad } else { good };
            each_second(k, |cells| format!("{},{mark}", cells.join(",")), ",,,")
        });
        let (report, _, dataset) = mapped(&[("flight.csv", text)]);
        assert_eq!(dataset.fixes.len(), 30, "{name} {bad}: {report}");
        let warnings = &dataset.warnings;
        assert!(warnings.iter().any(|w| w.contains("skipped: no fix")), "{warnings:?}");
    }
}

#[test]
fn a_sensor_of_zeros_is_replaced_by_another_of_the_file() {
    let text = flight("gps1_lat,gps1_lon,gps1_alt,gps2_lat,gps2_lon,gps2_alt", |k| {
        each_second(k, |cells| format!("0,0,0,{}", cells.join(",")), "0,0,0,,,")
    });
    let (report, _, dataset) = mapped(&[("flight.csv", text)]);
    assert_eq!((dataset.imu.len(), dataset.fixes.len()), (1000, 40), "{report}");
}

#[test]
fn numbers_for_an_unknown_velocity_are_no_velocity_and_do_not_change_its_unit() {
    let moving = |unknown: &str, k: u32| {
        each_second(
            k,
            |cells| {
                cells.join(",")
                    + &if k % 225 == 24 { format!(",{unknown}") } else { ",1.0,0.0".into() }
            },
            ",,,,",
        )
    };
    for unknown in ["655.35,655.35", "999.99,999.99", "-9999,-9999", "655.35,0"] {
        let names = "lat,lon,height,vn,ve";
        let (report, mapping, dataset) =
            mapped(&[("flight.csv", flight(names, |k| moving(unknown, k)))]);
        assert_eq!(dataset.fixes.len(), 40, "{unknown}: {report}");
        for (k, fix) in dataset.fixes.iter().enumerate() {
            let expected = (k % 9 != 0).then_some([1.0, 0.0]);
            assert_eq!(
                fix.horizontal_velocity_mps, expected,
                "{unknown}, {k}: {report}\n{mapping}"
            );
        }
    }
    // Phones write -1 for an unknown speed and course.
    let (report, _, dataset) =
        mapped(&[("flight.csv", flight("lat,lon,height,speed,bearing", |k| moving("-1,-1", k)))]);
    let unknown = dataset.fixes.iter().filter(|fix| fix.horizontal_velocity_mps.is_none()).count();
    assert_eq!(unknown, 5, "{report}");
}
