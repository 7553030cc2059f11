//! Maximum flow and minimum cut between a source and a sink.
//!
//! In: a [`Network`] of nodes and edges with a capacity in each direction; each node is also connected to the source
//! or to the sink. Out: the value of the flow, and each node's side of a minimum cut.
//!
//! The method is by Boykov and Kolmogorov ("An experimental comparison of min-cut/max-flow algorithms for energy
//! minimization in vision", PAMI 2004): two trees of unsaturated arcs grow from the source and from the sink; where
//! they meet, flow is pushed; arcs that it saturates leave orphans, which find another parent in their tree or become
//! free. A time stamp and a distance mark the nodes that are known to be connected to their terminal (section 3.2.3
//! there).
//!
//! The edges of a network are fixed, while capacities can be set again: nothing is allocated between solutions once the
//! queues have grown. Capacities are integers, so that the result is exact and the same everywhere. Cost: near linear in
//! practice; 12 bytes of memory an arc (two arcs an edge) and 32 a node.

use std::collections::VecDeque;

/// Parent of a free node.
const NONE: u32 = u32::MAX;
/// Parent of a root: the source or the sink.
const TERMINAL: u32 = u32::MAX - 1;
/// Parent of a node whose arc to its parent was saturated.
const ORPHAN: u32 = u32::MAX - 2;

/// Tree that a node belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Tree {
    Free,
    Source,
    Sink,
}

/// One direction of an edge.
#[derive(Debug, Clone, Copy)]
struct Arc {
    head: u32,
    /// The arc back.
    sister: u32,
    /// Remaining capacity.
    residual: i32,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    /// Remaining capacity from the source (positive) or to the sink (negative).
    excess: i64,
    /// The arc towards the root of the tree, or one of the three constants above.
    parent: u32,
    /// Time at which `distance` was last correct.
    stamp: u32,
    /// Number of arcs to the terminal.
    distance: u32,
    tree: Tree,
    active: bool,
}

const FREE_NODE: Node = Node { excess: 0, parent: NONE, stamp: 0, distance: 0, tree: Tree::Free, active: false };

/// A directed graph with a source, a sink and capacities.
///
/// Law: the arcs that leave node `i` are `first[i]..first[i + 1]`; `arcs[arcs[a].sister].sister == a`.
#[derive(Debug, Clone, Default)]
pub(crate) struct Network {
    first: Vec<u32>,
    arcs: Vec<Arc>,
    /// The forward arc of each edge.
    forward_arc: Vec<u32>,
    nodes: Vec<Node>,
    active: VecDeque<u32>,
    orphans: VecDeque<u32>,
    time: u32,
}

impl Network {
    /// Builds a network of `num_nodes` nodes and `edges`, with zero capacities. Ends must be below `num_nodes`; an edge may
    /// occur twice.
    pub(crate) fn new(num_nodes: usize, edges: &[(u32, u32)]) -> Self {
        let mut first = vec![0_u32; num_nodes + 1];
        for &(a, b) in edges {
            first[a as usize] += 1;
            first[b as usize] += 1;
        }
        let mut end = 0;
        for f in &mut first {
            end += *f;
            *f = end;
        }
        // Filled from the back, so that the ends become the starts.
        let mut arcs = vec![Arc { head: 0, sister: 0, residual: 0 }; 2 * edges.len()];
        let mut forward_arc = vec![0; edges.len()];
        for (e, &(a, b)) in edges.iter().enumerate().rev() {
            first[a as usize] -= 1;
            let forward = first[a as usize];
            first[b as usize] -= 1;
            let backward = first[b as usize];
            arcs[forward as usize] = Arc { head: b, sister: backward, residual: 0 };
            arcs[backward as usize] = Arc { head: a, sister: forward, residual: 0 };
            forward_arc[e] = forward;
        }
        Self { first, arcs, forward_arc, nodes: vec![FREE_NODE; num_nodes], ..Self::default() }
    }

