//! Delaunay triangulation of the kept sites, correct to the frame, as the paper's second graph.
//!
//! A plain Delaunay triangulation ends at the hull of the sites, short of the canvas, and its hull edges join sites far apart.
//! Here the sites whose cells touch the frame are mirrored across it. These *guards* only complete the triangulation: every
//! point outside the canvas is nearer to a guard than to any site, so two sites are joined exactly when their cells share an edge
//! inside the canvas. Guards carry no value and belong to no component; the adjacency keeps edges between sites alone.
//!
//! The triangulation itself is spade's, with exact predicates.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::base::{Control, Error, Result, Side};
use crate::graph::graph::{Graph, check_sites, cumulate};
use crate::graph::tiles::{Cut, Points, Rows, rows};

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

    /// Those of some positions in `graph.neighbors` that have the frame to their left.
    pub(crate) fn at_frame(&self, slots: Range<usize>) -> impl Iterator<Item = usize> {
        // Few of many: whole chunks are passed over at once.
        let chunks = self.left[slots.clone()].chunks(64).zip(slots.step_by(64));
        let with_frame = chunks.filter(|(chunk, _)| chunk.iter().fold(0, |most, left| most.max(*left)) >= FRAME);
        with_frame.flat_map(|(chunk, first)| (first..).zip(chunk).filter(|(_, left)| **left >= FRAME).map(|(slot, _)| slot))
    }

    /// What lies to the left of the directed edge at this position.
    pub fn left(&self, slot: usize) -> Beside {
        match self.left[slot] {
            FRAME.. => Beside::Frame(Side::ALL[((self.left[slot] - FRAME) as usize).min(3)]),
            node => Beside::Node(node),
        }
    }
}

/// Triangulates the sites of a canvas.
///
/// # Errors
/// [`Error::Input`] if there is no site, a site is not inside the canvas, or two sites coincide; [`Error::Cancelled`].
///
/// # Runtime
/// `n log n`, most of it spade's bulk load, of several tiles side by side where there are many sites.
pub fn triangulate(sites: Vec<[f64; 2]>, width: usize, height: usize, control: &Control) -> Result<Triangulation> {
    Ok(Edges::of(&sites, width, height, control)?.with_sites(sites))
}

/// A [`Triangulation`] without its sites, for those who need these meanwhile.
pub(crate) struct Edges {
    offsets: Vec<u32>,
    neighbors: Vec<u32>,
    left: Vec<u32>,
}

impl Edges {
    /// As [`triangulate`].
    pub(crate) fn of(sites: &[[f64; 2]], width: usize, height: usize, control: &Control) -> Result<Self> {
        Self::cut(sites, width, height, Cut::BEST, control)
    }

    fn cut(sites: &[[f64; 2]], width: usize, height: usize, cut: Cut, control: &Control) -> Result<Self> {
        check_sites(sites, width, height)?;
        let frame = [width as f64, height as f64];
        let (guards, sides): (Vec<[f64; 2]>, Vec<Side>) =
            guards(sites, frame[0], frame[1]).into_iter().map(|guard| (guard.position, guard.side)).unzip();
        control.check()?;
        let Some(mut parts) = rows(Points { sites, guards: &guards }, frame, cut, control)? else {
            return Err(coincidence(sites));
        };
        let beside = |point: u32| match (point as usize).checked_sub(sites.len()) {
            None => point,
            Some(guard) => FRAME + sides[guard] as u32,
        };
        parts.par_iter_mut().for_each(|part| part.left.iter_mut().for_each(|point| *point = beside(*point)));
        Ok(joined(parts, sites.len()))
    }

    /// The triangulation, with the sites that these are the edges of.
    pub(crate) fn with_sites(self, sites: Vec<[f64; 2]>) -> Triangulation {
        let Self { offsets, neighbors, left } = self;
        Triangulation { graph: Arc::new(Graph { sites, offsets, neighbors }), left }
    }
}

/// All rows in the order of the nodes. What the parts hold is given back one by the other.
fn joined(mut parts: Vec<Rows>, count: usize) -> Edges {
    if parts.len() == 1 {
        let Rows { starts, neighbors, left, .. } = parts.remove(0);
        return Edges { offsets: starts, neighbors, left };
    }
    let mut offsets = vec![0u32; count + 1];
    for part in &parts {
        for (node, row) in part.nodes.iter().zip(part.starts.windows(2)) {
            offsets[*node as usize + 1] = row[1] - row[0];
        }
    }
    cumulate(&mut offsets);
    let neighbors = in_order(&parts, &offsets, |part| &part.neighbors);
    parts.iter_mut().for_each(|part| part.neighbors = Vec::new());
    let left = in_order(&parts, &offsets, |part| &part.left);
    Edges { offsets, neighbors, left }
}

