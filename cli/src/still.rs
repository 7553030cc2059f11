//! `tracecut boundaries` and `tracecut superpixels`: results of single images.

use crate::failure::{Failure, Result, create_folder, print};
use crate::input::decode_within;
use crate::pictures::write_png;
use crate::run::Clock;
use crate::settings::Settings;
use clap::Args;
use image::ExtendedColorType;
use std::path::{Path, PathBuf};
use tracecut::contour::boundary_map;
use tracecut::image::{Frame, Plane};
use tracecut::still::image_discontinuities;
use tracecut::superpixel::{Edge, EdgeKind, Superpixels, superpixels_of};

#[derive(Args, Debug)]
pub(crate) struct BoundariesArgs {
    /// Image: PNG, JPEG or PPM
    image: PathBuf,
    /// Output: a file ending in .png for the thin map (with --embedding the combined one); a folder for
    /// pb.png and thin.png, with --embedding also discontinuity.png, spectral.png, combined.png and combined_thin.png
    #[arg(long, value_name = "DIR|FILE")]
    out: PathBuf,
    /// Add the discontinuities of the pixel embedding, the gradients of its eigenvectors, and Pb with the
    /// discontinuities
    #[arg(long)]
    embedding: bool,
    /// Number of runs; the time of the fastest is printed
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    repeat: u32,
    #[command(flatten)]
    settings: Settings,
}

