//! Stippling: dots that carry what the ground of smooth parts lacks.
//!
//! # The idea
//! On a graph, one node in three or four can be a dot of its own, none beside another, and a dot may be smaller or larger than its
//! node's cell. So dots alone show every tone of a [smooth part](super::grounds): black dots on white down to a half, white dots on
//! black below it. How many there are and how large they are share the work: light tints have small dots, far apart, and a cloud of
//! dots fades out by their size.
//!
//! 1. *Which nodes.* In the order of their numbers, row by row, a node becomes a dot unless one before is too near: nearer than the mean
//!    of the distances that both would like to have, or its neighbour. A node whose neighbours have another label than the ground is none.
//! 2. *Where.* Lloyd steps: every dot moves to the middle of the ink that it stands for, which is what the ground nearest to it lacks.
//!    A node between dots is shared among them as its cell is cut by their bisectors. The nodes around give way, and in the end those
//!    beside a dot that has too little room for its ink make room for it (see [`super::places`]).
//! 3. *How large.* A dot has the area of the ink that it stands for: the tone is kept around every dot, and where tones are flat the
//!    areas are alike. What a dot has no room for goes to those beside it.

use std::f64::consts::PI;

use rayon::prelude::*;

use crate::base::{Control, Error, Frame, Result, STAR_FILL};
use crate::graph::{Adjacency, Triangulation, check_areas, check_finite, check_labels, check_one_a_node, distance_squared};
use crate::labels::places::Places;
use crate::labels::smooth::STRUCTURED;

/// Area that a dot would like to have, in cells of its node: in the lightest tints, and at middle grey.
const SMALLEST: f64 = 0.2;
const LARGEST: f64 = 1.0;

/// A dot of less ink than this, in cells, is too small to draw.
const LEAST_INK: f64 = 0.1;

/// What a node must lack to become a dot: half a level of 8 bits.
const LEAST_LACK: f64 = 0.5 / 255.0;

/// Dots taken row by row, none nearer to another than d, come to this many in d^2.
const PACKING: f64 = 0.75;

/// Lloyd steps.
const STEPS: usize = 3;

/// How often room is made for dots that have too little, and how much more than they need.
const MAKING_ROOM: usize = 3;
const ROOM_TO_SPARE: f64 = 1.05;

/// How often dots hand on what they still have no room for.
const HANDING_ON: usize = 2;

/// Stands for "no dot".
const NONE: u32 = u32::MAX;

/// Nodes that one thread looks at.
const NODES_AT_ONCE: usize = 1 << 11;

/// The most dots that share a node.
const MOST_SHARING: usize = 12;

/// Labels with the dots of smooth parts, and what outlines need to draw them.
#[derive(Debug, Clone, PartialEq)]
pub struct Stippled {
    /// 0 black, 1 white: in smooth parts the ground, and dots of the other label.
    pub labels: Vec<u8>,
    /// How the nodes are drawn.
    pub marks: Marks,
}

/// Where nodes are drawn, and how large.
#[derive(Debug, Clone, PartialEq)]
pub struct Marks {
    /// Where every node is drawn, in pixels: dots and the nodes around them have left their sites, and turned no triangle over.
    pub places: Vec<[f64; 2]>,
    /// Area of every node's mark in px^2: a dot's is the ink that it stands for, those of others are their cells'.
    pub areas: Vec<f64>,
}

