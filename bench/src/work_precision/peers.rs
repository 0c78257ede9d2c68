//! Measurements of other engines: rows that the programs under `bench/peers` wrote, see `bench/README.md`.

use forcec_runtime::prelude::Vec3;
use std::path::Path;

/// A run of a peer.
#[derive(Clone, Debug)]
pub struct Row {
    /// The engine.
    pub engine: String,
    /// Its version.
    pub version: String,
    /// How it was set.
    pub setting: String,
    /// The scene.
    pub scene: String,
    /// The step, s.
    pub h: f64,
    /// Time of a step, s.
    pub step: f64,
    /// The largest change of energy, J; NaN where it is not judged.
    pub drift: f64,
    /// Where the bodies of the first copy end, m; none where energy is judged.
    pub positions: Vec<Vec3>,
}

impl Row {
    /// Whether the others are counted from it.
    pub fn is_reference(&self) -> bool {
        self.setting == "reference"
    }
}

/// All rows of all files in a folder, in the order of their names.
pub fn read(folder: &Path) -> Result<Vec<Row>, String> {
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    let entries: Result<Vec<_>, _> = std::fs::read_dir(folder).map_err(failed)?.collect();
    let mut paths: Vec<_> = entries.map_err(failed)?.iter().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|ending| ending == "csv"));
    paths.sort();
    let mut rows = Vec::new();
    for path in paths {
        let text = std::fs::read_to_string(&path).map_err(failed)?;
        for line in text.lines().skip(1) {
            rows.push(row(line).ok_or_else(|| format!("{}: no row: {line}", path.display()))?);
        }
    }
    Ok(rows)
}

fn row(line: &str) -> Option<Row> {
    let fields: Vec<&str> = line.split(',').collect();
    let [engine, version, setting, scene, h, micros, drift, positions] = fields[..] else { return None };
    let numbers: Vec<f64> = positions.split_whitespace().map(|x| x.parse().ok()).collect::<Option<_>>()?;
    Some(Row {
        engine: engine.to_owned(),
        version: version.to_owned(),
        setting: setting.to_owned(),
        scene: scene.to_owned(),
        h: h.parse().ok()?,
        step: micros.parse::<f64>().ok()? * 1e-6,
        drift: if drift.is_empty() { f64::NAN } else { drift.parse().ok()? },
        positions: numbers.chunks_exact(3).map(Vec3::from_column_slice).collect(),
    })
}

/// The engines with their versions.
pub fn versions(rows: &[Row]) -> Vec<String> {
    crate::machine::versions(rows.iter().map(|row| (row.engine.as_str(), row.version.as_str())))
}
