//! A pen in place of areas: in, the flags of a command line; out, of any drawing its plot, the plot's file and what it comes to.

use std::path::Path;

use clap::ArgMatches;
use graphstipple_core::stages::{Checked, Machine, MachineFormat, PEN_SETTINGS, Pen, Plot, PlotStats, Preset, Value, plot};
use graphstipple_core::{Control, Drawing, Export, Format};

use crate::arguments::export;
use crate::error::{Error, Result};
use crate::files::suffix_of_plot;
use crate::machines::machine;
use crate::messages::in_flags;

/// The machine whose times are told where none is named: an SVG is mostly for one.
const USUAL: &str = "axidraw";

/// A pen, and for which machine its plot is written.
#[derive(Debug, Clone)]
pub(crate) struct Plotter {
    pen: Checked<Pen>,
    export: Checked<Export>,
    format: MachineFormat,
    machine: Option<Machine>,
}

impl Plotter {
    /// What the flags ask for, if they name a pen; the file is `output`, or SVG on standard output.
    ///
    /// # Errors
    /// [`crate::error::Error::Usage`] for the first rule that they break; those of [`machine`].
    pub(crate) fn of(matches: &ArgMatches, output: Option<&Path>, preset: Option<&Preset>) -> Result<Option<Self>> {
        let given = |name: &str| matches.get_one::<String>(name).cloned();
        let Some(width) = given("pen") else { return Ok(None) };
        let mut pen = Pen::of_width(&Value::Word(width)).map_err(in_flags)?;
        for setting in PEN_SETTINGS.iter().filter(|setting| setting.name != "pen") {
            let Some(text) = given(&setting.full_name()) else { continue };
            let number = text.parse().ok().filter(|_| matches!(setting.value_name, "PART" | "DEGREES")).map(Value::Number);
            pen.set(setting.name, &number.unwrap_or(Value::Word(text))).map_err(in_flags)?;
        }
        let format = output.map_or(Ok(MachineFormat::Svg), suffix_of_plot)?;
        let svg = Format::ALL[0];
        let export = export(matches, preset, svg, &[svg]).and_then(Export::check).map_err(in_flags)?;
        for (is_given, flag) in [(export.trap.is_some(), "--trap"), (export.registration_marks, "--registration-marks")] {
            if is_given {
                return Err(Error::Usage(format!("{flag} must be left out with --pen: it is for plates that are printed")));
            }
        }
        let machine = given("machine").map(|name| machine(&name)).transpose().map_err(|error| match error {
            Error::Core(error) => in_flags(error),
            other => other,
        })?;
        Ok(Some(Self { pen: pen.check().map_err(in_flags)?, export, format, machine }))
    }

    /// The paths of a drawing.
    ///
    /// # Errors
    /// As [`plot`].
    pub(crate) fn plot(&self, drawing: &Drawing, control: &Control) -> Result<Plot> {
        plot(drawing, &self.pen, &self.export, control).map_err(in_flags)
    }

    /// The bytes of a plot's file.
    ///
    /// # Errors
    /// As [`Plot::write`].
    pub(crate) fn write(&self, plot: &Plot) -> Result<Vec<u8>> {
        plot.write(self.format, self.machine.as_ref()).map_err(in_flags)
    }

    /// What a plot comes to on the machine that it is for, or on a usual one.
    ///
    /// # Errors
    /// [`graphstipple_core::Error::Internal`] if a shipped profile is damaged.
    pub(crate) fn stats(&self, plot: &Plot) -> Result<PlotStats> {
        if let Some(machine) = &self.machine {
            return Ok(plot.stats(machine));
        }
        let usual = self.format.usual_machine()?.map_or_else(|| Machine::shipped(USUAL), Ok)?;
        Ok(plot.stats(&usual))
    }
}
