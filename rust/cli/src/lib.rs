//! The command line of graphstipple: one [`run`] for the native binary and for the console script that pip installs.
//!
//! [`files`] reads photos and [`writing`] writes drawings; the Python package calls them too.

mod arguments;
mod command;
mod drawn;
pub mod error;
pub mod files;
pub mod machines;
mod messages;
pub mod plates;
mod plotter;
pub mod recipe;
mod rules;
mod scratch;
mod shell;
pub mod writing;

use std::ffi::OsString;
use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

use graphstipple_core::stages::{Pool, picture, raster, schema};
use graphstipple_core::{Control, presets};
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Value, json};

use arguments::Job;
use command::{COMPLETIONS, HELP_ALL, LIST_PRESETS, MAN, OPTIONS_SCHEMA, command};
use drawn::Drawn;
pub use error::{Error, INTERRUPTED, Result};
use files::Input;
use messages::in_flags;
use rules::broken;
use writing::Target;

/// How often the waiting thread looks for an interruption and moves the progress bar: well under the half second within which
/// an interruption must end the run, and too seldom to cost anything.
const POLL: Duration = Duration::from_millis(50);

/// Work under this long shows no progress bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// Steps of the progress bar.
const STEPS: u64 = 1000;

/// Runs the command with the given arguments, the first of which is the program's name.
///
/// The work is done on as many threads as the options ask for; this one asks `interrupted` every 50 ms and returns soon after it says
/// yes by an exit code, such as [`INTERRUPTED`], without waiting for the workers, whose result is dropped. Files are written by this
/// thread alone, when everything is done, and to the end: an interruption that comes then is too late. Writing to pipes and devices,
/// which may take any time, is interrupted as the work is.
///
/// Returns the exit code: 0 done, 1 failed, 2 wrong usage, 3 done but for rules that must be kept, that of an interruption. What went wrong is one line on standard error.
pub fn run(arguments: impl IntoIterator<Item = OsString>, interrupted: &dyn Fn() -> Option<u8>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let done = match printed(&arguments) {
        _ if arguments.get(1).is_some_and(|first| first == command::STUDIO) => Err(Error::Usage(
            "the studio comes with Python's command, and this one is without: pip install graphstipple[studio]".to_owned(),
        )),
        _ if arguments.get(1).is_some_and(|first| first == command::BATCH) => Err(Error::Usage(
            "batches of photos come with Python's command, and this one is without: pip install graphstipple".to_owned(),
        )),
        Some(text) => text.and_then(|text| print(io::stdout(), text.as_bytes())),
        None => Job::of(arguments).and_then(|job| execute(&job, interrupted)),
    };
    done.map_or_else(|error| report(&error), |()| 0)
}

/// What is printed in place of drawing, if a flag asks for it: then nothing else is looked at.
fn printed(arguments: &[OsString]) -> Option<Result<String>> {
    // What comes behind -- is a path, whatever it looks like.
    let texts: Vec<&str> =
        arguments.iter().skip(1).take_while(|argument| *argument != "--").map(|it| it.to_str().unwrap_or_default()).collect();
    texts.iter().enumerate().find_map(|(place, argument)| {
        let flag = match *argument {
            "-h" => "help",
            "-V" => "version",
            flag => flag.strip_prefix("--")?,
        };
        Some(Ok(match flag.split_once('=').unwrap_or((flag, "")) {
            ("help", "") => help(false),
            (HELP_ALL, "") => help(true),
            ("version", "") => format!("graphstipple {}\n", env!("CARGO_PKG_VERSION")),
            (LIST_PRESETS, "") => list_of_presets(),
            (OPTIONS_SCHEMA, "") => serde_json::to_string_pretty(&schema()).expect("names and numbers always serialize") + "\n",
            (MAN, "") => shell::man(),
            (COMPLETIONS, "") => return Some(shell::completions(texts.get(place + 1).copied().unwrap_or_default())),
            (COMPLETIONS, shell) => return Some(shell::completions(shell)),
            _ => return None,
        }))
    })
}

/// The help, with every option or with those that people turn.
fn help(with_all: bool) -> String {
    command(with_all).render_help().to_string().trim_end().to_owned() + "\n"
}

/// A line for each preset: its name and what it gives.
fn list_of_presets() -> String {
    let all = presets();
    let longest = all.iter().map(|preset| preset.name.len()).max().unwrap_or(0);
    all.iter().map(|preset| format!("{:longest$}  {}\n", preset.name, preset.description)).collect()
}

