//! The simulated helicopter behind the serial lines of a flight computer, in real time.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{bail, ensure};
use hovernav_fly::serial::Clock;
use hovernav_hil::{LinePaths, LiveConfig, LiveFlight, LiveStatistics, Scene, ServoPackets};
use hovernav_record::CaptureSection;
use hovernav_sim::FlightConfig;
use serde::Serialize;
use signal_hook::consts::{SIGINT, SIGTERM};

use super::arguments::{Arguments, OUT};
use super::estimate::Estimate;
use crate::arguments::read_fly_config;
use crate::output;

/// The result of the flight, for `summary.json`.
#[derive(Serialize)]
struct LinesSummary {
    tool: &'static str,
    version: &'static str,
    input: PathBuf,
    duration_s: f64,
    wall_s: f64,
    imu_samples: usize,
    /// All fixes that the receiver measured. The flight computer's record shows their use.
    gps_fixes_used: usize,
    gps_fixes_rejected: usize,
    crashed_s: Option<f64>,
    engaged_s: f64,
    engagements: usize,
    velocity_rms_mps: [f64; 3],
    heading_deg: f64,
    place_m: f64,
    stick_step: f64,
    turnaround_s: Turnaround,
    servo_packets: ServoPacketSummary,
}

/// Regularity of the servo packets from the flight computer.
#[derive(Serialize)]
struct ServoPacketSummary {
    came: u64,
    late: u64,
    missing: u64,
    longest_gap_s: f64,
}

/// Time from the last byte of an inertial packet to the first byte for the servos, s.
#[derive(Serialize)]
struct Turnaround {
    median: f64,
    p99: f64,
    p99_9: f64,
    longest: f64,
}

/// Shortest gap between servo packets, s, that is reported. The servos switch to pass-through at 0.2 s.
const LONG_GAP_S: f64 = 0.1;

/// The regularity of the servo packets, with the likely cause of gaps.
fn packets_in_words(packets: &ServoPackets) -> String {
    let ServoPackets { came, late, missing, longest_gap_s } = packets;
    if *late == 0 {
        return format!(
            "all {came} servo packets were in time, at most {longest_gap_s:.3} s apart"
        );
    }
    let busy = if *longest_gap_s > LONG_GAP_S {
        ": this machine was too busy, or the flight computer was delayed"
    } else {
        ""
    };
    format!(
        "of {came} servo packets {late} were late and {missing} were missing; the longest gap was \
         {longest_gap_s:.3} s{busy}"
    )
}

impl LinesSummary {
    /// Prints the result in a few lines.
    fn say(&self, packets: &ServoPackets) {
        let say = |line: std::fmt::Arguments<'_>| crate::output::say(line);
        match self.crashed_s {
            Some(crashed_s) => say(format_args!("crashed at {crashed_s:.1} s")),
            None => say(format_args!("flown {:.1} s", self.duration_s)),
        }
        if self.crashed_s.is_some() || packets.longest_gap_s > LONG_GAP_S {
            say(format_args!("{}", packets_in_words(packets)));
        }
        let [u, v, w] = self.velocity_rms_mps;
        say(format_args!(
            "switch closed {:.1} s in {} engagement{}: u, v, w {u:.2}, {v:.2}, {w:.2} m/s RMS, heading within \
             {:.1} deg, position within {:.1} m, largest step of a stick {:.1} %",
            self.engaged_s,
            self.engagements,
            if self.engagements == 1 { "" } else { "s" },
            self.heading_deg,
            self.place_m,
            100.0 * self.stick_step
        ));
        let Turnaround { median, p99, p99_9, longest } = &self.turnaround_s;
        let [median, p99, p99_9, longest] =
            [median, p99, p99_9, longest].map(|took_s| 1e3 * took_s);
        say(format_args!(
            "from packet to servos: median {median:.2} ms, p99 {p99:.2}, p99.9 {p99_9:.2}, longest {longest:.2}"
        ));
    }
}

