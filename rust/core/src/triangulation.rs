//! Delaunay triangulation of the kept sites, correct to the frame, as the paper's second graph.
//!
//! A plain Delaunay triangulation ends at the hull of the sites, short of the canvas, and its hull edges join sites far apart.
//! Here the sites whose cells touch the frame are mirrored across it. These *guards* only complete the triangulation: every
//! point outside the canvas is nearer to a guard than to any site, so two sites are joined exactly when their cells share an edge
//! inside the canvas. Guards carry no value and belong to no component; the adjacency keeps edges between sites alone.
//!
//! The triangulation itself is spade's, with exact predicates.

use std::sync::Arc;

use rayon::prelude::*;
use spade::handles::FixedVertexHandle;
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation as _};

use crate::control::Control;
use crate::error::{Error, Result};
use crate::graph::{Graph, cumulate};
use crate::voronoi::check_sites;

/// A side of the frame, in the order in which a ring with positive area runs along it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// y = 0.
    Top = 0,
    /// x = width.
    Right = 1,
    /// y = height.
    Bottom = 2,
    /// x = 0.
    Left = 3,
}

impl Side {
    const ALL: [Self; 4] = [Self::Top, Self::Right, Self::Bottom, Self::Left];
}

/// What lies to the left of a directed edge (of positive turn, from +x towards +y).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beside {
    /// A triangle whose third node this is.
    Node(u32),
    /// The frame.
    Frame(Side),
}

/// The second graph with its triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct Triangulation {
    /// Sites and adjacency; every row is sorted. Shared, since it outlives the triangles in what [`crate::draw`] returns.
    pub graph: Arc<Graph>,
    /// For every entry of `graph.neighbors`, what lies to the left of the edge from the row's node to that neighbour: the number
    /// of a node, or [`FRAME`] plus a side.
    left: Vec<u32>,
}

/// Numbers from here on stand for sides of the frame.
const FRAME: u32 = u32::MAX - 4;

impl Triangulation {
    /// The position of the directed edge from `a` to `b` in `graph.neighbors`, if there is such an edge.
    pub fn slot(&self, a: u32, b: u32) -> Option<usize> {
        let start = self.graph.offsets[a as usize] as usize;
        self.graph.row(a as usize).iter().position(|n| *n == b).map(|k| start + k)
    }

    /// What lies to the left of the directed edge at this position.
    pub fn left(&self, slot: usize) -> Beside {
        match self.left[slot] {
            FRAME.. => Beside::Frame(Side::ALL[((self.left[slot] - FRAME) as usize).min(3)]),
            node => Beside::Node(node),
        }
    }
}

struct Vertex {
    position: [f64; 2],
    /// Site number, or number of sites plus number of the guard. spade's own order is not the order of insertion.
    index: u32,
}

impl HasPosition for Vertex {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.position[0], self.position[1])
    }
}

/// Triangulates the sites of a canvas.
///
/// # Errors
/// [`Error::Input`] if there is no site, a site is not inside the canvas, or two sites coincide; [`Error::Cancelled`].
///
/// # Runtime
/// `n log n`, nearly all of it spade's bulk load.
pub fn triangulate(sites: Vec<[f64; 2]>, width: usize, height: usize, control: &Control) -> Result<Triangulation> {
    check_sites(&sites, width, height)?;
    let guards = guards(&sites, width as f64, height as f64);
    let count = sites.len();
    let vertices: Vec<Vertex> = (sites.iter().copied().chain(guards.iter().map(|guard| guard.position)))
        .enumerate()
        .map(|(index, position)| Vertex { position, index: index as u32 })
        .collect();
    let total = vertices.len();
    control.check()?;
    let mesh = DelaunayTriangulation::<Vertex>::bulk_load(vertices)
        .map_err(|e| Error::Internal(format!("the triangulation refused its sites: {e}")))?;
    control.report(0.7)?;
    if mesh.num_vertices() != total {
        return Err(coincidence(&sites));
    }

    let index_of: Vec<u32> = mesh.vertices().map(|v| v.data().index).collect();
    control.check()?;
    // Rows are read off in spade's own order of vertices, in which its edges lie close together, and put in ours afterwards.
    let rows_of = |batch: &[u32], first: usize| {
        let mut rows = Rows::default();
        let mut ring: Vec<u32> = Vec::new();
        let mut row: Vec<u64> = Vec::new();
        for (vertex, from) in (first..).zip(batch) {
            if *from as usize >= count {
                continue;
            }
            // All around the node, in positive turn: the triangle to the left of an edge has the end of the next edge as its third
            // node. No site lies on the hull, so the ring closes.
            ring.clear();
            ring.extend(mesh.vertex(FixedVertexHandle::from_index(vertex)).out_edges().map(|e| index_of[e.to().index()]));
            row.clear();
            for (k, to) in ring.iter().enumerate() {
                if (*to as usize) < count {
                    let third = ring[if k + 1 < ring.len() { k + 1 } else { 0 }];
                    let beside = match (third as usize).checked_sub(count) {
                        None => third,
                        Some(guard) => FRAME + guards[guard].side as u32,
                    };
                    row.push(u64::from(*to) << 32 | u64::from(beside));
                }
            }
            row.sort_unstable();
            rows.nodes.push((*from, row.len() as u32));
            rows.entries.extend_from_slice(&row);
        }
        rows
    };
    let batches: Vec<Rows> =
        index_of.par_chunks(ROWS_A_BATCH).enumerate().map(|(k, batch)| rows_of(batch, k * ROWS_A_BATCH)).collect();
    let mut offsets = vec![0u32; count + 1];
    for (node, degree) in batches.iter().flat_map(|rows| &rows.nodes) {
        offsets[*node as usize + 1] = *degree;
    }
    cumulate(&mut offsets);
    let (mut neighbors, mut left) = (vec![0u32; offsets[count] as usize], vec![0u32; offsets[count] as usize]);
    for rows in batches {
        let mut entries = rows.entries.iter();
        for (node, degree) in rows.nodes {
            let start = offsets[node as usize] as usize;
            for (k, entry) in (start..).zip(entries.by_ref().take(degree as usize)) {
                neighbors[k] = (*entry >> 32) as u32;
                left[k] = *entry as u32;
            }
        }
    }
    Ok(Triangulation { graph: Arc::new(Graph { sites, offsets, neighbors }), left })
}