/// Stipples the smooth parts of a canvas of `width` x `height` pixels.
///
/// `grounds` are those of [`grounds`](super::grounds), `tones` those of the photo without emphasis, `areas` those of the nodes' cells in
/// px^2, and `labels` those of the nodes in structured parts; what they are in smooth parts does not matter.
///
/// # Errors
/// [`Error::Input`] if there is not one of each a node, a ground is above 2, a label above 1, a tone not finite, or an area not finite or
/// below 0; [`Error::Cancelled`].
pub fn stipple(
    triangulation: &Triangulation,
    grounds: &[u8],
    tones: &[f32],
    areas: &[f64],
    labels: &[u8],
    (width, height): (usize, usize),
    control: &Control,
) -> Result<Stippled> {
    let count = triangulation.graph.sites.len();
    for (what, found) in [("grounds", grounds.len()), ("tones", tones.len()), ("areas", areas.len()), ("labels", labels.len())] {
        check_one_a_node(what, found, count)?;
    }
    if let Some(node) = grounds.iter().position(|ground| *ground > STRUCTURED) {
        return Err(Error::Input(format!("the ground of node {node} is {}, but it must be 0, 1 or 2", grounds[node])));
    }
    check_finite("tone", tones)?;
    check_areas("cell area", areas)?;
    check_labels(labels)?;
    let labels: Vec<u8> =
        labels.iter().zip(grounds).map(|(label, ground)| if *ground == STRUCTURED { *label } else { *ground }).collect();
    let lack_of = |(ground, tone): (&u8, &f32)| match ground {
        0 => f64::from(*tone).clamp(0.0, 1.0),
        1 => (1.0 - f64::from(*tone)).clamp(0.0, 1.0),
        _ => 0.0,
    };
    let lacks: Vec<f64> = grounds.iter().zip(tones).map(lack_of).collect();
    let parts = Parts { triangulation, grounds, none: STRUCTURED, labels: &labels, areas, lacks: &lacks };
    let Dotted { dots, inks, places, .. } = Dotted::of(&parts, Frame { width: width as f64, height: height as f64 }, control)?;
    let (mut labels, mut areas) = (labels.clone(), areas.to_vec());
    for (node, ink) in dots.nodes.iter().map(|node| *node as usize).zip(inks) {
        if parts.is_drawn(node, ink) {
            (labels[node], areas[node]) = (1 - grounds[node], ink);
        }
    }
    Ok(Stippled { labels, marks: Marks { places, areas } })
}

/// Dots where they are drawn.
pub(super) struct Dotted {
    pub(super) dots: Dots,
    /// Every dot's share of nodes, in the order of the nodes.
    pub(super) shares: Vec<Vec<Share>>,
    /// What every dot covers, in px^2.
    pub(super) inks: Vec<f64>,
    /// Of all nodes.
    pub(super) places: Vec<[f64; 2]>,
}

impl Dotted {
    /// # Errors
    /// [`Error::Cancelled`]
    pub(super) fn of(parts: &Parts, frame: Frame, control: &Control) -> Result<Self> {
        let mut dots = Dots::choose(parts);
        let mut places = Places::new(parts.triangulation, parts.areas, frame);
        let mut shares = dots.share(parts, &places);
        for _ in 0..STEPS {
            control.check()?;
            dots.step(parts, &dots.carried(parts, &shares), &mut places);
            shares = dots.share(parts, &places);
        }
        let carried = dots.carried(parts, &shares);
        for _ in 0..MAKING_ROOM {
            control.check()?;
            dots.make_room(&carried, &mut places);
        }
        let inks = dots.inks_with_room(&carried, &shares, &places);
        Ok(Self { dots, shares, inks, places: places.places })
    }
}

/// What is stippled.
pub(super) struct Parts<'a> {
    pub(super) triangulation: &'a Triangulation,
    pub(super) grounds: &'a [u8],
    /// The ground of nodes that have none.
    pub(super) none: u8,
    /// Without dots.
    pub(super) labels: &'a [u8],
    pub(super) areas: &'a [f64],
    /// What the ground lacks, in [0, 1].
    pub(super) lacks: &'a [f64],
}