/// Simulates `flight` behind the lines that `fly_config` names.
pub fn run(
    arguments: &Arguments,
    mut flight: FlightConfig,
    fly_config: &Path,
) -> anyhow::Result<()> {
    let started = Instant::now();
    let config = read_fly_config(fly_config)?;
    let place = |section: &str, key: &str| {
        format!(
            "{}: [{section}] {key}: missing, expected a serial port: the simulation connects to it",
            fly_config.display()
        )
    };
    let Some(CaptureSection::Serial(pilot)) = &config.servo.capture else {
        bail!(place("servo.capture", "serial"));
    };
    let Some(servos) = &config.servo.stream else { bail!(place("servo", "stream")) };
    let paths = LinePaths {
        dmu: config.dmu.port.clone(),
        gps: config.receiver.port.clone(),
        pilot: pilot.port.clone(),
        servos: servos.port.clone(),
    };
    flight.dmu.lever_arm_m = config.navigation.imu.lever_arm_m;
    flight.gps.lever_arm_m = config.navigation.gps.antenna_lever_arm_m;
    let (dmu, gps) = config.sensors()?;
    let duration_s = arguments.duration.unwrap_or(300.0);
    flight.duration_s = duration_s;
    let calibration = dmu.calibration;
    let scene = Scene { acts: arguments.act.clone() };
    let (channels, swashplate) = (config.servo.channels, config.servo.swashplate);
    let live = LiveConfig { flight, calibration, channels, swashplate, scene };

    let out = arguments.out.clone().unwrap_or_else(|| OUT.into());
    output::create(&out)?;
    let stop = crate::stop::when_asked(&[SIGINT, SIGTERM])?;
    let flying = LiveFlight::start(live, gps.protocol, &paths, &Clock::start())?;
    crate::output::say(format_args!(
        "ready: dmu at {}, gps at {}, pilot at {}, servos at {}",
        paths.dmu.display(),
        paths.gps.display(),
        paths.pilot.display(),
        paths.servos.display()
    ));
    let ready = Instant::now();
    let mut told = 0;
    while !flying.is_finished() && !stop.load(Ordering::Relaxed) {
        thread::sleep(Duration::from_millis(20));
        if let Some(longest_s) = arguments.duration
            && flying.elapsed_s().is_none()
            && ready.elapsed() >= Duration::from_secs_f64(longest_s)
        {
            bail!(
                "no flight: no flight computer opened all lines within {longest_s} s; run `hovernav fly \
                 --config` with the same file"
            );
        }
        let seconds = flying.elapsed_s().unwrap_or_default() as u64;
        if seconds >= told + 10
            && let Some(sample) = flying.latest()
        {
            told = seconds;
            let speed = sample.truth.velocity_mps.norm();
            let switch = if sample.switch_on { "closed" } else { "open" };
            crate::output::say(format_args!(
                "{seconds:5} s  speed {speed:.2} m/s, switch {switch}"
            ));
        }
    }
    let turnaround = flying.turnaround();
    let packets = flying.servo_packets();
    let crashed_s = flying.crashed_s();
    let elapsed_s = flying.elapsed_s().unwrap_or_default();
    let (mut dataset, samples) = flying.end()?;
    ensure!(!samples.is_empty(), "no flight: no flight computer opened all lines");
    dataset.manifest = config.navigation.clone();
    let statistics = LiveStatistics::of(&samples);
    let summary = LinesSummary {
        tool: "hovernav",
        version: env!("CARGO_PKG_VERSION"),
        input: fly_config.to_path_buf(),
        duration_s: elapsed_s,
        wall_s: started.elapsed().as_secs_f64(),
        imu_samples: dataset.imu.len(),
        gps_fixes_used: dataset.fixes.len(),
        gps_fixes_rejected: 0,
        crashed_s,
        engaged_s: statistics.engaged_s,
        engagements: statistics.engagements,
        velocity_rms_mps: statistics.velocity_rms_mps,
        heading_deg: statistics.heading_rad.to_degrees(),
        place_m: statistics.place_m,
        stick_step: statistics.stick_step,
        turnaround_s: Turnaround {
            median: turnaround.quantile_s(0.5),
            p99: turnaround.quantile_s(0.99),
            p99_9: turnaround.quantile_s(0.999),
            longest: turnaround.longest_s(),
        },
        servo_packets: ServoPacketSummary {
            came: packets.came,
            late: packets.late,
            missing: packets.missing,
            longest_gap_s: packets.longest_gap_s,
        },
    };
    // Print the result first: a full disk then costs only the files.
    summary.say(&packets);
    let truth: Vec<_> = samples.iter().map(|sample| sample.truth).collect();
    dataset.write(&out, &truth)?;
    output::write_json(&summary, &out.join("summary.json"))?;
    if arguments.no_report {
        output::remove_stale(&out, [output::REPORT]);
    } else {
        let estimate = Estimate::of(&mut dataset, &out, |_| ())?;
        estimate.write_page("Simulated flight behind a flight computer", &dataset, &out)?;
    }
    if let Some(crashed_s) = crashed_s {
        bail!(
            "the vehicle crashed at {crashed_s:.1} s; the flight until then is in {}",
            out.display()
        );
    }
    crate::output::say(format_args!("written {}", out.display()));
    Ok(())
}
