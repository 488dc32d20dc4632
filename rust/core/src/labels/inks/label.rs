//! All that labels the nodes of a drawing of several inks.

use rayon::prelude::*;

use crate::base::{Control, Result};
use crate::diffusion::{Diffusion, diffuse_inks};
use crate::graph::Triangulation;
use crate::inks::{Mixing, Mixture};
use crate::labels::inks::{NO_GROUND, clean_inks, grounds_inks, refine_inks, split_inks, stipple_inks};
use crate::labels::{Labels, Refinement, Stippled};
use crate::options::{ErrorWeighting, Options};

/// What the nodes show, one of each a node.
#[derive(Debug, Clone, Copy)]
pub struct Inked<'a> {
    /// The colours of the labels.
    pub mixing: &'a Mixing,
    /// Mixtures for the emphasized colours, which shapes are made of.
    pub emphasized: &'a [Mixture],
    /// Mixtures for the colours without emphasis.
    pub plain: &'a [Mixture],
    /// Those colours, sRGB-encoded in [0, 1].
    pub colours: &'a [[f32; 3]],
}

/// The labels of a canvas of `width` x `height` pixels, with the dots of its smooth parts. `areas` are those of the nodes' cells in px^2.
///
/// # Errors
/// [`crate::Error::Input`] if there is not one of each a node; [`crate::Error::Cancelled`].
pub fn label_inks(
    triangulation: &Triangulation,
    areas: &[f64],
    inked: Inked,
    size: (usize, usize),
    options: &Options,
    control: &Control,
) -> Result<Labels> {
    let (graph, Inked { mixing, emphasized, plain, colours }) = (&*triangulation.graph, inked);
    let weighting = (options.published.error_weighting == ErrorWeighting::Area).then_some(areas);
    let grounds = grounds_inks(graph, plain, colours, mixing, options.stippling)?;
    // In smooth parts shapes are the ground, which passes no error on.
    let drawn = |(ground, mixture): (&u8, &Mixture)| if *ground == NO_GROUND { *mixture } else { Mixture::pure(*ground) };
    let mixtures: Vec<Mixture> = grounds.par_iter().zip(emphasized).map(drawn).collect();
    let mut labels = diffuse_inks(graph, &mixtures, mixing, weighting, &Diffusion::of_tone(options), control)?;
    labels.iter_mut().zip(&grounds).filter(|(_, ground)| **ground != NO_GROUND).for_each(|(label, ground)| *label = *ground);
    refine_inks(graph, (&mixtures, mixing), areas, &grounds, &mut labels, &Refinement::of(options, None), control)?;
    split_inks(graph, &mixtures, &mut labels, options.split)?;
    if options.stippling == 0.0 {
        return Ok(Labels { labels, shift: 0.0, marks: None, inks: None });
    }
    clean_inks(graph, plain, &mut labels)?;
    let Stippled { labels, marks } = stipple_inks(triangulation, &grounds, plain, areas, &labels, size, control)?;
    Ok(Labels { labels, shift: 0.0, marks: Some(marks), inks: None })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::noise;
    use crate::diffusion::diffuse;
    use crate::graph::{cells, triangulate};
    use crate::inks::mixtures;
    use crate::labels::smooth::STRUCTURED;
    use crate::labels::{clean, drawn_tones, grounds, refine, split, stipple};

    fn canvas(nodes: usize, side: usize) -> (Triangulation, Vec<f64>) {
        let columns = nodes.isqrt();
        let spacing = side as f64 / columns as f64;
        let off = |k: usize| 0.5 + 0.3 * f64::from(noise(k as u64));
        let site = |k: usize| [(k % columns) as f64 + off(2 * k), (k / columns) as f64 + off(2 * k + 1)].map(|v| v * spacing);
        let sites: Vec<[f64; 2]> = (0..columns * columns).map(site).collect();
        let areas = cells(&sites, side, side, 2, None, &Control::new()).unwrap().areas;
        (triangulate(sites, side, side, &Control::new()).unwrap(), areas)
    }

    fn colours(triangulation: &Triangulation, side: f64) -> Vec<[f32; 3]> {
        let colour = |[x, y]: &[f64; 2]| {
            let (x, y) = (x / side, y / side);
            let texture = 0.1 * (300.0 * x * y).sin() * (40.0 * y).cos();
            [x + texture, y - texture, 0.5 + 0.5 * (9.0 * (x - y)).sin()].map(|v| v.clamp(0.0, 1.0) as f32)
        };
        triangulation.graph.sites.iter().map(colour).collect()
    }

    fn seven() -> Mixing {
        let colours = [[0; 3], [230, 30, 40], [20, 120, 60], [10, 60, 180], [250, 220, 40], [120, 120, 120], [255; 3]];
        Mixing::new(&colours, false).unwrap()
    }

    #[test]
    fn every_label_has_about_its_share_whatever_the_threads() {
        let (triangulation, areas) = canvas(40_000, 200);
        let (mixing, colours) = (seven(), colours(&triangulation, 200.0));
        let plain = mixtures(&colours, &mixing);
        let run = |threads: usize, stippling: f64| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let inked = Inked { mixing: &mixing, emphasized: &plain, plain: &plain, colours: &colours };
            let options = Options { stippling, ..Options::default() };
            pool.install(|| label_inks(&triangulation, &areas, inked, (200, 200), &options, &Control::new()).unwrap())
        };
        let labels = run(1, 0.5);
        assert!(labels == run(3, 0.5) && run(2, 0.0).marks.is_none());
        let drawn = labels.marks.unwrap().areas;
        let total: f64 = areas.iter().sum();
        let grounds = grounds_inks(&triangulation.graph, &plain, &colours, &mixing, 0.5).unwrap();
        for label in 0..7 {
            // A dot takes its mark's area from its ground.
            let is_dot = |node: usize| grounds[node] != NO_GROUND && labels.labels[node] != grounds[node];
            let own = |node: usize| {
                let is_own = labels.labels[node] == label;
                match (is_dot(node), is_own, grounds[node] == label) {
                    (true, true, _) => drawn[node],
                    (true, false, true) => areas[node] - drawn[node],
                    (true, false, false) => 0.0,
                    (false, true, _) => areas[node],
                    (false, false, _) => 0.0,
                }
            };
            let found: f64 = (0..areas.len()).map(own).sum::<f64>() / total;
            let wanted: f64 =
                plain.iter().zip(&areas).map(|(mixture, area)| f64::from(mixture.part(label)) * area).sum::<f64>() / total;
            // Colours are kept, not shares: inks may stand in for one another.
            assert!((found - wanted).abs() < 0.04, "{label}: {found} of {wanted}");
        }
    }

    #[test]
    #[ignore = "a measurement"]
    fn time_beside_black_and_white() {
        let (triangulation, areas) = canvas(300_000, 1000);
        let (graph, options, control) = (&*triangulation.graph, Options::default(), Control::new());
        // Half of it smooth, half with a texture.
        let textured = |(k, (colour, [x, _])): (usize, ([f32; 3], &[f64; 2]))| {
            let texture = if *x < 500.0 { 0.0 } else { 0.15 * noise(k as u64 / 2) };
            colour.map(|v| (v + texture).clamp(0.0, 1.0))
        };
        let smooth = colours(&triangulation, 1000.0).into_iter();
        let colours: Vec<[f32; 3]> = smooth.zip(&graph.sites).enumerate().map(textured).collect();
        let tones: Vec<f32> = colours.iter().map(|[r, g, b]| 0.299 * r + 0.587 * g + 0.114 * b).collect();
        for _ in 0..2 {
            let began = std::time::Instant::now();
            let found = grounds(graph, &tones, 0.5).unwrap();
            let drawn = drawn_tones(&found, &tones);
            let mut labels = diffuse(graph, &drawn, None, &Diffusion::of_tone(&options), &control).unwrap();
            refine(graph, &drawn, &areas, Some(&found), &mut labels, &Refinement::of(&options, Some(0.5)), &control).unwrap();
            split(graph, &drawn, &mut labels, options.split).unwrap();
            clean(graph, &tones, &mut labels).unwrap();
            stipple(&triangulation, &found, &tones, &areas, &labels, (1000, 1000), &control).unwrap();
            let smooth = found.iter().filter(|ground| **ground != STRUCTURED).count();
            println!("black and white: {:.3} s, {smooth} smooth", began.elapsed().as_secs_f64());
        }
        let sixty: Vec<[u8; 3]> = (0..64u64).map(|k| [0, 1, 2].map(|c| (127.5 + 127.4 * noise(3 * k + c)) as u8)).collect();
        for mixing in [seven(), Mixing::new(&[[0; 3], [255; 3]], false).unwrap(), Mixing::new(&sixty, false).unwrap()] {
            let began = std::time::Instant::now();
            let plain = mixtures(&colours, &mixing);
            let mixed = began.elapsed().as_secs_f64();
            let inked = Inked { mixing: &mixing, emphasized: &plain, plain: &plain, colours: &colours };
            let mut part = std::time::Instant::now();
            let mut lap = |what: &str| {
                print!("{what} {:.3} ", part.elapsed().as_secs_f64());
                part = std::time::Instant::now();
            };
            let found = grounds_inks(graph, &plain, &colours, &mixing, 0.5).unwrap();
            lap("grounds");
            let mut labels = diffuse_inks(graph, &plain, &mixing, None, &Diffusion::of_tone(&options), &control).unwrap();
            lap("diffusion");
            refine_inks(graph, (&plain, &mixing), &areas, &found, &mut labels, &Refinement::of(&options, None), &control).unwrap();
            lap("refine");
            stipple_inks(&triangulation, &found, &plain, &areas, &labels, (1000, 1000), &control).unwrap();
            lap("stipple");
            let began = std::time::Instant::now();
            label_inks(&triangulation, &areas, inked, (1000, 1000), &options, &control).unwrap();
            let smooth = found.iter().filter(|ground| **ground != NO_GROUND).count();
            println!(
                "\n{} labels: {:.3} s and {mixed:.3} s for mixtures, {smooth} smooth",
                mixing.labels(),
                began.elapsed().as_secs_f64()
            );
        }
    }
}
