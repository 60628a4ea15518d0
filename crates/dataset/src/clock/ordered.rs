//! Passes over the rows of a file in order of time, without storing the rows.

use std::fmt::Debug;
use std::path::Path;

use crate::clock::steps::ClockSteps;
use crate::clock::{FirstLook, Order, late, looked_again};
use crate::error::LogError;
use crate::table::remarks::Remarks;
use hovernav::time::Time;

/// Reader of rows with a time.
pub(crate) trait TimedRows: Sized {
    /// Content of a row.
    type Row: Debug;

    /// The next row with content, with its line.
    fn next(&mut self) -> Result<Option<(u64, Self::Row)>, LogError>;

    /// The time of a row.
    fn time(row: &mut Self::Row) -> &mut Time;

    /// The file.
    fn path(&self) -> &Path;

    /// Defects of the rows read.
    fn remarks(&mut self) -> &mut Remarks;
}

/// Result of passes over the rows of a file.
pub(crate) struct Gathered<R, G> {
    /// Result from the rows that stay.
    pub made: G,
    /// Order of the rows.
    pub order: Order,
    /// The file, read to its end, with remarks on its clock.
    pub rows: R,
}

/// Gathers a result from the rows that stay in order of time, as [`Rows`](crate::Rows) selects them. `begin` makes an
/// empty result, given whether the rows have to be sorted, and `push` adds one row. The file is opened once, and again if rows have to be skipped. Only if time
/// goes back are the times of all rows in memory.
pub(crate) fn gather<R: TimedRows, G>(
    open: impl Fn() -> Result<R, LogError>,
    begin: impl Fn(bool) -> G,
    push: impl Fn(&mut G, u64, R::Row),
    steps: &mut ClockSteps,
) -> Result<Gathered<R, G>, LogError> {
    let mut rows = open()?;
    let (mut look, mut made) = (FirstLook::default(), begin(false));
    while let Some((line, mut row)) = rows.next()? {
        if look.push(line, *R::time(&mut row)) {
            push(&mut made, line, row);
        }
    }
    let order = match look.skipped(steps, rows.remarks()) {
        Some(skipped) => Order { skipped, ..Order::default() },
        None => disordered(open()?, steps, rows.remarks())?,
    };
    if order != Order::default() {
        made = begin(order.has_late);
        go_over(open()?, &order, |line, row| push(&mut made, line, row))?;
    }
    Ok(Gathered { made, order, rows })
}

/// The order of `rows` if time goes back, from the times of all rows.
fn disordered<R: TimedRows>(
    mut rows: R,
    steps: &mut ClockSteps,
    remarks: &mut Remarks,
) -> Result<Order, LogError> {
    let (mut times, mut prints, mut lines) = (Vec::new(), Vec::new(), Vec::new());
    while let Some((line, mut row)) = rows.next()? {
        times.push(*R::time(&mut row));
        prints.push(late::print(&mut row, R::time));
        lines.push(line);
    }
    looked_again(times, &prints, &lines, rows.path(), steps, remarks)
}

/// Passes every row that stays in `order` to `each`, with its line. If rows were written late, all rows are in memory.
pub(crate) fn go_over<R: TimedRows>(
    mut rows: R,
    order: &Order,
    mut each: impl FnMut(u64, R::Row),
) -> Result<(), LogError> {
    let (mut passing, mut sorted) = (Passing::default(), Vec::new());
    while let Some((line, mut row)) = rows.next()? {
        if !passing.stays(R::time(&mut row), order) {
            continue;
        }
        match order.has_late {
            true => sorted.push((*R::time(&mut row), line, row)),
            false => each(line, row),
        }
    }
    sorted.sort_by_key(|(time, ..)| *time);
    sorted.into_iter().for_each(|(_, line, row)| each(line, row));
    Ok(())
}

/// Selection of the rows that stay, row by row.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Passing {
    /// Number of rows read, and time of the last one.
    read: usize,
    last: Option<Time>,
    /// Number of skipped rows among them.
    passed: usize,
}

impl Passing {
    /// Whether the next row, at `time`, stays in `order`, which may shift the time.
    pub fn stays(&mut self, time: &mut Time, order: &Order) -> bool {
        let (index, skipped) = (self.read, &order.skipped);
        self.read += 1;
        if self.last.replace(*time) == Some(*time) {
            return false;
        }
        *time = order.shifts.apply(index, *time);
        while skipped.get(self.passed).is_some_and(|&skipped| skipped < index) {
            self.passed += 1;
        }
        skipped.get(self.passed) != Some(&index)
    }
}
