//! Heading found in motion when nothing gives it at the start.
//!
//! An error-state filter linearises, and no linearisation holds over an unknown heading. So the
//! circle is cut into sectors, each with a filter of its own. They all fly the same samples; the fixes
//! tell them apart, because only the right heading makes horizontal specific force agree with the
//! change of GPS velocity. Each is weighted by the likelihood of its fixes (a Gaussian sum); those
//! that lose are dropped, and when those left agree, the heading is found.
//!
//! # Memory
//! What the filters have in common, a shared filter holds once: settings, samples, the
//! history of increments. It steps for one sector after the other, each of which keeps only what is its own, half a
//! covariance among it. A fix that is older than a sector's own newest entries of the history, about
//! two samples, is looked back for through those of the sector that stepped last: biases differ between
//! sectors by so little that a GPS does not see it.
//!
//! # Time
//! A fix is taken in by one sector after the other, over the samples that follow it (`turns.rs`), and the
//! sectors are weighed when all have it.
//!
//! # Source
//! D. L. Alspach and H. W. Sorenson (1972), Nonlinear Bayesian estimation using Gaussian sum
//! approximations, *IEEE Transactions on Automatic Control* 17 (4), 439–448.

mod method;
mod mixture;
mod monitor;
mod sector;
mod turns;

pub use method::{HeadingMethod, NoHeadingSearch};
use mixture::Wander;
pub(super) use monitor::BetterHeading;
use monitor::Monitor;

use super::config::{EkfConfig, GpsModel};
use super::covariance::PackedCovariance;
use super::filter::{Ekf, Samples};
use super::gate::Group;
use super::history::Cursor;
use super::layout::{ATTITUDE, Layout, WithBarometer};
use super::measurement::{Report, Unusable};
use super::prediction::{ImuFault, Prediction};
use super::scalar::Scalar;
use super::square;
use crate::frames::{Body, Ned, Rotation, Vector, wrap_angle};
use crate::gps::Fix;
use crate::imu::ImuSample;
use crate::ins::{Mounting, Start};
use crate::time::Time;
use sector::Sector;
use turns::Waiting;

/// The filter of a sector, and the length of its state vector.
type SectorEkf<T> = Ekf<WithBarometer, STATES, T>;
const STATES: usize = PackedCovariance::STATES;

/// Number of sectors.
const SECTORS: usize = 12;
/// One-sigma of heading within a sector, rad: neighbours overlap at one sigma.
const SECTOR_SIGMA_RAD: f64 = core::f64::consts::PI / SECTORS as f64;
/// A sector whose weight falls below this is dropped.
const LEAST_WEIGHT: f64 = 1e-4;
/// The heading is found when its one-sigma over all sectors left is under this, rad.
const FOUND_RAD: f64 = 0.14;
/// Least speed, m/s, at fixes one second apart, before a heading counts as found; it goes with the
/// square root of the time between fixes. A vehicle that is carried, pushed or turned by hand moves
/// its unit in ways that slow fixes do not show, and the sectors agree on a wrong heading.
const FOUND_SPEED_MPS: f64 = 5.0;

/// Until then a heading is less sure than this, rad, whatever the sectors agree on: three of it are the circle.
const UNPROVEN_RAD: f64 = 1.05;

/// A slower vehicle's heading counts as found when the monitor agrees within this, rad, for so long, s.
const BORNE_OUT_RAD: f64 = 0.26;
const BORNE_OUT_S: f64 = 5.0;

/// A heading of two antennas is not believed where the fixes leave it less than this share of the
/// best sector's weight.
const LEAST_SHARE: f64 = 0.01;

/// A heading that is less likely than this share of the likeliest is not searched where one was known.
const LEAST_PRIOR: f64 = 0.001;

/// What the one-sigma of a fix is multiplied by for filters that have no states for its slow errors.
const WHITENED: f64 = 1.7;

