//! The map of one particle: independent landmarks ([`LandmarkEstimate`]), each a Kalman filter of
//! two numbers, in a list whose copies share memory ([`ParticleMap`]).
//!
//! Given the path of the robot, the errors of all observations are independent, and so are the
//! landmarks. A particle needs no covariance between them.

use super::observation::{Linearized, Located};
use loc_core::Gaussian;
use loc_filters::slam::MapSettings;
use nalgebra::Matrix2;
use std::sync::Arc;

/// A landmark with this score or less is removed.
const NO_SCORE: f64 = 1e-9;

/// The estimate of a landmark by a particle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LandmarkEstimate {
    pub(super) id: u32,
    pub(super) position: Gaussian<2>,
    pub(super) observations: u32,
    /// Score of the evidence for it, see [`MapSettings`].
    pub(super) score: f64,
    pub(super) confirmed: bool,
    /// The moment of its last observation, counted by the filter.
    pub(super) seen_at: u64,
}

impl LandmarkEstimate {
    pub(super) fn new(id: u32, located: &Located, moment: u64, map: &MapSettings) -> Self {
        let confirmed = map.confirm_score <= 1.0;
        let position = located.position;
        LandmarkEstimate { id, position, observations: 1, score: 1.0, confirmed, seen_at: moment }
    }

    /// Corrects the position by an observation from a certain pose; `covariance` is that of its
    /// residual. In Joseph form, which stays symmetric and positive.
    pub(super) fn correct(&mut self, linearized: &Linearized, covariance: &Matrix2<f64>) {
        let Some(inverse) = covariance.try_inverse() else { return };
        let p = self.position.covariance;
        let gain = p * linearized.by_landmark.transpose() * inverse;
        self.position.mean += gain * linearized.residual;
        let rest = Matrix2::identity() - gain * linearized.by_landmark;
        let corrected = rest * p * rest.transpose() + gain * linearized.noise * gain.transpose();
        self.position.covariance = 0.5 * (corrected + corrected.transpose());
    }

    /// Raises the score after an observation.
    pub(super) fn support(&mut self, moment: u64, map: &MapSettings) {
        self.seen_at = moment;
        self.observations = self.observations.saturating_add(1);
        self.score = (self.score + 1.0).min(map.max_score());
        self.confirmed |= self.score >= map.confirm_score;
    }

    /// Lowers the score after a contradiction or a missed observation.
    pub(super) fn penalize(&mut self, cost: f64) {
        self.score -= cost;
    }

    pub(super) fn is_false(&self) -> bool {
        self.score <= NO_SCORE
    }
}

/// The landmarks of one particle in slots, of which some are empty. Copies share equal parts.
#[derive(Debug, Clone, Default)]
pub(super) struct ParticleMap {
    slots: SharedList<Option<LandmarkEstimate>>,
    /// How many slots hold a landmark.
    len: usize,
}

impl ParticleMap {
    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn get(&self, slot: usize) -> Option<&LandmarkEstimate> {
        self.slots.get(slot)?.as_ref()
    }

    pub(super) fn get_mut(&mut self, slot: usize) -> Option<&mut LandmarkEstimate> {
        // An empty slot is left shared.
        self.get(slot)?;
        self.slots.get_mut(slot)?.as_mut()
    }

    /// Puts a landmark into the next slot.
    pub(super) fn push(&mut self, estimate: LandmarkEstimate) {
        self.slots.push(Some(estimate));
        self.len += 1;
    }

    /// Puts a landmark into an empty slot, which need not be there yet.
    pub(super) fn put(&mut self, slot: usize, estimate: LandmarkEstimate) {
        while self.slots.len() <= slot {
            self.slots.push(None);
        }
        if let Some(located) = self.slots.get_mut(slot) {
            self.len += usize::from(located.is_none());
            *located = Some(estimate);
        }
    }

    pub(super) fn remove(&mut self, slot: usize) {
        if self.get(slot).is_some() {
            self.len -= 1;
            if let Some(located) = self.slots.get_mut(slot) {
                *located = None;
            }
        }
    }

    /// Removes empty slots where they are more than half; the landmarks change their slots.
    pub(super) fn compact(&mut self) {
        if self.slots.len() > 2 * self.len + 16 {
            let mut tight = ParticleMap::default();
            self.visit(&mut |_, estimate| tight.push(*estimate));
            *self = tight;
        }
    }

    /// Calls `visitor` for all landmarks with their slots.
    pub(super) fn visit(&self, visitor: &mut impl FnMut(usize, &LandmarkEstimate)) {
        self.slots.visit(&mut |slot, estimate| {
            if let Some(estimate) = estimate {
                visitor(slot, estimate);
            }
        });
    }
}

/// Branches of a node.
const WIDTH: usize = 8;

