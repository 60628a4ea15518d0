//! One guess at the heading: a Kalman filter of eight states from fix to fix.
#![expect(clippy::indexing_slicing, reason = "indices below the constant lengths of the arrays")]

use super::super::scalar::Scalar;
use super::super::square;
use super::{GRAVITY_MPS2, GUESS_SIGMA_RAD};

/// States: velocity north and east, m/s; direction of the level frame, rad; acceleration by the tilt error of the level
/// frame, along its axes, m/s²; gyro bias, body axes, rad/s.
const STATES: usize = 8;
const DIRECTION: usize = 2;
const LEVEL: usize = 3;
const BIAS: usize = 5;
/// Number of states that change others: all but the two velocities.
const DRIVING: usize = STATES - DIRECTION;

/// Share of a velocity change that counts as error: fixes and samples differ in time.
const TIMING: f32 = 0.1;

/// A row of the transition, from the state of the direction on, less the identity.
type Row = [f32; DRIVING];

/// Velocity change between two fixes by specific force, in the level frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Felt {
    /// Velocity change along the level axes, m/s.
    pub velocity_mps: [f32; 2],
    /// Duration, s.
    pub duration_s: f32,
    /// Integral of the direction cosines from body to level axes, s.
    pub turned_s: [[f32; 3]; 3],
    /// Variance by sensor noise of each velocity, (m/s)², and of each angle, rad².
    pub velocity_variance: f32,
    pub angle_variance: f32,
}

impl Felt {
    /// Nothing felt.
    pub const NONE: Self = Self {
        velocity_mps: [0.0; 2],
        duration_s: 0.0,
        turned_s: [[0.0; 3]; 3],
        velocity_variance: 0.0,
        angle_variance: 0.0,
    };

    /// Change of level and direction by each axis of a gyro bias.
    fn drift(&self) -> [[f32; 3]; 3] {
        let [x, y, z] = self.turned_s;
        [y.map(|s| GRAVITY_MPS2 * s), x.map(|s| -GRAVITY_MPS2 * s), z.map(|s| -s)]
    }
}

/// Horizontal velocity at a fix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measured {
    /// Velocity north and east, m/s.
    pub velocity_mps: [f32; 2],
    /// Variance of each, (m/s)².
    pub variance: f32,
    /// Whether it is the mean since the fix before, from positions.
    pub is_mean: bool,
}

/// Result of a measurement: the sum of the squared normalised innovations, and that of the logarithms of their variances.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surprise {
    pub squares: f32,
    pub logarithms: f32,
}

/// What is known before the first fix of a bank.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    /// Tilt error of the level frame as an acceleration, north and east, and its one-sigma, m/s².
    pub level_mps2: [f32; 2],
    pub level_sigma_mps2: f32,
    /// One-sigma of the gyro bias, rad/s.
    pub bias_sigma_radps: f32,
}

/// A guess at the direction of the level frame, clockwise from north.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guess {
    pub weight: f64,
    state: [f32; STATES],
    covariance: [[f32; STATES]; STATES],
}

impl Guess {
    /// No guess.
    pub const NONE: Self =
        Self { weight: 0.0, state: [0.0; STATES], covariance: [[0.0; STATES]; STATES] };

    /// A guess that starts at a fix.
    pub fn start(direction_rad: f32, weight: f64, measured: &Measured, prior: &Prior) -> Self {
        let level_mps2 = prior.level_mps2;
        let [north, east] = measured.velocity_mps;
        let (sin, cos) = direction_rad.sincos();
        let level =
            [cos * level_mps2[0] + sin * level_mps2[1], cos * level_mps2[1] - sin * level_mps2[0]];
        let mut guess = Self { weight, ..Self::NONE };
        guess.state = [north, east, direction_rad, level[0], level[1], 0.0, 0.0, 0.0];
        let [velocity, level, bias] =
            [measured.variance, square(prior.level_sigma_mps2), square(prior.bias_sigma_radps)];
        let direction = square(GUESS_SIGMA_RAD as f32);
        let variances = [velocity, velocity, direction, level, level, bias, bias, bias];
        for (state, variance) in variances.into_iter().enumerate() {
            guess.covariance[state][state] = variance;
        }
        guess
    }

    /// Direction of the level frame, rad.
    pub fn direction_rad(&self) -> f32 {
        self.state[DIRECTION]
    }

    /// Variance of the direction, rad².
    pub fn direction_variance(&self) -> f32 {
        self.covariance[DIRECTION][DIRECTION]
    }

    /// Mean variance of the two velocities, (m/s)².
    pub fn velocity_variance(&self) -> f32 {
        0.5 * (self.covariance[0][0] + self.covariance[1][1])
    }

    /// Tilt error of the level frame as an acceleration along its axes, m/s².
    pub fn level_mps2(&self) -> [f32; 2] {
        [self.state[LEVEL], self.state[LEVEL + 1]]
    }

    /// Mean variance of the two tilt errors, (m/s²)².
    pub fn level_variance(&self) -> f32 {
        0.5 * (self.covariance[LEVEL][LEVEL] + self.covariance[LEVEL + 1][LEVEL + 1])
    }

    /// Subtracts a tilt error, by which the level frame has been turned.
    pub fn level_by(&mut self, level_mps2: [f32; 2]) {
        self.state[LEVEL] -= level_mps2[0];
        self.state[LEVEL + 1] -= level_mps2[1];
    }

    /// Gyro bias, rad/s, and its variances, (rad/s)².
    pub fn bias_radps(&self) -> [(f32, f32); 3] {
        core::array::from_fn(|axis| {
            let state = BIAS + axis;
            (self.state[state], self.covariance[state][state])
        })
    }

