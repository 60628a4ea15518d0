//! The steps of the filter, each timed separately.

use std::hint::black_box;

use hovernav::ekf::covariance::{
    Covariance, Joint, MAX_AXES, Sensitivities, Sensitivity, Transition,
};
use hovernav::ekf::layout::{Base, Full, Layout, WithoutHeightAids};
use hovernav::ekf::{AntennaHeadingModel, Ekf, Estimator, NoHeadingSearch, Rangefinder};
use hovernav::event::{BaroReading, Event, RangeReading};
use hovernav::frames::Rotation;
use hovernav::time::Time;

use crate::Timed;
use crate::distribution::{Pace, Times};
use crate::flight::{FIX_EVERY, Flight};

/// Cycles until the filter is aligned and settled.
const SETTLED: u64 = 1_000;
/// Cycles between two attitude updates. The filter rejects more frequent ones.
pub const ATTITUDE_EVERY: u64 = 4;

/// Cycles between two distances to the ground.
const RANGE_EVERY: u64 = 2;

/// Name of the whole cycle: a sample, the attitude and the fix if due, and the solution.
pub const WHOLE_CYCLE: &str = "sample, all due, solution";

/// A filter in mid-flight, and the flight that it follows.
pub fn settled<L: Layout<N>, const N: usize>() -> Result<(Ekf<L, N>, Flight), String> {
    let mut flight = Flight::new()?;
    let mut estimator = Estimator::<L, N, f64, NoHeadingSearch>::with_layout(Flight::config());
    for cycle in 0..SETTLED {
        estimator.push(&Event::Imu(flight.sample(cycle)), |_| {});
        if cycle % FIX_EVERY == 0 {
            estimator.push(&Event::Gps(flight.fix(cycle)), |_| {});
            let time = Flight::time(cycle);
            let height_m = flight.height_m();
            estimator.push(&Event::Baro(BaroReading::new(time, height_m)), |_| {});
        }
    }
    let filter = estimator.filter().ok_or("the synthetic flight does not align")?.clone();
    Ok((filter, flight))
}

/// A typical step of the covariance at 33 Hz; the parameters relax only every fifth of a second.
pub fn transition<const N: usize>() -> Transition<f64, N> {
    let matrix = |scale: f64| {
        [[0.5, -0.8, 0.1], [0.8, 0.5, -0.05], [0.0, 0.1, 0.99]].map(|row| row.map(|v| v * scale))
    };
    Transition {
        interval_s: crate::PERIOD_S,
        turn: matrix(crate::PERIOD_S),
        force: [0.01, 0.02, -0.3],
        attitude_noise: [1e-8, 0.0, 0.0, 1e-8, 0.0, 1e-8],
        velocity_noise: [1e-4, 0.0, 0.0, 1e-4, 0.0, 1e-4],
        position_noise: [0.0; 3],
        relaxation: None,
    }
}

/// Sensitivities of three axes of a position to the position and, by a lever arm, to the attitude.
pub fn arms() -> [Sensitivity<f64>; 3] {
    std::array::from_fn(|axis| {
        Sensitivity::default().with(6 + axis, 1.0).with_block(0, [0.1, 0.2, 0.3])
    })
}

/// A covariance after a hundred steps.
pub fn covariance<const N: usize>() -> Covariance<f64, N> {
    let mut p = Covariance::zero();
    for state in 0..N {
        p.set_variance(state, 0.01);
    }
    let step = transition();
    for _ in 0..100 {
        p.propagate(&step);
    }
    p
}

/// A three-axis update with unit variance per axis.
pub fn update<L: Layout<N>, const N: usize>(
    p: &mut Covariance<f64, N>,
    arms: &[Sensitivity<f64>; 3],
) {
    let [north, east, down] = arms;
    let axes = [Some(north), Some(east), Some(down), None, None, None];
    let mut joint = Joint::<L, f64, N>::new(Sensitivities::Each(axes), [0.0; MAX_AXES]);
    joint.project(p, 0);
    for axis in 0..arms.len() {
        joint.fuse(p, axis, 1.0, joint.sigma(axis, 1.0), &mut |_, _, _| {});
    }
    joint.settle(p, &mut |_, _, _| {});
    black_box(joint.correction());
}

