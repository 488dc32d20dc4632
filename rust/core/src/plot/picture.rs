//! The plot as pixels: what the pen draws, with round ends and corners.

use tiny_skia::{FillRule, LineCap, LineJoin, Mask, PathBuilder, Stroke, Transform};

use crate::base::{Error, Pool, Result, circle_polygon};
use crate::files::raster::{Raster, size};
use crate::plot::path::Path;
use crate::plot::plot::Plot;

/// How far the outline of a press may lie from its circle, in pixels.
const TOLERANCE: f64 = 0.05;

/// Paths that are painted at once: neighbours in the order of drawing, so mostly on the paper too.
const BATCH: usize = 256;

/// A path of lines of more points is stroked in pieces that begin where the last one ended.
const PIECE: usize = 4096;

const WHITE: [u8; 3] = [255; 3];

/// Paints what the pens draw, `width` pixels wide; `None` is a pixel for one of the canvas. The paper is white, or black under white ink
/// alone.
///
/// # Errors
/// As [`crate::stages::raster::rasterize`].
pub fn picture(plot: &Plot, width: Option<usize>) -> Result<Raster> {
    let (width, height) = size(plot.canvas[0], plot.canvas[1], width)?;
    let scale = [width as f64 / plot.size[0], height as f64 / plot.size[1]];
    let paper = if plot.layers.iter().all(|layer| layer.rgb == WHITE) { 0 } else { 255 };
    let is_grey = plot.layers.iter().all(|layer| layer.rgb == [layer.rgb[0]; 3]);
    let channels = if is_grey { 1 } else { 3 };
    let mut values = vec![paper; width * height * channels];
    for layer in &plot.layers {
        let mask = Pool::new(None).run(|| painted(&layer.paths, plot.pen, scale, width, height))?;
        for (pixel, drawn) in values.chunks_exact_mut(channels).zip(mask.data()) {
            for (value, ink) in pixel.iter_mut().zip(layer.rgb) {
                let (before, drawn, ink) = (u32::from(*value), u32::from(*drawn), u32::from(ink));
                *value = ((before * (255 - drawn) + ink * drawn + 127) / 255) as u8;
            }
        }
    }
    Ok(Raster { width, height, channels, values })
}

/// What is drawn, as coverage.
fn painted(paths: &[Path], pen: f64, scale: [f64; 2], width: usize, height: usize) -> Result<Mask> {
    let too_large = || Error::Internal(format!("there is no mask of {width} x {height} pixels"));
    let mut mask = Mask::new(width as u32, height as u32).ok_or_else(too_large)?;
    let across = pen * scale[0];
    let stroke = Stroke { width: across as f32, line_cap: LineCap::Round, line_join: LineJoin::Round, ..Stroke::default() };
    let on_raster = |p: &[f64; 2]| [p[0] * scale[0], p[1] * scale[1]];
    for batch in paths.chunks(BATCH) {
        let (mut presses, mut lines) = (PathBuilder::new(), PathBuilder::new());
        for path in batch {
            match &path.points[..] {
                [] => {}
                [press] => {
                    let outline = circle_polygon(on_raster(press), 0.5 * across, TOLERANCE);
                    push(&mut presses, outline.into_iter());
                    presses.close();
                }
                points if points.len() <= PIECE => {
                    push(&mut lines, points.iter().map(on_raster));
                    if path.is_closed {
                        lines.close();
                    }
                }
                points => {
                    let closing = path.is_closed.then(|| points[0]);
                    let all: Vec<[f64; 2]> = points.iter().copied().chain(closing).collect();
                    for begin in (0..all.len() - 1).step_by(PIECE) {
                        let piece = &all[begin..(begin + PIECE + 1).min(all.len())];
                        push(&mut lines, piece.iter().map(on_raster));
                    }
                }
            }
        }
        if let Some(presses) = presses.finish() {
            mask.fill_path(&presses, FillRule::Winding, true, Transform::identity());
        }
        if let Some(drawn) = lines.finish().and_then(|lines| lines.stroke(&stroke, 1.0)) {
            mask.fill_path(&drawn, FillRule::Winding, true, Transform::identity());
        }
    }
    Ok(mask)
}

fn push(builder: &mut PathBuilder, points: impl Iterator<Item = [f64; 2]>) {
    for (k, [x, y]) in points.enumerate() {
        if k == 0 {
            builder.move_to(x as f32, y as f32);
        } else {
            builder.line_to(x as f32, y as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::plot::samples::{line, plot};

    fn ink(raster: &Raster) -> f64 {
        raster.values.iter().map(|value| f64::from(255 - value) / 255.0).sum()
    }

    #[test]
    fn lines_and_presses_have_their_areas() {
        let mut plot = plot(vec![line(&[[50.0, 50.0], [100.0, 50.0]])]);
        (plot.canvas, plot.pen) = ([400, 300], 2.0);
        // 2 px a mm: a line of 100 px, 4 px wide, with round ends.
        let drawn = ink(&picture(&plot, Some(400)).unwrap());
        assert!((drawn - (400.0 + 4.0 * std::f64::consts::PI)).abs() < 2.0, "{drawn}");
        plot.layers[0].paths = vec![line(&[[50.0, 50.0]])];
        let drawn = ink(&picture(&plot, None).unwrap());
        assert!((drawn - 4.0 * std::f64::consts::PI).abs() < 0.6, "{drawn}");
        plot.layers[0].rgb = WHITE;
        assert!((400.0 * 300.0 - ink(&picture(&plot, None).unwrap()) - drawn).abs() < 0.2);
        assert!(picture(&plot, Some(0)).is_err());
    }
}
