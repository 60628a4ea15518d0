//! A path flown exactly, and what the sensors say of it.

use std::path::Path;
use std::time::Instant;

use anyhow::Context as _;
use hovernav_log::{Dataset, Manifest};
use hovernav_sim;
use hovernav_sim::{DmuConfig, FlightPlan, GpsConfig};
use serde_json::json;

use super::{Arguments, OUT};

#[derive(Clone, Copy, clap::ValueEnum)]
pub enum Flight {
    /// Five minutes of hover
    Hover,
    /// Roll, pitch, heave and yaw doublets from hover, as for identification
    TestPoints,
    /// Five minutes of hover, turns, test points, climbs and forward flight
    Tour,
}

pub fn run(arguments: &Arguments, flight: Flight) -> anyhow::Result<()> {
    let started = Instant::now();
    let out = arguments.out.clone().unwrap_or_else(|| OUT.into());
    let (start, heading_rad) = (arguments.place, arguments.heading.to_radians());
    let plan = match flight {
        Flight::Hover => FlightPlan::hover_at(start, heading_rad).hold(300.0),
        Flight::TestPoints => {
            FlightPlan::hover_at(start, heading_rad).hold(30.0).test_points().hold(10.0)
        }
        Flight::Tour => FlightPlan::test_flight(start, heading_rad),
    };
    let (dmu, gps) = (DmuConfig::default(), GpsConfig::default());
    let recording = hovernav_sim::fly(&plan.build()?, &dmu, &gps, arguments.seed)?;

    let dataset = Dataset {
        manifest: manifest(&dmu, &gps, arguments.seed),
        imu: recording.imu,
        fixes: recording.fixes,
        ..Dataset::default()
    };
    dataset.write(&out, &recording.truth)?;
    write_summary(&out.join("summary.json"), &dataset, started)?;
    println!(
        "{}: {:.0} s, {} inertial samples, {} fixes, seed {}",
        out.display(),
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
