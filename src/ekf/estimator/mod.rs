//! The whole estimator: alignment, heading search and filter, behind one call.

mod aids;
mod lost_heading;
mod lost_level;
mod notice;
mod own;
mod phase;
mod start;
mod waiting;

pub use notice::Notice;

use crate::earth::Geodetic;
use crate::ekf::filter::Ekf;
use crate::ekf::heading_search::{BetterHeading, HeadingMethod, HeadingSearch, Receiver};
use crate::ekf::kernel::layout::{ATTITUDE, Full, Layout, POSITION};
use crate::ekf::kernel::trace::Trace;
use crate::ekf::outcome::prediction::Prediction;
use crate::ekf::outcome::report::{Aid, Report, Unusable};
use crate::ekf::output::solution::Solution;
use crate::ekf::settings::config::AntennaHeadingModel;
use crate::ekf::settings::estimator_config::{Aiding, EstimatorConfig, Rangefinder};
use crate::ekf::watch::wheels::WheelWatch;
use crate::event::Event;
use crate::frames::Vector;
use crate::gps::Fix;
use crate::imu::ImuSample;
use crate::ins::Aligner;
use crate::matrix::square;
use crate::scalar::{Scalar, single};
use crate::setup::SetupCheck;
use crate::time::Time;
use phase::{Phase, TiltCheck};

/// Estimator from events to solutions: alignment, a heading search if necessary, then the filter.
///
/// `L`, `N` and `T` have the same meaning as in [`Ekf`]. `H` decides whether a heading that is unknown at the start is
/// searched for in motion.
///
/// # Memory
/// All memory is in the value itself. Nothing is allocated, and nothing large moves between phases. In a static it
/// takes
///
/// | estimator | bytes |
/// |---|---|
/// | `Estimator<Full, 28, f64, NoHeadingSearch>` | at most 16 200 |
/// | `Estimator<Full, 28, f64, HeadingSearch>`, the default | at most 21 100 |
/// | `Estimator<Full, 28, f32>`, in single precision | at most 15 000 |
/// | `Estimator<WithoutHeightAids, 26, f64, NoHeadingSearch>` | at most 15 300 |
///
/// and its calls at most 8 kB of stack.
///
/// # Examples
/// A minute at rest, facing north-east according to the inertial unit's own attitude:
///
/// ```
/// use hovernav::earth::Geodetic;
/// use hovernav::ekf::{Estimator, EstimatorConfig, Innovation, Notice};
/// use hovernav::event::Event;
/// use hovernav::frames::{EulerAngles, Vector};
/// use hovernav::gps::Fix;
/// use hovernav::imu::{ImuSample, Motion};
/// use hovernav::time::Time;
///
/// let mut estimator = Estimator::new(EstimatorConfig::default());
/// let place = Geodetic::from_degrees(48.1, 11.6, 520.0).ok_or("invalid position")?;
/// let mut fixes_used = 0;
/// for k in 0..3_000 {
///     let time = Time::from_nanoseconds(k * 20_000_000);
///     let at_rest = Motion::Rates {
///         angular_rate_radps: Vector::ZERO,
///         specific_force_mps2: Vector::new(0.0, 0.0, -9.807),
///     };
///     let attitude = Some(EulerAngles::from_degrees(0.0, 0.0, 45.0));
///     let sample = ImuSample { attitude, ..ImuSample::new(time, at_rest) };
///     // The report on a fix comes with the inertial samples that the fix waits for.
///     let mut notify = |notice| match notice {
///         Notice::Updated(report) => {
///             let of_fix = |axis: &Innovation| axis.channel.is_of_fix();
///             fixes_used += i32::from(report.innovations().any(of_fix) && report.any_accepted());
///         }
///         Notice::NotUsed { time, aid, reason } if reason.is_fault() => {
///             println!("{time}: {aid} not used: {reason}");
///         }
///         _ => {}
///     };
///     estimator.push(&Event::Imu(sample), &mut notify);
///     if k % 50 == 0 {
///         estimator.push(&Event::Gps(Fix::at(time, place)), &mut notify);
///     }
/// }
/// let solution = estimator.solution().ok_or("not aligned")?;
/// assert!(fixes_used > 55);
/// assert!((solution.body_to_ned.euler().yaw_rad.to_degrees() - 45.0).abs() < 1.0);
/// assert!(solution.velocity_mps.norm() < 0.1);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Debug)]
pub struct Estimator<L = Full, const N: usize = 28, T = f64, H = HeadingSearch<T>> {
    phase: Phase,
    setup: SetupCheck,
    aligner: Aligner,
    search: H,
    filter: Ekf<L, N, T>,
    aiding: Aiding,
    rangefinder: Rangefinder,
    antenna_heading: AntennaHeadingModel,
    waiting_fixes: [Option<Fix>; MAX_WAITING],
    /// Position, m, and velocity, m/s, horizontal and down, of the last fix.
    last_reported: Option<(Geodetic, Option<[f64; 2]>, Option<f64>)>,
    /// Whether the last fix is a repetition although the vehicle moves.
    is_frozen: bool,
    tilt_check: TiltCheck,
    wheels: WheelWatch,
    /// Time of the last suspect sample, which limits the rate of notices.
    suspected: Time,
}

