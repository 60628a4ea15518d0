//! Makes a long log from a short one, to measure the cost of reading and estimating. The same flight is repeated
//! with later times: the bytes of a PX4 ULog, or the dataset of any other log.
//!
//! `cargo run --release -p hovernav-formats --example repeat -- LOG TIMES OUT`

use std::collections::HashMap;
use std::error::Error;
use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::Path;

use hovernav_dataset::{Dataset, median_interval_s};
use hovernav_formats::Options;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [log, times, out] = &arguments[..] else {
        return Err("expected LOG TIMES OUT".into());
    };
    let times: u32 = times.parse()?;
    let (log, out) = (Path::new(log), Path::new(out));
    if log.is_file() {
        let bytes = fs::read(log)?;
        if bytes.starts_with(b"ULog") {
            return repeat_ulog(&bytes, times, out);
        }
    }
    repeated(hovernav_formats::open(log, &Options::default())?.dataset, times).write(out, &[])?;
    Ok(())
}

/// The dataset repeated `times` times, one sample interval apart.
fn repeated(mut dataset: Dataset, times: u32) -> Dataset {
    let clock: Vec<_> = dataset.imu.iter().map(|sample| sample.time).collect();
    let (Some(first), Some(last)) = (clock.first(), clock.last()) else { return dataset };
    let period_s = *last - *first + median_interval_s(&clock).unwrap_or_default();
    let once = dataset.clone();
    for turn in 1..times {
        let later_s = f64::from(turn) * period_s;
        for sample in &once.imu {
            let mut sample = *sample;
            sample.time = sample.time.offset_by(later_s);
            dataset.imu.push(sample);
        }
        for fix in &once.fixes {
            let mut fix = *fix;
            fix.time = fix.time.offset_by(later_s);
            dataset.fixes.push(fix);
        }
        dataset.baro.extend(once.baro.iter().map(|row| (row.0.offset_by(later_s), row.1)));
        let fields = once.magnetometer.iter().map(|row| (row.0.offset_by(later_s), row.1));
        dataset.magnetometer.extend(fields);
        let sticks = once.controls.iter().map(|row| (row.0.offset_by(later_s), row.1));
        dataset.controls.extend(sticks);
    }
    dataset
}

/// A message: its type and its body.
type Message<'a> = (u8, &'a [u8]);

/// The messages after the header of 16 bytes.
fn messages(bytes: &[u8]) -> Vec<Message<'_>> {
    let mut rest = bytes.get(16..).unwrap_or_default();
    let mut messages = Vec::new();
    while let Some((&[low, high, kind], behind)) = rest.split_first_chunk() {
        let length = usize::from(u16::from_le_bytes([low, high]));
        let Some((body, next)) = behind.split_at_checked(length) else { break };
        messages.push((kind, body));
        rest = next;
    }
    messages
}

/// Writes the file with its data repeated `times` times, after one copy of the definitions.
fn repeat_ulog(bytes: &[u8], times: u32, out: &Path) -> Result<(), Box<dyn Error>> {
    let messages = messages(bytes);
    let clocks = clocks(&messages);
    let at = |body: &[u8]| body.get(2..10)?.first_chunk().map(|clock| u64::from_le_bytes(*clock));
    let data = || messages.iter().filter(|message| message.0 == b'D');
    let stamps = || data().filter_map(|message| at(message.1));
    let (first, last) = (stamps().min().unwrap_or(0), stamps().max().unwrap_or(0));
    let mut file = BufWriter::new(File::create(out)?);
    file.write_all(&bytes[..16])?;
    let mut write = |kind: u8, body: &[u8]| -> std::io::Result<()> {
        file.write_all(&(body.len() as u16).to_le_bytes())?;
        file.write_all(&[kind])?;
        file.write_all(body)
    };
    // The flag message is omitted: its offsets of appended data would be wrong.
    for (kind, body) in messages.iter().filter(|message| !matches!(message.0, b'D' | b'B')) {
        write(*kind, body)?;
    }
    for turn in 0..times {
        let later_us = u64::from(turn) * (last - first + 10_000);
        for (kind, body) in data() {
            let mut body = body.to_vec();
            let number = body.first_chunk().map_or(0, |bytes| u16::from_le_bytes(*bytes));
            for &place in clocks.get(&number).into_iter().flatten() {
                if let Some(clock) = body.get_mut(2 + place..).and_then(<[u8]>::first_chunk_mut) {
                    let time = u64::from_le_bytes(*clock);
                    *clock = if time == 0 { 0 } else { time + later_us }.to_le_bytes();
                }
            }
            write(*kind, &body)?;
        }
    }
    file.flush()?;
    Ok(())
}

/// Byte offsets of the times in the data of each subscription.
fn clocks(messages: &[Message<'_>]) -> HashMap<u16, Vec<usize>> {
    let text = |body| std::str::from_utf8(body).unwrap_or_default();
    let definitions = messages.iter().filter(|message| message.0 == b'F');
    let fields: HashMap<&str, &str> =
        definitions.filter_map(|message| text(message.1).split_once(':')).collect();
    let subscriptions = messages.iter().filter(|message| message.0 == b'A');
    let places = subscriptions.filter_map(|(_, body)| {
        let (&[_, low, high], name) = body.split_first_chunk()?;
        let (mut place, mut found) = (0, Vec::new());
        for field in fields.get(text(name))?.split(';') {
            let Some((kind, name)) = field.split_once(' ') else { continue };
            if kind == "uint64_t" && matches!(name, "timestamp" | "timestamp_sample") {
                found.push(place);
            }
            // The time fields precede nested messages, whose size is unknown here.
            let Some(size) = size(kind) else { break };
            place += size;
        }
        Some((u16::from_le_bytes([low, high]), found))
    });
    places.collect()
}

/// Size of a type or an array of it, bytes; `None` for nested messages.
fn size(kind: &str) -> Option<usize> {
    let (kind, count) = match kind.split_once('[') {
        Some((kind, count)) => (kind, count.trim_end_matches(']').parse().ok()?),
        None => (kind, 1),
    };
    let size = match kind {
        "int8_t" | "uint8_t" | "bool" | "char" => 1,
        "int16_t" | "uint16_t" => 2,
        "int32_t" | "uint32_t" | "float" => 4,
        "int64_t" | "uint64_t" | "double" => 8,
        _ => return None,
    };
    Some(count * size)
}
