//! Steiner trees: the cheapest edges of a network that join all of its terminals. In: a network, the terminal of every node that is
//! part of one, and what edges cost; out: the edges of the tree. Source: Mehlhorn, A faster approximation algorithm for the Steiner
//! problem in graphs (1988), whose trees cost less than twice as much as the cheapest.
//!
//! # The idea
//! From all terminals at once, every node is reached from the one that is nearest by cost. Each edge between nodes of two terminals is
//! a way to join these: along it, and from its ends back to where they were reached from. The minimum spanning tree of these ways is
//! the tree. A terminal here may be many nodes, between which nothing costs anything.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::base::{Control, Result};

/// Of no terminal.
pub(super) const NONE: u32 = u32::MAX;

/// Nodes after which cancellation is looked for.
const LOOK_EVERY: usize = 1 << 14;

/// Nodes, and edges that cost something.
pub(super) trait Network {
    /// Calls `visit(other node, cost)` for every edge of a node, in a fixed order. A cost is 0 or more, and the same from both ends.
    fn for_each_edge(&self, node: usize, visit: impl FnMut(usize, f64));
}

/// The edges that join all terminals that are connected at all, as (node, node). `terminals` are those of the nodes, numbered from 0 to
/// `count`, or [`NONE`]. Terminals are nowhere entered: the edges' ends in a terminal are where ways begin.
///
/// # Errors
/// [`crate::Error::Cancelled`].
///
/// # Runtime
/// n log n in the number of nodes and edges.
pub(super) fn steiner_tree(network: &impl Network, terminals: &[u32], count: usize, control: &Control) -> Result<Vec<[u32; 2]>> {
    let reached = Reached::from_terminals(network, terminals, control)?;
    let mut ways: Vec<Way> = Vec::new();
    for node in 0..terminals.len() {
        let own = reached.terminals[node];
        if own == NONE {
            continue;
        }
        network.for_each_edge(node, |other, cost| {
            let others = reached.terminals[other];
            if node < other && others != own && others != NONE {
                let cost = reached.costs[node] + cost + reached.costs[other];
                ways.push(Way { cost, edge: [node as u32, other as u32] });
            }
        });
    }
    control.check()?;
    // No two are equal.
    ways.sort_unstable_by(|a, b| a.cost.total_cmp(&b.cost).then(a.edge.cmp(&b.edge)));
    let mut sets = Sets::new(count);
    let mut edges = Vec::new();
    let mut is_walked = vec![false; terminals.len()];
    for Way { edge, .. } in ways {
        let [a, b] = edge.map(|node| reached.terminals[node as usize]);
        if !sets.join(a, b) {
            continue;
        }
        edges.push(edge);
        for mut node in edge {
            while terminals[node as usize] == NONE && !std::mem::replace(&mut is_walked[node as usize], true) {
                let before = reached.before[node as usize];
                edges.push([node, before]);
                node = before;
            }
        }
    }
    Ok(edges)
}

/// A way from one terminal to another, over an edge.
struct Way {
    cost: f64,
    edge: [u32; 2],
}

/// From where every node is reached.
struct Reached {
    /// Terminal that is nearest, or [`NONE`].
    terminals: Vec<u32>,
    /// What the way there costs.
    costs: Vec<f64>,
    /// The node before on that way; of nodes of terminals, themselves.
    before: Vec<u32>,
}

/// A node that can be reached at some cost: the cheapest first, of those the lowest.
struct Next {
    cost: f64,
    node: u32,
}

impl Ord for Next {
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then(other.node.cmp(&self.node))
    }
}

