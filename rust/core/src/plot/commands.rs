//! Commands of a profile. In: lines with placeholders such as `{seconds}`; out: the lines with what these stand for.

use crate::plot::digits::push_number;
use crate::plot::machine::Machine;

/// What may stand in braces: the seconds of what the commands do, the same in milliseconds, the laser's power, and the speed of
/// drawing in mm to the minute and in cm to the second.
pub(super) const PLACEHOLDERS: &[&str] = &["seconds", "milliseconds", "power", "feed", "velocity"];

/// What stands in braces, in its order.
pub(super) fn placeholders(text: &str) -> impl Iterator<Item = &str> {
    text.split('{').skip(1).filter_map(|rest| rest.split_once('}').map(|(word, _)| word))
}

/// Appends the lines of commands, those that are empty left out, each with `end` behind it.
pub(super) fn push_commands(out: &mut String, machine: &Machine, text: &str, seconds: f64, end: &str) {
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let mut rest = line;
        while let Some((before, (word, after))) =
            rest.split_once('{').and_then(|(before, rest)| Some((before, rest.split_once('}')?)))
        {
            out.push_str(before);
            push_number(out, value_of(machine, word, seconds));
            rest = after;
        }
        out.push_str(rest);
        out.push_str(end);
    }
}

fn value_of(machine: &Machine, word: &str, seconds: f64) -> f64 {
    match word {
        "seconds" => seconds,
        "milliseconds" => 1000.0 * seconds,
        "feed" => 60.0 * machine.draw_speed,
        "velocity" => 0.1 * machine.draw_speed,
        // A profile has no other words.
        _ => machine.power,
    }
}
