//! Whether an estimator can find a heading in motion: chosen by type, as it takes memory.

use super::super::config::{EkfConfig, GpsModel};
use super::super::filter::Ekf;
use super::super::history::History;
use super::super::layout::Layout;
use super::super::measurement::{Report, Unusable};
use super::super::prediction::{ImuFault, Prediction};
use super::super::scalar::Scalar;
use super::super::solution::Solution;
use super::{BetterHeading, FoundHeading, HeadingSearch};
use crate::frames::{Body, Ned, Rotation, Vector};
use crate::gps::Fix;
use crate::imu::ImuSample;
use crate::ins::{Mounting, Start};
use crate::time::Time;

/// How an [`Estimator`](super::super::Estimator) finds a heading that nothing gives at the start:
/// [`HeadingSearch`], or not at all, [`NoHeadingSearch`]. Sealed.
pub trait HeadingMethod<T = f64>: sealed::Method<T> {}

/// No search, and no memory for one: alignment waits until a sensor, or the course where the
/// configuration names it, gives a heading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoHeadingSearch;

impl<T: Scalar> HeadingMethod<T> for HeadingSearch<T> {}
impl<T: Scalar> HeadingMethod<T> for NoHeadingSearch {}

pub(in super::super) mod sealed {
    use super::*;

    pub trait Method<T> {
        /// Whether there is a search.
        const SEARCHES: bool;
        fn unstarted(config: EkfConfig, mounting: Mounting) -> Self;
        fn start(&mut self, start: &Start, axis: Option<Vector<Ned>>);
        fn predict(&mut self, sample: &ImuSample) -> Result<Prediction, ImuFault>;
        fn update_gps(&mut self, fix: &Fix) -> Result<Report, Unusable>;
        fn update_baro(&mut self, time: Time, height_m: f64) -> Result<Report, Unusable>;
        fn found(&mut self) -> Option<FoundHeading<'_, T>>;
        /// The filter that leads, found or not.
        fn leading(&mut self) -> Option<FoundHeading<'_, T>>;
        /// The filter whose baseline points nearest to `heading_rad`.
        fn found_at(
            &mut self,
            baseline: Vector<Body>,
            heading_rad: f64,
        ) -> Option<FoundHeading<'_, T>>;
        fn solution(&self) -> Option<Solution<T>>;
        fn time(&self) -> Time;
        /// Searches about the heading of a filter that has lost it, to this one-sigma.
        fn reopen<L: Layout<N>, const N: usize>(&mut self, lost: &Ekf<L, N, T>, sigma_rad: f64);
        /// Whether headings are being searched.
        fn is_open(&self) -> bool;
        /// Ends the search and drops its filters; from now on monitors the heading of another filter, by its level.
        fn stop_and_monitor(&mut self, body_to_ned: Rotation<Body, Ned, T>);
        /// What the filter felt over a sample's interval, less bias.
        fn feel(&mut self, rate_radps: Vector<Body, T>, force_mps2: Vector<Body, T>, interval_s: T);
        /// A better heading than that of the filter, of this one-sigma, where the fixes bear out another one.
        fn better(
            &mut self,
            fix: &Fix,
            gps: &GpsModel,
            history: &History<T>,
            body_to_ned: Rotation<Body, Ned, T>,
            sigma_rad: T,
        ) -> Option<BetterHeading>;
        /// Whether motion of late bore out the heading that was judged last.
        fn bears_out(&self) -> bool;
    }
}