/// Minimum one-sigma of a newly found heading, rad (10°): errors that the model lacks are common to all hypotheses.
const FOUND_SIGMA_RAD: f64 = 0.175;

/// Largest offset, s, between a measurement and the inertial samples; beyond it the clocks differ.
const OF_ONE_CLOCK_S: f64 = 10.0;
/// Speed, m/s, below which a repeated velocity may be correct.
const REPEATED_MPS: f64 = 0.2;
/// Longest time, s, between suspect samples of one event.
const SUSPECT_S: f64 = 1.0;
/// Number of fixes that may wait for the next inertial sample.
const MAX_WAITING: usize = 4;

impl Estimator {
    /// The default estimator, before its first event: all states, in `f64`, with a search for an unknown heading. Its
    /// type needs no annotation; for other choices see [`with_layout`](Self::with_layout).
    #[inline(always)]
    #[must_use]
    pub fn new(config: EstimatorConfig) -> Self {
        Self::with_layout(config)
    }

    /// [`push`](Self::push) of the default estimator, compiled in this crate and not again in each dependent crate.
    #[doc(hidden)]
    pub fn push_default(&mut self, event: &Event, notify: &mut dyn FnMut(Notice)) {
        self.process_event(event, &mut (), notify);
    }
}

impl<L: Layout<N>, const N: usize, T: Scalar, H: HeadingMethod<T>> Estimator<L, N, T, H> {
    /// An estimator before its first event. Its type chooses the states, the numeric type and the heading search.
    ///
    /// ```
    /// use hovernav::ekf::layout::WithoutHeightAids;
    /// use hovernav::ekf::{Estimator, EstimatorConfig, NoHeadingSearch};
    ///
    /// type Small = Estimator<WithoutHeightAids, 26, f32, NoHeadingSearch>;
    /// let estimator = Small::with_layout(EstimatorConfig::default());
    /// assert!(estimator.solution().is_none());
    /// ```
    // Built in place inside its caller, not on the stack and then copied.
    #[inline(always)]
    #[must_use]
    pub fn with_layout(config: EstimatorConfig) -> Self {
        Self {
            phase: Phase::Aligning,
            setup: SetupCheck::NEW,
            aligner: Aligner::new(config.alignment, config.mounting),
            search: H::new(),
            filter: Ekf::unstarted(config.ekf, config.mounting),
            aiding: config.aiding,
            rangefinder: config.rangefinder,
            antenna_heading: config.antenna_heading,
            waiting_fixes: [None; MAX_WAITING],
            last_reported: None,
            is_frozen: false,
            tilt_check: TiltCheck::Idle,
            wheels: WheelWatch::of(config.vehicle_kind),
            suspected: Time::NEVER,
        }
    }

    /// Processes the next event in order of arrival; `notify` receives the outcome.
    ///
    /// A fix is held until inertial samples up to 0.06 s after it have arrived. Then it is fused and its outcome is
    /// reported.
    pub fn push(&mut self, event: &Event, notify: impl FnMut(Notice)) {
        self.push_traced(event, &mut (), notify);
    }