/// A bank of filters that differ in heading.
#[derive(Clone, Debug)]
pub struct HeadingSearch<T = f64> {
    sectors: [Option<Sector<T>>; SECTORS],
    /// Steps for each sector in turn.
    filter: SectorEkf<T>,
    last_fix: Option<Time>,
    /// The fix that not all sectors have taken in yet.
    waiting: Option<Waiting>,
    /// Whether the sectors have been weighed since the heading was last asked for.
    weighed: bool,
    /// Time between the last two samples, s.
    sample_s: f64,
    /// Whether the vehicle has been fast enough for its heading to count as found.
    fast: bool,
    /// Since when the monitor has borne out the leader.
    borne_out: Option<Time>,
    /// The sector that took in the last barometric height after the leader.
    next_height: u8,
    /// What wanders of the last fix, which no sector has states for.
    wander: Wander,
    /// Watches the heading once there is one.
    monitor: Monitor<T>,
}

impl HeadingSearch {
    /// Where the filter of one sector starts when the search starts at `start`, open about `axis`; sectors are counted
    /// clockwise from the start's heading.
    ///
    /// # Source
    /// Equation (H1) of docs/equations.md.
    #[must_use]
    pub fn sector_start(mut start: Start, axis: Vector<Ned>, sector: usize) -> Start {
        let turn = axis * (2.0 * SECTOR_SIGMA_RAD * sector as f64);
        let [tilt_rad, ..] = start.attitude_sigma_rad.to_array();
        start.state.body_to_ned = start.state.body_to_ned.turned_in_to(turn);
        let sigma = |along: f64| {
            let share = square(along);
            Scalar::sqrt(square(tilt_rad) * (1.0 - share) + square(SECTOR_SIGMA_RAD) * share)
        };
        let [north, east, down] = axis.to_array();
        start.attitude_sigma_rad = Vector::new(sigma(north), sigma(east), sigma(down));
        start
    }
}

impl<T: Scalar> HeadingSearch<T> {
    /// A search that is still to start.
    // As a part of its caller it is put together where the caller keeps it; so are its own parts.
    #[inline(always)]
    pub(super) fn unstarted(mut config: EkfConfig, mounting: Mounting) -> Self {
        // A sector keeps no sum of steps: the filter that goes from one to the next propagates at every sample.
        config.imu.covariance_interval_s = 0.0;
        Self {
            sectors: core::array::from_fn(|_| None),
            filter: Ekf::unstarted(config, mounting),
            last_fix: None,
            waiting: None,
            weighed: false,
            sample_s: 0.0,
            fast: false,
            borne_out: None,
            next_height: 0,
            wander: Wander::NONE,
            monitor: Monitor::none(),
        }
    }

    /// Starts, in place, to search all around from a start of unknown heading, open about `axis`; one whose heading is
    /// known, without an axis, is all that there is.
    pub(super) fn start(&mut self, start: &Start, axis: Option<Vector<Ned>>) {
        (self.last_fix, self.fast, self.borne_out) = (None, false, None);
        (self.waiting, self.weighed) = (None, false);
        self.monitor.restart(start.state.body_to_ned.cast());
        let Some(axis) = axis else {
            self.sectors.fill_with(|| None);
            self.filter.restart(start);
            if let Some(first) = self.sectors.first_mut() {
                first.insert(Sector::new(1.0)).store(&self.filter);
            }
            return;
        };
        for (sector, slot) in self.sectors.iter_mut().enumerate() {
            self.filter.restart(&HeadingSearch::sector_start(*start, axis, sector));
            slot.insert(Sector::new(1.0 / SECTORS as f64)).store(&self.filter);
        }
    }

    /// Starts, in place, to search about the heading of a filter that has lost it, to a one-sigma of `sigma_rad`.
    ///
    /// # Source
    /// Equation (H6) of docs/equations.md.
    // Its frame need not stand beneath a sample that comes without a gap.
    #[inline(never)]
    pub(super) fn reopen<L: Layout<N>, const N: usize>(
        &mut self,
        lost: &Ekf<L, N, T>,
        sigma_rad: f64,
    ) {
        let variance = square(sigma_rad).max(f64::MIN_POSITIVE);
        (self.last_fix, self.fast, self.borne_out) = (None, true, None);
        (self.waiting, self.weighed) = (None, false);
        self.monitor.restart(lost.state.body_to_ned);
        let mut sum = 0.0;
        for (sector, slot) in self.sectors.iter_mut().enumerate() {
            let turn_rad = wrap_angle(2.0 * SECTOR_SIGMA_RAD * sector as f64);
            let weight = libm::exp(-0.5 * square(turn_rad) / variance);
            if weight < LEAST_PRIOR {
                *slot = None;
                continue;
            }
            sum += weight;
            let filter = &mut self.filter;
            filter.continue_from(lost);
            let turn = Vector::new(T::ZERO, T::ZERO, T::of(turn_rad));
            filter.state.body_to_ned = filter.state.body_to_ned.turned_in_to(turn);
            filter.covariance.set_variance(ATTITUDE + 2, square(SECTOR_SIGMA_RAD));
            slot.insert(Sector::new(weight)).store(filter);
        }
        for sector in self.sectors.iter_mut().flatten() {
            sector.weight /= sum;
        }
    }

