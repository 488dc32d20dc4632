//! A plot as SVG: in, a plot; out, its size in mm, a layer for every pen, and an element for every path, in order.
//!
//! Coordinates are mm on the sheet, in thousandths. A path is a stroke as wide as the pen, with round ends and corners, as a pen draws
//! it. A press is a line of a hundredth of a mm with round ends: programs that plot leave out lines of no length. Where a pen is to be
//! filled, another layer of it begins; machines that take a sign in a layer's name for a pause have it there, and where another pen is
//! to be taken.
//!
//! The sheet's colour, where it is not white, is a matter of how the page is shown, and no rectangle: a machine would draw that.

use crate::base::{Error, Result};
use crate::files::{INKSCAPE, NAMESPACE, escape, hexadecimal};
use crate::plot::digits::{millimetres, push_steps};
use crate::plot::machine::{Machine, MachineFormat};
use crate::plot::path::Path;
use crate::plot::plot::Plot;

/// Where the attributes live by which Inkscape shows the page.
const SODIPODI: &str = "http://sodipodi.sourceforge.net/DTD/sodipodi-0.dtd";

/// Half of the line that is drawn for a press, in thousandths of a mm.
const HALF_PRESS: i64 = 5;

impl Plot {
    /// The plot as SVG, for a machine that plots SVG, or for any program.
    ///
    /// # Errors
    /// [`Error::Input`] if the machine reads something else or does not reach all of it.
    ///
    /// # Runtime
    /// Linear in the number of points. The same plot always gives the same bytes.
    pub fn to_svg(&self, machine: Option<&Machine>) -> Result<String> {
        if let Some(machine) = machine {
            machine.reads(MachineFormat::Svg)?;
            machine.check(self)?;
        }
        let points: usize = self.paths().map(|path| path.points.len()).sum();
        let mut out = String::with_capacity(2048 + 12 * points + 24 * self.lifts());
        let [width, height] = self.page.map(millimetres);
        let [left, top] = self.origin.map(millimetres);
        let [drawn_width, drawn_height] = self.size.map(millimetres);
        let pen = millimetres(self.pen);
        let paper = self.paper_colour();
        let is_white = paper == [255; 3];
        let style = if is_white { String::new() } else { format!(" style=\"background:{}\"", hexadecimal(paper)) };
        let json = serde_json::to_string(&self.provenance).map_err(|error| Error::Internal(error.to_string()))?;
        out.push_str(&format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:inkscape=\"{INKSCAPE}\" xmlns:sodipodi=\"{SODIPODI}\" \
             width=\"{width}mm\" height=\"{height}mm\" viewBox=\"0 0 {width} {height}\"{style}>\n"
        ));
        if !is_white {
            // Inkscape goes by this.
            let colour = hexadecimal(paper);
            out.push_str(&format!("<sodipodi:namedview pagecolor=\"{colour}\" inkscape:pageopacity=\"1\"/>\n"));
        }
        out.push_str(&format!(
            "<metadata><graphstipple:plot xmlns:graphstipple=\"{NAMESPACE}\" x=\"{left}\" y=\"{top}\" width=\"{drawn_width}\" \
             height=\"{drawn_height}\" pen=\"{pen}\">{}</graphstipple:plot></metadata>\n",
            escape(&json)
        ));
        let pause = machine.map_or("", |machine| machine.pause.trim());
        for (number, layer) in self.layers.iter().enumerate() {
            let number = number + 1;
            let mut fillings = self.fillings(layer);
            if fillings.is_empty() {
                // The pen has a layer all the same.
                fillings.push(0..0);
            }
            for (filling, paths) in fillings.into_iter().enumerate() {
                let is_first = number == 1 && filling == 0;
                let (id, again) = match filling {
                    0 => (format!("pen-{number}"), String::new()),
                    _ => (format!("pen-{number}-{}", filling + 1), format!(", filling {}", filling + 1)),
                };
                let label = escape(&format!("{}{number} {}{again}", if is_first { "" } else { pause }, layer.name));
                out.push_str(&format!(
                    "<g id=\"{id}\" inkscape:groupmode=\"layer\" inkscape:label=\"{}\" fill=\"none\" stroke=\"{}\" \
                     stroke-width=\"{pen}\" stroke-linecap=\"round\" stroke-linejoin=\"round\">\n",
                    label.replace('"', "&quot;"),
                    hexadecimal(layer.rgb)
                ));
                for path in &layer.paths[paths] {
                    self.push_path(&mut out, path);
                }
                out.push_str("</g>\n");
            }
        }
        out.push_str("</svg>\n");
        Ok(out)
    }

    /// The sheet's colour: white ink alone is for black paper.
    fn paper_colour(&self) -> [u8; 3] {
        let is_white_alone = !self.layers.is_empty() && self.layers.iter().all(|layer| layer.rgb == [255; 3]);
        self.paper.as_ref().map_or(if is_white_alone { [0; 3] } else { [255; 3] }, |paper| paper.rgb())
    }

    /// Appends the element of a path; one without a point is none.
    fn push_path(&self, out: &mut String, path: &Path) {
        let thousandths = |point: &[f64; 2]| [0, 1].map(|i| (1000.0 * (self.origin[i] + point[i])).round() as i64);
        let mut points = path.points.iter().map(thousandths);
        let Some(first) = points.next() else { return };
        let mut data = Data::open(out);
        let mut at = first;
        for point in points {
            if point != at {
                if at == first && data.is_empty {
                    data.point('M', first);
                }
                data.point('l', [point[0] - at[0], point[1] - at[1]]);
                at = point;
            }
        }
        if data.is_empty {
            data.point('M', [first[0] - HALF_PRESS, first[1]]);
            data.point('l', [2 * HALF_PRESS, 0]);
        } else if path.is_closed {
            data.out.push('z');
        }
        data.out.push_str("\"/>\n");
    }
}

