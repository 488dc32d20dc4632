//! Rows of the adjacency, read off Delaunay meshes of tiles that are made side by side.
//!
//! # The idea
//! A canvas with many sites is cut into tiles. Every tile has a mesh of its own sites and of a *halo*, the points nearest to
//! it all around, and the rows of its own sites are read off it. Meshes are small, so they stay in the cache, and only those
//! being worked on are in memory.
//!
//! # Why the rows are those of one mesh of everything
//! Call a triangle of a tile's mesh *mixed* if it joins own sites to other points. If no mixed triangle has a point that the mesh
//! lacks in or on its circumcircle, and no own site is on the mesh's hull, then no triangle at an own site has one:
//! the triangles whose circles hold a new point are connected, edge to edge, and among them is the one that the point lies in. A
//! new point never lies between own sites, as the mesh has all points of the tile, which is a rectangle. So a way from
//! there to a triangle of own sites leads over a mixed one. Points found in the circles of mixed triangles are added to
//! the mesh, until there are none.
//!
//! # Ties
//! Four sites or more on one empty circle have several Delaunay triangulations, of which two tiles could choose different ones.
//! All see all of these sites; where they belong to several tiles, the triangles are those that fan out from the one with the
//! lowest number.
//!
//! Tiles depend on the points alone, so the rows do not depend on the number of threads.

use std::collections::HashSet;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use robust::{Coord, incircle};
use spade::handles::{DirectedEdgeHandle, FaceHandle, FixedVertexHandle, InnerTag};
use spade::{DelaunayTriangulation, HasPosition, InsertionError, Point2, Triangulation as _};

use crate::base::{Control, Error, Result};

/// How tiles are cut.
#[derive(Clone, Copy)]
pub(crate) struct Cut {
    /// How many points a tile has at least; it is halved if both halves have them. Fewer make meshes that the cache holds and threads
    /// that end together, and more of them in halos.
    pub(crate) sites: usize,
    /// How many rows and columns of the grid a tile has at least: its halo should not be most of its mesh.
    pub(crate) side: usize,
    /// Points that a halo has in every column of the grid above and below the tile, and in every row beside it. Fewer leave more to be
    /// added one by one, which takes longer than loading them with the others.
    pub(crate) halo: usize,
}

impl Cut {
    /// By measurements from 0.25 to 16 megapixels: half to four times as many sites, or other halos, take as long to within 3 %.
    pub(crate) const BEST: Self = Self { sites: 1 << 12, side: 16, halo: 3 };
}

/// Points in a cell of the grid, on average: halos are made of whole cells, and circles are searched by them.
const POINTS_A_CELL: f64 = 2.0;

/// A cell with more points than this makes searching its circles slow: sites are then too unevenly spread for tiles.
const MOST_IN_A_CELL: u32 = 256;

/// How many points are added for one circle at a time. The first ones nearly always destroy the triangle, and with it the circle.
const ADDED_AT_ONCE: usize = 16;

/// Sites, and points beyond the frame that complete their triangulation. Guards are numbered behind the sites.
#[derive(Clone, Copy)]
pub(crate) struct Points<'a> {
    pub(crate) sites: &'a [[f64; 2]],
    pub(crate) guards: &'a [[f64; 2]],
}

impl Points<'_> {
    fn len(&self) -> usize {
        self.sites.len() + self.guards.len()
    }

    fn position(&self, point: u32) -> [f64; 2] {
        let point = point as usize;
        if point < self.sites.len() { self.sites[point] } else { self.guards[point - self.sites.len()] }
    }

    fn is_site(&self, point: u32) -> bool {
        (point as usize) < self.sites.len()
    }
}

/// The rows of some sites.
pub(crate) struct Rows {
    /// The sites, in ascending order.
    pub(crate) nodes: Vec<u32>,
    /// Start of every node's row; one more entry than there are nodes.
    pub(crate) starts: Vec<u32>,
    /// The rows, one behind the other, each sorted: sites alone.
    pub(crate) neighbors: Vec<u32>,
    /// For every neighbour, the point to the left of the edge to it.
    pub(crate) left: Vec<u32>,
}

