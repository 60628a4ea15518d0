//! `hovernav completions` and `hovernav man`: what shells and `man` know of the command.

use std::path::PathBuf;

use anyhow::Context as _;
use clap::Command;
use clap_complete::Shell;

use crate::output;

#[derive(clap::Args)]
pub struct Completions {
    /// The shell
    shell: Shell,
}

#[derive(clap::Args)]
pub struct Man {
    /// The directory to write hovernav.1 and a page for each verb to
    dir: PathBuf,
}

pub fn completions(arguments: &Completions, mut command: Command) -> anyhow::Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "hovernav", &mut script);
    output::print(String::from_utf8(script)?);
    Ok(())
}

pub fn man(arguments: &Man, command: Command) -> anyhow::Result<()> {
    let dir = &arguments.dir;
    output::create(dir)?;
    let command = command.name("hovernav");
    clap_mangen::generate_to(command, dir)
        .with_context(|| format!("cannot write manual pages to {}", dir.display()))?;
    output::say(format_args!("{}: written", dir.display()));
    Ok(())
}
