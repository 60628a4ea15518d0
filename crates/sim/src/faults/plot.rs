//! Plot of the outcomes of a campaign.

use std::fmt::Write as _;

use super::campaign::Outcome;
use super::measure::Measures;
use super::tables::cells;

/// Height of a row, px.
const ROW: f64 = 16.0;
/// Height of the space above each flight's rows, px.
const HEAD: f64 = 46.0;
/// Width of the column of names, px.
const NAMES: f64 = 190.0;
/// Width of a plot, px.
const PLOT: f64 = 330.0;
/// Width of the gap after a plot, px.
const GAP: f64 = 40.0;
/// Width of the picture, px.
const WIDTH: f64 = NAMES + 2.0 * PLOT + 2.0 * GAP;

/// One plot: its title, the plotted quantity of a run, and its axis from 0 to 1.
struct Plot {
    title: &'static str,
    value: fn(&Measures) -> f64,
    place: fn(f64) -> f64,
    /// Labels of the axis.
    ticks: [(f64, &'static str); 4],
    goal: f64,
}

/// Plots of the fraction of samples inside 3 sigma, from 80 % on, and of the cost, 0.8 to 80 times on a logarithmic
/// axis.
const PLOTS: [Plot; 2] = [
    Plot {
        title: "velocity and attitude inside 3σ, % of all samples",
        value: |measures| measures.inside_motion,
        place: |share| (share - 0.8) / 0.2,
        ticks: [(0.8, "80"), (0.9, "90"), (0.97, "97"), (1.0, "100")],
        goal: 0.97,
    },
    Plot {
        title: "largest cost of velocity, position, tilt and yaw; orange: not named",
        value: Measures::largest_cost,
        place: |cost| (cost / 0.8).log10() / 2.0,
        ticks: [(1.0, "1"), (2.0, "2"), (10.0, "10"), (80.0, "80")],
        goal: 1.2,
    },
];

/// An SVG of all runs, with one row per fault. It shows the fraction of the samples inside 3 sigma, and the cost of the
/// fault. The cost is orange if no warning names the fault. Values beyond the axis are drawn at its end. Runs without a
/// solution are omitted.
#[must_use]
pub fn svg(outcomes: &[Outcome]) -> String {
    let flights = cells(outcomes);
    let height: f64 = flights.iter().map(|(_, rows)| HEAD + 30.0 + ROW * rows.len() as f64).sum();
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" width=\"{WIDTH}\" \
         height=\"{height}\" font-family=\"sans-serif\" font-size=\"11\">\n<style>.goal{{stroke:#c33;stroke-dasharray:3 3}}\
         .end{{stroke:#ccc}}.run,.unnamed{{stroke-linecap:round;stroke-width:5;stroke:#247;stroke-opacity:.45}}\
         .unnamed{{stroke:#e80;stroke-opacity:.8}}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
    );
    let mut top = 0.0;
    for (flight, rows) in flights {
        let (first, last) = (top + HEAD, top + HEAD + ROW * rows.len() as f64);
        let _ = writeln!(
            text,
            "<text x=\"4\" y=\"{:.0}\" font-weight=\"bold\">{flight}</text>",
            top + 18.0
        );
        for (row, (faults, _)) in rows.iter().enumerate() {
            let name = if faults.is_empty() { "none" } else { faults };
            let (x, y) = (NAMES - 8.0, first + ROW * (row as f64 + 0.75));
            let _ =
                writeln!(text, "<text x=\"{x}\" y=\"{y:.0}\" text-anchor=\"end\">{name}</text>");
        }
        for (number, plot) in PLOTS.iter().enumerate() {
            let left = NAMES + number as f64 * (PLOT + GAP);
            let _ =
                writeln!(text, "<text x=\"{left}\" y=\"{:.0}\">{}</text>", top + 36.0, plot.title);
            let across = |value: f64| left + PLOT * (plot.place)(value).clamp(0.0, 1.0);
            for (value, label) in plot.ticks {
                let (x, y) = (across(value), last + 14.0);
                let _ = writeln!(
                    text,
                    "<path class=\"end\" d=\"M{x:.0} {first:.0}V{last:.0}\"/>\
                     <text x=\"{x:.0}\" y=\"{y:.0}\" text-anchor=\"middle\">{label}</text>"
                );
            }
            let goal = across(plot.goal);
            let _ = writeln!(text, "<path class=\"goal\" d=\"M{goal:.0} {first:.0}V{last:.0}\"/>");
            let mut dots = [String::new(), String::new()];
            for (row, (faults, cell)) in rows.iter().enumerate() {
                let y = first + ROW * (row as f64 + 0.5);
                for measures in cell.iter().filter(|measures| measures.samples > 0) {
                    let value = (plot.value)(measures);
                    let is_against_itself = number == 1 && faults.is_empty();
                    if value.is_nan() || is_against_itself {
                        continue;
                    }
                    let x = across(value);
                    let is_unnamed = number == 1 && !measures.named && value > plot.goal;
                    let _ = write!(dots[usize::from(is_unnamed)], "M{x:.0} {y:.0}h0");
                }
            }
            for (dots, class) in dots.iter().zip(["run", "unnamed"]) {
                let _ = writeln!(text, "<path class=\"{class}\" d=\"{dots}\"/>");
            }
        }
        top = last + 30.0;
    }
    text + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outcome(faults: &str, inside_motion: f64, cost: f64, named: bool) -> Outcome {
        let measures = Measures {
            samples: 100,
            inside_motion,
            cost: [cost, f64::NAN, f64::NAN, f64::NAN],
            named,
            ..Measures::default()
        };
        Outcome {
            flight: "hover".into(),
            faults: faults.into(),
            kinds: Vec::new(),
            seed: 1,
            made: Vec::new(),
            measures,
        }
    }

    #[test]
    fn every_run_has_a_dot_in_each_plot_and_one_that_was_not_named_another_colour() {
        let picture = svg(&[
            outcome("", 0.99, 0.0, false),
            outcome("gap=2", 0.97, 1.1, false),
            outcome("gap=2", 0.5, 8.0, true),
            outcome("lever-arm=1", 0.9, 2.0, false),
        ]);
        let dots = |class: &str| -> Vec<usize> {
            let before = format!("class=\"{class}\" d=\"");
            let paths = picture.split(before.as_str()).skip(1);
            paths.map(|path| path.split('"').next().unwrap().matches("h0").count()).collect()
        };
        assert_eq!((dots("run"), dots("unnamed")), (vec![4, 2], vec![0, 1]));
        // 97 % is drawn at the goal, and a value beyond the axis at its end.
        let goal = NAMES + 0.85 * PLOT;
        assert!(picture.contains(&format!("M{goal:.0} 70h0")));
        assert!(picture.contains(&format!("M{NAMES} 70h0")));
    }
}
