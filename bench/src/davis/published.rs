//! Figures that others published on the same sequences.

use std::collections::BTreeMap;
use std::path::Path;
use tracecut_cli::failure::{Failure, Result, read_text};

/// The paper's own program.
const PAPER: &str = "trc";
/// Methods on the benchmark's site that use no trained part: trc and msg trace trajectories (this paper; Ochs and
/// Brox), fst is by Papazoglou and Ferrari, nlc by Faktor and Irani, cvos by Taylor et al., key by Lee et al., sal by
/// Wang et al., tis by Griffin and Corso.
const UNLEARNED: [&str; 8] = ["trc", "msg", "fst", "nlc", "cvos", "key", "sal", "tis"];

/// J and F of one method on one sequence.
type Pair = [f64; 2];

/// The figures of each method, sequence by sequence; empty where there is no file.
#[derive(Debug, Default)]
pub(super) struct Published(BTreeMap<String, BTreeMap<String, Pair>>);

impl Published {
    /// Reads `published.json` in `folder`, if there.
    pub(super) fn beside(folder: &Path) -> Result<Self> {
        let path = folder.join("published.json");
        if !path.is_file() {
            return Ok(Self::default());
        }
        let methods = serde_json::from_str(&read_text(&path)?).map_err(|e| {
            Failure::about(path.display(), format_args!("is not {{\"method\": {{\"sequence\": [J, F]}}}}: {e}"))
        })?;
        Ok(Self(methods))
    }

    pub(super) fn heading(&self) -> &'static str {
        if self.0.is_empty() { "" } else { "  | trc J  trc F  best J  best F" }
    }

    /// The paper's figures on a sequence, and those of the unlearned method with the best J.
    pub(super) fn columns(&self, sequence: &str) -> String {
        if self.0.is_empty() {
            return String::new();
        }
        let (best, name) = match self.best(sequence) {
            Some((name, pair)) => (Some(pair), name),
            None => (None, ""),
        };
        pairs(self.of(PAPER, sequence), best, name)
    }

    /// The means of these columns over those of `sequences` that have them.
    pub(super) fn mean_columns(&self, sequences: &[&str]) -> String {
        if self.0.is_empty() {
            return String::new();
        }
        let paper: Vec<Pair> = sequences.iter().filter_map(|s| self.of(PAPER, s)).collect();
        let best: Vec<Pair> = sequences.iter().filter_map(|s| self.best(s)).map(|(_, pair)| pair).collect();
        pairs(mean(&paper), mean(&best), "")
    }

    /// A line for each method that has figures on all of `sequences`: its means, best J first.
    pub(super) fn table(&self, sequences: &[&str]) -> Vec<String> {
        let mut rows: Vec<(&str, Pair)> = Vec::new();
        for (name, figures) in &self.0 {
            let all: Option<Vec<Pair>> = sequences.iter().map(|&s| figures.get(s).copied()).collect();
            rows.extend(all.and_then(|all| mean(&all)).map(|pair| (name.as_str(), pair)));
        }
        rows.sort_by(|a, b| b.1[0].total_cmp(&a.1[0]));
        let line = |(name, [j, f]): &(&str, Pair)| {
            let note = if UNLEARNED.contains(name) { "" } else { "  with learned parts, or not known" };
            format!("  {name:8} J {j:.3}  F {f:.3}{note}")
        };
        let heading = format!("\npublished means over the same {} sequence(s), whole clips:", sequences.len());
        if rows.is_empty() { Vec::new() } else { std::iter::once(heading).chain(rows.iter().map(line)).collect() }
    }

    fn of(&self, method: &str, sequence: &str) -> Option<Pair> {
        self.0.get(method)?.get(sequence).copied()
    }

    fn best(&self, sequence: &str) -> Option<(&'static str, Pair)> {
        let all = UNLEARNED.iter().filter_map(|&name| Some((name, self.of(name, sequence)?)));
        all.max_by(|a, b| a.1[0].total_cmp(&b.1[0]))
    }
}

fn mean(pairs: &[Pair]) -> Option<Pair> {
    let over = |c: usize| pairs.iter().map(|p| p[c]).sum::<f64>() / pairs.len() as f64;
    (!pairs.is_empty()).then(|| [over(0), over(1)])
}

fn pairs(paper: Option<Pair>, best: Option<Pair>, name: &str) -> String {
    let number = |pair: Option<Pair>, c: usize| pair.map_or_else(|| "-".to_owned(), |p| format!("{:.3}", p[c]));
    let line = format!(
        "  | {:>5}  {:>5}  {:>6}  {:>6}  {name}",
        number(paper, 0),
        number(paper, 1),
        number(best, 0),
        number(best, 1)
    );
    line.trim_end().to_owned()
}