/// The rows of all sites, some sites an entry; none if two points coincide.
///
/// # Errors
/// [`Error::Cancelled`]; [`Error::Internal`] if spade refuses a position.
pub(crate) fn rows(points: Points, frame: [f64; 2], cut: Cut, control: &Control) -> Result<Option<Vec<Rows>>> {
    if points.sites.len() / 2 >= cut.sites {
        let grid = Grid::new(points, frame);
        let tiles = grid.tiles(cut);
        if tiles.len() > 1 && grid.most_in_a_cell() <= MOST_IN_A_CELL {
            match rows_of_tiles(&grid, &tiles, cut.halo, control)? {
                Found::Rows(rows) => return Ok(Some(rows)),
                Found::Coincidence => return Ok(None),
                Found::Unsure => {}
            }
        }
    }
    control.check()?;
    let own = (0..points.sites.len() as u32).collect();
    let Some(mesh) = Mesh::new(points, own, (points.sites.len()..points.len()).map(|guard| guard as u32))? else {
        return Ok(None);
    };
    control.report(0.7)?;
    Ok(Some(vec![mesh.rows(&Fans::default())]))
}

/// What came of one tile, or of all.
enum Found<T> {
    Rows(T),
    /// Two points are in one place.
    Coincidence,
    /// Circles are too large for floating-point numbers to search them.
    Unsure,
}

fn rows_of_tiles(grid: &Grid, tiles: &[Tile], halo: usize, control: &Control) -> Result<Found<Vec<Rows>>> {
    let done = AtomicUsize::new(0);
    let of_tile = |tile: &Tile| {
        control.check()?;
        let found = Mesh::of_tile(&Surroundings::new(grid, tile, halo))?;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        control.report(0.9 * done as f32 / tiles.len() as f32)?;
        Ok(found)
    };
    let found: Vec<Found<Rows>> = tiles.par_iter().map(of_tile).collect::<Result<_>>()?;
    let mut all = Vec::with_capacity(found.len());
    let mut is_sure = true;
    for found in found {
        match found {
            Found::Rows(rows) => all.push(rows),
            Found::Coincidence => return Ok(Found::Coincidence),
            Found::Unsure => is_sure = false,
        }
    }
    Ok(if is_sure { Found::Rows(all) } else { Found::Unsure })
}

/// All points in the cells of a grid over the canvas. Points beyond the frame are in the cells nearest to them.
struct Grid<'a> {
    points: Points<'a>,
    cells_per_pixel: f64,
    columns: usize,
    rows: usize,
    /// Start of every cell's points, row by row; one more entry than there are cells.
    starts: Vec<u32>,
    order: Vec<u32>,
}

impl<'a> Grid<'a> {
    fn new(points: Points<'a>, [width, height]: [f64; 2]) -> Self {
        let cells_per_pixel = (points.len() as f64 / (POINTS_A_CELL * width * height)).sqrt();
        let [columns, rows] = [width, height].map(|length| (length * cells_per_pixel).ceil().max(1.0) as usize);
        let mut grid =
            Self { points, cells_per_pixel, columns, rows, starts: vec![0; columns * rows + 1], order: vec![0; points.len()] };
        // Counted one cell late, so that starts move from the end of the last cell to that of their own while points are put in.
        let cell = |grid: &Self, position: [f64; 2]| grid.row(position[1]) * columns + grid.column(position[0]);
        let positions = || points.sites.iter().chain(points.guards);
        for position in positions() {
            let cell = cell(&grid, *position);
            grid.starts[cell] += 1;
        }
        let mut end = 0;
        for start in &mut grid.starts {
            end += *start;
            *start = end;
        }
        for (point, position) in positions().enumerate() {
            let cell = cell(&grid, *position);
            grid.starts[cell] -= 1;
            grid.order[grid.starts[cell] as usize] = point as u32;
        }
        grid
    }

    fn row(&self, y: f64) -> usize {
        ((y * self.cells_per_pixel) as usize).min(self.rows - 1)
    }

    fn column(&self, x: f64) -> usize {
        ((x * self.cells_per_pixel) as usize).min(self.columns - 1)
    }

    fn most_in_a_cell(&self) -> u32 {
        self.starts.windows(2).map(|cell| cell[1] - cell[0]).max().unwrap_or(0)
    }

    /// The points of some cells of a row.
    fn points_in(&self, row: usize, columns: Range<usize>) -> &[u32] {
        let first = row * self.columns;
        &self.order[self.starts[first + columns.start] as usize..self.starts[first + columns.end] as usize]
    }