fn time<L: Layout<N>, const N: usize>(
    cycles: u64,
    clock_ns: f64,
    states: usize,
) -> Result<Vec<Timed>, String> {
    let (mut filter, mut flight) = settled::<L, N>()?;
    let mut step = Times::with_capacity(cycles);
    let [mut gps, mut attitude, mut magnetic, mut antennas, mut baro, mut range, mut solution] =
        [(); 7].map(|()| Times::with_capacity(cycles));
    let (rangefinder, two_antennas) = (Rangefinder::default(), AntennaHeadingModel::default());
    let mut pace = Pace::begin();
    for cycle in SETTLED..SETTLED + cycles {
        pace.rest();
        let sample = flight.sample(cycle);
        let now: Time = sample.time;
        step.time(|| black_box(black_box(&mut filter).predict(black_box(&sample))))
            .map_err(|fault| format!("the synthetic flight: sample rejected at {now}: {fault}"))?;
        // Heading comes from the attitude. In two of six blocks of 256 cycles it comes from two antennas or from the
        // magnetometer.
        let (by_antennas, by_field) = (cycle / 256 % 6 == 4, cycle / 256 % 6 == 5);
        if cycle % ATTITUDE_EVERY == 0 && by_antennas {
            let heading = Flight::heading(cycle);
            let update = || {
                let heading = black_box(&heading);
                black_box(filter.update_antenna_heading(heading, None, &two_antennas, &mut ()))
            };
            let _ = antennas.time(update);
        } else if cycle % ATTITUDE_EVERY == 0 && by_field {
            let field = Flight::field_gauss(cycle);
            let heading =
                || black_box(filter.update_magnetic_heading(now, black_box(field), 0.0, &mut ()));
            let _ = magnetic.time(heading);
        } else if cycle % ATTITUDE_EVERY == 0 {
            let reference = Rotation::from_euler(Flight::angles(cycle));
            let _ = attitude.time(|| black_box(filter.update_attitude(now, reference, &mut ())));
        }
        if cycle % FIX_EVERY == 0 {
            let fix = flight.fix(cycle);
            let _ = gps.time(|| black_box(filter.update_gps(black_box(&fix))));
            let height_m = flight.height_m();
            if L::BARO.is_some() {
                let _ = baro.time(|| black_box(filter.update_baro(now, height_m, &mut ())));
            }
        }
        if L::GROUND.is_some() && cycle % RANGE_EVERY == 1 {
            let reading = RangeReading::new(now, flight.range_m());
            let update =
                || black_box(filter.update_range(black_box(&reading), &rangefinder, &mut ()));
            let _ = range.time(update);
        }
        black_box(solution.time(|| black_box(&filter).solution()));
    }

    let (mut propagation, mut axes) = (Times::with_capacity(cycles), Times::with_capacity(cycles));
    let (start, transition, arms) = (covariance::<N>(), transition(), arms());
    for _ in 0..cycles.min(100_000) {
        pace.rest();
        let mut p = start;
        propagation.time(|| black_box(&mut p).propagate(black_box(&transition)));
        axes.time(|| update::<L, N>(black_box(&mut p), black_box(&arms)));
    }

    let cycle = whole_cycles(&mut filter, &mut flight, cycles)?;
    let all = [
        ("inertial step", step),
        ("fix: position and velocity", gps),
        ("attitude", attitude),
        ("magnetic heading", magnetic),
        ("heading of two antennas", antennas),
        ("barometer", baro),
        ("distance to the ground", range),
        ("solution", solution),
        ("covariance, one step", propagation),
        ("covariance, three axes", axes),
        (WHOLE_CYCLE, cycle),
    ];
    let timed = |(name, times): (&'static str, Times)| Timed {
        name,
        states,
        time: times.distribution(clock_ns),
        instructions: None,
    };
    // Sensors whose states the layout lacks have no times.
    Ok(all.into_iter().map(timed).filter(|timed| timed.time.calls > 0).collect())
}

/// Whole cycles of the filter: a sample, the attitude and the fix if due, and the solution. All are due every 132
/// cycles.
fn whole_cycles<L: Layout<N>, const N: usize>(
    filter: &mut Ekf<L, N>,
    flight: &mut Flight,
    cycles: u64,
) -> Result<Times, String> {
    let mut whole = Times::with_capacity(cycles);
    let mut pace = Pace::begin();
    for cycle in SETTLED + cycles..SETTLED + 2 * cycles {
        pace.rest();
        let sample = flight.sample(cycle);
        let reference = Rotation::from_euler(Flight::angles(cycle));
        let reference = (cycle % ATTITUDE_EVERY == 0).then_some(reference);
        let fix = (cycle % FIX_EVERY == 0).then(|| flight.fix(cycle));
        whole
            .time(|| {
                let predicted = black_box(&mut *filter).predict(black_box(&sample));
                if let Some(reference) = black_box(reference) {
                    let _ = black_box(filter.update_attitude(sample.time, reference, &mut ()));
                }
                if let Some(fix) = black_box(&fix) {
                    let _ = black_box(filter.update_gps(fix));
                }
                black_box(filter.solution());
                predicted
            })
            .map_err(|fault| format!("the synthetic flight: sample rejected: {fault}"))?;
    }
    Ok(whole)
}

/// Times of the filter with all blocks of states.
pub fn full(cycles: u64, clock_ns: f64) -> Result<Vec<Timed>, String> {
    time::<Full, 28>(cycles, clock_ns, 28)
}

/// Times of the filter with all blocks except those of barometer and rangefinder.
pub fn without_height_aids(cycles: u64, clock_ns: f64) -> Result<Vec<Timed>, String> {
    time::<WithoutHeightAids, 26>(cycles, clock_ns, 26)
}

/// Times of the filter with the fifteen base states.
pub fn base(cycles: u64, clock_ns: f64) -> Result<Vec<Timed>, String> {
    let mut timed = time::<Base, 16>(cycles, clock_ns, 15)?;
    timed.retain(|timed| !matches!(timed.name, "attitude" | "magnetic heading" | "barometer"));
    Ok(timed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Work;

    #[test]
    fn every_update_that_is_counted_is_timed() {
        let steps = [full(1_000, 0.0), without_height_aids(1_000, 0.0), base(1_000, 0.0)];
        let steps: Vec<Timed> = steps.into_iter().flat_map(Result::unwrap).collect();
        // A notch is not an update.
        for work in Work::ALL.iter().filter(|work| !work.name.starts_with("notch")) {
            let timed = |step: &Timed| (step.name, step.states) == (work.name, work.states);
            assert!(steps.iter().any(timed), "{work:?}");
        }
    }
}
