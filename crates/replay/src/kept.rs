//! Selection of the solutions of a run that stay in memory.

use hovernav::ekf::Solution;

/// Selection of the solutions of a run that stay in memory. A callback can receive every solution regardless.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    /// All solutions, at 280 bytes each.
    All,
    /// At most 65 536 solutions, evenly thinned. A shorter log keeps all. A longer one keeps the first, every second,
    /// fourth, eighth … and the last. They need less than 20 MB for any log.
    Thinned,
}

/// Largest number of solutions under [`Keep::Thinned`]. Even, so that halves are whole numbers.
const MAX: usize = 1 << 16;

impl Keep {
    const fn most(self) -> usize {
        match self {
            Self::All => usize::MAX,
            Self::Thinned => MAX,
        }
    }
}

/// The solutions of a run that stay in memory.
pub(crate) struct Kept {
    most: usize,
    solutions: Vec<Solution>,
    /// One of this many solutions is kept.
    stride: usize,
    seen: usize,
    last: Option<Solution>,
}

impl Kept {
    /// Empty, with room for the solutions of `samples` samples.
    pub fn new(keep: Keep, samples: usize) -> Self {
        let most = keep.most();
        let solutions = Vec::with_capacity(samples.min(most));
        Self { most, solutions, stride: 1, seen: 0, last: None }
    }

    pub fn push(&mut self, solution: Solution) {
        self.last = Some(solution);
        if self.seen.is_multiple_of(self.stride) {
            if self.solutions.len() == self.most {
                let mut index = 0;
                self.solutions.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
                self.stride *= 2;
            }
            self.solutions.push(solution);
        }
        self.seen += 1;
    }

    /// The kept solutions, including the last one, and the number of solutions not kept.
    pub fn finish(mut self) -> (Vec<Solution>, usize) {
        let ends = self.solutions.last().map(|solution| solution.time);
        self.solutions.extend(self.last.filter(|last| Some(last.time) != ends));
        let skipped = self.seen - self.solutions.len();
        (self.solutions, skipped)
    }
}

/// Thins `solutions` as [`Keep::Thinned`] does, and frees the memory of the removed ones.
#[must_use]
pub fn thin(solutions: Vec<Solution>) -> Vec<Solution> {
    if solutions.len() <= MAX {
        return solutions;
    }
    let mut kept = Kept::new(Keep::Thinned, solutions.len());
    solutions.into_iter().for_each(|solution| kept.push(solution));
    kept.finish().0
}

#[cfg(test)]
mod tests {
    use super::*;
    use hovernav::earth::Geodetic;
    use hovernav::time::Time;

    fn solution(number: i64) -> Solution {
        Solution::at_rest(
            Time::from_nanoseconds(number),
            Geodetic { latitude_rad: 0.0, longitude_rad: 0.0, height_m: 0.0 },
        )
    }

    fn kept(most: usize, count: i64) -> (Vec<i64>, usize) {
        let mut kept = Kept { most, ..Kept::new(Keep::All, 0) };
        (0..count).for_each(|number| kept.push(solution(number)));
        let (solutions, skipped) = kept.finish();
        (solutions.iter().map(|solution| solution.time.nanoseconds()).collect(), skipped)
    }

    #[test]
    fn those_kept_are_even_and_have_the_first_and_the_last() {
        assert_eq!(kept(4, 0), (vec![], 0));
        assert_eq!(kept(4, 4), (vec![0, 1, 2, 3], 0));
        assert_eq!(kept(4, 5), (vec![0, 2, 4], 2));
        assert_eq!(kept(4, 8), (vec![0, 2, 4, 6, 7], 3));
        assert_eq!(kept(4, 9), (vec![0, 4, 8], 6));
        assert_eq!(kept(4, 1000).0.last(), Some(&999));
        assert!((1..3000).all(|count| kept(4, count).0.len() <= 5));
    }
}