    /// Tiles of all points, halved across the longer side for as long as the halves have the points and the sides wanted.
    fn tiles(&self, cut: Cut) -> Vec<Tile> {
        let mut tiles = Vec::new();
        let mut rest = vec![Tile { rows: 0..self.rows, columns: 0..self.columns }];
        while let Some(tile) = rest.pop() {
            match self.halved(&tile, cut) {
                // The first half comes out first.
                Some([first, second]) => rest.extend([second, first]),
                None => tiles.push(tile),
            }
        }
        tiles
    }

    /// Both halves of a tile, with about as many points each; none if one would be too small.
    fn halved(&self, tile: &Tile, cut: Cut) -> Option<[Tile; 2]> {
        let Tile { rows, columns } = tile.clone();
        let across_rows = rows.len() >= columns.len();
        let lines = if across_rows { rows.clone() } else { columns.clone() };
        let count = |line: usize| match across_rows {
            true => self.points_in(line, columns.clone()).len(),
            false => rows.clone().map(|row| self.points_in(row, line..line + 1).len()).sum(),
        };
        let counts: Vec<usize> = lines.clone().map(count).collect();
        let all: usize = counts.iter().sum();
        let mut before = 0;
        let half = counts.iter().position(|count| {
            before += count;
            2 * before >= all
        })?;
        let last = lines.len().checked_sub(cut.side).filter(|last| cut.side <= *last)?;
        let at = (half + 1).clamp(cut.side, last);
        let first: usize = counts[..at].iter().sum();
        if first.min(all - first) < cut.sites {
            return None;
        }
        let [first, second] = [lines.start..lines.start + at, lines.start + at..lines.end];
        Some([first, second].map(|lines| match across_rows {
            true => Tile { rows: lines, columns: columns.clone() },
            false => Tile { rows: rows.clone(), columns: lines },
        }))
    }
}

/// A rectangle of cells of the grid.
#[derive(Clone)]
struct Tile {
    rows: Range<usize>,
    columns: Range<usize>,
}

/// A tile with the cells around it that its mesh has from the start: its halo.
struct Surroundings<'a> {
    grid: &'a Grid<'a>,
    tile: Tile,
    /// Of every row of the tile: the columns of the tile and of the halo on both sides of it.
    beside: Vec<Range<usize>>,
    /// The columns of the tile and some on both sides, for its corners.
    columns: Range<usize>,
    /// Of each of them: the rows of the tile and of the halo above and below it.
    above_and_below: Vec<Range<usize>>,
}

/// Columns of the grid by which the halo above and below a tile is wider than that.
const CORNER: usize = 2;

impl<'a> Surroundings<'a> {
    /// With at least `least` points on either side of every row and every column of the tile, as far as there are any.
    fn new(grid: &'a Grid, tile: &Tile, least: usize) -> Self {
        // The lines on both sides of some lines, up to the one that has the last of these points.
        let around = |lines: &Range<usize>, count: usize, points: &dyn Fn(usize) -> usize| {
            let filled = || {
                let mut found = 0;
                move |line: &usize| {
                    found += points(*line);
                    found >= least
                }
            };
            let start = (0..lines.start).rev().find(filled()).unwrap_or(0);
            let last = (lines.end..count).find(filled()).unwrap_or(count - 1);
            start..last + 1
        };
        let in_cell = |row: usize, column: usize| grid.points_in(row, column..column + 1).len();
        let columns = tile.columns.start.saturating_sub(CORNER)..(tile.columns.end + CORNER).min(grid.columns);
        let beside = tile.rows.clone().map(|row| around(&tile.columns, grid.columns, &|column| in_cell(row, column)));
        let above_and_below = columns.clone().map(|column| around(&tile.rows, grid.rows, &|row| in_cell(row, column)));
        Self { grid, tile: tile.clone(), beside: beside.collect(), above_and_below: above_and_below.collect(), columns }
    }

    /// The points of the tile's cells.
    fn inside(&self) -> impl Iterator<Item = u32> {
        self.tile.rows.clone().flat_map(|row| self.grid.points_in(row, self.tile.columns.clone())).copied()
    }

