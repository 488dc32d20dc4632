//! Where a plot lies on a machine. In: a plot with its place on the sheet, and the machine's origin and area; out: coordinates of the
//! machine in whole steps, or one sentence that says which size would fit.
//!
//! The sheet lies with its corner at the machine's zero, less the machine's offset. It is turned by a quarter, its top to the left,
//! where more of it then lies in the area, or where the plot fits only so; the AxiDraw's software does that by itself. A drawing
//! without a page of its own needs no sheet around it: its corner lies at zero.

use crate::base::{Error, Result};
use crate::plot::digits::millimetres;
use crate::plot::machine::{Corner, Machine, Upward};
use crate::plot::path::Path;
use crate::plot::plot::Plot;

/// What a plot may lie beside the area, in mm: less than a machine repeats, more than sizes on paper are rounded by.
const BESIDE: f64 = 0.01;

/// A rectangle: its least and its largest coordinates, in mm.
type Bounds = [[f64; 2]; 2];

/// How a plot lies on a machine.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    /// The drawing's place on the sheet.
    origin: [f64; 2],
    /// The width of the sheet if it is turned.
    turned: Option<f64>,
    /// The machine's zero on the sheet as it lies.
    zero: [f64; 2],
    is_upward: bool,
    /// Steps to the mm.
    pub(super) steps: f64,
}

impl Placed {
    /// The steps of the machine at a point of the drawing.
    pub(super) fn at(&self, point: [f64; 2]) -> [i64; 2] {
        let [x, y] = turned([self.origin[0] + point[0], self.origin[1] + point[1]], self.turned);
        let y = if self.is_upward { self.zero[1] - y } else { y - self.zero[1] };
        [x - self.zero[0], y].map(|v| (v * self.steps).round() as i64)
    }

    /// The steps of the machine along a path, into `way`: every point that is not where the one before it is. A closed path ends where
    /// it begins.
    pub(super) fn along(&self, path: &Path, way: &mut Vec<[i64; 2]>) {
        way.clear();
        let closing = path.points.first().filter(|_| path.is_closed);
        way.extend(path.points.iter().chain(closing).map(|point| self.at(*point)));
        way.dedup();
    }
}

impl Machine {
    /// That it reaches all of a plot.
    ///
    /// # Errors
    /// [`Error::Input`] if it does not, with the width that would fit.
    pub fn check(&self, plot: &Plot) -> Result<()> {
        let Some(bounds) = bounds(plot) else { return Ok(()) };
        let turns = self.turns(plot);
        if turns.into_iter().any(|turn| self.fits(plot, bounds, turn)) {
            return Ok(());
        }
        let text = |[x, y]: [f64; 2]| format!("{} x {} mm", millimetres(tenths(x)), millimetres(tenths(y)));
        let [low, high] = bounds;
        let extent = [high[0] - low[0], high[1] - low[1]];
        let is_small = |extent: [f64; 2]| extent[0] <= self.area[0] + BESIDE && extent[1] <= self.area[1] + BESIDE;
        let what = if is_small(extent) || is_small([extent[1], extent[0]]) {
            let [turn, _] = turns;
            let [least, most] = turned_bounds(bounds, turn);
            let [from, to] = self.reach(plot, turn);
            let (least, most, from, to) = (text(least), text(most), text(from), text(to));
            format!("the plot lies from {least} to {most} of its page, but the machine {} reaches from {from} to {to}", self.name)
        } else {
            format!("the plot is {}, but the machine {} draws {}", text(extent), self.name, text(self.area))
        };
        let widest = turns.into_iter().filter_map(|turn| self.scale_to_fit(plot, bounds, turn));
        let width = plot.size[0] * widest.fold(0.0, f64::max);
        let width = if width >= 1.0 { width.floor() } else { (10.0 * width).floor() / 10.0 };
        Err(Error::Input(if width > 0.0 {
            format!("{what}: a width of {}mm would fit", millimetres(width))
        } else {
            format!("{what}: a page of at most {} would fit", text(self.area))
        }))
    }

    /// How a plot lies on it. One that it does not reach lies as it is.
    pub(super) fn placed(&self, plot: &Plot) -> Placed {
        let turns = self.turns(plot);
        let turn =
            bounds(plot).and_then(|bounds| turns.into_iter().find(|turn| self.fits(plot, bounds, *turn))).unwrap_or(turns[0]);
        Placed {
            origin: plot.origin,
            turned: turn,
            zero: self.zero(plot, turn),
            is_upward: self.y == Upward::Up,
            steps: self.steps(),
        }
    }

