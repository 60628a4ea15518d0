//! Serial lines on pseudo-terminals, opened by the same calls as real ones. After any fault of the line, complete
//! packets are read, damaged ones are counted, and the port returns.

use std::io::{Read as _, Write as _};
use std::path::PathBuf;
use std::time::Duration;

use hovernav::dmu::{AnglePacket, Decoder, Mode, Packet};
use hovernav_fly::serial::{Clock, Item, Port, PortConfig, PortEvent, PortFault, Read, Reader};
use hovernav_fly::serial::{Dropped, WriteError};
use serialport::{SerialPort as _, TTYPort};
use tempfile::TempDir;

/// A pseudo-terminal with a path that stays the same when it is replaced.
struct Wire {
    device: Option<TTYPort>,
    link: PathBuf,
    _directory: TempDir,
}

impl Wire {
    fn new() -> Self {
        let directory = tempfile::tempdir().unwrap();
        let link = directory.path().join("port");
        let mut wire = Self { device: None, link, _directory: directory };
        wire.plug();
        wire
    }

    fn plug(&mut self) {
        let (mut device, host) = TTYPort::pair().unwrap();
        device.set_timeout(Duration::from_secs(5)).unwrap();
        std::os::unix::fs::symlink(host.name().unwrap(), &self.link).unwrap();
        self.device = Some(device);
    }

    fn pull(&mut self) {
        std::fs::remove_file(&self.link).unwrap();
        self.device = None;
    }

    fn device(&mut self) -> &mut TTYPort {
        self.device.as_mut().unwrap()
    }

    fn port(&self, clock: &Clock) -> Port {
        Port::new(self.config(), clock)
    }

    fn config(&self) -> PortConfig {
        let path = self.link.to_str().unwrap().to_string();
        PortConfig::new(path, 38_400)
    }

    /// An open port.
    fn open(&self, clock: &Clock) -> Port {
        let mut port = self.port(clock);
        assert_eq!(next_event(&mut port, clock), PortEvent::Opened);
        port
    }
}

/// The next change of the port within 10 s.
fn next_event(port: &mut Port, clock: &Clock) -> PortEvent {
    let deadline = clock.now() + 10.0;
    loop {
        match port.read_until(&mut [0; 256], deadline) {
            Read::Changed(event) => return event,
            Read::Bytes { .. } => {}
            Read::Silent => panic!("no change in 10 s"),
        }
    }
}

/// Sends `bytes` and reads until the same number of bytes has arrived.
fn through(wire: &mut Wire, port: &mut Port, clock: &Clock, bytes: &[u8]) -> Vec<u8> {
    wire.device().write_all(bytes).unwrap();
    read(port, clock, bytes.len())
}

fn read(port: &mut Port, clock: &Clock, count: usize) -> Vec<u8> {
    let (mut found, mut buffer) = (Vec::new(), [0; 256]);
    let deadline = clock.now() + 10.0;
    while found.len() < count {
        match port.read_until(&mut buffer, deadline) {
            Read::Bytes { count, .. } => found.extend(&buffer[..count]),
            other => panic!("{other:?} after {} of {count} bytes", found.len()),
        }
    }
    found
}

/// Packets of small negative words, so that the header byte is frequent, and of words equal to replies to commands.
fn packet(index: u16) -> AnglePacket {
    let word = |k: u16| (index.wrapping_mul(31).wrapping_add(k) % 200) as i16 - 100;
    AnglePacket {
        attitude: [word(1), word(2), word(3)],
        angular_rate: [word(4), word(5), 0x4148],
        acceleration: [word(6), 0x4352, 5461],
        magnetic_field: [word(7), word(8), 7864],
        temperature: 1587,
        timer: 0u16.wrapping_sub(index.wrapping_mul(38_358)),
    }
}

fn stream(indices: std::ops::Range<u16>) -> Vec<u8> {
    indices.flat_map(|index| packet(index).encode()).collect()
}

fn decode(mut bytes: &[u8]) -> Vec<AnglePacket> {
    let mut decoder = Decoder::new(Mode::Angle);
    std::iter::from_fn(|| decoder.next_packet(&mut bytes))
        .map(|found| match found.packet {
            Packet::Angle(packet) => packet,
            other => panic!("{other:?}"),
        })
        .collect()
}

