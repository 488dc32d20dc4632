//! A plot as G-code: in, a plot and a machine; out, lines of ASCII as GRBL reads them.
//!
//! A path is a move with the pen up (`G0`), the commands that lower the pen, straight lines (`G1`, with the speed on the first one,
//! which commands of a pen may have changed), and the commands that lift it. Between pens, and where a pen is to be filled, stands the
//! machine's pause. At the end it is at zero again. What drew the file and with which options stands in comments before all that, in
//! lines that any controller takes.

use crate::base::{Error, Result};
use crate::plot::commands::push_commands;
use crate::plot::digits::{millimetres, push_number, push_steps};
use crate::plot::machine::{Machine, MachineFormat};
use crate::plot::plot::Plot;

/// The longest line of a comment: GRBL takes 80 letters a line, some senders count the comments.
const LONGEST_COMMENT: usize = 70;

impl Plot {
    /// The plot as G-code.
    ///
    /// # Errors
    /// [`Error::Input`] if the machine reads something else, does not reach all of it, or cannot pause where it has to.
    ///
    /// # Runtime
    /// Linear in the number of points. The same plot always gives the same bytes.
    pub fn to_gcode(&self, machine: &Machine) -> Result<String> {
        machine.reads(MachineFormat::Gcode)?;
        machine.check(self)?;
        let points: usize = self.paths().map(|path| path.points.len()).sum();
        let mut out = String::with_capacity(2048 + 24 * points + 64 * self.lifts());
        self.comments(&mut out, machine)?;
        let mut writer = Writer { out, machine, at: [0, 0] };
        writer.commands(&machine.header, 0.0);
        let placed = machine.placed(self);
        let (mut way, mut is_first) = (Vec::new(), true);
        for (number, layer) in self.layers.iter().enumerate() {
            for (filling, paths) in self.fillings(layer).into_iter().enumerate() {
                let pen = format!("pen {} {}", number + 1, layer.name);
                if filling > 0 {
                    machine.can_pause("until its pen is filled again")?;
                    writer.comment(&format!("fill {pen} again"));
                    writer.commands(&machine.pause, 0.0);
                } else if is_first {
                    writer.comment(&pen);
                } else {
                    machine.can_pause("for another pen")?;
                    writer.comment(&format!("change to {pen}"));
                    writer.commands(&machine.pause, 0.0);
                }
                is_first = false;
                for path in &layer.paths[paths] {
                    placed.along(path, &mut way);
                    writer.path(&way);
                }
            }
        }
        writer.travel([0, 0]);
        writer.commands(&machine.footer, 0.0);
        Ok(writer.out)
    }

    /// What drew it, with which options, for which machine.
    fn comments(&self, out: &mut String, machine: &Machine) -> Result<()> {
        let json = serde_json::to_string(&self.provenance).map_err(|error| Error::Internal(error.to_string()))?;
        let [width, height] = self.page.map(millimetres);
        let (name, pen) = (&machine.name, millimetres(self.pen));
        for text in [
            format!("graphstipple {}", self.provenance.version),
            format!("{name}, page {width} x {height} mm, pen {pen} mm, {} paths", self.lifts()),
            json,
        ] {
            push_comment(out, &text);
        }
        Ok(())
    }
}

/// Appends a comment, in as many lines as it takes.
fn push_comment(out: &mut String, text: &str) {
    let plain: String = text.chars().flat_map(char::escape_default).filter(|c| *c != '\\').collect();
    // Plain text has one byte to the letter.
    for piece in plain.as_bytes().chunks(LONGEST_COMMENT) {
        out.push_str("; ");
        out.extend(piece.iter().map(|letter| char::from(*letter)));
        out.push('\n');
    }
}

/// Writes moves and commands.
struct Writer<'a> {
    out: String,
    machine: &'a Machine,
    /// Where the machine is, in steps.
    at: [i64; 2],
}

