//! Maximum flow and minimum cut between a source and a sink.
//!
//! In: a [`Network`] of nodes joined by edges with a capacity in each direction; each node is also joined to the source
//! or to the sink. Out: the value of the flow, and on which side of a minimum cut each node lies.
//!
//! The method is by Boykov and Kolmogorov ("An experimental comparison of min-cut/max-flow algorithms for energy
//! minimization in vision", PAMI 2004): two trees of unsaturated arcs grow from the source and from the sink; where
//! they meet, flow is pushed; arcs that it saturates leave orphans, which look for another parent in their tree or
//! become free again. Two marks, a stamp and a distance, tell which nodes were already seen to hang on their terminal
//! (section 3.2.3 of that paper).
//!
//! The shape of a network is fixed at its making, capacities can be set again and again: nothing is allocated between
//! solutions once the queues have grown. Capacities are integers, so that the result is exact and the same everywhere.
//! Memory: 12 bytes an arc (two arcs an edge) and 32 a node.

use std::collections::VecDeque;

/// Neither in a tree nor waiting for a parent.
const NONE: u32 = u32::MAX;
/// The parent is the source or the sink itself.
const TERMINAL: u32 = u32::MAX - 1;
/// The arc to the parent was saturated.
const ORPHAN: u32 = u32::MAX - 2;

/// Which tree a node hangs in.
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
    /// What more can flow.
    residual: i32,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    /// What can still come from the source (positive) or go to the sink (negative).
    excess: i64,
    /// The arc towards the root of the tree, or one of the three names above.
    parent: u32,
    /// When `distance` was last known to be true.
    stamp: u32,
    /// Arcs to the terminal.
    distance: u32,
    tree: Tree,
    active: bool,
}

const FRESH: Node = Node { excess: 0, parent: NONE, stamp: 0, distance: 0, tree: Tree::Free, active: false };

/// A directed graph with a source, a sink and capacities.
///
/// Law: the arcs that leave node `i` are `first[i]..first[i + 1]`; `arcs[arcs[a].sister].sister == a`.
#[derive(Debug, Clone, Default)]
pub(crate) struct Network {
    first: Vec<u32>,
    arcs: Vec<Arc>,
    /// The forward arc of each edge.
    place: Vec<u32>,
    nodes: Vec<Node>,
    active: VecDeque<u32>,
    orphans: VecDeque<u32>,
    time: u32,
}