/// Tells an error in one line; returns its exit code.
fn report(error: &Error) -> u8 {
    // An interruption was the user's own; nothing needs to be said.
    if !matches!(error, Error::Interrupted(_) | Error::Core(graphstipple_core::Error::Cancelled)) {
        let text = error.to_string().replace("allow_damaged", "--allow-damaged").replace("force=True", "--force");
        let line: Vec<&str> = text.lines().map(str::trim).collect();
        // With standard error closed there is nobody left to tell.
        let _ = writeln!(io::stderr(), "graphstipple: error: {}", line.join(" "));
    }
    error.exit_code()
}

fn execute(job: &Job, interrupted: &dyn Fn() -> Option<u8>) -> Result<()> {
    for path in job.paths_to_write() {
        Target::find(path, job.force)?;
    }
    let mut bar = Bar::new(!job.quiet);
    let work = job.clone();
    let made = watched(job.options.threads, interrupted, |progress| bar.show(progress), move |control| make(&work, control))?;
    drop(bar);

    // One thread that waits with the bytes for whoever takes them.
    let pour = |writing: Box<dyn FnOnce() -> Result<()> + Send>| watched(Some(1), interrupted, |_| (), move |_| writing());
    let files = made.files.into_iter().map(|(path, bytes)| Ok((Target::find(&path, job.force)?, bytes)));
    writing::write_all(files.collect::<Result<_>>()?, |stream, bytes| pour(Box::new(move || stream.write(&bytes))))?;
    for warning in &made.warnings {
        // With standard error closed there is nobody to tell.
        let _ = writeln!(io::stderr(), "graphstipple: warning: {warning}");
    }
    let stats = job.stats.then(|| serde_json::to_string_pretty(&made.stats).expect("numbers and names always serialize") + "\n");
    let printed = match (made.standard_output, stats) {
        (Some(svg), stats) => {
            pour(Box::new(move || print(io::stdout(), &svg)))?;
            stats.map_or(Ok(()), |stats| print(io::stderr(), stats.as_bytes()))
        }
        (None, Some(stats)) => print(io::stdout(), stats.as_bytes()),
        (None, None) => Ok(()),
    };
    printed.and_then(|()| made.broken.map_or(Ok(()), |told| Err(Error::Broken(told))))
}

/// Writes to a stream; a reader that has gone away is no error.
fn print(mut stream: impl Write, bytes: &[u8]) -> Result<()> {
    match stream.write_all(bytes).and_then(|()| stream.flush()) {
        Err(source) if source.kind() != io::ErrorKind::BrokenPipe => Err(Error::File { path: PathBuf::from("-"), source }),
        _ => Ok(()),
    }
}

/// What a run makes, before any of it is written.
struct Made {
    files: Vec<(PathBuf, Vec<u8>)>,
    standard_output: Option<Vec<u8>>,
    stats: Value,
    /// Sentences for the user.
    warnings: Vec<String>,
    /// What is told in the end, if the drawing breaks rules and must not.
    broken: Option<String>,
}

/// Does work on so many threads, and waits for it or for an interruption; `look` is shown how far it is now and then.
fn watched<T: Send + 'static>(
    threads: Option<usize>,
    interrupted: &dyn Fn() -> Option<u8>,
    mut look: impl FnMut((&'static str, f32)),
    work: impl FnOnce(&Control) -> Result<T> + Send + 'static,
) -> Result<T> {
    let control = Arc::new(Control::new());
    let (sender, receiver) = mpsc::channel();
    let of_worker = Arc::clone(&control);
    Pool::start(threads, move || {
        // Nobody listens any more after an interruption.
        let _ = sender.send(work(&of_worker));
    });
    loop {
        let received = receiver.recv_timeout(POLL);
        if let Some(code) = interrupted() {
            control.cancel();
            return Err(Error::Interrupted(code));
        }
        match received {
            Ok(done) => return done,
            Err(RecvTimeoutError::Timeout) => look(control.progress()),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(graphstipple_core::Error::Internal("the worker stopped without a result".into()).into());
            }
        }
    }
}