    /// Whether headings are being searched.
    pub(super) fn is_open(&self) -> bool {
        self.sectors.iter().any(Option::is_some)
    }

    /// Ends the search and drops its filters; from now on monitors the heading of another filter, by its level.
    pub(super) fn stop_and_monitor(&mut self, body_to_ned: Rotation<Body, Ned, T>) {
        self.sectors.fill_with(|| None);
        self.waiting = None;
        self.monitor.restart(body_to_ned);
    }

    /// Advances every filter to the next inertial sample, and lets some take in the fix that waits.
    ///
    /// # Errors
    /// As [`Ekf::predict`]; all filters judge a sample alike.
    // Its frame, and that of the filter's step, need not stand beneath a fix that waited for the sample.
    #[inline(never)]
    pub(super) fn predict(&mut self, sample: &ImuSample) -> Result<Prediction, ImuFault> {
        let before = self.filter.state.time;
        if sample.time - before > self.filter.config.imu.gap_s {
            self.finish_turns();
        }
        let verdict = self.predict_all(sample)?;
        match verdict {
            Prediction::Stepped => {
                let interval_s: T = sample.time.seconds_since(before);
                self.sample_s = interval_s.wide();
                if self.filter.samples.suspicion.hides_motion() {
                    self.monitor.restart(self.filter.state.body_to_ned);
                } else {
                    let mean = sample.motion.cast().mean_rates(interval_s);
                    let errors = self.filter.imu_errors();
                    let rate = mean.angular_rate_radps - errors.gyro_bias_radps;
                    self.monitor.feel(rate, mean.specific_force_mps2, interval_s);
                }
            }
            _ => self.monitor.restart(self.filter.state.body_to_ned),
        }
        self.take_turns();
        Ok(verdict)
    }

    /// Lets the shared filter take a sample as each sector in turn.
    // Its frame need not stand beneath a fix that a sector takes in.
    #[inline(never)]
    fn predict_all(&mut self, sample: &ImuSample) -> Result<Prediction, ImuFault> {
        let mut verdict = Prediction::Stepped;
        let Samples { integrator, self_contradiction, .. } = self.filter.samples;
        let mut watched = self.filter.samples;
        let before: Cursor<T> = self.filter.history.cursor();
        let mut forgotten = false;
        for sector in self.sectors.iter_mut().flatten() {
            let filter = &mut self.filter;
            filter.history.set_cursor(before);
            filter.samples = watched;
            sector.load(filter);
            verdict = filter.predict(sample)?;
            if watched.watched != filter.samples.watched {
                // What the first has found the others need not look for; what they integrate is their own.
                watched = Samples { integrator, self_contradiction, ..filter.samples };
            }
            filter.update_at_rest(&mut ());
            sector.store(filter);
            forgotten |= filter.history.is_empty();
        }
        // A reset of one clears the history of all.
        if forgotten {
            self.filter.history.clear();
        }
        Ok(verdict)
    }

