//! A list whose copies share what they have in common.
//!
//! A particle that is drawn several times hands its whole map to each copy, and the next observation
//! changes a landmark or two. So the list is a tree with [`WIDTH`] branches at each node, and
//! copies share nodes: a copy costs one reference, a change the nodes on the way to it.

use std::sync::Arc;

/// Branches of a node.
const WIDTH: usize = 8;

/// A list of things with a number each, counted from 0.
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

/// How many things a node has room for whose leaves are `depth` levels below.
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
                Node::Leaf(things) => return things.get(index),
                Node::Branch(branches) => {
                    depth -= 1;
                    node = branches.get(index / room(depth))?;
                    index %= room(depth);
                }
            }
        }
    }

    /// The thing to change: its own from now on, where it was shared.
    pub(super) fn get_mut(&mut self, index: usize) -> Option<&mut T> {
        let (mut node, mut depth, mut index) = (&mut self.root, self.depth, index);
        loop {
            match Arc::make_mut(node) {
                Node::Leaf(things) => return things.get_mut(index),
                Node::Branch(branches) => {
                    depth -= 1;
                    node = branches.get_mut(index / room(depth))?;
                    index %= room(depth);
                }
            }
        }
    }

    pub(super) fn push(&mut self, thing: T) {
        if self.len == room(self.depth) {
            let below = std::mem::replace(&mut self.root, Arc::new(Node::Leaf(Vec::new())));
            self.root = Arc::new(Node::Branch(vec![below]));
            self.depth += 1;
        }
        push_below(&mut self.root, self.depth, self.len, thing);
        self.len += 1;
    }

    /// Shows all things in their order.
    pub(super) fn visit(&self, visitor: &mut impl FnMut(usize, &T)) {
        visit_below(&self.root, &mut 0, visitor);
    }
}

fn push_below<T: Clone>(node: &mut Arc<Node<T>>, depth: u32, index: usize, thing: T) {
    match Arc::make_mut(node) {
        Node::Leaf(things) => things.push(thing),
        Node::Branch(branches) => {
            let below = room(depth - 1);
            if index / below == branches.len() {
                let empty =
                    if depth == 1 { Node::Leaf(Vec::new()) } else { Node::Branch(Vec::new()) };
                branches.push(Arc::new(empty));
            }
            if let Some(branch) = branches.last_mut() {
                push_below(branch, depth - 1, index % below, thing);
            }
        }
    }
}

fn visit_below<T>(node: &Node<T>, next: &mut usize, visitor: &mut impl FnMut(usize, &T)) {
    match node {
        Node::Leaf(things) => {
            for thing in things {
                visitor(*next, thing);
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
        list.visit(&mut |index, &thing| seen.push((index, thing)));
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