/// The whole work, from the photo's bytes to those of the outputs.
fn make(job: &Job, control: &Control) -> Result<Made> {
    let input = job.photo.as_deref().map_or_else(Input::standard, Input::file);
    let Drawn { outcome, changes, warnings } = drawn::draw(job, input, control)?;
    let drawing = Arc::clone(&outcome.drawing);
    let mut made = Made { files: Vec::new(), standard_output: None, stats: Value::Null, warnings, broken: None };
    let plot = job.plotter.as_ref().map(|plotter| plotter.plot(&drawing, control).map(|plot| (plotter, plot))).transpose()?;
    let files: Vec<(Option<PathBuf>, Vec<u8>)> = match (&plot, &job.output) {
        (Some((plotter, plot)), output) => vec![(output.clone(), plotter.write(plot)?)],
        (None, output) => {
            made.warnings.extend(job.writer.warning(&drawing));
            match output {
                Some(path) if job.has_plates => {
                    let plates = plates::files(path, &drawing, &job.writer).map_err(in_flags)?;
                    // Inks of a photo have their names only now.
                    job.check_paths(&plates.iter().map(|(path, _)| path.clone()).collect::<Vec<_>>())?;
                    plates.into_iter().map(|(path, bytes)| (Some(path), bytes)).collect()
                }
                output => vec![(output.clone(), job.writer.write(&drawing)?)],
            }
        }
    };
    made.stats = serde_json::to_value(&outcome.stats).expect("numbers and names always serialize");
    if let (Some((plotter, plot)), Value::Object(stats), true) = (&plot, &mut made.stats, job.stats) {
        let of_plot = serde_json::to_value(plotter.stats(plot)?).expect("numbers and names always serialize");
        stats.insert("plot".to_owned(), of_plot);
    }
    for (path, bytes) in files {
        match path {
            None => made.standard_output = Some(bytes),
            Some(path) => made.files.push((path, bytes)),
        }
    }
    control.check()?;
    if let Some(keeper) = &job.keeper {
        let report = keeper.reported(&drawing, changes, control)?;
        made.warnings.extend(keeper.warnings(&report));
        if let Value::Object(stats) = &mut made.stats {
            stats.insert("rules".to_owned(), json!({ "changes": report.changes, "violations": report.counts() }));
        }
        if keeper.is_strict {
            made.broken = broken(&report);
        }
        if let Some((path, format)) = &keeper.report {
            made.files.push((path.clone(), report.write(*format, &drawing)?));
        }
    }
    control.check()?;
    if let Some((path, width)) = &job.preview {
        let raster = match &plot {
            Some((_, plot)) => picture(plot, *width)?,
            None => raster::rasterize(&drawing, *width)?,
        };
        made.files.push((path.clone(), raster::encode_png(&raster)?));
    }
    Ok(made)
}

impl Job {
    /// Checks that everything to write can have the size that is asked for, given that of the canvas. Returns the least radius of
    /// a stipple in pixels of the canvas, if there is one.
    fn check_sizes(&self, width: usize, height: usize) -> Result<Option<f64>> {
        [&self.writer].into_iter().chain(&self.others).try_for_each(|writer| writer.check_size(width, height))?;
        if let Some((_, preview)) = &self.preview {
            raster::size(width, height, *preview)?;
        }
        if let Some(keeper) = &self.keeper {
            keeper.scale(width, height)?;
        }
        let least = self.min_dot.map(|min_dot| self.writer.least_radius(min_dot, width, height));
        least.transpose().map_err(in_flags)
    }
}

/// A progress bar on standard error that appears only on a terminal and after [`PATIENCE`], and leaves nothing behind.
struct Bar {
    begin: Instant,
    wanted: bool,
    bar: Option<ProgressBar>,
}

impl Bar {
    fn new(wanted: bool) -> Self {
        Self { begin: Instant::now(), wanted: wanted && io::stderr().is_terminal(), bar: None }
    }

    fn show(&mut self, (stage, fraction): (&'static str, f32)) {
        if !self.wanted || self.begin.elapsed() < PATIENCE {
            return;
        }
        let bar = self.bar.get_or_insert_with(|| {
            let style = ProgressStyle::with_template("{msg:13} {wide_bar} {percent:>3} %").expect("the template is well-formed");
            ProgressBar::new(STEPS).with_style(style)
        });
        bar.set_message(stage);
        bar.set_position((f64::from(fraction) * STEPS as f64) as u64);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::fs::{self, File};

    use super::*;

    #[test]
    fn an_interruption_ends_the_run() {
        let folder = tempfile::tempdir().unwrap();
        let [photo, output] = ["photo.png", "a.svg"].map(|name| folder.path().join(name));
        let (width, height) = (2400, 1600);
        let encoder = png::Encoder::new(File::create(&photo).unwrap(), width, height);
        let grey = |i: u32| (i % width * 7 + i / width * 13) as u8;
        let values: Vec<u8> = (0..width * height).map(grey).collect();
        encoder.write_header().unwrap().write_image_data(&values).unwrap();
        let arguments: [OsString; 4] = ["graphstipple".into(), photo.into(), "-o".into(), output.clone().into()];
        // Asked for the second time, when the work has begun.
        let asked = Cell::new(0);
        let interrupted = || {
            asked.set(asked.get() + 1);
            (asked.get() >= 2).then_some(143)
        };
        assert_eq!(run(arguments.clone(), &interrupted), 143);
        assert_eq!(asked.get(), 2);
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
        assert_eq!(run(arguments, &|| None), 0);
        assert!(fs::read_to_string(output).unwrap().ends_with("</svg>\n"));
    }
}