    /// The points of the halo.
    fn halo(&self) -> impl Iterator<Item = u32> {
        let Tile { rows, columns } = &self.tile;
        let beside = rows.clone().zip(&self.beside).flat_map(|(row, beside)| {
            [beside.start..columns.start, columns.end..beside.end].map(|columns| self.grid.points_in(row, columns))
        });
        let above_and_below = self.columns.clone().zip(&self.above_and_below).flat_map(move |(column, lines)| {
            (lines.start..rows.start).chain(rows.end..lines.end).map(move |row| self.grid.points_in(row, column..column + 1))
        });
        beside.chain(above_and_below).flatten().copied()
    }

    /// Whether a cell is one of the tile or of its halo.
    fn has(&self, row: usize, column: usize) -> bool {
        if self.tile.rows.contains(&row) {
            return self.beside[row - self.tile.rows.start].contains(&column);
        }
        self.columns.contains(&column) && self.above_and_below[column - self.columns.start].contains(&row)
    }
}

/// A circle.
struct Circle {
    center: [f64; 2],
    radius: f64,
}

impl Circle {
    /// A circle that holds the one through three points, whatever the rounding; none if rounding could be too much of it.
    fn around([a, b, c]: [Point2<f64>; 3]) -> Option<Self> {
        let (b, c) = ([b.x - a.x, b.y - a.y], [c.x - a.x, c.y - a.y]);
        let doubled = 2.0 * (b[0] * c[1] - b[1] * c[0]);
        let (b2, c2) = (b[0] * b[0] + b[1] * b[1], c[0] * c[0] + c[1] * c[1]);
        let (x, y) = ((b2 * c[1] - c2 * b[1]) / doubled, (c2 * b[0] - b2 * c[0]) / doubled);
        // Rounding moves the centre by a few 1e-16 of the radius, times this where the corners are nearly in line.
        let sharpness = 1.0 + (b2 * c2).sqrt() / doubled.abs();
        let slack = SLACK * sharpness;
        let radius = (x * x + y * y).sqrt();
        let center = [a.x + x, a.y + y];
        let radius = radius * (1.0 + slack) + SLACK * (center[0].abs() + center[1].abs());
        (slack < 0.1 && radius.is_finite()).then_some(Self { center, radius })
    }

    fn holds(&self, [x, y]: [f64; 2]) -> bool {
        let (dx, dy) = (x - self.center[0], y - self.center[1]);
        dx * dx + dy * dy <= self.radius * self.radius
    }
}

/// Far more than what rounding does to a number of average size: points that are in a circle by this alone cost no more than being added.
const SLACK: f64 = 1e-12;

struct Vertex {
    position: [f64; 2],
    /// Place in [`Mesh::points`]. spade's own order is not the order of insertion.
    index: u32,
}

impl HasPosition for Vertex {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.position[0], self.position[1])
    }
}

type Edge<'a> = DirectedEdgeHandle<'a, Vertex, (), (), ()>;
type Triangle<'a> = FaceHandle<'a, InnerTag, Vertex, (), (), ()>;

/// The triangulation of some points.
struct Mesh<'a> {
    all: Points<'a>,
    mesh: DelaunayTriangulation<Vertex>,
    /// Numbers of the points: own sites in ascending order, then others.
    points: Vec<u32>,
    own: usize,
    /// Which of them every vertex of the mesh is.
    of_vertex: Vec<u32>,
}

fn refused(e: InsertionError) -> Error {
    Error::Internal(format!("the triangulation refused its sites: {e}"))
}

/// Puts vertices in the order in which bulk load inserts them, from the farthest from their mean to the nearest. It finds them sorted
/// then; by itself it reckons distances anew for every comparison.
fn sort_as_loaded(vertices: &mut [Vertex]) {
    let sum = vertices.iter().fold([0.0, 0.0], |[x, y], vertex| [x + vertex.position[0], y + vertex.position[1]]);
    let [x, y] = sum.map(|sum| sum / vertices.len() as f64);
    vertices.sort_by_cached_key(|vertex| {
        let (dx, dy) = (vertex.position[0] - x, vertex.position[1] - y);
        // Numbers that are not negative have the order of their bits.
        std::cmp::Reverse((dx * dx + dy * dy).to_bits())
    });
}

