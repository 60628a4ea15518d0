//! Files of loggers that are easily misread: `init` names each uncertain reading.

use std::fs;

use hovernav_formats::{Options, Proposal, open};

use crate::mapped::mapped;

/// A refusal of `init` for the file `name`.
fn refusal(name: &str, text: &str) -> String {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join(name);
    fs::write(&path, text).unwrap();
    Proposal::of(&[path]).unwrap_err().to_string()
}

/// A minute of driving north at about 8 m/s, at a height of 450 m that scatters by 2 m, in columns called by `gps`.
fn level_drive(gps: &str, sigma: &str) -> [(&'static str, String); 2] {
    let (mut imu, mut fixes) = (
        "time_s,gyro_x_radps,gyro_y_radps,gyro_z_radps,ax_mps2,ay_mps2,az_mps2\n".to_owned(),
        format!("{gps}\n"),
    );
    let mut lat_deg = 47.0;
    for k in 0..6000_u32 {
        let time_s = 0.02 * f64::from(k);
        let speed = 8.0 + 3.0 * (0.1 * time_s).sin();
        let noise = f64::from(k * 7 % 11) / 5.0 - 1.0;
        let ax = 0.3 * (0.1 * time_s).cos() + 0.05 * noise;
        imu += &format!("{time_s:.2},{:.5},{:.5},0,{ax:.4},0,-9.81\n", 1e-3 * noise, 1e-3 * noise);
        if k % 50 == 0 {
            let height = 450.0 + 2.0 * noise;
            fixes += &format!("{time_s:.2},{lat_deg:.8},8.5,{height:.2},{speed:.3},0.0{sigma}\n");
        }
        lat_deg += (speed * 0.02 / 6.37e6_f64).to_degrees();
    }
    [("imu.csv", imu), ("gps.csv", fixes)]
}

#[test]
fn heights_that_only_scatter_do_not_decide_their_unit() {
    let names = "time_s,latitude,longitude,altitude,speed,bearing";
    for (more, sigma) in [("", ""), (",verticalAccuracy,horizontalAccuracy", ",3,4")] {
        let (report, mapping, dataset) = mapped(&level_drive(&format!("{names}{more}"), sigma));
        let height_m = dataset.fixes[9].position.height_m;
        assert!((height_m - 450.0).abs() < 5.0, "{height_m}: {report}\n{mapping}");
        assert!(!report.contains("agree with altitude"), "{report}");
        assert!(report.contains("check: gps: the unit of altitude is not stated"), "{report}");
    }
}

#[test]
fn the_setting_of_an_altimeter_is_no_barometer() {
    let row = |k: u32| {
        let (lat, feet) = (47.0 + 1e-4 * f64::from(k), 1500.0 + 5.0 * f64::from(k));
        format!(
            "2024-05-05, 12:{:02}:{:02}, -07:00, KXYZ, {lat:.7}, 8.5, {:.1}, 30.12, {feet:.1}, 21.6, 0.0\n",
            k / 60,
            k % 60,
            feet + 40.0
        )
    };
    let rows: String = (0..120).map(row).collect();
    let text = format!(
        "#airframe_info, log_version=\"1.00\"\n\
         #yyy-mm-dd, hh:mm:ss, hh:mm, ident, degrees, degrees, ft Baro, inch, ft msl, kt, deg\n\
         Lcl Date, Lcl Time, UTCOfst, AtvWpt, Latitude, Longitude, AltB, BaroA, AltMSL, GndSpd, TRK\n{rows}"
    );
    let (report, mapping, dataset) = mapped(&[("log.csv", text)]);
    assert!((dataset.fixes[0].position.height_m - 457.2).abs() < 0.1, "{report}\n{mapping}");
    assert!((dataset.baro[0].1 - 469.4).abs() < 0.1, "{report}\n{mapping}");
}

#[test]
fn inches_of_mercury_are_a_pressure() {
    for name in ["pressure_inHg", "pressure"] {
        let row =
            |k: u32| format!("{k},0,0,{}e-4,0,0,-9.81,{:.3}\n", k % 7, 29.92 - 1e-3 * f64::from(k));
        let rows: String = (0..100).map(row).collect();
        let text = format!("time_s,gx,gy,gz,ax,ay,az,{name}\n{rows}");
        let (report, _, dataset) = mapped(&[("imu.csv", text)]);
        assert!(dataset.baro[0].1.abs() < 1.0, "{name}: {:?} {report}", dataset.baro[0]);
        let is_asked = report.contains("check: baro:") && report.contains("kPa");
        assert_eq!(is_asked, name == "pressure", "{report}");
    }
}

#[test]
fn texts_without_columns_of_degrees_are_refused_by_name() {
    let rinex = "     3.03           OBSERVATION DATA    M                   RINEX VERSION / TYPE\n\
                 > 2024 05 05 12 00  0.0000000  0  1\n> 2024 05 05 12 00  1.0000000  0  1\n";
    assert!(refusal("a.obs", rinex).contains("found RINEX"), "{}", refusal("a.obs", rinex));
    let packed =
        "3.0                 COMPACT RINEX FORMAT                    CRINEX VERS   / TYPE\n";
    assert!(refusal("a.crx", packed).contains("found RINEX"), "{}", refusal("a.crx", packed));
    let row = |k: u32| {
        let second = 0.01 * f64::from(k);
        format!(
            "2312 {:.3} 47 01 {second:08.5} 8 30 {second:08.5} 450.0 1 12 0.01 0.01 0.02\n",
            43_200 + k
        )
    };
    let rows: String = (0..60).map(row).collect();
    let text = format!(
        "%  GPST latitude(d'\") longitude(d'\") height(m) Q ns sdn(m) sde(m) sdu(m)\n{rows}"
    );
    let refusal = refusal("a.pos", &text);
    assert!(refusal.contains("degrees, minutes and seconds"), "{refusal}");
}

#[test]
fn an_epoch_in_single_precision_is_named() {
    let row = |k: u32| {
        let time_s = f64::from((1_714_900_000.0 + f64::from(k)) as f32);
        format!("{time_s:.0},0.01,0.02,{}e-3,0,0,-9.81\n", k % 7)
    };
    let rows: String = (0..300).map(row).collect();
    let refusal = refusal("imu.csv", &format!("timestamp,gx,gy,gz,ax,ay,az\n{rows}"));
    assert!(refusal.contains("single precision"), "{refusal}");
}

#[test]
fn a_receiver_without_a_height_is_named() {
    let row = |k: u32| format!("{k},{},8.5,30\n", 47.0 + 1e-5 * f64::from(k));
    let rows: String = (0..60).map(row).collect();
    let gyro: String = (0..600)
        .map(|k| format!("{:.1},0,0,{}e-4,0,0,-9.81\n", 0.1 * f64::from(k), k % 7))
        .collect();
    let (report, ..) = mapped(&[
        ("imu.csv", format!("t,gx,gy,gz,ax,ay,az\n{gyro}")),
        ("gps.csv", format!("t,lat,lon,speed\n{rows}")),
    ]);
    assert!(report.contains("check: gps: lat and lon have no height"), "{report}");
    let (_, _, dataset) = mapped(&[("gps.csv", format!("t,lat,lon,Höhe [m]\n{rows}"))]);
    assert_eq!(dataset.fixes.len(), 60);
}

#[test]
fn numbered_columns_of_a_position_and_a_velocity_are_read() {
    let row = |k: u32| format!("{k},{},8.5,450,3,0,0\n", 47.0 + 1e-5 * f64::from(k));
    let rows: String = (0..60).map(row).collect();
    for names in [
        "llh_1,llh_2,llh_3,vel_ned_1,vel_ned_2,vel_ned_3",
        "lla[0],lla[1],lla[2],v_ned[0],v_ned[1],v_ned[2]",
    ] {
        let (report, _, dataset) = mapped(&[("gps.csv", format!("t,{names}\n{rows}"))]);
        assert_eq!(dataset.fixes.len(), 60, "{report}");
        assert_eq!(dataset.fixes[0].horizontal_velocity_mps, Some([3.0, 0.0]), "{report}");
    }
}

#[test]
fn a_file_that_is_named_is_no_settings_file_and_its_error_is_reported() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = place.path().join(name);
        fs::write(&path, text).unwrap();
        path
    };
    let [imu, gps] = level_drive("time_s,lat,lon,height,speed,course", "");
    let settings = write("Metadata.csv", "version,name,zone\n3,Pixel,Zurich\n");
    let gps = write("gps.csv", &gps.1);
    let refused = |files: &[std::path::PathBuf]| Proposal::of(files).unwrap_err().to_string();
    for files in [vec![settings.clone(), gps.clone()], vec![gps, settings.clone()]] {
        assert!(refused(&files).contains("Metadata.csv"), "{}", refused(&files));
    }
    let other = write("other.csv", "a,b\nx,y\n");
    for files in [vec![settings, other], vec![place.path().to_path_buf()]] {
        fs::remove_file(place.path().join("gps.csv")).ok();
        let error = refused(&files);
        assert!(error.contains("Metadata.csv") && !error.contains("capture"), "{error}");
    }
    write("imu.csv", &imu.1);
    assert!(Proposal::of(&[place.path().to_path_buf()]).is_ok());
}

