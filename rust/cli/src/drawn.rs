//! From a photo to its drawing: in, a job and the photo's file; out, the drawing as it is asked for, or the finest that keeps within the job's limits.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use graphstipple_core::stages::{Changes, Checked, Reading, Trials, draw_owned};
use graphstipple_core::{Control, Importance, Options, Outcome, Photo, Session};

use crate::arguments::Job;
use crate::error::Result;
use crate::files::{self, Input};
use crate::messages::in_flags;

/// A drawing, with sentences for the user.
pub(crate) struct Drawn {
    pub(crate) outcome: Outcome,
    /// What was done so that it keeps the job's rules.
    pub(crate) changes: Option<Changes>,
    pub(crate) warnings: Vec<String>,
}

/// Draws what the job asks for.
pub(crate) fn draw(job: &Job, mut input: Input, control: &Control) -> Result<Drawn> {
    if !job.limits.is_none() {
        return draw_within(job, &mut input, control);
    }
    let read = read(job, &mut input, &job.options, control)?;
    // What came through a pipe is not needed any more.
    drop(input);
    let outcome = draw_owned(read.photo, read.importance, &job.options, control)?;
    let (mut outcome, changes) = kept(job, outcome, read.least_radius, control)?;
    outcome.stats.add_seconds(read.seconds);
    Ok(finished(outcome, changes, read.warnings, read.decoder))
}

/// The finest drawing within the job's limits.
fn draw_within(job: &Job, input: &mut Input, control: &Control) -> Result<Drawn> {
    control.begin_round();
    let mut begun = read(job, input, &job.options, control)?;
    let pixels = (begun.photo.width() * begun.photo.height()) as f64;
    let mut trials = Trials::new(job.options.clone(), pixels, job.writer.clone(), job.limits.clone());
    // What all drawings took but the one that is taken.
    let mut spent = std::mem::take(&mut begun.seconds);
    let mut session = Session::new(begun.photo, begun.importance);
    let mut finest: Option<(Outcome, Option<Changes>)> = None;
    while let Some(options) = trials.next_options()? {
        if !session.fits(&options) {
            // Fewer nodes can do with a photo that is reduced further.
            let again = read(job, input, &options, control)?;
            add(&mut spent, again.seconds);
            session = Session::new(again.photo, again.importance);
        }
        let (outcome, changes) = kept(job, session.draw(&options, control)?, begun.least_radius, control)?;
        let seconds = match &job.plotter {
            Some(plotter) if job.limits.max_seconds.is_some() => {
                Some(plotter.stats(&plotter.plot(&outcome.drawing, control)?)?.timing.seconds)
            }
            _ => None,
        };
        let is_finest = trials.tell(&outcome.drawing, outcome.stats.nodes, seconds)?;
        let drawn = (outcome, changes);
        let other = if is_finest { finest.replace(drawn) } else { Some(drawn) };
        add(&mut spent, other.map(|(other, _)| other.stats.seconds).unwrap_or_default());
        control.begin_round();
    }
    let within = trials.found().map_err(in_flags)?;
    let Some((mut outcome, changes)) = finest else {
        return Err(graphstipple_core::Error::Internal("what was found was not kept".into()).into());
    };
    outcome.stats.add_seconds(spent);
    outcome.stats.within = Some(within);
    Ok(finished(outcome, changes, begun.warnings, begun.decoder))
}

/// Adds the seconds of other drawings, by stage; their totals come of themselves.
fn add(seconds: &mut BTreeMap<String, f64>, others: BTreeMap<String, f64>) {
    for (stage, spent) in others.into_iter().filter(|(stage, _)| stage != "total") {
        *seconds.entry(stage).or_default() += spent;
    }
}

fn finished(mut outcome: Outcome, changes: Option<Changes>, mut warnings: Vec<String>, decoder: String) -> Drawn {
    warnings.extend(outcome.warning.take());
    outcome.stats.decoder = Some(decoder);
    Drawn { outcome, changes, warnings }
}

/// A photo and its importance, and what was heard of their files.
struct Read {
    photo: Photo,
    importance: Importance,
    /// The least radius of a stipple in pixels of the canvas.
    least_radius: Option<f64>,
    decoder: String,
    warnings: Vec<String>,
    seconds: BTreeMap<String, f64>,
}

/// Reads the photo and its importance for a drawing with these options.
fn read(job: &Job, input: &mut Input, options: &Checked<Options>, control: &Control) -> Result<Read> {
    let reading = Reading { options: Some(options.clone()), colour: options.wants_colour(), ..job.reading.clone() };
    let mut seconds = BTreeMap::new();
    let begin = Instant::now();
    let decoded = input.read(&reading, control)?;
    let of_photo = decoded.warning.map(|warning| files::told(input.path(), &warning));
    let photo = decoded.photo;
    seconds.insert("decoding".to_owned(), begin.elapsed().as_secs_f64());
    let (photo, of_subject) = match &job.subject {
        Some(subject) => {
            let begin = Instant::now();
            let found = files::with_subject(photo, input, subject, &reading, control)?;
            seconds.insert("subject".to_owned(), begin.elapsed().as_secs_f64());
            found
        }
        None => (photo, None),
    };
    // Sizes that cannot be are better told now than after the work.
    let least_radius = job.check_sizes(photo.width(), photo.height())?;
    let evaluated = files::evaluate(job.importance.clone(), job.map.as_deref(), photo.luma(), &reading, &mut seconds, control)?;
    let warnings = of_photo.into_iter().chain(of_subject).chain(evaluated.warning).collect();
    Ok(Read { photo, importance: evaluated.importance, least_radius, decoder: decoded.decoder, warnings, seconds })
}

/// The outcome as the job's rules allow it, and what was done to it; or with no stipple below this radius.
fn kept(job: &Job, mut outcome: Outcome, least: Option<f64>, control: &Control) -> Result<(Outcome, Option<Changes>)> {
    if let Some(keeper) = &job.keeper {
        return keeper.kept(outcome, control);
    }
    let Some(least) = least else { return Ok((outcome, None)) };
    let (drawing, changes) = outcome.drawing.with_least_radius(least)?;
    outcome.stats.recount(&drawing, changes.enlarged, changes.dropped);
    outcome.drawing = Arc::new(drawing);
    Ok((outcome, None))
}