impl Parts<'_> {
    fn site(&self, node: usize) -> [f64; 2] {
        self.triangulation.graph.sites[node]
    }

    fn row(&self, node: usize) -> &[u32] {
        self.triangulation.graph.row(node)
    }

    /// The neighbours of a node on its own ground.
    fn on_ground(&self, node: usize) -> impl Iterator<Item = usize> {
        self.row(node).iter().map(|other| *other as usize).filter(move |other| self.grounds[*other] == self.grounds[node])
    }

    /// Whether a node and all its neighbours, of which there are some around it, have the label of its ground.
    fn is_within_ground(&self, node: usize) -> bool {
        let ground = self.grounds[node];
        ground != self.none
            && self.row(node).len() >= 3
            && self.row(node).iter().all(|other| self.labels[*other as usize] == ground)
    }

    /// The mean area of the cells of a node and its neighbours.
    fn cell_around(&self, node: usize) -> f64 {
        self.triangulation.graph.mean_around(node, self.areas)
    }

    /// Whether a dot of so much ink is large enough to draw.
    pub(super) fn is_drawn(&self, node: usize, ink: f64) -> bool {
        ink > 0.0 && ink >= LEAST_INK * self.cell_around(node)
    }

    /// How far from others a dot at this node would like to be.
    fn distance_wanted(&self, node: usize) -> f64 {
        let (sum, count) =
            self.on_ground(node).fold((self.lacks[node], 1.0), |(sum, count), other| (sum + self.lacks[other], count + 1.0));
        let lack = (sum / count).max(LEAST_LACK);
        let area = SMALLEST + (LARGEST - SMALLEST) * (2.0 * lack).min(1.0);
        (PACKING * self.cell_around(node) * area / lack).sqrt()
    }
}

/// What a dot stands for.
#[derive(Clone, Copy, Default)]
struct Carried {
    /// In px^2.
    ink: f64,
    /// The sum of ink times its position.
    moment: [f64; 2],
}

impl Carried {
    fn radius(&self) -> f64 {
        (self.ink / PI).sqrt()
    }
}

/// A dot that may share a node.
#[derive(Clone, Copy)]
struct Sharing {
    dot: u32,
    place: [f64; 2],
    /// From the node's site, squared.
    distance: f64,
    /// Part of the node.
    share: f64,
}

/// A dot's share of a node.
pub(super) struct Share {
    pub(super) node: u32,
    pub(super) dot: u32,
    pub(super) ink: f64,
}

/// The dots, none beside another.
pub(super) struct Dots {
    /// The node of every dot.
    pub(super) nodes: Vec<u32>,
    /// The dot of every node, or [`NONE`].
    at: Vec<u32>,
    /// The dot nearest to every node's site, on the same ground; [`NONE`] where none is.
    owners: Vec<u32>,
    /// The nodes that have an owner.
    owned: Vec<u32>,
    /// Whether a node is one beside a dot that moves out of its way.
    gives_way: Vec<bool>,
    /// The nodes that do.
    beside: Vec<u32>,
}

impl Dots {
    fn choose(parts: &Parts) -> Self {
        let count = parts.grounds.len();
        let wanted = |node: usize| if parts.grounds[node] == parts.none { 0.0 } else { parts.distance_wanted(node) };
        let wanted: Vec<f64> = (0..count).into_par_iter().with_min_len(NODES_AT_ONCE).map(wanted).collect();
        let (mut nodes, mut at) = (Vec::new(), vec![NONE; count]);
        let mut is_taken = vec![false; count];
        let mut reached_by = vec![NONE; count];
        let mut open = Vec::new();
        for node in 0..count {
            if is_taken[node] || parts.lacks[node] < LEAST_LACK || !parts.is_within_ground(node) {
                continue;
            }
            let dot = nodes.len() as u32;
            nodes.push(node as u32);
            (at[node], reached_by[node]) = (dot, dot);
            open.push(node);
            while let Some(from) = open.pop() {
                for other in parts.on_ground(from) {
                    if reached_by[other] == dot {
                        continue;
                    }
                    let apart = 0.5 * (wanted[node] + wanted[other]);
                    let is_near = distance_squared(parts.site(node), parts.site(other)) < apart * apart;
                    if is_near || from == node {
                        (reached_by[other], is_taken[other]) = (dot, true);
                    }
                    if is_near {
                        open.push(other);
                    }
                }
            }
        }
        let owners = nearest_by_hops(parts, &nodes, &at);
        let owned = (0..count as u32).into_par_iter().filter(|node| owners[*node as usize] != NONE).collect();
        let gives_way = |node: usize| {
            at[node] == NONE && parts.row(node).iter().any(|other| at[*other as usize] != NONE) && parts.is_within_ground(node)
        };
        let gives_way: Vec<bool> = (0..count).into_par_iter().map(gives_way).collect();
        let beside = (0..count as u32).filter(|node| gives_way[*node as usize]).collect();
        Self { nodes, at, owners, owned, gives_way, beside }
    }

