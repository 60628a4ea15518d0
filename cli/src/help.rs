//! Jobs, examples and exit status for `--help` and the manual pages.

use std::fmt::Write as _;

use clap::Command;

/// The subcommands by job.
const JOBS: &[(&str, &[&str])] = &[
    ("Logs", &["estimate", "info", "init", "convert", "score", "compare", "inject", "ablate"]),
    ("Model and autopilot", &["identify", "design", "simulate", "campaign"]),
    ("Flight", &["fly", "ground", "report", "play"]),
    ("This command", &["config", "bench", "completions", "man"]),
];

/// Examples, each with its effect, as in docs/commands.md.
const EXAMPLES: &[(&str, &str)] = &[
    ("estimate LOG", "solution.csv, summary.json, report.html"),
    ("estimate LOG --smooth", "use the whole log for every sample"),
    ("estimate LOG --outage 120:20", "the drift in 20 s without GPS"),
    ("estimate LOG --config mine.toml", "other settings, in the form of dataset.toml"),
    ("estimate LOG --export kml,mcap", "for other programs; also parquet, gpx, pos, tum, euroc"),
    ("estimate LOG --emit rust", "the settings as Rust source; also c, postcard"),
    ("score SOLUTION REFERENCE", "any solution.csv, TUM or EuRoC file"),
    ("compare A B", "the differences between solutions"),
    ("info LOG", "sensors, rates, gaps, vibration"),
    ("init FILE.csv", "a mapping of a foreign file's columns"),
    ("convert LOG --out DIR", "a directory of CSV files"),
    ("inject LOG --fault gap=2", "a copy with faults"),
    ("ablate LOG", "the effect of each mechanism of the filter"),
    ("config", "every file, column and key"),
    ("config fly.toml", "the keys of one file"),
    ("config filter.gate", "the keys of one section"),
    ("config lever_arm", "the keys that contain a word"),
    ("bench", "the time of a cycle on this machine"),
    ("completions bash", "a script for the shell"),
    ("man DIR", "manual pages"),
    ("identify LOG", "the vehicle's model, with a verdict"),
    ("identify LOG --export csv,matlab", "also its frequency responses and a MATLAB script"),
    ("identify --list", "the built-in model structures; --list NAME prints one"),
    ("identify LOG --speed 5", "the model of forward flight at 5 m/s"),
    ("design MODEL", "an autopilot with its margins; MODEL also raptor60, thesis, r50"),
    ("design MODEL --at MODEL5", "also check the gains in forward flight"),
    ("simulate --seed 7", "a flight: helicopter, wind, sensors, estimator, servos"),
    ("simulate --test-points", "steps of the sticks, for identify"),
    ("simulate --excite all=3211", "test inputs that the autopilot flies itself"),
    ("simulate --velocity 5", "forward flight at 5 m/s"),
    ("campaign --flights 1000 --seed 1", "many flights with random vehicles, winds and sensors"),
    ("fly --config fly.toml", "the flight computer"),
    ("play LOG --dmu /tmp/dmu --gps /tmp/gps", "test `hovernav fly` with a log"),
    ("report RECORD", "the flight on a page: modes, sticks, checks, timing"),
    ("ground udp:14550", "the ground station"),
];

/// Exit status of every subcommand.
pub const EXIT_STATUS: &str = "Exit status:
  0  success
  1  an error: standard error states file, line, the value found and the value expected
  2  wrong usage";

/// Adds a list of jobs, with the subcommand for each, to the help of the `command`. Adds examples and the exit status to
/// the help of each subcommand.
pub fn explained(command: Command) -> Command {
    let jobs = jobs(&command);
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{jobs}Options:\n{{options}}\n\n{EXIT_STATUS}"
    );
    command.help_template(template).mut_subcommands(|verb| {
        let mut text = format!("{}\n{EXIT_STATUS}", examples(verb.get_name()));
        if let Some(more) = verb.get_after_long_help().or(verb.get_after_help()) {
            let _ = write!(text, "\n\n{more}");
        }
        verb.after_long_help(text)
    })
}

/// The subcommands of this build by job, each with its description in one line.
fn jobs(command: &Command) -> String {
    let mut text = String::new();
    for (job, names) in JOBS {
        let verbs: Vec<&Command> =
            names.iter().filter_map(|name| command.find_subcommand(name)).collect();
        if verbs.is_empty() {
            continue;
        }
        let _ = writeln!(text, "{job}:");
        for verb in verbs {
            let about = verb.get_about().map(ToString::to_string).unwrap_or_default();
            let about = about.split([';', ':']).next().unwrap_or_default();
            let _ = writeln!(text, "  {:<13}{about}", verb.get_name());
        }
        text.push('\n');
    }
    text
}

/// The examples of a subcommand, a line each, below a heading.
pub fn examples(name: &str) -> String {
    let of_verb = EXAMPLES.iter().filter(|(line, _)| line.split(' ').next() == Some(name));
    let width = of_verb.clone().map(|(line, _)| line.len()).max().unwrap_or_default();
    let mut text = String::from("Examples:\n");
    for (line, effect) in of_verb {
        let _ = writeln!(text, "  hovernav {line:<width$}  {effect}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn every_subcommand_has_one_job_and_an_example_that_parses() {
        let command = crate::Arguments::command();
        for verb in command.get_subcommands() {
            let name = verb.get_name();
            let jobs = JOBS.iter().filter(|(_, names)| names.contains(&name)).count();
            assert_eq!(jobs, 1, "{name}");
            let examples: Vec<_> =
                EXAMPLES.iter().filter(|(line, _)| line.split(' ').next() == Some(name)).collect();
            assert!(!examples.is_empty(), "{name}");
            for (line, _) in examples {
                let words = std::iter::once("hovernav").chain(line.split(' '));
                let parsed = crate::Arguments::command().try_get_matches_from(words);
                // A build without a feature refuses its options by name.
                let lacks =
                    parsed.as_ref().is_err_and(|e| e.to_string().contains("lacks the feature"));
                assert!(parsed.is_ok() || lacks, "{line}: {parsed:?}");
            }
        }
    }

    #[test]
    fn the_page_of_commands_lists_the_examples() {
        let page = include_str!("../../docs/commands.md");
        let listed: Vec<(&str, &str)> = page
            .lines()
            .filter_map(|line| line.strip_prefix("hovernav ")?.split_once('#'))
            .map(|(line, effect)| (line.trim(), effect.trim()))
            .collect();
        assert_eq!(listed, EXAMPLES);
    }
}
