//! `tracecut boundaries`: boundary probability of one image, and the discontinuities of its pixel embedding.

use crate::clock::Clock;
use crate::failure::{Result, create_folder, print};
use crate::input::decode_within;
use crate::pictures::write_png;
use crate::settings::Settings;
use clap::Args;
use image::ExtendedColorType;
use std::path::{Path, PathBuf};
use tracecut::contour::boundary_map;
use tracecut::image::Plane;
use tracecut::still::image_discontinuities;

#[derive(Args, Debug)]
pub(crate) struct BoundariesArgs {
    /// Image: PNG, JPEG or PPM
    image: PathBuf,
    /// Where to write: a file ending in .png takes the thin map (with --embedding the combined one); a folder takes
    /// pb.png and thin.png, with --embedding also discontinuity.png, spectral.png, combined.png and combined_thin.png
    #[arg(long, value_name = "DIR|FILE")]
    out: PathBuf,
    /// Add the discontinuities of the pixel embedding, the gradients of its eigenvectors, and Pb with the
    /// discontinuities
    #[arg(long)]
    embedding: bool,
    /// Runs; the fastest counts
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    #[command(flatten)]
    settings: Settings,
}

/// Writes probabilities 0 to 1 as grey values 0 to 255.
pub(crate) fn boundaries(args: &BoundariesArgs) -> Result<()> {
    let params = args.settings.params()?;
    let frame = decode_within(&args.image, params.clip.max_pixels as usize)?;
    let mut fastest = f64::INFINITY;
    let (mut map, mut found) = Default::default();
    for _ in 0..args.repeat {
        let clock = Clock::start();
        if args.embedding {
            found = image_discontinuities(&frame, &params.still, params.clip.seed);
            map = found.pb.clone();
        } else {
            map = boundary_map(&frame);
        }
        fastest = fastest.min(1000.0 * clock.seconds().best());
    }
    let one_file = args.out.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if one_file {
        write_grey(&args.out, if args.embedding { &found.combined.thin } else { &map.thin })?;
    } else {
        create_folder(&args.out)?;
        let mut maps = vec![("pb", &map.pb), ("thin", &map.thin)];
        if args.embedding {
            maps.extend([("discontinuity", &found.d.strength), ("spectral", &found.spectral.strength)]);
            maps.extend([("combined", &found.combined.pb), ("combined_thin", &found.combined.thin)]);
        }
        for (name, plane) in maps {
            write_grey(&args.out.join(name).with_extension("png"), plane)?;
        }
    }
    print(format_args!("{}x{} pixels, {fastest:.1} ms", map.pb.width(), map.pb.height()))
}

fn write_grey(path: &Path, plane: &Plane<f32>) -> Result<()> {
    let grey: Vec<u8> = plane.data().iter().map(|v| (255.0 * v + 0.5) as u8).collect();
    write_png(path, &grey, (plane.width(), plane.height()), ExtendedColorType::L8)
}