/// Vertices whose rows are read off the mesh at once: enough to be worth a thread's while.
const ROWS_A_BATCH: usize = 1 << 14;

/// Some rows of the adjacency.
#[derive(Default)]
struct Rows {
    /// Node and length of every row.
    nodes: Vec<(u32, u32)>,
    /// The rows, one behind the other: neighbour in the upper half of the bits, what is beside the edge, as in [`Triangulation`],
    /// in the lower. One number is sorted faster than two.
    entries: Vec<u64>,
}

fn coincidence(sites: &[[f64; 2]]) -> Error {
    let mut order: Vec<usize> = (0..sites.len()).collect();
    order.sort_by(|a, b| sites[*a][0].total_cmp(&sites[*b][0]).then(sites[*a][1].total_cmp(&sites[*b][1])).then(a.cmp(b)));
    match order.windows(2).find(|w| sites[w[0]] == sites[w[1]]) {
        Some(w) => {
            let [x, y] = sites[w[0]];
            Error::Input(format!("sites {} and {} are both at ({x}, {y}), but all sites must differ", w[0], w[1]))
        }
        None => Error::Internal("a site coincides with a guard".into()),
    }
}

/// A mirror image outside the canvas.
struct Guard {
    position: [f64; 2],
    side: Side,
}

/// The mirror images of the sites whose cells touch a side, side by side.
fn guards(sites: &[[f64; 2]], width: f64, height: f64) -> Vec<Guard> {
    let of_side = |side: Side| {
        // Along the side, and away from it.
        let flat = |s: [f64; 2]| match side {
            Side::Top => [s[0], s[1]],
            Side::Bottom => [s[0], height - s[1]],
            Side::Left => [s[1], s[0]],
            Side::Right => [s[1], width - s[0]],
        };
        let length = if matches!(side, Side::Top | Side::Bottom) { width } else { height };
        let mirrored = |i: usize| {
            let [x, y] = sites[i];
            let position = match side {
                Side::Top => [x, -y],
                Side::Bottom => [x, 2.0 * height - y],
                Side::Left => [-x, y],
                Side::Right => [2.0 * width - x, y],
            };
            Guard { position, side }
        };
        touching(sites.iter().map(|s| flat(*s)), sites.len(), length).into_iter().map(mirrored).collect::<Vec<_>>()
    };
    Side::ALL.into_par_iter().flat_map_iter(of_side).collect()
}

