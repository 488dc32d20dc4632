//! How long a machine takes. In: a plot and a machine; out: a [`Timing`].
//!
//! The way is what the machine moves: the paths in whole steps, and straight lines between them with the pen up. It stands still where
//! the pen is lowered or lifted. Between two stops the speed is as GRBL plans it: at a corner no higher than the junction deviation
//! allows, between corners growing and falling by the acceleration as far as that leads, so that it has fallen in time for every
//! corner to come. That takes one pass backward and one forward over the whole way, as if the machine looked ahead without end; the
//! eighteen lines that GRBL sees are as good, unless they are shorter than the way on which it stops.
//!
//! Source: GRBL's planner, and for corners also gcode-simulator ([`Cornering`]).

use serde::Serialize;

use crate::plot::machine::{Cornering, Limit, Machine};
use crate::plot::placing::Placed;
use crate::plot::plot::Plot;

/// How long a machine takes for a plot, and for what. Pauses, in which it waits for somebody, are left out.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Timing {
    /// All of it.
    pub seconds: f64,
    /// How much line it draws, in mm.
    pub pen_down_mm: f64,
    /// How far it moves with the pen up, in mm: from its zero through all paths, and back.
    pub pen_up_mm: f64,
    /// How often the pen is lifted.
    pub lifts: usize,
    /// Seconds in which it draws lines.
    pub drawing_s: f64,
    /// Seconds in which it moves with the pen up.
    pub travel_s: f64,
    /// Seconds in which the pen is lowered and lifted.
    pub pen_s: f64,
    /// Seconds in which the pen stays down for presses.
    pub dwell_s: f64,
}

/// The cosine of the angle at which a direction counts as straight on: what rounding leaves of one.
const STRAIGHT: f64 = 1.0 - 5e-13;

/// The same for a direction that is turned back, as GRBL has it.
const TURNED_BACK: f64 = -0.999_999;

impl Machine {
    /// How long it takes for a plot, whether it reaches all of it or not.
    ///
    /// # Runtime
    /// Linear in the number of points.
    pub fn seconds(&self, plot: &Plot) -> Timing {
        let placed = self.placed(plot);
        let mut planner = Planner::new(self, &placed);
        let (mut timing, mut way) = (Timing::default(), Vec::new());
        let mut at = [0, 0];
        for path in plot.paths() {
            placed.along(path, &mut way);
            let [Some(first), Some(last)] = [way.first(), way.last()] else { continue };
            let (mm, seconds) = planner.travel(at, *first);
            timing.pen_up_mm += mm;
            timing.travel_s += seconds;
            let (mm, seconds) = planner.draw(&way);
            timing.pen_down_mm += mm;
            timing.drawing_s += seconds;
            timing.pen_s += self.pen_down_seconds + self.pen_up_seconds;
            if way.len() == 1 {
                timing.dwell_s += self.press_seconds;
            }
            timing.lifts += 1;
            at = *last;
        }
        let (mm, seconds) = planner.travel(at, [0, 0]);
        timing.pen_up_mm += mm;
        timing.travel_s += seconds;
        timing.seconds = timing.drawing_s + timing.travel_s + timing.pen_s + timing.dwell_s;
        timing
    }
}

/// A straight line between two neighbouring points of a way.
#[derive(Debug, Clone, Copy)]
struct Line {
    length: f64,
    /// Of length 1.
    direction: [f64; 2],
    /// The highest speed on it.
    speed: f64,
    acceleration: f64,
    /// The square of the speed at which it is entered.
    entry: f64,
}

/// Plans speeds between two stops.
struct Planner<'a> {
    machine: &'a Machine,
    steps: f64,
    lines: Vec<Line>,
}

impl<'a> Planner<'a> {
    fn new(machine: &'a Machine, placed: &Placed) -> Self {
        Self { machine, steps: placed.steps, lines: Vec::new() }
    }

    /// A line between two points that differ.
    fn line(&self, from: [i64; 2], to: [i64; 2], speed: f64, acceleration: Limit) -> Option<Line> {
        let [x, y] = [0, 1].map(|i| (to[i] - from[i]) as f64 / self.steps);
        let length = (x * x + y * y).sqrt();
        if length == 0.0 {
            return None;
        }
        let direction = [x / length, y / length];
        let speed = speed.min(self.machine.travel_speed.along(direction));
        Some(Line { length, direction, speed, acceleration: acceleration.along(direction), entry: 0.0 })
    }

    /// Length and seconds of a move with the pen up.
    fn travel(&self, from: [i64; 2], to: [i64; 2]) -> (f64, f64) {
        let line = self.line(from, to, f64::INFINITY, self.machine.travel_acceleration);
        line.map_or((0.0, 0.0), |line| (line.length, line.seconds(0.0)))
    }