/// Sends each of `streams` through one port and checks the packets of each: all were sent, and at most `lost` of them
/// are missing.
fn all_but(lost: usize, streams: impl Iterator<Item = (Vec<u8>, u16)>) {
    let (clock, mut wire) = (&Clock::start(), Wire::new());
    let mut port = wire.open(clock);
    for (case, (bytes, sent)) in streams.enumerate() {
        let found = decode(&through(&mut wire, &mut port, clock, &bytes));
        assert!(found.iter().all(|found| (0..sent).any(|k| packet(k) == *found)), "case {case}");
        let missing = usize::from(sent) - found.len();
        assert!(missing <= lost, "case {case}: {missing} of {sent} lost");
    }
    assert_eq!(port.counts().lost, 0);
}

#[test]
fn every_byte_value_comes_through_unchanged() {
    let (clock, mut wire) = (&Clock::start(), Wire::new());
    let mut port = wire.open(clock);
    let bytes: Vec<u8> = (0..=255).collect();
    assert_eq!(through(&mut wire, &mut port, clock, &bytes), bytes);
    port.write(&bytes, clock.now() + 5.0).unwrap();
    let mut heard = vec![0; bytes.len()];
    wire.device().read_exact(&mut heard).unwrap();
    assert_eq!(heard, bytes);
}

#[test]
fn a_stream_that_starts_in_mid_packet_loses_that_packet_alone() {
    all_but(1, (0..30).map(|start| (stream(0..6)[start..].to_vec(), 6)));
}

#[test]
fn a_dropped_byte_costs_its_packet_and_at_most_the_one_after() {
    let streams = (0..90).map(|at| {
        let mut bytes = stream(0..8);
        bytes.remove(60 + at);
        (bytes, 8)
    });
    all_but(2, streams);
}

#[test]
fn an_inserted_byte_costs_its_packet_and_at_most_the_one_after() {
    // The inserted byte is not 0xFF. Inserted into a packet whose first word is negative and small, 0xFF makes another
    // packet with a valid checksum, one byte later.
    let streams = (0..90).flat_map(|at| {
        [0x00, 0xFE, b'A'].map(|byte| {
            let mut bytes = stream(0..8);
            bytes.insert(60 + at, byte);
            (bytes, 8)
        })
    });
    all_but(2, streams);
}

#[test]
fn a_flipped_bit_costs_its_packet_and_at_most_the_one_after() {
    let streams = (0..90).flat_map(|at| {
        (0..8).map(move |bit| {
            let mut bytes = stream(0..8);
            bytes[60 + at] ^= 1 << bit;
            (bytes, 8)
        })
    });
    all_but(2, streams);
}

#[test]
fn a_packet_cut_at_any_length_costs_itself_and_at_most_the_one_after() {
    let streams = (1..30).map(|length| {
        let whole = stream(0..8);
        ([&whole[..90 + length], &whole[120..]].concat(), 8)
    });
    all_but(2, streams);
}

