//! Boxes under a tree of boxes: finds those that overlap another box.

use crate::geometry::bounds::Aabb;

/// Most boxes of a leaf.
const LEAF: usize = 8;

/// Some boxes, by their places.
#[derive(Debug)]
pub struct Boxes {
    bounds: Vec<Aabb>,
    order: Vec<u32>,
    nodes: Vec<Node>,
}

#[derive(Debug)]
struct Node {
    bounds: Aabb,
    /// Its places in the order.
    from: usize,
    to: usize,
    /// Its second child; the first one follows it. None: a leaf.
    second: Option<usize>,
}

impl Boxes {
    /// Of boxes that are not empty.
    pub fn new(bounds: Vec<Aabb>) -> Boxes {
        let mut boxes = Boxes { order: (0..bounds.len() as u32).collect(), bounds, nodes: Vec::new() };
        if !boxes.bounds.is_empty() {
            boxes.build(0, boxes.bounds.len());
        }
        boxes
    }

    fn build(&mut self, from: usize, to: usize) {
        let own = &self.order[from..to];
        let bounds = own.iter().fold(Aabb::EMPTY, |around, i| around.union(&self.bounds[*i as usize]));
        let at = self.nodes.len();
        self.nodes.push(Node { bounds, from, to, second: None });
        if to - from <= LEAF {
            return;
        }
        let middle = |bounds: &Aabb, axis: usize| bounds.lower[axis] + bounds.upper[axis];
        let spread = |axis: usize| {
            let all = own.iter().map(|i| middle(&self.bounds[*i as usize], axis));
            let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            high - low
        };
        let axis = (0..3).max_by(|a, b| spread(*a).total_cmp(&spread(*b))).unwrap_or(0);
        let (half, all) = ((to - from) / 2, &self.bounds);
        self.order[from..to].select_nth_unstable_by(half, |p, q| {
            middle(&all[*p as usize], axis).total_cmp(&middle(&all[*q as usize], axis)).then(p.cmp(q))
        });
        self.build(from, from + half);
        self.nodes[at].second = Some(self.nodes.len());
        self.build(from + half, to);
    }

    /// The places of those that a box overlaps, ascending.
    pub fn around(&self, b: &Aabb) -> Vec<u32> {
        let mut found = Vec::new();
        let mut stack = Vec::from_iter((!self.nodes.is_empty()).then_some(0));
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at];
            if !node.bounds.is_overlapping(b) {
                continue;
            }
            match node.second {
                Some(second) => stack.extend([second, at + 1]),
                None => {
                    let own = self.order[node.from..node.to].iter();
                    found.extend(own.filter(|i| self.bounds[**i as usize].is_overlapping(b)));
                }
            }
        }
        found.sort_unstable();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_around_one_are_those_that_it_overlaps() {
        let corner = |i: usize| [(i * 7 % 23) as f64, (i * 5 % 11) as f64, (i % 3) as f64];
        let boxes: Vec<Aabb> =
            (0..200).map(|i| Aabb { lower: corner(i), upper: corner(i).map(|x| x + (i % 4) as f64) }).collect();
        let tree = Boxes::new(boxes.clone());
        for b in &boxes {
            let expected: Vec<u32> = (0..200).filter(|i| boxes[*i as usize].is_overlapping(b)).collect();
            assert_eq!(tree.around(b), expected);
        }
        assert!(Boxes::new(Vec::new()).around(&boxes[0]).is_empty());
    }
}
