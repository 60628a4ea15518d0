//! Instructions of the filter's kernels: independent of the load of the machine.
//!
//! Needs valgrind and the runner of the same version as the `gungraun` crate:
//!
//! ```text
//! cargo install gungraun-runner --version 0.20.0 --locked
//! cargo bench --bench instructions
//! ```
//!
//! Without them the bench is skipped.

mod fixtures;

use hovernav_testing::installed;

fn main() {
    // Under valgrind the runner calls this program again, with its own first argument.
    let called_again = std::env::args().nth(1).is_some_and(|first| first == "--gungraun-run");
    if called_again || (installed("gungraun-runner") && installed("valgrind")) {
        counted::run();
    }
}

mod counted {
    use std::hint::black_box;

    use gungraun::{library_benchmark, library_benchmark_group};
    use hovernav::ekf::Ekf;
    use hovernav::ekf::covariance::{Covariance, Sensitivity, Transition};
    use hovernav::ekf::layout::{Base, Full, Layout};
    use hovernav::frames::Rotation;
    use hovernav::gps::Fix;
    use hovernav::imu::ImuSample;
    use hovernav::scalar::Scalar;
    use nalgebra::SMatrix;

    use super::fixtures::{self, Hover};

    // Boxed, so that passing a case copies a pointer.
    type Propagation<T, const N: usize> = Box<(Covariance<T, N>, Transition<T, N>)>;
    type Update<T, const N: usize> = Box<(Covariance<T, N>, [Sensitivity<T>; 3])>;
    type Flight<L, const N: usize, T> = Box<(Ekf<L, N, T>, Fix, Vec<ImuSample>)>;

    fn propagation<T: Scalar, const N: usize>() -> Propagation<T, N> {
        Box::new((fixtures::covariance::<T, N>(), fixtures::transition()))
    }

    fn update<T: Scalar, const N: usize>() -> Update<T, N> {
        Box::new((fixtures::covariance::<T, N>(), fixtures::arms()))
    }

    fn flight<L: Layout<N>, const N: usize, T: Scalar>() -> Flight<L, N, T> {
        Box::new(Hover::open().middle())
    }

    /// The four benchmarks of one layout and number type.
    macro_rules! layout {
        ($T:ty, $L:ty, $N:literal, $predict:ident, $update:ident, $imu:ident, $gps:ident) => {
            #[library_benchmark]
            #[bench::step(propagation::<$T, $N>())]
            fn $predict(mut case: Propagation<$T, $N>) -> Propagation<$T, $N> {
                let (p, step) = &mut *case;
                black_box(p).propagate(black_box(step));
                case
            }

            #[library_benchmark]
            #[bench::three_axes(update::<$T, $N>())]
            fn $update(mut case: Update<$T, $N>) -> Update<$T, $N> {
                let (p, arms) = &mut *case;
                fixtures::update::<$T, $L, $N>(black_box(p), black_box(arms));
                case
            }

            #[library_benchmark]
            #[bench::step(flight::<$L, $N, $T>())]
            fn $imu(mut case: Flight<$L, $N, $T>) -> Flight<$L, $N, $T> {
                let (filter, _, samples) = &mut *case;
                if let Some(sample) = samples.first() {
                    let _ = black_box(black_box(filter).predict(sample));
                }
                case
            }

            #[library_benchmark]
            #[bench::fix(flight::<$L, $N, $T>())]
            fn $gps(mut case: Flight<$L, $N, $T>) -> Flight<$L, $N, $T> {
                let (filter, fix, _) = &mut *case;
                let _ = black_box(black_box(filter).update_gps(fix));
                case
            }
        };
    }

    layout!(f64, Base, 16, predict_15_f64, update_15_f64, imu_15_f64, gps_15_f64);
    layout!(f32, Base, 16, predict_15_f32, update_15_f32, imu_15_f32, gps_15_f32);
    layout!(f64, Full, 28, predict_28_f64, update_28_f64, imu_28_f64, gps_28_f64);

    #[library_benchmark]
    #[bench::full(Hover::open())]
    fn whole_log(hover: Hover) -> Hover {
        black_box(&hover).run::<Full, 28, f64>();
        hover
    }

    #[library_benchmark]
    #[bench::step(Rotation::IDENTITY)]
    fn quaternion(
        body_to_ned: Rotation<hovernav::frames::Body, hovernav::frames::Ned>,
    ) -> Rotation<hovernav::frames::Body, hovernav::frames::Ned> {
        let (increment, frame) = (fixtures::INCREMENT_RAD, fixtures::FRAME_RAD);
        let turns = (black_box(increment).into(), black_box(frame).into());
        fixtures::turn(black_box(body_to_ned), turns.0, turns.1)
    }

    type Dense = Box<[SMatrix<f64, 15, 15>; 3]>;

    fn dense() -> Dense {
        Box::new([SMatrix::from_fn(|i, j| 1.0 / (1 + i + j) as f64); 3])
    }

    #[library_benchmark]
    #[bench::step(dense())]
    fn predict_15_dense(mut case: Dense) -> Dense {
        let [phi, p, q] = black_box(&mut *case);
        *p = *phi * *p * phi.transpose() + *q;
        case
    }

    #[library_benchmark]
    #[bench::three_axes(dense())]
    fn update_15_dense(mut case: Dense) -> Dense {
        let [source, p, _] = black_box(&mut *case);
        let h = source.fixed_rows::<3>(0).into_owned();
        let r = SMatrix::<f64, 3, 3>::identity();
        let k = *p * h.transpose() * (h * *p * h.transpose() + r).try_inverse().unwrap_or(r);
        let a = SMatrix::<f64, 15, 15>::identity() - k * h;
        *p = a * *p * a.transpose() + k * r * k.transpose();
        case
    }

    library_benchmark_group!(
        name = kernels,
        benchmarks = [
            predict_15_f64,
            predict_15_f32,
            predict_28_f64,
            predict_15_dense,
            update_15_f64,
            update_15_f32,
            update_28_f64,
            update_15_dense,
            quaternion
        ]
    );
    library_benchmark_group!(
        name = whole,
        benchmarks =
            [imu_15_f64, imu_15_f32, imu_28_f64, gps_15_f64, gps_15_f32, gps_28_f64, whole_log]
    );
    gungraun::main!(library_benchmark_groups = kernels, whole);

    pub fn run() {
        main();
    }
}
