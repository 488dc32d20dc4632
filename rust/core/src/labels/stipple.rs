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
//!    A node between dots is shared among them as its cell is cut by their bisectors. The nodes around give way, so that dots
//!    have the room that they need (see [`super::places`]).
//! 3. *How large.* A dot has the area of the ink that it stands for: the tone is kept around every dot, and where tones are flat the
//!    areas are alike. What a dot has no room for goes to those beside it.

use std::f64::consts::PI;

use crate::base::{Control, Error, Frame, Result, STAR_FILL};
use crate::graph::{Triangulation, check_areas, check_finite, check_labels, check_one_a_node, distance_squared};
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
const STEPS: usize = 5;

/// How far from a dot the nodes around it would like to be, in radii.
const RING: f64 = 1.6;

/// How often in a step the nodes around the dots give way.
const GIVING_WAY: usize = 2;

/// How often dots hand on what they have no room for.
const HANDING_ON: usize = 3;

/// Stands for "no dot".
const NONE: u32 = u32::MAX;

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
    let labels: Vec<u8> = labels.iter().zip(grounds).map(|(label, ground)| if *ground == STRUCTURED { *label } else { *ground }).collect();
    let lack_of = |(ground, tone): (&u8, &f32)| match ground {
        0 => f64::from(*tone).clamp(0.0, 1.0),
        1 => (1.0 - f64::from(*tone)).clamp(0.0, 1.0),
        _ => 0.0,
    };
    let lacks: Vec<f64> = grounds.iter().zip(tones).map(lack_of).collect();
    let parts = Parts { triangulation, grounds, labels: &labels, areas, lacks: &lacks };
    let mut dots = Dots::choose(&parts);
    let frame = Frame { width: width as f64, height: height as f64 };
    let mut places = Places::new(triangulation, areas, frame);
    let mut carried = Vec::new();
    for step in 0..=STEPS {
        control.check()?;
        dots.find_owners(&parts, &places);
        carried = dots.carry(&parts, &places);
        if step < STEPS {
            dots.step(&parts, &carried, &mut places);
        }
    }
    let inks = dots.inks_with_room(&parts, &carried, &places);
    let (mut labels, mut areas) = (labels.clone(), areas.to_vec());
    for (node, ink) in dots.nodes.iter().map(|node| *node as usize).zip(inks) {
        if ink >= LEAST_INK * parts.cell_around(node) {
            (labels[node], areas[node]) = (1 - grounds[node], ink);
        }
    }
    Ok(Stippled { labels, marks: Marks { places: places.places, areas } })
}