    /// [`push`](Self::push), with the filter observed by `trace`.
    pub fn push_traced(
        &mut self,
        event: &Event,
        trace: &mut impl Trace<T, N>,
        mut notify: impl FnMut(Notice),
    ) {
        self.process_event(event, trace, &mut notify);
    }

    /// [`push_traced`](Self::push_traced), compiled once for all types of `notify`. Not inlined: a crate then uses the
    /// code that its dependency has compiled for the same type.
    #[inline(never)]
    fn process_event(
        &mut self,
        event: &Event,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        if let Some(fault) = self.setup.push(event) {
            notify(Notice::SetupSuspect { time: event.time(), fault });
        }
        if self.phase == Phase::Aligning {
            self.align(event, notify);
            return;
        }
        if H::SEARCHES && self.tilt_check == TiltCheck::Running && !matches!(event, Event::Gps(_)) {
            self.aligner.push(event);
        }
        match event {
            Event::Imu(sample) => self.imu(sample, trace, notify),
            Event::Gps(fix) => {
                if fix.time > self.filter.due_until() {
                    self.store_fix(fix, trace, notify);
                } else {
                    self.gps(fix, trace, notify);
                }
            }
            Event::Baro(reading) => self.barometer(reading, trace, notify),
            Event::Magnetometer(reading) => {
                self.magnetometer(reading.time, reading.field_gauss, trace, notify);
            }
            Event::AntennaHeading(heading) => self.antenna_heading(heading, trace, notify),
            Event::Range(reading) => self.range(reading, trace, notify),
        }
    }

    /// Adds the event to the alignment, and starts the filter from a finished one.
    // Not inlined, so that its local variables do not enlarge the caller's stack frame during other calls.
    #[inline(never)]
    fn align(&mut self, event: &Event, notify: &mut dyn FnMut(Notice)) {
        self.report_ignored(event, notify);
        let alignment = if H::SEARCHES {
            self.aligner.push(event)
        } else {
            self.aligner.push_as::<false>(event)
        };
        if let Some(alignment) = alignment {
            self.begin(&alignment, notify);
        }
    }

    /// The filter, for a measurement of the heading. Returns an error while the heading is unknown. A repeated search
    /// is an exception: the measurement can end it, unless roll and pitch were lost too.
    fn navigating(&mut self) -> Result<&mut Ekf<L, N, T>, Unusable> {
        let can_end_search = self.is_searching_again() && self.tilt_check != TiltCheck::Failed;
        if self.phase == Phase::Navigating || can_end_search {
            Ok(&mut self.filter)
        } else {
            Err(Unusable::HeadingUnknown)
        }
    }

    /// Checks the time of a measurement that is compared with the present state. A time from another clock would block
    /// all later measurements. Within a gap of the inertial samples the present state is unknown.
    fn check_time(&self, time: Time) -> Result<(), Unusable> {
        match self.filter.state.time - time {
            age_s if age_s > OF_ONE_CLOCK_S => Err(Unusable::TooOld),
            age_s if age_s < -self.filter.config.imu.gap_s => Err(Unusable::AheadOfImu),
            _ => Ok(()),
        }
    }

