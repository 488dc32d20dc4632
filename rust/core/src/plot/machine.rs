//! A machine as data: which files it reads, where its zero is, what it reaches, how fast it is, and its commands.
//!
//! [`super::profile`] reads one from TOML, [`super::placing`] lays a plot on it, [`super::motion`] tells how long it takes.

use crate::base::{Error, Result};
use crate::options::words;

words! {
    /// Which files a machine reads.
    MachineFormat {
        /// Through a program of its own that plots SVG.
        Svg = "svg",
        /// G-code, as GRBL reads it.
        Gcode = "gcode",
        /// HP-GL.
        Hpgl = "hpgl",
    }
}

words! {
    /// Where on the sheet a machine's zero lies.
    Corner {
        /// The top left corner.
        TopLeft = "top-left",
        /// The top right corner.
        TopRight = "top-right",
        /// The bottom left corner.
        BottomLeft = "bottom-left",
        /// The bottom right corner.
        BottomRight = "bottom-right",
        /// The middle of the sheet.
        Center = "center",
    }
}

words! {
    /// Where a machine's y grows to. Its x grows to the right.
    Upward {
        /// To the top of the sheet.
        Up = "up",
        /// To the bottom of the sheet.
        Down = "down",
    }
}

words! {
    /// How fast a machine takes a corner: as fast as on an arc beside it that its acceleration allows.
    Cornering {
        /// An arc of the radius d / sin(a / 2), for the junction deviation d and the angle a that the direction turns by: the rule of
        /// gcode-simulator. It is at the long end for curves of many short lines, and so keeps what it promises.
        Cautious = "cautious",
        /// The arc that touches both lines and passes the corner in the junction deviation: the rule of GRBL's planner and of the
        /// AxiDraw's software. Curves come out faster.
        Grbl = "grbl",
    }
}

/// What a speed or an acceleration is at most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Limit {
    /// Along the path, whatever its direction.
    Path(f64),
    /// Of the x axis and of the y axis, each by itself: between them a path is faster.
    Axes([f64; 2]),
}

impl Limit {
    /// What it comes to along a direction of length 1.
    pub(super) fn along(self, direction: [f64; 2]) -> f64 {
        match self {
            Self::Path(limit) => limit,
            Self::Axes(limits) => {
                let of_axis = |i: usize| limits[i] / direction[i].abs();
                of_axis(0).min(of_axis(1))
            }
        }
    }

    /// What it comes to along any direction.
    pub(super) fn least(self) -> f64 {
        match self {
            Self::Path(limit) => limit,
            Self::Axes([x, y]) => x.min(y),
        }
    }
}

/// A machine that plots. Lengths are mm, times seconds.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// What it is called in messages.
    pub name: String,
    /// Which files it reads.
    pub format: MachineFormat,
    /// Width and height that it reaches.
    pub area: [f64; 2],
    /// Where on the sheet its zero lies.
    pub origin: Corner,
    /// How far inside that corner of the sheet its zero lies.
    pub offset: [f64; 2],
    /// Where its y grows to.
    pub y: Upward,
    /// How fast it draws, along the path, in mm/s.
    pub draw_speed: f64,
    /// How fast it moves, in mm/s: with the pen up always, with the pen down at most.
    pub travel_speed: Limit,
    /// How fast its speed grows and falls with the pen down, in mm/s².
    pub acceleration: Limit,
    /// The same with the pen up.
    pub travel_acceleration: Limit,
    /// How far beside a corner it may pass: what decides how fast it is there.
    pub junction_deviation: f64,
    /// By which rule.
    pub cornering: Cornering,
    /// How long lowering the pen takes.
    pub pen_down_seconds: f64,
    /// How long lifting the pen takes.
    pub pen_up_seconds: f64,
    /// How long the pen stays down for a press.
    pub press_seconds: f64,
    /// Commands before everything else.
    pub header: String,
    /// Commands after everything else.
    pub footer: String,
    /// Commands that lower the pen or switch the laser on.
    pub pen_down: String,
    /// Commands that lift the pen or switch the laser off.
    pub pen_up: String,
    /// Commands between the two for a press.
    pub press: String,
    /// Commands that wait for somebody; in SVG what the name of a layer begins with. Empty if it cannot.
    pub pause: String,
    /// The power of a laser, in the unit of the commands.
    pub power: f64,
    /// Decimals of a coordinate in G-code.
    pub decimals: u32,
    /// Plotter units of HP-GL to the mm.
    pub units_per_mm: f64,
    /// The places of the black and of the white pen in the carousel.
    pub pens: [u32; 2],
}

impl Machine {
    /// That it reads such files.
    ///
    /// # Errors
    /// [`Error::Input`] if it does not.
    pub(super) fn reads(&self, format: MachineFormat) -> Result<()> {
        if self.format == format {
            return Ok(());
        }
        Err(Error::Input(format!("the machine {} reads {}, not {}", self.name, self.format.name(), format.name())))
    }

    /// That it can wait where a plot asks for it.
    ///
    /// # Errors
    /// [`Error::Input`] if it cannot; `why` says what for.
    pub(super) fn can_pause(&self, why: &str) -> Result<()> {
        if !self.pause.trim().is_empty() {
            return Ok(());
        }
        Err(Error::Input(format!("the plot waits {why}, but the machine {} has no command for a pause", self.name)))
    }

    /// Steps to the mm that coordinates are rounded to.
    pub(super) fn steps(&self) -> f64 {
        match self.format {
            MachineFormat::Svg => 1000.0,
            MachineFormat::Gcode => f64::from(10_u32.pow(self.decimals)),
            MachineFormat::Hpgl => self.units_per_mm,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_along_a_direction() {
        let axes = Limit::Axes([30.0, 40.0]);
        assert_eq!([[1.0, 0.0], [0.0, -1.0], [-0.6, 0.8]].map(|direction| axes.along(direction)), [30.0, 40.0, 50.0]);
        assert_eq!((axes.least(), Limit::Path(7.0).along([0.6, 0.8]), Limit::Path(7.0).least()), (30.0, 7.0, 7.0));
    }
}
