//! Agents: components of the foreground followed through time, also while they touch.
//!
//! Two agents that touch for a while are one component then. Trajectories that live only meanwhile would lie between
//! them and belong to both. So components are followed from frame to frame, in both directions of time:
//!
//! 1. A component whose trajectories belong to no agent yet is a new one.
//! 2. In a component that holds trajectories of several agents these keep theirs, and new trajectories join the agent
//!    of the nearest one.
//! 3. An agent that has been in one piece of its own for fewer frames than count as a violation joins the one that it
//!    touches.
//! 4. An agent that has been in several components for as many frames is several agents from then on.
//!
//! Not in the paper, which looks at the components of each frame alone. Cost: O(points + new trajectories · size of
//! their component).

use super::components::{Components, NO_COMPONENT};
use crate::trajectory::Trajectories;

/// The agent of each trajectory point, in the order of the points, [`NO_COMPONENT`] without; followed through the
/// frames in the order of `frames`. Numbers are unique in the clip.
pub(super) fn follow(
    tracks: &Trajectories,
    components: &Components,
    frames: impl Iterator<Item = usize>,
    min_frames: u32,
    min_size: usize,
) -> Vec<u32> {
    let mut of_point = vec![NO_COMPONENT; tracks.x.len()];
    let mut known = Agents { of_track: vec![NO_COMPONENT; tracks.len()], agents: Vec::new(), min_frames, min_size };
    for t in frames {
        let mut parts: Vec<Vec<Member>> = vec![Vec::new(); components.count[t] as usize];
        for (i, x, y) in tracks.alive(t) {
            let point = tracks.point(i, t);
            if let Some(part) = parts.get_mut(components.of_point[point] as usize) {
                part.push(Member { track: i, point, x, y });
            }
        }
        known.tear(&parts);
        for part in &parts {
            known.settle(part);
            part.iter().for_each(|m| of_point[m.point] = known.of_track[m.track]);
        }
    }
    of_point
}

/// A trajectory in a component of the present frame.
#[derive(Debug, Clone, Copy)]
struct Member {
    track: usize,
    point: usize,
    x: f32,
    y: f32,
}

#[derive(Debug, Clone, Copy, Default)]
struct Agent {
    /// Frames in which it was a component of its own.
    alone: u32,
    /// Frames up to now for which it has been in several components.
    torn: u32,
}

struct Agents {
    /// The agent of each trajectory so far.
    of_track: Vec<u32>,
    agents: Vec<Agent>,
    min_frames: u32,
    min_size: usize,
}

impl Agents {
    fn new_agent(&mut self, alone: u32) -> u32 {
        self.agents.push(Agent { alone, torn: 0 });
        self.agents.len() as u32 - 1
    }

    /// Step 4. Where an agent falls apart, the largest piece stays what it was.
    fn tear(&mut self, parts: &[Vec<Member>]) {
        // Pieces of each agent: (members, component).
        let mut pieces: Vec<Vec<(usize, usize)>> = vec![Vec::new(); self.agents.len()];
        for (c, part) in parts.iter().enumerate() {
            for (agent, count) in self.count(part) {
                if count >= self.min_size {
                    pieces[agent as usize].push((count, c));
                }
            }
        }
        for (agent, pieces) in pieces.iter().enumerate() {
            let torn = if pieces.len() > 1 { self.agents[agent].torn + 1 } else { 0 };
            self.agents[agent].torn = torn;
            if torn < self.min_frames || pieces.len() < 2 {
                continue;
            }
            self.agents[agent].torn = 0;
            let largest = pieces.iter().rev().max_by_key(|piece| piece.0).map_or(0, |piece| piece.1);
            for &(_, c) in pieces.iter().filter(|piece| piece.1 != largest) {
                let new = self.new_agent(torn);
                self.rename(&parts[c], agent as u32, new);
            }
        }
    }

    /// Steps 1 to 3 for one component.
    fn settle(&mut self, part: &[Member]) {
        let mut present = self.count(part);
        let oldest = present.iter().rev().max_by_key(|&&(a, count)| (self.agents[a as usize].alone, count)).copied();
        let Some((oldest, _)) = oldest else {
            let new = self.new_agent(1);
            part.iter().for_each(|m| self.of_track[m.track] = new);
            return;
        };
        for &(agent, _) in &present {
            if agent != oldest && self.agents[agent as usize].alone < self.min_frames {
                self.rename(part, agent, oldest);
            }
        }
        let (known, new): (Vec<Member>, Vec<Member>) =
            part.iter().partition(|m| self.of_track[m.track] != NO_COMPONENT);
        for m in new {
            let distance_sq = |k: &Member| (k.x - m.x).powi(2) + (k.y - m.y).powi(2);
            let nearest = known.iter().rev().min_by(|a, b| distance_sq(a).total_cmp(&distance_sq(b)));
            self.of_track[m.track] = nearest.map_or(oldest, |k| self.of_track[k.track]);
        }
        present.retain(|&(a, _)| a == oldest || self.agents[a as usize].alone >= self.min_frames);
        if present.len() == 1 {
            self.agents[oldest as usize].alone += 1;
        }
    }

    /// The agents in a component with the number of their trajectories there, by number.
    fn count(&self, part: &[Member]) -> Vec<(u32, usize)> {
        let mut of_members: Vec<u32> = part.iter().map(|m| self.of_track[m.track]).collect();
        of_members.retain(|&a| a != NO_COMPONENT);
        crate::order::sort_by_key(&mut of_members, |&a| a.into());
        of_members.chunk_by(|a, b| a == b).map(|same| (same[0], same.len())).collect()
    }

    fn rename(&mut self, part: &[Member], from: u32, to: u32) {
        for m in part {
            let agent = &mut self.of_track[m.track];
            *agent = if *agent == from { to } else { *agent };
        }
    }
}
