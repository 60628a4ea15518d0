//! Hovernav's own telemetry frames as channel values.

use hovernav::autopilot::Mode;
use hovernav::controls::{Channels, Sticks};
use hovernav::earth::STANDARD_GRAVITY_MPS2;
use hovernav::frames::{Rotation, Vector};
use hovernav::servo::{ChannelConfig, Swashplate};
use hovernav::telemetry::{Snapshot, StatusFlags, Supplement};

use crate::channel::Id;

/// The rigging: conversion of pulse widths to stick fractions.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rigging {
    /// Trim, range and direction of each channel.
    pub channels: Channels<ChannelConfig>,
    /// Geometry of the swashplate servos.
    pub swashplate: Swashplate,
}

impl Rigging {
    /// The pilot's sticks, as fractions about trim.
    #[must_use]
    pub fn pilot(&self, widths_ms: &Channels<Option<f64>>) -> Option<Sticks> {
        self.swashplate.pilot_sticks(&self.channels, widths_ms)
    }

    /// The stick positions that correspond to the servo positions.
    #[must_use]
    pub fn flown(&self, widths_ms: &Channels<Option<f64>>) -> Option<Sticks> {
        let mixed = Swashplate { pilot_is_mixed: true, ..self.swashplate };
        mixed.pilot_sticks(&self.channels, widths_ms)
    }
}

/// Channel values as sent; `None` if unknown.
pub type Values = Vec<(Id, Option<f64>)>;

fn three<F>(values: &mut Values, ids: [Id; 3], vector: Option<Vector<F>>, scale: f64) {
    let components = vector.map(Vector::to_array);
    for (axis, id) in ids.into_iter().enumerate() {
        values.push((id, components.map(|all| all[axis] * scale)));
    }
}

/// Stores a north-east-down vector in the channels east, north, up.
fn east_north_up<F>(values: &mut Values, ids: [Id; 3], vector: Option<Vector<F>>) {
    let turned = vector.map(|vector| {
        let [north, east, down] = vector.to_array();
        [east, north, -down]
    });
    for (axis, id) in ids.into_iter().enumerate() {
        values.push((id, turned.map(|all| all[axis])));
    }
}

fn pulses(values: &mut Values, ids: [Id; 5], widths_ms: &Channels<Option<f64>>) {
    let Channels { throttle, collective, longitudinal, lateral, pedal } = *widths_ms;
    values.extend(ids.into_iter().zip([throttle, collective, longitudinal, lateral, pedal]));
}

fn sticks(values: &mut Values, ids: [Id; 4], sticks: Option<Sticks>) {
    let fractions = sticks.map(|sticks| sticks.to_array());
    for (stick, id) in ids.into_iter().enumerate() {
        values.push((id, fractions.map(|all| 100.0 * all[stick])));
    }
}

