//! Where fixes are the only source of position, the solution stays close to them.

use std::path::Path;

use hovernav_dataset::Dataset;
use hovernav_replay::estimate;
use hovernav_testing::shared;

/// RMS horizontal distance, m, of a solution from its fixes.
fn from_fixes_m(dir: &Path) -> f64 {
    let mut dataset = Dataset::open(dir).unwrap();
    let config = dataset.settings().unwrap();
    let run = estimate(&dataset, &config, |_| {});
    let squares: Vec<f64> = dataset
        .fixes
        .iter()
        .filter_map(|fix| {
            let after = run.solutions.partition_point(|solution| solution.time < fix.time);
            let solution = run.solutions.get(after).filter(|_| after > 0)?;
            let [north, east, _] = fix.position.displacement_from(&solution.position).to_array();
            Some(north * north + east * east)
        })
        .collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// These datasets lack a position reference. A filter that rejects positions inconsistent with their own velocity ends
/// 30 m from good fixes in the first dataset and 20 m in the second.
#[test]
fn a_solution_stays_by_good_fixes() {
    for (name, most_m) in
        [("quad-hover-aided", 1.2), ("quad-ardupilot-5hz", 1.5), ("uav-thor75-1hz", 3.5)]
    {
        let Some(dir) = shared(format!("datasets/{name}")) else { continue };
        let off_m = from_fixes_m(&dir);
        assert!(off_m < most_m, "{name}: {off_m:.2} m");
        println!("{name}: {off_m:.2} m");
    }
}