/// One number for every entry of all rows, in the order of the nodes.
fn in_order(parts: &[Rows], offsets: &[u32], of: impl Fn(&Rows) -> &[u32] + Sync) -> Vec<u32> {
    let count = offsets.len() - 1;
    let mut all = vec![0; offsets[count] as usize];
    let mut rest = all.as_mut_slice();
    let mut pieces = Vec::new();
    for start in (0..count).step_by(NODES_A_PIECE) {
        let nodes = start..(start + NODES_A_PIECE).min(count);
        let (piece, others) = rest.split_at_mut((offsets[nodes.end] - offsets[nodes.start]) as usize);
        rest = others;
        pieces.push((nodes, piece));
    }
    // Most tiles lie far from a piece.
    let spans: Vec<Option<[u32; 2]>> = parts.iter().map(|part| Some([*part.nodes.first()?, *part.nodes.last()?])).collect();
    pieces.into_par_iter().for_each(|(nodes, piece)| {
        let overlaps = |[first, last]: [u32; 2]| (first as usize) < nodes.end && last as usize >= nodes.start;
        for (part, _) in parts.iter().zip(&spans).filter(|(_, span)| span.is_some_and(overlaps)) {
            let [first, end] = [nodes.start, nodes.end].map(|node| part.nodes.partition_point(|other| (*other as usize) < node));
            let values = of(part);
            for k in first..end {
                let row = &values[part.starts[k] as usize..part.starts[k + 1] as usize];
                let at = (offsets[part.nodes[k] as usize] - offsets[nodes.start]) as usize;
                piece[at..at + row.len()].copy_from_slice(row);
            }
        }
    });
    all
}

