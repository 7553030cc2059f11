//! Invariants of every result, whatever the input. Readers of files: any bytes give an error or a valid value, which is the same
//! after writing and reading.

use std::collections::BTreeMap;
use tracecut::connectedness::Components;
use tracecut::contour::BoundaryMap;
use tracecut::discontinuity::Discontinuities;
use tracecut::discretize::Clusters;
use tracecut::embedding::Embedding;
use tracecut::image::{Frame, Plane};
use tracecut::mask::Objects;
use tracecut::params::ParamValue;
use tracecut::superpixel::Superpixels;
use tracecut::{Error, Params, Session, tracks};

/// Codes of the errors that any call may return.
const CODES: [&str; 7] = ["too-few-frames", "frame-size", "frame-size-changed", "param", "data", "state", "too-large"];

/// Returns the value; fails the test unless an error has a documented code.
pub fn allowed<T>(outcome: Result<T, Error>) -> Option<T> {
    match outcome {
        Ok(value) => Some(value),
        Err(error) => {
            assert!(CODES.contains(&error.code()), "{error}");
            None
        }
    }
}

fn all_in(values: &[f32], range: std::ops::RangeInclusive<f32>, what: &str) {
    if let Some(value) = values.iter().find(|value| !range.contains(value)) {
        panic!("{what}: {value} is not in {range:?}");
    }
}

fn all_finite(values: &[f64], what: &str) {
    assert!(values.iter().all(|value| value.is_finite()), "{what} is not finite");
}

/// Checks everything that a session returns.
pub fn check_session(session: &Session) {
    check_spectral(session);
    let known: Vec<u8> = session.objects().map_or(Vec::new(), Objects::labels);
    if let (Some(objects), Some(clusters)) = (session.objects(), session.clusters()) {
        assert_eq!(objects.of_cluster.len(), clusters.count);
        assert!(known.iter().all(|&label| usize::from(label) <= objects.highest_label));
    }
    if let Some(agreement) = session.agreement() {
        for values in agreement.objects.iter().chain([&agreement.frames]) {
            assert_eq!(values.len(), session.num_frames());
            all_in(&values.iter().flatten().copied().collect::<Vec<_>>(), 0.0..=1.0, "agreement");
        }
    }
    for t in 0..session.num_frames() {
        check_frame(session, t, &known);
    }
}

fn check_spectral(session: &Session) {
    let Some(tracks) = session.trajectories() else { return };
    tracks.check().unwrap();
    if let Some(tracks) = session.mask_trajectories() {
        tracks.check().unwrap();
    }
    if let Some(affinities) = session.affinities() {
        affinities.check().unwrap();
    }
    if let Some(embedding) = session.embedding() {
        check_embedding(embedding, tracks.len());
    }
    if let Some(found) = session.discontinuities() {
        check_discontinuities(found, tracks.len());
    }
    if let Some(saliency) = session.saliency() {
        all_in(&saliency.of_points, 0.0..=1.0, "saliency of points");
        all_in(&saliency.in_context, 0.0..=1.0, "saliency in context");
        assert_eq!((saliency.of_points.len(), saliency.in_context.len()), (tracks.len(), tracks.len()));
    }
    if let Some(components) = session.components() {
        assert_eq!(components.of_point.len(), tracks.x.len());
        check_components(components);
    }
    if let Some(clusters) = session.clusters() {
        check_clusters(clusters, tracks.len());
        if let Some(others) = session.threshold_clusters() {
            check_clusters(&others, tracks.len());
        }
    }
}

fn check_embedding(embedding: &Embedding, num_tracks: usize) {
    let Embedding { num_rows, dimensions, eigenvalues, vectors, embedded, .. } = embedding;
    assert_eq!((*num_rows, embedded.len(), vectors.len()), (num_tracks, num_tracks, num_rows * dimensions));
    assert_eq!(eigenvalues.len(), *dimensions);
    all_finite(eigenvalues, "an eigenvalue");
    all_finite(vectors, "an eigenvector");
    assert!(eigenvalues.is_sorted_by(|a, b| a >= b) && eigenvalues.iter().all(|l| l.abs() < 1.0 + 1e-6));
    let is_zero = (0..*num_rows).all(|i| embedded[i] || embedding.row(i).iter().all(|&v| v == 0.0));
    assert!(is_zero, "a trajectory that is not embedded has coordinates");
}

fn check_discontinuities(found: &Discontinuities, num_tracks: usize) {
    let pairs = &found.neighborhoods.pairs;
    assert!(pairs.is_sorted_by(|a, b| a < b) && pairs.iter().all(|&(i, j)| i < j && (j as usize) < num_tracks));
    assert_eq!((found.d.len(), found.affinity.len()), (pairs.len(), pairs.len()));
    assert!(found.d.iter().all(|d| (0.0..=1.0).contains(d)), "a discontinuity is not in 0..=1");
    all_finite(&found.affinity, "an affinity");
    all_finite(&found.density, "a density");
    let edges = &found.neighborhoods.frame_edges;
    assert!(edges.iter().all(|&edge| (edge as usize) < pairs.len()));
}

