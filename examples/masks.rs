//! Writes masks of a clip's moving objects: `cargo run --locked --release --example masks -- FRAMES OUT`.
//!
//! `FRAMES` is a folder of PNG or JPEG files, taken in name order; `-` stands for a synthetic clip. `OUT` gets a grey
//! PNG file for each frame: black is the background, each object has its own grey.

use image::GrayImage;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs};
use tracecut::synth::Scene;
use tracecut::{Params, Session};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<_> = env::args().skip(1).collect();
    let [input, output] = arguments.as_slice() else {
        return Err("expected two folders: frames (or -) and masks".into());
    };

    let mut session = Session::new(Params::default())?;
    if input == "-" {
        let scene = Scene::sample((256, 144), 10, 1);
        for t in 0..scene.num_frames() {
            session.push_frame(scene.frame(t))?;
        }
    } else {
        for file in images_in(Path::new(input))? {
            session.push_encoded(&fs::read(file)?)?;
        }
    }
    session.run()?;

    let objects = session.objects().map_or(0, |objects| objects.highest_label);
    println!("{objects} objects in {} frames", session.num_frames());
    fs::create_dir_all(output)?;
    let step = 255 / objects.max(1);
    for t in 0..session.num_frames() {
        let mask = session.labels(t)?;
        let (width, height) = (mask.width() as u32, mask.height() as u32);
        let picture = GrayImage::from_fn(width, height, |x, y| {
            let label = usize::from(mask[(x as usize, y as usize)]);
            [(label * step) as u8].into()
        });
        picture.save(Path::new(output).join(format!("{t:05}.png")))?;
    }
    Ok(())
}

fn images_in(folder: &Path) -> Result<Vec<PathBuf>, std::io::Error> {
    let mut files = fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>, std::io::Error>>()?;
    files.retain(|file| {
        let kind = file.extension().and_then(|kind| kind.to_str()).unwrap_or_default().to_lowercase();
        ["png", "jpg", "jpeg"].contains(&kind.as_str())
    });
    files.sort();
    Ok(files)
}
