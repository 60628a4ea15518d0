//! A flight computer for a microcontroller, to be copied. It needs `core`, `hovernav` and the traits of
//! `embedded-hal` 1.
//!
//! The program around it moves the bytes of two serial ports, by DMA or an interrupt, and passes them on with their
//! arrival times. The channels of five timers move the servos. Nothing here waits, allocates or depends on a chip.

use embedded_hal::pwm::SetDutyCycle;
use hovernav::autopilot::{HoverAutopilot, Inputs, Outputs};
use hovernav::controls::{Channels, Sticks};
use hovernav::ekf::layout::WithoutHeightAids;
use hovernav::ekf::{Estimator, EstimatorConfig, NoHeadingSearch, Solution};
use hovernav::event::Event;
use hovernav::sensors::{SensorOutput, Sensors};
use hovernav::servo::{ChannelConfig, Limiter};
use hovernav::time::Time;

/// Period of the servos' pulses, ms.
pub const FRAME_MS: f64 = 20.0;

/// All processing between the sensors' bytes and the servos' pulses. Place it in a static, or in other large memory:
/// `docs/embedded.md` lists the sizes of its parts.
pub struct FlightComputer<P> {
    sensors: Sensors,
    estimator: Estimator<WithoutHeightAids, 26, f64, NoHeadingSearch>,
    autopilot: HoverAutopilot,
    channels: Channels<ChannelConfig>,
    limiter: Limiter,
    /// The channels of the timers.
    pub servos: Channels<P>,
}

/// Bytes to write to a line.
#[derive(Clone, Copy, Debug)]
pub struct Reply {
    bytes: [u8; 32],
    length: usize,
}

impl Reply {
    const NONE: Self = Self { bytes: [0; 32], length: 0 };

    fn add(&mut self, bytes: &[u8]) {
        for (slot, byte) in self.bytes.iter_mut().skip(self.length).zip(bytes) {
            *slot = *byte;
            self.length += 1;
        }
    }

    /// The bytes to write.
    pub fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

impl<P: SetDutyCycle> FlightComputer<P> {
    /// A flight computer whose replies start the sensors.
    pub fn new(
        sensors: Sensors,
        config: EstimatorConfig,
        autopilot: HoverAutopilot,
        channels: Channels<ChannelConfig>,
        limiter: Limiter,
        servos: Channels<P>,
    ) -> Self {
        let estimator = Estimator::with_layout(config);
        Self { sensors, estimator, autopilot, channels, limiter, servos }
    }

    /// Processes bytes of the IMU's line. Pass no bytes when the time that the last call returned is reached. Returns
    /// the bytes to write, and the time until which to read next.
    pub fn dmu(&mut self, bytes: &[u8], now: Time) -> (Reply, Time) {
        let mut reply = Reply::NONE;
        let Self { sensors, estimator, autopilot, .. } = self;
        let until = sensors.dmu(bytes, now, |output| match output {
            SensorOutput::WriteDmu(command) => reply.add(&[command.byte()]),
            SensorOutput::Event(event) => push(estimator, autopilot, &event),
            _ => {}
        });
        (reply, until)
    }

    /// Processes bytes of the receiver's line. Pass no bytes when the line is silent. Returns the bytes to write.
    pub fn gps(&mut self, bytes: &[u8], now: Time) -> Reply {
        let mut reply = Reply::NONE;
        let Self { sensors, estimator, autopilot, .. } = self;
        sensors.gps(bytes, now, |output| match output {
            SensorOutput::WriteGps(command) => reply.add(command.as_bytes()),
            SensorOutput::Event(event) => push(estimator, autopilot, &event),
            _ => {}
        });
        reply
    }

    /// One cycle of control: the autopilot's step, and the servos' pulses.
    ///
    /// # Errors
    /// The error of a timer's channel.
    pub fn control(
        &mut self,
        pilot: Option<Sticks>,
        engage: bool,
        now: Time,
    ) -> Result<Outputs, P::Error> {
        let solution = self.solution();
        let outputs =
            self.autopilot.step(&Inputs { now, solution: solution.as_ref(), pilot, engage });
        let Sticks { lateral, longitudinal, collective, pedal } = outputs.sticks;
        let sticks = Channels { throttle: 0.0, collective, longitudinal, lateral, pedal };
        let wanted_ms = self.channels.zip(sticks).map(|(channel, stick)| channel.width_ms(stick));
        let pulses = self.limiter.apply(&wanted_ms, now);
        let Channels { throttle, collective, longitudinal, lateral, pedal } = &mut self.servos;
        let servos = [throttle, collective, longitudinal, lateral, pedal].into_iter();
        for (servo, pulse) in servos.zip(pulses.to_array()) {
            let full = f64::from(servo.max_duty_cycle());
            // The width is within the channel's range, and therefore within the timer's range.
            servo.set_duty_cycle((pulse.width_ms / FRAME_MS * full) as u16)?;
        }
        Ok(outputs)
    }

    /// Position, velocity and attitude, once aligned.
    pub fn solution(&self) -> Option<Solution> {
        self.estimator.solution()
    }
}

fn push(
    estimator: &mut Estimator<WithoutHeightAids, 26, f64, NoHeadingSearch>,
    autopilot: &mut HoverAutopilot,
    event: &Event,
) {
    autopilot.observe(event);
    estimator.push(event, |notice| autopilot.observe_notice(&notice));
}