/// What is stippled.
struct Parts<'a> {
    triangulation: &'a Triangulation,
    grounds: &'a [u8],
    /// Without dots.
    labels: &'a [u8],
    areas: &'a [f64],
    /// What the ground lacks, in [0, 1].
    lacks: &'a [f64],
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

    /// Whether a node and all its neighbours have the label of its ground.
    fn is_within_ground(&self, node: usize) -> bool {
        let ground = self.grounds[node];
        ground != STRUCTURED && self.row(node).iter().all(|other| self.labels[*other as usize] == ground)
    }

    /// The mean area of the cells of a node and its neighbours.
    fn cell_around(&self, node: usize) -> f64 {
        let row = self.row(node);
        row.iter().fold(self.areas[node], |sum, other| sum + self.areas[*other as usize]) / (row.len() + 1) as f64
    }

    /// How far from others a dot at this node would like to be.
    fn distance_wanted(&self, node: usize) -> f64 {
        let (sum, count) = self.on_ground(node).fold((self.lacks[node], 1.0), |(sum, count), other| (sum + self.lacks[other], count + 1.0));
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

/// The dots, none beside another.
struct Dots {
    /// The node of every dot.
    nodes: Vec<u32>,
    /// The dot of every node, or [`NONE`].
    at: Vec<u32>,
    /// The dot nearest to every node's site, on the same ground; [`NONE`] where none is.
    owners: Vec<u32>,
}

impl Dots {
    fn choose(parts: &Parts) -> Self {
        let count = parts.grounds.len();
        let wanted: Vec<f64> =
            (0..count).map(|node| if parts.grounds[node] == STRUCTURED { 0.0 } else { parts.distance_wanted(node) }).collect();
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
        Self { nodes, at, owners }
    }

    fn place(&self, places: &Places, dot: u32) -> [f64; 2] {
        places.places[self.nodes[dot as usize] as usize]
    }

    /// Asks every node again which of the dots of its neighbours is nearest.
    fn find_owners(&mut self, parts: &Parts, places: &Places) {
        // Dots have moved by less than their distance: twice is enough.
        for node in (0..self.owners.len()).chain((0..self.owners.len()).rev()) {
            let own = self.owners[node];
            if own == NONE {
                continue;
            }
            let distance = |dot: u32| distance_squared(parts.site(node), self.place(places, dot));
            let mut nearest = (distance(own), own);
            for other in parts.on_ground(node) {
                let dot = self.owners[other];
                if dot != nearest.1 {
                    let distance = distance(dot);
                    if distance < nearest.0 {
                        nearest = (distance, dot);
                    }
                }
            }
            self.owners[node] = nearest.1;
        }
    }

    /// The dots that share a node, each with its part of it: about what the bisectors between them leave of the node's cell.
    fn sharing(&self, parts: &Parts, places: &Places, node: usize, shares: &mut Vec<(u32, f64)>) {
        shares.clear();
        if self.owners[node] == NONE {
            return;
        }
        shares.push((self.owners[node], 1.0));
        for other in parts.on_ground(node) {
            let dot = self.owners[other];
            if shares.len() < MOST_SHARING && shares.iter().all(|(known, _)| *known != dot) {
                shares.push((dot, 1.0));
            }
        }
        if shares.len() == 1 {
            return;
        }
        let (site, side) = (parts.site(node), parts.areas[node].sqrt());
        let mut total = 0.0;
        for k in 0..shares.len() {
            let own = self.place(places, shares[k].0);
            let mut share = 1.0;
            for (other, _) in shares.iter().enumerate().filter(|(l, _)| *l != k).map(|(_, other)| other) {
                let other = self.place(places, *other);
                // How far the node lies on the dot's side of the bisector.
                let off = distance_squared(site, other) - distance_squared(site, own);
                let apart = 2.0 * distance_squared(own, other).sqrt() * side;
                share *= if apart > 0.0 { (0.5 + off / apart).clamp(0.0, 1.0) } else { 0.5 };
            }
            shares[k].1 = share;
            total += share;
        }
        if total > 0.0 {
            shares.iter_mut().for_each(|(_, share)| *share /= total);
        } else {
            shares.truncate(1);
        }
    }

    /// What every dot stands for.
    fn carry(&self, parts: &Parts, places: &Places) -> Vec<Carried> {
        let mut carried = vec![Carried::default(); self.nodes.len()];
        let mut shares = Vec::with_capacity(MOST_SHARING);
        for node in 0..self.owners.len() {
            self.sharing(parts, places, node, &mut shares);
            let (site, ink) = (parts.site(node), parts.lacks[node] * parts.areas[node]);
            for (dot, share) in &shares {
                let carried = &mut carried[*dot as usize];
                let ink = share * ink;
                carried.ink += ink;
                carried.moment = [carried.moment[0] + ink * site[0], carried.moment[1] + ink * site[1]];
            }
        }
        carried
    }

    /// A Lloyd step of the dots, for which the nodes around them give way.
    fn step(&self, parts: &Parts, carried: &[Carried], places: &mut Places) {
        for (node, carried) in self.nodes.iter().map(|node| *node as usize).zip(carried) {
            if carried.ink > 0.0 {
                let middle = carried.moment.map(|moment| moment / carried.ink);
                let room = carried.radius().min(places.room(node, places.places[node]));
                places.move_towards(node, middle, |places, to| places.room(node, to) >= room);
            }
        }
        for _ in 0..GIVING_WAY {
            for node in 0..self.at.len() {
                if self.at[node] == NONE && parts.is_within_ground(node) {
                    self.give_way(parts, carried, node, places);
                }
            }
        }
    }

    /// Moves a node between dots to the middle of its neighbours, and out of the rings around dots.
    fn give_way(&self, parts: &Parts, carried: &[Carried], node: usize, places: &mut Places) {
        let row = parts.row(node);
        if row.iter().all(|other| self.at[*other as usize] == NONE) {
            return;
        }
        let [mut x, mut y] = places.places[node];
        if !places.is_at_frame(node) {
            let sum = row.iter().fold([0.0; 2], |[x, y], other| {
                let place = places.places[*other as usize];
                [x + place[0], y + place[1]]
            });
            [x, y] = sum.map(|sum| sum / row.len() as f64);
        }
        let mut to = [x, y];
        for other in row {
            let Some(carried) = carried.get(self.at[*other as usize] as usize) else { continue };
            let place = places.places[*other as usize];
            let (ring, distance) = (RING * carried.radius(), distance_squared([x, y], place).sqrt());
            if distance > 0.0 && distance < ring {
                let out = (ring - distance) / distance;
                to = [to[0] + out * (x - place[0]), to[1] + out * (y - place[1])];
            }
        }
        places.move_towards(node, to, |_, _| true);
    }

    /// The ink of every dot, after those that have no room for theirs have handed it on to those that share nodes with them.
    fn inks_with_room(&self, parts: &Parts, carried: &[Carried], places: &Places) -> Vec<f64> {
        let mut inks: Vec<f64> = carried.iter().map(|carried| carried.ink).collect();
        let room = |node: &u32| STAR_FILL * places.room(*node as usize, places.places[*node as usize]);
        let most: Vec<f64> = self.nodes.iter().map(|node| PI * room(node) * room(node)).collect();
        // All groups of dots that share a node.
        let (mut groups, mut ends, mut shares) = (Vec::new(), Vec::new(), Vec::with_capacity(MOST_SHARING));
        for node in 0..self.owners.len() {
            self.sharing(parts, places, node, &mut shares);
            if shares.len() > 1 {
                groups.extend(shares.iter().map(|(dot, _)| *dot as usize));
                ends.push(groups.len());
            }
        }
        let groups: Vec<&[usize]> = std::iter::once(&0).chain(&ends).zip(&ends).map(|(begin, end)| &groups[*begin..*end]).collect();
        for _ in 0..HANDING_ON {
            let over: Vec<f64> = inks.iter().zip(&most).map(|(ink, most)| (ink - most).max(0.0)).collect();
            let pairs = || {
                let from = |group: &&[usize]| group.iter().copied().filter(|dot| over[*dot] > 0.0).collect::<Vec<_>>();
                let to = |group: &&[usize]| group.iter().copied().filter(|dot| inks[*dot] < most[*dot]).collect::<Vec<_>>();
                groups.iter().flat_map(move |group| {
                    let to = to(group);
                    from(group).into_iter().flat_map(move |from| to.clone().into_iter().map(move |to| (from, to)))
                })
            };
            let (mut takers, mut handed) = (vec![0u32; inks.len()], vec![0.0; inks.len()]);
            pairs().for_each(|(from, _)| takers[from] += 1);
            pairs().for_each(|(from, to)| handed[to] += over[from] / f64::from(takers[from]));
            for (dot, ink) in inks.iter_mut().enumerate() {
                *ink += handed[dot] - if takers[dot] > 0 { over[dot] } else { 0.0 };
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
