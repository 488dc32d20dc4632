//! Path data of our own SVG. In: what [`super::write_path`] wrote; out: its closed outlines, or its dots, in pixels of the canvas.
//!
//! What this module does not do: read what other programs write: absolute commands, open subpaths, arcs that make no circle.

use std::result::Result;

use kurbo::{BezPath, Point};

use crate::files::load::Subpath;
use crate::files::write_path::{STROKE, leftmost};

/// The most characters of a number: more than the exact value of any coordinate on a drawing's finest grid has.
const MOST_CHARACTERS: usize = 40;

/// Reads a decimal number as files have it: digits, a point before digits, a minus sign, and neither exponent nor words.
pub(super) fn number(text: &str) -> Option<f64> {
    let is_plain = text.len() <= MOST_CHARACTERS
        && text.bytes().all(|byte| byte.is_ascii_digit() || b".-".contains(&byte))
        && text.ends_with(|last: char| last.is_ascii_digit());
    if is_plain { text.parse().ok() } else { None }
}

/// The dot of a circle in units: exactly the one that was written.
pub(super) fn circle(x: f64, y: f64, radius: f64, units: f64, is_exterior: bool) -> Subpath {
    Subpath::Circle { x: (leftmost(x, radius) + radius) / units, y: y / units, radius: radius / units, is_exterior }
}

/// The command before the current one, as far as smooth curves go on from it.
#[derive(Clone, Copy, PartialEq)]
enum Before {
    Quadratic,
    Cubic,
    Other,
}

/// Reads path data: relative commands, every subpath closed.
pub(super) struct PathReader<'a> {
    text: &'a str,
    at: usize,
    units: f64,
}

/// The byte at which path data are none that we write.
pub(super) type Unexpected = usize;

impl<'a> PathReader<'a> {
    pub(super) fn new(text: &'a str, units: f64) -> Self {
        Self { text, at: 0, units }
    }

    /// Reads closed outlines; `visit` says whether one of its kind can be there.
    ///
    /// # Errors
    /// Where the data are others.
    pub(super) fn outlines(mut self, mut visit: impl FnMut(Subpath) -> bool) -> Result<(), Unexpected> {
        // In units.
        let mut start = Point::ZERO;
        while self.at < self.text.len() {
            self.expect(b'm')?;
            start = self.point(start)?;
            let outline = if self.peek() == Some(b'a') { self.arcs(start)? } else { self.ring(start)? };
            if !visit(outline) {
                return Err(self.at);
            }
        }
        Ok(())
    }

    /// Reads dots of a radius, in units, as strokes; `visit` likewise.
    ///
    /// # Errors
    /// Where the data are others.
    pub(super) fn strokes(mut self, radius: f64, mut visit: impl FnMut(Subpath) -> bool) -> Result<(), Unexpected> {
        let mut at = Point::ZERO;
        while self.at < self.text.len() {
            self.expect(b'm')?;
            at = self.point(at)?;
            self.expect(b'h')?;
            let along = self.number()?;
            let dot = circle(at.x + 0.5 * along, at.y, radius, self.units, true);
            if along.abs() != STROKE || !visit(dot) {
                return Err(self.at);
            }
            at.x += along;
        }
        Ok(())
    }

    /// A circle of two arcs, from its leftmost point.
    fn arcs(&mut self, start: Point) -> Result<Subpath, Unexpected> {
        self.expect(b'a')?;
        let mut numbers = [0.0; 14];
        for (place, number) in numbers.iter_mut().enumerate() {
            *number = if [3, 4].contains(&(place % 7)) { self.flag()? } else { self.number()? };
        }
        let [radius, sweep] = [numbers[0], numbers[4]];
        let half = |diameter: f64| [radius, radius, 0.0, 1.0, sweep, diameter, 0.0];
        let expected = [half(2.0 * radius), half(-2.0 * radius)];
        if numbers != *expected.as_flattened() {
            return Err(self.at);
        }
        self.expect(b'z')?;
        Ok(circle(start.x + radius, start.y, radius, self.units, sweep == 1.0))
    }

    /// The rest of a ring of lines and curves.
    fn ring(&mut self, start: Point) -> Result<Subpath, Unexpected> {
        let units = self.units;
        let pixels = |p: Point| Point::new(p.x / units, p.y / units);
        let mut path = BezPath::new();
        path.move_to(pixels(start));
        let (mut current, mut mirrored, mut before) = (start, start, Before::Other);
        let mut command = b'l';
        loop {
            if let Some(letter) = self.peek().filter(u8::is_ascii_alphabetic) {
                self.at += 1;
                command = letter;
            }
            let last = std::mem::replace(&mut before, Before::Other);
            match command {
                b'z' => break,
                b'l' => current = self.point(current)?,
                b'h' => current.x += self.number()?,
                b'v' => current.y += self.number()?,
                b'q' | b't' => {
                    let control = match (command, last) {
                        (b'q', _) => self.point(current)?,
                        (_, Before::Quadratic) => mirrored,
                        _ => return Err(self.at),
                    };
                    current = self.point(current)?;
                    (mirrored, before) = (current + (current - control), Before::Quadratic);
                    path.quad_to(pixels(control), pixels(current));
                }
                b'c' | b's' => {
                    let first = match (command, last) {
                        (b'c', _) => self.point(current)?,
                        (_, Before::Cubic) => mirrored,
                        _ => return Err(self.at),
                    };
                    let second = self.point(current)?;
                    current = self.point(current)?;
                    (mirrored, before) = (current + (current - second), Before::Cubic);
                    path.curve_to(pixels(first), pixels(second), pixels(current));
                }
                _ => return Err(self.at),
            }
            if before == Before::Other {
                path.line_to(pixels(current));
            }
        }
        if current != start {
            path.line_to(pixels(start));
        }
        path.close_path();
        Ok(Subpath::Ring(path))
    }