impl<'a> Mesh<'a> {
    /// The mesh of own sites, in ascending order, and other points; none if two coincide.
    fn new(all: Points<'a>, own: Vec<u32>, others: impl IntoIterator<Item = u32>) -> Result<Option<Self>> {
        let own_count = own.len();
        let mut points = own;
        points.extend(others);
        let vertex = |(index, point): (usize, &u32)| Vertex { position: all.position(*point), index: index as u32 };
        let mut vertices: Vec<Vertex> = points.iter().enumerate().map(vertex).collect();
        sort_as_loaded(&mut vertices);
        let mesh = DelaunayTriangulation::bulk_load(vertices).map_err(refused)?;
        if mesh.num_vertices() != points.len() {
            return Ok(None);
        }
        let of_vertex = mesh.vertices().map(|vertex| vertex.data().index).collect();
        Ok(Some(Self { all, mesh, points, own: own_count, of_vertex }))
    }

    /// Triangulates a tile and reads its rows.
    fn of_tile(tile: &Surroundings<'a>) -> Result<Found<Rows>> {
        let all = tile.grid.points;
        let (mut own, mut others): (Vec<u32>, Vec<u32>) = tile.inside().partition(|point| all.is_site(*point));
        own.sort_unstable();
        others.extend(tile.halo());
        let Some(mut mesh) = Self::new(all, own, others)? else {
            return Ok(Found::Coincidence);
        };
        if !mesh.complete(tile)? {
            return Ok(Found::Unsure);
        }
        if mesh.mesh.num_vertices() != mesh.points.len() {
            return Ok(Found::Coincidence);
        }
        Ok(Found::Rows(mesh.rows(&mesh.shared_polygons())))
    }

    /// Adds points until no triangle at an own site can miss one. False if a circle cannot be searched.
    fn complete(&mut self, tile: &Surroundings) -> Result<bool> {
        let mut added = HashSet::new();
        let mut missing = Vec::new();
        if self.mesh.convex_hull().any(|edge| self.is_own(edge.from().fix())) {
            // The hull of all points is one of guards.
            let guards = self.all.sites.len() as u32..self.all.len() as u32;
            let has: HashSet<u32> = self.points[self.own..].iter().copied().collect();
            missing.extend(guards.filter(|guard| !has.contains(guard)));
            added.extend(missing.iter().copied());
            self.add(&missing)?;
        }
        let mut checked = 0;
        loop {
            missing.clear();
            for vertex in checked..self.mesh.num_vertices() {
                if !self.missing_around(FixedVertexHandle::from_index(vertex), tile, &mut added, &mut missing) {
                    return Ok(false);
                }
            }
            if missing.is_empty() {
                return Ok(true);
            }
            // Every new triangle is at a new vertex.
            checked = self.mesh.num_vertices();
            self.add(&missing)?;
        }
    }

    fn is_own(&self, vertex: FixedVertexHandle) -> bool {
        (self.of_vertex[vertex.index()] as usize) < self.own
    }

    fn add(&mut self, points: &[u32]) -> Result<()> {
        for point in points {
            let index = self.points.len() as u32;
            let vertex = Vertex { position: self.all.position(*point), index };
            self.mesh.insert(vertex).map_err(refused)?;
            self.points.push(*point);
            self.of_vertex.push(index);
        }
        Ok(())
    }

    /// Finds points that the mixed triangles at a vertex miss and that are not yet `added`. False if a circle cannot be searched.
    fn missing_around(
        &self,
        vertex: FixedVertexHandle,
        tile: &Surroundings,
        added: &mut HashSet<u32>,
        missing: &mut Vec<u32>,
    ) -> bool {
        if self.is_own(vertex) {
            return true;
        }
        for triangle in self.mesh.vertex(vertex).out_edges().filter_map(|edge| edge.face().as_inner()) {
            if !triangle.vertices().iter().any(|corner| self.is_own(corner.fix())) {
                continue;
            }
            let Some(circle) = Circle::around(triangle.positions()) else {
                return false;
            };
            let Circle { center: [x, y], radius } = circle;
            let grid = tile.grid;
            let before = missing.len();
            for row in grid.row(y - radius)..=grid.row(y + radius) {
                for column in (grid.column(x - radius)..=grid.column(x + radius)).filter(|column| !tile.has(row, *column)) {
                    for point in grid.points_in(row, column..column + 1) {
                        if missing.len() < before + ADDED_AT_ONCE && circle.holds(self.all.position(*point)) && added.insert(*point)
                        {
                            missing.push(*point);
                        }
                    }
                }
            }
        }
        true
    }

