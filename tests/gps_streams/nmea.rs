//! NMEA sentences that give a fix, and sentences that do not.

use approx::assert_abs_diff_eq;
use hovernav::gps::nmea::Decoder;
use hovernav::gps::{Correction, Dimension, Protocol, ReceiverFix};
use hovernav::time::Time;

use crate::fixes;
use hovernav_fly::devices::encode;
use hovernav_fly::devices::encode::{Epoch, nmea_sentence};

fn read(bodies: &[&str]) -> Vec<ReceiverFix> {
    let wire: Vec<u8> = bodies.iter().flat_map(|body| nmea_sentence(body)).collect();
    fixes(Protocol::Nmea, &wire)
}

/// The fixes of bursts of sentences that arrive a second apart, without flushes between them.
fn read_bursts(bursts: &[&[&str]]) -> Vec<ReceiverFix> {
    let mut decoder = Decoder::default();
    let mut fixes = Vec::new();
    for (second, bodies) in bursts.iter().enumerate() {
        let wire: Vec<u8> = bodies.iter().flat_map(|body| nmea_sentence(body)).collect();
        let mut rest = wire.as_slice();
        while let Some(fix) = decoder.read(&mut rest, Time::ZERO + second as f64) {
            fixes.push(fix);
        }
    }
    fixes.extend(decoder.flush());
    fixes
}

const GGA: &str = "GPGGA,094812.00,0120.5000,N,10341.0000,E,1,09,0.9,31.0,M,7.0,M,,";
const RMC: &str = "GPRMC,094812.00,A,0120.5000,N,10341.0000,E,4.0,90.0,230305,,,A";

#[test]
fn rmc_and_gga_of_one_time_are_one_fix() {
    let fix = read(&[RMC, GGA])[0];
    assert_eq!(read(&[RMC, GGA]).len(), 1);
    assert_eq!((fix.height_m, fix.altitude_msl_m), (Some(38.0), Some(31.0)));
    assert_eq!(fix.satellites, Some(9));
    assert_eq!(fix.correction, Some(Correction::None));
    // 4 knots eastwards, and an unknown vertical velocity.
    assert_abs_diff_eq!(
        fix.horizontal_velocity_mps.unwrap()[1],
        4.0 * 1_852.0 / 3_600.0,
        epsilon = 1e-12
    );
    assert_eq!(fix.down_velocity_mps, None);
    // 23 March 2005, 09:48:12.
    assert_eq!(fix.time.unwrap().unix_ns(), Some(1_111_571_292_000_000_000));
}

#[test]
fn places_that_are_not_on_earth_are_refused() {
    for place in [
        "9900.0000,N,10341.0000,E",
        "9000.0001,N,10341.0000,E",
        "0120.5000,N,18000.0001,E",
        "0120.5000,N,20000.0000,E",
        "0160.5000,N,10341.0000,E",
        "0120.5000,N,10361.0000,E",
        "-120.5000,N,10341.0000,E",
        "120.5000,N,10341.0000,E",
        "0120.5000,N,3341.0000,E",
        "0120.5000,N,,E",
        "nan,N,10341.0000,E",
        "01NAN,N,10341.0000,E",
        "01inf,N,103inf,E",
        "012e1,N,10341.0000,E",
        "0120.5000,X,10341.0000,E",
        "0120.5000,NS,10341.0000,E",
        ",,,",
    ] {
        let gga = format!("GPGGA,094812.00,{place},1,09,0.9,31.0,M,7.0,M,,");
        let rmc = format!("GPRMC,094812.00,A,{place},4.0,90.0,230305,,,A");
        assert_eq!(read(&[&gga]), [], "{gga}");
        assert_eq!(read(&[&rmc]), [], "{rmc}");
    }
    assert_eq!(read(&["GPGGA,094812.00,9000.0,S,18000.0,W,1,09,0.9,31.0,M,7.0,M,,"]).len(), 1);
}

#[test]
fn other_impossible_values_are_refused_or_skipped() {
    for body in [
        "GPGGA,094812.00,0120.5,N,10341.0,E,1,09,0.9,123456.0,M,7.0,M,,",
        "GPRMC,094812.00,A,0120.5,N,10341.0,E,5000,90.0,230305,,,A",
        "GPRMC,094812.00,A,0120.5,N,10341.0,E,-4.0,90.0,230305,,,A",
        "GPRMC,094812.00,A,0120.5,N,10341.0,E,4.0,361.0,230305,,,A",
        "GPRMC,246000.00,A,0120.5,N,10341.0,E,4.0,90.0,230305,,,A",
        "GPRMC,94812.00,A,0120.5,N,10341.0,E,4.0,90.0,230305,,,A",
        "GPRMC,,A,0120.5,N,10341.0,E,4.0,90.0,230305,,,A",
    ] {
        assert_eq!(read(&[body]), [], "{body}");
    }
    // An invalid date or dilution only loses its own value.
    let fix = read(&["GPRMC,094812.00,A,0120.5,N,10341.0,E,4.0,90.0,2303-5,,,A"])[0];
    assert_eq!(fix.time.unwrap().unix_ns(), None);
    let fix = read(&["GPGGA,094812.00,0120.5,N,10341.0,E,1,09,0x9,31.0,M,7.0,M,,"])[0];
    assert_eq!(fix.dilution.horizontal, None);
}

