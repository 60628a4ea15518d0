//! Choice of the heading search by type, because the search takes memory.

use super::HeadingSearch;
use crate::scalar::Scalar;

/// Method by which an [`Estimator`](crate::ekf::Estimator) finds the heading if no source gives it at the start:
/// [`HeadingSearch`], or [`NoHeadingSearch`] without a search. Sealed.
pub trait HeadingMethod<T = f64>: sealed::Method<T> {}

/// No search and no memory for one. Alignment waits for a heading from a sensor, or from the course if the
/// configuration names it as source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoHeadingSearch;

impl<T: Scalar> HeadingMethod<T> for HeadingSearch<T> {}
impl<T: Scalar> HeadingMethod<T> for NoHeadingSearch {}

pub(in crate::ekf) mod sealed {
    use super::HeadingSearch;

    /// Interface of the search.
    pub trait Method<T>: Sized {
        /// Whether the method searches.
        const SEARCHES: bool;
        fn new() -> Self;
        /// The search, if there is one.
        fn bank(&mut self) -> Option<&mut HeadingSearch<T>>;
    }
}

impl<T: Scalar> sealed::Method<T> for HeadingSearch<T> {
    const SEARCHES: bool = true;
    #[inline(always)]
    fn new() -> Self {
        Self::empty()
    }
    #[inline(always)]
    fn bank(&mut self) -> Option<&mut Self> {
        Some(self)
    }
}

impl<T: Scalar> sealed::Method<T> for NoHeadingSearch {
    const SEARCHES: bool = false;
    fn new() -> Self {
        Self
    }
    #[inline(always)]
    fn bank(&mut self) -> Option<&mut HeadingSearch<T>> {
        None
    }
}
