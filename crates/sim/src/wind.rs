//! Steady wind and gusts.

use hovernav::glam::DVec3;

use super::axes::HorizontalVertical;
use super::check::{Checked, ConfigError, finite_vector, positive, size};
use super::noise::{Noise, Stream};
use hovernav::frames::{Ned, Vector};

/// Settings of the wind. The default is a light wind with gusts of the MIL-F-8785C length scales for 10 m above the
/// ground. These gusts are three times as strong as specified for such a wind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindConfig {
    /// The steady wind, in the direction to which it blows, m/s.
    pub steady_mps: Vector<Ned>,
    /// Standard deviation of the gusts, m/s.
    pub gust_sigma_mps: HorizontalVertical,
    /// Length scale of the gusts, m.
    pub gust_length_m: HorizontalVertical,
    /// Speed at which the gusts pass, m/s: the airspeed of the vehicle. It is at least 1 m/s, so that a hover in calm
    /// air has gusts.
    pub passing_mps: f64,
}

impl Default for WindConfig {
    /// Gusts of 1.5 m/s along each horizontal axis in 3 m/s of wind from the south-east.
    fn default() -> Self {
        Self {
            steady_mps: Vector::new(2.12, -2.12, 0.0),
            gust_sigma_mps: HorizontalVertical::new(1.5, 0.8),
            gust_length_m: HorizontalVertical::new(67.0, 10.0),
            passing_mps: 3.0,
        }
    }
}

impl WindConfig {
    /// No wind.
    #[must_use]
    pub fn calm() -> Self {
        Self {
            steady_mps: Vector::ZERO,
            gust_sigma_mps: HorizontalVertical::default(),
            ..Self::default()
        }
    }

    /// Wind of `speed_mps` from the direction `from_rad`, clockwise from true north. One sigma of the gusts is
    /// `gust_sigma_mps` along each horizontal axis, and half that vertically.
    #[must_use]
    pub fn from_direction(speed_mps: f64, from_rad: f64, gust_sigma_mps: f64) -> Self {
        let (east, north) = from_rad.sin_cos();
        Self {
            steady_mps: Vector::new(-speed_mps * north, -speed_mps * east, 0.0),
            gust_sigma_mps: HorizontalVertical::new(gust_sigma_mps, 0.5 * gust_sigma_mps),
            passing_mps: speed_mps.max(1.0),
            ..Self::default()
        }
    }

    fn check(&self) -> Checked {
        const SENSOR: &str = "wind";
        finite_vector(SENSOR, "steady wind", self.steady_mps)?;
        size(SENSOR, "gusts", self.gust_sigma_mps.horizontal)?;
        size(SENSOR, "gusts", self.gust_sigma_mps.vertical)?;
        positive(SENSOR, "length scale", self.gust_length_m.horizontal)?;
        positive(SENSOR, "length scale", self.gust_length_m.vertical)?;
        positive(SENSOR, "passing speed", self.passing_mps)
    }
}

/// Running wind: the same seed gives the same wind.
///
/// # Source
/// Dryden spectra of MIL-F-8785C, 3.7.2.1: along the wind σ²(2L/πV)/(1 + (Lω/V)²), across it and
/// vertically σ²(L/πV)(1 + 3(Lω/V)²)/(1 + (Lω/V)²)², each as a filter of white noise, held over the
/// step.
#[derive(Clone, Debug)]
pub struct Wind {
    config: WindConfig,
    noise: Noise,
    /// Unit vector along the steady wind; the next one is across it.
    along: DVec3,
    across: DVec3,
    filters: [Dryden; 3],
}

impl Wind {
    /// Wind that changes every `period_s`.
    ///
    /// # Errors
    /// [`ConfigError`] with the invalid value of `config`.
    pub fn new(config: &WindConfig, period_s: f64, seed: u64) -> Result<Self, ConfigError> {
        config.check()?;
        positive("wind", "period", period_s)?;
        let mut noise = Noise::new(seed, Stream::Gust);
        let steady = config.steady_mps.components() * DVec3::new(1.0, 1.0, 0.0);
        let along = steady.try_normalize().unwrap_or(DVec3::X);
        let speed = config.passing_mps.max(1.0);
        let (sigma, length) = (config.gust_sigma_mps, config.gust_length_m);
        let filters = [
            Dryden::new(sigma.horizontal, length.horizontal / speed, true, period_s, &mut noise),
            Dryden::new(sigma.horizontal, length.horizontal / speed, false, period_s, &mut noise),
            Dryden::new(sigma.vertical, length.vertical / speed, false, period_s, &mut noise),
        ];
        Ok(Self { config: *config, noise, along, across: DVec3::Z.cross(along), filters })
    }

    /// The wind over the next period, m/s, in the direction to which it blows.
    pub fn advance(&mut self) -> Vector<Ned> {
        let [along, across, down] = self.filters.each_mut().map(|f| f.next(&mut self.noise));
        let gust = self.along * along + self.across * across + DVec3::Z * down;
        self.config.steady_mps + Vector::claim(gust)
    }
}

