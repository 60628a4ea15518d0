//! Damaged packets. One damaged packet with a valid checksum does not end an engagement, and many lost packets are
//! reported.

use hovernav::gps::Protocol;
use hovernav_record::Level;

use crate::common::{Setup, all_flown};

/// Times of the damaged packets, s: in hover, while a stick steers, and just after engagement.
const DAMAGED_S: [f64; 3] = [8.4, 12.0, 16.0];
/// Duration in which exactly one packet arrives, s.
const ONE_PACKET_S: f64 = 0.031;

#[test]
fn one_damaged_packet_never_ends_an_engagement() {
    let mut acts = vec!["engage@8:12".to_owned(), "stick-longitudinal=0.3@15:3".to_owned()];
    acts.extend(DAMAGED_S.map(|second| format!("wild-packet@{second}:{ONE_PACKET_S}")));
    let acts: Vec<&str> = acts.iter().map(String::as_str).collect();
    let flights = all_flown(&[()], |()| Setup { pilot: "steer", ..Setup::new(22.0, &acts) });
    let flown = &flights[0];
    let events: Vec<_> = flown.told().collect();
    for second in DAMAGED_S {
        let after_s = flown.after(second, "gyro x jumped to 1.50 times its rated range");
        assert!((-0.01..0.08).contains(&after_s), "{second} s: {after_s} s");
    }
    assert_eq!(flown.crashed_s, None);
    assert!(flown.at("the attitude is not known").is_none(), "{events:#?}");
    let engaged_s = flown.statistics().engaged_s;
    assert!(engaged_s > 11.8, "{engaged_s} s of 12 s: {events:#?}");
    // The damage has no visible effect on the attitude.
    let worst = flown
        .samples
        .iter()
        .filter(|sample| sample.truth.time.seconds() > 8.0 && sample.truth.time.seconds() < 20.0)
        .map(|sample| {
            let angles = sample.truth.body_to_ned.euler();
            angles.roll_rad.abs().max(angles.pitch_rad.abs())
        })
        .fold(0.0, f64::max);
    assert!(worst < 0.35, "{worst} rad");
}

/// TSIP has no checksum: a damaged fix is received as a good fix.
#[test]
fn one_damaged_fix_never_ends_an_engagement() {
    let protocols = [(Protocol::Tsip, "tsip"), (Protocol::Ubx, "ubx")];
    let flights = all_flown(&protocols, |protocol| Setup {
        protocol: *protocol,
        ..Setup::new(24.0, &["engage@8:14", "wild-fix@13.9:0.9"])
    });
    for ((_, name), flown) in protocols.iter().zip(&flights) {
        let events: Vec<_> = flown.told().collect();
        assert!(flown.after(13.9, "rejected") < 1.5, "{name}");
        assert_eq!(flown.crashed_s, None, "{name}");
        let statistics = flown.statistics();
        assert!(statistics.engaged_s > 13.8, "{name}: {events:#?}");
        assert!(flown.at("the pilot flies: the attitude").is_none(), "{name}: {events:#?}");
        assert!(statistics.place_m < 5.0, "{name}: {} m", statistics.place_m);
    }
}

/// One byte in a hundred of the receiver's line is damaged for 20 s. TSIP has no checksum: damaged fixes look intact.
/// UBX has a checksum: epochs are lost, and the remaining epochs keep the vehicle at its position.
#[test]
fn a_noisy_line_of_the_receiver_moves_nothing() {
    let acts = ["engage@8:30", "gps-noise@12:20"];
    let protocols = [(Protocol::Tsip, "tsip"), (Protocol::Ubx, "ubx")];
    let flights =
        all_flown(&protocols, |protocol| Setup { protocol: *protocol, ..Setup::new(40.0, &acts) });
    for ((_, name), flown) in protocols.iter().zip(&flights) {
        let events: Vec<_> = flown.told().collect();
        let statistics = flown.statistics();
        println!("{name}: {:.1} s engaged, {:.1} m off", statistics.engaged_s, statistics.place_m);
        assert_eq!(flown.crashed_s, None, "{name}: {events:#?}");
        assert!(statistics.engaged_s > 29.8, "{name}: {events:#?}");
        assert!(statistics.place_m < 8.0, "{name}: {} m: {events:#?}", statistics.place_m);
    }
}

/// Two damaged packets in a row count as motion at full scale. Without the rejection of single packets, one packet
/// would have the same effect.
#[test]
fn damage_that_lasts_is_not_coasted_over() {
    let acts = ["engage@8:12", "wild-packet@12:0.4"];
    let flights = all_flown(&[()], |()| Setup::new(16.0, &acts));
    let events: Vec<_> = flights[0].told().collect();
    let after_s = flights[0].after(12.0, "the pilot flies: the attitude is not known");
    assert!((0.0..0.3).contains(&after_s), "{after_s} s: {events:#?}");
}

/// With one damaged byte in a hundred, a quarter of the packets of 30 bytes is lost.
#[test]
fn lost_packets_are_reported_in_flight_and_so_is_their_end() {
    let flights = all_flown(&[()], |()| Setup::new(60.0, &["engage@8:50", "dmu-noise@10:25"]));
    let flown = &flights[0];
    let events: Vec<_> = flown.told().collect();
    let lost: Vec<_> =
        flown.record.events.iter().filter(|event| event.kind == "samples lost").collect();
    let levels: Vec<Level> = lost.iter().map(|event| event.level).collect();
    assert_eq!(levels, [Level::Warning, Level::Info], "{events:#?}");
    assert!(lost[0].text.contains("% of the samples are missing"), "{events:#?}");
    let (told_s, over_s) = (flown.second(lost[0].time), flown.second(lost[1].time));
    assert!(told_s < 31.0 && (35.0..56.0).contains(&over_s), "{told_s} s, {over_s} s");
    // The observer sees the recovery too, and no error after it.
    let after = flown.said.iter().filter(|said| flown.second(said.time) > over_s + 0.1);
    let errors: Vec<_> = after.filter(|said| said.level > Level::Info).collect();
    assert!(errors.is_empty(), "{errors:?}");
    assert_eq!(flown.crashed_s, None);
}
