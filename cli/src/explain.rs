//! `tracecut explain`: explanations of pixel labels as text.

use crate::failure::{Failure, Result, print};
use crate::input::{Input, KINDS};
use crate::log::Log;
use crate::run::run_frames;
use crate::settings::Settings;
use clap::Args;
use std::cmp::Ordering;
use std::path::PathBuf;
use tracecut::Session;
use tracecut::explanation::{Explanation, LabelSource, SuperpixelLink};

/// Number of links that are listed one by one, the strongest first; chosen by eye.
const MAX_LINKS: usize = 8;

#[derive(Args, Debug)]
pub(crate) struct ExplainArgs {
    #[arg(help = KINDS)]
    input: PathBuf,
    /// A pixel: frame, column and row, each counted from 0; may be given several times
    #[arg(long, value_name = "T,X,Y", required = true, value_parser = pixel)]
    at: Vec<[usize; 3]>,
    /// Take the first N frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..))]
    frames: Option<u32>,
    #[command(flatten)]
    settings: Settings,
}

fn pixel(text: &str) -> std::result::Result<[usize; 3], String> {
    let numbers: std::result::Result<Vec<usize>, _> = text.split(',').map(|n| n.trim().parse()).collect();
    numbers.ok().and_then(|n| n.try_into().ok()).ok_or_else(|| "expected three whole numbers, as 12,200,80".to_owned())
}

pub(crate) fn explain(args: &ExplainArgs) -> Result<()> {
    let params = args.settings.params()?;
    let input = Input::open(&args.input, args.frames)?.with_limits(&params);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut damage = None;
    let frames = input.frames()?.map_while(|frame| match frame {
        Err(failure) if failure.is_after_clip() => {
            damage = Some(failure);
            None
        }
        frame => Some(frame),
    });
    let (session, _) = run_frames(frames, input.num_frames(), params, threads, &Log::plain())?;
    for &[t, x, y] in &args.at {
        let explanation = session.explain(t, (x, y)).map_err(|e| Failure::usage(e.to_string()))?;
        print(describe(&session, [t, x, y], &explanation))?;
    }
    damage.map_or(Ok(()), Err)
}

fn name_label(label: u8) -> String {
    if label == 0 { "the background".to_owned() } else { format!("object {label}") }
}

fn label_of(why: &Explanation, cluster: u32) -> u8 {
    why.costs.get(cluster as usize).map_or(0, |cost| cost.label)
}

fn describe(session: &Session, [t, x, y]: [usize; 3], why: &Explanation) -> String {
    let mut text = Vec::new();
    let named = |cluster: u32| format!("{} (cluster {cluster})", name_label(label_of(why, cluster)));
    text.push(format!("frame {t}, pixel {x},{y}: {}", name_label(why.label)));
    let cut_label = named(why.cluster);
    match why.source {
        LabelSource::Superpixel => text.push(format!("  by the cut: superpixel {} is {cut_label}", why.superpixel)),
        LabelSource::Border => {
            text.push(format!("  by border refinement: superpixel {} is {cut_label}", why.superpixel));
        }
        LabelSource::Stroke => text.push(format!("  by a stroke: superpixel {} is {cut_label}", why.superpixel)),
    }
    text.push("  cost of each label, all others fixed (in steps of 1/65536):".to_owned());
    text.push(format!(
        "    {:28} {:>7} {:>12} {:>9} {:>9} {:>9}",
        "", "votes", "trajectories", "evidence", "links", "sum"
    ));
    for cost in &why.costs {
        let note = if cost.forbidden > 0.0 { "  forbidden by a stroke" } else { "" };
        text.push(format!(
            "    {:28} {:7} {:12.4} {:9.4} {:9.4} {:9.4}{note}",
            named(cost.cluster),
            cost.votes,
            cost.trajectories,
            cost.evidence,
            cost.links,
            cost.total
        ));
    }
    text.push(format!("  {} trajectories; weight {:.2}", why.voters.len(), why.weight));
    let evidence = why.evidence;
    text.push(format!(
        "  evidence for an object: {:+.3} from the background, {:+.3} from appearance",
        evidence.background, evidence.looks
    ));
    links(&mut text, t, &why.links, &named);
    motion(&mut text, session, why, &named);
    flips(&mut text, t, why, &named);
    text.join("\n")
}

fn links(text: &mut Vec<String>, t: usize, links: &[SuperpixelLink], named: &dyn Fn(u32) -> String) {
    let mut strongest: Vec<&SuperpixelLink> = links.iter().collect();
    strongest.sort_by(|a, b| b.cost.total_cmp(&a.cost));
    text.push(format!("  linked to {} superpixels:", links.len()));
    for link in strongest.iter().take(MAX_LINKS) {
        text.push(format!("    {:8.4} {}", link.cost, neighbour(t, link, named)));
    }
    let rest: f64 = strongest.iter().skip(MAX_LINKS).map(|link| link.cost).sum();
    if links.len() > MAX_LINKS {
        text.push(format!("    {rest:8.4} others"));
    }
}

fn neighbour(t: usize, link: &SuperpixelLink, named: &dyn Fn(u32) -> String) -> String {
    let position = match link.t.cmp(&t) {
        Ordering::Equal => "beside it".to_owned(),
        Ordering::Less => format!("a frame before, {} common trajectories", link.tracks),
        Ordering::Greater => format!("a frame after, {} common trajectories", link.tracks),
    };
    format!("superpixel {} {position}: {}", link.superpixel, named(link.cluster))
}

fn motion(text: &mut Vec<String>, session: &Session, why: &Explanation, named: &dyn Fn(u32) -> String) {
    let label = |i: u32| session.clusters().map_or_else(String::new, |c| named(c.label[i as usize]));
    if let Some(i) = why.nearest {
        text.push(format!("  nearest clustered trajectory: {i}, of {}; its largest affinities:", label(i)));
        for entry in &why.affinities {
            text.push(format!("    trajectory {} of {}: affinity {:.4}", entry.to, label(entry.to), entry.affinity));
        }
    }
    if let (Some(border), Some(flip)) = (why.border, why.flip) {
        text.push(format!(
            "  {} edges to {}: mean discontinuity {:.3}, largest {:.3} ({} to {})",
            border.edges,
            named(flip.cluster),
            border.mean,
            border.d,
            border.i,
            border.j
        ));
    }
}

fn flips(text: &mut Vec<String>, t: usize, why: &Explanation, named: &dyn Fn(u32) -> String) {
    let Some(flip) = why.flip else {
        text.push("  there is no other label".to_owned());
        return;
    };
    text.push(format!("  {} costs {:.4} more; any of these would outweigh that:", named(flip.cluster), flip.margin));
    match flip.votes {
        Some(votes) => text.push(format!("    {votes} more trajectories of that cluster in the superpixel")),
        None => text.push("    no number of trajectories in this superpixel alone".to_owned()),
    }
    // A neighbour that changes its label adds the cost of its link to one label and removes it from the flip.
    for link in why.links.iter().filter(|l| l.cluster == why.cluster && 2.0 * l.cost >= flip.margin) {
        text.push(format!("    a change of {}", neighbour(t, link, named)));
    }
    let is_object = label_of(why, why.cluster) > 0;
    if is_object != (label_of(why, flip.cluster) > 0) {
        let side = if is_object { "against" } else { "for" };
        text.push(format!("    {:.4} more evidence {side} an object", flip.margin));
    }
}
