//! Instructions per call, counted by valgrind, independent of the load of the machine.
//!
//! The program runs itself under valgrind twice: with the work, and with everything except the work. The difference is
//! the work alone.

use std::hint::black_box;
use std::path::Path;
use std::process::Command;

use hovernav::ekf::layout::{Base, Full, Layout, WithoutHeightAids};
use hovernav::ekf::{AntennaHeadingModel, Ekf, Rangefinder};
use hovernav::event::RangeReading;
use hovernav::frames::Rotation;
use hovernav::gps::AntennaHeading;
use hovernav::imu::{Notch, NotchConfig};
use hovernav::time::Time;

use crate::flight::Flight;
use crate::kernels::{ATTITUDE_EVERY, WHOLE_CYCLE, arms, covariance, settled, transition, update};

/// A piece of work whose instructions are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Work {
    /// Name of the work, as in [`Timed`](crate::Timed).
    pub name: &'static str,
    /// States of the filter.
    pub states: usize,
}

impl Work {
    /// All counted pieces of work.
    pub const ALL: [Self; 16] = [
        Self { name: "inertial step", states: 26 },
        Self { name: "fix: position and velocity", states: 26 },
        Self { name: "attitude", states: 26 },
        Self { name: "magnetic heading", states: 26 },
        Self { name: "barometer", states: 28 },
        Self { name: "distance to the ground", states: 28 },
        Self { name: "heading of two antennas", states: 26 },
        Self { name: "notch, two harmonics", states: 26 },
        Self { name: "covariance, one step", states: 26 },
        Self { name: "covariance, three axes", states: 26 },
        Self { name: WHOLE_CYCLE, states: 26 },
        Self { name: "inertial step", states: 15 },
        Self { name: "fix: position and velocity", states: 15 },
        Self { name: "covariance, one step", states: 15 },
        Self { name: "covariance, three axes", states: 15 },
        Self { name: WHOLE_CYCLE, states: 15 },
    ];

    /// Does the work `times` times, each time from the same state. Without `works` it only restores this state.
    ///
    /// # Errors
    /// If the synthetic flight fails.
    pub fn perform(self, times: u64, works: bool) -> Result<(), String> {
        match self.states {
            28 => self.on::<Full, 28>(times, works),
            26 => self.on::<WithoutHeightAids, 26>(times, works),
            _ => self.on::<Base, 16>(times, works),
        }
    }

    fn on<L: Layout<N>, const N: usize>(self, times: u64, works: bool) -> Result<(), String> {
        let (mut filter, mut flight) = settled::<L, N>()?;
        // In a whole cycle the attitude update must be due.
        let passed = if self.name == WHOLE_CYCLE { ATTITUDE_EVERY } else { 0 };
        let now = 1_000 + passed;
        for cycle in 1_000..now {
            let _ = filter.predict(&flight.sample(cycle));
        }
        let (sample, fix) = (flight.sample(now), flight.fix(now));
        let reference = Rotation::from_euler(Flight::angles(999));
        let (field, height_m) = (Flight::field_gauss(999), flight.height_m());
        let time = Flight::time(999) + 0.2;
        let (range, rangefinder) = (RangeReading::new(time, 7.0), Rangefinder::default());
        let (model, heading) = (AntennaHeadingModel::default(), antenna_heading(time));
        let mut notch = Notch::new(NotchConfig::at_hz(26.6).with_harmonics(2));
        (0..100).for_each(|cycle| _ = notch.filter(&flight.sample(900 + cycle)));
        let (p, step, arms) = (covariance::<N>(), transition(), arms());
        let mut copy: Box<Ekf<L, N>> = Box::new(filter.clone());
        for _ in 0..times {
            (*copy).clone_from(&filter);
            let (mut p, mut notch) = (p, notch);
            black_box((&mut copy, &mut p, &mut notch));
            if !black_box(works) {
                continue;
            }
            match self.name {
                WHOLE_CYCLE => {
                    _ = black_box(copy.predict(black_box(&sample)));
                    _ = black_box(copy.update_attitude(sample.time, reference, &mut ()));
                    _ = black_box(copy.update_gps(black_box(&fix)));
                    black_box(copy.solution());
                }
                "inertial step" => _ = black_box(copy.predict(black_box(&sample))),
                "fix: position and velocity" => _ = black_box(copy.update_gps(black_box(&fix))),
                "attitude" => _ = black_box(copy.update_attitude(time, reference, &mut ())),
                "magnetic heading" => {
                    _ = black_box(copy.update_magnetic_heading(time, field, 0.0, &mut ()));
                }
                "barometer" => _ = black_box(copy.update_baro(time, height_m, &mut ())),
                "distance to the ground" => {
                    let rangefinder = black_box(&rangefinder);
                    _ = black_box(copy.update_range(black_box(&range), rangefinder, &mut ()));
                }
                "heading of two antennas" => {
                    let heading = black_box(&heading);
                    _ = black_box(copy.update_antenna_heading(heading, None, &model, &mut ()));
                }
                "notch, two harmonics" => _ = black_box(notch.filter(black_box(&sample))),
                "covariance, one step" => black_box(&mut p).propagate(black_box(&step)),
                _ => update::<L, N>(black_box(&mut p), black_box(&arms)),
            }
        }
        Ok(())
    }
}

