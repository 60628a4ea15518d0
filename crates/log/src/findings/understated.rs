//! A receiver whose places scatter by more than it states of them.

use hovernav::ekf::{Channel, Innovation, Notice, Verdict};

use super::{Judged, when};
use crate::finding::{Finding, Severity};

/// A mean square of the normalised innovations beyond this is of one-sigmas that are too small; where they are right, up to
/// 1.8 was seen, for a part of them wanders.
const UNDERSTATED: f64 = 3.0;
/// Fewer fixes tell nothing.
const LEAST: usize = 50;

pub(super) fn find(log: &Judged<'_>, findings: &mut Vec<Finding>) {
    let stated = log.dataset.fixes.iter().filter(|fix| fix.position_sigma_m.is_some()).count();
    if 2 * stated <= log.dataset.fixes.len() {
        return;
    }
    // Not the tally of the run: that counts the reopened, each as large as a jump.
    let level = [Channel::PositionNorth, Channel::PositionEast].map(|channel| {
        let accepted = log.run.notices.iter().filter_map(|notice| match notice {
            Notice::Updated(report) => report
                .innovations()
                .find(|axis| axis.channel == channel && axis.verdict == Verdict::Accepted)
                .map(Innovation::normalised),
            _ => None,
        });
        accepted.fold((0, 0.0), |(count, sum), off| (count + 1, sum + off * off))
    });
    let [(north, of_north), (east, of_east)] = level;
    let least = (of_north / north as f64).min(of_east / east as f64);
    let Some((start_s, end_s)) = log.span_s() else { return };
    if north.min(east) < LEAST || least <= UNDERSTATED {
        return;
    }
    findings.push(Finding {
        start_s,
        end_s,
        sensor: "gps",
        kind: "understated",
        severity: Severity::Warning,
        count: north,
        words: format!(
            "gps states its places surer than they are {}: the {north} that were taken in scatter by {:.1} times \
             what their one-sigmas let expect, so that those of the solution's position are too small by about as \
             much, and right ones may be refused",
            when(start_s, end_s),
            least.sqrt()
        ),
    });
}