    fn peek(&self) -> Option<u8> {
        self.text.as_bytes().get(self.at).copied()
    }

    fn expect(&mut self, letter: u8) -> Result<(), Unexpected> {
        if self.peek() != Some(letter) {
            return Err(self.at);
        }
        self.at += 1;
        Ok(())
    }

    fn number(&mut self) -> Result<f64, Unexpected> {
        if self.peek() == Some(b' ') {
            self.at += 1;
        }
        let rest = &self.text.as_bytes()[self.at..];
        let mut has_point = false;
        let end = rest.iter().enumerate().position(|(i, byte)| match byte {
            b'0'..=b'9' => false,
            b'-' => i > 0,
            b'.' => std::mem::replace(&mut has_point, true),
            _ => true,
        });
        let end = self.at + end.unwrap_or(rest.len());
        // What was read is ASCII, so the place is one between characters.
        let value = number(&self.text[self.at..end]).ok_or(self.at)?;
        self.at = end;
        Ok(value)
    }

    /// A flag of an arc: a single digit, 0 or 1. Others read no number there, but an end of the path.
    fn flag(&mut self) -> Result<f64, Unexpected> {
        self.expect(b' ')?;
        let value = match self.peek() {
            Some(b'0') => 0.0,
            Some(b'1') => 1.0,
            _ => return Err(self.at),
        };
        self.at += 1;
        match self.peek() {
            Some(b' ' | b'-') => Ok(value),
            _ => Err(self.at),
        }
    }

    /// A point relative to another.
    fn point(&mut self, from: Point) -> Result<Point, Unexpected> {
        Ok(Point::new(from.x + self.number()?, from.y + self.number()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outlines(data: &str) -> Result<usize, Unexpected> {
        let mut count = 0;
        let visit = |_| {
            count += 1;
            true
        };
        PathReader::new(data, 16.0).outlines(visit).map(|()| count)
    }

    #[test]
    fn what_we_write_is_read() {
        assert_eq!(outlines("m16 32 32-16 8 24h-40z"), Ok(1));
        assert_eq!(outlines("m0 0q16 0 32 16t-16 48c-8 0-16-16-16-32s8-24 0-32zm1 1q.25.375-.5 8z"), Ok(2));
        assert_eq!(outlines("m1 2a3.5 3.5 0 1 1 7 0 3.5 3.5 0 1 1-7 0z"), Ok(1));
        assert_eq!(outlines(""), Ok(0));
    }

    #[test]
    fn what_we_do_not_write_is_not() {
        for (data, at) in [
            ("M1 2h3v4z", 0),
            ("m1 2h3v4", 8),
            ("m1 2h3v4z 5 6", 9),
            ("m1 2h3v4zx", 9),
            ("m1 2hnan", 5),
            ("m1 2h1e999", 7),
            ("m1 2h1.2.3.4-", 12),
            ("m1 2h", 5),
            ("m1  2z", 3),
            ("m1 2t3 4z", 5),
            ("m1 2q1 1 2 2s3 4 5 6z", 13),
            ("m1 2c1 1 2 2 3 3t4 4z", 17),
            ("m1 2l3 4t5 6z", 9),
            // Not a circle: radii, flags, diameters, one arc, no end.
            ("m1 2a3 4 0 1 1 6 0 3 4 0 1 1-6 0z", 32),
            ("m1 2a3 3 0 0 1 6 0 3 3 0 1 1-6 0z", 32),
            ("m1 2a3 3 0 1 2 6 0 3 3 0 1 2-6 0z", 13),
            ("m1 2a3 3 0 1-0 6 0 3 3 0 1-0-6 0z", 12),
            ("m1 2a3 3 0 1 -0 6 0 3 3 0 1 -0-6 0z", 13),
            ("m1 2a3 3 0 1 1. 6 0 3 3 0 1 1.-6 0z", 14),
            ("m1 2a3 3 0 11 6 0 3 3 0 11-6 0z", 12),
            ("m1 2h1.v3z", 5),
            ("m1 2a3 3 0 1 1 5 0 3 3 0 1 1-5 0z", 32),
            ("m1 2a3 3 0 1 1 6 0z", 18),
            ("m1 2a3 3 0 1 1 6 0 3 3 0 1 1-6 0h1z", 32),
            ("m1 2\u{e4}", 4),
        ] {
            assert_eq!(outlines(data), Err(at), "{data}");
        }
        assert_eq!(outlines(&format!("m1 {}z", "2".repeat(41))), Err(3));
    }

    #[test]
    fn strokes_are_dots_around_their_middles() {
        let mut dots = Vec::new();
        let read = |data: &str, dots: &mut Vec<[f64; 3]>| {
            PathReader::new(data, 16.0).strokes(2.34, |subpath| {
                if let Subpath::Circle { x, y, radius, .. } = subpath {
                    dots.push([x, y, radius].map(|v| v * 16.0));
                }
                true
            })
        };
        assert_eq!(read("m12.32 5h.04m8 2h-.04m-17 1.5h.04", &mut dots), Ok(()));
        assert_eq!(dots, [[12.34, 5.0, 2.34], [10.0 + 10.34, 7.0, 2.34], [1.0 + 2.34, 8.5, 2.34]]);
        for (data, at) in [("m1 2h.02", 8), ("m1 2v.04", 4), ("m1 2h.04z", 8)] {
            assert_eq!(read(data, &mut dots), Err(at), "{data}");
        }
    }
}
