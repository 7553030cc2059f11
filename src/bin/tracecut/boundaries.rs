//! `tracecut boundaries`: boundary probability of one image.

use crate::clock::Clock;
use crate::failure::{Failure, Result, cannot_write, create_folder, print};
use crate::input::decode;
use crate::settings::Settings;
use clap::Args;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use tracecut::contour::boundary_map;
use tracecut::image::Plane;

#[derive(Args, Debug)]
pub(crate) struct BoundariesArgs {
    /// Image: PNG, JPEG or PPM
    image: PathBuf,
    /// Where to write: a file ending in .png takes the thin map; a folder takes pb.png and thin.png
    #[arg(long, value_name = "DIR|FILE")]
    out: PathBuf,
    /// Runs; the fastest counts
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    #[command(flatten)]
    settings: Settings,
}

/// Writes probabilities 0 to 1 as grey values 0 to 255.
pub(crate) fn boundaries(args: &BoundariesArgs) -> Result<()> {
    let params = args.settings.params()?;
    let (_, frame) = decode(&args.image)?;
    let mut fastest = f64::INFINITY;
    let mut map = Default::default();
    for _ in 0..args.repeat {
        let clock = Clock::start();
        map = boundary_map(&frame, None, &params.contour);
        fastest = fastest.min(1000.0 * clock.seconds().best());
    }
    if args.out.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        write_grey(&args.out, &map.thin)?;
    } else {
        create_folder(&args.out)?;
        write_grey(&args.out.join("pb.png"), &map.pb)?;
        write_grey(&args.out.join("thin.png"), &map.thin)?;
    }
    print(format_args!("{}x{} pixels, {fastest:.1} ms", frame.width(), frame.height()))
}

fn write_grey(path: &Path, plane: &Plane<f32>) -> Result<()> {
    let grey: Vec<u8> = plane.data().iter().map(|v| (255.0 * v + 0.5) as u8).collect();
    let file = File::create(path).map_err(|e| cannot_write(path, &e))?;
    PngEncoder::new(BufWriter::new(file))
        .write_image(&grey, plane.width() as u32, plane.height() as u32, ExtendedColorType::L8)
        .map_err(|e| Failure::about(path.display(), format_args!("cannot be written: {e}")))
}