/// One component of the gusts: two equal lags, mixed for a Dryden spectrum.
#[derive(Clone, Copy, Debug)]
struct Dryden {
    keep: f64,
    step: f64,
    states: [f64; 2],
    /// Standard deviations and correlation of the noise added to the two states per step.
    drive: [f64; 3],
    mix: [f64; 2],
}

impl Dryden {
    /// `time_s` is L/V. Along the wind there is one lag, x' = −x/T + w. Across it a second follows, y' = (x − y)/T, and
    /// the output is √3 x + (1 − √3) y, whose transfer function (1 + √3 Ts)/(1 + Ts)² is Dryden's.
    ///
    /// # Source
    /// Equation (W4) of docs/equations.md.
    fn new(sigma: f64, time_s: f64, along: bool, period_s: f64, noise: &mut Noise) -> Self {
        let step = period_s / time_s;
        let keep = (-step).exp();
        // The white noise gives x unit variance: q = 2/T. Then y has variance 1/2 and their covariance is 1/2. The
        // noise of a step keeps these stationary.
        let added_xx = 1.0 - keep * keep;
        let added_xy = 0.5 - keep * keep * (0.5 + step);
        let added_yy = 0.5 - keep * keep * (0.5 + step + step * step);
        let first = added_xx.sqrt();
        let cross = added_xy / first;
        let drive = [first, cross, (added_yy - cross * cross).max(0.0).sqrt()];
        let root3 = 3f64.sqrt();
        // Across the wind, an x of unit variance gives the variance 3 + 2√3(1−√3)/2 + (1−√3)²/2 = 2.
        let mix = if along {
            [sigma, 0.0]
        } else {
            [sigma * root3 / 2f64.sqrt(), sigma * (1.0 - root3) / 2f64.sqrt()]
        };
        let [a, b] = [noise.normal(), noise.normal()];
        Self { keep, step, states: [a, 0.5 * (a + b)], drive, mix }
    }

    fn next(&mut self, noise: &mut Noise) -> f64 {
        let [x, y] = self.states;
        let output = self.mix[0] * x + self.mix[1] * y;
        let [a, b] = [noise.normal(), noise.normal()];
        self.states = [
            self.keep * x + self.drive[0] * a,
            self.keep * (y + self.step * x) + self.drive[1] * a + self.drive[2] * b,
        ];
        output
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    fn gusts(config: &WindConfig, count: usize) -> Vec<[f64; 3]> {
        let mut wind = Wind::new(config, 0.03, 5).unwrap();
        (0..count).map(|_| (wind.advance() - config.steady_mps).to_array()).collect()
    }

    fn correlation(values: &[f64], lag: usize) -> f64 {
        let products = values.iter().zip(values.get(lag..).unwrap()).map(|(a, b)| a * b);
        products.sum::<f64>() / (values.len() - lag) as f64
    }

    #[test]
    fn gusts_have_drydens_correlations() {
        // A time scale of 1 s, so that 300 000 samples of 0.03 s contain 9000 time scales.
        let config = WindConfig {
            steady_mps: Vector::new(3.0, 0.0, 0.0),
            gust_sigma_mps: HorizontalVertical::new(1.5, 0.8),
            gust_length_m: HorizontalVertical::new(4.0, 4.0),
            passing_mps: 4.0,
        };
        let gusts = gusts(&config, 300_000);
        for (axis, sigma, along) in [(0, 1.5, true), (1, 1.5, false), (2, 0.8, false)] {
            let values: Vec<f64> = gusts.iter().map(|gust| gust[axis]).collect();
            for lag in [0, 10, 33, 66] {
                let scaled: f64 = lag as f64 * 0.03;
                let shape = if along { 1.0 } else { 1.0 - 0.5 * scaled };
                let expected = shape * (-scaled).exp();
                let found = correlation(&values, lag) / (sigma * sigma);
                assert!((found - expected).abs() < 0.05, "{axis} {lag}: {found} {expected}");
            }
        }
    }

    #[test]
    fn wind_from_the_east_blows_to_the_west() {
        let wind = WindConfig::from_direction(4.0, 90f64.to_radians(), 2.0);
        let [north, east, down] = wind.steady_mps.to_array();
        assert_abs_diff_eq!(north, 0.0, epsilon = 1e-12);
        assert_abs_diff_eq!(east, -4.0, epsilon = 1e-12);
        assert_eq!(down, 0.0);
        assert_eq!(wind.gust_sigma_mps, HorizontalVertical::new(2.0, 1.0));
        assert_eq!(WindConfig::from_direction(0.2, 0.0, 0.0).passing_mps, 1.0);
    }

    #[test]
    fn a_seed_blows_the_same_and_calm_air_does_not_move() {
        let config = WindConfig::default();
        assert_eq!(gusts(&config, 10), gusts(&config, 10));
        let mut calm = Wind::new(&WindConfig::calm(), 0.03, 1).unwrap();
        assert!((0..10).all(|_| calm.advance() == Vector::ZERO));
    }
}
