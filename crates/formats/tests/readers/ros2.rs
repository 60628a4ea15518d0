//! MCAP with ROS 2 messages, written byte by byte in this test.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write as _;
use std::path::Path;

use approx::assert_abs_diff_eq;
use hovernav::frames::Vector;
use hovernav::imu::Motion;
use hovernav_dataset::Dataset;
use hovernav_formats::{Format, Log, Options, open, open_bytes};

const ORIGINAL: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../datasets/heli-hover");
const START_NS: u64 = 1_752_000_000_000_000_000;

/// A message written field by field.
struct Cdr {
    bytes: Vec<u8>,
    little: bool,
}

impl Cdr {
    fn new(little: bool) -> Self {
        Self { bytes: vec![0, u8::from(little), 0, 0], little }
    }

    fn put<const N: usize>(&mut self, mut value: [u8; N]) {
        while !(self.bytes.len() - 4).is_multiple_of(N) {
            self.bytes.push(0);
        }
        if !self.little {
            value.reverse();
        }
        self.bytes.extend(value);
    }

    fn doubles(&mut self, values: &[f64]) {
        values.iter().for_each(|value| self.put(value.to_le_bytes()));
    }

    fn header(&mut self, at_ns: u64, frame: &str) {
        self.put(((at_ns / 1_000_000_000) as i32).to_le_bytes());
        self.put(((at_ns % 1_000_000_000) as u32).to_le_bytes());
        self.put((frame.len() as u32 + 1).to_le_bytes());
        self.bytes.extend(frame.as_bytes());
        self.bytes.push(0);
    }
}

