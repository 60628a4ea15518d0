//! Gravity: how large the mean specific force is, and where it points.

use super::{G, Means, Second, norm};
use crate::distribution::Distribution;
use crate::finding::SetupFinding;
use crate::rates::Rates;

/// Over so long, s, vibration is gone from a mean.
const MEAN_S: f64 = 1.0;
/// What the median of the means may be in m/s² in any flight: the first is sure, the second likely.
const POSSIBLE: (f64, f64) = (0.75, 1.6);
const USUAL: (f64, f64) = (0.85, 1.35);
/// Cosine of the angle from the vertical within which a vehicle spends its flight, 60°.
const UPRIGHT: f64 = 0.5;

/// The mean of the directions that a force had second by second is this long where it has one on the whole.
const STEADY: f64 = 0.7;

/// Cosine of the angle from the vertical, 20°, beyond which a unit stands askew if its mean specific
/// force is that steady: no vehicle is tilted so far from end to end.
const ASKEW: f64 = 0.94;
const ASKEW_STEADY: f64 = 0.97;

/// The mean specific force, second by second.
pub(super) struct Gravity {
    means: Means,
    sizes: Distribution,
    /// Of the directions of the means, and how many.
    directions: [f64; 3],
    count: usize,
    /// Of all samples.
    sum: [f64; 3],
}

impl Default for Gravity {
    fn default() -> Self {
        Self {
            means: Means::over(MEAN_S),
            sizes: Distribution::default(),
            directions: [0.0; 3],
            count: 0,
            sum: [0.0; 3],
        }
    }
}

impl Gravity {
    pub fn push(&mut self, at: &Rates) {
        self.sum = [0, 1, 2].map(|axis| self.sum[axis] + at.force_mps2[axis]);
        let mean = self.means.push(at);
        self.add(mean);
    }

    fn add(&mut self, mean: Option<Second>) {
        let Some(Second { force_mps2, .. }) = mean else { return };
        let size = norm(force_mps2);
        self.sizes.push(size);
        for (sum, value) in self.directions.iter_mut().zip(force_mps2) {
            *sum += value / size.max(1e-9);
        }
        self.count += 1;
    }

    /// Where up is in the body, on the whole; `None` of a vehicle that flies on its back as well, for whatever it is
    /// there is no such direction.
    pub fn up(&self) -> Option<[f64; 3]> {
        let is_steady = norm(self.directions) >= STEADY * self.count as f64;
        is_steady.then(|| self.sum.map(|component| component / norm(self.sum).max(1e-12)))
    }

    pub fn check(mut self, found: &mut Vec<SetupFinding>) {
        let last = self.means.finish();
        self.add(last);
        let Some(size_mps2) = self.sizes.quantile(0.5) else { return };
        size(size_mps2, found);
        direction(self.directions, self.count, found);
    }
}

fn size(size: f64, found: &mut Vec<SetupFinding>) {
    let in_g = size / G;
    if !(USUAL.0..=USUAL.1).contains(&in_g) {
        let (cause, mend) = size_error(in_g);
        found.push(SetupFinding {
            sensor: "inertial unit",
            is_certain: !(POSSIBLE.0..=POSSIBLE.1).contains(&in_g),
            found: format!(
                "mean specific force is {size:.3} m/s², expected gravity, about 9.81 m/s²"
            ),
            cause,
            mend,
        });
    }
}

