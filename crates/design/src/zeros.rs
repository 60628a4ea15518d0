//! Where a function of frequency crosses zero.

/// Where a function of frequency crosses zero between the points of a grid, by bisection.
pub(super) fn zeros(grid: &[f64], value: impl Fn(f64) -> Option<f64>) -> Vec<f64> {
    let values: Vec<Option<f64>> = grid.iter().map(|&frequency| value(frequency)).collect();
    let mut found = Vec::new();
    for (ends, signs) in grid.windows(2).zip(values.windows(2)) {
        let (&[mut low, mut high], &[Some(at_low), Some(at_high)]) = (ends, signs) else {
            continue;
        };
        if (at_low < 0.0) == (at_high < 0.0) {
            continue;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            match value(middle) {
                Some(at_middle) if (at_middle < 0.0) == (at_low < 0.0) => low = middle,
                Some(_) => high = middle,
                None => break,
            }
        }
        found.push(0.5 * (low + high));
    }
    found
}