    /// Takes a fix into the filter that leads, whose report is given; the others follow with the next
    /// samples. The fix before is done first.
    ///
    /// # Errors
    /// As [`Ekf::update_gps`].
    #[inline(never)]
    pub(super) fn update_gps(&mut self, fix: &Fix) -> Result<Report, Unusable> {
        self.finish_turns();
        let interval_s = self.last_fix.map_or(1.0, |last| (fix.time - last).clamp(0.05, 10.0));
        self.last_fix = Some(fix.time);
        let fast_mps = FOUND_SPEED_MPS * Scalar::sqrt(interval_s);
        let told = fix.horizontal_velocity_mps;
        self.fast |= told.is_some_and(|[north, east]| Scalar::hypot(north, east) > fast_mps);
        let (gps, mounting) = (self.filter.config.gps, self.filter.mounting);
        let shares = information_shares(fix, &gps, interval_s);
        let wider = whitened(fix, &gps);
        let leader = self.leader();
        let sector = self.sectors.get_mut(leader).and_then(Option::as_mut);
        let report = sector
            .ok_or(Unusable::NoState)?
            .lend(&mut self.filter, |filter| filter.update_gps(&wider))?;
        if report.contradicts_itself() {
            return Ok(report);
        }
        // A receiver without velocity: that of its places, by the filter that leads.
        self.fast |= told.is_none()
            && self.best().is_some_and(|best| best.solution(&mounting).moves(fast_mps));
        self.monitor.fix(fix, &gps, &self.filter.history);
        self.wander = Wander::of(self.filter.fix_sigmas(fix), &gps);
        // One that came late is soon older than what is remembered.
        let left_s = interval_s.min(self.filter.history.remembers_for_s(fix.time));
        let mut waiting = Waiting::new(wider, shares, left_s, self.sample_s);
        waiting.told(leader, report.minus_two_log_likelihood(shares));
        self.waiting = Some(waiting);
        if left_s < 2.0 * self.sample_s {
            self.finish_turns();
        }
        Ok(report)
    }

    /// Takes a barometric height, m, into the sector that leads, whose report is given, and into another in turn: height
    /// needs no heading.
    ///
    /// # Errors
    /// As [`Ekf::update_baro`].
    #[inline(never)]
    pub(super) fn update_baro(&mut self, time: Time, height_m: f64) -> Result<Report, Unusable> {
        let open = self.sectors.iter().flatten().count();
        let elapsed_s = open as f64 * self.filter.gates.since_accepted_s(Group::Baro, time);
        let leader = self.leader();
        let sector = self.sectors.get_mut(leader).and_then(Option::as_mut);
        let report = sector
            .ok_or(Unusable::NoState)?
            .lend(&mut self.filter, |filter| filter.update_baro(time, height_m, &mut ()))?;
        let next = (usize::from(self.next_height) + 1) % SECTORS;
        self.next_height = next as u8;
        if let Some(Some(sector)) = self.sectors.get_mut(next).filter(|_| next != leader) {
            sector.lend(&mut self.filter, |filter| filter.follow_baro(time, height_m, elapsed_s));
        }
        Ok(report)
    }

    /// Asks the monitor about the leader.
    fn bear_out(&mut self, time: Time) {
        let off = self.best().and_then(|best| self.monitor.off(best.state().body_to_ned));
        let agrees = off.is_some_and(|off| libm::fabs(off.turn_rad) < BORNE_OUT_RAD);
        self.borne_out = if agrees { self.borne_out.or(Some(time)) } else { None };
    }

    /// Whether the motion so far can tell a heading.
    fn is_proven(&self) -> bool {
        self.fast || self.is_borne_out()
    }

    /// Whether the monitor has borne out the leader for long enough.
    fn is_borne_out(&self) -> bool {
        let since = self.borne_out.zip(self.last_fix);
        since.is_some_and(|(since, now)| now - since >= BORNE_OUT_S)
    }

    fn best(&self) -> Option<&Sector<T>> {
        self.sectors.iter().flatten().max_by(|a, b| a.weight.total_cmp(&b.weight))
    }

    /// The last inertial sample's time.
    pub(super) const fn time(&self) -> Time {
        self.filter.state.time
    }

