//! Smooth parts: where a drawing shows tone and no shape, so that dots alone can carry it.
//!
//! # The idea
//! Where the photo is smooth, the labels of diffusion and refinement wind through middle tones by chance: a labyrinth that nothing
//! in the photo asks for. There the drawing has a *ground* instead, ink or paper, whichever is nearer to the tone, and
//! [dots](super::stipple) of the other colour carry what the ground lacks.
//!
//! A part is smooth if the tones of a node and its neighbours lie on a plane, nearly: a slope is smooth, an edge or a texture is not.
//! What counts as nearly grows with what the ground lacks. A tint of a few percent is worth its dots only where nothing else
//! happens, whereas middle grey as bare paper is wrong whatever its texture. A flat part is smooth in every tone.

use rayon::prelude::*;

use crate::base::{Error, Result};
use crate::graph::{Adjacency, Graph, check_finite, check_one_a_node};

/// The ground of a node in a part with structure: none.
pub const STRUCTURED: u8 = 2;

/// How far from a plane tones may lie, by root mean square, where dots are worth it most: at middle grey, with a stippling of one half.
pub(super) const ROUGHNESS: f64 = 0.02;

/// And in any tone: what a step of one level of 8 bits comes to. It is rounding and no detail.
pub(super) const STEP: f64 = 0.5 / 255.0;

/// How often a node is asked again whether it is like most of its neighbours, so that neither kind of part has single nodes.
const MAJORITIES: usize = 2;

/// How much the neighbours count in the choice of a ground, as a difference of tones, and how often they are asked.
pub(super) const COHESION: f32 = 0.1;
pub(super) const COHESION_SWEEPS: usize = 2;

/// Nodes that one thread looks at, at least.
const LEAST_PART: usize = 1 << 12;

/// The ground of every node: 0 black and 1 white in smooth parts, [`STRUCTURED`] elsewhere.
///
/// `tones` are those of the photo, without emphasis; `stippling` says how much is smooth: 0 nothing, 1 everything, as
/// [`Options::stippling`](crate::Options). A tone t lacks c = min(t, 1 - t) of its ground, and a node is smooth if the tones around
/// it lie `STEP + 2 c ROUGHNESS stippling / (1 - stippling)` from a plane at most: the root of the mean, over two rings, of the
/// squared distances of every node's tone and its neighbours' from the plane that fits them best.
///
/// # Errors
/// [`Error::Input`] if there is not one finite tone a node, or stippling is not between 0 and 1.
pub fn grounds(graph: &Graph, tones: &[f32], stippling: f64) -> Result<Vec<u8>> {
    let count = graph.sites.len();
    check_one_a_node("tones", tones.len(), count)?;
    check_finite("tone", tones)?;
    if !(0.0..=1.0).contains(&stippling) {
        return Err(Error::Input(format!("stippling is {stippling}, but it must be between 0 and 1")));
    }
    if stippling == 0.0 {
        return Ok(vec![STRUCTURED; count]);
    }
    let around = mean_around(graph, &mean_around(graph, tones));
    let ground = grounds_of(graph, &around);
    if stippling == 1.0 {
        return Ok(ground);
    }
    let off_plane: Vec<f32> = for_nodes(count, |node| off_plane(graph, tones, node) as f32);
    let off_plane = mean_around(graph, &mean_around(graph, &off_plane));
    let allowed = 2.0 * ROUGHNESS * stippling / (1.0 - stippling);
    let smooth = for_nodes(count, |node| {
        let tone = f64::from(around[node]);
        let limit = STEP + allowed * tone.min(1.0 - tone).max(0.0);
        f64::from(off_plane[node]) <= limit * limit
    });
    let smooth = without_single_nodes(graph, smooth);
    Ok(smooth.iter().zip(ground).map(|(smooth, ground)| if *smooth { ground } else { STRUCTURED }).collect())
}

/// What most of a node's neighbours are.
pub(super) fn without_single_nodes(graph: &Graph, mut smooth: Vec<bool>) -> Vec<bool> {
    for _ in 0..MAJORITIES {
        smooth = for_nodes(smooth.len(), |node| {
            let row = graph.row(node);
            let alike = row.iter().filter(|other| smooth[**other as usize]).count();
            2 * alike + usize::from(smooth[node]) > row.len()
        });
    }
    smooth
}

/// The tones that shapes are made of: those of structured nodes, and in smooth parts the ground, which passes no error on.
pub(crate) fn drawn_tones(grounds: &[u8], tones: &[f32]) -> Vec<f32> {
    let drawn = |(ground, tone): (&u8, &f32)| if *ground == STRUCTURED { *tone } else { f32::from(*ground) };
    grounds.par_iter().zip(tones).map(drawn).collect()
}

/// The mean tone of structured parts, by area; none where there are none.
pub(crate) fn structured_mean(grounds: &[u8], tones: &[f32], areas: &[f64]) -> Option<f64> {
    let structured = grounds.iter().zip(tones).zip(areas).filter(|((ground, _), _)| **ground == STRUCTURED);
    let (sum, area) = structured.fold((0.0, 0.0), |(sum, all), ((_, tone), area)| (sum + f64::from(*tone) * area, all + area));
    (area > 0.0).then(|| (sum / area).clamp(0.0, 1.0))
}

pub(super) fn for_nodes<T: Send>(count: usize, of: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    (0..count).into_par_iter().with_min_len(LEAST_PART).map(of).collect()
}

/// The mean over every node and its neighbours.
pub(super) fn mean_around(graph: &Graph, values: &[f32]) -> Vec<f32> {
    for_nodes(values.len(), |node| graph.mean_around(node, values) as f32)
}