/// What makes gravity so many times too large.
fn size_error(in_g: f64) -> (String, String) {
    let near = |expected: f64| (0.85..1.2).contains(&(in_g / expected));
    let key = |text: &str| format!("write {text} under [imu] in dataset.toml");
    if near(1.0 / G) {
        return ("accelerations in g".into(), key("accel_unit = \"g\""));
    }
    if near(1000.0 / G) {
        return ("accelerations in thousandths of g".into(), key("accel_unit = \"mg\""));
    }
    if near(G) {
        return ("accelerations multiplied by g once too often".into(), key("accel_unit = \"g\""));
    }
    for factor in [0.25, 0.5, 2.0, 4.0] {
        if near(factor) {
            return (
                format!(
                    "the scale of the accelerometers is {factor} times the right one, as with a range of \
                     another setting (2 g for 4 g)"
                ),
                "correct the range with which the counts were converted".into(),
            );
        }
    }
    if in_g < 0.2 {
        return (
            "accelerations less gravity, which is no specific force, or a unit that is none of m/s²"
                .into(),
            "give the accelerometers' own readings in m/s²".into(),
        );
    }
    (
        "accelerometers of a wrong unit, scale or range, or increments taken for rates".into(),
        "give specific force in m/s²".into(),
    )
}

/// Whether gravity stands where the axes say: up is minus z.
fn direction(sum: [f64; 3], count: usize, found: &mut Vec<SetupFinding>) {
    // How steady the direction is, and what it is.
    let steady = norm(sum) / count.max(1) as f64;
    let up = sum.map(|component| component / norm(sum).max(1e-9));
    if steady > ASKEW_STEADY && (UPRIGHT..ASKEW).contains(&-up[2]) {
        found.push(askew(up));
    }
    if steady < STEADY || -up[2] > UPRIGHT {
        return;
    }
    let axis = (0..3).max_by(|&a, &b| up[a].abs().total_cmp(&up[b].abs())).unwrap_or(2);
    let names = ["x", "y", "z"];
    let sign = if up[axis] > 0.0 { "+" } else { "−" };
    let (cause, mend) = match (axis, up[axis] > 0.0) {
        (2, _) => (
            "axes forward, left, up, or accelerometers of the wrong sign (gravity taken for specific \
             force)"
                .to_owned(),
            "write axes = \"flu\" under [imu] in dataset.toml, or accel_is_gravity = true where the gyros \
             are right already"
                .to_owned(),
        ),
        _ => {
            let letters: [&str; 3] = match (axis, up[axis] > 0.0) {
                (0, true) => ["u", "r", "f"],
                (0, false) => ["d", "l", "f"],
                (1, true) => ["f", "u", "r"],
                _ => ["f", "d", "l"],
            };
            (
                format!("the unit's {} axis stands vertical: axes swapped, or a unit mounted on its side", names[axis]),
                format!(
                    "write axes = \"{}\" under [imu] in dataset.toml, the letters being where the unit's \
                     x, y and z point: f, b, l, r, u or d",
                    letters.concat()
                ),
            )
        }
    };
    // Half way between two axes a unit may well be mounted.
    let is_certain = up[axis].abs() > 0.85;
    found.push(SetupFinding {
        sensor: "inertial unit",
        is_certain,
        found: format!(
            "mean specific force points along {sign}{} ({:.2}, {:.2}, {:.2} of its size), expected −z, \
             axes being forward, right, down",
            names[axis], up[0], up[1], up[2]
        ),
        cause,
        mend,
    });
}

/// A unit mounted askew, by where it sees `up`: its roll and pitch are proposed, its yaw is not seen.
fn askew(up: [f64; 3]) -> SetupFinding {
    let (roll_deg, pitch_deg) =
        (f64::atan2(-up[1], -up[2]).to_degrees(), up[0].asin().to_degrees());
    SetupFinding {
        sensor: "inertial unit",
        is_certain: false,
        found: format!(
            "mean specific force stands {:.0}° off −z ({:.2}, {:.2}, {:.2} of its size) from end to end",
            (-up[2]).acos().to_degrees(),
            up[0],
            up[1],
            up[2]
        ),
        cause: "a unit mounted askew in the vehicle".into(),
        mend: format!(
            "write mounting_deg = [{roll_deg:.1}, {pitch_deg:.1}, 0.0] under [imu] in dataset.toml, on top of \
             what may be written there, the third being the unit's heading in the vehicle, which gravity \
             does not tell"
        ),
    }
}