    /// Subtracts a gyro bias, by which the rates are corrected from now on.
    pub fn correct_bias(&mut self, bias_radps: [f32; 3]) {
        for (own, bias) in self.state[BIAS..].iter_mut().zip(bias_radps) {
            *own -= bias;
        }
    }

    /// Velocity change north and east by what was felt, m/s, and its rows of the transition.
    fn change(&self, felt: &Felt) -> ([f32; 2], [Row; 2]) {
        let (sin, cos) = self.state[DIRECTION].sincos();
        let felt_s = felt.duration_s;
        let drift = felt.drift();
        // The level drifts evenly: half its change acts on the velocity.
        let level = |axis: usize| {
            let drifted: f32 = (0..3).map(|k| drift[axis][k] * self.state[BIAS + k]).sum();
            self.state[LEVEL + axis] + 0.5 * drifted
        };
        let x = felt.velocity_mps[0] + level(0) * felt_s;
        let y = felt.velocity_mps[1] + level(1) * felt_s;
        let change = [cos * x - sin * y, sin * x + cos * y];
        let row = |along: f32, across: f32, by_direction: f32| {
            let bias = |k: usize| 0.5 * felt_s * (along * drift[0][k] + across * drift[1][k]);
            [by_direction, along * felt_s, across * felt_s, bias(0), bias(1), bias(2)]
        };
        (change, [row(cos, -sin, -change[1]), row(sin, cos, change[0])])
    }

    /// Velocity north and east after what was felt since the last fix, m/s.
    pub fn velocity_after(&self, felt: &Felt) -> [f32; 2] {
        let (change, _) = self.change(felt);
        [self.state[0] + change[0], self.state[1] + change[1]]
    }

    /// Propagates to a fix, and takes in its velocity.
    ///
    /// # Source
    /// Equation (H5) of docs/equations.md.
    pub fn step(&mut self, felt: &Felt, measured: &Measured) -> Surprise {
        let (change, rows) = self.change(felt);
        self.propagate(change, &rows, felt);
        let mut surprise = Surprise { squares: 0.0, logarithms: 0.0 };
        for (axis, row) in rows.iter().enumerate() {
            // The mean over the interval lies half the velocity change before its end.
            let mut sensitivity = [0.0; STATES];
            sensitivity[axis] = 1.0;
            let mut predicted = self.state[axis];
            if measured.is_mean {
                predicted -= 0.5 * change[axis];
                for (sensitivity, slope) in sensitivity[DIRECTION..].iter_mut().zip(row) {
                    *sensitivity = -0.5 * slope;
                }
            }
            let innovation = measured.velocity_mps[axis] - predicted;
            let total = self.update(&sensitivity, innovation, measured.variance);
            surprise.squares += square(innovation) / total;
            surprise.logarithms += total.ln();
        }
        surprise
    }

    fn propagate(&mut self, change: [f32; 2], rows: &[Row; 2], felt: &Felt) {
        let [x, y, down] = felt.drift();
        let by_bias = |[p, q, r]: [f32; 3]| [0.0, 0.0, 0.0, p, q, r];
        // The transition is the identity but for these rows, the first of which read states before they change.
        let rows = [
            (0, rows[0]),
            (1, rows[1]),
            (DIRECTION, by_bias(down)),
            (LEVEL, by_bias(x)),
            (LEVEL + 1, by_bias(y)),
        ];
        let p = &mut self.covariance;
        for (state, row) in &rows {
            let moved: [f32; STATES] = core::array::from_fn(|column| {
                row.iter().zip(&p[DIRECTION..]).map(|(factor, line)| factor * line[column]).sum()
            });
            for (value, moved) in p[*state].iter_mut().zip(moved) {
                *value += moved;
            }
        }
        for line in p.iter_mut() {
            for (state, row) in &rows {
                let moved: f32 = row.iter().zip(&line[DIRECTION..]).map(|(a, b)| a * b).sum();
                line[*state] += moved;
            }
        }
        let [x, y] = felt.velocity_mps;
        let velocity = felt.velocity_variance + square(TIMING) * (square(x) + square(y));
        let level = square(GRAVITY_MPS2) * felt.angle_variance;
        let noise = [velocity, velocity, felt.angle_variance, level, level];
        for (state, variance) in noise.into_iter().enumerate() {
            p[state][state] += variance;
        }
        let bias = [self.state[BIAS], self.state[BIAS + 1], self.state[BIAS + 2]];
        for (state, row) in &rows[2..] {
            let moved: f32 = row[3..].iter().zip(bias).map(|(factor, bias)| factor * bias).sum();
            self.state[*state] += moved;
        }
        self.state[0] += change[0];
        self.state[1] += change[1];
    }

    /// Scalar Kalman update; gives the innovation's variance.
    fn update(&mut self, sensitivity: &[f32; STATES], innovation: f32, variance: f32) -> f32 {
        let seen: [f32; STATES] = core::array::from_fn(|row| {
            self.covariance[row].iter().zip(sensitivity).map(|(p, h)| p * h).sum()
        });
        let total: f32 =
            variance + seen.iter().zip(sensitivity).map(|(seen, h)| seen * h).sum::<f32>();
        for row in 0..STATES {
            self.state[row] += seen[row] / total * innovation;
            for column in 0..STATES {
                self.covariance[row][column] -= seen[row] * seen[column] / total;
            }
        }
        total
    }

    /// Whether rounding has left a valid covariance.
    pub fn is_sound(&self) -> bool {
        self.state.iter().all(|value| value.is_finite())
            && (0..STATES).all(|state| self.covariance[state][state] >= 0.0)
    }
}
