//! `tracecut explain`: why pixels have their labels, in words and numbers.

use crate::failure::{Failure, Result, print};
use crate::input::Input;
use crate::run::{progress_bar, run};
use crate::settings::Settings;
use clap::Args;
use std::path::PathBuf;
use tracecut::cut::{Link, STEPS_PER_UNIT, STRANGER};
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
    let (session, _) = run(&input, params, threads, &progress_bar())?;
    for &[t, x, y] in &args.at {
        print(words(&session, [t, x, y], &session.explain(t, x, y).map_err(|e| Failure::usage(e.to_string()))?))?;
    }
    Ok(())
}

/// Steps of the solver in units of cost.
fn units(steps: i64) -> f64 {
    steps as f64 / f64::from(STEPS_PER_UNIT)
}

fn thing(label: u8) -> String {
    if label == 0 { "the background".to_owned() } else { format!("object {label}") }
}

fn words(session: &Session, [t, x, y]: [usize; 3], why: &Explanation) -> String {
    let (mut text, reasons) = (Vec::new(), &why.reasons);
    let of = |cluster: u32| why.of_cluster.get(cluster as usize).copied().unwrap_or(0);
    let named = |cluster: u32| format!("{} (cluster {cluster})", thing(of(cluster)));
    text.push(format!("frame {t}, pixel {x},{y}: {}", thing(why.label)));
    let by_cut = named(reasons.label);
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
    text.push(format!("  what each label would cost, all else as it is (the solver counts in 1/{STEPS_PER_UNIT}):"));
    text.push(format!(
        "    {:28} {:>7} {:>12} {:>9} {:>9} {:>9} {:>9}",
        "", "votes", "trajectories", "colours", "evidence", "links", "sum"
    ));
    for (cluster, own) in (0..).zip(&reasons.own) {
        let sum = reasons.cost(cluster);
        let alone = [own.trajectories, own.colours, own.evidence].map(i64::from);
        let links = sum - alone.iter().sum::<i64>() - i64::from(own.forbidden);
        let [a, b, c] = alone.map(units);
        let held = if own.forbidden > 0 { "  forbidden by a stroke" } else { "" };
        let (name, votes, links, sum) = (named(cluster), reasons.votes[cluster as usize], units(links), units(sum));
        text.push(format!("    {name:28} {votes:7} {a:12.4} {b:9.4} {c:9.4} {links:9.4} {sum:9.4}{held}"));
    }
    let strangers = why.voters.iter().filter(|voter| voter.cluster == STRANGER).count();
    text.push(format!(
        "  {} trajectories in it, {strangers} of them like nothing around them; their weight is {:.2}",
        why.voters.len(),
        reasons.lambda
    ));
    text.push(format!("  evidence for an object: {:+.3} by the background, {:+.3} by looks", why.cues, why.looks));
    links(&mut text, t, &reasons.links, &named);
    motion(&mut text, session, why, &named);
    flips(&mut text, t, why, &named);
    text.join("\n")
}

fn links(text: &mut Vec<String>, t: usize, links: &[Link], named: &dyn Fn(u32) -> String) {
    let mut strongest: Vec<&Link> = links.iter().collect();
    strongest.sort_by_key(|link| std::cmp::Reverse(link.cost));
    text.push(format!("  bound to {} superpixels:", links.len()));
    for link in strongest.iter().take(MOST_LINKS) {
        text.push(format!("    {:8.4} {}", units(link.cost.into()), neighbour(t, link, named)));
    }
    let rest: i64 = strongest.iter().skip(MOST_LINKS).map(|link| i64::from(link.cost)).sum();
    if links.len() > MOST_LINKS {
        text.push(format!("    {:8.4} all others", units(rest)));
    }
}

fn neighbour(t: usize, link: &Link, named: &dyn Fn(u32) -> String) -> String {
    let where_to = match link.t {
        other if other == t => "beside it".to_owned(),
        other if other < t => format!("a frame before, {} common trajectories", link.tracks),
        _ => format!("a frame after, {} common trajectories", link.tracks),
    };
    format!("superpixel {} {where_to}: {}", link.superpixel, named(link.label))
}

fn motion(text: &mut Vec<String>, session: &Session, why: &Explanation, named: &dyn Fn(u32) -> String) {
    let label = |i: u32| session.clusters().map_or_else(String::new, |c| named(c.label[i as usize]));
    if let Some(i) = why.nearest {
        text.push(format!("  the nearest clustered trajectory is {i}, of {}; it moves most like", label(i)));
        for &(j, affinity) in &why.affinities {
            text.push(format!("    trajectory {j} of {}: affinity {affinity:.4}", label(j)));
        }
    }
    if let (Some(rim), Some(other)) = (why.rim, why.runner_up) {
        let (i, j, d) = rim.strongest;
        let (edges, mean, other) = (rim.edges, rim.mean, named(other.cluster));
        text.push(format!(
            "  {edges} edges of this frame lead to {other}: mean discontinuity {mean:.3}, most {d:.3} ({i} to {j})"
        ));
    }
}

fn flips(text: &mut Vec<String>, t: usize, why: &Explanation, named: &dyn Fn(u32) -> String) {
    let Some(other) = why.runner_up else {
        text.push("  there is nothing else that it could be".to_owned());
        return;
    };
    text.push(format!(
        "  to be {} instead costs {:.4} more; any of these would outweigh that:",
        named(other.cluster),
        units(other.margin)
    ));
    match other.votes {
        Some(votes) => text.push(format!("    {votes} more trajectories of that cluster in the superpixel")),
        None => text.push("    no number of trajectories in this superpixel alone".to_owned()),
    }
    // A neighbour that goes over costs the one label its link and saves it the other.
    let own = why.reasons.label;
    for link in why.reasons.links.iter().filter(|l| l.label == own && 2 * i64::from(l.cost) >= other.margin) {
        text.push(format!("    if {} went over", neighbour(t, link, named)));
    }
    if (why.of_cluster[own as usize] > 0) != (why.of_cluster[other.cluster as usize] > 0) {
        let side = if why.of_cluster[own as usize] > 0 { "against" } else { "for" };
        text.push(format!("    evidence of {:.4} more {side} an object", units(other.margin)));
    }
}