    /// Shares every node's ink among the dots about it, and finds the nearest of them anew. Shares are in the order of the nodes.
    fn share(&mut self, parts: &Parts, places: &Places) -> Vec<Vec<Share>> {
        let dots: Vec<[f64; 2]> = self.nodes.iter().map(|node| places.places[*node as usize]).collect();
        let of_nodes = |nodes: &[u32]| {
            let (mut shares, mut nearest) = (Vec::with_capacity(2 * nodes.len()), Vec::with_capacity(nodes.len()));
            let mut sharing = Vec::with_capacity(MOST_SHARING);
            for node in nodes {
                let ink = parts.lacks[*node as usize] * parts.areas[*node as usize];
                self.find_sharing(parts, &dots, *node as usize, &mut sharing);
                nearest.push(sharing[0].dot);
                shares.extend(sharing.iter().map(|Sharing { dot, share, .. }| Share { node: *node, dot: *dot, ink: share * ink }));
            }
            (nearest, shares)
        };
        let (nearest, shares): (Vec<Vec<u32>>, _) = self.owned.par_chunks(NODES_AT_ONCE).map(of_nodes).unzip();
        for (node, dot) in self.owned.iter().zip(nearest.into_iter().flatten()) {
            self.owners[*node as usize] = dot;
        }
        shares
    }

    /// The dots that share a node, the nearest first: it, and those whose bisector with it cuts the node's cell. Each has about the part
    /// of the cell that the bisectors leave it.
    fn find_sharing(&self, parts: &Parts, dots: &[[f64; 2]], node: usize, sharing: &mut Vec<Sharing>) {
        let site = parts.site(node);
        sharing.clear();
        let mut add = |dot: u32| {
            if sharing.len() < MOST_SHARING && sharing.iter().all(|known| known.dot != dot) {
                let place = dots[dot as usize];
                sharing.push(Sharing { dot, place, distance: distance_squared(site, place), share: 1.0 });
            }
        };
        add(self.owners[node]);
        parts.on_ground(node).for_each(|other| add(self.owners[other]));
        if sharing.len() == 1 {
            return;
        }
        let nearest = (1..sharing.len()).fold(0, |best, k| if sharing[k].distance < sharing[best].distance { k } else { best });
        sharing.swap(0, nearest);
        let (first, area) = (sharing[0], parts.areas[node]);
        sharing.retain(|other| {
            let farther = other.distance - first.distance;
            other.dot == first.dot || farther * farther < area * distance_squared(first.place, other.place)
        });
        if sharing.len() == 1 {
            return;
        }
        let side = area.sqrt();
        let mut total = 0.0;
        for k in 0..sharing.len() {
            let own = sharing[k];
            let mut share = 1.0;
            for other in sharing.iter().filter(|other| other.dot != own.dot) {
                // How far the node lies on the dot's side of the bisector.
                let apart = 2.0 * distance_squared(own.place, other.place).sqrt() * side;
                share *= if apart > 0.0 { (0.5 + (other.distance - own.distance) / apart).clamp(0.0, 1.0) } else { 0.5 };
            }
            sharing[k].share = share;
            total += share;
        }
        if total > 0.0 {
            sharing.iter_mut().for_each(|sharing| sharing.share /= total);
        } else {
            sharing.truncate(1);
        }
    }

    /// What every dot stands for, summed in the order of the nodes.
    fn carried(&self, parts: &Parts, shares: &[Vec<Share>]) -> Vec<Carried> {
        let mut carried = vec![Carried::default(); self.nodes.len()];
        for Share { node, dot, ink } in shares.iter().flatten() {
            let ([x, y], carried) = (parts.site(*node as usize), &mut carried[*dot as usize]);
            carried.ink += ink;
            carried.moment = [carried.moment[0] + ink * x, carried.moment[1] + ink * y];
        }
        carried
    }

