//! Slow errors of fixes, common to several successive fixes.

use crate::ekf::filter::Ekf;
use crate::ekf::kernel::covariance::Relaxation;
use crate::ekf::kernel::layout::Layout;
use crate::ekf::kernel::trace::Trace;
use crate::gps::Fix;
use crate::matrix::square;
use crate::scalar::Scalar;

/// White variances of a fix, north, east, down.
pub(super) struct GpsNoise {
    pub position_variance: [f64; 3],
    pub velocity_variance: [f64; 3],
}

/// Largest ratio of two stated one-sigmas that count as equal.
const STEADY: f64 = 1.25;

impl<L: Layout<N>, const N: usize, T: Scalar> Ekf<L, N, T> {
    /// Splits the one-sigmas of a fix, of position and velocity, into a white part and a slow part. It adapts the
    /// states of the slow errors; the first fix sets their initial variances.
    ///
    /// # Source
    /// Equation (M5) of docs/equations.md.
    pub(super) fn gps_noise(
        &mut self,
        fix: &Fix,
        (position, velocity): ([f64; 3], [f64; 3]),
        trace: &mut impl Trace<T, N>,
    ) -> GpsNoise {
        let model = self.config.gps;
        let split = |state: Option<usize>, share: f64, sigma: [f64; 3], floor: f64| {
            let slow = if state.is_some() { share } else { 0.0 };
            let white = sigma.map(|sigma| ((1.0 - slow * slow) * square(sigma)).max(square(floor)));
            ([slow * sigma[0].max(sigma[1]), slow * sigma[2]], white)
        };
        let ([position_h, position_v], mut position_variance) =
            split(L::GPS_POSITION, model.position_wander_share, position, model.position_floor_m);
        let ([velocity_h, velocity_v], velocity_variance) =
            split(L::GPS_VELOCITY, model.velocity_wander_share, velocity, model.velocity_floor_mps);
        let share = self.memory.position_scatter.share();
        for (variance, sigma) in position_variance.iter_mut().zip(position) {
            *variance = variance.max(share * square(sigma));
        }
        let mut wander = [position_h, position_v, velocity_h, velocity_v];
        match self.memory.gps_wander.map(|before| before.map(f64::from)) {
            Some(before) => {
                // For fixes that state no one-sigma, the learned size grows with rejected fixes, so it is not followed.
                if fix.position_sigma_m.is_some() {
                    self.follow_wander(before, &mut wander, trace);
                }
            }
            None => self.set_wander_sigmas(wander),
        }
        self.memory.gps_wander = Some(wander.map(|sigma| sigma as f32));
        GpsNoise { position_variance, velocity_variance }
    }

    /// Adapts the slow errors of position to the one-sigmas that the fixes state. If a receiver converges, its slow
    /// error shrinks in proportion. If it becomes worse, the additional error is unknown. For changes within [`STEADY`]
    /// the one-sigmas `before` remain.
    ///
    /// # Source
    /// Equation (M5) of docs/equations.md.
    #[inline(never)]
    fn follow_wander(
        &mut self,
        before: [f64; 4],
        wander: &mut [f64; 4],
        trace: &mut impl Trace<T, N>,
    ) {
        let Some(first) = L::GPS_POSITION else { return };
        let mut relaxation = Relaxation::default();
        let mut changes = false;
        for (which, axes) in [(0, first..first + 2), (1, first + 2..first + 3)] {
            let (Some(&old), Some(new)) = (before.get(which), wander.get_mut(which)) else {
                continue;
            };
            if *new <= old * STEADY && old <= *new * STEADY {
                *new = old;
                continue;
            }
            changes = true;
            let kept = if *new < old { square(*new / old) } else { 1.0 };
            let states = relaxation.decay.iter_mut().zip(&mut relaxation.noise);
            for (decay, noise) in states.take(axes.end).skip(axes.start) {
                *decay = T::of(kept);
                *noise = T::of(square(*new) - square(kept * old));
            }
        }
        if changes {
            self.apply(relaxation, trace);
        }
    }

    // Not inlined, so that its stack frame is not part of every fix's.
    #[inline(never)]
    fn set_wander_sigmas(&mut self, [position_h, position_v, velocity_h, velocity_v]: [f64; 4]) {
        if let Some(first) = L::GPS_POSITION {
            self.set_sigmas(first, [position_h, position_h, position_v]);
        }
        if let Some(first) = L::GPS_VELOCITY {
            self.set_sigmas(first, [velocity_h, velocity_h, velocity_v]);
        }
    }
}
