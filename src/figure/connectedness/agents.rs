//! Agents: components of the foreground, tracked also while they touch.
//!
//! Two agents that touch for a while are one component then, and trajectories that exist only meanwhile would belong to
//! both. So components are tracked from frame to frame, in both directions of time:
//!
//! 1. A component whose trajectories belong to no agent yet is a new agent.
//! 2. In a component of several agents, their trajectories keep their agents, and new trajectories join the agent of the
//!    nearest one.
//! 3. An agent that was a component of its own for fewer frames than count as a violation is merged with one that it
//!    touches.
//! 4. An agent that was in several components for as many frames is split.
//!
//! Not in the paper, which uses the components of each frame alone. Cost: O(points + new trajectories · size of their
//! component). It fails where agents swap sides while they touch.

use super::Components;
use crate::trajectory::Trajectories;

/// Tracks agents through the frames in the order of `frames`. Returns the agent of each trajectory point;
/// `None` outside of components. Numbers are unique in the clip.
pub(super) fn track_agents(
    tracks: &Trajectories,
    components: &Components,
    frames: impl Iterator<Item = usize>,
    min_frames: u32,
    min_size: usize,
) -> Vec<Option<u32>> {
    let mut of_point = vec![None; tracks.x.len()];
    let mut agents = Agents { of_track: vec![None; tracks.len()], agents: Vec::new(), min_frames, min_size };
    for t in frames {
        let mut members: Vec<Vec<Member>> = vec![Vec::new(); components.count[t] as usize];
        for (i, x, y) in tracks.alive(t) {
            let point = tracks.point(i, t);
            if let Some(component) = components.of_point[point] {
                members[component as usize].push(Member { track: i, point, x, y });
            }
        }
        agents.split(&members);
        for component in &members {
            agents.update(component);
            component.iter().for_each(|m| of_point[m.point] = agents.of_track[m.track]);
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
    single_frames: u32,
    /// Frames up to now in which it was in several components.
    split_frames: u32,
}

struct Agents {
    /// The agent of each trajectory so far.
    of_track: Vec<Option<u32>>,
    agents: Vec<Agent>,
    min_frames: u32,
    min_size: usize,
}

impl Agents {
    fn new_agent(&mut self, single_frames: u32) -> u32 {
        self.agents.push(Agent { single_frames, split_frames: 0 });
        self.agents.len() as u32 - 1
    }

    /// Splits agents that are in several components for long (step 4). The largest piece stays the same agent.
    fn split(&mut self, components: &[Vec<Member>]) {
        // Size and component of each piece of each agent.
        let mut pieces: Vec<Vec<(usize, usize)>> = vec![Vec::new(); self.agents.len()];
        for (c, component) in components.iter().enumerate() {
            for (agent, count) in self.count(component) {
                if count >= self.min_size {
                    pieces[agent as usize].push((count, c));
                }
            }
        }
        for (agent, pieces) in pieces.iter().enumerate() {
            let split_frames = if pieces.len() > 1 { self.agents[agent].split_frames + 1 } else { 0 };
            self.agents[agent].split_frames = split_frames;
            if split_frames < self.min_frames || pieces.len() < 2 {
                continue;
            }
            self.agents[agent].split_frames = 0;
            let largest = pieces.iter().rev().max_by_key(|piece| piece.0).map_or(0, |piece| piece.1);
            for &(_, c) in pieces.iter().filter(|piece| piece.1 != largest) {
                let new = self.new_agent(split_frames);
                self.rename(&components[c], agent as u32, new);
            }
        }
    }

    /// Assigns the trajectories of a component to agents (steps 1 to 3).
    fn update(&mut self, component: &[Member]) {
        let mut present = self.count(component);
        let age = |&&(a, count): &&(u32, usize)| (self.agents[a as usize].single_frames, count);
        let Some((oldest, _)) = present.iter().rev().max_by_key(age).copied() else {
            let new = self.new_agent(1);
            component.iter().for_each(|m| self.of_track[m.track] = Some(new));
            return;
        };
        for &(agent, _) in &present {
            if agent != oldest && self.agents[agent as usize].single_frames < self.min_frames {
                self.rename(component, agent, oldest);
            }
        }
        let (assigned, new): (Vec<Member>, Vec<Member>) =
            component.iter().partition(|m| self.of_track[m.track].is_some());
        for m in new {
            let distance_sq = |k: &Member| (k.x - m.x).powi(2) + (k.y - m.y).powi(2);
            let nearest = assigned.iter().rev().min_by(|a, b| distance_sq(a).total_cmp(&distance_sq(b)));
            self.of_track[m.track] = nearest.map_or(Some(oldest), |k| self.of_track[k.track]);
        }
        present.retain(|&(a, _)| a == oldest || self.agents[a as usize].single_frames >= self.min_frames);
        if present.len() == 1 {
            self.agents[oldest as usize].single_frames += 1;
        }
    }

    /// Counts the trajectories of each agent in a component, by agent.
    fn count(&self, component: &[Member]) -> Vec<(u32, usize)> {
        let mut agents: Vec<u32> = component.iter().filter_map(|m| self.of_track[m.track]).collect();
        crate::order::sort_by_key(&mut agents, |&a| a.into());
        agents.chunk_by(|a, b| a == b).map(|equal| (equal[0], equal.len())).collect()
    }

    fn rename(&mut self, component: &[Member], from: u32, to: u32) {
        for m in component {
            let agent = &mut self.of_track[m.track];
            *agent = if *agent == Some(from) { Some(to) } else { *agent };
        }
    }
}