    // Not inlined, so that its local variables do not enlarge the caller's stack frame during other calls.
    #[inline(never)]
    fn imu(
        &mut self,
        sample: &ImuSample,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        let before = self.filter.state.time;
        if sample.time - before > self.filter.config.imu.gap_s {
            self.fuse_waiting(before, trace, notify);
        }
        let time = sample.time;
        match self.filter.predict_traced(sample, trace) {
            Ok(Prediction::Stepped) => {
                if self.filter.samples.suspicion.hides_motion() {
                    self.interrupt_search();
                } else {
                    self.observe_sample(sample, time.seconds_since(before));
                }
            }
            Ok(Prediction::BridgedGap { length_s }) => {
                self.search_again(time, length_s);
                notify(Notice::GapBridged { time, length_s });
            }
            Ok(Prediction::Reset(cause)) => {
                self.search_again(time, time - before);
                notify(Notice::CovarianceReset { time, cause });
            }
            Err(fault) => {
                notify(Notice::SampleRejected { time, fault });
                return;
            }
        }
        if let Some(report) = self.filter.update_at_rest(trace) {
            notify(Notice::Updated(report));
        }
        if L::WHEELS && self.filter.config.mechanisms.wheels && self.phase == Phase::Navigating {
            self.constrain_to_road(trace, notify);
        }
        let suspicion = &self.filter.samples.suspicion;
        if self.phase == Phase::Navigating && suspicion.is_suspect() {
            if time - self.suspected > SUSPECT_S {
                let suspicion = suspicion.cast();
                notify(Notice::SampleSuspect { time, suspicion });
            }
            self.suspected = time;
        }
        self.fuse_waiting(self.filter.due_until(), trace, notify);
        if let Some(angles) = sample.attitude.filter(|_| self.aiding.attitude) {
            self.attitude(sample.time, angles, sample.magnetic_field_gauss, trace, notify);
        } else if let Some(field) = sample.magnetic_field_gauss {
            self.magnetometer(sample.time, field, trace, notify);
        }
    }

    /// Applies the wheel constraint while fixes are absent, and reports its start and its end.
    #[inline(never)]
    fn constrain_to_road(&mut self, trace: &mut impl Trace<T, N>, notify: &mut dyn FnMut(Notice)) {
        if let Some(report) = self.filter.update_on_wheels(&mut self.wheels, trace) {
            notify(Notice::Updated(report));
        }
        let time = self.filter.state.time;
        match self.wheels.next_report() {
            Some(true) => {
                let sigma_mps = f64::from(self.wheels.sigma_mps());
                notify(Notice::WheelConstraintOn { time, sigma_mps });
            }
            Some(false) => notify(Notice::WheelConstraintOff { time }),
            None => {}
        }
    }

    /// Feeds a sample to the heading search and to the wheel monitor.
    fn observe_sample(&mut self, sample: &ImuSample, interval_s: T) {
        let mean = sample.motion.cast().mean_rates(interval_s);
        let errors = self.filter.imu_errors();
        let force_mps2 = mean.specific_force_mps2 - errors.accel_bias_mps2;
        if L::WHEELS {
            let [forward, right, _] = force_mps2.to_array();
            self.wheels.observe_sample([single(forward), single(right)], single(interval_s));
        }
        if let Some(search) = self.search.bank() {
            let rate_radps = mean.angular_rate_radps - errors.gyro_bias_radps;
            let variances = self.filter.memory.step_variances;
            search.observe_sample(rate_radps, force_mps2, variances, interval_s);
        }
    }

    /// Starts the heading search again after samples that hid the motion: see [`HeadingSearch::interrupt`].
    pub(super) fn interrupt_search(&mut self) {
        if let Some(search) = self.search.bank() {
            search.interrupt(self.filter.state.body_to_ned);
        }
    }

    /// Monitors the heading of the filter from the next fix on.
    fn monitor_heading(&mut self) {
        if let Some(search) = self.search.bank() {
            search.monitor(self.filter.state.body_to_ned);
        }
    }

    /// Whether a fix repeats position and velocity of the previous one bit for bit during motion. Motion means that the
    /// horizontal velocity of the fix exceeds [`REPEATED_MPS`], or the filter's speed exceeds it by three one-sigmas. A
    /// receiver at rest may repeat itself.
    fn repeats(&mut self, fix: &Fix) -> bool {
        let reported = Some((fix.position, fix.horizontal_velocity_mps, fix.down_velocity_mps));
        if core::mem::replace(&mut self.last_reported, reported) != reported {
            self.is_frozen = false;
            return false;
        }
        let moves = level_square(fix).is_some_and(|squared| squared > square(REPEATED_MPS));
        self.is_frozen |=
            moves || self.solution().is_some_and(|solution| solution.moves(REPEATED_MPS));
        self.is_frozen
    }

