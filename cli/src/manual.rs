//! `hovernav completions` and `hovernav man`: shell completions and manual pages.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Command;
use clap_complete::Shell;
use clap_mangen::Man as ManualPage;

use crate::{help, output};

#[derive(clap::Args)]
pub struct Completions {
    /// The shell to complete for
    shell: Shell,
}

#[derive(clap::Args)]
pub struct Man {
    /// The directory for hovernav.1 and one page per subcommand
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
    let mut command = command.name("hovernav").disable_help_subcommand(true);
    command.build();
    write_pages(&command, dir)?;
    output::say(format_args!("{}: written", dir.display()));
    Ok(())
}

/// Writes the page of a command and of all its subcommands.
fn write_pages(command: &Command, dir: &Path) -> anyhow::Result<()> {
    for verb in command.get_subcommands().filter(|verb| !verb.is_hide_set()) {
        write_pages(verb, dir)?;
    }
    let man = ManualPage::new(command.clone());
    let mut page = Vec::new();
    man.render(&mut page)?;
    for section in [help::examples(command.get_name()).as_str(), help::EXIT_STATUS] {
        let (title, lines) = section.split_once(":\n").unwrap_or_default();
        if lines.is_empty() {
            continue;
        }
        // Without filling, each line stays a line.
        write!(page, ".SH \"{}\"\n.nf\n{}\n.fi\n", title.to_uppercase(), lines.trim_end())?;
    }
    output::write(&dir.join(man.get_filename()), page)
}