/// Nodes whose rows are put in order at once: enough to be worth a thread's while.
const NODES_A_PIECE: usize = 1 << 14;

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
    // A point owns nothing if another point of its bin is that much lower: it would win only beyond the ends of the line. This
    // leaves out nearly all before sorting.
    let bins = ((count as f64).sqrt() as usize).clamp(1, 1 << 16);
    let bins_per_pixel = bins as f64 / length;
    let bin = |t: f64| ((t * bins_per_pixel) as usize).min(bins - 1);
    let lowest_of_every = |step: usize| {
        let mut lowest = vec![f64::INFINITY; bins];
        for [t, d] in points.clone().step_by(step) {
            let lowest = &mut lowest[bin(t)];
            *lowest = lowest.min(d);
        }
        lowest
    };
    // Any point of a bin will do; where some of them leave a bin empty, all are looked at.
    let mut lowest = lowest_of_every(8);
    if lowest.iter().any(|d| d.is_infinite()) {
        lowest = lowest_of_every(1);
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
    use crate::graph::lattice::Lattice;
    use crate::options::LatticeKind;
    use proptest::prelude::*;
    use robust::{Coord, incircle};

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
        let all = crate::graph::components::components(graph, &vec![0; graph.sites.len()]);
        assert_eq!(all.sizes.len(), 1, "the graph of a {width} x {height} canvas falls apart");
    }

    /// Tiles of a few sites.
    const SMALL: Cut = Cut { sites: 8, side: 1, halo: 1 };

    const WHOLE: Cut = Cut { sites: usize::MAX / 2, ..SMALL };

    /// No node lies in the circle of a triangle: the nodes beyond its edges are enough to know that.
    fn delaunay_check(t: &Triangulation) {
        let graph = &t.graph;
        for (i, j) in (0..graph.sites.len() as u32).flat_map(|i| graph.row(i as usize).iter().map(move |j| (i, *j))) {
            let sides = [(i, j), (j, i)].map(|(a, b)| t.left(t.slot(a, b).unwrap()));
            if let [Beside::Node(k), Beside::Node(l)] = sides {
                let [a, b, c, d] = [i, j, k, l].map(|n| graph.sites[n as usize]).map(|[x, y]| Coord { x, y });
                assert!(incircle(a, b, c, d) <= 0.0, "{l} lies in the circle of {i} {j} {k}");
            }
        }
    }

    fn triangulate_in(sites: Vec<[f64; 2]>, width: usize, height: usize, cut: Cut) -> Result<Triangulation> {
        Ok(Edges::cut(&sites, width, height, cut, &Control::new())?.with_sites(sites))
    }

    /// Sites in (0, 1) x (0, 1), put on a canvas without two in one place, in an order that has nothing to do with theirs.
    fn on_canvas(raw: &[(f64, f64)], w: f64, h: f64, grid: Option<f64>) -> Vec<[f64; 2]> {
        let snapped = |c: f64| grid.map_or(c, |grid| (c * grid).round() / grid);
        let inside = |c: f64, length: f64| snapped(c * length).clamp(0.001, length - 0.001);
        let mut sites: Vec<[f64; 2]> = raw.iter().map(|(u, v)| [inside(*u, w), inside(*v, h)]).collect();
        sites.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        sites.dedup();
        sites.sort_by_key(|site| crate::base::mixed(site[0].to_bits() ^ site[1].to_bits().rotate_left(32)));
        sites
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(192))]
        #[test]
        fn tiles_give_what_one_mesh_gives(
            width in 1usize..40, height in 1usize..80,
            raw in prop::collection::vec((0.0f64..1.0, 0.0f64..1.0), 1..300),
            // Powers crowd the sites on one side; gaps leave tiles half empty.
            (power, gap) in (1.0f64..4.0, 0.0f64..0.9), sites in 4usize..60,
        ) {
            let raw: Vec<(f64, f64)> =
                raw.iter().map(|(u, v)| (u.powf(power), if *v < 0.5 { v * (1.0 - gap) } else { 1.0 - (1.0 - v) * (1.0 - gap) })).collect();
            let placed = on_canvas(&raw, width as f64, height as f64, None);
            let [tiled, whole] = [Cut { sites, ..SMALL }, WHOLE]
                .map(|cut| triangulate_in(placed.clone(), width, height, cut).unwrap());
            sanity_check(&tiled, width, height);
            prop_assert_eq!(tiled, whole);
        }

        #[test]
        fn tiles_agree_on_ties(
            width in 1usize..20, height in 1usize..40,
            raw in prop::collection::vec((0.0f64..1.0, 0.0f64..1.0), 1..400), grid in 0.5f64..3.0, sites in 4usize..60,
        ) {
            let placed = on_canvas(&raw, width as f64, height as f64, Some((2.0 * grid).round() / 2.0));
            for cut in [Cut { sites, ..SMALL }, WHOLE] {
                let t = triangulate_in(placed.clone(), width, height, cut).unwrap();
                sanity_check(&t, width, height);
                delaunay_check(&t);
            }
        }
    }

    /// Sites on a ring with nothing inside: the circles of triangles reach over to its other side.
    #[test]
    fn tiles_find_what_lies_beyond_a_void() {
        let unit = |k: u64| 0.5 + 0.5 * f64::from(crate::base::noise(k));
        let on_ring = |k: u64| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * unit(2 * k));
            let radius = 98.0 - 8.0 * unit(2 * k + 1);
            [100.0 + radius * cos, 100.0 + radius * sin]
        };
        let sites: Vec<[f64; 2]> = (0..2000).map(on_ring).collect();
        let [tiled, whole] = [Cut { sites: 20, ..SMALL }, WHOLE].map(|cut| triangulate_in(sites.clone(), 200, 200, cut).unwrap());
        assert_eq!(tiled, whole);
    }

    #[test]
    fn a_piece_of_one_node_has_its_row() {
        let unit = |k: usize| 0.5 + 0.499 * f64::from(crate::base::noise(k as u64));
        let sites: Vec<[f64; 2]> = (0..=NODES_A_PIECE).map(|k| [150.0 * unit(2 * k), 150.0 * unit(2 * k + 1)]).collect();
        let cut = Cut { sites: 4000, ..SMALL };
        let [tiled, whole] = [cut, WHOLE].map(|cut| triangulate_in(sites.clone(), 150, 150, cut).unwrap());
        assert_eq!(tiled, whole);
    }

    #[test]
    fn tiles_name_sites_that_coincide() {
        let mut sites = Lattice::new(LatticeKind::Hexagonal, 20, 40, 1.0).unwrap().sites();
        sites.push(sites[333]);
        let errors = [SMALL, WHOLE].map(|cut| triangulate_in(sites.clone(), 20, 40, cut).unwrap_err().to_string());
        assert!(errors[0].starts_with(&format!("sites 333 and {} are both at", sites.len() - 1)), "{}", errors[0]);
        assert_eq!(errors[0], errors[1]);
    }

    #[test]
    fn tiles_do_not_depend_on_threads() {
        let lattice = Lattice::new(LatticeKind::Square, 30, 50, 1.0).unwrap();
        let of = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| triangulate_in(lattice.sites(), 30, 50, Cut { sites: 100, ..SMALL }).unwrap())
        };
        let one = of(1);
        sanity_check(&one, 30, 50);
        delaunay_check(&one);
        assert!([2, 3, 5].into_iter().all(|threads| of(threads) == one));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]
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

    /// In the corner the first is nearest, though another of its bin is far lower.
    #[test]
    fn the_envelope_reaches_from_one_end_to_the_other() {
        let points = [[10.0, 251f64.sqrt()], [19.9, 1.0], [19.5, 30.0], [19.6, 30.0]];
        assert_eq!(touching(points.into_iter(), points.len(), 20.0), [0, 1]);
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
