//! A build without a feature names the missing feature.

use crate::common::{HELI, hovernav, place, refusal, text};

#[test]
fn a_verb_missing_from_the_build_names_its_feature() {
    for (verb, feature, built) in [
        ("bench", "bench", cfg!(feature = "bench")),
        ("init", "formats", cfg!(feature = "formats")),
        ("ground", "ground", cfg!(feature = "ground")),
        ("fly", "fly", cfg!(all(feature = "fly", target_os = "linux"))),
        ("play", "fly", cfg!(feature = "fly")),
        ("campaign", "lab", cfg!(feature = "lab")),
        ("design", "lab", cfg!(feature = "lab")),
        ("identify", "lab", cfg!(feature = "lab")),
        ("report", "record", cfg!(feature = "record")),
        ("inject", "lab", cfg!(feature = "lab")),
        ("simulate", "lab", cfg!(feature = "lab")),
        ("completions", "manual", cfg!(feature = "manual")),
        ("man", "manual", cfg!(feature = "manual")),
    ] {
        if built {
            assert!(hovernav(&[verb, "--help"]).status.success(), "{verb}");
        } else {
            let message = refusal(&[verb, "LOG"]);
            assert!(message.contains(verb) && message.contains(feature), "{message}");
        }
    }
}

// A build without the feature cannot be tested here: the tests depend on `hovernav-validate`, which enables all
// formats.
#[cfg(feature = "formats")]
#[test]
fn a_log_of_another_program_is_read_with_the_feature_formats() {
    let log = place("damaged-log").join("flight.ulg");
    std::fs::write(&log, b"ULog\x01\x12\x35\x01").unwrap();
    let message = refusal(&["info", text(&log)]);
    assert!(message.contains("found a PX4 ULog that ends within its header"), "{message}");
}

#[test]
fn an_export_missing_from_the_build_names_its_feature() {
    let place = place("left-out");
    let asked = hovernav(&["estimate", HELI, "--out", text(&place), "--export", "kml"]);
    assert_eq!(asked.status.success(), cfg!(feature = "export"), "{asked:?}");
    let message = String::from_utf8_lossy(&asked.stderr);
    assert_eq!(message.contains("feature `export`"), !cfg!(feature = "export"), "{message}");
}
