//! Cells of foreign text without a value: numbers and words for unknown ones, units, marks of validity.

use crate::mapped::mapped;

const IMU: &str = "gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z";

/// Cells of a fix near 33.9° S 151.2° E, `second` seconds after the start, that moves north at 1 m/s.
fn fix(second: u32) -> [String; 3] {
    let latitude = -33.856_802 + 9e-6 * f64::from(second);
    [format!("{latitude:.7}"), "151.2152974".to_owned(), format!("{:.2}", 49.7)]
}

/// Forty seconds at rest at 25 Hz, the time and six inertial cells, then the cells of `gps` in each row.
fn flight(gps_names: &str, gps: impl Fn(u32) -> String) -> String {
    let row = |k: u32| {
        let (time, noise) = (f64::from(k) * 0.04, 1e-4 * f64::from(k % 7));
        format!("{time:.2},{noise:.5},0.001,-0.002,0.01,0.02,-9.81,{}\n", gps(k))
    };
    format!("time,{IMU},{gps_names}\n{}", (0..1000).map(row).collect::<String>())
}

/// The cells of `of` with the fix of each second, once a second, else `blank`.
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
