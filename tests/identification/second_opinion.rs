//! The second opinion of the frequency domain: agrees with right parameters, and reports wrong ones.

use hovernav_model::Grade;
use hovernav_sysid::helicopter::{Basis, FlightRecord, FrequencyDomain, Identification, Velocity};

use crate::data;

/// The flight included in every checkout, identified with the structure `name`.
fn identified(name: &str) -> (Identification, FlightRecord) {
    let (dataset, solutions) = data::flown();
    let found = data::identified(&dataset, &solutions, name);
    let record = FlightRecord::new(&dataset, &solutions, Velocity::Estimated).unwrap();
    (found, record)
}

#[test]
fn both_methods_find_the_same_yaw_and_heave() {
    for (structure, names) in [("yaw", ["Nr", "Nped"]), ("heave", ["Zw", "Zcol"])] {
        let (found, record) = identified(structure);
        let asked = FrequencyDomain::of(&found, &record).unwrap();
        println!("{structure}: {:.2?} {:?}", asked.parameters, asked.costs);
        assert_eq!(asked.basis, Basis::Sticks);
        assert!(asked.converged && asked.disagreements().next().is_none());
        for name in names {
            let own = asked.parameters.iter().find(|own| own.name == name).expect(name);
            assert!(own.apart() < 3.0 && own.frequency.1 < 0.2 * own.frequency.0.abs(), "{own:?}");
        }
        assert!(asked.costs.iter().all(|pair| pair.time < 50.0 && pair.frequency < 50.0));
        assert!(asked.mean_cost.1 <= asked.mean_cost.0);
    }
}

#[test]
fn a_derivative_that_the_flight_denies_is_named_and_enters_the_verdict() {
    let (mut found, record) = identified("yaw");
    let before = found.verdict(FrequencyDomain::of(&found, &record).ok().as_ref());
    let list = &mut found.identified.estimates.list;
    let pedal = list.iter_mut().find(|estimate| estimate.name == "Nped").unwrap();
    pedal.value *= 2.0;
    let asked = FrequencyDomain::of(&found, &record).unwrap();
    let named: Vec<String> = asked.disagreements().collect();
    assert!(named.iter().any(|words| words.starts_with("Nped is ")), "{named:?}");
    let pair = asked.costs.iter().find(|pair| pair.stick == "pedal" && pair.output == "r").unwrap();
    assert!(pair.time > 100.0 && pair.frequency < 50.0, "{pair:?}");
    let after = found.verdict(Some(&asked));
    assert!(after.grade >= Grade::Care);
    assert_eq!(after.reasons.len(), before.reasons.len() + named.len() + 1, "{after:?}");
}