impl Network {
    /// `num_nodes` nodes joined by `edges`, all capacities zero. Ends must be below `num_nodes`; an edge may occur
    /// twice.
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
        // Filled from the back, the counts end up as the beginnings.
        let mut arcs = vec![Arc { head: 0, sister: 0, residual: 0 }; 2 * edges.len()];
        let mut place = vec![0; edges.len()];
        for (e, &(a, b)) in edges.iter().enumerate().rev() {
            first[a as usize] -= 1;
            let forward = first[a as usize];
            first[b as usize] -= 1;
            let backward = first[b as usize];
            arcs[forward as usize] = Arc { head: b, sister: backward, residual: 0 };
            arcs[backward as usize] = Arc { head: a, sister: forward, residual: 0 };
            place[e] = forward;
        }
        Self { first, arcs, place, nodes: vec![FRESH; num_nodes], ..Self::default() }
    }

    /// Sets how much can come from the source to `node` (positive) or go from it to the sink (negative).
    ///
    /// A node with both needs only their difference: the smaller of the two flows straight through.
    pub(crate) fn set_terminal(&mut self, node: usize, excess: i64) {
        self.nodes[node].excess = excess;
    }

    /// Sets the capacities of `edge`, an index into the edges given to [`Network::new`]: along it, and back. At most
    /// `i32::MAX / 2` each; not negative.
    pub(crate) fn set_edge(&mut self, edge: usize, along: i32, back: i32) {
        debug_assert!(along >= 0 && back >= 0 && along <= i32::MAX / 2 && back <= i32::MAX / 2);
        let forward = self.place[edge] as usize;
        self.arcs[forward].residual = along;
        let backward = self.arcs[forward].sister as usize;
        self.arcs[backward].residual = back;
    }

    /// Pushes the maximum flow and returns its value. Both capacities of every edge and all terminals are used up by
    /// it: set them before the next solution.
    pub(crate) fn solve(&mut self) -> i64 {
        self.plant();
        let mut flow = 0;
        while let Some(i) = self.next_active() {
            let mut a = self.first[i as usize];
            while let Some((bridge, at)) = self.grow(i, a) {
                self.time += 1;
                flow += self.augment(bridge);
                while let Some(orphan) = self.orphans.pop_front() {
                    self.adopt(orphan);
                }
                if self.nodes[i as usize].tree == Tree::Free {
                    break;
                }
                // Arcs before this one need no second look: a node that became free has woken its neighbours.
                a = at;
            }
        }
        flow
    }

    /// Whether `node` lies on the sink's side of the minimum cut just found: the smallest such side there is.
    pub(crate) fn on_sink_side(&self, node: usize) -> bool {
        self.nodes[node].tree == Tree::Sink
    }

    /// Every node with something to give or to take is a root.
    fn plant(&mut self) {
        self.time = 1;
        self.active.clear();
        self.orphans.clear();
        for (i, node) in self.nodes.iter_mut().enumerate() {
            *node = Node { excess: node.excess, ..FRESH };
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

    fn wake(&mut self, i: u32) {
        let node = &mut self.nodes[i as usize];
        if !node.active {
            node.active = true;
            self.active.push_back(i);
        }
    }

    /// Takes free neighbours of `i` into its tree, from arc `begin` on. Where the other tree is met: the arc from the
    /// source's tree to the sink's, and which arc of `i` it belongs to.
    fn grow(&mut self, i: u32, begin: u32) -> Option<(u32, u32)> {
        let from = self.nodes[i as usize];
        for a in begin..self.first[i as usize + 1] {
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
                self.wake(head);
            } else if node.tree != from.tree {
                return Some((if from.tree == Tree::Source { a } else { sister }, a));
            } else if node.stamp <= from.stamp && node.distance > from.distance {
                // A shorter way to the terminal.
                (node.parent, node.stamp, node.distance) = (sister, from.stamp, from.distance + 1);
            }
        }
        None
    }

    /// Pushes what the path through `bridge` can take; returns how much.
    fn augment(&mut self, bridge: u32) -> i64 {
        let Arc { head, sister, residual } = self.arcs[bridge as usize];
        let tail = self.arcs[sister as usize].head;
        let amount = self.narrowest(tail, true).min(self.narrowest(head, false)).min(i64::from(residual));
        self.arcs[bridge as usize].residual -= amount as i32;
        self.arcs[sister as usize].residual += amount as i32;
        self.push(tail, amount, true);
        self.push(head, amount, false);
        amount
    }

    /// The least residual on the way between `i` and its terminal.
    fn narrowest(&self, mut i: u32, from_source: bool) -> i64 {
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

    /// Pushes `amount` along the way between `i` and its terminal; whoever loses its parent becomes an orphan.
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

    /// Whether flow could come to `a`'s tail from its head (in the source's tree) or go there (in the sink's).
    fn is_open(&self, a: u32, tree: Tree) -> bool {
        let arc = self.arcs[a as usize];
        let residual = if tree == Tree::Source { self.arcs[arc.sister as usize].residual } else { arc.residual };
        residual > 0
    }

    /// Finds another parent for the orphan `i`, the one nearest to the terminal, or sets `i` free.
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
                self.wake(j);
            }
            if node.parent < ORPHAN && self.arcs[node.parent as usize].head == i {
                self.nodes[j as usize].parent = ORPHAN;
                self.orphans.push_back(j);
            }
        }
    }

    /// Arcs between `j` and its terminal, `u32::MAX` if the way ends in an orphan. Marks the way, so that it is not
    /// gone twice.
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

        /// What the cut costs that has exactly the nodes of `sink_side` with the sink.
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
            let mut left = vec![vec![0_i64; n + 2]; n + 2];
            for (i, &excess) in self.terminals.iter().enumerate() {
                left[source][i] = excess.max(0);
                left[i][sink] = (-excess).max(0);
            }
            for (&(a, b), &(along, back)) in self.edges.iter().zip(&self.capacities) {
                left[a as usize][b as usize] += i64::from(along);
                left[b as usize][a as usize] += i64::from(back);
            }
            let mut flow = 0;
            loop {
                let mut parent = vec![usize::MAX; n + 2];
                let mut queue = VecDeque::from([source]);
                while let Some(i) = queue.pop_front() {
                    for j in 0..n + 2 {
                        if left[i][j] > 0 && parent[j] == usize::MAX && j != source {
                            parent[j] = i;
                            queue.push_back(j);
                        }
                    }
                }
                if parent[sink] == usize::MAX {
                    return flow;
                }
                let way = || std::iter::successors(Some(sink), |&j| (parent[j] != source).then(|| parent[j]));
                let amount = way().map(|j| left[parent[j]][j]).min().unwrap();
                for j in way() {
                    left[parent[j]][j] -= amount;
                    left[j][parent[j]] += amount;
                }
                flow += amount;
            }
        }

        /// Conservation, capacities, and that the cut found costs what flows.
        fn check(&self, network: &Network, flow: i64) {
            let mut outgoing = vec![0_i64; self.terminals.len()];
            for (e, (&(a, b), &(along, back))) in self.edges.iter().zip(&self.capacities).enumerate() {
                let forward = network.arcs[network.place[e] as usize];
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
            assert_eq!(self.cut(|i| network.on_sink_side(i)), flow);
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
        assert!(!network.on_sink_side(0) && !network.on_sink_side(1));
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
