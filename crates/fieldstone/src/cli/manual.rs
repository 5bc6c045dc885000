//! Shell completions and man pages, from the same definitions as the help.

use std::path::PathBuf;

use anyhow::bail;
use clap::{Args, CommandFactory};

use super::{Cli, report};

/// Print a completion script for a shell
///
/// For bash: fieldstone completions bash > /etc/bash_completion.d/fieldstone
#[derive(Debug, Args)]
pub(crate) struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: clap_complete::Shell,
}

impl Completions {
    pub fn run(self) -> anyhow::Result<()> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "fieldstone", &mut script);
        report::print(&String::from_utf8(script)?)
    }
}

/// Write the man pages, one per subcommand, into a folder
#[derive(Debug, Args)]
pub(crate) struct Manual {
    /// Folder for fieldstone.1, fieldstone-fraction.1, …; it must exist
    folder: PathBuf,
}

impl Manual {
    pub fn run(self) -> anyhow::Result<()> {
        if !self.folder.is_dir() {
            bail!("{}: this folder does not exist; make it first", self.folder.display());
        }
        clap_mangen::generate_to(Cli::command(), &self.folder)
            .map_err(|e| anyhow::anyhow!("{}: cannot write the man pages: {e}", self.folder.display()))
    }
}