    /// Sets the capacity from the source to `node` (positive) or from it to the sink (negative). Of both only their
    /// difference matters.
    pub(crate) fn set_terminal(&mut self, node: usize, excess: i64) {
        self.nodes[node].excess = excess;
    }

    /// Sets the capacities of an edge of [`Network::new`], by its index, in both directions; each in `0..=i32::MAX / 2`.
    pub(super) fn set_edge(&mut self, edge: usize, forward: i32, backward: i32) {
        debug_assert!(forward >= 0 && backward >= 0 && forward <= i32::MAX / 2 && backward <= i32::MAX / 2);
        let arc = self.forward_arc[edge] as usize;
        self.arcs[arc].residual = forward;
        let sister = self.arcs[arc].sister as usize;
        self.arcs[sister].residual = backward;
    }

    /// Pushes the maximum flow and returns its value. It uses up all capacities, which must be set again for the next
    /// solution.
    pub(super) fn solve(&mut self) -> i64 {
        self.plant_roots();
        let mut flow = 0;
        while let Some(i) = self.next_active() {
            let mut a = self.first[i as usize];
            while let Some((bridge, next)) = self.grow(i, a) {
                self.time += 1;
                flow += self.augment(bridge);
                while let Some(orphan) = self.orphans.pop_front() {
                    self.adopt(orphan);
                }
                if self.nodes[i as usize].tree == Tree::Free {
                    break;
                }
                // Earlier arcs are done: a node that became free has activated its neighbours.
                a = next;
            }
        }
        flow
    }

    /// Returns `true` for nodes on the sink's side of the minimum cut, the smallest such side.
    pub(super) fn is_on_sink_side(&self, node: usize) -> bool {
        self.nodes[node].tree == Tree::Sink
    }

    /// Makes a root of every node with excess.
    fn plant_roots(&mut self) {
        self.time = 1;
        self.active.clear();
        self.orphans.clear();
        for (i, node) in self.nodes.iter_mut().enumerate() {
            *node = Node { excess: node.excess, ..FREE_NODE };
            if node.excess != 0 {
                node.tree = if node.excess > 0 { Tree::Source } else { Tree::Sink };
                (node.parent, node.stamp, node.distance, node.active) = (TERMINAL, 1, 1, true);
                self.active.push_back(i as u32);
            }
        }
    }

    fn next_active(&mut self) -> Option<u32> {
        while let Some(i) = self.active.pop_front() {
            let node = &mut self.nodes[i as usize];
            node.active = false;
            if node.tree != Tree::Free {
                return Some(i);
            }
        }
        None
    }

    fn activate(&mut self, i: u32) {
        let node = &mut self.nodes[i as usize];
        if !node.active {
            node.active = true;
            self.active.push_back(i);
        }
    }

    /// Adds free neighbours of `i` to its tree, from arc `start` on. Where it meets the other tree, returns the arc from the
    /// source's tree to the sink's, and the arc of `i`.
    fn grow(&mut self, i: u32, start: u32) -> Option<(u32, u32)> {
        let from = self.nodes[i as usize];
        for a in start..self.first[i as usize + 1] {
            let Arc { head, sister, residual } = self.arcs[a as usize];
            let open = match from.tree {
                Tree::Source => residual,
                _ => self.arcs[sister as usize].residual,
            };
            if open == 0 {
                continue;
            }
            let node = &mut self.nodes[head as usize];
            if node.tree == Tree::Free {
                node.tree = from.tree;
                (node.parent, node.stamp, node.distance) = (sister, from.stamp, from.distance + 1);
                self.activate(head);
            } else if node.tree != from.tree {
                return Some((if from.tree == Tree::Source { a } else { sister }, a));
            } else if node.stamp <= from.stamp && node.distance > from.distance {
                // A shorter path to the terminal.
                (node.parent, node.stamp, node.distance) = (sister, from.stamp, from.distance + 1);
            }
        }
        None
    }

