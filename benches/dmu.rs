//! Throughput of the decoder: the goal is 200 MB/s on one core, without allocation.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use hovernav::dmu::{AnglePacket, Calibration, Decoder, Mode, Plausibility, SampleClock};
use hovernav::time::Time;

/// About a quarter of an hour of packets in which all words change.
fn flight() -> Vec<u8> {
    (0..32_768u32)
        .flat_map(|index| {
            let word = |factor: u32| (index.wrapping_mul(factor) >> 4) as u16 as i16 >> 5;
            AnglePacket {
                attitude: [word(7919), word(6037), word(104_729)],
                angular_rate: [word(7907), word(7901), word(7883)],
                acceleration: [word(7879), word(7877), word(7873)],
                magnetic_field: [word(7867), word(7853), word(7841)],
                temperature: 1587,
                timer: 0u16.wrapping_sub((index.wrapping_mul(38_358) & 0xFFFF) as u16),
            }
            .encode()
        })
        .collect()
}

fn decode(mut bytes: &[u8]) -> u64 {
    let mut decoder = Decoder::new(Mode::Angle);
    while let Some(received) = decoder.next_packet(&mut bytes) {
        black_box(&received);
    }
    decoder.counts().packets
}

/// Complete processing from bytes to samples: decoding, plausibility, sample time, units.
fn decode_to_samples(mut bytes: &[u8]) -> u64 {
    let mut decoder = Decoder::new(Mode::Angle);
    let mut plausibility = Plausibility::default();
    let mut clock = SampleClock::new(Mode::Angle.transfer_time_s());
    let calibration = Calibration::new(200.0, 4.0).expect("a unit's ranges");
    let mut arrival = Time::ZERO;
    while let Some(received) = decoder.next_packet(&mut bytes) {
        let packet = received.packet;
        arrival = arrival + 38_358.0 * 0.79e-6;
        black_box(plausibility.check(&packet).any(|reason| reason.invalidates_packet()));
        let stamp = clock.stamp(packet.timer(), received.sequence, arrival);
        black_box(stamp.ok().zip(calibration.measure(&packet)));
    }
    decoder.counts().packets
}

fn throughput(criterion: &mut Criterion) {
    let flight = flight();
    let mut random = 1u64;
    let noise: Vec<u8> = (0..flight.len())
        .map(|_| {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (random >> 56) as u8
        })
        .collect();
    let headers = vec![0xFF; flight.len()];
    let mut group = criterion.benchmark_group("dmu");
    group.throughput(Throughput::Bytes(flight.len() as u64));
    group.bench_function("decode flight", |bencher| {
        bencher.iter(|| decode(black_box(&flight)));
    });
    group.bench_function("decode flight in pieces of 7 bytes", |bencher| {
        bencher.iter(|| {
            let mut decoder = Decoder::new(Mode::Angle);
            for mut piece in black_box(&flight).chunks(7) {
                while let Some(received) = decoder.next_packet(&mut piece) {
                    black_box(&received);
                }
            }
            decoder.counts().packets
        });
    });
    group.bench_function("decode noise", |bencher| bencher.iter(|| decode(black_box(&noise))));
    group.bench_function("decode headers only", |bencher| {
        bencher.iter(|| decode(black_box(&headers)));
    });
    group.bench_function("decode flight to samples", |bencher| {
        bencher.iter(|| decode_to_samples(black_box(&flight)));
    });
    group.finish();
}

criterion_group!(benches, throughput);
criterion_main!(benches);