fn check_components(components: &Components) {
    let most = components.count.iter().copied().max().unwrap_or(0);
    assert!(components.of_point.iter().flatten().all(|&component| component < most));
}

fn check_clusters(clusters: &Clusters, num_tracks: usize) {
    assert_eq!(clusters.label.len(), num_tracks);
    let mut used = vec![false; clusters.count];
    clusters.label.iter().for_each(|&label| used[label as usize] = true);
    assert!(used.iter().all(|&used| used), "a cluster without trajectories");
}

/// Checks the results of frame `t`; `known` are the labels of the objects.
fn check_frame(session: &Session, t: usize, known: &[u8]) {
    let size = session.input_size().unwrap();
    if let Some(field) = allowed(session.flow(t)) {
        assert!(field.u.data().iter().chain(field.v.data()).all(|v| v.is_finite()), "flow is not finite");
    }
    if let Some(map) = allowed(session.saliency_map(t)) {
        all_in(map.data(), 0.0..=1.0, "a saliency map");
    }
    if let Some(map) = allowed(session.boundaries(t)) {
        check_boundaries(&map);
    }
    if let Some(superpixels) = allowed(session.superpixels(t)) {
        check_superpixels(superpixels);
    }
    if let Some(plate) = allowed(session.background(t)) {
        assert!(plate.data().iter().all(|pixel| pixel[3] == 0 || pixel[3] == 255));
    }
    if let Some(mask) = allowed(session.labels(t)) {
        check_mask(session, t, &mask, known, size);
    }
}

fn check_mask(session: &Session, t: usize, mask: &Plane<u8>, known: &[u8], (width, height): (usize, usize)) {
    assert_eq!((mask.width(), mask.height()), (width, height));
    assert!(mask.data().iter().all(|label| *label == 0 || known.contains(label)), "{known:?}");
    if let (Some(clusters), Some(objects)) = (allowed(session.cluster_labels(t)), session.objects()) {
        let label_of = |&cluster: &u32| objects.of_cluster.get(cluster as usize).copied().unwrap_or(0);
        assert!(clusters.data().iter().map(label_of).eq(mask.data().iter().copied()), "clusters and masks disagree");
    }
    if let Some(why) = allowed(session.explain(t, (width / 2, height / 2))) {
        assert_eq!(why.label, mask[(width / 2, height / 2)]);
        assert!(why.evidence.background.is_finite() && why.evidence.looks.is_finite());
    }
}

/// Checks a boundary map.
pub fn check_boundaries(map: &BoundaryMap) {
    all_in(map.pb.data(), 0.0..=1.0, "pb");
    assert_eq!(map.pb.data().len(), map.thin.data().len());
    assert!(map.pb.data().iter().zip(map.thin.data()).all(|(pb, thin)| (0.0..=*pb).contains(thin)), "thin above pb");
}

/// Checks superpixels.
pub fn check_superpixels(found: &Superpixels) {
    let mut next = 0;
    for &label in found.label().data() {
        assert!(label <= next, "label {label} before {next}");
        next += u32::from(label == next);
    }
    assert_eq!(next as usize, found.count, "a label is missing");
    assert!(found.borders.is_sorted_by(|a, b| (a.a, a.b) < (b.a, b.b)));
    for border in &found.borders {
        assert!(border.a < border.b && (border.b as usize) < found.count);
        assert!(border.length >= 0.0 && (0.0..=1.0).contains(&border.pb), "{border:?}");
    }
}

/// An image file: PNG, JPEG or PPM.
pub fn image_file(bytes: &[u8]) {
    match Frame::decode(bytes) {
        Ok(frame) => assert_eq!(frame.rgb().len(), 3 * frame.width() * frame.height()),
        Err(error) => assert!(["decode", "frame-size", "too-large"].contains(&error.code()), "{error}"),
    }
}

/// A `tracks.dat`. Coordinates are written with three decimals, so what was written once stays the same.
pub fn tracks_dat(bytes: &[u8]) {
    let Ok((found, clusters)) = tracks::parse(&String::from_utf8_lossy(bytes)) else { return };
    found.check().unwrap();
    let text = tracks::write(&found, &clusters).unwrap();
    let (again, same) = tracks::parse(&text).unwrap();
    assert_eq!(same, clusters);
    assert_eq!(again.start_frame, found.start_frame);
    assert_eq!(tracks::write(&again, &same).unwrap(), text);
}

/// Parameters from JSON. What was taken is legal, and gives the same again.
pub fn parameters(bytes: &[u8]) {
    let Ok(tree) = serde_json::from_slice::<BTreeMap<String, ParamValue>>(bytes) else { return };
    let mut params = Params::default();
    if let Err(error) = params.apply(&tree) {
        assert_eq!(error.code(), "param");
        assert_eq!(params, Params::default(), "refused parameters changed others");
        return;
    }
    params.validate().unwrap();
    let mut again = Params::default();
    again.apply(&serde_json::from_str(&serde_json::to_string(&params).unwrap()).unwrap()).unwrap();
    assert_eq!(again, params);
}
