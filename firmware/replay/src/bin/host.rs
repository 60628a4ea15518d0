//! The flight on the host: the bit-exact reference for the emulated one.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    use hovernav::ekf::layout::{Base, Full, WithoutHeightAids};
    use hovernav::ekf::{Estimator, HeadingSearch, NoHeadingSearch};
    use replay::{autopilot, config, config_without_heading, flight_control, fly, variants};

    macro_rules! run {
        ($name:literal, [$L:ty, $N:literal, $T:ty, $H:ty], $config:ident, $made:ident, $most:literal) => {
            let mut estimator = Box::new(Estimator::<$L, $N, $T, $H>::with_layout($config()));
            let mut controller = $made::<$T>().expect("gains that can be flown");
            let outcome = fly(&mut estimator, &mut controller, $most, || 0, |_, _, _| {});
            println!("bits {}: {} solutions, {:016x}", $name, outcome.solutions, outcome.hash);
        };
    }
    variants!(run);
}

#[cfg(target_os = "none")]
mod not_here {
    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        loop {}
    }
}
