//! What can be made: in, the flags of a command line; out, of any drawing one that keeps their rules, and the report of what breaks them.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::ArgMatches;
use graphstipple_core::stages::{
    Changes, Checked, Length, Preset, RULES, Report, ReportFormat, Rules, Value, ViolationKind, check, enforce,
};
use graphstipple_core::{Control, Drawing, Export, Format, Outcome};

use crate::arguments::export;
use crate::error::{Error, Result};
use crate::files::suffix_of_report;
use crate::messages::in_flags;

/// A mean tone that differs by more is told.
const TOLD: f64 = 0.02;

/// Rules, and what is to be done by them.
#[derive(Debug, Clone)]
pub(crate) struct Keeper {
    rules: Checked<Rules>,
    export: Checked<Export>,
    /// The file of the report.
    pub(crate) report: Option<(PathBuf, ReportFormat)>,
    /// Whether the drawing stays as it is.
    only_checks: bool,
    /// Whether a drawing that breaks rules is a failure.
    pub(crate) is_strict: bool,
}

impl Keeper {
    /// What the flags ask for, if they name a rule. `min_dot` is the least radius of a dot.
    ///
    /// # Errors
    /// [`Error::Usage`] for the first rule of the command line that they break.
    pub(crate) fn of(matches: &ArgMatches, preset: Option<&Preset>, min_dot: Option<Length>) -> Result<Option<Self>> {
        let text = |name: &str| matches.get_one::<String>(name).cloned();
        let report = matches.get_one::<PathBuf>("check").cloned();
        let [only_checks, is_strict] = ["check_only", "strict"].map(|name| matches.get_flag(name));
        let given: Vec<&str> =
            RULES.iter().map(|rule| rule.name).filter(|name| *name != "min_dot" && text(name).is_some()).collect();
        let process = text("process");
        let Some(first) = process.as_ref().map(|_| "process").or(given.first().copied()) else {
            let needs = [(report.is_some(), "--check"), (only_checks, "--check-only"), (is_strict, "--strict")];
            return match needs.into_iter().find(|(is_given, _)| *is_given) {
                Some((_, flag)) => Err(Error::Usage(format!(
                    "{flag} needs rules: give --process, or one of --min-feature, --min-gap, --min-area and --islands"
                ))),
                None => Ok(None),
            };
        };
        let mut rules = process.map_or_else(|| Ok(Rules::default()), |name| Rules::of_process(&name)).map_err(in_flags)?;
        for name in &given {
            rules.set(name, &text(name).map_or(Value::Absent, Value::Word)).map_err(in_flags)?;
        }
        if let Some(radius) = min_dot {
            let diameter = Length { value: 2.0 * radius.value, ..radius };
            rules.set("min_dot", &Value::Word(diameter.to_string())).map_err(in_flags)?;
        }
        let svg = Format::ALL[0];
        let export = export(matches, preset, svg, &[svg]).and_then(Export::check).map_err(in_flags)?;
        if export.layout.width.is_none() && export.layout.page.is_none() {
            let flag = first.replace('_', "-");
            return Err(Error::Usage(format!("--{flag} is about sizes on paper: give --width or --page too")));
        }
        let report = report.map(|path| suffix_of_report(&path).map(|format| (path, format))).transpose()?;
        Ok(Some(Self { rules: rules.check().map_err(in_flags)?, export, report, only_checks, is_strict }))
    }

    /// Millimetres to a pixel of a canvas of this size.
    ///
    /// # Errors
    /// If it does not fit its page.
    pub(crate) fn scale(&self, width: usize, height: usize) -> Result<f64> {
        self.export.layout.mm_per_pixel(width, height).map_err(in_flags)
    }

    /// The drawing as the rules allow it, and what was done to it.
    ///
    /// # Errors
    /// As [`enforce`].
    pub(crate) fn kept(&self, mut outcome: Outcome, control: &Control) -> Result<(Outcome, Option<Changes>)> {
        if self.only_checks {
            return Ok((outcome, None));
        }
        let scale = self.scale(outcome.drawing.width, outcome.drawing.height)?;
        let began = Instant::now();
        let (drawing, changes) = enforce(&outcome.drawing, Some(&outcome), &self.rules, scale, control)?;
        outcome.stats.recount(&drawing, changes.dots_enlarged, changes.dots_dropped);
        outcome.stats.add_seconds([("rules".to_owned(), began.elapsed().as_secs_f64())].into());
        outcome.drawing = Arc::new(drawing);
        Ok((outcome, Some(changes)))
    }

    /// What of the drawing breaks the rules, after this was done to it.
    ///
    /// # Errors
    /// As [`check`].
    pub(crate) fn reported(&self, drawing: &Drawing, changes: Option<Changes>, control: &Control) -> Result<Report> {
        let scale = self.scale(drawing.width, drawing.height)?;
        let mut report = check(drawing, &self.rules, scale, control)?;
        report.changes = changes;
        Ok(report)
    }

    /// What whoever gets the file should know.
    pub(crate) fn warnings(&self, report: &Report) -> Vec<String> {
        let broken = broken(report).filter(|_| !self.is_strict);
        report.changes.as_ref().and_then(of_tone).into_iter().chain(broken).collect()
    }
}

/// What to say of a mean tone that what was done has changed, if it shows.
pub(crate) fn of_tone(changes: &Changes) -> Option<String> {
    let by = changes.tone - changes.tone_before;
    let comparative = if by > 0.0 { "lighter" } else { "darker" };
    (by.abs() > TOLD).then(|| {
        format!(
            "what keeps the rules is {comparative} by {:.2}: drawn larger, or with a lower --fineness, it changes less",
            by.abs()
        )
    })
}

/// What of the rules is broken, in a sentence, if any is.
pub(crate) fn broken(report: &Report) -> Option<String> {
    let counts = ViolationKind::ALL.iter().map(|kind| (report.count(*kind), *kind));
    let told: Vec<String> =
        counts.filter(|(count, _)| *count > 0).map(|(count, kind)| format!("{count} {}", kind.counted(count))).collect();
    (!told.is_empty()).then(|| format!("the drawing breaks the rules: {}", told.join(", ")))
}
