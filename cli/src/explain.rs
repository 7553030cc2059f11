//! `tracecut explain`: why pixels have their labels, in words and numbers.

use crate::failure::{Failure, Result, print};
use crate::input::Input;
use crate::log::Log;
use crate::run::run_frames;
use crate::settings::Settings;
use clap::Args;
use std::path::PathBuf;
use tracecut::session::SuperpixelLink;
use tracecut::{Explanation, Session, Source};

/// How many of the links are listed one by one, the strongest first.
const MOST_LINKS: usize = 8;

#[derive(Args, Debug)]
pub(crate) struct ExplainArgs {
    /// Folder of images in name order, .bmf list, animated GIF, .y4m file, or - for Y4M on standard input
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
    let input = Input::open(&args.input, args.frames)?.within(&params);
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
        print(words(&session, [t, x, y], &session.explain(t, x, y).map_err(|e| Failure::usage(e.to_string()))?))?;
    }
    damage.map_or(Ok(()), Err)
}

fn thing(label: u8) -> String {
    if label == 0 { "the background".to_owned() } else { format!("object {label}") }
}

fn label_of(why: &Explanation, cluster: u32) -> u8 {
    why.costs.get(cluster as usize).map_or(0, |cost| cost.label)
}

fn words(session: &Session, [t, x, y]: [usize; 3], why: &Explanation) -> String {
    let mut text = Vec::new();
    let named = |cluster: u32| format!("{} (cluster {cluster})", thing(label_of(why, cluster)));
    text.push(format!("frame {t}, pixel {x},{y}: {}", thing(why.label)));
    let by_cut = named(why.cluster);
    match why.source {
        Source::Superpixel => text.push(format!("  by superpixel {}, which the cut gave to {by_cut}", why.superpixel)),
        Source::Border => {
            text.push(format!(
                "  the border's step moved it here by the colours on both sides; its superpixel {} is {by_cut}",
                why.superpixel
            ));
        }
        Source::Stroke => text.push(format!("  by a stroke; its superpixel {} is {by_cut}", why.superpixel)),
    }
    text.push("  what each label would cost, all else as it is (the solver counts in 1/65536):".to_owned());
    text.push(format!(
        "    {:28} {:>7} {:>12} {:>9} {:>9} {:>9} {:>9}",
        "", "votes", "trajectories", "colours", "evidence", "links", "sum"
    ));
    for cost in &why.costs {
        let held = if cost.forbidden > 0.0 { "  forbidden by a stroke" } else { "" };
        text.push(format!(
            "    {:28} {:7} {:12.4} {:9.4} {:9.4} {:9.4} {:9.4}{held}",
            named(cost.cluster),
            cost.votes,
            cost.trajectories,
            cost.colours,
            cost.evidence,
            cost.links,
            cost.total
        ));
    }
    let strangers = why.voters.iter().filter(|voter| voter.stranger).count();
    text.push(format!(
        "  {} trajectories in it, {strangers} of them like nothing around them; their weight is {:.2}",
        why.voters.len(),
        why.weight
    ));
    let evidence = why.evidence;
    text.push(format!(
        "  evidence for an object: {:+.3} by the background, {:+.3} by looks",
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
    text.push(format!("  bound to {} superpixels:", links.len()));
    for link in strongest.iter().take(MOST_LINKS) {
        text.push(format!("    {:8.4} {}", link.cost, neighbour(t, link, named)));
    }
    let rest: f64 = strongest.iter().skip(MOST_LINKS).map(|link| link.cost).sum();
    if links.len() > MOST_LINKS {
        text.push(format!("    {rest:8.4} all others"));
    }
}

fn neighbour(t: usize, link: &SuperpixelLink, named: &dyn Fn(u32) -> String) -> String {
    let where_to = match link.t {
        other if other == t => "beside it".to_owned(),
        other if other < t => format!("a frame before, {} common trajectories", link.tracks),
        _ => format!("a frame after, {} common trajectories", link.tracks),
    };
    format!("superpixel {} {where_to}: {}", link.superpixel, named(link.cluster))
}

fn motion(text: &mut Vec<String>, session: &Session, why: &Explanation, named: &dyn Fn(u32) -> String) {
    let label = |i: u32| session.clusters().map_or_else(String::new, |c| named(c.label[i as usize]));
    if let Some(i) = why.nearest {
        text.push(format!("  the nearest clustered trajectory is {i}, of {}; it moves most like", label(i)));
        for near in &why.affinities {
            text.push(format!("    trajectory {} of {}: affinity {:.4}", near.to, label(near.to), near.affinity));
        }
    }
    if let (Some(border), Some(other)) = (why.border, why.flip) {
        text.push(format!(
            "  {} edges of this frame lead to {}: mean discontinuity {:.3}, most {:.3} ({} to {})",
            border.edges,
            named(other.cluster),
            border.mean,
            border.d,
            border.i,
            border.j
        ));
    }
}

fn flips(text: &mut Vec<String>, t: usize, why: &Explanation, named: &dyn Fn(u32) -> String) {
    let Some(other) = why.flip else {
        text.push("  there is nothing else that it could be".to_owned());
        return;
    };
    text.push(format!(
        "  to be {} instead costs {:.4} more; any of these would outweigh that:",
        named(other.cluster),
        other.margin
    ));
    match other.votes {
        Some(votes) => text.push(format!("    {votes} more trajectories of that cluster in the superpixel")),
        None => text.push("    no number of trajectories in this superpixel alone".to_owned()),
    }
    // A neighbour that goes over costs the one label its link and saves it the other.
    for link in why.links.iter().filter(|l| l.cluster == why.cluster && 2.0 * l.cost >= other.margin) {
        text.push(format!("    if {} went over", neighbour(t, link, named)));
    }
    let is_object = label_of(why, why.cluster) > 0;
    if is_object != (label_of(why, other.cluster) > 0) {
        let side = if is_object { "against" } else { "for" };
        text.push(format!("    evidence of {:.4} more {side} an object", other.margin));
    }
}