/// Writes probabilities 0 to 1 as grey values 0 to 255.
pub(crate) fn boundaries(args: &BoundariesArgs) -> Result<()> {
    let params = args.settings.params_of(&["still.", "clip.maxPixels", "clip.seed"])?;
    let frame = decode_within(&args.image, params.clip.max_pixels as usize)?;
    let mut fastest = f64::INFINITY;
    let (mut map, mut discontinuities) = Default::default();
    for _ in 0..args.repeat {
        let clock = Clock::start();
        if args.embedding {
            discontinuities = image_discontinuities(&frame, &params.still, params.clip.seed);
            map = discontinuities.pb.clone();
        } else {
            map = boundary_map(&frame);
        }
        fastest = fastest.min(1000.0 * clock.seconds().best());
    }
    let one_file = args.out.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if one_file {
        write_grey(&args.out, if args.embedding { &discontinuities.combined.thin } else { &map.thin })?;
    } else {
        create_folder(&args.out)?;
        let mut maps = vec![("pb", &map.pb), ("thin", &map.thin)];
        if args.embedding {
            maps.extend([
                ("discontinuity", &discontinuities.d.strength),
                ("spectral", &discontinuities.spectral.strength),
            ]);
            maps.extend([
                ("combined", &discontinuities.combined.pb),
                ("combined_thin", &discontinuities.combined.thin),
            ]);
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

/// Pictures are enlarged by an integer factor up to about this side, so that lines do not hide the image; chosen by eye.
const PICTURE_SIDE_PX: usize = 1280;
/// Colour of contours, as in Figure 8 of the paper.
const CONTOUR: [u8; 3] = [255, 40, 40];
/// Colour of Gabriel edges, as in Figure 8 of the paper.
const BRIDGE: [u8; 3] = [60, 230, 60];

#[derive(Args, Debug)]
pub(crate) struct SuperpixelArgs {
    /// Image: PNG, JPEG or PPM
    image: PathBuf,
    /// Folder for NAME_superpixels.png, a 16-bit grey PNG with the number of each pixel's superpixel, and
    /// NAME_edges.png, the image with contours red and the Gabriel edges that bridge their gaps green
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Number of superpixels; by default that of the contours above the thresholds
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    count: Option<u16>,
    #[command(flatten)]
    settings: Settings,
}

pub(crate) fn superpixels(args: &SuperpixelArgs) -> Result<()> {
    let params = args.settings.params_of(&["contour.", "superpixel.", "clip.maxPixels"])?;
    let frame = decode_within(&args.image, params.clip.max_pixels as usize)?;
    let superpixels = superpixels_of(&frame, args.count.map(usize::from), &params.contour, &params.superpixel);
    create_folder(&args.out)?;
    let stem = args.image.file_stem().unwrap_or_default().to_string_lossy();
    write_labels(&args.out.join(format!("{stem}_superpixels.png")), &superpixels)?;
    let (picture, width, height) = draw(&frame, &superpixels.edges);
    write_png(&args.out.join(format!("{stem}_edges.png")), &picture, (width, height), ExtendedColorType::Rgb8)?;
    print(format_args!("{} superpixels", superpixels.count))
}

fn write_labels(path: &Path, superpixels: &Superpixels) -> Result<()> {
    if superpixels.count > 1 << 16 {
        let reason = format!("cannot hold {} superpixels (expected at most 65536, see --count)", superpixels.count);
        return Err(Failure::about(path.display(), reason));
    }
    let label = superpixels.label();
    let bytes: Vec<u8> = label.data().iter().flat_map(|&l| (l as u16).to_ne_bytes()).collect();
    write_png(path, &bytes, (label.width(), label.height()), ExtendedColorType::L16)
}

/// Draws the edges over the enlarged image; returns RGB, width and height.
fn draw(frame: &Frame, edges: &[Edge]) -> (Vec<u8>, usize, usize) {
    let scale = (PICTURE_SIDE_PX / frame.width().max(frame.height())).max(1);
    let (width, height) = (frame.width() * scale, frame.height() * scale);
    let pixel = |i: usize| {
        let (x, y) = (i % width / scale, i / width / scale);
        let at = 3 * (y * frame.width() + x);
        [frame.rgb()[at], frame.rgb()[at + 1], frame.rgb()[at + 2]]
    };
    let mut picture = Plane::from_fn(width, height, |x, y| pixel(y * width + x));
    // Contours last, to cover bridges.
    for (kind, colour) in [(EdgeKind::Gabriel, BRIDGE), (EdgeKind::Constraint, CONTOUR)] {
        for edge in edges.iter().filter(|e| e.kind == kind) {
            line(&mut picture, edge, scale as f32, colour);
        }
    }
    (picture.into_data().into_flattened(), width, height)
}

fn line(picture: &mut Plane<[u8; 3]>, edge: &Edge, scale: f32, colour: [u8; 3]) {
    let place = |v: f32| (v + 0.5) * scale;
    let (x0, y0, x1, y1) = (place(edge.from.0), place(edge.from.1), place(edge.to.0), place(edge.to.1));
    let steps = ((x1 - x0).abs().max((y1 - y0).abs()) as usize).max(1);
    for k in 0..=steps {
        let share = k as f32 / steps as f32;
        let x = ((x0 + share * (x1 - x0)) as usize).min(picture.width() - 1);
        let y = ((y0 + share * (y1 - y0)) as usize).min(picture.height() - 1);
        picture[(x, y)] = colour;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contours_are_drawn_over_bridges_and_deleted_edges_not_at_all() {
        let frame = Frame::from_rgb(vec![9; 3 * 8 * 8], 8, 8).unwrap();
        let edge = |from, to, kind| Edge { from, to, kind };
        let edges = [
            edge((-0.5, 4.0), (7.5, 4.0), EdgeKind::Constraint),
            edge((4.0, -0.5), (4.0, 7.5), EdgeKind::Gabriel),
            edge((2.0, -0.5), (2.0, 7.5), EdgeKind::Deleted),
        ];
        let (picture, width, height) = draw(&frame, &edges);
        assert_eq!((width, height), (1280, 1280));
        let at = |x: usize, y: usize| &picture[3 * (y * width + x)..][..3];
        assert_eq!((at(720, 720), at(720, 300), at(400, 300)), (&CONTOUR[..], &BRIDGE[..], &[9; 3][..]));
    }
}