    /// Length and seconds of a way with the pen down.
    fn draw(&mut self, way: &[[i64; 2]]) -> (f64, f64) {
        let mut lines = std::mem::take(&mut self.lines);
        lines.clear();
        let (speed, acceleration) = (self.machine.draw_speed, self.machine.acceleration);
        lines.extend(way.windows(2).filter_map(|pair| self.line(pair[0], pair[1], speed, acceleration)));
        for i in 1..lines.len() {
            let [before, after] = [lines[i - 1], lines[i]];
            let slower = before.speed.min(after.speed);
            lines[i].entry = self.junction(before.direction, after.direction).min(slower * slower);
        }
        // Backward: slow enough to slow down in time; at the end it stands.
        let mut exit = 0.0;
        for line in lines.iter_mut().rev() {
            line.entry = line.entry.min(exit + 2.0 * line.acceleration * line.length);
            exit = line.entry;
        }
        // Forward: no faster than it can have become; at the beginning it stands.
        for i in 1..lines.len() {
            let before = lines[i - 1];
            lines[i].entry = lines[i].entry.min(before.entry + 2.0 * before.acceleration * before.length);
        }
        let exits = lines.iter().skip(1).map(|line| line.entry).chain([0.0]);
        let sums = lines
            .iter()
            .zip(exits)
            .fold((0.0, 0.0), |(mm, seconds), (line, exit)| (mm + line.length, seconds + line.seconds(exit)));
        self.lines = lines;
        sums
    }

    /// The square of the highest speed at a corner.
    fn junction(&self, before: [f64; 2], after: [f64; 2]) -> f64 {
        let cosine = before[0] * after[0] + before[1] * after[1];
        if cosine > STRAIGHT {
            return f64::INFINITY;
        }
        let deviation = self.machine.junction_deviation;
        match self.machine.cornering {
            Cornering::Cautious => {
                let sine_of_half = ((1.0 - cosine) / 2.0).sqrt();
                self.machine.acceleration.least() * deviation / sine_of_half
            }
            Cornering::Grbl if cosine < TURNED_BACK => 0.0,
            Cornering::Grbl => {
                let cosine_of_half = ((1.0 + cosine) / 2.0).sqrt();
                // The speed changes in the direction of the difference.
                let [x, y] = [after[0] - before[0], after[1] - before[1]];
                let length = (x * x + y * y).sqrt();
                self.machine.acceleration.along([x / length, y / length]) * deviation * cosine_of_half / (1.0 - cosine_of_half)
            }
        }
    }
}

