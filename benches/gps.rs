//! Speed of decoding receivers' streams, from framing to fix.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use hovernav::gps::{Protocol, Receiver};
use hovernav::time::Time;
use hovernav_fly::devices::encode;
use hovernav_fly::devices::encode::Epoch;

fn decode(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("gps");
    for (name, protocol, epoch) in [
        ("tsip", Protocol::Tsip, encode::tsip_epoch as fn(&Epoch) -> Vec<u8>),
        ("tsip_superpacket", Protocol::Tsip, encode::tsip_superpacket),
        ("ubx_nav_pvt", Protocol::Ubx, encode::ubx_pvt),
        ("nmea", Protocol::Nmea, encode::nmea_epoch),
    ] {
        let stream: Vec<u8> = (0..1_000).flat_map(|second| epoch(&Epoch::flying(second))).collect();
        group.throughput(Throughput::Bytes(stream.len() as u64));
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let mut receiver = Receiver::new(protocol);
                let mut bytes = black_box(stream.as_slice());
                let mut fixes = 0;
                while let Some(fix) = receiver.read(&mut bytes, Time::ZERO) {
                    black_box(fix);
                    fixes += 1;
                }
                assert!(fixes >= 999);
            });
        });
    }
    group.finish();
}

criterion_group!(benches, decode);
criterion_main!(benches);
