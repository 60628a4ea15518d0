//! Exports of the whole store. The test has its own process, because other tests would change its memory.

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::time::Duration;

use crate::common::{Served, cycle, passes_alone, resident, serve};
use hovernav_ground::link::lock;

/// Requests all channels of the last twenty minutes, with this version of HTTP.
fn ask(served: &Served, version: &str) -> TcpStream {
    let (from, to) = (served.start_s - 1e4, served.start_s + 1e4);
    let host = served.address;
    let mut stream = TcpStream::connect(host).unwrap();
    let path = format!("/export.csv?from={from}&to={to}");
    let request = format!("GET {path} HTTP/{version}\r\nHost: {host}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    stream
}

/// An accepted export, as soon as a slot is free.
fn answered(served: &Served) -> Option<TcpStream> {
    (0..200).find_map(|_| {
        let mut stream = ask(served, "1.1");
        let found = status(&mut stream) == "HTTP/1.1 200";
        if !found {
            std::thread::sleep(Duration::from_millis(100));
        }
        found.then_some(stream)
    })
}

fn status(stream: &mut TcpStream) -> String {
    let mut head = [0; 12];
    stream.read_exact(&mut head).unwrap();
    String::from_utf8_lossy(&head).into_owned()
}

/// Flies a range of cycles, counted from the start of the server.
fn fly(served: &Served, cycles: std::ops::Range<u32>) {
    for number in cycles {
        let arrival_s = served.start_s + f64::from(number) / 33.0;
        lock(&served.station).receive(&cycle(number), arrival_s);
    }
}

#[test]
fn all_that_is_kept_is_exported_in_little_memory_and_nobody_who_stops_reading_is_in_the_way() {
    passes_alone("export::all_that_is_kept");
}

#[test]
#[ignore = "the test above runs it in its own process"]
fn all_that_is_kept() {
    let served = serve(None);
    fly(&served, 0..40_000);
    let before = resident();
    // Without the chunks of HTTP 1.1, each line is a line of the table.
    let mut stream = ask(&served, "1.0");
    assert_eq!(status(&mut stream), "HTTP/1.0 200");
    let (mut lines, mut bytes, mut most) = (0, 0, before);
    let mut buffer = vec![0; 256 * 1024];
    while let Ok(count @ 1..) = stream.read(&mut buffer) {
        bytes += count;
        lines += buffer[..count].iter().filter(|byte| **byte == b'\n').count();
        most = most.max(resident());
    }
    let more = most - before;
    println!("{:.1} MB exported with {:.1} MB more", bytes as f64 / 1e6, more as f64 / 1e6);
    assert!(lines > 40_000 && bytes > 15_000_000, "{lines} lines, {bytes} bytes");
    assert!(more < 8_000_000, "{more} bytes more in memory");

    // A client that does not read keeps its slot until the timeout.
    let mut idle: Vec<_> = (0..4).filter_map(|_| answered(&served)).collect();
    assert_eq!(idle.len(), 4);
    assert_eq!(status(&mut ask(&served, "1.1")), "HTTP/1.1 503");
    assert!(answered(&served).is_some(), "slots are freed");
    // A truncated table does not end like a complete one. One of the four has timed out; the others follow soon.
    std::thread::sleep(Duration::from_secs(3));
    let mut rest = Vec::new();
    let _ = idle[0].read_to_end(&mut rest);
    assert!(!rest.ends_with(b"\r\n0\r\n\r\n"), "{} bytes and a quiet end", rest.len());

    // Nor does a table whose values are dropped during a slow download.
    drop(idle);
    let mut slow = answered(&served).unwrap();
    let (mut rest, mut taken) = (Vec::new(), vec![0; 64 * 1024]);
    let mut flown = 40_000;
    while let Ok(count @ 1..) = slow.read(&mut taken) {
        rest.extend_from_slice(&taken[..count]);
        fly(&served, flown..flown + 1000);
        flown += 1000;
    }
    let text = String::from_utf8_lossy(&rest);
    assert!(rest.len() < bytes && text.contains("\n# broken off after "), "{flown} cycles");
    assert!(!rest.ends_with(b"\r\n0\r\n\r\n"), "{} bytes and a quiet end", rest.len());
}