    /// How its sheet can lie, the better way first: as it is, or turned, which is told by its width.
    fn turns(&self, plot: &Plot) -> [Option<f64>; 2] {
        let beyond = |turn| -> f64 {
            let page = turned_size(plot.page, turn);
            (0..2).map(|i| (page[i] - self.area[i]).max(0.0)).sum()
        };
        let turn = Some(plot.page[0]);
        if beyond(turn) < beyond(None) - BESIDE { [turn, None] } else { [None, turn] }
    }

    fn fits(&self, plot: &Plot, bounds: Bounds, turn: Option<f64>) -> bool {
        let ([low, high], [from, to]) = (turned_bounds(bounds, turn), self.reach(plot, turn));
        (0..2).all(|i| low[i] >= from[i] - BESIDE && high[i] <= to[i] + BESIDE)
    }

    /// Its zero on the sheet, in mm from the sheet's top left.
    fn zero(&self, plot: &Plot, turn: Option<f64>) -> [f64; 2] {
        let page = turned_size(plot.page, turn);
        let offset = if is_bare(plot) { [0.0; 2] } else { self.offset };
        let corner = self.corner();
        std::array::from_fn(|i| corner[i] * page[i] + if corner[i] == 1.0 { -offset[i] } else { offset[i] })
    }

    /// What it reaches of the sheet.
    fn reach(&self, plot: &Plot, turn: Option<f64>) -> Bounds {
        let (zero, corner) = (self.zero(plot, turn), self.corner());
        [
            std::array::from_fn(|i| zero[i] - corner[i] * self.area[i]),
            std::array::from_fn(|i| zero[i] + (1.0 - corner[i]) * self.area[i]),
        ]
    }

    /// The corner of its zero as shares of the sheet's width and height.
    fn corner(&self) -> [f64; 2] {
        match self.origin {
            Corner::TopLeft => [0.0, 0.0],
            Corner::TopRight => [1.0, 0.0],
            Corner::BottomLeft => [0.0, 1.0],
            Corner::BottomRight => [1.0, 1.0],
            Corner::Center => [0.5, 0.5],
        }
    }

    /// How much smaller a plot has to be so that it fits: about the middle of the drawing, where it stays on its page; without a page,
    /// about the machine's zero. None if no size fits there.
    fn scale_to_fit(&self, plot: &Plot, bounds: Bounds, turn: Option<f64>) -> Option<f64> {
        let ([low, high], [from, to]) = (turned_bounds(bounds, turn), self.reach(plot, turn));
        let middle = turned([plot.origin[0] + plot.size[0] / 2.0, plot.origin[1] + plot.size[1] / 2.0], turn);
        let about = if is_bare(plot) { self.zero(plot, turn) } else { middle };
        let mut scale = 1.0_f64;
        for i in 0..2 {
            for (room, extent) in [(to[i] - about[i], high[i] - about[i]), (about[i] - from[i], about[i] - low[i])] {
                if extent > 0.0 {
                    scale = scale.min(room / extent);
                }
            }
        }
        (scale > 0.0).then_some(scale)
    }
}

/// Whether a plot has no page but the drawing.
fn is_bare(plot: &Plot) -> bool {
    (0..2).all(|i| plot.origin[i].abs() < BESIDE && (plot.page[i] - plot.size[i]).abs() < BESIDE)
}

/// All that is drawn, on the sheet; nothing if there is no path.
fn bounds(plot: &Plot) -> Option<Bounds> {
    let mut bounds: Option<Bounds> = None;
    for point in plot.paths().flat_map(|path| &path.points) {
        let [low, high] = bounds.get_or_insert([*point, *point]);
        for i in 0..2 {
            low[i] = low[i].min(point[i]);
            high[i] = high[i].max(point[i]);
        }
    }
    bounds.map(|bounds| bounds.map(|[x, y]| [x + plot.origin[0], y + plot.origin[1]]))
}

/// A place on the sheet, or where it lies if the sheet, of this width, is turned.
fn turned([x, y]: [f64; 2], width: Option<f64>) -> [f64; 2] {
    width.map_or([x, y], |width| [y, width - x])
}

fn turned_size([width, height]: [f64; 2], turn: Option<f64>) -> [f64; 2] {
    if turn.is_some() { [height, width] } else { [width, height] }
}

fn turned_bounds([low, high]: Bounds, turn: Option<f64>) -> Bounds {
    let [a, b] = [low, high].map(|corner| turned(corner, turn));
    [std::array::from_fn(|i| a[i].min(b[i])), std::array::from_fn(|i| a[i].max(b[i]))]
}

