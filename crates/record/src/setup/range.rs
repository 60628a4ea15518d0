//! Permitted range of a number in `fly.toml`.

use hovernav::ekf::Setting;
use hovernav::scalar::Readable;

/// Permitted range of a number.
#[derive(Clone, Copy)]
pub(super) struct Range {
    pub key: &'static str,
    from: f64,
    to: f64,
    unit: &'static str,
    /// Whether 0, in the sense of "none", is permitted too.
    or_zero: bool,
}

/// A section and its numbers. `*` matches any section or number key that has no earlier entry.
pub(super) type Section = (&'static str, &'static [Range]);

/// Unit and remark for bias times: the filter would stop estimating a bias that never changes.
const BIAS_TIME: &str = "s; write 10000000 for a bias that hardly changes";

/// Range of `key` from `from` to `to`.
pub(super) const fn range(key: &'static str, from: f64, to: f64, unit: &'static str) -> Range {
    Range { key, from, to, unit, or_zero: false }
}

impl Range {
    /// The same range, or 0.
    pub const fn or_zero(self) -> Self {
        Self { or_zero: true, ..self }
    }

    /// The range in flight of a setting of the estimator.
    pub fn of(setting: &Setting) -> Self {
        let Setting { name: key, unit, in_flight: [from, to], or_zero, .. } = *setting;
        let unit = if key.ends_with("bias_time_s") { BIAS_TIME } else { unit };
        Self { key, from, to, unit, or_zero }
    }

    /// Whether `found` is in the range, or is 0 and the range permits 0; false for NaN.
    pub fn holds(&self, found: f64) -> bool {
        (self.from..=self.to).contains(&found) || (self.or_zero && found == 0.0)
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { from, to, unit, .. } = self;
        if self.or_zero {
            f.write_str("0, or ")?;
        }
        write!(f, "{} to {}", Readable(*from), Readable(*to))?;
        if unit.is_empty() { Ok(()) } else { write!(f, " {unit}") }
    }
}
