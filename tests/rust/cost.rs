//! What small clips cost at worst. `TRACECUT_SEARCH=SIDExFRAMES cargo test --profile quick --test integration
//! cost -- --ignored --nocapture` goes through all parameters, to the ends of their ranges and on from the dearest, and prints what makes
//! clips slower; the ends that it found are the ones tested here. One frame is a single image.

use std::sync::OnceLock;
use std::time::{Duration, Instant};
use tracecut::image::{Frame, Plane};
use tracecut::params::{ParamField, ParamValue};
use tracecut::rng::Rng;
use tracecut::still::image_discontinuities;
use tracecut::superpixel::superpixels_of;
use tracecut::{Params, Session, Step};

/// Seconds of each part of some work.
type Spent = Vec<(&'static str, f64)>;

/// Processor time of this thread where the system tells it (Linux), else elapsed time.
fn seconds() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    // The system brings its account up to date when a thread gives way.
    std::thread::sleep(Duration::from_micros(10));
    let elapsed = START.get_or_init(Instant::now).elapsed().as_secs_f64();
    let schedule = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    schedule.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).map_or(elapsed, |ns| 1e-9 * ns)
}

const CONTENTS: [&str; 4] = ["noise", "texture", "disc", "flat"];

fn clip(content: &str, side: usize, count: usize) -> Vec<Frame> {
    (0..count)
        .map(|t| {
            let mut noise = Rng::for_stage(t as u64, "noise");
            let plane = Plane::from_fn(side, side, |x, y| {
                let (u, v) = (x as f64 - 1.3 * t as f64, y as f64 - 0.4 * t as f64);
                let texture = |u: f64, v: f64| ((u * 0.7).sin() * (v * 0.9).cos() * 100.0 + 128.0) as u8;
                let inside = (u - side as f64 / 3.0).hypot(v - side as f64 / 2.0) < side as f64 / 4.0;
                match content {
                    "noise" => noise.next_u64().to_le_bytes()[..3].try_into().unwrap(),
                    "texture" => [texture(u, v), texture(u, v).wrapping_add(40), 255 - texture(u, v)],
                    "disc" if inside => [texture(u * 1.7, v), 90, texture(v, u)],
                    "disc" => [texture(x as f64, y as f64), texture(y as f64, x as f64 * 0.5), 60],
                    _ => [90; 3],
                }
            });
            Frame::from_rgb(plane.data().iter().flatten().copied().collect(), side, side).unwrap()
        })
        .collect()
}

/// A whole run, or all that there is of a single image.
fn cost(frames: &[Frame], params: &Params) -> Spent {
    if let [frame] = frames {
        return of_image(frame, params);
    }
    let mut session = Session::new(params.clone()).unwrap();
    frames.iter().for_each(|frame| session.push_frame(frame.clone()).unwrap());
    let mut spent = Spent::new();
    loop {
        let begin = seconds();
        let Step::Working(progress) = session.step().unwrap() else { return spent };
        let (stage, took) = (progress.stage.name(), seconds() - begin);
        match spent.iter_mut().find(|(other, _)| *other == stage) {
            Some((_, sum)) => *sum += took,
            None => spent.push((stage, took)),
        }
    }
}

fn of_image(frame: &Frame, params: &Params) -> Spent {
    let begin = seconds();
    let _ = image_discontinuities(frame, &params.still, params.clip.seed);
    let between = seconds();
    let _ = superpixels_of(frame, Some(1), &params.contour, &params.superpixel);
    vec![("discontinuities", between - begin), ("superpixels", seconds() - between)]
}

fn total(spent: &Spent) -> f64 {
    spent.iter().map(|(_, s)| s).sum()
}

/// What costs most, first.
fn dearest(mut spent: Spent) -> String {
    spent.sort_by(|a, b| b.1.total_cmp(&a.1));
    spent.iter().take(4).map(|(stage, s)| format!(" {stage} {s:.2}")).collect()
}

fn with(settings: &[&str]) -> Params {
    let mut params = Params::default();
    for setting in settings.iter().flat_map(|list| list.split_whitespace()) {
        let (name, value) = setting.split_once('=').unwrap();
        let number = value.parse().map(ParamValue::Number);
        params.set(name, &number.unwrap_or_else(|_| ParamValue::Text(value.to_owned()))).unwrap();
    }
    params
}

