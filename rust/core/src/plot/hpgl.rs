//! A plot as HP-GL: in, a plot and a machine; out, instructions in whole plotter units.
//!
//! A path is `PU` to its beginning and `PD` along it, in pieces that small buffers take; a press is `PD` and `PU` where it is. `SP`
//! takes a pen, and at the end it is put away. HP-GL of pen plotters has no comments, and what looks like one may be taken for
//! instructions: what drew the file does not stand in it.

use std::fmt::Write;

use crate::base::Result;
use crate::plot::commands::push_commands;
use crate::plot::machine::{Machine, MachineFormat};
use crate::plot::path::PlotLayer;
use crate::plot::plot::Plot;

/// Points of one instruction: at most half a kilobyte, as much as the buffer of an old plotter holds half of.
const MOST_POINTS: usize = 32;

impl Plot {
    /// The plot as HP-GL.
    ///
    /// # Errors
    /// [`Error::Input`](crate::Error::Input) if the machine reads something else, does not reach all of it, or cannot pause where its
    /// pen is to be filled.
    ///
    /// # Runtime
    /// Linear in the number of points. The same plot always gives the same bytes.
    pub fn to_hpgl(&self, machine: &Machine) -> Result<String> {
        machine.reads(MachineFormat::Hpgl)?;
        machine.check(self)?;
        let points: usize = self.paths().map(|path| path.points.len()).sum();
        let mut out = String::with_capacity(256 + 12 * points + 16 * self.lifts());
        push_commands(&mut out, machine, &machine.header, 0.0, "\n");
        let placed = machine.placed(self);
        let mut way = Vec::new();
        for layer in &self.layers {
            for (filling, paths) in self.fillings(layer).into_iter().enumerate() {
                if filling > 0 {
                    machine.can_pause("until its pen is filled again")?;
                    push_commands(&mut out, machine, &machine.pause, 0.0, "\n");
                }
                push(&mut out, format_args!("SP{};\n", pen_of(machine, layer)));
                for path in &layer.paths[paths] {
                    placed.along(path, &mut way);
                    push_path(&mut out, &way);
                }
            }
        }
        out.push_str("PU0,0;SP0;\n");
        push_commands(&mut out, machine, &machine.footer, 0.0, "\n");
        Ok(out)
    }
}

/// Appends a path; one without a point is none.
fn push_path(out: &mut String, way: &[[i64; 2]]) {
    let Some(([x, y], rest)) = way.split_first() else { return };
    push(out, format_args!("PU{x},{y};"));
    if rest.is_empty() {
        out.push_str("PD;PU;");
    }
    for piece in rest.chunks(MOST_POINTS) {
        for (i, [x, y]) in piece.iter().enumerate() {
            push(out, format_args!("{}{x},{y}", if i == 0 { "PD" } else { "," }));
        }
        out.push(';');
    }
    if !rest.is_empty() {
        out.push_str("PU;");
    }
    out.push('\n');
}

fn push(out: &mut String, text: std::fmt::Arguments) {
    out.write_fmt(text).expect("text can always be appended to");
}

/// The pen of a layer in the carousel: the machine's for black and for white, and for more inks their numbers from 1 on.
fn pen_of(machine: &Machine, layer: &PlotLayer) -> u32 {
    let number = usize::from(layer.ink.label());
    machine.pens.get(number).copied().unwrap_or(number as u32 + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::plot::samples::{line, plot, small};

    #[test]
    fn pens_lines_and_presses() {
        let hp = Machine::shipped("hp7475a").unwrap();
        // Without a page, so zero is at the drawing's corner, 150 mm below its top.
        assert_eq!(
            small().to_hpgl(&hp).unwrap(),
            "IN;VS38.1;\nSP1;\nPU400,5600;PD520,5440;PU;\n\
             PU800,5200;PD1200,5200,1200,4800,800,4800,800,5200;PU;\n\
             PU2000,3580;PD;PU;\nSP2;\nPU50,5900;PD;PU;\nPU0,0;SP0;\n"
        );
        let carousel = Machine { pens: [3, 6], ..hp };
        let text = small().to_hpgl(&carousel).unwrap();
        assert!(text.contains("SP3;\n") && text.contains("SP6;\n"), "{text}");
    }

    #[test]
    fn sheets_lie_at_the_offset_and_are_turned() {
        let hp = Machine::shipped("hp7475a").unwrap();
        let mut plot = plot(vec![line(&[[0.0, 0.0]])]);
        (plot.page, plot.origin, plot.size) = ([297.0, 210.0], [20.0, 30.0], [200.0, 150.0]);
        assert!(plot.to_hpgl(&hp).unwrap().contains("PU400,7040;PD;PU;"));
        (plot.page, plot.origin, plot.size) = ([210.0, 297.0], [20.0, 280.0], [150.0, 10.0]);
        plot.layers[0].paths = vec![line(&[[0.0, 0.0], [150.0, 0.0]])];
        // 280 mm below the top is 280 mm from the left; 20 mm from the left is 20 mm from the bottom.
        assert!(plot.to_hpgl(&hp).unwrap().contains("PU10800,640;PD10800,6640;PU;"), "{}", plot.to_hpgl(&hp).unwrap());
    }

    #[test]
    fn long_paths_come_in_pieces() {
        let points: Vec<[f64; 2]> = (0..100).map(|i| [f64::from(i), f64::from(i % 2)]).collect();
        let text = plot(vec![line(&points)]).to_hpgl(&Machine::shipped("hp7475a").unwrap()).unwrap();
        assert_eq!((text.matches("PD").count(), text.matches("PU").count()), (4, 3));
        assert!(text.split(';').all(|instruction| instruction.len() < 512));
        // One within each point, that of zero too, and one between neighbours in an instruction.
        assert_eq!(text.matches(',').count(), 101 + 99 - 4);
    }

    #[test]
    fn nothing_to_draw_and_no_pause_to_fill_a_pen() {
        let hp = Machine::shipped("hp7475a").unwrap();
        let mut empty = plot(Vec::new());
        assert_eq!(empty.to_hpgl(&hp).unwrap(), "IN;VS38.1;\nPU0,0;SP0;\n");
        empty.layers.clear();
        assert_eq!(empty.to_hpgl(&hp).unwrap(), "IN;VS38.1;\nPU0,0;SP0;\n");
        let mut two = plot((0..2).map(|i| line(&[[0.0, f64::from(i)], [10.0, f64::from(i)]])).collect());
        two.refill = Some(5.0);
        let error = two.to_hpgl(&hp).unwrap_err().to_string();
        assert_eq!(error, "the plot waits until its pen is filled again, but the machine HP 7475A (A4) has no command for a pause");
        let waits = Machine { pause: "NR;".into(), ..hp };
        assert!(two.to_hpgl(&waits).unwrap().contains("PU;\nNR;\nSP1;\nPU0,5960;"), "{}", two.to_hpgl(&waits).unwrap());
    }
}
