//! Sources of contacts on the command line, where each may say how it is to be read.

use std::fmt;

use clap::{Arg, ArgAction, ArgMatches, Args, Command, Error, FromArgMatches, error::ErrorKind};
use fieldstone::io::{ContactColumns, ContactOptions, ContactPreset};
use serde::de::value::MapAccessDeserializer;
use serde::de::{self, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// Files of contacts: one name or pattern, and what its columns mean.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ContactSource {
    /// Name of the file, or a pattern that all files of the series fit.
    pub file: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<ContactPreset>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub columns: Option<ContactColumns>,
}

impl ContactSource {
    pub fn options(&self) -> ContactOptions {
        ContactOptions { preset: self.preset, columns: self.columns.clone() }
    }
}

/// All sources. A preset or a mapping belongs to the `--contacts` before it.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub(crate) struct ContactSources(pub Vec<ContactSource>);

/// One of a list in TOML: a table, or a name alone.
struct Listed(ContactSource);

fn named(file: &str) -> ContactSource {
    ContactSource { file: file.into(), preset: None, columns: None }
}

impl<'de> Deserialize<'de> for Listed {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TableOrName;

        impl<'de> Visitor<'de> for TableOrName {
            type Value = Listed;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a file, or a table [[contacts]] with file = \"NAME\"")
            }

            fn visit_str<E: de::Error>(self, file: &str) -> Result<Listed, E> {
                Ok(Listed(named(file)))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Listed, A::Error> {
                ContactSource::deserialize(MapAccessDeserializer::new(map)).map(Listed)
            }
        }

        deserializer.deserialize_any(TableOrName)
    }
}

impl<'de> Deserialize<'de> for ContactSources {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NameOrList;

        impl<'de> Visitor<'de> for NameOrList {
            type Value = ContactSources;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("the name of a file, a list of names, or tables [[contacts]] with file = \"NAME\"")
            }

            fn visit_str<E: de::Error>(self, file: &str) -> Result<ContactSources, E> {
                Ok(ContactSources(vec![named(file)]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<ContactSources, A::Error> {
                let mut sources = Vec::new();
                while let Some(Listed(source)) = list.next_element()? {
                    sources.push(source);
                }
                Ok(ContactSources(sources))
            }
        }

        deserializer.deserialize_any(NameOrList)
    }
}

const FILE: &str = "contacts";
const PRESET: &str = "contacts-preset";
const COLUMNS: &str = "contacts-columns";

impl Args for ContactSources {
    fn augment_args(command: Command) -> Command {
        command
            .arg(
                Arg::new(FILE)
                    .long(FILE)
                    .value_name("FILE")
                    .action(ArgAction::Append)
                    .help("Contacts: LIGGGHTS or LAMMPS dump local, MercuryDPM .fstat, CSV; several are joined")
                    .long_help(
                        "Contacts: LIGGGHTS or LAMMPS dump local, MercuryDPM .fstat, CSV; .gz too. Several are joined: pairs \
                         and walls, say. For a series of files give a pattern in quotes, as in 'pair_*.dump'",
                    ),
            )
            .arg(
                Arg::new(PRESET)
                    .long(PRESET)
                    .value_name("NAME")
                    .action(ArgAction::Append)
                    .value_parser(|text: &str| text.parse::<ContactPreset>())
                    .help("What the columns of the --contacts before it are: liggghts-pair, liggghts-wall, lammps-pair, …")
                    .long_help(
                        "What the columns of the --contacts before it are: liggghts-pair and liggghts-wall (compute \
                         pair/gran/local and wall/gran/local with all keywords), lammps-pair (compute pair/local dist force \
                         fx fy fz p1 p2 p3 and property/local patom1 patom2), lammps-wall (fix wall/gran contacts; the file \
                         is that of the particles), mercury. Not needed for .fstat and for tables with common names",
                    ),
            )
            .arg(
                Arg::new(COLUMNS)
                    .long(COLUMNS)
                    .value_name("MAP")
                    .action(ArgAction::Append)
                    .value_parser(|text: &str| text.parse::<ContactColumns>())
                    .help("The same by name, as in id1=c_id[1],id2=c_id[2],normal=c_c[2..4],tangential=c_c[5..7]")
                    .long_help(
                        "What the columns of the --contacts before it are, by name, as in \
                         id1=c_id[1],id2=c_id[2],normal=c_c[2..4],tangential=c_c[5..7]. Parts: id1, id2 (or position1, \
                         position2), wall, force (or normal and tangential), point, overlap",
                    ),
            )
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for ContactSources {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let placed = |id: &str| matches.indices_of(id).into_iter().flatten().collect::<Vec<usize>>();
        let files = matches.get_many::<String>(FILE).into_iter().flatten().cloned();
        let mut sources: Vec<(usize, ContactSource)> =
            placed(FILE).into_iter().zip(files.map(|file| named(&file))).collect();
        let misplaced = |option: &str, why: &str| {
            Error::raw(ErrorKind::ArgumentConflict, format!("--{option} {why}; it belongs after its --contacts\n"))
        };
        let mut assign = |at: usize, option: &str, set: &mut dyn FnMut(&mut ContactSource)| match sources
            .iter_mut()
            .rev()
            .find(|(place, _)| *place < at)
        {
            Some((_, source)) if source.preset.is_some() || source.columns.is_some() => {
                Err(misplaced(option, "says a second time what the columns of one file are"))
            }
            Some((_, source)) => {
                set(source);
                Ok(())
            }
            None => Err(misplaced(option, "has no --contacts before it")),
        };
        let presets = matches.get_many::<ContactPreset>(PRESET).into_iter().flatten();
        for (at, &preset) in placed(PRESET).into_iter().zip(presets) {
            assign(at, PRESET, &mut |source| source.preset = Some(preset))?;
        }
        let columns = matches.get_many::<ContactColumns>(COLUMNS).into_iter().flatten();
        for (at, map) in placed(COLUMNS).into_iter().zip(columns) {
            assign(at, COLUMNS, &mut |source| source.columns = Some(map.clone()))?;
        }
        Ok(Self(sources.into_iter().map(|(_, source)| source).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