impl Writer<'_> {
    fn comment(&mut self, text: &str) {
        push_comment(&mut self.out, text);
    }

    fn commands(&mut self, text: &str, seconds: f64) {
        push_commands(&mut self.out, self.machine, text, seconds, "\n");
    }

    /// A path; one without a point is none.
    fn path(&mut self, way: &[[i64; 2]]) {
        let Some((first, rest)) = way.split_first() else { return };
        let machine = self.machine;
        self.travel(*first);
        self.commands(&machine.pen_down, machine.pen_down_seconds);
        if rest.is_empty() && machine.press_seconds > 0.0 {
            self.commands(&machine.press, machine.press_seconds);
        }
        for (i, point) in rest.iter().enumerate() {
            self.step("G1", *point);
            if i == 0 {
                self.out.push_str(" F");
                push_number(&mut self.out, 60.0 * machine.draw_speed);
            }
            self.out.push('\n');
        }
        self.commands(&machine.pen_up, machine.pen_up_seconds);
    }

    /// A move with the pen up, unless it is there.
    fn travel(&mut self, to: [i64; 2]) {
        if to != self.at {
            self.step("G0", to);
            self.out.push('\n');
        }
    }

    fn step(&mut self, command: &str, to: [i64; 2]) {
        self.out.push_str(command);
        for (axis, steps) in [" X", " Y"].into_iter().zip(to) {
            self.out.push_str(axis);
            push_steps(&mut self.out, steps, self.machine.decimals);
        }
        self.at = to;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::plot::samples::{line, plot, small};

    #[test]
    fn lines_presses_and_pauses() {
        let grbl = Machine::shipped("grbl").unwrap();
        let text = small().to_gcode(&grbl).unwrap();
        let (comments, rest): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with(';'));
        assert_eq!(comments[..2], ["; graphstipple 1.2.3", "; GRBL plotter, page 200 x 150 mm, pen 0.3 mm, 4 paths"]);
        assert!(comments.contains(&"; pen 1 black") && comments.contains(&"; change to pen 2 white"), "{comments:?}");
        let expected = "G21,G90,G94,M5,\
            G0 X10 Y140,M3 S90,G4 P0.15,G1 X13 Y136 F1800,M5,G4 P0.1,\
            G0 X20 Y130,M3 S90,G4 P0.15,G1 X30 Y130 F1800,G1 X30 Y120,G1 X20 Y120,G1 X20 Y130,M5,G4 P0.1,\
            G0 X50 Y89.5,M3 S90,G4 P0.15,G4 P0.05,M5,G4 P0.1,\
            M0,\
            G0 X1.25 Y147.5,M3 S90,G4 P0.15,G4 P0.05,M5,G4 P0.1,\
            G0 X0 Y0,M2";
        assert_eq!(rest.join(","), expected);
    }

    #[test]
    fn a_laser_burns_a_dot_with_constant_power() {
        let laser = Machine::shipped("grbl-laser").unwrap();
        let text = plot(vec![line(&[[10.0, 10.0], [20.0, 10.0]]), line(&[[30.0, 10.0]])]).to_gcode(&laser).unwrap();
        let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with(';')).skip(4).collect();
        assert_eq!(lines.join(","), "G0 X10 Y140,M4 S300,G1 X20 Y140 F3000,M5,G0 X30 Y140,M4 S300,M3 S300,G4 P0.02,M5,G0 X0 Y0,M2");
    }

    #[test]
    fn pens_are_filled_after_the_path_that_exceeds_the_length() {
        let ten = |y: f64| line(&[[0.0, y], [10.0, y]]);
        let mut plot = plot((1..8).map(|i| ten(f64::from(i))).collect());
        plot.refill = Some(25.0);
        let grbl = Machine::shipped("grbl").unwrap();
        let text = plot.to_gcode(&grbl).unwrap();
        let lifts_before: Vec<usize> = text.match_indices("M0\n").map(|(at, _)| text[..at].matches("M3 S90").count()).collect();
        assert_eq!(lifts_before, [3, 6]);
        assert_eq!(text.matches("; fill pen 1 black again").count(), 2);
        let restless = Machine { pause: String::new(), ..grbl };
        assert_eq!(
            plot.to_gcode(&restless).unwrap_err().to_string(),
            "the plot waits until its pen is filled again, but the machine GRBL plotter has no command for a pause"
        );
        assert!(small().to_gcode(&restless).unwrap_err().to_string().starts_with("the plot waits for another pen, but"));
    }

    #[test]
    fn nothing_to_draw_and_what_is_smaller_than_a_step() {
        let grbl = Machine::shipped("grbl").unwrap();
        let body = |plot: &Plot| {
            let text = plot.to_gcode(&grbl).unwrap();
            text.lines().filter(|line| !line.starts_with(';')).collect::<Vec<_>>().join(",")
        };
        assert_eq!(body(&plot(Vec::new())), "G21,G90,G94,M5,M2");
        // The pen touches the paper all the same.
        let tiny = plot(vec![line(&[[10.0, 10.0], [10.0001, 10.0]])]);
        assert!(body(&tiny).contains("G0 X10 Y140,M3 S90,G4 P0.15,G4 P0.05,M5"), "{}", body(&tiny));
    }

    #[test]
    fn comments_are_short_lines_of_plain_letters() {
        let mut plot = small();
        plot.provenance.importance = "Größe\n\"x\"".repeat(40);
        let text = plot.to_gcode(&Machine::shipped("grbl").unwrap()).unwrap();
        assert!(text.is_ascii() && text.lines().all(|line| line.len() <= LONGEST_COMMENT + 2), "{text}");
        assert!(text.lines().all(|line| line.starts_with([';', 'G', 'M'])), "{text}");
    }

    #[test]
    fn other_machines_and_plots_beyond_their_area_are_refused() {
        let error = small().to_gcode(&Machine::shipped("axidraw").unwrap()).unwrap_err().to_string();
        assert_eq!(error, "the machine AxiDraw V3 reads svg, not gcode");
        let mut large = small();
        large.layers[0].paths.push(line(&[[0.0, 0.0], [500.0, 20.0]]));
        assert!(large.to_gcode(&Machine::shipped("grbl").unwrap()).unwrap_err().to_string().contains("a width of"));
    }
}