    /// A Lloyd step of the dots, for which the nodes around them give way.
    fn step(&self, parts: &Parts, carried: &[Carried], places: &mut Places) {
        places.visit(&self.nodes, |places, node| {
            let carried = &carried[self.at[node] as usize];
            if carried.ink > 0.0 {
                places.move_towards(node, carried.moment.map(|moment| moment / carried.ink), |_, _| true);
            }
        });
        places.visit(&self.beside, |places, node| {
            if places.is_at_frame(node) {
                return;
            }
            let row = parts.row(node);
            let sum = row.iter().fold([0.0; 2], |[x, y], other| {
                let place = places.place(*other as usize);
                [x + place[0], y + place[1]]
            });
            places.move_towards(node, sum.map(|sum| sum / row.len() as f64), |_, _| true);
        });
    }

    /// Moves the rims of stars that are too small for their dots outwards, and dots away from rims that cannot move.
    fn make_room(&self, carried: &[Carried], places: &mut Places) {
        places.visit(&self.nodes, |places, node| {
            let needed = ROOM_TO_SPARE * carried[self.at[node] as usize].radius() / STAR_FILL;
            if places.room(node, places.place(node)) >= needed {
                return;
            }
            for side in places.rim(node) {
                let Some([x, y]) = places.way_out(node, side, needed) else { continue };
                for end in side.into_iter().filter(|end| self.gives_way[*end]) {
                    let from = places.place(end);
                    places.move_towards(end, [from[0] + x, from[1] + y], |_, _| true);
                }
                if let Some([x, y]) = places.way_out(node, side, needed) {
                    let from = places.place(node);
                    let room = places.room(node, from);
                    places.move_towards(node, [from[0] - x, from[1] - y], |places, to| places.room(node, to) > room);
                }
            }
        });
    }

    /// The ink of every dot, after those that have no room for theirs have handed it on to those that share nodes with them.
    fn inks_with_room(&self, carried: &[Carried], shares: &[Vec<Share>], places: &Places) -> Vec<f64> {
        let mut inks: Vec<f64> = carried.iter().map(|carried| carried.ink).collect();
        let most = |node: &u32| {
            let radius = STAR_FILL * places.room(*node as usize);
            PI * radius * radius
        };
        let most: Vec<f64> = self.nodes.par_iter().map(most).collect();
        for _ in 0..HANDING_ON {
            let over: Vec<f64> = inks.iter().zip(&most).map(|(ink, most)| (ink - most).max(0.0)).collect();
            let (mut takers, mut handed) = (vec![0u32; inks.len()], vec![0.0; inks.len()]);
            // Those that share a node, one of which has too much and the other has not.
            let mut pairs = Vec::new();
            for group in shares.iter().flat_map(|shares| shares.chunk_by(|a, b| a.node == b.node)) {
                for from in group.iter().map(|share| share.dot as usize).filter(|dot| over[*dot] > 0.0) {
                    for to in group.iter().map(|share| share.dot as usize).filter(|dot| inks[*dot] < most[*dot]) {
                        takers[from] += 1;
                        pairs.push((from, to));
                    }
                }
            }
            for (from, to) in pairs {
                handed[to] += over[from] / f64::from(takers[from]);
            }
            for (dot, ink) in inks.iter_mut().enumerate() {
                // To the last bit: a dot that has handed on is full.
                *ink = handed[dot] + if takers[dot] > 0 { most[dot] } else { *ink };
            }
        }
        inks
    }
}

