//! `--dump`: the numbers between the stages as text, for checking against other programs.

use crate::failure::{Result, cannot_write, create_folder};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use tracecut::Session;
use tracecut::discontinuity::Discontinuities;
use tracecut::embedding::Embedding;
use tracecut::saliency::Saliency;
use tracecut::sparse::SymCsr;

type Lines<'a> = &'a mut dyn Write;

/// Writes the available files among `affinity.mtx`, `eigenvalues.txt`, `eigenvectors.txt`, `neighbours.txt`,
/// `saliency.txt`.
pub(crate) fn write_all(folder: &Path, session: &Session) -> Result<()> {
    create_folder(folder)?;
    if let Some(affinities) = session.affinities() {
        write_lines(&folder.join("affinity.mtx"), |out| write_affinities(out, affinities))?;
    }
    if let Some(embedding) = session.embedding() {
        write_lines(&folder.join("eigenvalues.txt"), |out| write_rows(out, &embedding.eigenvalues, 1))?;
        write_lines(&folder.join("eigenvectors.txt"), |out| write_vectors(out, embedding))?;
    }
    if let Some(discontinuities) = session.discontinuities() {
        write_lines(&folder.join("neighbours.txt"), |out| write_neighbours(out, discontinuities))?;
    }
    if let Some(saliency) = session.saliency() {
        write_lines(&folder.join("saliency.txt"), |out| write_saliency(out, saliency))?;
    }
    Ok(())
}

fn write_lines(path: &Path, lines: impl FnOnce(Lines<'_>) -> std::io::Result<()>) -> Result<()> {
    let write = || {
        let mut out = BufWriter::new(File::create(path)?);
        lines(&mut out)?;
        out.flush()
    };
    write().map_err(|e| cannot_write(path, &e))
}

/// `N = D^-1/2 A D^-1/2` in MatrixMarket form: the lower triangle, counted from 1. It has the eigenvalues of `P = D^-1
/// A`.
fn write_affinities(out: Lines<'_>, affinities: &SymCsr) -> std::io::Result<()> {
    let n = affinities.len();
    let root: Vec<f64> = affinities.degrees().iter().map(|d| d.sqrt()).collect();
    let lower = |i: usize| affinities.row(i).filter(move |&(j, _)| j <= i);
    let count: usize = (0..n).map(|i| lower(i).count()).sum();
    writeln!(out, "%%MatrixMarket matrix coordinate real symmetric\n{n} {n} {count}")?;
    for i in 0..n {
        for (j, w) in lower(i) {
            let scale = root[i] * root[j];
            let value = if scale > 0.0 { w / scale } else { 0.0 };
            writeln!(out, "{} {} {value:.16e}", i + 1, j + 1)?;
        }
    }
    Ok(())
}

/// One row for each trajectory: its coordinates in the embedding, the rows of `V`.
fn write_vectors(out: Lines<'_>, embedding: &Embedding) -> std::io::Result<()> {
    write_rows(out, &embedding.vectors, embedding.dimensions)
}

fn write_rows(out: Lines<'_>, values: &[f64], columns: usize) -> std::io::Result<()> {
    for row in values.chunks_exact(columns.max(1)) {
        let columns: Vec<String> = row.iter().map(|v| format!("{v:.16e}")).collect();
        writeln!(out, "{}", columns.join(" "))?;
    }
    Ok(())
}

/// One line for each pair of neighbours: `i j affinity d`, trajectories counted from 0 as in `tracks.dat`.
fn write_neighbours(out: Lines<'_>, discontinuities: &Discontinuities) -> std::io::Result<()> {
    for ((&(i, j), w), d) in
        discontinuities.neighborhoods.pairs.iter().zip(&discontinuities.affinity).zip(&discontinuities.d)
    {
        writeln!(out, "{i} {j} {w:.16e} {d:.16e}")?;
    }
    Ok(())
}

/// One line for each trajectory: its saliency, its saliency in the context of the embedding, and 1 for foreground.
fn write_saliency(out: Lines<'_>, saliency: &Saliency) -> std::io::Result<()> {
    for ((of_points, in_context), &foreground) in
        saliency.of_points.iter().zip(&saliency.in_context).zip(&saliency.foreground)
    {
        writeln!(out, "{of_points} {in_context} {}", u8::from(foreground))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn affinities_are_normalised_and_only_the_lower_triangle_is_written() {
        let affinities = SymCsr::from_upper(4, &[(0, 1, 1.0), (1, 2, 3.0)]);
        let mut out = Vec::new();
        write_affinities(&mut out, &affinities).unwrap();
        let text = String::from_utf8(out).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "4 4 2");
        // Degrees 1, 4, 3, 0.
        assert_eq!(lines[2], "2 1 5.0000000000000000e-1");
        let value: f64 = lines[3].strip_prefix("3 2 ").unwrap().parse().unwrap();
        assert!((value - 0.75_f64.sqrt()).abs() < 1e-15, "{}", lines[3]);
        assert_eq!(lines.len(), 4);
    }
}
