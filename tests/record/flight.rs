//! A flight of the real loop, with a simulated IMU and receiver at the ends of its lines.

use std::collections::VecDeque;

use hovernav::dmu::AnglePacket;
use hovernav::earth::Geodetic;
use hovernav::ekf::layout::Full;
use hovernav::ekf::{Estimator, Solution};
use hovernav::event::Event;
use hovernav::imu::{ImuSample, Motion};
use hovernav::sensors::{SensorOutput, Sensors};
use hovernav::time::Time;
use hovernav_record::{Entry, FlyConfig, Header, Line, ReceiverProtocol, Recorder};
use hovernav_sim::{FlightPlan, Recording};

use hovernav_fly::devices::encode::{Epoch, tsip_epoch, tsip_time};

/// Start of the flight on the clock of the machine, some time after it was switched on.
pub const START: Time = Time::from_nanoseconds(86_412_345_678_901);
/// Start of the flight in UTC, on a day of 2026, ns since 1970.
const START_UNIX_NS: i64 = 1_790_000_000_123_456_789;

/// A Crossbow IMU and a Trimble receiver on a helicopter.
pub fn header() -> Header {
    let mut config = FlyConfig::default();
    config.receiver.protocol = ReceiverProtocol::Tsip;
    let navigation = &mut config.navigation;
    navigation.name = "hover".into();
    navigation.imu.lever_arm_m = [0.03, -0.02, 0.28].into();
    navigation.imu.magnetic_declination_deg = Some(0.3);
    navigation.gps.antenna_lever_arm_m = [-0.35, 0.0, 0.2].into();
    navigation.gps.latency_s = 0.12;
    Header::new(config, START, START_UNIX_NS)
}

/// Runs the loop with recording for `duration_s`. After a third of this time the IMU is unplugged for a second; after
/// two thirds the receiver's line is lost. Returns the flown data.
pub fn fly(header: &Header, recorder: &mut Recorder, duration_s: f64) -> Vec<Solution> {
    let start = Geodetic::from_degrees(1.3521, 103.8198, 50.0).unwrap();
    let path = FlightPlan::hover_at(start, 0.5).hold(duration_s).build().unwrap();
    let truth = hovernav_sim::fly(
        &path,
        &hovernav_sim::DmuConfig::default(),
        &hovernav_sim::GpsConfig::default(),
        7,
    )
    .unwrap();
    let (dmu, gps) = header.config.sensors().unwrap();
    let mut vehicle = Vehicle {
        sensors: Sensors::new(dmu, gps, header.start),
        estimator: Estimator::new(header.settings().unwrap()),
        recorder,
        unit: VecDeque::new(),
        truth: &truth,
        flown: Vec::new(),
    };
    let mut receiver: VecDeque<(Time, Vec<u8>)> = receiver(&truth).into();
    let end = START + duration_s;
    let (unplugged, lost) = (START + duration_s / 3.0, START + duration_s * 2.0 / 3.0);
    let (mut now, mut until) = (START, vehicle.dmu(&[], START));
    while now < end {
        // The clock of this flight is faster than the writer.
        while vehicle.recorder.status().queued > 1000 {
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        let packet = vehicle.unit.front().map_or(end, |reply| reply.0);
        let fix = receiver.front().map_or(end, |part| part.0);
        now = packet.min(fix).min(until.max(now));
        if now == packet
            && let Some((_, mut bytes)) = vehicle.unit.pop_front()
        {
            if now >= unplugged && now - unplugged < 1.0 {
                bytes.clear();
            }
            until = vehicle.dmu(&bytes, now);
        } else if now == fix
            && let Some((_, bytes)) = receiver.pop_front()
        {
            vehicle.gps(&bytes, now);
            if now >= lost && now - lost < 1.0 {
                vehicle.recorder.push(now, Entry::GpsRestarted);
                vehicle.sensors.restart_gps();
            }
        } else {
            until = vehicle.dmu(&[], now);
        }
    }
    vehicle.flown
}

struct Vehicle<'a> {
    sensors: Sensors,
    estimator: Estimator<Full, 28>,
    recorder: &'a mut Recorder,
    /// The next bytes of the IMU, and their time.
    unit: VecDeque<(Time, Vec<u8>)>,
    truth: &'a Recording,
    flown: Vec<Solution>,
}

