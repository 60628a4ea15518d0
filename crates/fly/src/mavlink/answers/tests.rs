#![expect(deprecated, reason = "older stations still send these messages")]

use super::super::tests::{at, flying, messages_of, read};
use super::*;
use hovernav_record::MavlinkConfig;

/// The answers to `requests` from system 255, component 190.
fn answers(mavlink: &mut Mavlink, requests: &[MavMessage]) -> Vec<MavMessage> {
    let mut bytes = Vec::new();
    for (sequence, request) in requests.iter().enumerate() {
        let header =
            mavlink::MavHeader { system_id: 255, component_id: 190, sequence: sequence as u8 };
        let mut raw = mavlink::MAVLinkV2MessageRaw::new();
        raw.serialize_message(header, request);
        bytes.extend_from_slice(raw.raw_bytes());
    }
    // In pieces, as on a serial line.
    bytes.chunks(7).for_each(|piece| mavlink.receive(piece, at(3.0)));
    let mut out = Vec::new();
    for _ in 0..64 {
        mavlink.answer(&mut out);
    }
    read(&out).into_iter().map(|(_, message)| message).collect()
}

fn command(command: common::MavCmd, param1: f32) -> MavMessage {
    MavMessage::COMMAND_LONG(common::COMMAND_LONG_DATA {
        command,
        param1,
        target_system: 1,
        ..common::COMMAND_LONG_DATA::DEFAULT
    })
}

#[test]
fn parameters_are_read_and_never_written() {
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), Time::ZERO);
    let list = common::PARAM_REQUEST_LIST_DATA { target_system: 1, target_component: 1 };
    let answered = answers(&mut mavlink, &[MavMessage::PARAM_REQUEST_LIST(list)]);
    let values: Vec<_> = answered
        .iter()
        .map(|message| match message {
            MavMessage::PARAM_VALUE(value) => (value.param_index, value.param_count),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(values, (0..11).map(|index| (index, 11)).collect::<Vec<_>>());

    let set = common::PARAM_SET_DATA {
        param_value: 50.0,
        target_system: 1,
        param_id: "HZ_ATTITUDE".into(),
        ..common::PARAM_SET_DATA::DEFAULT
    };
    let answered = answers(&mut mavlink, &[MavMessage::PARAM_SET(set)]);
    let [MavMessage::PARAM_ERROR(error), MavMessage::PARAM_VALUE(value), ..] = &answered[..] else {
        panic!("{answered:?}")
    };
    assert_eq!(error.error, common::MavParamError::MAV_PARAM_ERROR_READ_ONLY);
    assert_eq!((value.param_id.to_str().unwrap(), value.param_value), ("HZ_ATTITUDE", 33.0));
    let missing = common::PARAM_REQUEST_READ_DATA {
        param_index: -1,
        target_system: 1,
        param_id: "NO_SUCH".into(),
        ..common::PARAM_REQUEST_READ_DATA::DEFAULT
    };
    let answered = answers(&mut mavlink, &[MavMessage::PARAM_REQUEST_READ(missing)]);
    assert!(matches!(answered[..], [MavMessage::PARAM_ERROR(_)]), "{answered:?}");
}

#[test]
fn every_command_is_acknowledged_and_none_changes_the_flight() {
    use common::MavCmd::*;
    use common::MavResult::*;
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), Time::ZERO);
    messages_of(&mut mavlink, &flying(at(2.0)));
    for (asked, param, expected) in [
        (MAV_CMD_COMPONENT_ARM_DISARM, 1.0, MAV_RESULT_DENIED),
        (MAV_CMD_COMPONENT_ARM_DISARM, 0.0, MAV_RESULT_DENIED),
        (MAV_CMD_DO_SET_MODE, 0.0, MAV_RESULT_DENIED),
        (MAV_CMD_GET_MESSAGE_INTERVAL, 30.0, MAV_RESULT_ACCEPTED),
        (MAV_CMD_NAV_TAKEOFF, 0.0, MAV_RESULT_UNSUPPORTED),
        (MAV_CMD_REQUEST_MESSAGE, 9_999.0, MAV_RESULT_UNSUPPORTED),
        (MAV_CMD_REQUEST_MESSAGE, 148.0, MAV_RESULT_ACCEPTED),
        (MAV_CMD_REQUEST_MESSAGE, 242.0, MAV_RESULT_ACCEPTED),
        (MAV_CMD_REQUEST_MESSAGE, 300.0, MAV_RESULT_ACCEPTED),
        (MAV_CMD_REQUEST_MESSAGE, 435.0, MAV_RESULT_ACCEPTED),
        (MAV_CMD_REQUEST_MESSAGE, 436.0, MAV_RESULT_ACCEPTED),
    ] {
        let answered = answers(&mut mavlink, &[command(asked, param)]);
        let acknowledged: Vec<_> = answered
            .iter()
            .filter_map(|message| match message {
                MavMessage::COMMAND_ACK(ack) => Some((ack.command, ack.result)),
                _ => None,
            })
            .collect();
        assert_eq!(acknowledged, [(asked, expected)], "{answered:?}");
        assert_eq!(answered.len() > 1, expected != MAV_RESULT_UNSUPPORTED, "{answered:?}");
    }
    // The names of the modes are ours.
    let answered = answers(&mut mavlink, &[command(MAV_CMD_REQUEST_MESSAGE, 435.0)]);
    let names: Vec<_> = answered
        .iter()
        .filter_map(|message| match message {
            MavMessage::AVAILABLE_MODES(mode) => Some(mode.mode_name.to_str().unwrap().to_owned()),
            _ => None,
        })
        .collect();
    assert_eq!(names.len(), 6);
    assert_eq!(names[3..5], ["the pilot", "the autopilot"]);
}

