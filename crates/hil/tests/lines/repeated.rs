//! A flight with emulated time is reproducible, independent of the load of the machine.

use crate::common::{Setup, all_flown};

#[test]
fn a_flight_is_the_same_every_time() {
    let flights = all_flown(&[1, 2, 3, 4], |_| {
        let acts = ["engage@8:13", "pilot-lost@12:4", "dmu-pulled@17:1", "gps-cut@10:3"];
        Setup::new(24.0, &acts)
    });
    let all = flights.iter().map(|flown| {
        let record = &flown.record;
        let (cycles, solutions) = (&record.cycles, &record.solutions);
        // The texts of the events contain the directory, so they are not compared.
        let events = record.events.iter().map(|event| (event.time, &event.kind, event.level));
        let events: Vec<_> = events.collect();
        format!("{:?} {cycles:?} {solutions:?} {events:?}", flown.samples)
    });
    let all: Vec<String> = all.collect();
    assert!(all[0].len() > 1_000_000 && all.iter().all(|one| *one == all[0]));
}