    /// Polygons of four corners or more on a circle, own sites and sites of other tiles among them.
    fn shared_polygons(&self) -> Fans {
        let is_other_site = |index: u32| index as usize >= self.own && self.all.is_site(self.points[index as usize]);
        let mut polygons = Vec::new();
        for vertex in (0..self.of_vertex.len()).filter(|vertex| is_other_site(self.of_vertex[*vertex])) {
            for edge in self.mesh.vertex(FixedVertexHandle::from_index(vertex)).out_edges() {
                let Some(triangle) = edge.face().as_inner() else { continue };
                // The rest of the halo has nothing to do with own sites.
                let is_beyond = triangle.vertices().iter().all(|corner| is_other_site(self.of_vertex[corner.index()]));
                if is_beyond || !triangle.adjacent_edges().into_iter().any(is_tie) {
                    continue;
                }
                let mut polygon = self.polygon(triangle);
                if polygon.iter().any(|corner| (*corner as usize) < self.own) {
                    let lowest = (0..polygon.len()).min_by_key(|k| self.points[polygon[*k] as usize]).unwrap_or(0);
                    polygon.rotate_left(lowest);
                    polygons.push(polygon);
                }
            }
        }
        Fans::new(polygons, &self.points, self.own)
    }

    /// The corners, in positive turn, of all triangles that have the circle of this one.
    fn polygon(&self, triangle: Triangle) -> Vec<u32> {
        let [a, b, c] = triangle.adjacent_edges();
        let mut sides = vec![c, b, a];
        let mut corners = Vec::new();
        while let Some(side) = sides.pop() {
            if is_tie(side) {
                sides.extend([side.rev().prev(), side.rev().next()]);
            } else {
                corners.push(self.of_vertex[side.from().index()]);
            }
        }
        corners
    }

    /// The rows of the own sites, with the triangles of the mesh but in the polygons that are cut into fans.
    fn rows(&self, fans: &Fans) -> Rows {
        let point_of: Vec<u32> = self.of_vertex.iter().map(|index| self.points[*index as usize]).collect();
        // Rows are read in the mesh's own order, in which its edges lie close together, and put in that of the sites afterwards.
        let mut read: Vec<u64> = Vec::with_capacity(6 * self.own);
        let mut places = vec![0..0; self.own];
        let mut ring: Vec<u32> = Vec::new();
        for (vertex, index) in self.of_vertex.iter().enumerate().filter(|(_, index)| (**index as usize) < self.own) {
            // All around the node, in positive turn: the triangle to the left of an edge has the end of the next edge as its third
            // node. No site lies on the hull, so the ring closes.
            ring.clear();
            ring.extend(
                self.mesh.vertex(FixedVertexHandle::from_index(vertex)).out_edges().map(|edge| point_of[edge.to().index()]),
            );
            for polygon in fans.at(*index) {
                cut_as_fan(&mut ring, point_of[vertex], polygon);
            }
            let start = read.len();
            for (k, to) in ring.iter().enumerate() {
                if self.all.is_site(*to) {
                    let third = ring[if k + 1 < ring.len() { k + 1 } else { 0 }];
                    // One number is sorted faster than two.
                    read.push(u64::from(*to) << 32 | u64::from(third));
                }
            }
            read[start..].sort_unstable();
            places[*index as usize] = start..read.len();
        }
        let mut rows = Rows {
            nodes: self.points[..self.own].to_vec(),
            starts: Vec::with_capacity(self.own + 1),
            neighbors: Vec::with_capacity(read.len()),
            left: Vec::with_capacity(read.len()),
        };
        rows.starts.push(0);
        for place in places {
            let row = &read[place];
            rows.neighbors.extend(row.iter().map(|entry| (*entry >> 32) as u32));
            rows.left.extend(row.iter().map(|entry| *entry as u32));
            rows.starts.push(rows.neighbors.len() as u32);
        }
        rows
    }
}

/// Polygons whose triangles are to fan out from their first corner. Corners are points, in positive turn.
#[derive(Default)]
struct Fans {
    polygons: Vec<Vec<u32>>,
    /// Every own site, by its place in [`Mesh::points`], with the polygons that it is a corner of, in ascending order.
    corners: Vec<(u32, usize)>,
}

