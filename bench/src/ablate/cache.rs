//! Scores on disk, so that a long run can be broken off and taken up again.

use crate::measures::masks::MaskScores;
use crate::points::PointScores;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use tracecut::Params;
use tracecut_cli::failure::{Failure, Result, cannot_write, create_folder, read, write};
use tracecut_cli::provenance::sum;

/// A folder of scores, one file for each run of a clip.
#[derive(Debug)]
pub(super) struct Cache {
    folder: PathBuf,
    /// Hash of the program that computed the scores: another one may compute others.
    program: String,
}

/// The scores of a clip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Score {
    pub(super) masks: MaskScores,
    pub(super) points: PointScores,
}

impl Score {
    /// J, and the error of the points.
    pub(super) fn line(&self) -> String {
        let decimals = |value: Option<f64>, n: usize| value.map_or_else(|| "-".to_owned(), |v| format!("{v:.n$}"));
        let PointScores { error, region, fragments, objects, .. } = self.points;
        let (j, error, fragments) = (decimals(self.masks.j, 3), decimals(error, 2), decimals(fragments, 1));
        format!("{j} {error}/{region:.1}/{fragments}/{objects:.0}")
    }
}

/// The inputs that scores depend on.
#[derive(Debug, Serialize)]
pub(super) struct Key<'a> {
    pub(super) clip: &'a Path,
    pub(super) start: usize,
    pub(super) mirrored: bool,
    pub(super) frames: u32,
    pub(super) params: &'a Params,
}

/// The content of a file; the key is for people to read.
#[derive(Debug, Serialize, Deserialize)]
struct Entry {
    key: serde_json::Value,
    scores: Score,
}

impl Cache {
    pub(super) fn open(folder: &Path) -> Result<Self> {
        create_folder(folder)?;
        let program = std::env::current_exe().map_err(|e| Failure::new(format!("cannot find this program: {e}")))?;
        Ok(Self { folder: folder.to_owned(), program: format!("{:016x}", sum(&read(&program)?)) })
    }

    /// The scores under this key, if they are known.
    pub(super) fn get(&self, key: &Key<'_>) -> Result<Option<Score>> {
        let (path, key) = self.place(key)?;
        if !path.is_file() {
            return Ok(None);
        }
        let entry: Entry = serde_json::from_slice(&read(&path)?)
            .map_err(|e| Failure::about(path.display(), format_args!("is no entry of a cache (remove it): {e}")))?;
        Ok((entry.key == key).then_some(entry.scores))
    }

    /// Keeps scores. The file appears whole or not at all.
    pub(super) fn put(&self, key: &Key<'_>, scores: Score) -> Result<()> {
        let (path, key) = self.place(key)?;
        let text = serde_json::to_string(&Entry { key, scores }).map_err(|e| Failure::about(path.display(), e))?;
        let part = path.with_extension("part");
        write(&part, text + "\n")?;
        std::fs::rename(&part, &path).map_err(|e| cannot_write(&path, &e))
    }

    /// The file of a key, and the key with the program in it.
    fn place(&self, key: &Key<'_>) -> Result<(PathBuf, serde_json::Value)> {
        let fail = |e: serde_json::Error| Failure::about(self.folder.display(), e);
        let text = serde_json::to_string(&(&self.program, key)).map_err(fail)?;
        let name = format!("{:016x}.json", sum(text.as_bytes()));
        Ok((self.folder.join(name), serde_json::from_str(&text).map_err(fail)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scores_are_found_again_under_their_own_key_only() {
        let folder = std::env::temp_dir().join(format!("tracecut-cache-{}", std::process::id()));
        let cache = Cache::open(&folder).unwrap();
        let params = Params::default();
        let clip = Path::new("clip");
        let masks = MaskScores { j: Some(0.125), f: None, ..MaskScores::default() };
        let (error, fragments) = (Some(0.5), None);
        let points = PointScores { error, region: 3.0, fragments, objects: 1.0, true_objects: 2.0, best: None };
        let scores = Score { masks, points };
        fn key<'a>(clip: &'a Path, params: &'a Params) -> Key<'a> {
            Key { clip, start: 0, mirrored: false, frames: 5, params }
        }
        assert_eq!(cache.get(&key(clip, &params)).unwrap(), None);
        cache.put(&key(clip, &params), scores.clone()).unwrap();
        assert_eq!(cache.get(&key(clip, &params)).unwrap(), Some(scores));
        assert_eq!(cache.get(&Key { frames: 6, ..key(clip, &params) }).unwrap(), None);
        assert_eq!(cache.get(&Key { start: 6, ..key(clip, &params) }).unwrap(), None);
        assert_eq!(cache.get(&Key { mirrored: true, ..key(clip, &params) }).unwrap(), None);
        let other = Cache { program: String::new(), folder: folder.clone() };
        assert_eq!(other.get(&key(clip, &params)).unwrap(), None);
        let mut changed = params.clone();
        changed.clip.seed = 1;
        assert_eq!(cache.get(&key(clip, &changed)).unwrap(), None);
        std::fs::remove_dir_all(folder).unwrap();
    }
}