/// Trajectories everywhere.
const MANY: &str = "trajectory.gridStep=3 trajectory.maskStep=2 trajectory.minLength=2 trajectory.maskMinLength=2 \
    trajectory.structureMean=0 trajectory.structureFloor=0";
/// Every pair has an affinity.
const DENSE: &str = "affinity.localRadius=1000 affinity.lambda=0.001 affinity.minOverlap=2 affinity.noiseFloor=10";
const VECTORS: &str = "embedding.maxDimensions=64 embedding.minDimensions=64 embedding.minComponent=1";
const FLOW: &str = "flow.patchStride=1 flow.fixedPoints=12";
const VOTES: &str = "cut.appearanceRounds=10 refine.band=64";
const MEANS: &str = "discretize.method=k-means";
const SALIENCY: &str = "saliency.bins=32";

#[test]
#[ignore = "processor time; part of npm run test:long"]
fn no_small_clip_takes_long_at_the_ends_of_the_ranges() {
    let ends: [&[&str]; 9] = [
        &[FLOW],
        &[MANY, VECTORS],
        &[MANY, DENSE],
        &[MANY, DENSE, VECTORS],
        &[MANY, VOTES],
        &[MANY, VECTORS, MEANS],
        &[MANY, SALIENCY],
        &[MANY, DENSE, VECTORS, FLOW, VOTES, SALIENCY],
        &[MANY, DENSE, VECTORS, FLOW, VOTES, MEANS, SALIENCY],
    ];
    for content in CONTENTS {
        let frames = clip(content, 99, 12);
        ends.iter().for_each(|settings| assert_quick(content, &frames, settings));
        let image = clip(content, 99, 1);
        for settings in ["still.radius=10 still.sigma=0.001", "still.radius=1"] {
            assert_quick(content, &image, &[settings, "still.dimensions=64"]);
        }
    }
}

/// Wide: a machine that is in use, a build without optimisation across crates.
fn assert_quick(content: &str, frames: &[Frame], settings: &[&str]) {
    let spent = cost(frames, &with(settings));
    let sum = total(&spent);
    let told = format!("{content}, {} frames: {sum:.2} s,{}; {}", frames.len(), dearest(spent), settings.join(" "));
    println!("{told}");
    assert!(sum < 30.0, "{told}");
}

/// The ends of the range, and a value between.
fn values(field: &ParamField) -> Vec<f64> {
    let (low, high) = (field.min, field.max);
    match field.kind() {
        "choice" => (0..field.choices().len()).map(|k| k as f64).collect(),
        "boolean" => vec![0.0, 1.0],
        kind => {
            let middle = if low > 0.0 { (low * high).sqrt() } else { (low + high) / 16.0 };
            vec![low, high, if kind == "integer" { middle.round() } else { middle }]
        }
    }
}

fn set(params: &mut Params, name: &str, value: f64) {
    let mut given = ParamValue::Number(value);
    params.for_each(&mut |field| match field.kind() {
        "boolean" if field.name == name => given = ParamValue::Bool(value != 0.0),
        "choice" if field.name == name => given = ParamValue::Text(field.choices()[value as usize].to_owned()),
        _ => {}
    });
    // A number that 32 bits round to more than the range allows is refused, and the old one stays.
    let _ = params.set(name, &given);
}

#[test]
#[ignore = "a search; does nothing unless it is asked for"]
fn search() {
    let Ok(size) = std::env::var("TRACECUT_SEARCH") else { return };
    let (side, count) = size.split_once('x').expect("TRACECUT_SEARCH=SIDExFRAMES");
    let mut all = Vec::new();
    Params::default().for_each(&mut |field| all.push((field.name.clone(), values(&field))));
    for content in CONTENTS {
        let frames = clip(content, side.parse().unwrap(), count.parse().unwrap());
        let mut best = Params::default();
        let mut most = total(&cost(&frames, &best));
        println!("{content}: {most:.2} s by default");
        for (name, value) in all.iter().flat_map(|(name, values)| values.iter().map(move |&v| (name, v))) {
            let mut tried = best.clone();
            set(&mut tried, name, value);
            let spent = cost(&frames, &tried);
            if total(&spent) > 1.03 * most + 0.005 {
                (most, best) = (total(&spent), tried);
                println!("  {most:.2} s with {name} = {value}:{}", dearest(spent));
            }
        }
    }
}