impl Line {
    /// How long it takes from its entry to an exit, given as the square of its speed: speeding up, at full speed where it gets there,
    /// slowing down.
    fn seconds(&self, exit: f64) -> f64 {
        let peak = ((self.entry + exit) / 2.0 + self.acceleration * self.length).min(self.speed * self.speed);
        let ramps = (2.0 * peak - self.entry - exit) / (2.0 * self.acceleration);
        let at_peak = peak.sqrt();
        (2.0 * at_peak - self.entry.sqrt() - exit.sqrt()) / self.acceleration + (self.length - ramps).max(0.0) / at_peak
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::path::Path;
    use crate::plot::plot::samples::{circle, line, plot};

    /// At 50 mm/s, with 500 mm/s² along the path.
    fn machine(more: &str) -> Machine {
        Machine::parse(&format!(
            "name = \"Arm\"\nformat = \"svg\"\narea = [300, 300]\ndraw_speed = 50\ntravel_speed = 100\nacceleration = 500\n{more}"
        ))
        .unwrap()
    }

    fn drawing(machine: &Machine, path: Path) -> f64 {
        machine.seconds(&plot(vec![path])).drawing_s
    }

    fn is_near(value: f64, expected: f64) {
        assert!((value - expected).abs() < 1e-9 * expected.max(1.0), "{value} instead of {expected}");
    }

    #[test]
    fn a_line_is_a_trapezoid_or_a_triangle() {
        let machine = machine("");
        // 2.5 mm to speed up and as many to slow down, in 0.1 s each.
        is_near(drawing(&machine, line(&[[0.0, 0.0], [105.0, 0.0]])), 0.2 + 2.0);
        is_near(drawing(&machine, line(&[[0.0, 0.0], [0.0, 1.25]])), 0.1);
        is_near(drawing(&machine, line(&[[7.0, 7.0]])), 0.0);
    }

    #[test]
    fn points_along_a_line_change_nothing() {
        let many: Vec<[f64; 2]> = (0..=1000).map(|i| [0.09 * f64::from(i), 0.12 * f64::from(i)]).collect();
        is_near(drawing(&machine(""), line(&many)), 0.2 + 145.0 / 50.0);
    }

    #[test]
    fn corners_are_passed_at_the_speed_of_their_rule() {
        let corner = || line(&[[0.0, 0.0], [50.0, 0.0], [50.0, 50.0]]);
        let straight = 2.0 * (0.1 + 47.5 / 50.0);
        // From 50 mm/s down to the speed v, and up again.
        let with = |v: f64| straight + 2.0 * ((50.0 - v) / 500.0 - (2500.0 - v * v) / 1000.0 / 50.0);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let [deviation, acceleration] = [0.05, 500.0];
        let cautious = machine("junction_deviation = 0.05");
        is_near(drawing(&cautious, corner()), with((deviation * acceleration / half).sqrt()));
        let grbl = machine("junction_deviation = 0.05\ncornering = \"grbl\"");
        is_near(drawing(&grbl, corner()), with((deviation * acceleration * half / (1.0 - half)).sqrt()));
        is_near(drawing(&machine("junction_deviation = 0"), corner()), with(0.0));
        // There and back: GRBL stops at the turn.
        let back = line(&[[0.0, 0.0], [50.0, 0.0], [0.0, 0.0]]);
        is_near(drawing(&grbl, back), with(0.0));
    }

    #[test]
    fn it_slows_down_in_time_for_what_comes() {
        // A line of 3 mm in short pieces that turn by little, and then back: it cannot be at 50 mm/s before.
        let machine = machine("cornering = \"grbl\"\njunction_deviation = 1");
        let mut points: Vec<[f64; 2]> = (0..=30).map(|i| [0.1 * f64::from(i), 0.001 * f64::from(i * i)]).collect();
        let length = drawing_length(&points);
        points.push([0.0, 0.0]);
        let there = drawing(&machine, line(&points[..31]));
        is_near(there, 2.0 * (length / 500.0).sqrt());
    }

    fn drawing_length(points: &[[f64; 2]]) -> f64 {
        line(points).length()
    }

    #[test]
    fn axes_have_limits_of_their_own() {
        let axes = Machine { travel_speed: Limit::Axes([30.0, 40.0]), acceleration: Limit::Axes([300.0, 400.0]), ..machine("") };
        // Along x at 30 mm/s, along (3, 4) at 50 mm/s and 500 mm/s².
        is_near(drawing(&axes, line(&[[0.0, 0.0], [31.5, 0.0]])), 0.1 + 31.5 / 30.0);
        is_near(drawing(&axes, line(&[[0.0, 0.0], [60.0, 80.0]])), 0.1 + 100.0 / 50.0);
    }

    #[test]
    fn a_plot_is_timed_from_zero_and_back() {
        let machine = machine("pen_down_seconds = 0.3\npen_up_seconds = 0.2\npress_seconds = 0.1\ntravel_acceleration = 1000");
        let timing =
            machine.seconds(&plot(vec![line(&[[30.0, 40.0]]), line(&[[30.0, 40.0], [30.0, 145.0]]), circle([50.0, 50.0], 5.0, 3)]));
        assert_eq!(timing.lifts, 3);
        is_near(timing.pen_s, 1.5);
        is_near(timing.dwell_s, 0.1);
        assert!((timing.pen_down_mm - 105.0 - 15.0 * 3.0_f64.sqrt()).abs() < 1e-3);
        // 5 mm to speed up to 100 mm/s: 0.2 s and what is left at that speed.
        let ways = [50.0, 25.0_f64.hypot(95.0), 55.0_f64.hypot(50.0)];
        is_near(timing.pen_up_mm, ways.iter().sum());
        is_near(timing.travel_s, ways.map(|way| 0.2 + (way - 10.0) / 100.0).iter().sum());
        is_near(timing.seconds, timing.drawing_s + timing.travel_s + timing.pen_s + timing.dwell_s);
        assert_eq!(machine.seconds(&plot(Vec::new())), Timing::default());
    }

    #[test]
    fn more_corners_take_longer_and_no_order_of_threads_matters() {
        let machine = machine("");
        let [few, many] = [40, 4000].map(|corners| drawing(&machine, circle([100.0, 100.0], 20.0, corners)));
        assert!(few > std::f64::consts::TAU * 20.0 / 50.0 && many > few, "{few} {many}");
        let grbl = Machine { cornering: Cornering::Grbl, ..machine };
        let round = drawing(&grbl, circle([100.0, 100.0], 20.0, 4000));
        assert!(round < 1.1 * std::f64::consts::TAU * 20.0 / 50.0, "{round}");
    }
}
