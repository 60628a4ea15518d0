//! Passes over the rows of a file in order of time, without storing the rows.

use std::path::Path;

use crate::clock::{FirstLook, looked_again};
use crate::error::LogError;
use crate::remarks::Remarks;
use hovernav::time::Time;

/// Reader of rows with a time.
pub(crate) trait TimedRows: Sized {
    /// Content of a row.
    type Row;

    /// The next row with content, with its line.
    fn next(&mut self) -> Result<Option<(u64, Self::Row)>, LogError>;

    /// The time of a row.
    fn time(row: &Self::Row) -> Time;

    /// The file.
    fn path(&self) -> &Path;

    /// Defects of the rows read.
    fn remarks(&mut self) -> &mut Remarks;
}

/// Result of passes over the rows of a file.
pub(crate) struct Gathered<R, G> {
    /// Result from the rows that stay.
    pub made: G,
    /// Indices of the rows that are left out so that time runs forward, rising. Those with the time of the row before
    /// may be missing here.
    pub left_out: Vec<usize>,
    /// The file, read to its end, with remarks on its clock.
    pub rows: R,
}

/// Gathers a result from the rows that stay in order of time, as [`Rows`](crate::Rows) selects them. `begin` makes an
/// empty result, and `push` adds one row. The file is opened once, and again if rows have to be left out. Only if time
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

/// Indices of the `rows` to leave out where time goes back, from the times of all rows.
fn disordered<R: TimedRows>(mut rows: R, remarks: &mut Remarks) -> Result<Vec<usize>, LogError> {
    let (mut times, mut lines) = (Vec::new(), Vec::new());
    while let Some((line, row)) = rows.next()? {
        times.push(R::time(&row));
        lines.push(line);
    }
    looked_again(&times, &lines, rows.path(), remarks)
}

/// Passes every row that is not `left_out` to `each`, with its line.
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

/// Selection of the rows that stay, row by row.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Passing {
    /// Number of rows read, and time of the last one.
    read: usize,
    last: Option<Time>,
    /// Number of left-out rows passed.
    passed: usize,
}

impl Passing {
    /// Whether the next row, at this time, stays; the rows `left_out` do not.
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
