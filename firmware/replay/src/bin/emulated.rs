//! The flight on an emulated microcontroller: prints the hash of the results, the instructions of each kind of call,
//! and the depth of the stack.
//!
//! The emulator advances its clock by instructions, so the system timer counts them; `instructions` converts ticks to
//! instructions.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("build it for thumbv7em-none-eabihf; firmware/run does");
}

#[cfg(target_os = "none")]
mod emulated {
    use core::arch::asm;
    use core::hint::black_box;
    use core::panic::PanicInfo;

    use cortex_m::peripheral::SYST;
    use cortex_m::peripheral::syst::SystClkSource;
    use cortex_m::{Peripherals, register::msp, singleton};
    use cortex_m_rt::entry;
    use cortex_m_semihosting::{debug, hprintln};
    use hovernav::ekf::layout::{Base, Full, WithoutHeightAids};
    use hovernav::ekf::{Estimator, HeadingSearch, NoHeadingSearch};
    use replay::{Work, autopilot, config, config_without_heading, flight_control, fly, variants};

    #[panic_handler]
    fn panic(info: &PanicInfo<'_>) -> ! {
        hprintln!("{}", info);
        debug::exit(debug::EXIT_FAILURE);
        loop {}
    }

    /// Largest count of the timer, which counts down and has 24 bits.
    const TIMER: u32 = 0x00ff_ffff;

    fn elapsed(before: u32, after: u32) -> u32 {
        before.wrapping_sub(after) & TIMER
    }

    /// Number of ticks of 10 000 instructions.
    fn calibrate() -> u32 {
        let before = SYST::get_current();
        // SAFETY: counts a register down, two instructions per iteration.
        unsafe {
            asm!("2: subs {n}, {n}, #1", "bne 2b", n = inout(reg) 5_000 => _);
        }
        elapsed(before, SYST::get_current())
    }

    /// Number of bytes of stack below the current frame that are painted.
    const PAINTED: usize = 64 * 1024;
    /// Pattern of painted stack words.
    const PAINT: u32 = 0xa5a5_5a5a;
    /// Number of free bytes below the painter's own frame.
    const MARGIN: usize = 256;

    /// Paints the stack below, runs `work`, and returns the number of overwritten bytes.
    #[inline(never)]
    fn stack_of(work: impl FnOnce()) -> usize {
        let top = (msp::read() as usize - MARGIN) & !3;
        let bottom = top - PAINTED;
        for address in (bottom..top).step_by(4) {
            // SAFETY: unused RAM below the stack pointer: 4 MB, of which statics take 200 kB.
            unsafe { (address as *mut u32).write_volatile(PAINT) };
        }
        work();
        let untouched = (bottom..top)
            .step_by(4)
            // SAFETY: as above.
            .take_while(|&address| unsafe { (address as *const u32).read_volatile() } == PAINT)
            .count();
        PAINTED + MARGIN - 4 * untouched
    }

    #[derive(Clone, Copy, Default)]
    struct Cost {
        calls: u32,
        ticks: u64,
        most: u32,
    }

    #[entry]
    fn main() -> ! {
        let Some(mut peripherals) = Peripherals::take() else { loop {} };
        peripherals.SYST.set_clock_source(SystClkSource::Core);
        peripherals.SYST.set_reload(TIMER);
        peripherals.SYST.clear_current();
        peripherals.SYST.enable_counter();
        let ticks = u64::from(calibrate());

        macro_rules! run {
            ($name:literal, [$L:ty, $N:literal, $T:ty, $H:ty], $config:ident, $made:ident, $most:literal) => {{
                let mut made = None;
                let mut make =
                    || made = singleton!(: Estimator<$L, $N, $T, $H> = Estimator::with_layout($config()));
                // The call must not be in the painter's own frame, which is above the painted stack.
                let make: &mut dyn FnMut() = black_box(&mut make);
                let making = stack_of(make);
                let (Some(estimator), Some(mut controller)) = (made, $made::<$T>()) else { loop {} };
                let mut costs = [Cost::default(); Work::ALL.len()];
                let mut flown = None;
                let stack = stack_of(|| {
                    let note = |work: Work, before, after| {
                        let took = elapsed(before, after);
                        if let Some(cost) = costs.get_mut(work as usize) {
                            cost.calls += 1;
                            cost.ticks += u64::from(took);
                            cost.most = cost.most.max(took);
                        }
                    };
                    flown = Some(fly(estimator, &mut controller, $most, SYST::get_current, note));
                });
                if let Some(outcome) = flown {
                    hprintln!("bits {}: {} solutions, {:016x}", $name, outcome.solutions, outcome.hash);
                }
                for (work, cost) in Work::ALL.iter().zip(&costs).filter(|(_, cost)| cost.calls > 0) {
                    let instructions = |of: u64| of * 10_000 / ticks;
                    let mean = instructions(cost.ticks / u64::from(cost.calls));
                    let most = instructions(u64::from(cost.most));
                    hprintln!("cost {}: {} | {} | {}", $name, work.name(), mean, most);
                }
                hprintln!("stack {}: {}", $name, stack);
                hprintln!("making {}: {}", $name, making);
            }};
        }
        variants!(run);
        debug::exit(debug::EXIT_SUCCESS);
        loop {}
    }
}
