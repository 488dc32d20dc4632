//! Ways through black, and the bands that are drawn along them. In: edges of a graph that join white pieces; out: nodes that become
//! white, where they are drawn, and how far inside of a band every node lies.
//!
//! # The idea
//! A way from node to node staggers. So its nodes move to the middle between those before and after them, as far as no triangle is
//! turned over, until it runs as a line does that somebody draws. Along it the black nodes nearer than half a width become white, and
//! boundaries are drawn where the band ends and not halfway between nodes (see [`Bands`](crate::stages::Bands)): so a bridge is as
//! wide as it is to be where nodes are closer than that, and where they are farther apart.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use kurbo::Point;

use crate::base::{Control, Frame, Result, distance_to_segment};
use crate::graph::{Components, Triangulation, components};
use crate::labels::Places;
use crate::rules::pieces::AtFrame;

/// How often the nodes of a way move: as many straighten a zigzag of about as many nodes.
const STRAIGHTENING: usize = 12;

/// The part of an edge that boundaries keep from its nodes: they cannot end a band closer to a node than that, so where a band ends
/// closer, the node becomes white too.
const CLEARANCE: f32 = 0.2;

/// Black pieces that bridges cut off become white too if they have less area than this, in squares of their width: no machine holds
/// them, and nobody misses them.
const CRUMB: f64 = 1.0;

/// A black dot beside a band that would have less than this part of its radius goes.
const LEAST_DOT: f32 = 0.7;

/// A labelled graph, as it is drawn, in pixels of the raster.
pub(super) struct Sheet<'a> {
    pub(super) triangulation: &'a Triangulation,
    pub(super) at_frame: &'a AtFrame,
    pub(super) frame: Frame,
    pub(super) labels: Vec<u8>,
    /// Where nodes are drawn.
    pub(super) places: Vec<[f64; 2]>,
    /// Areas of their cells.
    pub(super) areas: &'a [f64],
}

/// What bands make of the nodes.
#[derive(Clone)]
pub(super) struct Banded {
    pub(super) depths: Vec<f32>,
    pub(super) is_added: Vec<bool>,
    /// Black dots beside bands that must have no larger a radius than this.
    pub(super) small_dots: Vec<(u32, f32)>,
}

