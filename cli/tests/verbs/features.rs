//! A build that lacks a feature names it.

use crate::common::{HELI, hovernav, place, refusal, text};

#[test]
fn a_verb_that_is_left_out_names_its_feature() {
    for (verb, feature, built) in [
        ("bench", "bench", cfg!(feature = "bench")),
        ("init", "formats", cfg!(feature = "formats")),
        ("ground", "ground", cfg!(feature = "ground")),
        ("fly", "fly", cfg!(all(feature = "fly", target_os = "linux"))),
        ("play", "fly", cfg!(feature = "fly")),
        ("campaign", "lab", cfg!(feature = "lab")),
        ("design", "lab", cfg!(feature = "lab")),
        ("identify", "lab", cfg!(feature = "lab")),
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

#[test]
fn a_log_and_an_export_that_are_left_out_name_their_features() {
    let place = place("left-out");
    let log = place.join("flight.ulg");
    std::fs::write(&log, b"ULog\x01\x12\x35\x01").unwrap();
    let message = refusal(&["info", text(&log)]);
    let is_named = message.contains("lacks the feature `formats`");
    assert_eq!(is_named, !cfg!(feature = "formats"), "{message}");

    let asked = hovernav(&["estimate", HELI, "--out", text(&place), "--export", "kml"]);
    assert_eq!(asked.status.success(), cfg!(feature = "export"), "{asked:?}");
    let message = String::from_utf8_lossy(&asked.stderr);
    assert_eq!(message.contains("feature `export`"), !cfg!(feature = "export"), "{message}");
}