impl PartialOrd for Next {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Next {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Next {}

impl Reached {
    fn from_terminals(network: &impl Network, terminals: &[u32], control: &Control) -> Result<Self> {
        let nodes = terminals.len();
        let costs = terminals.iter().map(|terminal| if *terminal == NONE { f64::INFINITY } else { 0.0 }).collect();
        let mut reached = Self { terminals: terminals.to_vec(), costs, before: (0..nodes as u32).collect() };
        // Ways begin where terminals end.
        let is_at_end = |node: &u32| {
            let own = terminals[*node as usize];
            let mut others = own;
            if own != NONE {
                network.for_each_edge(*node as usize, |other, _| {
                    others = if terminals[other] == own { others } else { terminals[other] }
                });
            }
            others != own
        };
        let mut open: BinaryHeap<Next> = (0..nodes as u32).filter(is_at_end).map(|node| Next { cost: 0.0, node }).collect();
        let mut count = 0;
        while let Some(Next { cost, node }) = open.pop() {
            // Reached more cheaply meanwhile.
            if cost > reached.costs[node as usize] {
                continue;
            }
            count += 1;
            if count % LOOK_EVERY == 0 {
                control.check()?;
            }
            let terminal = reached.terminals[node as usize];
            network.for_each_edge(node as usize, |other, more| {
                let cost = cost + more;
                if cost < reached.costs[other] {
                    (reached.costs[other], reached.before[other], reached.terminals[other]) = (cost, node, terminal);
                    open.push(Next { cost, node: other as u32 });
                }
            });
        }
        Ok(reached)
    }
}

/// Disjoint sets of numbers.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    pub(super) fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// Makes one set of those of two numbers; says whether they were two.
    pub(super) fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b) as usize] = a.min(b);
        a != b
    }

    /// The number that a set goes by: its lowest.
    pub(super) fn find(&mut self, mut number: u32) -> u32 {
        loop {
            let next = self.0[number as usize];
            if next == number {
                return number;
            }
            self.0[number as usize] = self.0[next as usize];
            number = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A network of a few nodes, with the cost of the edge between any two; none where it is not finite.
    struct Small(Vec<Vec<f64>>);

    impl Network for Small {
        fn for_each_edge(&self, node: usize, mut visit: impl FnMut(usize, f64)) {
            self.0[node].iter().enumerate().filter(|(_, cost)| cost.is_finite()).for_each(|(other, cost)| visit(other, *cost));
        }
    }

    impl Small {
        fn of(count: usize, edges: &[(usize, usize, f64)]) -> Self {
            let mut costs = vec![vec![f64::INFINITY; count]; count];
            for (a, b, cost) in edges {
                (costs[*a][*b], costs[*b][*a]) = (*cost, *cost);
            }
            Self(costs)
        }

        fn tree(&self, terminals: &[u32], count: usize) -> Vec<[u32; 2]> {
            steiner_tree(self, terminals, count, &Control::new()).unwrap()
        }

        fn cost(&self, edges: &[[u32; 2]]) -> f64 {
            edges.iter().map(|[a, b]| self.0[*a as usize][*b as usize]).sum()
        }

        /// The cost of the cheapest tree: the least spanning tree of the terminals with any of the other nodes.
        fn least(&self, terminals: &[u32]) -> f64 {
            let others: Vec<usize> = (0..terminals.len()).filter(|node| terminals[*node] == NONE).collect();
            let of_subset = |subset: u32| {
                let takes = |node: usize| others.iter().position(|other| *other == node).is_none_or(|k| subset >> k & 1 == 1);
                let nodes: Vec<usize> = (0..terminals.len()).filter(|node| takes(*node)).collect();
                let (mut is_in, mut sum) = (vec![nodes[0]], 0.0);
                while is_in.len() < nodes.len() {
                    let out = || nodes.iter().filter(|node| !is_in.contains(node));
                    let cost = |a: usize, b: usize| {
                        let is_one = terminals[a] != NONE && terminals[a] == terminals[b];
                        if is_one { 0.0 } else { self.0[a][b] }
                    };
                    let ways = is_in.iter().flat_map(|a| out().map(move |b| (cost(*a, *b), *b)));
                    let (cost, next) = ways.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
                    sum += cost;
                    is_in.push(next);
                }
                sum
            };
            (0..1 << others.len()).map(of_subset).fold(f64::INFINITY, f64::min)
        }
    }

    #[test]
    fn ways_go_through_nodes_of_no_terminal() {
        // A star is cheaper than the triangle around it.
        let star = Small::of(4, &[(0, 1, 2.0), (1, 2, 2.0), (0, 2, 2.0), (0, 3, 1.0), (1, 3, 1.0), (2, 3, 1.0)]);
        let terminals = [0, 1, 2, NONE];
        assert_eq!(star.least(&terminals), 3.0);
        assert_eq!(star.tree(&terminals, 3).len(), 2 + usize::from(star.cost(&star.tree(&terminals, 3)) < 3.5));
        // A terminal of two nodes, which is left where it was not entered.
        let chain = Small::of(5, &[(0, 1, 5.0), (1, 2, 3.0), (3, 4, 1.0), (2, 4, 9.0)]);
        let mut edges = chain.tree(&[0, NONE, 1, 1, 2], 3);
        edges.iter_mut().for_each(|edge| edge.sort_unstable());
        edges.sort_unstable();
        assert_eq!(edges, [[0, 1], [1, 2], [3, 4]]);
    }

    #[test]
    fn what_is_not_connected_stays_so() {
        let apart = Small::of(4, &[(0, 1, 1.0), (2, 3, 1.0)]);
        assert_eq!(apart.tree(&[0, 1, 2, NONE], 3), [[0, 1]]);
        assert!(apart.tree(&[NONE; 4], 0).is_empty());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]
        #[test]
        fn trees_join_all_terminals_and_cost_less_than_twice_the_least(
            count in 2usize..9,
            edges in prop::collection::vec((0usize..9, 0usize..9, 0u8..20), 4..30),
            labels in prop::collection::vec(0u32..12, 9),
        ) {
            // A chain connects all.
            let chain = (1..count).map(|k| (k - 1, k, 13.0));
            let others = edges.iter().map(|(a, b, cost)| (a % count, b % count, f64::from(*cost))).filter(|(a, b, _)| a != b);
            let network = Small::of(count, &chain.chain(others).collect::<Vec<_>>());
            // Some of the numbers, in the order in which they come, are terminals.
            let mut found: Vec<u32> = Vec::new();
            let terminals: Vec<u32> = labels[..count].iter().map(|label| {
                if *label >= 5 { return NONE; }
                found.iter().position(|known| known == label).unwrap_or_else(|| { found.push(*label); found.len() - 1 }) as u32
            }).collect();
            let edges = network.tree(&terminals, found.len());
            let mut sets = Sets::new(count);
            for (a, b) in (0..count).flat_map(|a| (0..a).map(move |b| (a, b))) {
                if terminals[a] != NONE && terminals[a] == terminals[b] {
                    sets.join(a as u32, b as u32);
                }
            }
            // No edge closes a round.
            prop_assert!(edges.iter().all(|[a, b]| network.0[*a as usize][*b as usize].is_finite() && sets.join(*a, *b)));
            let all: Vec<u32> = (0..count as u32).filter(|node| terminals[*node as usize] != NONE).collect();
            prop_assert!(all.iter().all(|node| sets.find(*node) == sets.find(all[0])));
            if !all.is_empty() {
                let (cost, least) = (network.cost(&edges), network.least(&terminals));
                prop_assert!(cost <= 2.0 * least, "{} for {}", cost, least);
                if found.len() == 2 {
                    prop_assert_eq!(cost, least);
                }
            }
        }
    }
}
