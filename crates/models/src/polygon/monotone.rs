//! Triangulation of large polygons, which are divided into monotone ones by a sweep (`berg2008computational`, chapter 3).
//!
//! A library would be better, but those for polygons of this size take time with its square where ears are long and thin or
//! corners lie on a line, and polygons come from files that may be made to have either.

use std::cmp::Ordering;
use std::collections::BTreeSet;

use robust::{Coord, orient2d};

/// Largest error of the area of all triangles, as a part of the polygon's.
const AREA_ERROR: f64 = 1e-6;

/// The triangles of a polygon that turns to the left, by the numbers of its corners; one for each corner but two, and but
/// those that are where the corner before them is. `None` for a polygon whose edges cross, or turn back on themselves.
pub(super) fn triangles(corners: &[[f64; 2]]) -> Option<Vec<[usize; 3]>> {
    if !corners.as_flattened().iter().all(|x| x.is_finite()) {
        return None;
    }
    let before = corners.iter().cycle().skip(corners.len() - 1);
    let kept = corners.iter().zip(before).enumerate().filter(|(_, (corner, before))| corner != before);
    // Adding zero makes -0 and 0 the same.
    let (numbers, places): (Vec<usize>, Vec<[f64; 2]>) =
        kept.map(|(number, (corner, _))| (number, corner.map(|x| x + 0.0))).unzip();
    let triangles = sweep(Polygon { corners: &places })?;
    Some(triangles.into_iter().map(|triangle| triangle.map(|corner| numbers[corner])).collect())
}

fn sweep(polygon: Polygon<'_>) -> Option<Vec<[usize; 3]>> {
    let count = polygon.corners.len().checked_sub(2)?;
    let diagonals = Sweep::new(polygon).diagonals()?;
    let mut triangles = Vec::with_capacity(count);
    for piece in polygon.pieces(&diagonals)? {
        polygon.cut_monotone(&piece, &mut triangles);
    }
    polygon.is_covered_by(&triangles).then_some(triangles)
}

/// A polygon whose inside is on the left of its edges. The sweep goes from the left to the right, and upwards within a
/// vertical line.
#[derive(Clone, Copy)]
struct Polygon<'a> {
    corners: &'a [[f64; 2]],
}

impl Polygon<'_> {
    fn next(self, corner: usize) -> usize {
        if corner + 1 == self.corners.len() { 0 } else { corner + 1 }
    }

    fn previous(self, corner: usize) -> usize {
        corner.checked_sub(1).unwrap_or(self.corners.len() - 1)
    }

    /// Order in which the sweep comes to corners.
    fn order(self, a: usize, b: usize) -> Ordering {
        order(self.corners[a], self.corners[b]).then(a.cmp(&b))
    }

    /// Whether the sweep comes to `a` before `b`.
    fn is_before(self, a: usize, b: usize) -> bool {
        self.order(a, b).is_lt()
    }

    /// Turn of the way from a over b to c; positive to the left, of the right sign whatever the rounding.
    fn turn(self, a: usize, b: usize, c: usize) -> f64 {
        turn(self.corners[a], self.corners[b], self.corners[c])
    }

    /// Cycles of corners into which diagonals divide the polygon.
    fn pieces(self, diagonals: &[[usize; 2]]) -> Option<Vec<Vec<usize>>> {
        let ways = Ways::new(self, diagonals);
        let mut seen = vec![false; ways.to.len()];
        let mut pieces = Vec::with_capacity(diagonals.len() + 1);
        for first in 0..ways.to.len() {
            let (mut piece, mut way) = (Vec::new(), first);
            while !std::mem::replace(&mut seen[way], true) {
                piece.push(ways.to[way]);
                way = ways.onward[way];
            }
            if way != first {
                return None;
            }
            if !piece.is_empty() {
                pieces.push(piece);
            }
        }
        Some(pieces)
    }

    /// Cuts a piece that the sweep meets in two chains, a lower one that goes on to the right and an upper one that goes
    /// back to the left.
    fn cut_monotone(self, piece: &[usize], triangles: &mut Vec<[usize; 3]>) {
        let sorted = self.chains(piece);
        let mut open: Vec<(usize, bool)> = Vec::new();
        for (i, (corner, is_upper)) in sorted.iter().copied().enumerate() {
            let is_last = i + 1 == sorted.len();
            match open.last().copied() {
                Some(last) if i > 1 && (is_last || last.1 != is_upper) => {
                    for pair in open.windows(2) {
                        let (a, b) = if last.1 { (pair[1].0, pair[0].0) } else { (pair[0].0, pair[1].0) };
                        triangles.push([a, b, corner]);
                    }
                    open.clear();
                    open.push(last);
                }
                Some(_) if i > 1 => {
                    while let [.., (before, _), (last, _)] = open[..] {
                        let (a, c) = if is_upper { (corner, before) } else { (before, corner) };
                        if self.turn(a, last, c) <= 0.0 {
                            break;
                        }
                        triangles.push([a, last, c]);
                        open.pop();
                    }
                }
                _ => {}
            }
            open.push((corner, is_upper));
        }
    }

    /// The corners of a monotone piece in the order of the sweep, and whether each is on the upper chain.
    fn chains(self, piece: &[usize]) -> Vec<(usize, bool)> {
        let count = piece.len();
        let first = (0..count).min_by(|a, b| self.order(piece[*a], piece[*b])).unwrap_or(0);
        let last = (0..count).max_by(|a, b| self.order(piece[*a], piece[*b])).unwrap_or(0);
        let lower_count = (last + count - first) % count;
        let mut sorted: Vec<_> = (0..count).map(|i| (piece[(first + i) % count], i > lower_count)).collect();
        // The chains are sorted already, one forwards and one backwards, which this sort merges in linear time.
        sorted.sort_by(|a, b| self.order(a.0, b.0));
        sorted
    }

    fn is_covered_by(self, triangles: &[[usize; 3]]) -> bool {
        let area = |[a, b, c]: [usize; 3]| self.turn(a, b, c);
        let sum: f64 = triangles.iter().map(|triangle| area(*triangle)).sum();
        let outlined: f64 = (1..self.corners.len() - 1).map(|i| area([0, i, i + 1])).sum();
        triangles.len() + 2 == self.corners.len()
            && triangles.iter().all(|triangle| area(*triangle) >= 0.0)
            && (sum - outlined).abs() <= AREA_ERROR * outlined
    }
}