/// The dot that is the fewest hops away from every node, over nodes of its ground.
fn nearest_by_hops(parts: &Parts, nodes: &[u32], at: &[u32]) -> Vec<u32> {
    let mut owners = at.to_vec();
    let mut queue = nodes.to_vec();
    let mut next = 0;
    while let Some(node) = queue.get(next).map(|node| *node as usize) {
        next += 1;
        for other in parts.on_ground(node) {
            if owners[other] == NONE {
                owners[other] = owners[node];
                queue.push(other as u32);
            }
        }
    }
    owners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::noise;
    use crate::graph::{cells, triangulate};
    use crate::labels::grounds;
    use crate::sites::relax;

    const SIZE: (usize, usize) = (60, 50);

    /// Some nodes on a canvas, with their tones and cell areas.
    fn canvas(count: usize, tone: impl Fn([f64; 2]) -> f64) -> (Triangulation, Vec<f32>, Vec<f64>) {
        let (width, height) = SIZE;
        let random = |k: usize| 0.5 + 0.499 * f64::from(noise(k as u64));
        let scattered = (0..count).map(|k| [random(2 * k) * width as f64, random(2 * k + 1) * height as f64]).collect();
        let mut sites = relax(scattered, width, height, 3, 2, &Control::new()).unwrap();
        sites.sort_by(|a, b| a[1].total_cmp(&b[1]));
        let areas = cells(&sites, width, height, 2, None, &Control::new()).unwrap().areas;
        let tones = sites.iter().map(|site| tone(*site) as f32).collect();
        (triangulate(sites, width, height, &Control::new()).unwrap(), tones, areas)
    }

    fn stippled(triangulation: &Triangulation, grounds: &[u8], tones: &[f32], areas: &[f64]) -> Stippled {
        let labels = vec![0; tones.len()];
        stipple(triangulation, grounds, tones, areas, &labels, SIZE, &Control::new()).unwrap()
    }

    #[test]
    fn dots_stand_apart_and_carry_what_the_ground_lacks() {
        for tone in [0.0, 0.04, 0.2, 0.45, 0.5, 0.7, 0.97, 1.0] {
            let (triangulation, tones, areas) = canvas(900, |_| tone);
            let grounds = grounds(&triangulation.graph, &tones, 0.5).unwrap();
            let Stippled { labels, marks } = stippled(&triangulation, &grounds, &tones, &areas);
            let is_dot = |node: usize| labels[node] != grounds[node];
            let dots: Vec<usize> = (0..tones.len()).filter(|node| is_dot(*node)).collect();
            for dot in &dots {
                assert!(triangulation.graph.row(*dot).iter().all(|other| !is_dot(*other as usize)));
            }
            let (ink, canvas) = (dots.iter().map(|dot| marks.areas[*dot]).sum::<f64>(), areas.iter().sum::<f64>());
            assert!((ink / canvas - tone.min(1.0 - tone)).abs() < 2e-3, "{tone}: {}", ink / canvas);
        }
    }

    #[test]
    fn structured_nodes_stay_and_so_do_those_of_pure_tones() {
        let (triangulation, tones, areas) = canvas(900, |[x, _]| if x < 30.0 { 1.0 } else { 0.7 });
        let sites = &triangulation.graph.sites;
        let grounds: Vec<u8> = sites.iter().map(|[_, y]| if *y < 25.0 { STRUCTURED } else { 1 }).collect();
        let Stippled { labels, marks } = stippled(&triangulation, &grounds, &tones, &areas);
        for (node, site) in sites.iter().enumerate() {
            if grounds[node] == STRUCTURED {
                assert!(labels[node] == 0 && marks.places[node] == *site && marks.areas[node] == areas[node]);
            } else if site[0] < 30.0 {
                assert_eq!(labels[node], 1);
            }
        }
        assert!(labels.iter().zip(&grounds).filter(|(label, ground)| **ground == 1 && **label == 0).count() > 30);
    }

    #[test]
    fn threads_do_not_matter() {
        let (triangulation, tones, areas) = canvas(9000, |[x, y]| 0.5 + 0.45 * (0.2 * x).sin() * (0.1 * y).cos());
        let grounds = grounds(&triangulation.graph, &tones, 1.0).unwrap();
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| stippled(&triangulation, &grounds, &tones, &areas))
        };
        assert!(with(1) == with(3));
    }

    #[test]
    fn a_cancelled_stippling_ends() {
        let (triangulation, tones, areas) = canvas(30, |_| 0.5);
        let (grounds, labels) = (vec![1; tones.len()], vec![0; tones.len()]);
        let cancelled = Control::new();
        cancelled.cancel();
        let result = stipple(&triangulation, &grounds, &tones, &areas, &labels, SIZE, &cancelled);
        assert!(matches!(result, Err(Error::Cancelled)));
    }
}
