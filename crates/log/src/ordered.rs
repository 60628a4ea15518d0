//! The rows of a file in order of time, gone over without being kept.

use std::path::Path;

use crate::clock::{FirstLook, looked_again};
use crate::error::LogError;
use crate::remarks::Remarks;
use hovernav::time::Time;

/// Rows with a time, read forward once.
pub(crate) trait TimedRows: Sized {
    /// What a row holds.
    type Row;

    /// The next row that holds anything, with its line.
    fn next(&mut self) -> Result<Option<(u64, Self::Row)>, LogError>;

    /// The time of a row.
    fn time(row: &Self::Row) -> Time;

    /// The file.
    fn path(&self) -> &Path;

    /// What was wrong with the rows so far.
    fn remarks(&mut self) -> &mut Remarks;
}

/// What was gathered from the rows of a file.
pub(crate) struct Gathered<R, G> {
    /// What was made of the rows that stay.
    pub made: G,
    /// Which rows are left out for time to run forward, by number, rising; those with the time of the row before
    /// need not be among them.
    pub left_out: Vec<usize>,
    /// The file, read to its end, remarks about its clock included.
    pub rows: R,
}

/// Gathers from all rows that stay in order of time, as [`Rows`](crate::Rows) keeps them, what `push` makes of them
/// one by one from `begin` on. The file is opened once, and anew where rows have to be left out; only where time
/// goes back are the times of all rows in memory.
pub(crate) fn gather<R: TimedRows, G>(
    open: impl Fn() -> Result<R, LogError>,
    begin: impl Fn() -> G,
    push: impl Fn(&mut G, u64, R::Row),
) -> Result<Gathered<R, G>, LogError> {
    let mut rows = open()?;
    let (mut look, mut made) = (FirstLook::default(), begin());
    while let Some((line, row)) = rows.next()? {
        if look.push(line, R::time(&row)) {
            push(&mut made, line, row);
        }
    }
    let left_out = match look.left_out(rows.remarks()) {
        Some(left_out) => left_out,
        None => disordered(open()?, rows.remarks())?,
    };
    if !left_out.is_empty() {
        made = begin();
        go_over(open()?, &left_out, |line, row| push(&mut made, line, row))?;
    }
    Ok(Gathered { made, left_out, rows })
}

/// Which of `rows` to leave out where time goes back: the times of all of them decide.
fn disordered<R: TimedRows>(mut rows: R, remarks: &mut Remarks) -> Result<Vec<usize>, LogError> {
    let (mut times, mut lines) = (Vec::new(), Vec::new());
    while let Some((line, row)) = rows.next()? {
        times.push(R::time(&row));
        lines.push(line);
    }
    looked_again(&times, &lines, rows.path(), remarks)
}

/// Hands every row with its line to `each` that is not `left_out`.
pub(crate) fn go_over<R: TimedRows>(
    mut rows: R,
    left_out: &[usize],
    mut each: impl FnMut(u64, R::Row),
) -> Result<(), LogError> {
    let mut passing = Passing::default();
    while let Some((line, row)) = rows.next()? {
        if passing.stays(R::time(&row), left_out) {
            each(line, row);
        }
    }
    Ok(())
}

/// Which rows stay, as they pass.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Passing {
    /// Rows so far, and the time of the last.
    read: usize,
    last: Option<Time>,
    /// How many of those left out have passed.
    passed: usize,
}

impl Passing {
    /// Whether the next row, of this time, stays where the rows `left_out` do not.
    pub fn stays(&mut self, time: Time, left_out: &[usize]) -> bool {
        let index = self.read;
        self.read += 1;
        if self.last.replace(time) == Some(time) {
            return false;
        }
        while left_out.get(self.passed).is_some_and(|&left_out| left_out < index) {
            self.passed += 1;
        }
        left_out.get(self.passed) != Some(&index)
    }
}