#[test]
fn noise_bursts_cost_no_packet_but_those_they_fall_into() {
    let noise: Vec<u8> = (0..200u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    let streams = (0..12).map(|burst| {
        let whole = stream(0..12);
        let burst = &noise[burst * 16..][..8 + burst];
        ([&whole[..150], burst, &whole[150..]].concat(), 12)
    });
    all_but(2, streams);
}

#[test]
fn replies_to_commands_inside_packets_are_data() {
    let bytes = stream(0..20);
    assert!(b"AHCR".iter().all(|reply| bytes.contains(reply)));
    all_but(0, std::iter::once((bytes, 20)));
}

#[test]
fn many_packets_come_in_one_read_and_one_packet_in_many() {
    let (clock, mut wire) = (&Clock::start(), Wire::new());
    let mut port = wire.open(clock);
    let bytes = stream(0..100);
    assert_eq!(decode(&through(&mut wire, &mut port, clock, &bytes)).len(), 100);
    let mut found = Vec::new();
    for byte in stream(0..3) {
        found.extend(through(&mut wire, &mut port, clock, &[byte]));
    }
    assert_eq!(decode(&found), (0..3).map(packet).collect::<Vec<_>>());
}

#[test]
fn an_idle_line_returns_at_the_deadline_and_what_has_come_is_read_after_it() {
    let (clock, mut wire) = (&Clock::start(), Wire::new());
    let mut port = wire.open(clock);
    let deadline = clock.now() + 0.03;
    assert_eq!(port.read_until(&mut [0; 64], deadline), Read::Silent);
    assert!(clock.now() >= deadline);
    wire.device().write_all(b"late").unwrap();
    let mut buffer = [0; 64];
    let past = clock.now() + -1.0;
    let read = std::iter::repeat_with(|| port.read_until(&mut buffer, past))
        .find(|read| *read != Read::Silent);
    assert!(matches!(read, Some(Read::Bytes { .. })), "{read:?}");
}

#[test]
fn a_port_that_is_pulled_out_is_reported_and_taken_up_when_it_comes_back() {
    let (clock, mut wire) = (&Clock::start(), Wire::new());
    let mut port = wire.open(clock);
    for round in 1..=3 {
        wire.pull();
        assert!(matches!(next_event(&mut port, clock), PortEvent::Lost(_)));
        assert!(!port.is_open());
        assert_eq!(port.write(b"G", clock.now() + 1.0), Err(WriteError::Closed));
        assert_eq!(next_event(&mut port, clock), PortEvent::CannotOpen(PortFault::Missing));
        wire.plug();
        assert_eq!(next_event(&mut port, clock), PortEvent::Opened);
        assert_eq!(through(&mut wire, &mut port, clock, b"again"), b"again");
        assert_eq!((port.counts().opened, port.counts().lost), (round + 1, round));
    }
}

#[test]
fn the_first_write_opens_the_port() {
    let (clock, mut wire) = (&Clock::start(), Wire::new());
    let mut port = wire.port(clock);
    port.write(b"P", clock.now() + 5.0).unwrap();
    let mut heard = [0];
    wire.device().read_exact(&mut heard).unwrap();
    assert_eq!(&heard, b"P");
    assert_eq!(next_event(&mut port, clock), PortEvent::Opened);
}

#[test]
fn a_missing_port_is_tried_less_and_less_often() {
    let clock = &Clock::at_speed(20.0).unwrap();
    let mut wire = Wire::new();
    wire.pull();
    let mut port = wire.port(clock);
    assert_eq!(next_event(&mut port, clock), PortEvent::CannotOpen(PortFault::Missing));
    let end = clock.now() + 12.0;
    while clock.now() < end {
        assert_eq!(port.read_until(&mut [0; 16], end), Read::Silent);
    }
    // Attempts are after 0, 0.05, 0.15, 0.35, 0.75, 1.25, 1.75 … s; a slow machine makes fewer attempts.
    let tried = port.counts().failed_to_open;
    assert!((3..=28).contains(&tried), "{tried}");
    wire.plug();
    assert_eq!(next_event(&mut port, clock), PortEvent::Opened);
}

#[test]
fn a_port_is_ours_alone() {
    let (clock, wire) = (&Clock::start(), Wire::new());
    let _port = wire.open(clock);
    let mut other = wire.port(clock);
    assert_eq!(next_event(&mut other, clock), PortEvent::CannotOpen(PortFault::Busy));
}

#[test]
fn what_is_no_terminal_is_refused() {
    let (clock, mut wire) = (&Clock::start(), Wire::new());
    wire.pull();
    std::fs::write(&wire.link, "a file").unwrap();
    let event = next_event(&mut wire.port(clock), clock);
    assert!(matches!(event, PortEvent::CannotOpen(PortFault::Other(_))), "{event:?}");
}

#[test]
fn a_line_that_takes_no_more_does_not_hold_the_writer() {
    let (clock, wire) = (&Clock::start(), Wire::new());
    let mut port = wire.open(clock);
    let more_than_any_buffer = vec![0x55; 1 << 20];
    let stuck = port.write(&more_than_any_buffer, clock.now() + 0.1);
    assert!(matches!(stuck, Err(WriteError::Stuck { written }) if written < 1 << 20), "{stuck:?}");
    assert!(port.is_open());
}

/// The next item within 10 s.
fn next_item(reader: &Reader, clock: &Clock) -> Item {
    reader.receive(clock.now() + 10.0).expect("nothing in 10 s")
}

fn reader(wire: &Wire, clock: &Clock, capacity: usize) -> Reader {
    let reader = Reader::spawn(wire.port(clock), clock, capacity).unwrap();
    assert_eq!(next_item(&reader, clock), Item::Changed(PortEvent::Opened));
    reader
}

#[test]
fn a_reader_reports_once_that_the_line_fell_silent() {
    let (clock, mut wire) = (&Clock::start(), Wire::new());
    let reader = reader(&wire, clock, 64);
    for burst in [&b"one"[..], b"two"] {
        wire.device().write_all(burst).unwrap();
        let (mut found, mut last) = (Vec::new(), clock.now());
        loop {
            let Item::Bytes { arrival, bytes } = next_item(&reader, clock) else { panic!() };
            if bytes.is_empty() {
                assert!(arrival - last >= 0.05);
                break;
            }
            (last, found) = (arrival, [&found, &*bytes].concat());
        }
        assert_eq!(found, burst);
        assert_eq!(reader.receive(clock.now() + 0.2), None);
    }
}

#[test]
fn when_the_writer_is_faster_than_the_reader_the_newest_is_kept_and_the_rest_counted() {
    let (clock, mut wire) = (&Clock::start(), Wire::new());
    let reader = reader(&wire, clock, 4);
    let sent: Vec<u8> = (0..40_000u32).map(|k| (k / 100) as u8).collect();
    for chunk in sent.chunks(500) {
        wire.device().write_all(chunk).unwrap();
    }
    // The reader reports silence as an item without bytes. This item is the newest one and follows all others.
    let deadline = clock.now() + 10.0;
    while reader.counts().bytes_read < sent.len() as u64 && clock.now() < deadline {
        clock.sleep_until(clock.now() + 0.01);
    }
    clock.sleep_until(clock.now() + 0.3);
    let mut kept = Vec::new();
    while let Some(Item::Bytes { bytes, .. }) = reader.receive(clock.now()) {
        kept.extend_from_slice(&bytes);
    }
    let Dropped { items, bytes } = reader.dropped();
    assert!(items > 0 && !kept.is_empty());
    assert_eq!(bytes + kept.len() as u64, sent.len() as u64);
    assert_eq!(kept, sent[sent.len() - kept.len()..]);
}

#[test]
fn what_the_port_went_through_is_not_dropped_for_bytes() {
    let (clock, mut wire) = (&Clock::start(), Wire::new());
    let reader = Reader::spawn(wire.port(clock), clock, 3).unwrap();
    while reader.counts().bytes_read < 1_000 {
        // The bytes are lost before the port is open.
        let _ = wire.device().write(&[1; 100]);
        clock.sleep_until(clock.now() + 0.01);
    }
    assert_eq!(next_item(&reader, clock), Item::Changed(PortEvent::Opened));
}

#[test]
fn a_reader_writes_what_it_is_handed_and_reports_what_it_could_not() {
    let (clock, mut wire) = (&Clock::start(), Wire::new());
    let reader = reader(&wire, clock, 64);
    assert!(reader.write(b"configure"));
    let mut heard = [0; 9];
    wire.device().read_exact(&mut heard).unwrap();
    assert_eq!(&heard, b"configure");
    wire.pull();
    assert!(matches!(next_item(&reader, clock), Item::Changed(PortEvent::Lost(_))));
    assert!(reader.write(b"configure"));
    let told = std::iter::repeat_with(|| next_item(&reader, clock))
        .find(|item| !matches!(item, Item::Changed(_)));
    assert_eq!(told, Some(Item::NotWritten(WriteError::Closed)));
}

#[test]
fn time_runs_as_fast_as_asked() {
    assert!([0.0, -1.0, f64::NAN, f64::INFINITY].map(Clock::at_speed).iter().all(Option::is_none));
    let clock = Clock::at_speed(50.0).unwrap();
    let (before, wall) = (clock.now(), std::time::Instant::now());
    clock.sleep_until(before + 1.0);
    assert!(clock.now() - before >= 1.0);
    // At least a fiftieth of a second has passed.
    assert!(wall.elapsed() >= Duration::from_millis(19));
}