/// The sweep, which finds the diagonals that divide a polygon into monotone pieces.
struct Sweep<'a> {
    polygon: Polygon<'a>,
    /// Edges under which the outside begins, from below, of those that the sweep is on.
    edges: BTreeSet<Edge>,
    /// For each of these edges, by the corner where it begins, the last corner seen above it and below the next edge.
    helpers: Vec<usize>,
    is_merge: Vec<bool>,
    diagonals: Vec<[usize; 2]>,
}

impl<'a> Sweep<'a> {
    fn new(polygon: Polygon<'a>) -> Self {
        let count = polygon.corners.len();
        let (helpers, is_merge) = (vec![0; count], vec![false; count]);
        Self { polygon, edges: BTreeSet::new(), helpers, is_merge, diagonals: Vec::new() }
    }

    fn diagonals(mut self) -> Option<Vec<[usize; 2]>> {
        let polygon = self.polygon;
        let mut sorted: Vec<usize> = (0..polygon.corners.len()).collect();
        sorted.sort_unstable_by(|a, b| polygon.order(*a, *b));
        for corner in sorted {
            let (previous, next) = (polygon.previous(corner), polygon.next(corner));
            let is_convex = polygon.turn(previous, corner, next) > 0.0;
            match (polygon.is_before(previous, corner), polygon.is_before(next, corner)) {
                // A start or a split: the polygon begins here, or is divided by what begins here.
                (false, false) => {
                    if !is_convex {
                        let below = self.below(corner)?;
                        self.diagonals.push([corner, self.helpers[below]]);
                        self.helpers[below] = corner;
                    }
                    self.begin(corner);
                }
                // An end or a merge.
                (true, true) => {
                    self.end(previous, corner);
                    if !is_convex {
                        self.is_merge[corner] = true;
                        self.pass_above(corner)?;
                    }
                }
                (true, false) => {
                    self.end(previous, corner);
                    self.begin(corner);
                }
                (false, true) => self.pass_above(corner)?,
            }
        }
        Some(self.diagonals)
    }

    fn edge(&self, from: usize) -> Edge {
        let Polygon { corners } = self.polygon;
        Edge { from: corners[from], to: corners[self.polygon.next(from)], corner: from }
    }

    fn begin(&mut self, corner: usize) {
        self.edges.insert(self.edge(corner));
        self.helpers[corner] = corner;
    }

