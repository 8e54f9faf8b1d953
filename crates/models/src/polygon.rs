//! Triangulation of polygons: fans for convex ones, ears for small ones, a sweep for the others.

mod monotone;

/// Most corners of a polygon whose ears are cut off without asking whether it can be swept: to cut them takes time with the
/// square of their number and more.
const MOST_EARS: usize = 64;
/// Most point tests per file; a file made to need more gets fans for the rest.
const MOST_TESTS: u64 = 1 << 29;

/// Cuts polygons into triangles, with a budget of work for the whole file.
pub(crate) struct Triangulator {
    tests_left: u64,
    /// Corners of the polygon at hand, seen along its normal.
    flat: Vec<[f64; 2]>,
    /// Corners that are not cut off yet.
    ring: Vec<usize>,
}

impl Triangulator {
    pub(crate) fn new() -> Self {
        Self { tests_left: MOST_TESTS, flat: Vec::new(), ring: Vec::new() }
    }

    /// Adds the triangles of one polygon to `triangles`: two fewer than `corners`, in the polygon's orientation.
    /// `position` gives the place of the corner of that number.
    pub(crate) fn add(&mut self, corners: &[u32], position: impl Fn(usize) -> [f32; 3], triangles: &mut Vec<[u32; 3]>) {
        self.ring.clear();
        self.ring.extend(0..corners.len());
        if corners.len() > 3 {
            flatten(corners.len(), position, &mut self.flat);
            self.cut(corners, triangles);
        }
        for pair in self.ring.get(1..).unwrap_or_default().windows(2) {
            triangles.push([self.ring[0], pair[0], pair[1]].map(|corner| corners[corner]));
        }
    }

    /// Cuts the polygon as far as a fan does not do for what is left of the ring.
    fn cut(&mut self, corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
        if self.is_convex() {
            return;
        }
        let is_large = corners.len() > MOST_EARS;
        if let Some(cut) = is_large.then(|| monotone::triangles(&self.flat)).flatten() {
            self.ring.clear();
            triangles.extend(cut.into_iter().map(|triangle| triangle.map(|corner| corners[corner])));
        } else {
            self.cut_ears(corners, triangles);
        }
    }

    /// Cuts ears off until the rest of the ring is a triangle, hopeless or over budget: then a fan has to do.
    fn cut_ears(&mut self, corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
        let (mut at, mut failures) = (0, 0);
        while self.ring.len() > 3 && failures < self.ring.len() {
            let count = self.ring.len();
            let Some(tests_left) = self.tests_left.checked_sub(count as u64) else { return };
            self.tests_left = tests_left;
            let ear = [self.ring[(at + count - 1) % count], self.ring[at], self.ring[(at + 1) % count]];
            if self.is_ear(ear) {
                triangles.push(ear.map(|corner| corners[corner]));
                self.ring.remove(at);
                // The corner before has the best chance to have become an ear.
                at = at.saturating_sub(1);
                failures = 0;
            } else {
                at = (at + 1) % count;
                failures += 1;
            }
        }
    }

    fn is_convex(&self) -> bool {
        let count = self.flat.len();
        (0..count).all(|i| {
            let turn = turn(self.flat[i], self.flat[(i + 1) % count], self.flat[(i + 2) % count]);
            turn >= 0.0 || turn.is_nan()
        })
    }

    fn is_ear(&self, ear: [usize; 3]) -> bool {
        let [a, b, c] = ear.map(|corner| self.flat[corner]);
        let inside = |p: [f64; 2]| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
        let others = || self.ring.iter().map(|corner| self.flat[*corner]).filter(|p| ![a, b, c].contains(p));
        turn(a, b, c) > 0.0 && !others().any(inside)
    }
}

/// Projects the polygon along the axis in which it has most area, so that it turns to the left.
fn flatten(count: usize, position: impl Fn(usize) -> [f32; 3], flat: &mut Vec<[f64; 2]>) {
    let at = |i: usize| position(i % count).map(f64::from);
    // Newell's normal, relative to the first corner to keep the digits of polygons far from the origin.
    let origin = at(0);
    let from_origin = |i: usize| [0, 1, 2].map(|axis| at(i)[axis] - origin[axis]);
    let mut normal = [0.0f64; 3];
    for i in 0..count {
        let (p, q) = (from_origin(i), from_origin(i + 1));
        for (axis, sum) in normal.iter_mut().enumerate() {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            *sum += p[u] * q[v] - p[v] * q[u];
        }
    }
    let size = normal.map(f64::abs);
    let axis = if size[0] > size[1] && size[0] > size[2] {
        0
    } else if size[1] > size[2] {
        1
    } else {
        2
    };
    let (mut u, mut v) = ((axis + 1) % 3, (axis + 2) % 3);
    if normal[axis] < 0.0 {
        (u, v) = (v, u);
    }
    flat.clear();
    flat.extend((0..count).map(|i| [from_origin(i)[u], from_origin(i)[v]]));
}

/// Turn of the way from a over b to c; positive to the left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