/// A list whose copies share equal parts.
///
/// A particle that is drawn several times copies its whole map, and the next observation changes a
/// landmark or two. So the list is a tree with [`WIDTH`] branches at each node, and copies share
/// nodes: a copy costs one reference, a change the nodes on the path to it.
#[derive(Debug, Clone)]
pub(super) struct SharedList<T> {
    root: Arc<Node<T>>,
    /// Levels of branches above the leaves.
    depth: u32,
    len: usize,
}

#[derive(Debug, Clone)]
enum Node<T> {
    Leaf(Vec<T>),
    Branch(Vec<Arc<Node<T>>>),
}

impl<T> Default for SharedList<T> {
    fn default() -> Self {
        SharedList { root: Arc::new(Node::Leaf(Vec::new())), depth: 0, len: 0 }
    }
}

/// Capacity of a node whose leaves are `depth` levels below.
fn room(depth: u32) -> usize {
    WIDTH.saturating_pow(depth + 1)
}

impl<T: Clone> SharedList<T> {
    pub(super) fn len(&self) -> usize {
        self.len
    }

    pub(super) fn get(&self, index: usize) -> Option<&T> {
        let (mut node, mut depth, mut index) = (&self.root, self.depth, index);
        loop {
            match node.as_ref() {
                Node::Leaf(elements) => return elements.get(index),
                Node::Branch(branches) => {
                    depth -= 1;
                    node = branches.get(index / room(depth))?;
                    index %= room(depth);
                }
            }
        }
    }

    /// An element to change; where it was shared, it is copied first.
    pub(super) fn get_mut(&mut self, index: usize) -> Option<&mut T> {
        let (mut node, mut depth, mut index) = (&mut self.root, self.depth, index);
        loop {
            match Arc::make_mut(node) {
                Node::Leaf(elements) => return elements.get_mut(index),
                Node::Branch(branches) => {
                    depth -= 1;
                    node = branches.get_mut(index / room(depth))?;
                    index %= room(depth);
                }
            }
        }
    }

    pub(super) fn push(&mut self, element: T) {
        if self.len == room(self.depth) {
            let below = std::mem::replace(&mut self.root, Arc::new(Node::Leaf(Vec::new())));
            self.root = Arc::new(Node::Branch(vec![below]));
            self.depth += 1;
        }
        push_below(&mut self.root, self.depth, self.len, element);
        self.len += 1;
    }

    /// Calls `visitor` for all elements in order.
    pub(super) fn visit(&self, visitor: &mut impl FnMut(usize, &T)) {
        visit_below(&self.root, &mut 0, visitor);
    }
}

fn push_below<T: Clone>(node: &mut Arc<Node<T>>, depth: u32, index: usize, element: T) {
    match Arc::make_mut(node) {
        Node::Leaf(elements) => elements.push(element),
        Node::Branch(branches) => {
            let below = room(depth - 1);
            if index / below == branches.len() {
                let empty =
                    if depth == 1 { Node::Leaf(Vec::new()) } else { Node::Branch(Vec::new()) };
                branches.push(Arc::new(empty));
            }
            if let Some(branch) = branches.last_mut() {
                push_below(branch, depth - 1, index % below, element);
            }
        }
    }
}

fn visit_below<T>(node: &Node<T>, next: &mut usize, visitor: &mut impl FnMut(usize, &T)) {
    match node {
        Node::Leaf(elements) => {
            for element in elements {
                visitor(*next, element);
                *next += 1;
            }
        }
        Node::Branch(branches) => {
            branches.iter().for_each(|branch| visit_below(branch, next, visitor));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_a_list() {
        let mut list = SharedList::default();
        for k in 0..700 {
            assert_eq!((list.len(), list.get(k)), (k, None));
            list.push(k);
        }
        assert!((0..700).all(|k| list.get(k) == Some(&k)) && list.get_mut(700).is_none());
        let mut seen = Vec::new();
        list.visit(&mut |index, &element| seen.push((index, element)));
        assert_eq!(seen, (0..700).map(|k| (k, k)).collect::<Vec<_>>());
    }

    #[test]
    fn copies_share_all_but_what_they_change() {
        let mut list = SharedList::default();
        (0..512).for_each(|k| list.push(k));
        let mut copy = list.clone();
        assert!(Arc::ptr_eq(&list.root, &copy.root));
        *copy.get_mut(300).unwrap() = -1;
        assert_eq!((list.get(300), copy.get(300)), (Some(&300), Some(&-1)));
        let leaf = |list: &SharedList<i32>, index| std::ptr::from_ref(list.get(index).unwrap());
        let shared = (0..512).filter(|&k| leaf(&list, k) == leaf(&copy, k)).count();
        assert_eq!(shared, 512 - WIDTH);
    }
}
