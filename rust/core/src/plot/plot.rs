//! What a pen draws of a drawing, in order and with its place on the sheet, and what it comes to in lengths.

use std::ops::Range;

use crate::base::Color;
use crate::drawing::Provenance;
use crate::plot::path::{Path, PlotLayer, distance};

/// A drawing as paths for pens. All lengths are mm; paths are in mm from the drawing's top left corner, y running down.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// Width and height of the sheet. Without a sheet of its own they are those of the drawing.
    pub page: [f64; 2],
    /// The drawing's top left corner on the sheet, from the sheet's top left.
    pub origin: [f64; 2],
    /// Width and height of the drawing's canvas, in pixels.
    pub canvas: [usize; 2],
    /// Width and height of the drawing.
    pub size: [f64; 2],
    /// How wide a line the pen draws.
    pub pen: f64,
    /// What each pen draws, in the order in which they are taken.
    pub layers: Vec<PlotLayer>,
    /// How many parts narrower than the pen are drawn as one line along their middle.
    pub thin: usize,
    /// How many dots are narrower than the pen, and pressed nonetheless.
    pub small_dots: usize,
    /// After how much drawn line the pen is filled again: the machine then waits.
    pub refill: Option<f64>,
    /// The sheet's colour, where one was chosen.
    pub paper: Option<Color>,
    /// How the drawing was made.
    pub provenance: Provenance,
}

impl Plot {
    /// All paths, in the order in which they are drawn.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.layers.iter().flat_map(|layer| &layer.paths)
    }

    /// How much line is drawn. A press draws none.
    pub fn pen_down_mm(&self) -> f64 {
        self.paths().map(Path::length).sum()
    }

    /// How far the pen moves above the paper: from the sheet's top left corner to the first path, and from the end of every path to
    /// the beginning of the next one. [`Timing`](crate::stages::Timing) has the same for a machine, from its origin and back to it.
    pub fn pen_up_mm(&self) -> f64 {
        let mut at = self.origin.map(|v| -v);
        let mut sum = 0.0;
        for path in self.paths() {
            let (Some(first), Some(last)) = (path.points.first(), path.end()) else { continue };
            sum += distance(at, *first);
            at = last;
        }
        sum
    }

    /// How often the pen is lifted: after every path.
    pub fn lifts(&self) -> usize {
        self.layers.iter().map(|layer| layer.paths.len()).sum()
    }

    /// How many paths are a press of the pen.
    pub fn presses(&self) -> usize {
        self.paths().filter(|path| path.points.len() == 1).count()
    }

    /// The paths of a layer from one filling of the pen to the next, as ranges of their numbers: a pen is filled after the path that
    /// exceeds the length, so that no line is broken. None of a layer without paths.
    pub(super) fn fillings(&self, layer: &PlotLayer) -> Vec<Range<usize>> {
        let longest = self.refill.unwrap_or(f64::INFINITY);
        let (mut ranges, mut begin, mut drawn) = (Vec::new(), 0, 0.0);
        for (i, path) in layer.paths.iter().enumerate() {
            drawn += path.length();
            if drawn > longest {
                ranges.push(begin..i + 1);
                (begin, drawn) = (i + 1, 0.0);
            }
        }
        if begin < layer.paths.len() {
            ranges.push(begin..layer.paths.len());
        }
        ranges
    }
}

/// Plots made by hand, for the tests of this folder.
#[cfg(test)]
pub(super) mod samples {
    use super::*;
    use crate::base::Ink;

    /// A path of lines.
    pub(in crate::plot) fn line(points: &[[f64; 2]]) -> Path {
        Path { points: points.to_vec(), is_closed: false }
    }

    /// A circle of `corners` points.
    pub(in crate::plot) fn circle(centre: [f64; 2], radius: f64, corners: usize) -> Path {
        let point = |i: usize| {
            let angle = std::f64::consts::TAU * i as f64 / corners as f64;
            [centre[0] + radius * libm::cos(angle), centre[1] + radius * libm::sin(angle)]
        };
        Path { points: (0..corners).map(point).collect(), is_closed: true }
    }

    /// Paths of a black pen of 0.3 mm, on a sheet of 200 x 150 mm that is the drawing.
    pub(in crate::plot) fn plot(paths: Vec<Path>) -> Plot {
        let options = serde_json::Map::from_iter([("nodes".to_owned(), serde_json::Value::from(1000))]);
        Plot {
            page: [200.0, 150.0],
            origin: [0.0; 2],
            canvas: [800, 600],
            size: [200.0, 150.0],
            pen: 0.3,
            layers: vec![PlotLayer { ink: Ink::BLACK, name: "black".to_owned(), rgb: [0; 3], paths }],
            thin: 0,
            small_dots: 0,
            refill: None,
            paper: None,
            provenance: Provenance {
                version: "1.2.3".into(),
                importance: "saliency".into(),
                options,
                rest: serde_json::Map::new(),
            },
        }
    }

    /// A line, a square, a press; and a press in white.
    pub(in crate::plot) fn small() -> Plot {
        let square = Path { points: vec![[20.0, 20.0], [30.0, 20.0], [30.0, 30.0], [20.0, 30.0]], is_closed: true };
        let mut plot = plot(vec![line(&[[10.0, 10.0], [13.0, 14.0]]), square, line(&[[50.0, 60.5]])]);
        plot.layers.push(PlotLayer { ink: Ink::WHITE, name: "white".to_owned(), rgb: [255; 3], paths: vec![line(&[[1.25, 2.5]])] });
        plot
    }
}

#[cfg(test)]
mod tests {
    use super::samples::{line, plot, small};
    use super::*;

    #[test]
    fn lengths_and_lifts() {
        let plot = small();
        assert_eq!((plot.pen_down_mm(), plot.lifts(), plot.presses()), (45.0, 4, 2));
        let up: f64 = [[10.0, 10.0], [7.0, 6.0], [30.0, 40.5], [48.75, 58.0]].map(|[x, y]: [f64; 2]| x.hypot(y)).iter().sum();
        assert!((plot.pen_up_mm() - up).abs() < 1e-9);
        let empty = samples::plot(Vec::new());
        assert_eq!((empty.pen_down_mm(), empty.pen_up_mm(), empty.lifts()), (0.0, 0.0, 0));
    }

    #[test]
    fn a_pen_is_filled_between_paths() {
        let ten = || line(&[[0.0, 0.0], [10.0, 0.0]]);
        let mut plot = plot((0..6).map(|_| ten()).collect());
        let fillings = |plot: &Plot| plot.fillings(&plot.layers[0]);
        assert_eq!(fillings(&plot), vec![0..6]);
        plot.refill = Some(25.0);
        assert_eq!(fillings(&plot), vec![0..3, 3..6]);
        plot.refill = Some(20.0);
        assert_eq!(fillings(&plot), vec![0..3, 3..6], "at the length itself there is ink left");
        plot.refill = Some(1.0);
        assert_eq!(fillings(&plot), (0..6).map(|i| i..i + 1).collect::<Vec<_>>());
        plot.layers[0].paths.clear();
        assert!(fillings(&plot).is_empty());
    }
}
