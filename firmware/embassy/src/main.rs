//! The flight computer of `examples/05_microcontroller` on an STM32H743. A Crossbow IMU is on USART2 and a u-blox
//! receiver on USART3, both with ring buffers filled by DMA. Five servos are on TIM3 and TIM4, and a switch engages the
//! autopilot. This repository only compiles it: pins, clocks and gains must be set for the vehicle.
//!
//! No bytes are lost while the filter computes, because DMA receives them: at 38 400 baud the buffer of the IMU's line
//! holds 66 ms.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("build it for thumbv7em-none-eabihf");
}

#[cfg(target_os = "none")]
#[path = "../../../examples/05_microcontroller/computer.rs"]
mod computer;

#[cfg(target_os = "none")]
mod board {
    use core::convert::Infallible;

    use embassy_executor::Spawner;
    use embassy_futures::select::{Either3, select3};
    use embassy_stm32::gpio::{Input, OutputType, Pull};
    use embassy_stm32::peripherals::{DMA1_CH0, DMA1_CH1, DMA1_CH2, DMA1_CH3, TIM3, TIM4};
    use embassy_stm32::peripherals::{USART2, USART3};
    use embassy_stm32::time::Hertz;
    use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm, SimplePwmChannel};
    use embassy_stm32::usart::{Config, InterruptHandler, Uart};
    use embassy_stm32::{bind_interrupts, dma};
    use embassy_time::{Duration, Instant, Ticker, Timer};
    use embedded_hal::pwm::{ErrorType, SetDutyCycle};
    use hovernav::autopilot::{Gains, HoverAutopilot, HoverConfig};
    use hovernav::controls::Channels;
    use hovernav::dmu::{Calibration, Flow, Mode};
    use hovernav::ekf::EstimatorConfig;
    use hovernav::gps::Protocol;
    use hovernav::gps::quality::Limits;
    use hovernav::sensors::{DmuConfig, GpsConfig, Sensors};
    use hovernav::servo::{ChannelConfig, Limiter};
    use hovernav::time::Time;
    use panic_halt as _;
    use static_cell::StaticCell;

    use crate::computer::{FRAME_MS, FlightComputer};

    bind_interrupts!(struct Interrupts {
        USART2 => InterruptHandler<USART2>;
        USART3 => InterruptHandler<USART3>;
        DMA1_STREAM0 => dma::InterruptHandler<DMA1_CH0>;
        DMA1_STREAM1 => dma::InterruptHandler<DMA1_CH1>;
        DMA1_STREAM2 => dma::InterruptHandler<DMA1_CH2>;
        DMA1_STREAM3 => dma::InterruptHandler<DMA1_CH3>;
    });

    /// Period of the loop, s.
    const CYCLE_S: f64 = 0.0303;
    /// Period of the loop, µs.
    const CYCLE_US: u64 = 30_300;

    /// A servo on one of the timers.
    enum Servo {
        First(SimplePwmChannel<'static, TIM3>),
        Second(SimplePwmChannel<'static, TIM4>),
    }

    impl ErrorType for Servo {
        type Error = Infallible;
    }

    impl SetDutyCycle for Servo {
        fn max_duty_cycle(&self) -> u16 {
            match self {
                Self::First(channel) => SetDutyCycle::max_duty_cycle(channel),
                Self::Second(channel) => SetDutyCycle::max_duty_cycle(channel),
            }
        }

        fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
            match self {
                Self::First(channel) => SetDutyCycle::set_duty_cycle(channel, duty),
                Self::Second(channel) => SetDutyCycle::set_duty_cycle(channel, duty),
            }
        }
    }

    /// Silence of the receiver, s, that ends an epoch.
    const SILENT_S: f64 = 0.05;

    /// The time on the one clock of the flight.
    fn now() -> Time {
        Time::from_nanoseconds(Instant::now().as_micros() as i64 * 1_000)
    }

    fn instant(time: Time) -> Instant {
        Instant::from_micros((time.nanoseconds() / 1_000).max(0) as u64)
    }

    fn sensors() -> Option<Sensors> {
        let dmu = DmuConfig {
            mode: Mode::Angle,
            flow: Flow::Polled { cycle_s: CYCLE_S },
            calibration: Calibration::new(200.0, 4.0).ok()?,
            latency_s: Mode::Angle.transfer_time_s(),
        };
        let gps = GpsConfig {
            protocol: Protocol::Ubx,
            rate_hz: Some(1),
            latency_s: 0.1,
            geoid_separation_m: None,
            limits: Limits::default(),
        };
        Some(Sensors::new(dmu, gps, now()))
    }

    /// The flight computer of this program; `None` for settings that cannot be flown.
    fn computer(servos: Channels<Servo>) -> Option<FlightComputer<Servo>> {
        // Insert the output of `hovernav design --emit rust` for the vehicle here.
        let mut gains = Gains::default();
        gains.heave.tracking_time_s = 1.0;
        let channels = Channels::<ChannelConfig>::default();
        let autopilot = HoverAutopilot::new(HoverConfig::new(CYCLE_S, gains)).ok()?;
        let limiter = Limiter::new(channels, 0.5).ok()?;
        let config = EstimatorConfig::default();
        Some(FlightComputer::new(sensors()?, config, autopilot, channels, limiter, servos))
    }

    #[embassy_executor::main]
    async fn main(_spawner: Spawner) {
        let p = embassy_stm32::init(embassy_stm32::Config::default());

        let mut line = Config::default();
        line.baudrate = 38_400;
        let dmu = Uart::new(p.USART2, p.PD6, p.PD5, p.DMA1_CH0, p.DMA1_CH1, Interrupts, line);
        let mut line = Config::default();
        line.baudrate = 9_600;
        let gps = Uart::new(p.USART3, p.PD9, p.PD8, p.DMA1_CH2, p.DMA1_CH3, Interrupts, line);
        let (Ok(dmu), Ok(gps)) = (dmu, gps) else { return };
        static DMU: StaticCell<[u8; 256]> = StaticCell::new();
        static GPS: StaticCell<[u8; 512]> = StaticCell::new();
        let (mut dmu_out, dmu_in) = dmu.split();
        let (mut gps_out, gps_in) = gps.split();
        let mut dmu_in = dmu_in.into_ring_buffered(DMU.init([0; 256]));
        let mut gps_in = gps_in.into_ring_buffered(GPS.init([0; 512]));

        let frame = Hertz((1_000.0 / FRAME_MS) as u32);
        let push_pull = OutputType::PushPull;
        let first = SimplePwm::new(
            p.TIM3,
            Some(PwmPin::new(p.PA6, push_pull)),
            Some(PwmPin::new(p.PA7, push_pull)),
            Some(PwmPin::new(p.PB0, push_pull)),
            Some(PwmPin::new(p.PB1, push_pull)),
            frame,
            Default::default(),
        )
        .split();
        let throttle = Some(PwmPin::new(p.PD12, push_pull));
        let second =
            SimplePwm::new(p.TIM4, throttle, None, None, None, frame, Default::default()).split();
        let mut servos = Channels {
            throttle: Servo::Second(second.ch1),
            collective: Servo::First(first.ch1),
            longitudinal: Servo::First(first.ch2),
            lateral: Servo::First(first.ch3),
            pedal: Servo::First(first.ch4),
        };
        for servo in [
            &mut servos.throttle,
            &mut servos.collective,
            &mut servos.longitudinal,
            &mut servos.lateral,
            &mut servos.pedal,
        ] {
            match servo {
                Servo::First(channel) => channel.enable(),
                Servo::Second(channel) => channel.enable(),
            }
        }
        let switch = Input::new(p.PC13, Pull::Down);

        static COMPUTER: StaticCell<FlightComputer<Servo>> = StaticCell::new();
        let Some(computer) = computer(servos) else { return };
        let computer = COMPUTER.init(computer);

        let mut cycle = Ticker::every(Duration::from_micros(CYCLE_US));
        let (mut from_dmu, mut from_gps) = ([0; 64], [0; 128]);
        // The loop reads at once, because the IMU waits for its start-up commands.
        let mut read_until = now();
        let mut heard_gps = None;
        loop {
            let deadline = async {
                embassy_futures::select::select(Timer::at(instant(read_until)), cycle.next()).await
            };
            let woken =
                select3(dmu_in.read(&mut from_dmu), gps_in.read(&mut from_gps), deadline).await;
            let reply = match woken {
                Either3::First(read) => {
                    // An overrun of the line counts as silence; the link to the IMU handles it.
                    let read = read.unwrap_or(0);
                    let bytes = from_dmu.get(..read).unwrap_or_default();
                    let (reply, until) = computer.dmu(bytes, now());
                    read_until = until;
                    reply
                }
                Either3::Second(read) => {
                    let read = read.unwrap_or(0);
                    let bytes = from_gps.get(..read).unwrap_or_default();
                    heard_gps = Some(now());
                    let reply = computer.gps(bytes, now());
                    let _ = gps_out.write(reply.as_bytes()).await;
                    continue;
                }
                Either3::Third(embassy_futures::select::Either::First(())) => {
                    let (reply, until) = computer.dmu(&[], now());
                    read_until = until;
                    reply
                }
                Either3::Third(embassy_futures::select::Either::Second(())) => {
                    if heard_gps.take_if(|heard| now() - *heard > SILENT_S).is_some() {
                        let reply = computer.gps(&[], now());
                        let _ = gps_out.write(reply.as_bytes()).await;
                    }
                    // The pilot's sticks come from any receiver; this example has none.
                    let Ok(_outputs) = computer.control(None, switch.is_high(), now());
                    continue;
                }
            };
            let _ = dmu_out.write(reply.as_bytes()).await;
        }
    }
}