#[test]
fn what_the_receiver_does_not_vouch_for_is_no_fix() {
    for quality in ["0", "6", "7", "8"] {
        let gga = format!("GPGGA,094812.00,0120.5,N,10341.0,E,{quality},09,0.9,31.0,M,7.0,M,,");
        assert_eq!(read(&[&gga]), [], "{gga}");
        assert_eq!(read(&[RMC, &gga]), [], "{gga}");
    }
    for (status, mode) in
        [("V", "A"), ("V", "N"), ("A", "N"), ("A", "E"), ("A", "M"), ("A", "S"), ("A", "U")]
    {
        let rmc = format!("GPRMC,094812.00,{status},0120.5,N,10341.0,E,4.0,90.0,230305,,,{mode}");
        assert_eq!(read(&[&rmc]), [], "{rmc}");
        assert_eq!(read(&[&rmc, GGA]), [], "{rmc}");
        // The mode follows the magnetic variation, which some receivers do not send.
        let rmc = rmc.replace(",,,", ",10.5,W,");
        assert_eq!(read(&[&rmc, GGA]), [], "{rmc}");
    }
    assert_eq!(read(&[RMC, "GPGSA,A,1,,,,,,,,,,,,,,,", GGA]), []);
    assert_eq!(read(&["GNGNS,094812.00,0120.5,N,10341.0,E,NN,09,0.9,31.0,7.0,,"]), []);
}

#[test]
fn a_makers_sentence_that_ends_like_a_standard_one_is_not_taken_for_it() {
    assert_eq!(read(&["PGRMC,094812.00,A,0120.5,N,10341.0,E,4.0,90.0,230305,,,A"]), []);
}

#[test]
fn gns_with_a_mode_for_each_of_many_systems_is_read() {
    for modes in ["A", "AN", "NNNA", "AAAAAA", "NNRN"] {
        let gns = format!("GNGNS,094812.00,0120.5,N,10341.0,E,{modes},14,0.6,31.0,7.0,,,V");
        let fix = read(&[&gns])[0];
        assert_eq!(fix.height_m, Some(38.0), "{gns}");
        assert_eq!(fix.satellites, Some(14));
        let rtk = modes.contains('R');
        let expected = if rtk { Correction::RtkFixed } else { Correction::None };
        assert_eq!(fix.correction, Some(expected));
    }
}

#[test]
fn gsa_gives_the_dimension_and_gst_the_sigmas() {
    let fix = read(&[
        RMC,
        GGA,
        "GPGSA,A,2,01,02,03,,,,,,,,,,4.0,3.0,1.3",
        "GPGST,094812.00,1.0,2.0,1.0,30.0,1.5,2.5,3.5",
    ])[0];
    assert_eq!(fix.dimension, Some(Dimension::TwoD));
    assert_eq!(fix.dilution.position, Some(4.0));
    assert_eq!(fix.position_sigma_m.unwrap().to_array(), [1.5, 2.5, 3.5]);
}

#[test]
fn gsa_with_other_than_twelve_satellites_gives_no_dilution() {
    let twelve = "01,02,03,,,,,,,,,";
    for (satellites, system) in [
        // Each of these lacks one field, so that the system is in the field of the vertical dilution.
        ("01,02,03,,,,,,,,", ",1"),
        ("01,02,03,04,05,06,07,08,09,10,11", ",2"),
        // Each of these has additional fields, so that satellites are in the fields of the dilutions.
        ("01,02,03,04,05,06,07,08,09,10,11,12,13", ""),
        ("01,02,03,04,05,06,07,08,09,10,11,12,13,,,,,,,,,,,", ""),
        ("01,02,03,04,05,06,07,08,09,10,11,12,13,14,15,,,,,,,,,", ""),
        ("01,02,1e3,,,,,,,,,", ""),
    ] {
        let gsa = format!("GPGSA,A,3,{satellites},4.0,3.0,1.3{system}");
        let fix = read(&[RMC, GGA, &gsa])[0];
        assert_eq!((fix.dimension, fix.dilution.position), (None, None), "{gsa}");
    }
    for system in ["", ",", ",1", ",A"] {
        let gsa = format!("GPGSA,A,3,{twelve},4.0,3.0,1.3{system}");
        let fix = read(&[RMC, GGA, &gsa])[0];
        assert_eq!(fix.dilution.vertical, Some(1.3), "{gsa}");
    }
}

#[test]
fn a_mode_or_status_of_more_than_one_letter_is_a_damaged_sentence() {
    for end in ["NX", "CA", "Ep", "A,UX", "1"] {
        let rmc = format!("GPRMC,094812.00,A,0120.5,N,10341.0,E,4.0,90.0,230305,,,{end}");
        assert_eq!(read(&[&rmc]), [], "{rmc}");
    }
    assert_eq!(read(&["GNGNS,094812.00,0120.5,N,10341.0,E,AA,09,0.9,31.0,7.0,,,UX"]), []);
}