/// The heading from two antennas at the end of the settling.
fn antenna_heading(time: Time) -> AntennaHeading {
    AntennaHeading::new(time, Flight::angles(999).yaw_rad, None)
}

/// Number of instructions of `command` under valgrind.
fn counted(command: &Path, arguments: &[String]) -> Result<u64, String> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(command)
        .args(arguments)
        .output()
        .map_err(|error| format!("valgrind: {error}"))?;
    let text = String::from_utf8_lossy(&output.stderr);
    text.lines()
        .find_map(|line| line.split("Collected : ").nth(1)?.trim().parse().ok())
        .filter(|_| output.status.success())
        .ok_or_else(|| format!("valgrind reported no count: {}", text.trim()))
}

/// Repetitions of each work. The variation at the start of the program is then negligible.
const TIMES: u64 = 200;

/// Instructions per call of each work. `command` runs with `arguments` of the work's index in [`Work::ALL`], the
/// repetitions, and whether to do the work. It must call [`Work::perform`] with these.
///
/// # Errors
/// The reason, if valgrind is missing or fails.
pub fn count_instructions(
    command: &Path,
    arguments: impl Fn(usize, u64, bool) -> Vec<String>,
) -> Result<Vec<(Work, u64)>, String> {
    let count = |(place, work): (usize, &Work)| {
        let with = counted(command, &arguments(place, TIMES, true))?;
        let without = counted(command, &arguments(place, TIMES, false))?;
        Ok((*work, with.saturating_sub(without) / TIMES))
    };
    Work::ALL.iter().enumerate().map(count).collect()
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;

    /// Largest number of instructions of each work in [`Work::ALL`]: the count of the release build plus 2 %.
    const MAX: [u64; Work::ALL.len()] = [
        4_954, 18_440, 8_099, 4_654, 4_883, 5_596, 4_649, 543, 2_254, 6_058, 34_631, 4_414, 12_529,
        1_709, 2_975, 18_005,
    ];

    const COUNTED: &str = "instructions::tests::the_work_that_is_counted";

    /// The last three command arguments are index, repetitions, and whether to do the work; they match no test name.
    #[test]
    #[ignore = "the test below runs and counts it"]
    fn the_work_that_is_counted() {
        let arguments: Vec<String> = std::env::args().collect();
        let [.., place, times, works] = arguments.as_slice() else { return };
        if let (Ok(place), Ok(times)) = (place.parse::<usize>(), times.parse()) {
            Work::ALL[place].perform(times, works == "1").unwrap();
        }
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "counts the instructions of a release build: .ci/run")]
    fn no_work_takes_more_instructions_than_it_may() {
        if !hovernav_testing::installed("valgrind") {
            return;
        }
        let program = std::env::current_exe().unwrap();
        let counts = count_instructions(&program, |place, times, works| {
            let asked = [place.to_string(), times.to_string(), u8::from(works).to_string()];
            let test = ["--ignored", "--test-threads=1", "--exact", COUNTED];
            test.map(str::to_owned).into_iter().chain(asked).collect()
        });
        let counts = counts.unwrap();
        for (work, instructions) in &counts {
            println!("{}, {} states: {instructions}", work.name, work.states);
        }
        for ((work, instructions), most) in counts.iter().zip(MAX) {
            assert!(*instructions <= most, "{work:?}: {instructions} instructions, at most {most}");
        }
    }
}
