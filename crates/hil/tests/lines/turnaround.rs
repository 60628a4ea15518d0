//! Time of the flight computer from the last byte of an inertial packet to the servos. Its own time and the wake-up
//! delays of both ends are separate.

use std::fmt::Write as _;
use std::fs;
use std::thread;

use hovernav_fly::DurationHistogram;
use hovernav_fly::serial::Clock;

use crate::common::{Flown, Setup, flown_by};

/// The curves: name, colour, and histogram of a flight.
type Curve = (&'static str, &'static str, fn(&Flown) -> &DurationHistogram);

const CURVES: [Curve; 2] = [
    ("our own time", "#0072b2", |flown| &flown.report.turnaround),
    ("over the lines, with the wake-up of both ends", "#d55e00", |flown| &flown.over_lines),
];

/// Half a minute of every flight is flown by hand, so both paths to the servos are measured.
#[test]
#[ignore = "needs an idle machine: it measures how long the computer takes, over five minutes of \
            real time"]
fn the_servos_receive_their_command_within_a_millisecond_of_the_packet() {
    let taken_before = taken_ticks();
    let fly = |seed| {
        let mut setup = Setup::new(300.0, &["engage@30:260"]);
        setup.flight.seed = seed;
        flown_by(&Clock::start(), &setup)
    };
    let flights: Vec<Flown> = thread::scope(|scope| {
        let running = [1, 2, 3, 4].map(|seed| scope.spawn(move || fly(seed)));
        running.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    let mut own_s = Vec::new();
    for (name, _, of) in CURVES {
        for flown in &flights {
            let took = of(flown);
            let [median, p99, p99_9] = [0.5, 0.99, 0.999].map(|part| 1e3 * took.quantile_s(part));
            println!(
                "{name:<45} {} cycles: median {median:.3} ms, p99 {p99:.3}, p99.9 {p99_9:.3}, \
                 longest {:.3}",
                took.count(),
                1e3 * took.longest_s()
            );
        }
        own_s.push(flights.iter().map(|flown| of(flown).quantile_s(0.999)).fold(0.0, f64::max));
    }
    if std::env::var_os("HOVERNAV_DRAW").is_some() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/turnaround.svg");
        fs::write(path, picture(&flights)).unwrap();
    }
    let [all, taken] = taken_ticks().zip(taken_before).map_or([1, 0], |(after, before)| {
        [after[0].saturating_sub(before[0]).max(1), after[1].saturating_sub(before[1])]
    });
    let taken_percent = 100.0 * taken as f64 / all as f64;
    println!("the host of this machine used {taken_percent:.2} % of the processor time");
    assert!(
        own_s[0] <= 1e-3,
        "{own_s:?}, with {taken_percent:.2} % of the processor time used by \
         the host"
    );
}

/// Ticks of all processors since boot, and ticks that the host of a virtual machine has stolen.
fn taken_ticks() -> Option<[u64; 2]> {
    let statistics = fs::read_to_string("/proc/stat").ok()?;
    let ticks: Vec<u64> = statistics
        .lines()
        .next()?
        .split_whitespace()
        .skip(1)
        .map_while(|ticks| ticks.parse().ok())
        .collect();
    Some([ticks.iter().take(8).sum(), *ticks.get(7)?])
}

/// Left, right, top and bottom of the plot.
const FRAME: [f64; 4] = [70.0, 700.0, 50.0, 330.0];
/// Powers of ten at the ends of the time axis, s.
const SECONDS: (i32, i32) = (-5, -1);
/// Powers of ten at the ends of the axis of the fraction of cycles.
const SHARES: (i32, i32) = (-4, 0);

fn at(seconds: f64, share: f64) -> (f64, f64) {
    let [left, right, top, bottom] = FRAME;
    let along = |value: f64, (from, to): (i32, i32)| {
        ((value.log10() - f64::from(from)) / f64::from(to - from)).clamp(0.0, 1.0)
    };
    (
        left + along(seconds, SECONDS) * (right - left),
        bottom - along(share, SHARES) * (bottom - top),
    )
}

/// The fraction of cycles that take longer, over the duration.
fn picture(flights: &[Flown]) -> String {
    let [left, right, top, bottom] = FRAME;
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 740 400\" font-family=\"system-ui, \
         sans-serif\" font-size=\"14\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n\
         <text x=\"70\" y=\"24\" font-size=\"16\">From the inertial packet to the servos: share of cycles \
         that take longer</text>\n",
    );
    let times = ["10 µs", "100 µs", "1 ms", "10 ms", "100 ms"];
    for (power, label) in (SECONDS.0..).zip(times) {
        let (x, _) = at(10f64.powi(power), 1.0);
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1} {top} V{bottom}\" stroke=\"#cccccc\"/>\n\
             <text x=\"{x:.1}\" y=\"352\" text-anchor=\"middle\">{label}</text>"
        );
    }
    for (power, label) in (SHARES.0..).zip(["0.01 %", "0.1 %", "1 %", "10 %", "100 %"]) {
        let (_, y) = at(1.0, 10f64.powi(power));
        let _ = writeln!(
            svg,
            "<path d=\"M{left} {y:.1} H{right}\" stroke=\"#cccccc\"/>\n\
             <text x=\"62\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            y + 5.0
        );
    }
    for (number, (name, colour, of)) in CURVES.into_iter().enumerate() {
        for flown in flights {
            let points: Vec<String> = (0..=160)
                .map(|step| 10f64.powf(-f64::from(step) / 40.0))
                .map(|share| {
                    let (x, y) = at(of(flown).quantile_s(1.0 - share), share);
                    format!("{x:.1},{y:.1}")
                })
                .collect();
            let _ = writeln!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"/>",
                points.join(" ")
            );
        }
        let x = 80.0 + 130.0 * number as f64;
        let _ = writeln!(
            svg,
            "<path d=\"M{x} 378 h24\" stroke=\"{colour}\" stroke-width=\"3\"/>\n\
             <text x=\"{}\" y=\"383\">{name}</text>",
            x + 32.0
        );
    }
    svg + "</svg>\n"
}
