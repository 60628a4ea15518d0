//! One hour at full rate. The test has its own process, because other tests would change its memory.

use crate::common::{cycle, passes_alone, resident};
use hovernav_ground::channel::Id;
use hovernav_ground::frames::Rigging;
use hovernav_ground::station::Station;

#[test]
fn an_hour_of_every_channel_at_33_hz_leaves_memory_flat_and_loses_nothing() {
    passes_alone("memory::an_hour");
}

#[test]
#[ignore = "the test above runs it in its own process"]
fn an_hour() {
    let mut station = Station::new(Rigging::default(), None, "test");
    let mut number = 0;
    let mut minutes = |station: &mut Station, count: u32| {
        for _ in 0..count * 60 * 33 {
            station.receive(&cycle(number), 1e9 + f64::from(number) / 33.0);
            if number % 8 == 0 {
                station.tick(1e9 + f64::from(number) / 33.0);
            }
            number += 1;
        }
    };
    // Twenty minutes fill the ring buffers.
    minutes(&mut station, 22);
    let full = resident();
    minutes(&mut station, 38);
    let after = resident();
    let link = station.link(1e9 + 3600.0);
    let known = Id::all().filter(|id| !station.latest(*id, 1e9 + 3600.0).is_nan()).count();
    println!(
        "{known} channels, {:.0} MB full, {:.0} MB after an hour",
        full as f64 / 1e6,
        after as f64 / 1e6
    );
    assert!(known >= 60, "{known}");
    assert!(after < full + 8_000_000, "{full} bytes, then {after}");
    assert_eq!((link.frames, link.lost, link.damaged, link.late), (2 * 60 * 60 * 33, 0, 0, 0));
}