/// Path data, with as few letters and separators as the grammar asks for.
struct Data<'a> {
    out: &'a mut String,
    is_empty: bool,
    /// The command that numbers without a letter would continue.
    implied: char,
    /// Whether the last number had a decimal point, so that another may begin with one right away.
    has_point: bool,
}

impl<'a> Data<'a> {
    fn open(out: &'a mut String) -> Self {
        out.push_str("<path d=\"");
        Self { out, is_empty: true, implied: ' ', has_point: false }
    }

    /// A command with a point, in thousandths.
    fn point(&mut self, command: char, point: [i64; 2]) {
        let is_implied = self.implied == command;
        if !is_implied {
            self.out.push(command);
        }
        (self.is_empty, self.implied) = (false, command);
        for (i, steps) in point.into_iter().enumerate() {
            self.number(steps, i == 0 && !is_implied);
        }
    }

    fn number(&mut self, steps: i64, is_behind_letter: bool) {
        let is_below_one = steps != 0 && steps.abs() < 1000;
        if !is_behind_letter && steps >= 0 && !(is_below_one && self.has_point) {
            self.out.push(' ');
        }
        if is_below_one {
            if steps < 0 {
                self.out.push('-');
            }
            // What is written begins with a 0 that nobody needs.
            let begin = self.out.len();
            push_steps(self.out, steps.abs(), 3);
            self.out.remove(begin);
        } else {
            push_steps(self.out, steps, 3);
        }
        self.has_point = steps % 1000 != 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::plot::samples::{line, plot, small};

    fn elements(plot: &Plot) -> Vec<String> {
        let text = plot.to_svg(None).unwrap();
        text.lines().filter(|line| line.starts_with("<path")).map(str::to_owned).collect()
    }

    #[test]
    fn every_path_is_an_element() {
        assert_eq!(
            elements(&small()),
            [
                "<path d=\"M10 10l3 4\"/>",
                "<path d=\"M20 20l10 0 0 10-10 0z\"/>",
                "<path d=\"M49.995 60.5l.01 0\"/>",
                "<path d=\"M1.245 2.5l.01 0\"/>"
            ]
        );
        let text = small().to_svg(None).unwrap();
        roxmltree::Document::parse(&text).unwrap();
        assert!(text.contains("width=\"200mm\" height=\"150mm\" viewBox=\"0 0 200 150\">"), "{text}");
        assert!(text.contains("inkscape:label=\"1 black\" fill=\"none\" stroke=\"#000\" stroke-width=\"0.3\""), "{text}");
        assert!(text.contains("inkscape:label=\"2 white\" fill=\"none\" stroke=\"#fff\""), "{text}");
        assert!(text.contains("pen=\"0.3\">{\"version\":\"1.2.3\""), "{text}");
    }

    #[test]
    fn numbers_are_short_and_sums_exact() {
        let mut plot = plot(vec![line(&[[0.0, 0.0], [0.5, 0.25], [0.0, 0.0], [-0.125, 1000.5], [-0.125, 1000.5], [7.0, 0.3333]])]);
        assert_eq!(elements(&plot), ["<path d=\"M0 0l.5.25-.5-.25-.125 1000.5 7.125-1000.167\"/>"]);
        plot.origin = [1.5, 0.001];
        plot.layers[0].paths = vec![line(&[[0.0, 0.0], [0.0001, 0.0001]]), Path { points: vec![[0.0; 2]], is_closed: true }];
        assert_eq!(elements(&plot), ["<path d=\"M1.495.001l.01 0\"/>", "<path d=\"M1.495.001l.01 0\"/>"], "a mark is not lost");
        plot.layers[0].paths = vec![line(&[])];
        assert!(elements(&plot).is_empty());
    }

    #[test]
    fn pens_are_filled_and_changed_between_layers() {
        let ten = |y: f64| line(&[[0.0, y], [10.0, y]]);
        let mut plot = small();
        plot.layers[0].paths = (1..6).map(|i| ten(f64::from(i))).collect();
        plot.refill = Some(15.0);
        let labels = |machine: Option<&Machine>| {
            let text = plot.to_svg(machine).unwrap();
            let found = text.split("inkscape:label=\"").skip(1).map(|rest| rest.split('"').next().unwrap_or("").to_owned());
            found.collect::<Vec<_>>()
        };
        assert_eq!(labels(None), ["1 black", "1 black, filling 2", "1 black, filling 3", "2 white"]);
        let axidraw = Machine::shipped("axidraw").unwrap();
        assert_eq!(labels(Some(&axidraw)), ["1 black", "!1 black, filling 2", "!1 black, filling 3", "!2 white"]);
    }

    #[test]
    fn paper_is_shown_and_not_drawn() {
        let mut plot = small();
        let text = |plot: &Plot| plot.to_svg(None).unwrap();
        assert!(!text(&plot).contains("background"));
        plot.layers.remove(0);
        assert!(text(&plot).contains(" style=\"background:#000\">"));
        plot.paper = Some("#a08060".parse().unwrap());
        assert!(text(&plot).contains("background:#a08060") && text(&plot).contains("pagecolor=\"#a08060\""));
        assert!(!text(&plot).contains("<rect"));
    }

    #[test]
    fn nothing_to_draw() {
        let mut empty = plot(Vec::new());
        let text = empty.to_svg(None).unwrap();
        let document = roxmltree::Document::parse(&text).unwrap();
        assert_eq!(document.descendants().filter(|node| node.has_tag_name("g")).count(), 1);
        assert!(!text.contains("<path"));
        empty.layers.clear();
        roxmltree::Document::parse(&empty.to_svg(None).unwrap()).unwrap();
        let error = empty.to_svg(Some(&Machine::shipped("grbl").unwrap())).unwrap_err().to_string();
        assert_eq!(error, "the machine GRBL plotter reads gcode, not svg");
    }
}
