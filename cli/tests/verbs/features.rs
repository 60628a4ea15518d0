//! What a build without every feature says of the verbs that it lacks.

use crate::common::{hovernav, refusal};

#[test]
fn a_verb_that_is_left_out_names_its_feature() {
    let lab = ["campaign", "design", "identify", "inject", "simulate"].map(|verb| (verb, "lab"));
    let fly = ["fly", "play"].map(|verb| (verb, "fly"));
    for (verb, feature) in lab.into_iter().chain(fly).chain([("ground", "ground")]) {
        let built = match feature {
            "lab" => cfg!(feature = "lab"),
            "ground" => cfg!(feature = "ground"),
            _ => cfg!(feature = "fly") && (verb == "play" || cfg!(target_os = "linux")),
        };
        if built {
            assert!(hovernav(&[verb, "--help"]).status.success(), "{verb}");
        } else {
            let message = refusal(&[verb, "LOG"]);
            assert!(message.contains(verb) && message.contains(feature), "{message}");
        }
    }
}
