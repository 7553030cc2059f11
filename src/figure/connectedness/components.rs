//! Connected components of the foreground, frame by frame.

use crate::discontinuity::Neighborhoods;
use crate::sets::DisjointSets;
use crate::trajectory::Trajectories;

/// Connected components of the foreground in each frame.
///
/// Law: `of_point` has an entry for each trajectory point, in their order; in frame `t` it is below `count[t]`, or `None` for
/// the background and for foreground in too small a component.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Components {
    /// Number of components of each frame.
    pub count: Vec<u32>,
    /// The component of each trajectory point in its frame.
    pub of_point: Vec<Option<u32>>,
}

/// Computes the connected components of the foreground, along Delaunay edges of at most `max_edge` pixels. Components of
/// fewer than `min_size` trajectories are left out. They are numbered by their first trajectory.
///
/// # Examples
/// Foreground at either end of a row of trajectories: two components.
///
/// ```
/// use tracecut::connectedness::components;
/// use tracecut::discontinuity::neighborhoods;
/// use tracecut::trajectory::Trajectories;
///
/// let row = "1110000011";
/// let mut tracks = Trajectories::empty(1, (100, 20));
/// (0..10).for_each(|i| tracks.push(0, [(10.0 * i as f32, (i % 2) as f32, 0.0)]));
/// let foreground: Vec<bool> = row.bytes().map(|digit| digit == b'1').collect();
/// let found = components(&tracks, &neighborhoods(&tracks), &foreground, 30.0, 2);
/// assert_eq!(found.count, [2]);
/// assert_eq!((found.of_point[0], found.of_point[3], found.of_point[9]), (Some(0), None, Some(1)));
/// ```
#[must_use]
pub fn components(
    tracks: &Trajectories,
    neighborhoods: &Neighborhoods,
    foreground: &[bool],
    max_edge: f32,
    min_size: usize,
) -> Components {
    let mut components = Components { count: Vec::new(), of_point: vec![None; tracks.x.len()] };
    let mut set = DisjointSets::new(tracks.len());
    let mut size = vec![0_u32; tracks.len()];
    let mut number = vec![None; tracks.len()];
    for t in 0..tracks.num_frames {
        let members: Vec<usize> = tracks.alive(t).map(|(i, _, _)| i).filter(|&i| foreground[i]).collect();
        for &i in &members {
            set.reset(i);
            (size[i], number[i]) = (0, None);
        }
        for &pair in neighborhoods.frame(t) {
            let (i, j) = neighborhoods.pairs[pair as usize];
            let (i, j) = (i as usize, j as usize);
            if foreground[i] && foreground[j] && distance_sq(tracks, i, j, t) <= max_edge * max_edge {
                set.join(i, j);
            }
        }
        for &i in &members {
            size[set.root(i)] += 1;
        }
        let mut count = 0;
        for &i in &members {
            let root = set.root(i);
            if size[root] as usize >= min_size && number[root].is_none() {
                number[root] = Some(count);
                count += 1;
            }
            components.of_point[tracks.point(i, t)] = number[root];
        }
        components.count.push(count);
    }
    components
}

fn distance_sq(tracks: &Trajectories, i: usize, j: usize, t: usize) -> f32 {
    let (p, q) = (tracks.point(i, t), tracks.point(j, t));
    (tracks.x[p] - tracks.x[q]).powi(2) + (tracks.y[p] - tracks.y[q]).powi(2)
}
