//! The compile options as arguments of commands.

use crate::options::{Choice, OPTIONS, OptionRow, Request, Takes, Wrong};
use clap::builder::TypedValueParser;

/// The options for making kernels, for printing them, for specialisation, or for the precision alone.
pub(super) struct Options<const OF: u8 = MADE>(pub(super) Vec<Choice>);

pub(super) const MADE: u8 = 0;
pub(super) const PRINTED: u8 = 1;
pub(super) const KNOWN: u8 = 2;
pub(super) const REAL: u8 = 3;

impl<const OF: u8> Options<OF> {
    fn rows() -> impl Iterator<Item = &'static OptionRow> {
        OPTIONS.iter().filter(|row| match row.name {
            "real" => OF == PRINTED || OF == REAL,
            "target" => OF == PRINTED,
            "fixed" | "set" => OF == MADE || OF == KNOWN,
            _ => OF == MADE,
        })
    }

    /// The request that results from the options.
    pub(super) fn request(&self) -> Request {
        Request::default().with(&self.0)
    }
}

impl<const OF: u8> clap::Args for Options<OF> {
    fn augment_args(command: clap::Command) -> clap::Command {
        command.args(Options::<OF>::rows().map(argument))
    }

    fn augment_args_for_update(command: clap::Command) -> clap::Command {
        Options::<OF>::augment_args(command)
    }
}

impl<const OF: u8> clap::FromArgMatches for Options<OF> {
    fn from_arg_matches(matches: &clap::ArgMatches) -> Result<Options<OF>, clap::Error> {
        let mut choices = Vec::new();
        for row in Options::<OF>::rows() {
            let given = row.takes != Takes::Nothing;
            let words = if given { matches.get_many::<String>(row.name) } else { None };
            let words: Vec<&str> = words.into_iter().flatten().map(String::as_str).collect();
            if if given { !words.is_empty() } else { matches.get_flag(row.name) } {
                // Each value has been parsed before.
                let wrong =
                    |wrong: Wrong| clap::Error::raw(clap::error::ErrorKind::InvalidValue, wrong.message);
                choices.push(row.read(&words).map_err(wrong)?);
            }
        }
        Ok(Options(choices))
    }

    fn update_from_arg_matches(&mut self, matches: &clap::ArgMatches) -> Result<(), clap::Error> {
        *self = Options::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Converts an option to a clap argument.
fn argument(row: &'static OptionRow) -> clap::Arg {
    let several = if row.is_list() { "; may be repeated" } else { "" };
    let argument = clap::Arg::new(row.name).long(row.name).help(format!("{}{several}", row.summary));
    let values = (row.values)();
    let argument = match row.takes {
        Takes::Nothing => return argument.action(clap::ArgAction::SetTrue),
        Takes::One => argument.value_name(row.name.to_uppercase()),
        Takes::Some => argument.value_name(row.name.to_uppercase() + ",…").value_delimiter(','),
        Takes::Names => argument.value_name(row.noun.to_uppercase()).value_delimiter(','),
        Takes::Numbers => argument.value_name("NAME=VALUE"),
    };
    let action = if row.is_list() { clap::ArgAction::Append } else { clap::ArgAction::Set };
    let argument = argument.action(action);
    if values.is_empty() {
        let read = |text: &str| match row.read(&[text]) {
            Ok(_) => Ok(text.to_owned()),
            Err(wrong) => Err(wrong.message),
        };
        return argument.value_parser(read);
    }
    argument.value_parser(clap::builder::PossibleValuesParser::new(values).map(|value| value))
}