/// Black where the tones are dark, white where they are light; within a few percent of middle grey what the neighbours are.
fn grounds_of(graph: &Graph, tones: &[f32]) -> Vec<u8> {
    let mut ground: Vec<u8> = tones.iter().map(|tone| u8::from(*tone >= 0.5)).collect();
    for _ in 0..COHESION_SWEEPS {
        ground = for_nodes(ground.len(), |node| {
            let row = graph.row(node);
            let white = row.iter().filter(|other| ground[**other as usize] == 1).count();
            let company = if row.is_empty() { 0.0 } else { white as f32 / row.len() as f32 - 0.5 };
            u8::from(tones[node] - 0.5 + COHESION * company >= 0.0)
        });
    }
    ground
}

/// The mean squared distance of the tones of a node and its neighbours from the plane that fits them best.
pub(super) fn off_plane(graph: &Graph, tones: &[f32], node: usize) -> f64 {
    let row = graph.row(node);
    let count = (row.len() + 1) as f64;
    let [x0, y0] = graph.sites[node];
    // Sums of x, y and t, and of their products, seen from the node.
    let (mut x, mut y, mut t) = (0.0, 0.0, 0.0);
    let (mut xx, mut xy, mut yy, mut xt, mut yt, mut tt) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for other in row {
        let [dx, dy] = graph.sites[*other as usize];
        let (dx, dy) = (dx - x0, dy - y0);
        let dt = f64::from(tones[*other as usize]) - f64::from(tones[node]);
        (x, y, t) = (x + dx, y + dy, t + dt);
        (xx, xy, yy) = (xx + dx * dx, xy + dx * dy, yy + dy * dy);
        (xt, yt, tt) = (xt + dx * dt, yt + dy * dt, tt + dt * dt);
    }
    (xx, xy, yy) = (xx - x * x / count, xy - x * y / count, yy - y * y / count);
    (xt, yt, tt) = (xt - x * t / count, yt - y * t / count, tt - t * t / count);
    let spread = xx * yy - xy * xy;
    let on_plane = if spread > 1e-9 * xx * yy {
        (yy * xt * xt - 2.0 * xy * xt * yt + xx * yt * yt) / spread
    } else if xx + yy > 0.0 {
        // All on one line.
        (xt * xt + yt * yt) / (xx + yy)
    } else {
        0.0
    };
    (tt - on_plane).max(0.0) / count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::Lattice;
    use crate::options::LatticeKind;

    fn found(tone: impl Fn([f64; 2]) -> f64, stippling: f64) -> (Graph, Vec<u8>) {
        let graph = Lattice::new(LatticeKind::Hexagonal, 60, 60, 1.0).unwrap().to_graph();
        let tones: Vec<f32> = graph.sites.iter().map(|site| tone(*site) as f32).collect();
        let grounds = grounds(&graph, &tones, stippling).unwrap();
        (graph, grounds)
    }

    #[test]
    fn slopes_and_flat_tones_are_smooth_and_take_the_nearer_ground() {
        for stippling in [1e-3, 0.5, 1.0] {
            let (graph, grounds) = found(|[x, _]| x / 60.0, stippling);
            for (site, ground) in graph.sites.iter().zip(grounds) {
                if (site[0] - 30.0).abs() > 4.0 {
                    assert_eq!(ground, u8::from(site[0] > 30.0), "{site:?}");
                } else {
                    assert_ne!(ground, STRUCTURED);
                }
            }
        }
        for tone in [0.0, 0.03, 0.5, 0.9, 1.0] {
            assert!(found(|_| tone, 0.1).1.iter().all(|ground| *ground == u8::from(tone >= 0.5)));
        }
    }

    #[test]
    fn an_edge_is_structured_and_what_is_far_from_it_is_not() {
        let (graph, grounds) = found(|[x, _]| if x < 30.0 { 0.2 } else { 0.7 }, 0.5);
        for (site, ground) in graph.sites.iter().zip(&grounds) {
            let off = (site[0] - 30.0).abs();
            assert!(off > 1.0 || *ground == STRUCTURED, "{site:?}");
            assert!(off < 5.0 || *ground == u8::from(site[0] > 30.0), "{site:?}");
        }
    }

    #[test]
    fn a_step_of_one_level_is_smooth_and_texture_is_by_what_the_ground_lacks() {
        for tone in [0.02, 0.5, 0.97] {
            let (_, grounds) = found(|[x, _]| tone + if x < 30.0 { 0.0 } else { 1.0 / 255.0 }, 0.01);
            assert!(grounds.iter().all(|ground| *ground != STRUCTURED), "{tone}");
        }
        // A checkered texture around a tone.
        let textured = |tone: f64| {
            let parity = |v: f64| (v / 2.0).floor() as i64;
            let (_, grounds) = found(|[x, y]| tone + if (parity(x) + parity(y)) % 2 == 0 { 0.02 } else { -0.02 }, 0.5);
            grounds.iter().filter(|ground| **ground == STRUCTURED).count() as f64 / grounds.len() as f64
        };
        assert!(textured(0.05) > 0.9 && textured(0.97) > 0.9 && textured(0.45) < 0.1);
    }

    #[test]
    fn more_stippling_makes_more_smooth_and_none_nothing() {
        let tone = |[x, y]: [f64; 2]| 0.5 + 0.2 * (0.02 * x * x).sin() * (0.1 * y).cos();
        let smooth = |stippling: f64| found(tone, stippling).1.iter().filter(|ground| **ground != STRUCTURED).count();
        let counts = [0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0].map(smooth);
        assert!(counts.is_sorted() && counts[0] == 0 && counts[6] == found(tone, 1.0).1.len(), "{counts:?}");
        assert!(counts[1] < counts[5]);
    }
}
