//! The command that flies one flight of a campaign again.

use std::env;

/// Options that a single flight cannot have; each except the last has a value.
const OF_CAMPAIGN: [&str; 4] = ["--flights", "--seed", "--shard", "--no-report"];

/// Command that repeats one flight of this campaign, without its seed. It contains the user's arguments except
/// `OF_CAMPAIGN`, and ends with `--record`. The seed is to be appended.
pub fn command() -> String {
    of(env::args().skip(1))
}

fn of(arguments: impl IntoIterator<Item = String>) -> String {
    let mut text = String::from("hovernav");
    let mut arguments = arguments.into_iter();
    while let Some(argument) = arguments.next() {
        let (name, value) = match argument.split_once('=') {
            Some((name, value)) => (name, Some(value)),
            None => (argument.as_str(), None),
        };
        if !OF_CAMPAIGN.contains(&name) {
            text += " ";
            text += &quoted(&argument);
        } else if value.is_none() && Some(&name) != OF_CAMPAIGN.last() {
            arguments.next();
        }
    }
    text + " --record"
}

/// An argument as a shell reads it.
fn quoted(argument: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+@%".contains(c);
    match argument.is_empty() || !argument.chars().all(is_plain) {
        true => format!("'{}'", argument.replace('\'', "'\\''")),
        false => argument.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_concerns_many_flights_is_dropped_and_the_rest_stays_readable_by_a_shell() {
        let of = |words: &[&str]| of(words.iter().map(|word| (*word).to_owned()));
        let flown =
            ["campaign", "--flights", "8", "--jams=1", "--no-report", "--seed=3", "--out", "a b"];
        assert_eq!(of(&flown), "hovernav campaign --jams=1 --out 'a b' --record");
        assert_eq!(
            of(&["campaign", "--out", "it's"]),
            r"hovernav campaign --out 'it'\''s' --record"
        );
    }
}
