//! Times of the frames in the results of `segment`.

use super::files::{WINDOWS, absent};
use super::*;
use image::{Delay, RgbaImage};
use serde_json::{Value, json as value};

/// Milliseconds that the pictures of the test's GIF are shown, over and over.
const DELAYS_MS: [u32; 5] = [40, 120, 50, 40, 300];
const PICTURES: usize = 26;

/// An animated GIF of the moving clip with uneven delays.
fn uneven_gif(name: &str) -> PathBuf {
    let file = folder(name).join("clip.gif");
    let mut encoder = image::codecs::gif::GifEncoder::new(fs::File::create(&file).unwrap());
    for t in 0..PICTURES {
        let rgba = rgb(SIZE.0, SIZE.1, &|x, y| moving(x, y, t as i32 % 20));
        let rgba = rgba.chunks(3).flat_map(|pixel| [pixel[0], pixel[1], pixel[2], 255]).collect();
        let picture = RgbaImage::from_raw(SIZE.0, SIZE.1, rgba).unwrap();
        let delay = Delay::from_numer_denom_ms(DELAYS_MS[t % DELAYS_MS.len()], 1);
        encoder.encode_frame(image::Frame::from_parts(picture, 0, 0, delay)).unwrap();
    }
    drop(encoder);
    file
}

/// Times and durations of the GIF's first pictures, in seconds.
fn expected(count: usize) -> (Vec<f64>, Vec<f64>) {
    let durations: Vec<u32> = (0..count).map(|t| DELAYS_MS[t % DELAYS_MS.len()]).collect();
    let times = (0..count).map(|t| f64::from(durations[..t].iter().sum::<u32>()) / 1000.0).collect();
    (times, durations.into_iter().map(|ms| f64::from(ms) / 1000.0).collect())
}

#[track_caller]
fn assert_near(seconds: &Value, expected: &[f64]) {
    let seconds: Vec<f64> = seconds.as_array().unwrap().iter().map(|s| s.as_f64().unwrap()).collect();
    let is_near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-6;
    assert!(seconds.len() == expected.len() && seconds.iter().zip(expected).all(is_near), "{seconds:?} {expected:?}");
}

/// The array of doubles in a file for NumPy.
fn doubles(npz: &Path, name: &str) -> Option<Value> {
    let mut zip = zip::ZipArchive::new(fs::File::open(npz).unwrap()).unwrap();
    let mut npy = Vec::new();
    std::io::Read::read_to_end(&mut zip.by_name(name).ok()?, &mut npy).unwrap();
    let header = 10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    let count = (npy.len() - header) / 8;
    let words = format!("'descr': '<f8', 'fortran_order': False, 'shape': ({count},), }}");
    assert!(text(&npy[..header]).contains(&words), "{}", text(&npy[..header]));
    let numbers = npy[header..].chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap()));
    Some(numbers.collect())
}

#[test]
fn times_of_the_file_are_in_every_form() {
    let (input, out) = (uneven_gif("times-in"), absent("times-out"));
    for (count, more) in [(PICTURES, &WINDOWS[..2]), (20, &["--frames", "20"])] {
        assert_done(&segment(&input, &out, &[&["--format", "rle,npz,prompts", "--overwrite"], more].concat()));
        let (times, durations) = expected(count);
        let report = json(&out.join("result.json"));
        assert_near(&report["times"], &times);
        assert_near(&report["durations"], &durations);
        assert_near(&value!([report["frameRate"]]), &[count as f64 / durations.iter().sum::<f64>()]);
        let coco = json(&out.join("masks.json"));
        assert_near(&coco["videos"][0]["frame_times"], &times);
        let stamps: Value = coco["images"].as_array().unwrap().iter().map(|image| image["timestamp"].clone()).collect();
        assert_near(&stamps, &times);
        assert_near(&json(&out.join("prompts.json"))["times"], &times);
        assert_near(&doubles(&out.join("masks.npz"), "times.npy").unwrap(), &times);
        assert_near(&doubles(&out.join("masks.npz"), "durations.npy").unwrap(), &durations);
        let table = fs::read_to_string(out.join("objects.csv")).unwrap();
        let rows: Vec<Vec<&str>> = table.lines().skip(1).map(|row| row.split(',').collect()).collect();
        assert!(rows.len() >= count, "{table}");
        for row in rows {
            let frame: usize = row[0].parse().unwrap();
            assert_near(&value!([row[1].parse::<f64>().unwrap()]), &times[frame..=frame]);
        }
    }
}

#[test]
fn frames_without_times_get_none() {
    let (input, out) = moving_clip("timeless", 4);
    assert_done(&segment(&input, &out, &["--format", "rle,npz,prompts"]));
    let report = json(&out.join("result.json"));
    for name in ["times", "durations", "frameRate"] {
        assert_eq!(report.get(name), None);
    }
    let coco = json(&out.join("masks.json"));
    assert_eq!((coco["videos"][0].get("frame_times"), coco["images"][0].get("timestamp")), (None, None));
    assert_eq!(json(&out.join("prompts.json")).get("times"), None);
    assert_eq!(doubles(&out.join("masks.npz"), "times.npy"), None);
    assert!(fs::read_to_string(out.join("objects.csv")).unwrap().contains("\n0,,1,"));
}
