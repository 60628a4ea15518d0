//! Numbers in the format of the page's script.

use serde::{Serialize, Serializer};

/// Numbers to draw. A number that is not finite is written as `null`, which interrupts a line.
#[derive(Debug)]
pub struct Numbers {
    pub(crate) values: Vec<f64>,
    digits: Digits,
}

/// Value to which the five significant digits refer.
#[derive(Debug)]
enum Digits {
    OfLargest,
    OfEach,
}

impl Numbers {
    /// Numbers on a common scale: five significant digits of the largest number, and at least three decimals.
    pub fn new(values: Vec<f64>) -> Self {
        Self { values, digits: Digits::OfLargest }
    }

    /// Numbers with five significant digits each, for logarithmic axes.
    pub fn with_digits_of_each(values: Vec<f64>) -> Self {
        Self { values, digits: Digits::OfEach }
    }
}

impl Serialize for Numbers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let decimals = |size: f64| 4.0 - size.max(1e-12).log10().floor();
        let sizes = self.values.iter().filter(|value| value.is_finite()).map(|value| value.abs());
        let of_largest = decimals(sizes.fold(0.0, f64::max)).clamp(3.0, 15.0);
        serializer.collect_seq(self.values.iter().map(|value| {
            let decimals = match self.digits {
                Digits::OfLargest => of_largest,
                Digits::OfEach => decimals(value.abs()).clamp(0.0, 15.0),
            };
            let scale = 10f64.powi(decimals as i32);
            let rounded = (value * scale).round() / scale;
            rounded.is_finite().then_some(rounded)
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(values: &[f64]) -> String {
        serde_json::to_string(&Numbers::new(values.to_vec())).unwrap()
    }

    #[test]
    fn numbers_keep_five_digits_of_the_largest_and_unknown_ones_are_null() {
        assert_eq!(text(&[1.234_567_89, 0.000_001_2]), "[1.2346,0.0]");
        assert_eq!(text(&[123_456.789_12, 1.0]), "[123456.789,1.0]");
        assert_eq!(text(&[1.234_567_89e-6]), "[1.2346e-6]");
        assert_eq!(text(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY]), "[null,null,null]");
        assert_eq!(text(&[f64::MAX]), "[null]");
        assert_eq!(text(&[]), "[]");
    }
}
