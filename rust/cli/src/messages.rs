//! What is wrong with arguments, in the words of the command line: flags instead of options, one line instead of a page.

use clap::Arg;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use graphstipple_core::stages::{DECLARATIONS, Declaration, Group, PUBLISHED, nearest};

use crate::command::command;
use crate::error::Error;

/// Names the flag instead of the core's option.
pub(crate) fn in_flags(error: graphstipple_core::Error) -> Error {
    match error {
        graphstipple_core::Error::Option { option, value, allowed } => {
            let flag = match option.strip_prefix(PUBLISHED).and_then(|rest| rest.strip_prefix('.')) {
                Some(parameter) => format!("{PUBLISHED} {parameter}"),
                None => option.replace('_', "-"),
            };
            // What Python calls None has a word of its own here.
            let absent = Declaration::named(&option).ok().and_then(|declaration| declaration.absent);
            let allowed = match (absent, allowed.strip_prefix("None")) {
                (Some(absent), Some(rest)) => format!("{}{rest}", absent.word),
                _ => allowed,
            };
            // Other options stand there by their names.
            let others = DECLARATIONS.iter().filter(|it| it.group != Group::Method && it.name.contains('_'));
            let allowed =
                others.fold(allowed, |allowed, other| allowed.replace(other.name, &format!("--{}", other.name.replace('_', "-"))));
            Error::Usage(format!("--{flag} is {value}, but it must be {allowed}"))
        }
        other => Error::Core(other),
    }
}

/// What clap says, in one line without its usage block and its tips, and the flag that was probably meant.
pub(crate) fn usage(error: &clap::Error) -> Error {
    let text = error.to_string();
    let told = ["\n\nUsage:", "\n\nFor more information", "\n\n  tip:"]
        .iter()
        .fold(&*text, |told, end| told.split(end).next().unwrap_or(told));
    let told = told.trim_start_matches("error: ").split_whitespace().collect::<Vec<_>>().join(" ");
    let meant = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(given)) if error.kind() == ErrorKind::UnknownArgument => meant(given),
        _ => String::new(),
    };
    Error::Usage(format!("{told}{meant} (see graphstipple --help)"))
}

/// What was probably meant by a flag that there is none of.
fn meant(given: &str) -> String {
    let Some(name) = given.split('=').next().and_then(|flag| flag.strip_prefix("--")) else { return String::new() };
    let parameter = name.replace('-', "_");
    if DECLARATIONS.iter().any(|it| it.group == Group::Method && it.name == parameter) {
        return format!(": it is a parameter of the published method, --{PUBLISHED} {parameter}=...");
    }
    let command = command(true);
    nearest(name, command.get_arguments().filter_map(Arg::get_long))
        .map_or_else(String::new, |flag| format!("; did you mean --{flag}?"))
}
