//! `hovernav simulate`: a flight whose truth is known, recorded as a dataset.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Context as _;
use hovernav::earth::Geodetic;
use hovernav::log::{Dataset, Manifest};
use hovernav::sim::{self, DmuConfig, FlightPlan, GpsConfig};
use serde_json::json;

#[derive(clap::Args)]
pub struct Arguments {
    /// Where to write; out/simulated unless given
    #[arg(long, value_name = "DIR", default_value = "out/simulated")]
    out: PathBuf,
    /// What to fly
    #[arg(long, value_enum, default_value_t = Flight::Tour)]
    flight: Flight,
    /// Seed of every sensor error: the same seed gives the same dataset
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Where to start: latitude and longitude in degrees, height above the ellipsoid in metres
    #[arg(long, value_name = "LAT,LON,HEIGHT", default_value = "1.3521,103.8198,50", value_parser = place, allow_hyphen_values = true)]
    place: Geodetic,
    /// Heading to start with, degrees from true north
    #[arg(long, value_name = "DEG", default_value_t = 60.0, allow_hyphen_values = true)]
    heading: f64,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Flight {
    /// Five minutes of hover
    Hover,
    /// Roll, pitch, heave and yaw doublets from hover, as for identification
    TestPoints,
    /// Five minutes of hover, turns, test points, climbs and forward flight
    Tour,
}

fn place(text: &str) -> Result<Geodetic, String> {
    let numbers: Vec<f64> = text.split(',').map_while(|part| part.trim().parse().ok()).collect();
    match numbers[..] {
        [lat, lon, height] => {
            Geodetic::from_degrees(lat, lon, height).filter(Geodetic::is_navigable)
        }
        _ => None,
    }
    .ok_or_else(|| format!("found \"{text}\", expected LAT,LON,HEIGHT of a place on Earth"))
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let started = Instant::now();
    let (start, heading_rad) = (arguments.place, arguments.heading.to_radians());
    let plan = match arguments.flight {
        Flight::Hover => FlightPlan::hover_at(start, heading_rad).hold(300.0),
        Flight::TestPoints => {
            FlightPlan::hover_at(start, heading_rad).hold(30.0).test_points().hold(10.0)
        }
        Flight::Tour => FlightPlan::test_flight(start, heading_rad),
    };
    let (dmu, gps) = (DmuConfig::default(), GpsConfig::default());
    let recording = sim::fly(&plan.build()?, &dmu, &gps, arguments.seed)?;

    let dataset = Dataset {
        manifest: manifest(&dmu, &gps, arguments.seed),
        imu: recording.imu,
        fixes: recording.fixes,
        ..Dataset::default()
    };
    dataset.write(&arguments.out, &recording.truth)?;
    write_summary(&arguments.out.join("summary.json"), &dataset, started)?;
    println!(
        "{}: {:.0} s, {} inertial samples, {} fixes, seed {}",
        arguments.out.display(),
        plan.duration_s(),
        dataset.imu.len(),
        dataset.fixes.len(),
        arguments.seed
    );
    Ok(())
}

fn manifest(dmu: &DmuConfig, gps: &GpsConfig, seed: u64) -> Manifest {
    let mut manifest = Manifest {
        name: "simulated".into(),
        vehicle: format!("simulated helicopter, thesis-grade sensors, seed {seed}"),
        kind: "simulated".into(),
        time: "seconds, one clock for all files".into(),
        ..Manifest::default()
    };
    let imu = &mut manifest.imu;
    imu.rate_hz = Some(dmu.rate_hz);
    imu.lever_arm_m = dmu.lever_arm_m;
    imu.angle_random_walk_deg_per_sqrt_h = Some(dmu.gyro.angle_random_walk_deg_per_sqrt_h);
    imu.velocity_random_walk_mps_per_sqrt_h =
        Some(dmu.accelerometer.velocity_random_walk_mps_per_sqrt_h);
    imu.gyro_bias_sigma_degps = Some(dmu.gyro.turn_on_bias_sigma_degps);
    imu.accel_bias_sigma_mps2 = Some(dmu.accelerometer.turn_on_bias_sigma_mps2);
    imu.gyro_range_degps = Some(dmu.gyro.range_degps);
    imu.accel_range_g = Some(dmu.accelerometer.range_mps2 / 9.806_65);
    imu.magnetic_declination_deg = Some(0.0);
    manifest.gps.rate_hz = Some(gps.rate_hz);
    manifest.gps.antenna_lever_arm_m = gps.lever_arm_m;
    manifest.gps.latency_s = gps.assumed_latency_s;
    manifest
}

fn write_summary(path: &Path, dataset: &Dataset, started: Instant) -> anyhow::Result<()> {
    let duration_s = match (dataset.imu.first(), dataset.imu.last()) {
        (Some(first), Some(last)) => last.time - first.time,
        _ => 0.0,
    };
    let summary = json!({
        "tool": "hovernav",
        "version": env!("CARGO_PKG_VERSION"),
        "input": dataset.manifest.vehicle,
        "duration_s": duration_s,
        "wall_s": started.elapsed().as_secs_f64(),
        "imu_samples": dataset.imu.len(),
        "gps_fixes_used": dataset.fixes.len(),
        "gps_fixes_rejected": 0,
    });
    std::fs::write(path, format!("{summary:#}\n"))
        .with_context(|| format!("cannot write {}", path.display()))
}
