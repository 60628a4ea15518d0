//! The standard campaign of faults over the given dataset directories and simulated flights: `cargo run --release -p
//! hovernav-sim --example injection_campaign -- SEEDS OUT DIR…`

use hovernav_sim::faults::{Campaign, Flight, csv, goals_markdown, markdown, standard_cells};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let seeds = arguments.next().ok_or("expected SEEDS OUT DIR…")?.parse()?;
    let out = std::path::PathBuf::from(arguments.next().ok_or("expected SEEDS OUT DIR…")?);
    let mut cells = standard_cells();
    let mut flights = Vec::new();
    let mut asked = Vec::new();
    for argument in arguments {
        match argument.as_str() {
            "sim" => flights.push(Flight::Simulated),
            dir if std::path::Path::new(dir).is_dir() => flights.push(Flight::Dataset(dir.into())),
            cell => {
                asked.push(cell.split(' ').map(str::parse).collect::<Result<Vec<_>, String>>()?);
            }
        }
    }
    if !asked.is_empty() {
        cells = asked;
    }
    let outcomes = Campaign { flights, cells, seeds }.run(|| {})?;
    std::fs::create_dir_all(&out)?;
    std::fs::write(out.join("results.csv"), csv(&outcomes))?;
    std::fs::write(out.join("results.json"), serde_json::to_string(&outcomes)?)?;
    let table = goals_markdown(&outcomes) + &markdown(&outcomes);
    std::fs::write(out.join("table.md"), &table)?;
    print!("{table}");
    Ok(())
}