fn tenths(value: f64) -> f64 {
    (10.0 * value).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::plot::samples::{line, plot};

    fn machine(origin: &str, y: &str, offset: &str) -> Machine {
        Machine::parse(&format!(
            "name = \"Arm\"\nformat = \"gcode\"\narea = [300, 200]\norigin = \"{origin}\"\ny = \"{y}\"\noffset = {offset}\n\
             draw_speed = 50\ntravel_speed = 100\nacceleration = 500\npen_down = \"M3\"\npen_up = \"M5\""
        ))
        .unwrap()
    }

    #[test]
    fn zero_is_at_any_corner() {
        let mut plot = plot(vec![line(&[[10.0, 20.0]])]);
        plot.page = [250.0, 190.0];
        plot.origin = [5.0, 6.0];
        for (origin, y, offset, at) in [
            ("top-left", "down", "[0, 0]", [15_000, 26_000]),
            ("top-left", "up", "[0, 0]", [15_000, -26_000]),
            ("bottom-left", "up", "[0, 0]", [15_000, 164_000]),
            ("bottom-left", "up", "[10, 7]", [5_000, 157_000]),
            ("top-right", "down", "[1, 2]", [-234_000, 24_000]),
            ("bottom-right", "up", "[0, 0]", [-235_000, 164_000]),
            ("center", "up", "[0, 0]", [-110_000, 69_000]),
        ] {
            let machine = machine(origin, y, offset);
            machine.check(&plot).unwrap();
            assert_eq!(machine.placed(&plot).at(plot.layers[0].paths[0].points[0]), at, "{origin} {y} {offset}");
        }
    }

    #[test]
    fn a_sheet_is_turned_where_the_plot_fits_only_so() {
        let machine = machine("bottom-left", "up", "[0, 0]");
        let mut upright = plot(vec![line(&[[0.0, 0.0], [150.0, 250.0]])]);
        (upright.page, upright.size) = ([150.0, 250.0], [150.0, 250.0]);
        machine.check(&upright).unwrap();
        let placed = machine.placed(&upright);
        // Its top lies to the left, its left at the bottom.
        assert_eq!(
            [[0.0, 0.0], [150.0, 0.0], [150.0, 250.0]].map(|point| placed.at(point)),
            [[0, 0], [0, 150_000], [250_000, 150_000]]
        );
        let flat = plot(vec![line(&[[0.0, 0.0], [150.0, 100.0]])]);
        assert_eq!(machine.placed(&flat).at([0.0, 0.0]), [0, 150_000]);
    }

    #[test]
    fn what_is_beyond_the_area_is_refused_with_a_width_that_fits() {
        let message = |machine: &Machine, plot: &Plot| machine.check(plot).unwrap_err().to_string();
        let own = machine("bottom-left", "up", "[10, 10]");
        let of_size = |page: [f64; 2], origin: [f64; 2], size: [f64; 2]| {
            let mut plot = plot(vec![line(&[[0.0, 0.0], size])]);
            (plot.page, plot.origin, plot.size) = (page, origin, size);
            plot
        };
        // Without a page, the drawing lies at zero, whatever the offset.
        own.check(&of_size([300.0, 200.0], [0.0; 2], [300.0, 200.0])).unwrap();
        own.check(&of_size([200.0, 300.0], [0.0; 2], [200.0, 300.0])).unwrap();
        let large = of_size([320.0, 240.0], [0.0; 2], [320.0, 240.0]);
        assert_eq!(
            message(&own, &large),
            "the plot is 320 x 240 mm, but the machine Arm draws 300 x 200 mm: a width of 266mm would fit"
        );
        let tall = of_size([240.0, 320.0], [0.0; 2], [240.0, 320.0]);
        assert!(message(&own, &tall).ends_with("a width of 200mm would fit"), "turned: {}", message(&own, &tall));
        // On a page it stays in its middle.
        let on_a4 = of_size([297.0, 210.0], [2.0, 5.0], [293.0, 200.0]);
        assert_eq!(
            message(&own, &on_a4),
            "the plot lies from 2 x 5 mm to 295 x 205 mm of its page, but the machine Arm reaches from 10 x 0 mm to 310 x 200 mm: \
             a width of 277mm would fit"
        );
        own.check(&of_size([297.0, 210.0], [10.0, 10.0], [277.0, 189.08])).unwrap();
        let far = of_size([900.0, 800.0], [400.0, 100.0], [100.0, 100.0]);
        assert!(message(&own, &far).ends_with(": a page of at most 300 x 200 mm would fit"), "{}", message(&own, &far));
        own.check(&plot(Vec::new())).unwrap();
    }
}
