//! With a full disk, the flight continues and reports the failure of the record.

use std::process::Command;

use crate::common::{Setup, flown};
use crate::failsafes::{Moment, engaged_at};

/// Environment variable with the index of the moment, for the process with the file size limit.
const MOMENT: &str = "HOVERNAV_FULL_AT_MOMENT";
/// Length of the flight, s.
const LENGTH_S: f64 = 22.0;

/// The flight in a separate process, because a limit of the file size applies to a whole process.
#[test]
fn flight_with_a_limit() {
    let Some(number) = std::env::var_os(MOMENT) else { return };
    let moment = Moment::ALL[number.to_str().unwrap().parse::<usize>().unwrap()];
    let flown =
        flown(&Setup { disk_full_s: Some(moment.second()), ..engaged_at(moment, LENGTH_S) });
    assert_eq!(flown.crashed_s, None);
    let engaged_s = flown.statistics().engaged_s;
    assert!(engaged_s > LENGTH_S - 10.0, "{moment:?}: {engaged_s} s");
    let said = |text: &str| flown.said.iter().any(|line| line.text.as_str().contains(text));
    assert!(said("the record is not written: File too large"), "{moment:?}: {:#?}", flown.said);
    let record = &flown.record;
    assert!(!record.is_ended && record.cycles.len() > 200, "it opens up to there");
}

#[test]
fn a_flight_continues_without_space_for_its_record() {
    for (number, moment) in Moment::ALL.into_iter().enumerate() {
        // The signal would end the process. When it is ignored, writing fails as on a full disk.
        let flown = Command::new("bash")
            .args(["-c", "trap '' XFSZ; exec \"$0\" \"$@\""])
            .arg(std::env::current_exe().unwrap())
            .args(["--exact", "full_record::flight_with_a_limit", "--nocapture"])
            .env(MOMENT, number.to_string())
            .output()
            .unwrap();
        assert!(flown.status.success(), "{moment:?}: {}", String::from_utf8_lossy(&flown.stderr));
    }
}