    /// Ends the edge that begins at `from` and ends at `corner`.
    fn end(&mut self, from: usize, corner: usize) {
        self.join_merge(from, corner);
        self.edges.remove(&self.edge(from));
    }

    /// Makes the corner the helper of the edge below it.
    fn pass_above(&mut self, corner: usize) -> Option<()> {
        let below = self.below(corner)?;
        self.join_merge(below, corner);
        self.helpers[below] = corner;
        Some(())
    }

    fn join_merge(&mut self, edge: usize, corner: usize) {
        let helper = self.helpers[edge];
        if self.is_merge[helper] {
            self.diagonals.push([corner, helper]);
        }
    }

    /// The edge directly below a corner, by the corner where it begins.
    fn below(&self, corner: usize) -> Option<usize> {
        let place = self.polygon.corners[corner];
        let point = Edge { from: place, to: place, corner };
        self.edges.range(..point).next_back().map(|edge| edge.corner)
    }
}

/// An edge from the left to the right. The order of two that the sweep is on at the same time is upwards.
#[derive(Clone, Copy)]
struct Edge {
    from: [f64; 2],
    to: [f64; 2],
    corner: usize,
}

impl Ord for Edge {
    fn cmp(&self, other: &Self) -> Ordering {
        if self.corner == other.corner {
            return Ordering::Equal;
        }
        let side = |edge: &Self, point: [f64; 2]| turn(edge.from, edge.to, point);
        // The one that begins later is above or below the other where it begins, or where it ends.
        let self_first = order(self.from, other.from).is_le();
        let (first, later) = if self_first { (self, other) } else { (other, self) };
        let above = [later.from, later.to].map(|point| side(first, point)).into_iter().find(|side| *side != 0.0);
        let order = match above {
            Some(above) if above > 0.0 => Ordering::Less,
            Some(_) => Ordering::Greater,
            None => return self.corner.cmp(&other.corner),
        };
        if self_first { order } else { order.reverse() }
    }
}

impl PartialOrd for Edge {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Edge {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Edge {}

/// Ways from corner to corner inside a polygon: its edges, and its diagonals in both directions.
struct Ways {
    /// Corner at the end of each way.
    to: Vec<usize>,
    /// The way that goes on from the end of each, by the sharpest turn to the left.
    onward: Vec<usize>,
}

impl Ways {
    /// Numbers the edges as the corners where they begin, and the two ways of a diagonal behind all edges.
    fn new(polygon: Polygon<'_>, diagonals: &[[usize; 2]]) -> Self {
        let count = polygon.corners.len();
        let to = (0..count).map(|corner| polygon.next(corner)).chain(diagonals.iter().flat_map(|[a, b]| [*b, *a]));
        let to: Vec<usize> = to.collect();
        let from = diagonals.as_flattened();
        let mut leaving: Vec<usize> = (count..to.len()).collect();
        leaving.sort_unstable_by(|a, b| {
            let corner = from[a - count];
            corner.cmp(&from[b - count]).then_with(|| around(polygon, corner, to[*a], to[*b])).then(a.cmp(b))
        });
        // Without diagonals each edge goes on with the next. A way that arrives goes on with the last one that leaves before
        // its own way back, seen from the corner's edge to the left.
        let mut onward: Vec<usize> = (0..to.len()).map(|way| to[way]).collect();
        for group in leaving.chunk_by(|a, b| from[a - count] == from[b - count]) {
            let corner = from[group[0] - count];
            let mut before = corner;
            for way in group {
                let back = count + ((way - count) ^ 1);
                onward[back] = before;
                before = *way;
            }
            onward[polygon.previous(corner)] = before;
        }
        Self { to, onward }
    }
}

/// Order of two corners around another one: to the left, from its edge to the next corner.
fn around(polygon: Polygon<'_>, corner: usize, a: usize, b: usize) -> Ordering {
    let next = polygon.next(corner);
    let is_beyond = |to: usize| polygon.turn(corner, next, to) < 0.0;
    let left = polygon.turn(corner, a, b);
    is_beyond(a).cmp(&is_beyond(b)).then(if left > 0.0 {
        Ordering::Less
    } else if left < 0.0 {
        Ordering::Greater
    } else {
        Ordering::Equal
    })
}

fn order(a: [f64; 2], b: [f64; 2]) -> Ordering {
    a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
}

fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let [a, b, c] = [a, b, c].map(|[x, y]| Coord { x, y });
    orient2d(a, b, c)
}