impl Vehicle<'_> {
    fn dmu(&mut self, bytes: &[u8], now: Time) -> Time {
        self.recorder.raw(Line::Dmu, bytes, now);
        let mut reports = Vec::new();
        let until = self.sensors.dmu(bytes, now, |report| reports.push(report));
        self.take(&reports, now);
        until
    }

    fn gps(&mut self, bytes: &[u8], now: Time) {
        self.recorder.raw(Line::Gps, bytes, now);
        let mut reports = Vec::new();
        self.sensors.gps(bytes, now, |report| reports.push(report));
        self.take(&reports, now);
    }

    fn take(&mut self, reports: &[SensorOutput], now: Time) {
        for report in reports {
            self.recorder.push(now, *report);
            match report {
                SensorOutput::WriteDmu(command) if command.byte() == b'G' => {
                    let sample = sample(self.truth, now);
                    self.unit.push_back((now + 0.0091, packet(sample, now).encode().to_vec()));
                }
                SensorOutput::WriteDmu(command) => {
                    let reply = command.reply().into_iter().collect::<Vec<u8>>();
                    self.unit.extend((!reply.is_empty()).then(|| (now + 0.002, reply)));
                }
                SensorOutput::Event(event) => {
                    self.estimator.push(event, |notice| self.recorder.push(now, notice));
                    if let (Event::Imu(_), Some(solution)) = (event, self.estimator.solution()) {
                        self.recorder.push(now, solution);
                        self.flown.push(solution);
                    }
                }
                _ => {}
            }
        }
    }
}

fn sample(truth: &Recording, now: Time) -> &ImuSample {
    let since_start = Time::ZERO + (now - START);
    let next = truth.imu.partition_point(|sample| sample.time < since_start);
    &truth.imu[next.min(truth.imu.len() - 1)]
}

/// The words of the IMU for a sample: ±200 °/s and ±4 g, accelerations counted against their axes.
fn packet(sample: &ImuSample, now: Time) -> AnglePacket {
    let Motion::Rates { angular_rate_radps, specific_force_mps2 } = sample.motion else {
        panic!("{sample:?}");
    };
    let words =
        |values: [f64; 3], full: f64| values.map(|value| (value / full * 32_768.0).round() as i16);
    let field = sample.magnetic_field_gauss.unwrap();
    let elapsed_ns = (now - START) * 1e9;
    AnglePacket {
        attitude: words(sample.attitude.unwrap().to_degrees(), 180.0),
        angular_rate: words(angular_rate_radps.to_array().map(f64::to_degrees), 300.0),
        acceleration: words((specific_force_mps2 * -1.0).to_array(), 6.0 * 9.806_65),
        magnetic_field: words(field.to_array(), 1.5 * 1.25),
        temperature: 1590,
        // The timer counts down by one in 790 ns.
        timer: 0u16.wrapping_sub((elapsed_ns / 790.0) as u64 as u16),
    }
}

/// The output of the receiver: each fix in two parts, 20 ms apart, then silence.
fn receiver(truth: &Recording) -> Vec<(Time, Vec<u8>)> {
    let mut parts = Vec::new();
    for (index, fix) in truth.fixes.iter().enumerate() {
        let [north, east] = fix.horizontal_velocity_mps.unwrap_or_default();
        let epoch = Epoch {
            latitude_deg: fix.position.latitude_deg(),
            longitude_deg: fix.position.longitude_deg(),
            height_m: fix.position.height_m,
            velocity_ned_mps: Some([north, east, fix.down_velocity_mps.unwrap_or_default()]),
            satellites: 8,
            ..Epoch::flying(index as u32)
        };
        let arrival = START + (fix.time - Time::ZERO) + 0.12;
        let mut bytes = if index == 0 { tsip_time(&epoch) } else { Vec::new() };
        bytes.extend(tsip_epoch(&epoch));
        let second = bytes.split_off(40);
        parts.extend([(arrival, bytes), (arrival + 0.02, second), (arrival + 0.2, Vec::new())]);
    }
    parts
}
