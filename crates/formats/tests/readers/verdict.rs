//! The verdict does not call a solution usable if its own log contradicts the solution.

use hovernav_dataset::LogError;
use hovernav_findings::FindingKind;
use hovernav_formats::{Changes, Options, Pass, open};
use hovernav_score::Level;
use hovernav_testing::shared;

#[test]
fn a_solution_that_the_onboard_estimator_contradicts_is_not_usable() {
    let Some(path) = shared("logs/px4-quad-vibration-2025.ulg") else { return };
    let mut log = open(&path, &Options::default()).unwrap();
    let changes = Changes::default();
    let estimated = log
        .estimate(&path, &changes, false, |dataset, config, keep| {
            Pass::over(dataset, config, keep, false, |_| Ok::<_, LogError>(()), |_| Ok(()))
        })
        .unwrap();
    let summary = log.judge(&path, &changes, false, &estimated).unwrap().summary;
    let verdict = summary.verdict.unwrap();
    assert_eq!(verdict.level, Level::Bad, "{verdict:?}");
    assert!(!verdict.words.contains("usable"), "{verdict:?}");
    // A span of 3.4 s with the largest harm is listed before 23 s of clipping.
    assert!(verdict.reasons[0].contains("contradicted by the onboard EKF2"), "{verdict:?}");
    assert!(summary.warnings.contains(&verdict.reasons[0]));
    let contradiction =
        summary.findings.iter().find(|one| one.kind == FindingKind::Contradicted).unwrap();
    assert!((65.0..75.0).contains(&contradiction.start_s), "{contradiction:?}");
    let harm = contradiction.harm.unwrap();
    assert!(harm.position_m.unwrap() > 10.0 && harm.one_sigmas.unwrap() > 10.0, "{harm:?}");
}