impl Sheet<'_> {
    fn place(&self, node: u32) -> Point {
        let [x, y] = self.places[node as usize];
        Point::new(x, y)
    }

    /// Where a node that meets the frame is joined to it: the nearest point of the sides that it meets.
    pub(super) fn on_frame(&self, node: u32) -> Point {
        let place = self.place(node);
        let sides = self.at_frame.sides(node).unwrap_or_default().iter();
        let feet = sides.map(|side| self.frame.project(place, *side));
        feet.min_by(|a, b| place.distance_squared(*a).total_cmp(&place.distance_squared(*b))).unwrap_or(place)
    }

    /// Moves the black nodes of a way so that it staggers less. An edge to the frame has a number that is no node's.
    pub(super) fn straighten(&mut self, edges: &[[u32; 2]], control: &Control) -> Result<()> {
        let count = self.labels.len() as u32;
        let within = edges.iter().filter(|[a, b]| *a < count && *b < count);
        let mut beside: Vec<[u32; 2]> = within.flat_map(|[a, b]| [[*a, *b], [*b, *a]]).collect();
        beside.sort_unstable();
        let others = |node: u32| {
            let from = beside.partition_point(|[other, _]| *other < node);
            beside[from..].iter().take_while(move |[other, _]| *other == node).map(|[_, other]| *other as usize)
        };
        let mut nodes: Vec<u32> = beside.iter().map(|[node, _]| *node).collect();
        nodes.dedup();
        nodes.retain(|node| {
            self.labels[*node as usize] == 0 && self.at_frame.sides(*node).is_none() && others(*node).nth(1).is_some()
        });
        let mut places = Places::at(std::mem::take(&mut self.places), self.triangulation, self.areas, self.frame);
        for _ in 0..STRAIGHTENING {
            control.check()?;
            places.visit(&nodes, |places, node| {
                let (mut sum, mut count) = ([0.0; 2], 0.0);
                for other in others(node as u32) {
                    let [x, y] = places.place(other);
                    (sum, count) = ([sum[0] + x, sum[1] + y], count + 1.0);
                }
                places.move_towards(node, sum.map(|sum| sum / count), |_, _| true);
            });
        }
        self.places = places.places;
        Ok(())
    }

    /// Makes white what lies within `half` px of the edges, whose numbers beyond those of nodes stand for the frame.
    /// Black dots have such radii.
    pub(super) fn band(&mut self, edges: &[[u32; 2]], half: f64, radius: impl Fn(u32) -> f32, control: &Control) -> Result<Banded> {
        let graph = &self.triangulation.graph;
        let count = self.labels.len();
        let segments: Vec<[Point; 2]> = (edges.iter())
            .map(|[a, b]| match [*a, *b].map(|node| (node as usize) < count) {
                [true, true] => [self.place(*a), self.place(*b)],
                [true, false] => [self.place(*a), self.on_frame(*a)],
                _ => [self.place(*b), self.on_frame(*b)],
            })
            .collect();
        let mut near = Near { distances: vec![f32::INFINITY; count], open: BinaryHeap::new() };
        for (segment, edge) in (0u32..).zip(edges) {
            for node in edge.iter().filter(|node| (**node as usize) < count) {
                near.meet(*node, segment, 0.0);
            }
        }
        let distance = |node: u32, segment: u32| {
            let [a, b] = segments[segment as usize];
            distance_to_segment(self.place(node), a, b) as f32
        };
        let half = half as f32;
        let mut inside = Vec::new();
        let mut steps = 0usize;
        while let Some(Reached { distance: at, node, segment }) = near.open.pop() {
            if at > near.distances[node as usize] || at > half {
                continue;
            }
            steps += 1;
            if steps.is_multiple_of(1 << 14) {
                control.check()?;
            }
            inside.push((node, segment));
            for other in graph.row(node as usize) {
                near.meet(*other, segment, distance(*other, segment));
            }
        }
        let mut is_added = vec![false; count];
        for (node, _) in &inside {
            is_added[*node as usize] = self.labels[*node as usize] == 0;
        }
        // Those just outside, too near for a boundary to pass.
        let mut rim = Vec::new();
        for (node, segment) in &inside {
            let own = near.distances[*node as usize];
            for other in graph.row(*node as usize) {
                let apart = near.distances[*other as usize];
                if self.labels[*other as usize] == 0 && apart > half && apart - half < CLEARANCE * (apart - own) {
                    is_added[*other as usize] = true;
                    rim.push((*other, *segment));
                }
            }
        }
        for (node, segment) in rim {
            for other in graph.row(node as usize) {
                near.meet(*other, segment, distance(*other, segment));
            }
        }
        for (label, is_added) in self.labels.iter_mut().zip(&is_added) {
            *label |= u8::from(*is_added);
        }
        let depth = |distance: &f32| if distance.is_finite() { half - distance } else { f32::NAN };
        let mut banded = Banded { depths: near.distances.iter().map(depth).collect(), is_added, small_dots: Vec::new() };
        self.sweep_crumbs(&mut banded, CRUMB * f64::from(4.0 * half * half));
        self.clear_dots(&mut banded, radius);
        Ok(banded)
    }

    /// Black dots that reach into bands become smaller, or white where little would be left of them.
    fn clear_dots(&mut self, banded: &mut Banded, radius: impl Fn(u32) -> f32) {
        let Components { ids, sizes } = components(&self.triangulation.graph, &self.labels);
        let is_dot = |node: usize| self.labels[node] == 0 && sizes[ids[node] as usize] == 1 && banded.depths[node].is_finite();
        for node in (0..ids.len()).filter(|node| is_dot(*node)).collect::<Vec<_>>() {
            // How far the rim of the band is.
            let (room, radius) = (-banded.depths[node], radius(node as u32));
            if room < LEAST_DOT * radius {
                (self.labels[node], banded.is_added[node]) = (1, true);
            } else if room < radius {
                banded.small_dots.push((node as u32, room));
            }
        }
    }

    /// Makes white what bands have cut off of black and has less than this area.
    fn sweep_crumbs(&mut self, banded: &mut Banded, least: f64) {
        let graph = &self.triangulation.graph;
        let Components { ids, sizes } = components(graph, &self.labels);
        let (mut areas, mut is_cut_off) = (vec![0.0; sizes.len()], vec![false; sizes.len()]);
        for (node, id) in ids.iter().enumerate() {
            areas[*id as usize] += self.areas[node];
            if banded.is_added[node] {
                graph.row(node).iter().for_each(|other| is_cut_off[ids[*other as usize] as usize] = true);
            }
        }
        for (node, id) in ids.iter().map(|id| *id as usize).enumerate() {
            if self.labels[node] == 0 && is_cut_off[id] && areas[id] < least {
                (self.labels[node], banded.is_added[node]) = (1, true);
            }
        }
    }
}

impl Banded {
    /// A dot of this radius that stays, with bands beside it.
    pub(super) fn add_dot(&mut self, sheet: &Sheet<'_>, node: u32, radius: f64) {
        let centre = sheet.place(node);
        let around = sheet.triangulation.graph.row(node as usize).iter().copied();
        for other in around.chain([node]) {
            let depth = (radius - (sheet.place(other) - centre).hypot2().sqrt()) as f32;
            let known = &mut self.depths[other as usize];
            // The largest, which a number is before none.
            *known = known.max(depth);
        }
        self.is_added[node as usize] = true;
    }
}

/// How near nodes are to the segments of ways.
struct Near {
    distances: Vec<f32>,
    open: BinaryHeap<Reached>,
}

/// A node at some distance from a segment: the nearest first, of those the lowest.
#[derive(PartialEq)]
struct Reached {
    distance: f32,
    node: u32,
    segment: u32,
}

impl Near {
    fn meet(&mut self, node: u32, segment: u32, distance: f32) {
        let known = &mut self.distances[node as usize];
        if distance < *known {
            *known = distance;
            self.open.push(Reached { distance, node, segment });
        }
    }
}

impl Eq for Reached {}

impl Ord for Reached {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_distance = other.distance.total_cmp(&self.distance);
        by_distance.then(other.node.cmp(&self.node)).then(other.segment.cmp(&self.segment))
    }
}

impl PartialOrd for Reached {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