/// The flight of the hovering helicopter as ROS 2 records it: forward-left-up, east-north-up.
fn recorded(little: bool, stamped: bool) -> Vec<u8> {
    let original = Dataset::open(ORIGINAL.as_ref()).unwrap();
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut writer = mcap::WriteOptions::new()
        .compression(None)
        .chunk_size(Some(50_000))
        .create(file.reopen().unwrap())
        .unwrap();
    let mut channel = |topic: &str, schema: &str| {
        let schema = writer.add_schema(schema, "ros2msg", b"").unwrap();
        writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap()
    };
    let imu = channel("/imu", "sensor_msgs/msg/Imu");
    let other = channel("/other_imu", "sensor_msgs/msg/Imu");
    let fix = channel("/fix", "sensor_msgs/msg/NavSatFix");
    let velocity = channel("/vel", "geometry_msgs/msg/TwistStamped");
    let estimated = channel("/an_estimate", "geometry_msgs/msg/TwistStamped");
    let odometry = channel("/odometry", "nav_msgs/msg/Odometry");
    let chatter = channel("/chatter", "std_msgs/msg/String");
    let mut send = |channel_id: u16, time: hovernav::time::Time, message: Cdr| {
        let log_time = START_NS + time.nanoseconds() as u64 + 2_000_000;
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence: 0,
            log_time,
            publish_time: log_time,
        };
        writer.write_to_known_channel(&header, &message.bytes).unwrap();
    };
    let stamp = |time: hovernav::time::Time| {
        if stamped { START_NS + time.nanoseconds() as u64 } else { 0 }
    };
    let mut fixes = original.fixes.iter().peekable();
    for (index, sample) in original.imu.iter().enumerate() {
        while let Some(at) = fixes.next_if(|fix| fix.time <= sample.time) {
            let mut message = Cdr::new(little);
            message.header(stamp(at.time), "gps");
            message.put([0u8]);
            message.put(1u16.to_le_bytes());
            let place = at.position;
            message.doubles(&[place.latitude_deg(), place.longitude_deg(), place.height_m]);
            let [n, e, d] = at.position_sigma_m.unwrap().to_array().map(|sigma| sigma * sigma);
            message.doubles(&[e, 0.0, 0.0, 0.0, n, 0.0, 0.0, 0.0, d]);
            message.put([2u8]);
            send(fix, at.time, message);
            let mut message = Cdr::new(little);
            message.header(stamp(at.time), "gps");
            let [north, east] = at.horizontal_velocity_mps.unwrap();
            message.doubles(&[east, north, -at.down_velocity_mps.unwrap(), 0.0, 0.0, 0.0]);
            send(velocity, at.time, message);
        }
        let Motion::Rates { angular_rate_radps, specific_force_mps2 } = sample.motion else {
            panic!("rates")
        };
        let flu = |vector: Vector<_>| {
            let [x, y, z]: [f64; 3] = Vector::<hovernav::frames::Body>::to_array(vector);
            [x, -y, -z]
        };
        // The rotation is from forward-left-up to east-north-up: yaw is anticlockwise from east, pitch has the opposite
        // sign.
        let attitude = sample.attitude.unwrap();
        let (roll, pitch) = (attitude.roll_rad / 2.0, -attitude.pitch_rad / 2.0);
        let yaw = (90f64.to_radians() - attitude.yaw_rad) / 2.0;
        let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
        let quaternion = [
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        ];
        let mut message = Cdr::new(little);
        message.header(stamp(sample.time), "imu_link");
        message.doubles(&quaternion);
        message.doubles(&[0.0; 9]);
        message.doubles(&flu(angular_rate_radps));
        message.doubles(&[0.0; 9]);
        message.doubles(&flu(specific_force_mps2));
        message.doubles(&[0.0; 9]);
        if index % 2 == 0 {
            let bytes = message.bytes.clone();
            send(other, sample.time, Cdr { bytes, little });
        }
        send(imu, sample.time, message);
        if index % 10 == 0 {
            let mut message = Cdr::new(little);
            message.header(stamp(sample.time), "odom");
            message.put(5u32.to_le_bytes());
            message.bytes.extend(b"base\0");
            message.doubles(&[1.0, 2.0, 3.0]);
            message.doubles(&quaternion);
            message.doubles(&[0.0; 36]);
            message.doubles(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            message.doubles(&[0.0; 36]);
            send(odometry, sample.time, message);
            let mut message = Cdr::new(little);
            message.header(stamp(sample.time), "base_link");
            message.doubles(&[50.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            send(estimated, sample.time, message);
            send(chatter, sample.time, Cdr::new(little));
        }
    }
    writer.finish().unwrap();
    drop(writer);
    fs::read(file.path()).unwrap()
}

fn read(bytes: &[u8]) -> Log {
    open_bytes(bytes, Path::new("flight.mcap"), &Options::default()).unwrap()
}

#[test]
fn a_flight_recorded_by_ros_gives_the_samples_of_the_original() {
    let original = Dataset::open(ORIGINAL.as_ref()).unwrap();
    for (little, stamped) in [(true, true), (false, true), (true, false)] {
        let log = read(&recorded(little, stamped));
        assert_eq!(log.format, Format::Ros2);
        let dataset = &log.dataset;
        assert_eq!(dataset.imu.len(), original.imu.len());
        assert_eq!(dataset.fixes.len(), original.fixes.len());
        let shift = dataset.imu[0].time - original.imu[0].time;
        for (a, b) in dataset.imu.iter().zip(&original.imu) {
            assert_abs_diff_eq!(a.time - b.time, shift, epsilon = 2e-9);
            assert_eq!(a.motion, b.motion);
            let (a, b) = (a.attitude.unwrap(), b.attitude.unwrap());
            for (a, b) in a.to_degrees().into_iter().zip(b.to_degrees()) {
                assert_abs_diff_eq!(a, b, epsilon = 1e-9);
            }
        }
        for (a, b) in dataset.fixes.iter().zip(&original.fixes) {
            assert!(a.position.displacement_from(&b.position).norm() < 1e-6);
            assert_eq!(a.velocity_mps(), b.velocity_mps());
            let (a, b) = (a.position_sigma_m.unwrap(), b.position_sigma_m.unwrap());
            assert!((a - b).norm() < 1e-9);
        }
        let onboard = log.onboard.unwrap();
        assert_eq!(onboard.moments.len(), original.imu.len().div_ceil(10));
        let speed = onboard.moments[5].velocity_mps.unwrap().norm();
        assert_abs_diff_eq!(speed, 1.0, epsilon = 1e-9);
        let said = [&dataset.notes[..], &dataset.warnings].concat().join("\n");
        for sentence in [
            "REP 103",
            "/other_imu",
            "/chatter",
            "velocity of the fixes from /vel: its frame denotes a receiver",
            "not used as the receiver's velocity: /an_estimate (990 messages)",
        ] {
            assert!(said.contains(sentence), "{said}");
        }
        assert_eq!(said.contains("log times are used instead"), !stamped, "{said}");
    }
}

#[test]
fn a_truncated_log_gives_its_complete_records() {
    let bytes = recorded(true, true);
    let whole = read(&bytes).dataset.imu.len();
    let mut last = 0;
    for tenths in 1..10 {
        let log = read(&bytes[..bytes.len() * tenths / 10]);
        let found = log.dataset.imu.len();
        assert!(found >= last && found < whole, "{found} of {whole}");
        last = found;
        assert!(
            log.dataset.warnings[0].starts_with("damaged at byte"),
            "{:?}",
            log.dataset.warnings
        );
    }
}

#[test]
fn a_damaged_chunk_costs_only_its_own_records() {
    let bytes = recorded(true, true);
    let whole = read(&bytes).dataset.imu.len();
    // A record is an opcode, its length and that many bytes; those of kind 6 are chunks.
    let mut chunks = Vec::new();
    let mut at = 8;
    while let Some(length) = bytes.get(at + 1..at + 9) {
        let length = u64::from_le_bytes(length.try_into().unwrap()) as usize;
        chunks.extend((bytes[at] == 6).then_some((at, length)));
        at += 9 + length;
    }
    // The first chunk describes the channels; the end of the file repeats this.
    for &(at, length) in [&chunks[0], &chunks[chunks.len() / 2]] {
        let mut damaged = bytes.clone();
        damaged[at + length / 2] ^= 1;
        let dataset = read(&damaged).dataset;
        let least = whole - 2 * whole / chunks.len();
        assert!((least..whole).contains(&dataset.imu.len()), "{} of {whole}", dataset.imu.len());
        let said = format!("damaged at byte {at}: found a chunk with a wrong checksum; ignored");
        assert_eq!(dataset.warnings[0], said);
    }
    // In an uncompressed chunk, the records are found without the chunk's frame.
    let (at, _) = chunks[chunks.len() / 2];
    let mut damaged = bytes;
    damaged[at..at + 9].fill(0);
    let dataset = read(&damaged).dataset;
    assert_eq!(dataset.imu.len(), whole);
    let said = &dataset.warnings[0];
    assert!(
        said.starts_with(&format!("damaged at byte {at}: found an impossible record of kind 0")),
        "{said}"
    );
}

#[test]
fn a_chunk_with_more_messages_than_file_bytes_is_truncated() {
    let record =
        |kind: u8, body: &[u8]| [&[kind][..], &(body.len() as u64).to_le_bytes(), body].concat();
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let schema =
        [&[1, 0][..], &text("sensor_msgs/msg/FluidPressure"), &text(""), &text("")].concat();
    let channel = [&[0, 0, 1, 0][..], &text("/baro"), &text("cdr"), &text("")].concat();
    let mut message = vec![0; 22];
    let mut pressure = Cdr::new(true);
    pressure.header(START_NS, "baro");
    pressure.doubles(&[101_325.0, 0.0]);
    message.extend(pressure.bytes);
    let mut records = [record(3, &schema), record(4, &channel)].concat();
    records.extend(record(5, &message).repeat(300_000));
    let mut packed = lz4_flex::frame::FrameEncoder::new(Vec::new());
    packed.write_all(&records).unwrap();
    let packed = packed.finish().unwrap();
    let mut chunk = vec![0; 16];
    chunk.extend((records.len() as u64).to_le_bytes());
    chunk.extend([0; 4]);
    chunk.extend(text("lz4"));
    chunk.extend((packed.len() as u64).to_le_bytes());
    chunk.extend(packed);
    let header = record(1, &[text("ros2"), text("x")].concat());
    let file = [&b"\x89MCAP0\r\n"[..], &header, &record(6, &chunk)].concat();
    assert!(file.len() < 200_000, "{}", file.len());
    let refused = open_bytes(&file, Path::new("bomb.mcap"), &Options::default()).unwrap_err();
    let told = format!(
        "{} messages skipped: the file contains more messages than bytes",
        300_000 - file.len()
    );
    assert!(refused.to_string().contains(&told), "{refused}");
}

#[test]
fn an_oversized_chunk_is_skipped_unread() {
    let mut bytes = recorded(true, true);
    // The uncompressed size of the first chunk comes after the chunk's kind, its length and two times.
    let mut at = 8;
    while bytes[at] != 6 {
        at += 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
    }
    let promise: u64 = (1 << 26) + 1;
    bytes[at + 25..at + 33].copy_from_slice(&promise.to_le_bytes());
    let said = format!(
        "damaged at byte {at}: found a chunk of {promise} bytes uncompressed, expected at most {}; \
         ignored",
        1 << 26
    );
    assert_eq!(read(&bytes).dataset.warnings[0], said);
}

#[test]
fn individually_compressed_messages_are_decompressed() {
    let bytes = recorded(true, true);
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut writer =
        mcap::WriteOptions::new().compression(None).create(file.reopen().unwrap()).unwrap();
    let mut channels = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let channel_id = *channels.entry(message.channel.id).or_insert_with(|| {
            let schema = message.channel.schema.as_ref().unwrap();
            let schema = writer.add_schema(&schema.name, &schema.encoding, b"").unwrap();
            writer.add_channel(schema, &message.channel.topic, "cdr", &BTreeMap::new()).unwrap()
        });
        let (log_time, publish_time) = (message.log_time, message.publish_time);
        let header =
            mcap::records::MessageHeader { channel_id, sequence: 0, log_time, publish_time };
        let level = ruzstd::encoding::CompressionLevel::Fastest;
        let packed = ruzstd::encoding::compress_to_vec(&message.data[..], level);
        writer.write_to_known_channel(&header, &packed).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    let (packed, plain) = (read(&fs::read(file.path()).unwrap()), read(&bytes));
    assert_eq!(packed.dataset.imu, plain.dataset.imu);
    assert_eq!(packed.dataset.fixes, plain.dataset.fixes);
    assert_eq!(packed.dataset.warnings, plain.dataset.warnings);
}

#[test]
fn a_bag_is_opened_by_its_directory() {
    let place = tempfile::tempdir().unwrap();
    fs::write(place.path().join("metadata.yaml"), "rosbag2_bagfile_information:\n").unwrap();
    let refusal = || open(place.path(), &Options::default()).unwrap_err().to_string();
    assert!(refusal().contains("a ROS 2 bag without an .mcap file"), "{}", refusal());
    fs::write(place.path().join("flight_0.db3"), "SQLite format 3").unwrap();
    assert!(refusal().contains("rosbags-convert"), "{}", refusal());
    fs::write(place.path().join("flight_0.mcap"), recorded(true, true)).unwrap();
    let log = open(place.path(), &Options::default()).unwrap();
    assert_eq!((log.format, &*log.dataset.manifest.name), (Format::Ros2, "flight_0"));
    // The files of a split bag are one recording, also where one is damaged or compressed.
    fs::write(place.path().join("flight_1.mcap"), "").unwrap();
    let parts = open(place.path(), &Options::default()).unwrap().dataset;
    assert_eq!(parts.imu, log.dataset.imu);
    assert!(parts.warnings.iter().any(|warning| warning.contains("without the footer")));
    let level = ruzstd::encoding::CompressionLevel::Fastest;
    let packed = ruzstd::encoding::compress_to_vec(&recorded(true, true)[..], level);
    fs::remove_file(place.path().join("flight_0.mcap")).unwrap();
    fs::write(place.path().join("flight_0.mcap.zstd"), packed).unwrap();
    assert_eq!(open(place.path(), &Options::default()).unwrap().dataset.imu, log.dataset.imu);
}

#[test]
fn an_instance_is_chosen_by_number() {
    let bytes = recorded(true, true);
    let mut options = Options::default();
    options.imu = Some(1);
    let log = open_bytes(&bytes, Path::new("flight.mcap"), &options).unwrap();
    assert_eq!(log.dataset.imu.len(), read(&bytes).dataset.imu.len().div_ceil(2));
    options.imu = Some(7);
    let refusal = open_bytes(&bytes, Path::new("flight.mcap"), &options).unwrap_err().to_string();
    assert!(refusal.contains("no instance 7") && refusal.contains("/other_imu"), "{refusal}");
}

#[test]
fn the_velocity_is_from_the_requested_topic_or_absent() {
    let bytes = recorded(true, true);
    let open = |velocity: &str| {
        let mut options = Options::default();
        options.velocity = Some(velocity.to_owned());
        open_bytes(&bytes, Path::new("flight.mcap"), &options)
    };
    let east_mps = |velocity: &str| {
        let fixes = open(velocity).unwrap().dataset.fixes;
        fixes.iter().find_map(|fix| fix.horizontal_velocity_mps).map(|[_, east]| east)
    };
    assert_eq!(east_mps("/an_estimate"), Some(50.0));
    assert_eq!(east_mps("none"), None);
    let refusal = open("/nowhere").unwrap_err().to_string();
    assert!(refusal.contains("no velocity topic /nowhere; the log has /an_estimate"), "{refusal}");
}