    /// Pushes the bottleneck of the path through `bridge`, and returns it.
    fn augment(&mut self, bridge: u32) -> i64 {
        let Arc { head, sister, residual } = self.arcs[bridge as usize];
        let tail = self.arcs[sister as usize].head;
        let amount = self.bottleneck(tail, true).min(self.bottleneck(head, false)).min(i64::from(residual));
        self.arcs[bridge as usize].residual -= amount as i32;
        self.arcs[sister as usize].residual += amount as i32;
        self.push(tail, amount, true);
        self.push(head, amount, false);
        amount
    }

    /// Least residual between `i` and its terminal.
    fn bottleneck(&self, mut i: u32, from_source: bool) -> i64 {
        let mut least = i64::MAX;
        loop {
            let parent = self.nodes[i as usize].parent;
            if parent == TERMINAL {
                return least.min(self.nodes[i as usize].excess.abs());
            }
            let arc = self.arcs[parent as usize];
            let residual = if from_source { self.arcs[arc.sister as usize].residual } else { arc.residual };
            least = least.min(i64::from(residual));
            i = arc.head;
        }
    }

    /// Pushes `amount` between `i` and its terminal; nodes that lose their parent become orphans.
    fn push(&mut self, mut i: u32, amount: i64, from_source: bool) {
        loop {
            let parent = self.nodes[i as usize].parent;
            if parent == TERMINAL {
                let node = &mut self.nodes[i as usize];
                node.excess += if from_source { -amount } else { amount };
                if node.excess == 0 {
                    node.parent = ORPHAN;
                    self.orphans.push_front(i);
                }
                return;
            }
            let Arc { head, sister, .. } = self.arcs[parent as usize];
            let (filled, emptied) = if from_source { (sister, parent) } else { (parent, sister) };
            self.arcs[emptied as usize].residual += amount as i32;
            let full = &mut self.arcs[filled as usize].residual;
            *full -= amount as i32;
            if *full == 0 {
                self.nodes[i as usize].parent = ORPHAN;
                self.orphans.push_front(i);
            }
            i = head;
        }
    }

    /// Returns `true` if flow can come to `a`'s tail from its head (in the source's tree) or go there (in the sink's).
    fn is_open(&self, a: u32, tree: Tree) -> bool {
        let arc = self.arcs[a as usize];
        let residual = if tree == Tree::Source { self.arcs[arc.sister as usize].residual } else { arc.residual };
        residual > 0
    }

    /// Finds another parent for the orphan `i`, nearest to the terminal, or makes `i` free.
    fn adopt(&mut self, i: u32) {
        let tree = self.nodes[i as usize].tree;
        let arcs = self.first[i as usize]..self.first[i as usize + 1];
        let (mut best, mut least) = (NONE, u32::MAX);
        for a in arcs.clone() {
            let j = self.arcs[a as usize].head;
            if self.nodes[j as usize].tree == tree && self.is_open(a, tree) {
                let distance = self.distance_to_terminal(j);
                if distance < least {
                    (best, least) = (a, distance);
                }
            }
        }
        if best != NONE {
            let node = &mut self.nodes[i as usize];
            (node.parent, node.stamp, node.distance) = (best, self.time, least + 1);
            return;
        }
        self.nodes[i as usize].tree = Tree::Free;
        self.nodes[i as usize].parent = NONE;
        for a in arcs {
            let j = self.arcs[a as usize].head;
            let node = self.nodes[j as usize];
            if node.tree != tree {
                continue;
            }
            if self.is_open(a, tree) {
                self.activate(j);
            }
            if node.parent < ORPHAN && self.arcs[node.parent as usize].head == i {
                self.nodes[j as usize].parent = ORPHAN;
                self.orphans.push_back(j);
            }
        }
    }