    #[inline(never)]
    fn gps(&mut self, fix: &Fix, trace: &mut impl Trace<T, N>, notify: &mut dyn FnMut(Notice)) {
        let mechanisms = self.filter.config.mechanisms;
        if self.repeats(fix) && mechanisms.repeated_fixes {
            notify(Notice::of_update(fix.time, Aid::Gps, Err(Unusable::Repeated)));
            return;
        }
        let mut report = Report::default();
        let searches = self.phase == Phase::Searching;
        let result = if searches {
            self.filter.fuse_position(fix, &mut report, trace)
        } else {
            self.filter.fuse_gps(fix, &mut report, trace)
        };
        if L::WHEELS && !searches && report.any_accepted() && !report.any_rejected() {
            self.filter.watch_wheels(&mut self.wheels);
        }
        notify(Notice::of_report(fix.time, Aid::Gps, result, &report));
        if let Some((offset_m, sigma_m)) = self.filter.memory.antenna.next_report() {
            let (offset_m, sigma_m) = (offset_m.cast(), f64::from(sigma_m));
            notify(Notice::AntennaOffsetFound { time: fix.time, offset_m, sigma_m });
        }
        if report.contradicts_itself() {
            return;
        }
        if let Some(search) = self.search.bank() {
            let filter = &self.filter;
            let receiver = Receiver {
                model: &filter.config.gps,
                sigmas: filter.fix_sigmas(fix),
                position_scatter: filter.memory.position_scatter.share(),
                antenna: filter.mounting.antenna_from_imu().cast(),
                bias_radps: filter.imu_errors().gyro_bias_radps,
            };
            search.fix(fix, &receiver, &filter.history);
        }
        if searches {
            self.follow_search(trace, notify);
        } else {
            self.watch_heading(fix, trace, notify);
        }
        let is_confirmed = self.search.bank().is_some_and(|search| search.is_confirmed());
        self.filter.memory.gates.heading_is_consistent =
            is_confirmed && mechanisms.confirmed_heading;
        self.monitor_tilt(fix, &report, trace, notify);
    }

    #[inline(never)]
    fn watch_heading(
        &mut self,
        fix: &Fix,
        trace: &mut impl Trace<T, N>,
        notify: &mut dyn FnMut(Notice),
    ) {
        let filter = &mut self.filter;
        filter.catch_up(trace);
        let heading = ATTITUDE + 2;
        let own_sigma_rad = filter.covariance.value(heading, heading).max(T::ZERO).sqrt();
        let body_to_ned = filter.state.body_to_ned;
        let search = self.search.bank();
        let better = search.and_then(|search| search.judge(fix.time, body_to_ned, own_sigma_rad));
        let Some(better) = better.filter(|_| filter.config.mechanisms.heading_monitor) else {
            return;
        };
        let BetterHeading { turn_rad, sigma_rad, replaces } = better;
        if !replaces {
            filter.suspect_heading(turn_rad, trace);
            notify(Notice::HeadingSuspect { time: fix.time, off_rad: turn_rad, sigma_rad });
            return;
        }
        let sigma_rad = sigma_rad.max(FOUND_SIGMA_RAD);
        filter.turn_heading(fix.time, turn_rad, sigma_rad);
        self.wheels.forget();
        trace.reset(ATTITUDE..POSITION);
        if let Some(heading) = L::ATTITUDE_REFERENCE.map(|first| first + 2) {
            trace.reset(heading..heading + 1);
        }
        self.monitor_heading();
        trace.turned(Vector::new(0.0, 0.0, turn_rad));
        notify(Notice::HeadingReset { time: fix.time, turn_rad, sigma_rad });
    }

    /// The filter, after alignment and heading search.
    #[must_use]
    pub fn filter(&self) -> Option<&Ekf<L, N, T>> {
        (self.phase == Phase::Navigating).then_some(&self.filter)
    }

    /// The present solution, in the numeric type of the estimator; `None` until alignment ends.
    #[must_use]
    // Compiled once, with a stack frame of its own, because it is long.
    #[inline(never)]
    pub fn solution(&self) -> Option<Solution<T>> {
        (self.phase != Phase::Aligning).then(|| self.filter.solution())
    }
}

/// The square of the horizontal speed that a fix reports, (m/s)².
fn level_square(fix: &Fix) -> Option<f64> {
    fix.horizontal_velocity_mps.map(|[north, east]| square(north) + square(east))
}
