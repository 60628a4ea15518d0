//! Tallies of all comparisons, and thinning of the routine ones.

use std::collections::BTreeMap;

use hovernav::ekf::{Channel, Notice, Report, Verdict};

/// Tally of all comparisons of one channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChannelTally {
    /// Number of comparisons that corrected the state.
    pub used: usize,
    /// Number of comparisons that a gate rejected.
    pub rejected: usize,
    /// Sum of the squared normalised innovations of the used comparisons.
    pub square_sum: f64,
}

impl ChannelTally {
    pub(crate) fn count(tallies: &mut BTreeMap<&'static str, Self>, report: &Report) {
        for axis in report.innovations() {
            let channel = tallies.entry(axis.channel.name()).or_default();
            if axis.verdict == Verdict::Rejected {
                channel.rejected += 1;
            } else {
                channel.used += 1;
                channel.square_sum += axis.normalised().powi(2);
            }
        }
    }
}

/// Tally of all fixes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FixTally {
    /// Number of fixes with at least one channel that corrected the state.
    pub used: usize,
    /// Number of fixes with at least one channel that a gate rejected.
    pub rejected: usize,
}

impl FixTally {
    pub(crate) fn count(&mut self, report: &Report) {
        if report.innovations().any(|axis| axis.channel.is_of_fix()) {
            self.used += usize::from(report.any_accepted());
            self.rejected += usize::from(report.any_rejected());
        }
    }
}

/// Thinning of the routine comparisons among the notices of a run. At most 65 536 of fixes and 32 768 of each other aid
/// stay, evenly spaced.
#[derive(Clone, Debug, Default)]
pub(crate) struct Thinning(BTreeMap<Channel, Aid>);

#[derive(Clone, Copy, Debug)]
struct Aid {
    /// Number of comparisons of which one stays.
    stride: usize,
    seen: usize,
    kept: usize,
}

/// Largest number of comparisons of fixes that stay, an hour at 18 Hz. It is even, so that halves are whole numbers.
const MOST_OF_FIXES: usize = 1 << 16;
/// Largest number of comparisons of each other aid that stay.
const MAX: usize = 1 << 15;

impl Thinning {
    /// Whether the next routine comparison of `channel` stays. May remove half of those in `notices` to make room.
    pub fn takes(&mut self, channel: Channel, notices: &mut Vec<Notice>) -> bool {
        let aid = self.0.entry(channel).or_insert(Aid { stride: 1, seen: 0, kept: 0 });
        let index = aid.seen;
        aid.seen += 1;
        if !index.is_multiple_of(aid.stride) {
            return false;
        }
        let most = if channel.is_of_fix() { MOST_OF_FIXES } else { MAX };
        if aid.kept == most {
            let mut nth = 0;
            notices.retain(|notice| {
                let is_of_aid = routine(notice) == Some(channel);
                nth += usize::from(is_of_aid);
                !is_of_aid || nth % 2 == 1
            });
            aid.kept = most / 2;
            aid.stride *= 2;
        }
        aid.kept += 1;
        true
    }
}

/// First channel of a routine comparison, which is accepted as a whole and has no event; `None` otherwise.
pub(crate) fn routine(notice: &Notice) -> Option<Channel> {
    let Notice::Updated(report) = notice else { return None };
    let first = report.innovations().next()?.channel;
    let is_accepted = report.innovations().all(|axis| axis.verdict == Verdict::Accepted);
    let is_remarkable = report.bias_variance_was_raised()
        || report.covariance_was_reset()
        || report.contradicts_itself()
        || report.position_drift_m().is_some();
    (is_accepted && !is_remarkable).then_some(first)
}