    /// Number of arcs between `j` and its terminal, `u32::MAX` if an orphan is between. Stamps the nodes on the path.
    fn distance_to_terminal(&mut self, j: u32) -> u32 {
        let (mut k, mut distance) = (j, 0);
        loop {
            let node = &mut self.nodes[k as usize];
            if node.stamp == self.time {
                distance += node.distance;
                break;
            }
            distance += 1;
            match node.parent {
                TERMINAL => {
                    (node.stamp, node.distance) = (self.time, 1);
                    break;
                }
                ORPHAN | NONE => return u32::MAX,
                parent => k = self.arcs[parent as usize].head,
            }
        }
        let (mut k, mut mark) = (j, distance);
        while self.nodes[k as usize].stamp != self.time {
            let node = &mut self.nodes[k as usize];
            (node.stamp, node.distance) = (self.time, mark);
            mark -= 1;
            k = self.arcs[node.parent as usize].head;
        }
        distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    /// A random network with its capacities, to solve and to check.
    struct Instance {
        terminals: Vec<i64>,
        edges: Vec<(u32, u32)>,
        capacities: Vec<(i32, i32)>,
    }

    impl Instance {
        /// Capacities are zero often enough to saturate much and to leave parts unconnected; loops and parallel edges
        /// occur.
        fn random(rng: &mut Rng, num_nodes: usize, num_edges: usize) -> Self {
            let mut few = |n: usize| rng.below(3 * n).saturating_sub(2 * n) as i32;
            let terminals = (0..num_nodes).map(|_| i64::from(few(40) - few(40))).collect();
            let capacities = (0..num_edges).map(|_| (few(60), few(60))).collect();
            let edges = (0..num_edges).map(|_| (rng.below(num_nodes) as u32, rng.below(num_nodes) as u32)).collect();
            Self { terminals, edges, capacities }
        }

        fn load(&self, network: &mut Network) {
            for (i, &excess) in self.terminals.iter().enumerate() {
                network.set_terminal(i, excess);
            }
            for (e, &(along, back)) in self.capacities.iter().enumerate() {
                network.set_edge(e, along, back);
            }
        }

        /// Cost of the cut with exactly the nodes of `sink_side` on the sink's side.
        fn cut(&self, sink_side: impl Fn(usize) -> bool) -> i64 {
            let terminal = |(i, &excess): (usize, &i64)| if sink_side(i) { excess.max(0) } else { (-excess).max(0) };
            let ends = |e: usize| (sink_side(self.edges[e].0 as usize), sink_side(self.edges[e].1 as usize));
            let edge = |(e, &(along, back)): (usize, &(i32, i32))| match ends(e) {
                (false, true) => i64::from(along),
                (true, false) => i64::from(back),
                _ => 0,
            };
            self.terminals.iter().enumerate().map(terminal).sum::<i64>()
                + self.capacities.iter().enumerate().map(edge).sum::<i64>()
        }

        /// The maximum flow by shortest augmenting paths on a matrix (Edmonds and Karp 1972).
        fn naive_flow(&self) -> i64 {
            let n = self.terminals.len();
            let (source, sink) = (n, n + 1);
            let mut residual = vec![vec![0_i64; n + 2]; n + 2];
            for (i, &excess) in self.terminals.iter().enumerate() {
                residual[source][i] = excess.max(0);
                residual[i][sink] = (-excess).max(0);
            }
            for (&(a, b), &(along, back)) in self.edges.iter().zip(&self.capacities) {
                residual[a as usize][b as usize] += i64::from(along);
                residual[b as usize][a as usize] += i64::from(back);
            }
            let mut flow = 0;
            loop {
                let mut parent = vec![usize::MAX; n + 2];
                let mut queue = VecDeque::from([source]);
                while let Some(i) = queue.pop_front() {
                    for j in 0..n + 2 {
                        if residual[i][j] > 0 && parent[j] == usize::MAX && j != source {
                            parent[j] = i;
                            queue.push_back(j);
                        }
                    }
                }
                if parent[sink] == usize::MAX {
                    return flow;
                }
                let way = || std::iter::successors(Some(sink), |&j| (parent[j] != source).then(|| parent[j]));
                let amount = way().map(|j| residual[parent[j]][j]).min().unwrap();
                for j in way() {
                    residual[parent[j]][j] -= amount;
                    residual[j][parent[j]] += amount;
                }
                flow += amount;
            }
        }

        /// Checks conservation, capacities, and that the cut costs as much as the flow.
        fn check(&self, network: &Network, flow: i64) {
            let mut outgoing = vec![0_i64; self.terminals.len()];
            for (e, (&(a, b), &(along, back))) in self.edges.iter().zip(&self.capacities).enumerate() {
                let forward = network.arcs[network.forward_arc[e] as usize];
                let backward = network.arcs[forward.sister as usize];
                assert!(forward.residual >= 0 && backward.residual >= 0);
                assert_eq!(forward.residual + backward.residual, along + back);
                outgoing[a as usize] += i64::from(along - forward.residual);
                outgoing[b as usize] -= i64::from(along - forward.residual);
            }
            let mut from_source = 0;
            for (i, (&excess, node)) in self.terminals.iter().zip(&network.nodes).enumerate() {
                assert!(node.excess.signum() * excess.signum() >= 0 && node.excess.abs() <= excess.abs());
                assert_eq!(outgoing[i], excess - node.excess, "node {i}");
                from_source += (excess - node.excess).max(0);
            }
            assert_eq!(from_source, flow);
            assert_eq!(self.cut(|i| network.is_on_sink_side(i)), flow);
        }
    }

    #[test]
    fn flow_equals_the_least_of_all_cuts_on_small_networks() {
        let mut rng = Rng::for_stage(1, "maxflow");
        for _ in 0..400 {
            let n = 1 + rng.below(10);
            let num_edges = rng.below(4 * n);
            let instance = Instance::random(&mut rng, n, num_edges);
            let mut network = Network::new(n, &instance.edges);
            instance.load(&mut network);
            let flow = network.solve();
            instance.check(&network, flow);
            let cuts = (0..1_u32 << n).map(|set| instance.cut(|i| set >> i & 1 == 1));
            assert_eq!(Some(flow), cuts.min());
        }
    }

    #[test]
    fn flow_equals_that_of_shortest_augmenting_paths_and_a_network_can_be_used_again() {
        let mut rng = Rng::for_stage(2, "maxflow");
        for n in [12, 40, 90] {
            let shape = Instance::random(&mut rng, n, 4 * n);
            let mut network = Network::new(n, &shape.edges);
            for _ in 0..12 {
                let instance = Instance { edges: shape.edges.clone(), ..Instance::random(&mut rng, n, 4 * n) };
                instance.load(&mut network);
                let flow = network.solve();
                instance.check(&network, flow);
                assert!(flow > 0);
                assert_eq!(flow, instance.naive_flow());
            }
        }
    }

    #[test]
    fn the_sink_side_is_the_smallest_there_is() {
        // 0 gives 5 to 1 through a free arc, 1 takes 5: every cut of the chain costs 5.
        let mut network = Network::new(2, &[(0, 1)]);
        network.set_terminal(0, 5);
        network.set_terminal(1, -5);
        network.set_edge(0, 5, 0);
        assert_eq!(network.solve(), 5);
        assert!(!network.is_on_sink_side(0) && !network.is_on_sink_side(1));
    }

    #[test]
    fn large_capacities_do_not_overflow() {
        let mut network = Network::new(3, &[(0, 1), (1, 2), (0, 2)]);
        for e in 0..3 {
            network.set_edge(e, i32::MAX / 2, i32::MAX / 2);
        }
        network.set_terminal(0, 1 << 40);
        network.set_terminal(2, -(1 << 40));
        assert_eq!(network.solve(), 2 * i64::from(i32::MAX / 2));
    }

    #[test]
    fn an_empty_network_has_no_flow() {
        assert_eq!(Network::new(0, &[]).solve(), 0);
        assert_eq!(Network::new(3, &[]).solve(), 0);
    }
}