/// `level_drive` in a directory `place`, one file of each name for a sensor.
fn drive_in(place: &std::path::Path, names: [&str; 2]) {
    let drive = level_drive("time_s,lat,lon,height,speed,course", "");
    for (name, (_, text)) in names.into_iter().zip(drive) {
        let path = place.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
}

#[test]
fn a_directory_of_one_log_in_subdirectories_is_read() {
    for names in [
        ["mav0/imu0/data.csv", "mav0/gps0/data.csv"],
        ["flight/imu.csv", "flight/gps.csv"],
        ["imu/0.txt", "gnss/0.txt"],
    ] {
        let place = tempfile::tempdir().unwrap();
        drive_in(place.path(), names);
        drive_in(place.path(), ["mav0/cam0/data.csv", "mav0/state_groundtruth0/data.csv"]);
        let proposal = Proposal::of(&[place.path().to_path_buf()]).unwrap();
        assert!(proposal.has_motion() && proposal.has_fixes(), "{names:?}: {proposal}");
        let error = open(place.path(), &Options::default()).unwrap_err().to_string();
        assert!(error.contains("Run `hovernav init"), "{names:?}: {error}");
    }
}

#[test]
fn a_directory_of_several_logs_or_of_a_file_for_each_row_is_refused_with_the_next_step() {
    let refused = |path: &std::path::Path| {
        let error = Proposal::of(&[path.to_path_buf()]).unwrap_err().to_string();
        assert_eq!(open(path, &Options::default()).unwrap_err().to_string(), error);
        error
    };
    let place = tempfile::tempdir().unwrap();
    drive_in(place.path(), ["monday/imu.csv", "monday/gps.csv"]);
    drive_in(place.path(), ["tuesday/imu.csv", "tuesday/gps.csv"]);
    let error = refused(place.path());
    assert!(error.contains("in 2 subdirectories") && error.contains("tuesday"), "{error}");
    let place = tempfile::tempdir().unwrap();
    let oxts = place.path().join("drive_0001/oxts");
    fs::create_dir_all(oxts.join("data")).unwrap();
    for k in 0..150 {
        fs::write(oxts.join(format!("data/{k:010}.txt")), "49.0 8.4 112.8 0.02 0.01\n").unwrap();
    }
    for name in ["timestamps.txt", "dataformat.txt"] {
        fs::write(oxts.join(name), "2011-09-26 13:02:25.594360375\n").unwrap();
    }
    for path in [place.path(), &oxts, &oxts.join("data")] {
        let error = refused(path);
        assert!(error.contains("oxts/timestamps.txt <(cat "), "{error}");
        assert!(error.contains("`hovernav init oxts.txt`"), "{error}");
    }
}

#[test]
fn positions_in_metres_and_messages_without_times_are_refused_with_the_next_step() {
    for (names, step) in [
        ("utm_easting,utm_northing,alt,speed,course", "cs2cs"),
        ("east_m,north_m,up_m,speed,course", "lat = LAT + north"),
        ("pos_x,pos_y,pos_z,speed,course", "lat = LAT + north"),
    ] {
        let [imu, (_, fixes)] = level_drive(&format!("time_s,{names}"), "");
        let fixes = fixes.replace(",47.", ",5220");
        let (report, ..) = mapped(&[imu, ("gps.csv", fixes)]);
        assert!(report.contains(step), "{report}");
    }
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("vn.txt");
    let lines =
        "$VNIMU,-0.13,+0.02,+0.44,-0.02,+0.02,-9.81,+0.01,+0.02,+0.03,+25.0,+101.325*62\r\n";
    fs::write(&path, lines.repeat(20)).unwrap();
    for error in [
        Proposal::of(std::slice::from_ref(&path)).unwrap_err().to_string(),
        open(&path, &Options::default()).unwrap_err().to_string(),
    ] {
        assert!(error.contains("VectorNav") && error.contains("Control Center"), "{error}");
    }
}

#[test]
fn a_directory_above_a_log_names_it_and_remarks_are_no_tables() {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("out.txt"), "printed 1 2 3\n").unwrap();
    let error = || open(place.path(), &Options::default()).unwrap_err().to_string();
    assert!(error().contains("imu.csv: no such file"), "{}", error());
    fs::remove_file(place.path().join("out.txt")).unwrap();
    let log = place.path().join("monday");
    fs::create_dir(&log).unwrap();
    fs::write(log.join("imu.csv"), "t_s,gyro_x_radps\n0,0\n").unwrap();
    assert!(error().ends_with(&format!("expected its log {}", log.display())), "{}", error());
}