/// Requests an interval, µs, of a message. Returns the result and the interval that the vehicle reports afterwards.
fn interval(mavlink: &mut Mavlink, id: f32, interval_us: f32) -> (MavResult, i32) {
    let MavMessage::COMMAND_LONG(mut set) = command(MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, id)
    else {
        unreachable!()
    };
    set.param2 = interval_us;
    let get = command(MavCmd::MAV_CMD_GET_MESSAGE_INTERVAL, id);
    let (mut result, mut reported) = (None, None);
    for message in answers(mavlink, &[MavMessage::COMMAND_LONG(set), get]) {
        match message {
            MavMessage::COMMAND_ACK(ack) => _ = result.get_or_insert(ack.result),
            MavMessage::MESSAGE_INTERVAL(interval) => reported = Some(interval.interval_us),
            _ => {}
        }
    }
    (result.unwrap(), reported.unwrap())
}

#[test]
fn an_interval_is_set_where_the_line_has_room_and_reported_as_it_is() {
    use MavResult::*;
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), Time::ZERO);
    for (id, asked_us, expected) in [
        (30.0, 100_000.0, (MAV_RESULT_ACCEPTED, 100_000)),
        (30.0, 10_000.0, (MAV_RESULT_DENIED, 100_000)),
        (30.0, f32::NAN, (MAV_RESULT_DENIED, 100_000)),
        (30.0, f32::INFINITY, (MAV_RESULT_DENIED, 100_000)),
        (30.0, -7.0, (MAV_RESULT_DENIED, 100_000)),
        (30.0, 0.0, (MAV_RESULT_ACCEPTED, 30_303)),
        (30.0, -1.0, (MAV_RESULT_ACCEPTED, -1)),
        (0.0, -1.0, (MAV_RESULT_DENIED, 1_000_000)),
        (1.0, 100_000.0, (MAV_RESULT_DENIED, 1_000_000)),
        (1.0, 0.0, (MAV_RESULT_ACCEPTED, 1_000_000)),
        (9_999.0, 100_000.0, (MAV_RESULT_UNSUPPORTED, 0)),
    ] {
        assert_eq!(interval(&mut mavlink, id, asked_us), expected, "{id} {asked_us}");
    }
    let count = |mavlink: &mut Mavlink| {
        let heard =
            (0..330).flat_map(|k| messages_of(mavlink, &flying(at(3.0 + f64::from(k) / 33.0))));
        heard.filter(|message| matches!(message, MavMessage::ATTITUDE(_))).count()
    };
    assert_eq!(count(&mut mavlink), 0, "it is off");
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), Time::ZERO);
    interval(&mut mavlink, 30.0, 500_000.0);
    let heard = count(&mut mavlink);
    assert!((20..=21).contains(&heard), "{heard} in 10 s");
}

#[test]
fn missions_pings_and_clocks_are_answered_and_strangers_are_not() {
    let mut mavlink = Mavlink::new(MavlinkConfig::default(), Time::ZERO);
    let list = |target_system| {
        let target_component = 1;
        MavMessage::MISSION_REQUEST_LIST(common::MISSION_REQUEST_LIST_DATA {
            target_system,
            target_component,
        })
    };
    let ping = common::PING_DATA { seq: 7, time_usec: 5, target_system: 0, target_component: 0 };
    let sync = common::TIMESYNC_DATA { tc1: 0, ts1: 77 };
    let answered = answers(
        &mut mavlink,
        &[list(1), list(9), MavMessage::PING(ping), MavMessage::TIMESYNC(sync)],
    );
    let [MavMessage::MISSION_COUNT(count), MavMessage::PING(ping), MavMessage::TIMESYNC(sync)] =
        &answered[..]
    else {
        panic!("{answered:?}")
    };
    assert_eq!((count.count, count.target_system, count.target_component), (0, 255, 190));
    assert_eq!((ping.seq, ping.target_system), (7, 255));
    assert_eq!((sync.tc1, sync.ts1), (3_000_000_000, 77));
    // Noise is survived, and requests without end do not fill the memory.
    let noise: Vec<u8> =
        (0..100_000u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    noise.chunks(64).for_each(|piece| mavlink.receive(piece, at(4.0)));
    let flood: Vec<MavMessage> = (0..1000).map(|_| list(1)).collect();
    assert!(answers(&mut mavlink, &flood).len() <= 64);
}