impl<T: Scalar> sealed::Method<T> for HeadingSearch<T> {
    const SEARCHES: bool = true;
    #[inline(always)]
    fn unstarted(config: EkfConfig, mounting: Mounting) -> Self {
        Self::unstarted(config, mounting)
    }
    fn start(&mut self, start: &Start, axis: Option<Vector<Ned>>) {
        self.start(start, axis);
    }
    fn predict(&mut self, sample: &ImuSample) -> Result<Prediction, ImuFault> {
        self.predict(sample)
    }
    fn update_gps(&mut self, fix: &Fix) -> Result<Report, Unusable> {
        self.update_gps(fix)
    }
    fn update_baro(&mut self, time: Time, height_m: f64) -> Result<Report, Unusable> {
        self.update_baro(time, height_m)
    }
    fn found(&mut self) -> Option<FoundHeading<'_, T>> {
        self.found()
    }
    fn leading(&mut self) -> Option<FoundHeading<'_, T>> {
        self.leading()
    }
    fn found_at(
        &mut self,
        baseline: Vector<Body>,
        heading_rad: f64,
    ) -> Option<FoundHeading<'_, T>> {
        self.found_at(baseline, heading_rad)
    }
    fn solution(&self) -> Option<Solution<T>> {
        self.solution()
    }
    fn time(&self) -> Time {
        self.time()
    }
    fn reopen<L: Layout<N>, const N: usize>(&mut self, lost: &Ekf<L, N, T>, sigma_rad: f64) {
        self.reopen(lost, sigma_rad);
    }
    fn is_open(&self) -> bool {
        self.is_open()
    }
    fn stop_and_monitor(&mut self, body_to_ned: Rotation<Body, Ned, T>) {
        self.stop_and_monitor(body_to_ned);
    }
    fn feel(&mut self, rate_radps: Vector<Body, T>, force_mps2: Vector<Body, T>, interval_s: T) {
        self.monitor.feel(rate_radps, force_mps2, interval_s);
    }
    fn better(
        &mut self,
        fix: &Fix,
        gps: &GpsModel,
        history: &History<T>,
        body_to_ned: Rotation<Body, Ned, T>,
        sigma_rad: T,
    ) -> Option<BetterHeading> {
        self.monitor.fix(fix, gps, history);
        self.monitor.judge(fix.time, body_to_ned, sigma_rad)
    }
    fn bears_out(&self) -> bool {
        self.monitor.bears_out()
    }
}

impl<T: Scalar> sealed::Method<T> for NoHeadingSearch {
    const SEARCHES: bool = false;
    fn unstarted(_: EkfConfig, _: Mounting) -> Self {
        Self
    }
    fn start(&mut self, _: &Start, _: Option<Vector<Ned>>) {}
    fn predict(&mut self, _: &ImuSample) -> Result<Prediction, ImuFault> {
        Ok(Prediction::Stepped)
    }
    fn update_gps(&mut self, _: &Fix) -> Result<Report, Unusable> {
        Err(Unusable::HeadingUnknown)
    }
    fn update_baro(&mut self, _: Time, _: f64) -> Result<Report, Unusable> {
        Err(Unusable::HeadingUnknown)
    }
    fn found(&mut self) -> Option<FoundHeading<'_, T>> {
        None
    }
    fn leading(&mut self) -> Option<FoundHeading<'_, T>> {
        None
    }
    fn found_at(&mut self, _: Vector<Body>, _: f64) -> Option<FoundHeading<'_, T>> {
        None
    }
    fn solution(&self) -> Option<Solution<T>> {
        None
    }
    fn time(&self) -> Time {
        Time::ZERO
    }
    fn reopen<L: Layout<N>, const N: usize>(&mut self, _: &Ekf<L, N, T>, _: f64) {}
    fn is_open(&self) -> bool {
        false
    }
    fn stop_and_monitor(&mut self, _: Rotation<Body, Ned, T>) {}
    fn feel(&mut self, _: Vector<Body, T>, _: Vector<Body, T>, _: T) {}
    fn better(
        &mut self,
        _: &Fix,
        _: &GpsModel,
        _: &History<T>,
        _: Rotation<Body, Ned, T>,
        _: T,
    ) -> Option<BetterHeading> {
        None
    }
    fn bears_out(&self) -> bool {
        false
    }
}