#[test]
fn a_fix_with_the_status_unsafe_is_no_fix() {
    let rmc = |status| format!("GPRMC,094812.00,A,0120.5,N,10341.0,E,4.0,90.0,230305,,,A{status}");
    assert_eq!(read(&[&rmc(",U")]), []);
    assert_eq!(read(&["GNGNS,094812.00,0120.5,N,10341.0,E,AA,09,0.9,31.0,7.0,,,U"]), []);
    for status in ["", ",", ",S", ",C", ",V"] {
        assert_eq!(read(&[&rmc(status)]).len(), 1, "{status}");
    }
}

#[test]
fn a_course_left_empty_near_rest_leaves_the_direction_unknown_but_not_the_speed() {
    let fix = read(&["GPRMC,094812.00,A,0120.5,N,10341.0,E,0.250,,230305,,,A"])[0];
    assert_eq!(fix.horizontal_velocity_mps, None);
    assert_abs_diff_eq!(fix.ground_speed_mps.unwrap(), 0.128_6, epsilon = 1e-4);
    let fix = read(&["GPRMC,094812.00,A,0120.5,N,10341.0,E,0.00,,230305,,,A"])[0];
    assert_eq!(fix.horizontal_velocity_mps, Some([0.0, 0.0]));
}

/// The SK8's default sentences are GGA and VTG: neither date nor RMC.
#[test]
fn vtg_gives_the_velocity_where_the_receiver_sends_no_rmc() {
    let gga = |second: u32| {
        format!("GPGGA,0948{second:02}.00,0120.5,N,10341.0,E,1,09,0.9,31.0,M,7.0,M,,")
    };
    let vtg = |knots: u32| format!("GPVTG,0.0,T,,M,{knots}.0,N,,K");
    let north = |fix: &ReceiverFix| {
        fix.horizontal_velocity_mps.map(|v| (v[0] * 3_600.0 / 1_852.0).round() as u32)
    };
    let (gga, vtg) = ([gga(1), gga(2), gga(3), gga(4)], [vtg(1), vtg(2), vtg(3), vtg(4)]);
    let after: Vec<[&str; 2]> = gga.iter().zip(&vtg).map(|(g, v)| [g.as_str(), v]).collect();
    let before: Vec<[&str; 2]> = gga.iter().zip(&vtg).map(|(g, v)| [v.as_str(), g]).collect();
    for order in [after, before] {
        let bursts: Vec<&[&str]> = order.iter().map(|burst| &burst[..]).collect();
        let speeds: Vec<_> = read_bursts(&bursts).iter().map(north).collect();
        assert_eq!(speeds, [Some(1), Some(2), Some(3), Some(4)], "{order:?}");
        // A position lost in transfer loses its velocity too.
        let mut lost = bursts.clone();
        let alone = [vtg[1].as_str()];
        lost[1] = &alone;
        let speeds: Vec<_> = read_bursts(&lost).iter().map(north).collect();
        assert_eq!(speeds, [Some(1), Some(3), Some(4)], "{order:?}");
    }
}

#[test]
fn from_the_third_epoch_on_a_fix_is_out_with_its_last_sentence() {
    let mut decoder = Decoder::default();
    for index in 0..6 {
        let wire = encode::nmea_epoch(&Epoch::flying(index));
        let arrival = Time::ZERO + f64::from(index);
        let mut fix_at = None;
        for (position, byte) in wire.iter().enumerate() {
            let mut rest = std::slice::from_ref(byte);
            if let Some(fix) = decoder.read(&mut rest, arrival)
                && fix.arrival == arrival
            {
                fix_at = Some(position);
            }
        }
        // The last byte of the checksum completes the sentence; its line end is not needed.
        assert_eq!(fix_at, (index >= 2).then_some(wire.len() - 3), "epoch {index}");
    }
}

#[test]
fn what_is_skipped_is_counted() {
    let mut decoder = Decoder::default();
    let wire = [
        nmea_sentence(GGA),
        nmea_sentence("GPGSV,1,1,00"),
        b"$GPGGA,no checksum\r\n".to_vec(),
        nmea_sentence("GPGGA,not,a,gga"),
        nmea_sentence("GPGGA,094813.00,9900.0,N,10341.0,E,1,09,0.9,31.0,M,7.0,M,,"),
        nmea_sentence("GPGGA,094814.00,,,,,0,00,,,M,,M,,"),
    ]
    .concat();
    let mut rest = wire.as_slice();
    while decoder.read(&mut rest, Time::ZERO).is_some() {}
    decoder.flush();
    let counts = decoder.counts();
    assert_eq!((counts.read, counts.unknown), (2, 1));
    assert_eq!((counts.damaged, counts.impossible, counts.no_fix), (2, 1, 1));
}
