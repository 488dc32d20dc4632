//! Files of a plot: in, a format and a machine or none; out, bytes.

use crate::base::{Error, Result, or_nearest};
use crate::plot::machine::{Machine, MachineFormat};
use crate::plot::plot::Plot;

impl MachineFormat {
    /// The format of a file's suffix, in upper or lower case.
    ///
    /// # Errors
    /// [`Error::Option`] with the suffixes that there are.
    pub fn of_suffix(suffix: &str) -> Result<Self> {
        let all = [Self::Svg, Self::Gcode, Self::Hpgl];
        let found = all.into_iter().find(|format| format.name().eq_ignore_ascii_case(suffix));
        found.ok_or_else(|| {
            let sentence = or_nearest(Self::SUFFIXES, suffix, Self::WORDS.iter().copied(), |suffix| format!(".{suffix}"));
            Error::option("suffix", suffix, sentence)
        })
    }

    /// All suffixes, for messages.
    pub const SUFFIXES: &str = ".svg, .gcode or .hpgl";

    /// The machine that a file is written for where none is named; none for SVG, which is for any.
    ///
    /// # Errors
    /// [`Error::Internal`] if a shipped profile is damaged.
    pub fn usual_machine(self) -> Result<Option<Machine>> {
        match self {
            Self::Svg => Ok(None),
            Self::Gcode => Machine::shipped("grbl").map(Some),
            Self::Hpgl => Machine::shipped("hp7475a").map(Some),
        }
    }
}

impl Plot {
    /// The bytes of the plot's file. The same plot always gives the same.
    ///
    /// # Errors
    /// [`Error::Input`] if the machine reads something else, or does not reach all of the plot.
    pub fn write(&self, format: MachineFormat, machine: Option<&Machine>) -> Result<Vec<u8>> {
        let usual = if machine.is_none() { format.usual_machine()? } else { None };
        let machine = machine.or(usual.as_ref());
        match (format, machine) {
            (MachineFormat::Svg, machine) => self.to_svg(machine),
            (MachineFormat::Gcode, Some(machine)) => self.to_gcode(machine),
            (MachineFormat::Hpgl, Some(machine)) => self.to_hpgl(machine),
            (_, None) => Err(Error::Internal("a file of commands is for no machine".to_owned())),
        }
        .map(String::into_bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::plot::samples::small;

    #[test]
    fn a_suffix_says_the_format() {
        for word in MachineFormat::WORDS {
            assert_eq!(MachineFormat::of_suffix(&word.to_uppercase()).unwrap().name(), *word);
            assert!(MachineFormat::SUFFIXES.contains(&format!(".{word}")));
        }
        let error = MachineFormat::of_suffix("gcod").unwrap_err().to_string();
        assert_eq!(error, "suffix is gcod, but it must be .svg, .gcode or .hpgl; did you mean .gcode?");
    }

    #[test]
    fn files_are_for_a_machine_of_their_kind() {
        let mut plot = small();
        plot.layers.truncate(1);
        for format in [MachineFormat::Svg, MachineFormat::Gcode, MachineFormat::Hpgl] {
            assert!(!plot.write(format, None).unwrap().is_empty());
        }
        let laser = Machine::shipped("grbl-laser").unwrap();
        let error = plot.write(MachineFormat::Svg, Some(&laser)).unwrap_err().to_string();
        assert_eq!(error, "the machine GRBL laser reads gcode, not svg");
    }
}
