//! Choice of the heading search by type, because the search takes memory.

use super::super::history::History;
use super::super::scalar::Scalar;
use super::{BetterHeading, GuessedMotion, HeadingSearch, Receiver};
use crate::frames::{Body, Ned, Rotation, Vector};
use crate::gps::Fix;
use crate::ins::Start;
use crate::time::Time;

/// Method by which an [`Estimator`](super::super::Estimator) finds the heading if no source gives it at the start:
/// [`HeadingSearch`], or [`NoHeadingSearch`] without a search. Sealed.
pub trait HeadingMethod<T = f64>: sealed::Method<T> {}

/// No search and no memory for one. Alignment waits for a heading from a sensor, or from the course if the
/// configuration names it as source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoHeadingSearch;

impl<T: Scalar> HeadingMethod<T> for HeadingSearch<T> {}
impl<T: Scalar> HeadingMethod<T> for NoHeadingSearch {}

pub(in super::super) mod sealed {
    use super::*;

    /// Interface of the search; the default implementations do not search.
    pub trait Method<T>: Sized {
        /// Whether the method searches.
        const SEARCHES: bool;
        fn new() -> Self;
        /// Searches all headings from a start whose attitude about `axis` is unknown. `bias_sigma_radps` is the
        /// one-sigma of the gyro bias, rad/s, unless the start states one.
        fn start(&mut self, _start: &Start, _axis: Vector<Ned>, _bias_sigma_radps: f64) {}
        /// Searches about a heading of one-sigma `sigma_rad`, with the one-sigmas of tilt, rad, and gyro bias, rad/s,
        /// in `others`.
        fn start_about(
            &mut self,
            _body_to_ned: Rotation<Body, Ned, T>,
            _sigma_rad: f64,
            _others: [f64; 2],
        ) {
        }
        /// Monitors a heading from the next fix on.
        fn monitor(&mut self, _body_to_ned: Rotation<Body, Ned, T>) {}
        /// Adds an inertial sample, less bias, whose noise adds `variances` to angle, rad², and velocity, (m/s)².
        fn observe_sample(
            &mut self,
            _rate_radps: Vector<Body, T>,
            _force_mps2: Vector<Body, T>,
            _variances: [T; 2],
            _interval_s: T,
        ) {
        }
        /// Changes the weights of the hypotheses by a fix.
        fn fix(&mut self, _fix: &Fix, _receiver: &Receiver<'_, T>, _history: &History<T>) {}
        /// Motion according to the best hypothesis; `None` before a first fix.
        fn motion(&mut self) -> Option<GuessedMotion<T>> {
            None
        }
        /// Motion according to the hypothesis whose baseline points to `heading_rad`.
        fn motion_at(
            &mut self,
            _baseline: Vector<Body>,
            _heading_rad: f64,
        ) -> Option<GuessedMotion<T>> {
            None
        }
        /// A heading better than that of the filter, whose one-sigma is `sigma_rad`; `Some` if the fixes confirm
        /// another heading.
        fn better(
            &mut self,
            _time: Time,
            _body_to_ned: Rotation<Body, Ned, T>,
            _sigma_rad: T,
        ) -> Option<BetterHeading> {
            None
        }
        /// Whether recent motion confirmed the last judged heading.
        fn is_confirmed(&self) -> bool {
            false
        }
    }
}

impl<T: Scalar> sealed::Method<T> for HeadingSearch<T> {
    const SEARCHES: bool = true;
    #[inline(always)]
    fn new() -> Self {
        Self::empty()
    }
    fn start(&mut self, start: &Start, axis: Vector<Ned>, bias_sigma_radps: f64) {
        self.start(start, axis, bias_sigma_radps);
    }
    fn start_about(
        &mut self,
        body_to_ned: Rotation<Body, Ned, T>,
        sigma_rad: f64,
        others: [f64; 2],
    ) {
        self.start_about(body_to_ned, sigma_rad, others);
    }
    fn monitor(&mut self, body_to_ned: Rotation<Body, Ned, T>) {
        self.monitor(body_to_ned);
    }
    fn observe_sample(
        &mut self,
        rate_radps: Vector<Body, T>,
        force_mps2: Vector<Body, T>,
        variances: [T; 2],
        interval_s: T,
    ) {
        self.observe_sample(rate_radps, force_mps2, variances, interval_s);
    }
    #[inline(never)]
    fn fix(&mut self, fix: &Fix, receiver: &Receiver<'_, T>, history: &History<T>) {
        self.fix(fix, receiver, history);
    }
    #[inline(never)]
    fn motion(&mut self) -> Option<GuessedMotion<T>> {
        self.motion()
    }
    #[inline(never)]
    fn motion_at(&mut self, baseline: Vector<Body>, heading_rad: f64) -> Option<GuessedMotion<T>> {
        self.motion_at(baseline, heading_rad)
    }
    fn better(
        &mut self,
        time: Time,
        body_to_ned: Rotation<Body, Ned, T>,
        sigma_rad: T,
    ) -> Option<BetterHeading> {
        self.judge(time, body_to_ned, sigma_rad)
    }
    fn is_confirmed(&self) -> bool {
        self.judgement.is_confirmed
    }
}

impl<T: Scalar> sealed::Method<T> for NoHeadingSearch {
    const SEARCHES: bool = false;
    fn new() -> Self {
        Self
    }
}
