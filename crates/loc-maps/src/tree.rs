//! A bounding volume hierarchy: finds the items near a point or hit by a ray without a linear
//! search.
//!
//! The items are split recursively at the median of their centres along the longer side of their
//! box. The same tree serves line segments and points, and its answers are exactly those of a
//! linear search, which the tests of the maps check.

use crate::Bounds;
use nalgebra::{Point2, Vector2};

/// Maximum number of items in a leaf.
const LEAF: usize = 4;
/// Maximum number of levels: every level halves, so 2^60 items fit.
const DEPTH: usize = 64;
/// Tolerance of a search for rounding in positions \[m\].
const SLACK: f64 = 1e-9;

/// An item of a [`BoxTree`].
pub(crate) trait Bounded: Copy {
    /// The smallest box around it.
    fn bounds(&self) -> Bounds;
}

impl Bounded for Point2<f64> {
    fn bounds(&self) -> Bounds {
        Bounds { min: *self, max: *self }
    }
}

/// A ray from a point along a unit vector.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray {
    pub(crate) origin: Point2<f64>,
    pub(crate) along: Vector2<f64>,
}

impl Ray {
    /// The ray from a point in a direction \[rad\].
    pub(crate) fn new(origin: &Point2<f64>, direction: f64) -> Ray {
        let (sin, cos) = direction.sin_cos();
        Ray { origin: *origin, along: Vector2::new(cos, sin) }
    }
}

/// Items with their indices, sorted into a tree of boxes.
#[derive(Debug, Clone)]
pub(crate) struct BoxTree<T> {
    items: Vec<(usize, T)>,
    /// A node is followed by its first child.
    nodes: Vec<Node>,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    bounds: Bounds,
    /// A leaf's first item, or an inner node's second child.
    link: usize,
    /// Number of items of a leaf, 0 for an inner node.
    count: usize,
}

impl<T: Bounded> BoxTree<T> {
    pub(crate) fn new(items: impl IntoIterator<Item = T>) -> Self {
        let items: Vec<(usize, T)> = items.into_iter().enumerate().collect();
        let mut tree = BoxTree { nodes: Vec::with_capacity(items.len()), items };
        tree.build(0, tree.items.len());
        tree
    }

    /// The box around everything.
    pub(crate) fn bounds(&self) -> Option<Bounds> {
        self.nodes.first().map(|node| node.bounds)
    }

    fn build(&mut self, first: usize, count: usize) {
        let items = &mut self.items[first..first + count];
        let Some(bounds) = items.iter().map(|(_, item)| item.bounds()).reduce(Bounds::union) else {
            return;
        };
        let index = self.nodes.len();
        self.nodes.push(Node { bounds, link: first, count });
        if count <= LEAF {
            return;
        }
        let axis = usize::from(bounds.height() > bounds.width());
        let middle = |item: &T| item.bounds().center()[axis];
        let half = count / 2;
        items.select_nth_unstable_by(half, |a, b| {
            middle(&a.1).total_cmp(&middle(&b.1)).then(a.0.cmp(&b.0))
        });
        self.build(first, half);
        let second = self.nodes.len();
        self.build(first + half, count - half);
        self.nodes[index] = Node { bounds, link: second, count: 0 };
    }

    /// Index and distance of the first item on a ray, up to `max_range`.
    ///
    /// `hit` gives the distance of an item along the ray, at most `margin` \[m\] off its box.
    pub(crate) fn cast(
        &self,
        ray: &Ray,
        max_range: f64,
        margin: f64,
        hit: impl Fn(&T) -> Option<f64>,
    ) -> Option<(usize, f64)> {
        let slabs = Slabs { ray: *ray, inverse: ray.along.map(f64::recip), margin: margin + SLACK };
        let mut best = (None, max_range);
        self.descend(
            max_range,
            |bounds, limit| slabs.entry(bounds, limit),
            |index, item, limit| match hit(item) {
                Some(far) if far < *limit || (best.0.is_none() && far <= *limit) => {
                    *limit = far;
                    best = (Some(index), far);
                }
                _ => {}
            },
        );
        best.0.map(|index| (index, best.1))
    }

    /// Index and squared distance of the item nearest to a point, up to `limit`.
    pub(crate) fn nearest(
        &self,
        point: &Point2<f64>,
        limit: f64,
        squared_distance: impl Fn(&T) -> f64,
    ) -> Option<(usize, f64)> {
        let mut best = (None, limit);
        self.descend(
            limit,
            |bounds, limit| Some(bounds.squared_distance(point)).filter(|far| far <= limit),
            |index, item, limit| {
                let far = squared_distance(item);
                if far < *limit || (best.0.is_none() && far <= *limit) {
                    *limit = far;
                    best = (Some(index), far);
                }
            },
        );
        best.0.map(|index| (index, best.1))
    }

    /// Visits every item whose boxes pass `enter`.
    pub(crate) fn visit(&self, enter: impl Fn(&Bounds) -> bool, mut each: impl FnMut(usize, &T)) {
        self.descend(
            0.0,
            |bounds, _| enter(bounds).then_some(0.0),
            |index, item, _| each(index, item),
        );
    }

    /// Descends, nearer boxes first; `entry` gives the distance of a box, `None` to skip it.
    #[inline]
    fn descend(
        &self,
        mut limit: f64,
        entry: impl Fn(&Bounds, &f64) -> Option<f64>,
        mut leaf: impl FnMut(usize, &T, &mut f64),
    ) {
        let mut stack = [(0, 0.0); DEPTH];
        let mut height = 0;
        let mut next = self.nodes.first().and_then(|node| entry(&node.bounds, &limit)).map(|_| 0);
        while let Some(index) = next {
            let node = &self.nodes[index];
            let mut down = None;
            if node.count > 0 {
                for (index, item) in &self.items[node.link..node.link + node.count] {
                    leaf(*index, item, &mut limit);
                }
            } else {
                let children = [index + 1, node.link];
                let [a, b] = children.map(|child| entry(&self.nodes[child].bounds, &limit));
                down = match (a, b) {
                    (Some(a), Some(b)) => {
                        let (near, far) = if b < a { (1, 0) } else { (0, 1) };
                        stack[height] = (children[far], a.max(b));
                        height += 1;
                        Some(children[near])
                    }
                    (Some(_), None) => Some(children[0]),
                    (None, Some(_)) => Some(children[1]),
                    (None, None) => None,
                };
            }
            while down.is_none() && height > 0 {
                height -= 1;
                down = Some(stack[height]).filter(|waiting| waiting.1 <= limit).map(|w| w.0);
            }
            next = down;
        }
    }
}

/// A ray prepared for the slab test.
struct Slabs {
    ray: Ray,
    inverse: Vector2<f64>,
    margin: f64,
}

impl Slabs {
    /// Where the ray enters a box grown by the margin, at most at `limit`.
    #[inline]
    fn entry(&self, bounds: &Bounds, limit: &f64) -> Option<f64> {
        let (mut enter, mut leave) = (0.0, *limit);
        for axis in 0..2 {
            let origin = self.ray.origin[axis];
            let a = (bounds.min[axis] - self.margin - origin) * self.inverse[axis];
            let b = (bounds.max[axis] + self.margin - origin) * self.inverse[axis];
            enter = a.min(b).max(enter);
            leave = a.max(b).min(leave);
        }
        (enter <= leave).then_some(enter)
    }
}
