//! Outcomes of a campaign as tables.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use hovernav_score::Axis;

use super::campaign::Outcome;
use super::measure::{AXES, Measures};

/// The runs of one flight and one set of faults.
pub(super) type Cell<'a> = Vec<&'a Measures>;

/// Outcomes by flight and faults, in the order in which they first appear.
pub(super) fn cells(outcomes: &[Outcome]) -> Vec<(&str, Vec<(&str, Cell<'_>)>)> {
    let mut flights: Vec<(&str, Vec<(&str, Cell<'_>)>)> = Vec::new();
    let mut places: BTreeMap<(&str, &str), (usize, usize)> = BTreeMap::new();
    for Outcome { flight, faults, measures, .. } in outcomes {
        let (flight_place, cell_place) = *places.entry((flight, faults)).or_insert_with(|| {
            let known = flights.iter().position(|(name, _)| name == flight);
            let place = known.unwrap_or_else(|| {
                flights.push((flight, Vec::new()));
                flights.len() - 1
            });
            flights[place].1.push((faults, Vec::new()));
            (place, flights[place].1.len() - 1)
        });
        flights[flight_place].1[cell_place].1.push(measures);
    }
    flights
}

/// The `fraction`-quantile of the known values of a measure, by nearest rank; NaN without a known value. It is not
/// interpolated: a measure may be infinite, and interpolation between two infinite values gives no number.
fn quantile(cell: &Cell<'_>, fraction: f64, of: impl Fn(&Measures) -> f64) -> f64 {
    let mut values: Vec<f64> =
        cell.iter().map(|measures| of(measures)).filter(|value| !value.is_nan()).collect();
    values.sort_by(f64::total_cmp);
    let rank = (fraction * values.len().saturating_sub(1) as f64).round() as usize;
    values.get(rank).copied().unwrap_or(f64::NAN)
}

/// Axis with the smallest fraction inside 3 sigma, in the worst run.
fn worst_axis(cell: &Cell<'_>) -> String {
    let worst = (0..6)
        .map(|axis| (axis, quantile(cell, 0.0, |m| m.inside[axis])))
        .filter(|(_, share)| share.is_finite())
        .min_by(|a, b| a.1.total_cmp(&b.1));
    worst.map_or_else(
        || "–".into(),
        |(axis, share)| format!("{} {}", short(AXES[axis]), percent(share)),
    )
}

fn short(axis: Axis) -> &'static str {
    axis.name().split('_').next().unwrap_or_default()
}

fn percent(share: f64) -> String {
    if share.is_nan() { "–".into() } else { format!("{:.1}", 100.0 * share) }
}

fn figure(value: f64) -> String {
    match value.abs() {
        _ if value.is_nan() => "–".into(),
        _ if value.is_infinite() => "never".into(),
        size if size >= 100.0 => format!("{value:.0}"),
        size if size >= 10.0 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

/// Median and worst value of a measure, as text.
fn both(cell: &Cell<'_>, of: impl Fn(&Measures) -> f64) -> String {
    let (median, worst) = (quantile(cell, 0.5, &of), quantile(cell, 1.0, &of));
    match cell.len() {
        _ if worst.is_nan() => figure(worst),
        1 => figure(worst),
        _ => format!("{} / {}", figure(median), figure(worst)),
    }
}

/// A table for each flight, in Markdown. Two numbers are the median and the worst of the runs; percentages are those of
/// the worst run.
#[must_use]
pub fn markdown(outcomes: &[Outcome]) -> String {
    let mut text = String::new();
    for (flight, cells) in cells(outcomes) {
        let _ = writeln!(text, "\n## {flight}\n");
        let _ = writeln!(
            text,
            "| fault | runs | lost | in 3σ: motion | position | jointly | worst axis | error/σ | worst \
             velocity, m/s | pulled, m | pulled, m/s | pulled yaw, ° | back after, s | cost: velocity | \
             position | tilt | yaw | named |"
        );
        let _ = writeln!(text, "|{}", "---|".repeat(18));
        for (faults, cell) in cells {
            let count =
                |is: fn(&Measures) -> bool| cell.iter().filter(|measures| is(measures)).count();
            let lost = [
                (count(|m| m.panicked), "panic"),
                (count(|m| m.nan), "NaN"),
                (count(|m| m.diverged), "div"),
                (count(|m| m.samples == 0 && !m.panicked), "refused"),
            ];
            let lost: Vec<String> = (lost.iter().filter(|(count, _)| *count > 0))
                .map(|(count, what)| format!("{count} {what}"))
                .collect();
            let least = |of: fn(&Measures) -> f64| percent(quantile(&cell, 0.0, of));
            let is_clean = faults.is_empty();
            let row = [
                if is_clean { "none".into() } else { faults.replace(' ', ", ") },
                cell.len().to_string(),
                lost.join(", "),
                least(|m| m.inside_motion),
                least(|m| m.inside_position),
                least(|m| m.inside_jointly),
                worst_axis(&cell),
                both(&cell, |m| m.normalised_motion),
                both(&cell, |m| m.worst_velocity_mps),
                if is_clean {
                    both(&cell, |m| m.horizontal_rmse_m)
                } else {
                    both(&cell, |m| m.pulled_m)
                },
                if is_clean {
                    both(&cell, |m| m.velocity_rmse_mps)
                } else {
                    both(&cell, |m| m.pulled_mps)
                },
                if is_clean {
                    both(&cell, |m| m.yaw_rmse_deg)
                } else {
                    both(&cell, |m| m.pulled_yaw_deg)
                },
                both(&cell, |m| m.back_after_s),
                both(&cell, |m| m.cost[0]),
                both(&cell, |m| m.cost[1]),
                both(&cell, |m| m.cost[2]),
                both(&cell, |m| m.cost[3]),
                match is_clean {
                    true => format!("{} warn", count(|m| !m.warnings.is_empty())),
                    false => format!("{}/{}", count(|m| m.named), cell.len()),
                },
            ];
            let _ = writeln!(text, "| {} |", row.join(" | "));
        }
    }
    text
}

/// A row for each run, in CSV.
#[must_use]
pub fn csv(outcomes: &[Outcome]) -> String {
    let mut text =
        String::from("flight,faults,seed,start_s,duration_s,samples,panicked,nan,diverged");
    for axis in AXES {
        let _ = write!(text, ",inside_{}", axis.name());
    }
    text.push_str(",inside_motion,inside_position,inside_jointly");
    for axis in AXES {
        let _ = write!(text, ",normalised_{}", axis.name());
    }
    text.push_str(
        ",normalised_motion,velocity_rmse_mps,horizontal_rmse_m,tilt_rmse_deg,yaw_rmse_deg,\
         worst_velocity_mps,worst_horizontal_m,pulled_m,pulled_mps,pulled_yaw_deg,back_after_s,\
         cost_velocity,cost_position,cost_tilt,cost_yaw,named\n",
    );
    for Outcome { flight, faults, seed, made, measures: m, .. } in outcomes {
        let window = made.first().map(|made| made.window);
        let bound = |of: Option<f64>| {
            of.filter(|s| s.is_finite()).map_or(String::new(), |s| format!("{s:.3}"))
        };
        let (start, length) =
            (bound(window.map(|w| w.start_s)), bound(window.map(|w| w.duration_s)));
        let _ = write!(
            text,
            "{flight},{faults},{seed},{start},{length},{},{},{},{}",
            m.samples, m.panicked, m.nan, m.diverged
        );
        let numbers = (m.inside.into_iter())
            .chain([m.inside_motion, m.inside_position, m.inside_jointly])
            .chain(m.normalised)
            .chain([
                m.normalised_motion,
                m.velocity_rmse_mps,
                m.horizontal_rmse_m,
                m.tilt_rmse_deg,
                m.yaw_rmse_deg,
                m.worst_velocity_mps,
                m.worst_horizontal_m,
                m.pulled_m,
                m.pulled_mps,
                m.pulled_yaw_deg,
                m.back_after_s,
            ])
            .chain(m.cost);
        for number in numbers {
            let _ = if number.is_nan() { write!(text, ",") } else { write!(text, ",{number:.5}") };
        }
        let _ = writeln!(text, ",{}", m.named);
    }
    text
}