impl Fans {
    /// Of polygons whose corners are places in [`Mesh::points`], of which the first are own sites.
    fn new(mut polygons: Vec<Vec<u32>>, points: &[u32], own: usize) -> Self {
        // Found once for each of several triangles.
        polygons.sort_unstable();
        polygons.dedup();
        let corners_of = |(k, polygon): (usize, &Vec<u32>)| polygon.iter().map(move |corner| (*corner, k)).collect::<Vec<_>>();
        let mut corners: Vec<(u32, usize)> = polygons.iter().enumerate().flat_map(corners_of).collect();
        corners.retain(|(corner, _)| (*corner as usize) < own);
        corners.sort_unstable();
        polygons.iter_mut().flatten().for_each(|corner| *corner = points[*corner as usize]);
        Self { polygons, corners }
    }

    /// The polygons at an own site.
    fn at(&self, index: u32) -> impl Iterator<Item = &[u32]> {
        let first = self.corners.partition_point(|(corner, _)| *corner < index);
        self.corners[first..].iter().take_while(move |(corner, _)| *corner == index).map(|(_, k)| &self.polygons[*k][..])
    }
}

/// Whether the triangles on both sides of an edge have the same circle.
fn is_tie(edge: Edge) -> bool {
    if edge.face().is_outer() || edge.rev().face().is_outer() {
        return false;
    }
    let corners = [edge.from(), edge.to(), edge.next().to(), edge.rev().next().to()];
    let [a, b, c, d] = corners.map(|corner| Coord { x: corner.position().x, y: corner.position().y });
    incircle(a, b, c, d) == 0.0
}

/// Puts into the ring of a corner's neighbours, in positive turn, what it has in a polygon whose triangles fan out from its first corner.
fn cut_as_fan(ring: &mut Vec<u32>, corner: u32, polygon: &[u32]) {
    let place = |ring: &[u32], of: u32| ring.iter().position(|index| *index == of).expect("sides of the polygon are edges");
    let at = place(polygon, corner);
    let (next, last) = (polygon[(at + 1) % polygon.len()], polygon[(at + polygon.len() - 1) % polygon.len()]);
    let between: &[u32] = match at {
        0 => &polygon[2..polygon.len() - 1],
        _ if next == polygon[0] || last == polygon[0] => &[],
        _ => &polygon[..1],
    };
    let start = place(ring, next);
    ring.rotate_left(start);
    let end = place(ring, last);
    ring.splice(1..end, between.iter().copied());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::mixed;

    /// Sites that look random on a canvas of 40 x 40, squeezed by `place`, with guards far around them.
    fn parts(count: u64, place: impl Fn([f64; 2]) -> [f64; 2]) -> usize {
        let unit = |k: u64| mixed(k) as f64 / u64::MAX as f64;
        let sites: Vec<[f64; 2]> = (0..count).map(|k| place([1.0 + 38.0 * unit(2 * k), 1.0 + 38.0 * unit(2 * k + 1)])).collect();
        let guards = [[-90.0, -91.0], [130.0, -92.0], [131.0, 130.0], [-93.0, 132.0]];
        let cut = Cut { sites: 100, side: 4, halo: 1 };
        rows(Points { sites: &sites, guards: &guards }, [40.0, 40.0], cut, &Control::new()).unwrap().unwrap().len()
    }

    #[test]
    fn many_sites_are_cut() {
        assert_eq!(parts(150, |site| site), 1);
        assert!(parts(1000, |site| site) > 3);
        // Half of the canvas is empty.
        assert!(parts(1000, |[x, y]| [x, y / 2.0]) > 1);
    }

    #[test]
    fn crowded_sites_are_not_cut() {
        assert_eq!(parts(1000, |[x, y]| if y < 20.0 { [0.001 * x, 0.001 * y] } else { [x, y] }), 1);
    }

    #[test]
    fn circles_hold_their_corners() {
        let corners = [[1.0, 1.0], [3.0, 1.1], [2.0, 1.05 + 1e-7]];
        let circle = Circle::around(corners.map(|[x, y]| Point2::new(x, y))).unwrap();
        assert!(corners.into_iter().all(|corner| circle.holds(corner)));
        assert!(circle.radius > 1e6);
        assert!(Circle::around([[0.0, 0.0], [1.0, 1.0], [3.0, 3.0]].map(|[x, y]| Point2::new(x, y))).is_none());
    }
}