/// The channel values of a snapshot.
#[must_use]
pub fn of_snapshot(snapshot: &Snapshot, rigging: &Rigging) -> Values {
    use Id::*;
    const G: f64 = 1.0 / STANDARD_GRAVITY_MPS2;
    let degrees = 1f64.to_degrees();
    let mut values = Values::with_capacity(Id::COUNT);
    three(&mut values, [RateP, RateQ, RateR], snapshot.angular_rate_radps, degrees);
    three(&mut values, [AccelX, AccelY, AccelZ], snapshot.specific_force_mps2, G);
    three(&mut values, [MagX, MagY, MagZ], snapshot.magnetic_field_gauss, 1.0);
    let angles = snapshot.attitude;
    let velocity_body = angles
        .zip(snapshot.velocity_mps)
        .map(|(angles, velocity_mps)| Rotation::from_euler(angles).inverse() * velocity_mps);
    east_north_up(&mut values, [VelE, VelN, VelU], snapshot.velocity_mps);
    three(&mut values, [BodyU, BodyV, BodyW], velocity_body, 1.0);
    pulses(
        &mut values,
        [PilotThrottle, PilotCollective, PilotLongitudinal, PilotLateral, PilotPedal],
        &snapshot.pilot_ms,
    );
    pulses(
        &mut values,
        [ServoThrottle, ServoCollective, ServoLongitudinal, ServoLateral, ServoPedal],
        &snapshot.commanded_ms,
    );
    let pilot = rigging.pilot(&snapshot.pilot_ms);
    sticks(&mut values, [StickLateral, StickLongitudinal, StickCollective, StickPedal], pilot);
    let flown = rigging.flown(&snapshot.commanded_ms);
    sticks(&mut values, [FlownLateral, FlownLongitudinal, FlownCollective, FlownPedal], flown);

    let (gps, sigmas) = (&snapshot.gps, &snapshot.sigmas);
    let (innovations, timing) = (&snapshot.innovations, &snapshot.timing);
    let drops = &snapshot.drops;
    let position = snapshot.position;
    let count = |count: u32| Some(f64::from(count));
    let milliseconds = |seconds: Option<f64>| seconds.map(|seconds| 1e3 * seconds);
    let gps_velocity = gps.horizontal_velocity_mps;
    values.extend([
        (Roll, angles.map(|angles| angles.roll_rad.to_degrees())),
        (Pitch, angles.map(|angles| angles.pitch_rad.to_degrees())),
        (Yaw, angles.map(|angles| angles.yaw_rad.to_degrees())),
        (Temperature, snapshot.temperature_degc),
        (Latitude, position.map(|place| place.latitude_deg())),
        (Longitude, position.map(|place| place.longitude_deg())),
        (Height, position.map(|place| place.height_m)),
        (SigmaHorizontal, sigmas.horizontal_m),
        (SigmaVertical, sigmas.vertical_m),
        (SigmaVelHorizontal, sigmas.horizontal_velocity_mps),
        (SigmaVelVertical, sigmas.vertical_velocity_mps),
        (SigmaTilt, sigmas.tilt_rad.map(f64::to_degrees)),
        (SigmaHeading, sigmas.heading_rad.map(f64::to_degrees)),
        (GpsLatitude, gps.latitude_longitude_deg.map(|[latitude_deg, _]| latitude_deg)),
        (GpsLongitude, gps.latitude_longitude_deg.map(|[_, longitude_deg]| longitude_deg)),
        (GpsHeight, gps.height_m),
        (GpsAltitude, gps.altitude_msl_m),
        (GpsVelE, gps_velocity.map(|[_, east_mps]| east_mps)),
        (GpsVelN, gps_velocity.map(|[north_mps, _]| north_mps)),
        (GpsVelU, gps.down_velocity_mps.map(|down_mps| -down_mps)),
        (GpsFix, Some(f64::from(gps.fix.code()))),
        (Satellites, gps.satellites.map(f64::from)),
        (GpsAge, gps.age_s),
        (Hdop, gps.hdop),
        (Vdop, gps.vdop),
        (InnovationPosition, innovations.position),
        (InnovationVelocity, innovations.velocity),
        (InnovationAttitude, innovations.attitude),
        (InnovationHeading, innovations.heading),
        (InnovationBaro, innovations.baro),
        (Rejected, count(innovations.rejected)),
        (Period, milliseconds(timing.period_s)),
        (Work, milliseconds(timing.work_s)),
        (LongestWork, milliseconds(timing.longest_work_s)),
        (Overruns, count(timing.overruns)),
        (LostImu, count(drops.imu_packets)),
        (LostGps, count(drops.gps_messages)),
        (LostPulses, count(drops.pilot_pulses)),
        (LostFrames, count(drops.telemetry_frames)),
        (SystemMode, Some(f64::from(snapshot.mode.code()))),
        (Status, Some(f64::from(snapshot.status.bits()))),
        (StatusKnown, Some(f64::from(StatusFlags::ALL.bits()))),
    ]);
    values
}

/// The channel values of a supplement.
#[must_use]
pub fn of_supplement(supplement: &Supplement) -> Values {
    use Id::*;
    const G: f64 = 1.0 / STANDARD_GRAVITY_MPS2;
    let degrees = 1f64.to_degrees();
    let place = |mode| Mode::ALL.iter().position(|own| *own == mode).map(|place| place as f64);
    let mut values = Values::with_capacity(20);
    east_north_up(&mut values, [AskedVelE, AskedVelN, AskedVelU], supplement.asked_velocity_mps);
    let ids = [GyroBiasX, GyroBiasY, GyroBiasZ];
    three(&mut values, ids, supplement.gyro_bias_radps, degrees);
    let ids = [GyroBiasSigmaX, GyroBiasSigmaY, GyroBiasSigmaZ];
    three(&mut values, ids, supplement.gyro_bias_sigma_radps, degrees);
    let ids = [AccelBiasX, AccelBiasY, AccelBiasZ];
    three(&mut values, ids, supplement.accel_bias_mps2, G);
    let ids = [AccelBiasSigmaX, AccelBiasSigmaY, AccelBiasSigmaZ];
    three(&mut values, ids, supplement.accel_bias_sigma_mps2, G);
    values.extend([
        (AskedHeading, supplement.asked_heading_rad.map(f64::to_degrees)),
        (GeofenceShare, supplement.geofence_share.map(|share| 100.0 * share)),
        (Aux, supplement.aux_ms),
        (AutopilotMode, supplement.mode.and_then(place)),
        (Control, supplement.mode.map(|_| f64::from(supplement.flags.bits()))),
        (FailedChecks, supplement.mode.map(|_| f64::from(supplement.failed_checks))),
    ]);
    values
}