/// Which points (t along a line, d away from it) own a piece of the line from 0 to `length`: the lower envelope of the parabolas
/// `(p - t)^2 + d^2`.
fn touching(points: impl Iterator<Item = [f64; 2]> + Clone, count: usize, length: f64) -> Vec<usize> {
    // A point owns nothing if the lowest point of its bin is that much lower: it would win only beyond the ends of the line. This
    // leaves out nearly all before sorting.
    let bins = ((count as f64).sqrt() as usize).clamp(1, 1 << 16);
    let bins_per_pixel = bins as f64 / length;
    let bin = |t: f64| ((t * bins_per_pixel) as usize).min(bins - 1);
    let mut lowest = vec![f64::INFINITY; bins];
    for [t, d] in points.clone() {
        let lowest = &mut lowest[bin(t)];
        *lowest = lowest.min(d);
    }
    let margin = 2.0 * length * (length / bins as f64);
    // Most points are beyond the reach of any bin.
    let farthest = lowest.iter().fold(0.0, |farthest: f64, d| farthest.max(*d));
    let mut near: Vec<(f64, f64, usize)> = (points.enumerate())
        .filter(|(_, [t, d])| {
            let reach = |lowest: f64| d * d - lowest * lowest <= margin;
            reach(farthest) && reach(lowest[bin(*t)])
        })
        .map(|(i, [t, d])| (t, d, i))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    near.dedup_by(|later, kept| later.0 == kept.0);

    // Every envelope member with the place from which on it is the lowest.
    let mut envelope: Vec<(f64, (f64, f64, usize))> = Vec::new();
    for point in near {
        let mut from = f64::NEG_INFINITY;
        while let Some((start, last)) = envelope.last() {
            let square = |p: &(f64, f64, usize)| p.0 * p.0 + p.1 * p.1;
            from = (square(&point) - square(last)) / (2.0 * (point.0 - last.0));
            if from > *start {
                break;
            }
            envelope.pop();
            from = f64::NEG_INFINITY;
        }
        envelope.push((from, point));
    }
    let ends = envelope.iter().skip(1).map(|e| e.0).chain([f64::INFINITY]);
    let touches = envelope.iter().zip(ends).filter(|((from, _), end)| *end >= 0.0 && *from <= length);
    touches.map(|((_, point), _)| point.2).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Lattice;
    use crate::params::LatticeKind;
    use proptest::prelude::*;

    /// Every rule that a triangulation keeps.
    fn sanity_check(t: &Triangulation, width: usize, height: usize) {
        let graph = &t.graph;
        for i in 0..graph.sites.len() {
            let row = graph.row(i);
            assert!(row.windows(2).all(|w| w[0] < w[1]), "row {i} is not sorted");
            for &j in row {
                let slot = t.slot(i as u32, j).unwrap();
                assert!(t.slot(j, i as u32).is_some(), "edge {i}-{j} stands in one row only");
                if let Beside::Node(k) = t.left(slot) {
                    let [a, b, c] = [i, j as usize, k as usize].map(|n| graph.sites[n]);
                    let turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
                    assert!(turn > 0.0, "triangle {i} {j} {k} does not turn left");
                    // The same triangle from its other edges.
                    assert_eq!(t.left(t.slot(j, k).unwrap()), Beside::Node(i as u32));
                }
            }
        }
        // Connected: the cells cover the canvas.
        let all = crate::components::components(graph, &vec![0; graph.sites.len()]);
        assert_eq!(all.sizes.len(), 1, "the graph of a {width} x {height} canvas falls apart");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]
        #[test]
        fn random_sites(
            width in 1usize..60, height in 1usize..60,
            raw in prop::collection::vec((0.0f64..1.0, 0.0f64..1.0), 1..80), squeeze in 0.05f64..1.0, snap in any::<bool>(),
        ) {
            let (w, h) = (width as f64, height as f64);
            let mut sites: Vec<[f64; 2]> = raw.iter().map(|(u, v)| {
                let p = [u * squeeze * w, v * squeeze * h];
                // Snapped to a coarse grid: cocircular and collinear sites.
                let p = if snap { p.map(|c| (c * 2.0).round() / 2.0) } else { p };
                [p[0].clamp(0.001, w - 0.001), p[1].clamp(0.001, h - 0.001)]
            }).collect();
            sites.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
            sites.dedup();
            sanity_check(&triangulate(sites, width, height, &Control::new()).unwrap(), width, height);
        }

        #[test]
        fn the_envelope_is_that_of_all_points(raw in prop::collection::vec((0.0f64..20.0, 0.01f64..9.0), 1..50)) {
            let points: Vec<[f64; 2]> = raw.iter().map(|p| [p.0, p.1]).collect();
            let found = touching(points.iter().copied(), points.len(), 20.0);
            for k in 0..2000 {
                let p = (k as f64 + 0.5) / 100.0;
                let d = |i: usize| (points[i][0] - p).powi(2) + points[i][1].powi(2);
                let best = (0..points.len()).min_by(|a, b| d(*a).total_cmp(&d(*b))).unwrap();
                prop_assert!(found.iter().any(|i| d(*i) <= d(best) + 1e-9));
            }
        }
    }

    #[test]
    fn lattices_triangulate_to_their_own_adjacency_inside() {
        let lattice = Lattice::new(LatticeKind::Hexagonal, 30, 20, 1.0).unwrap();
        let t = triangulate(lattice.sites(), 30, 20, &Control::new()).unwrap();
        sanity_check(&t, 30, 20);
        let expected = lattice.to_graph();
        let inner = lattice.nearest(15.0, 10.0);
        assert_eq!(t.graph.row(inner), expected.row(inner));
    }

    #[test]
    fn a_line_of_sites_is_a_path() {
        let lattice = Lattice::new(LatticeKind::Hexagonal, 1, 400, 0.3).unwrap();
        let t = triangulate(lattice.sites(), 1, 400, &Control::new()).unwrap();
        assert_eq!(t.graph.edges().collect::<Vec<_>>(), lattice.to_graph().edges().collect::<Vec<_>>());
        let slot = t.slot(0, 1).unwrap();
        assert_eq!(t.left(slot), Beside::Frame(Side::Left));
    }

    #[test]
    fn sites_that_coincide_are_named() {
        let error = triangulate(vec![[1.0, 1.0], [2.0, 1.0], [1.0, 1.0]], 4, 4, &Control::new()).unwrap_err();
        assert_eq!(error.to_string(), "sites 0 and 2 are both at (1, 1), but all sites must differ");
    }
}