    /// The best filter, once the heading is found: the sectors left agree, and the vehicle has been
    /// fast enough for its motion to tell. Asked once of every fix that they have been weighed by.
    pub(super) fn found(&mut self) -> Option<FoundHeading<'_, T>> {
        if !core::mem::take(&mut self.weighed) {
            return None;
        }
        let sigma_rad = self.heading_sigma_rad();
        if !(self.is_proven() && sigma_rad < FOUND_RAD) {
            return None;
        }
        let sector = self.leader();
        self.sectors.get(sector)?.as_ref()?.load(&mut self.filter);
        Some(FoundHeading { filter: &self.filter, sector, sigma_rad, wander: self.wander.sigmas() })
    }

    /// The filter that leads, whatever the others say; none where none is left.
    pub(super) fn leading(&mut self) -> Option<FoundHeading<'_, T>> {
        self.finish_turns();
        let sigma_rad = self.heading_sigma_rad();
        let sector = self.leader();
        self.sectors.get(sector)?.as_ref()?.load(&mut self.filter);
        Some(FoundHeading { filter: &self.filter, sector, sigma_rad, wander: self.wander.sigmas() })
    }

    /// The filter in whose attitude a baseline of the body points nearest to `heading_rad`, clockwise from
    /// north; none where the fixes have spoken against it.
    pub(super) fn found_at(
        &mut self,
        baseline: Vector<Body>,
        heading_rad: f64,
    ) -> Option<FoundHeading<'_, T>> {
        self.finish_turns();
        let most = self.best()?.weight;
        let off = |sector: &Sector<T>| {
            let heading = (sector.state().body_to_ned * baseline.cast()).azimuth_rad().wide();
            libm::fabs(wrap_angle(heading_rad - heading))
        };
        let near = self.sectors.iter().zip(0..).filter_map(|(slot, number)| {
            let sector = slot.as_ref().filter(|sector| sector.weight > LEAST_SHARE * most)?;
            Some((off(sector), number)).filter(|(off, _)| *off < 2.0 * SECTOR_SIGMA_RAD)
        });
        let (_, sector) = near.min_by(|a, b| a.0.total_cmp(&b.0))?;
        self.sectors.get(sector)?.as_ref()?.load(&mut self.filter);
        let (sigma_rad, wander) = (SECTOR_SIGMA_RAD, self.wander.sigmas());
        Some(FoundHeading { filter: &self.filter, sector, sigma_rad, wander })
    }

    /// The number of the sector that leads, counted clockwise from the start's heading.
    fn leader(&self) -> usize {
        let leads = |slot: &Option<Sector<T>>| slot.as_ref().map_or(0.0, |sector| sector.weight);
        (0..SECTORS)
            .zip(&self.sectors)
            .max_by(|a, b| leads(a.1).total_cmp(&leads(b.1)))
            .map_or(0, |(sector, _)| sector)
    }
}

/// What a search has found.
#[derive(Debug)]
pub struct FoundHeading<'a, T> {
    pub filter: &'a SectorEkf<T>,
    pub sector: usize,
    pub sigma_rad: f64,
    /// One-sigmas of what the fixes' errors have of wander: position level and vertical, m, and velocity, m/s.
    pub wander: [f64; 4],
}

/// Which share of its information a fix's position and velocity add to the weights. A share s of the
/// one-sigma that wanders with correlation time τ weighs, at fixes Δt apart, like white noise of
/// variance s² 2τ/Δt: without this a vehicle at rest would find a heading in the wander of its GPS.
/// Where there is a velocity, position adds nothing of its own.
///
/// # Source
/// Equation (H3) of docs/equations.md.
fn information_shares(fix: &Fix, gps: &GpsModel, interval_s: f64) -> [f64; 2] {
    let wander = square(gps.velocity_wander_share) * 2.0 * gps.velocity_wander_time_s / interval_s;
    let share = (square(WHITENED) / (1.0 + wander)).min(1.0);
    if fix.horizontal_velocity_mps.is_some() { [0.0, share] } else { [share, 0.0] }
}

/// The fix with a part of its slow errors counted as white, so that filters without states for them
/// do not follow them blindly.
fn whitened(fix: &Fix, gps: &GpsModel) -> Fix {
    let wider = |sigma: Option<Vector<Ned>>, model: [f64; 3]| {
        Some(sigma.unwrap_or(model.into()) * WHITENED)
    };
    Fix {
        position_sigma_m: wider(fix.position_sigma_m, gps.position_sigma_m()),
        velocity_sigma_mps: wider(fix.axes_velocity_sigma_mps(), gps.velocity_sigma_mps()),
        ..*fix
    }
}

#[cfg(test)]
mod tests;
