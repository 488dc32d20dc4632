//! Labels of other inks than black and white: in, the photo with its colour, the graph and its cells; out, labels with the palette that
//! they are of.
//!
//! Every channel is adjusted as the tone is, and every node has the means of its cell. What emphasis adds to the tone of a cell is added
//! to all three channels: it changes the luma by just that, and no hue. Emphasis makes up for what black and white lose of the photo; the
//! nearer the inks are that mix its colours, the less they lose, and the less is added.

use std::borrow::Cow;

use crate::base::{Control, Palette, Result};
use crate::graph::{TonedCells, Triangulation, cell_means, samples_per_pixel};
use crate::inks::{Mixing, Mixture, extract, mixtures};
use crate::labels::{Inked, Labels, OfInks, label_inks};
use crate::options::Options;
use crate::photo::{Colour, Field, Photo, adjusted_channel, backed};

/// The palette that a drawing of the photo has.
///
/// # Errors
/// As [`Palette::new`].
pub(super) fn palette_of(photo: &Photo, options: &Options) -> Result<Palette> {
    options.palette(|count| extract(colour_of(photo).planes(), count))
}

/// The photo's colour; that of a photo which was read without is its luma.
fn colour_of(photo: &Photo) -> Cow<'_, Colour> {
    photo.colour().map_or_else(|| Cow::Owned(Colour::grey(photo.shared_luma())), Cow::Borrowed)
}

/// The labels of the nodes, of a palette.
///
/// # Errors
/// As [`label_inks`].
pub(super) fn labels_of_inks(
    photo: &Photo,
    palette: Palette,
    triangulation: &Triangulation,
    cells: &TonedCells,
    options: &Options,
    control: &Control,
) -> Result<Labels> {
    let (colour, luma, sites) = (colour_of(photo), photo.luma(), &triangulation.graph.sites);
    let channel = |channel: usize| -> Result<Cow<'_, Field>> {
        let field = adjusted_channel(colour.planes()[channel], luma, options)?;
        Ok(if let Some(mask) = photo.subject() { backed(field, mask, options.backdrop) } else { field })
    };
    let samples = samples_per_pixel(options.budget((luma.width() * luma.height()) as f64).density);
    let [red, green, blue] = if colour.is_grey() {
        let [grey] = cell_means(sites, [&*channel(0)?], samples, control)?;
        [grey.clone(), grey.clone(), grey]
    } else {
        cell_means(sites, [&*channel(0)?, &*channel(1)?, &*channel(2)?], samples, control)?
    };
    let plain: Vec<[f32; 3]> = (0..sites.len()).map(|node| [red[node], green[node], blue[node]]).collect();
    let colours: Vec<[u8; 3]> = palette.labels().map(|label| palette.rgb(label)).collect();
    let mixing = Mixing::new(&colours, options.linear)?;
    let plain_mixtures = mixtures(&plain, &mixing);
    let apart = mean_apart(&plain_mixtures, &mixing) as f32;
    let added = |node: usize| apart * (cells.means[node] - cells.plain[node]);
    let emphasized: Vec<[f32; 3]> =
        plain.iter().enumerate().map(|(node, rgb)| rgb.map(|value| (value + added(node)).clamp(0.0, 1.0))).collect();
    let emphasized = mixtures(&emphasized, &mixing);
    let inked = Inked { mixing: &mixing, emphasized: &emphasized, plain: &plain_mixtures, colours: &plain };
    let labels = label_inks(triangulation, &cells.areas, inked, (luma.width(), luma.height()), options, control)?;
    Ok(Labels { inks: Some(OfInks { palette, mixtures: emphasized }), ..labels })
}

/// How far apart the labels are that are mixed, on average: 1 for black and white.
fn mean_apart(mixtures: &[Mixture], mixing: &Mixing) -> f64 {
    let of = |mixture: &Mixture| {
        let labels = || mixture.shares().map(|(label, _)| label);
        labels().flat_map(|a| labels().map(move |b| mixing.distance(a, b))).fold(0.0, f64::max)
    };
    let (sum, count) =
        mixtures.iter().map(of).filter(|apart| *apart > 0.0).fold((0.0, 0usize), |(sum, count), apart| (sum + apart, count + 1));
    if count == 0 { 1.0 } else { (sum / count as f64).min(1.0) }
}
