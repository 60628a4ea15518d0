//! Zeros and peaks of functions of frequency.

/// Maximum of a function of frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// The frequency, rad/s.
    pub frequency_radps: f64,
    /// The value.
    pub value: f64,
}

/// A function of frequency with its values at the points of a grid, computed once for repeated evaluation.
pub(super) struct Curve<'a, T, F> {
    grid: &'a [f64],
    at_grid: Vec<Option<T>>,
    value: F,
}

impl<'a, T, F: Fn(f64) -> Option<T>> Curve<'a, T, F> {
    pub fn new(grid: &'a [f64], value: F) -> Self {
        Self { grid, at_grid: grid.iter().map(|&frequency| value(frequency)).collect(), value }
    }

    /// The value at any frequency.
    pub fn at(&self, frequency_radps: f64) -> Option<T> {
        (self.value)(frequency_radps)
    }

    /// The value at the first point of the grid.
    pub fn first(&self) -> Option<&T> {
        self.at_grid.first()?.as_ref()
    }

    /// Frequencies between the points of the grid at which `read` of the value is zero, by bisection.
    pub fn zeros(&self, read: impl Fn(&T) -> f64) -> Vec<f64> {
        let is_below = |value: &T| read(value) < 0.0;
        let mut found = Vec::new();
        for (ends, values) in self.grid.windows(2).zip(self.at_grid.windows(2)) {
            let (&[mut low, mut high], [Some(at_low), Some(at_high)]) = (ends, values) else {
                continue;
            };
            let below = is_below(at_low);
            if below == is_below(at_high) {
                continue;
            }
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                match self.at(middle) {
                    Some(value) if is_below(&value) == below => low = middle,
                    Some(_) => high = middle,
                    None => break,
                }
            }
            found.push(0.5 * (low + high));
        }
        found
    }

    /// Maximum over frequency of `read` of the value. The maximum on the grid is refined by golden-section search
    /// between its two neighbours.
    pub fn peak(&self, read: impl Fn(&T) -> f64) -> Peak {
        let read = |value: Option<&T>| value.map_or(f64::NEG_INFINITY, &read);
        let values: Vec<f64> = self.at_grid.iter().map(|value| read(value.as_ref())).collect();
        let highest = (0..values.len())
            .max_by(|&one, &other| values[one].total_cmp(&values[other]))
            .unwrap_or(0);
        let mut best = Peak { frequency_radps: self.grid[highest], value: values[highest] };
        let mut low = self.grid[highest.saturating_sub(1)];
        let mut high = self.grid[(highest + 1).min(self.grid.len() - 1)];
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        for _ in 0..60 {
            let (left, right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
            let at = |frequency| read(self.at(frequency).as_ref());
            let (at_left, at_right) = (at(left), at(right));
            if at_left > at_right {
                high = right;
            } else {
                low = left;
            }
            for (frequency_radps, value) in [(left, at_left), (right, at_right)] {
                if value > best.value {
                    best = Peak { frequency_radps, value };
                }
            }
        }
        best
    }
}
