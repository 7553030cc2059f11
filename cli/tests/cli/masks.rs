//! What `segment` writes of the masks.

use super::files::absent;
use super::*;
use std::collections::BTreeSet;
use tracecut::discretize::Clusters;
use tracecut::image::{Frame, Plane};
use tracecut::mask::enlarge;
use tracecut::trajectory::Trajectories;
use tracecut::{Params, Session};

/// Labels and palette of a palette PNG, as they stand in the file.
fn read_mask(path: &Path) -> (Plane<u8>, Vec<u8>) {
    let decoder = png::Decoder::new(std::io::BufReader::new(fs::File::open(path).unwrap()));
    let mut reader = decoder.read_info().unwrap();
    let info = reader.info();
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Indexed, png::BitDepth::Eight));
    let (width, height) = (info.width as usize, info.height as usize);
    let palette = info.palette.clone().unwrap().into_owned();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut data).unwrap();
    (Plane::from_vec(width, height, data).unwrap(), palette)
}

/// Frame `t` of a picture that moves.
fn frame(t: i32, picture: &dyn Fn(i32, i32, i32) -> u8) -> Frame {
    Frame::from_rgb(rgb(SIZE.0, SIZE.1, &|x, y| picture(x, y, t)), SIZE.0 as usize, SIZE.1 as usize).unwrap()
}

/// The first `frames` frames of a picture that moves through the library.
fn session_with(params: Params, frames: i32, picture: &dyn Fn(i32, i32, i32) -> u8) -> Session {
    let mut session = Session::new(params).unwrap();
    (0..frames).for_each(|t| session.push_frame(frame(t, picture)).unwrap());
    session.run().unwrap();
    session
}

fn session(frames: i32) -> Session {
    session_with(Params::default(), frames, &moving)
}

#[test]
fn masks_of_reduced_frames_have_the_size_of_the_frames_and_their_borders() {
    let (input, out) = moving_clip("masks-source", FRAMES);
    assert_done(&segment(&input, &out, &["--set", "clip.maxSide=112", "--format", "png,tracks,overlay"]));
    let mut params = Params::default();
    params.clip.max_side = 112;
    let session = session_with(params, FRAMES, &moving);
    let mut others = 0;
    for t in 0..FRAMES {
        let (mask, _) = read_mask(&out.join(format!("masks/{t:05}.png")));
        let small = session.working_labels(t as usize).unwrap();
        assert_eq!(small.width(), 112);
        assert_eq!(mask, enlarge(small, &frame(t, &moving), |_| true).unwrap().labels, "frame {t}");
        others += usize::from(mask != session.labels(t as usize).unwrap());
    }
    assert!(others > 0, "every mask equals the mask of the nearest pixels");
    assert!(out.join("overlay-masks/00000.png").is_file());
}

#[test]
fn masks_are_palette_images_of_the_sessions_labels() {
    let (input, out) = moving_clip("masks", FRAMES);
    assert_done(&segment(&input, &out, &[]));
    let session = session(FRAMES);
    let mut pixels = vec![0_u64; session.objects().unwrap().highest_label + 1];
    for t in 0..FRAMES as usize {
        let (mask, palette) = read_mask(&out.join(format!("masks/{t:05}.png")));
        assert_eq!(mask, session.labels(t).unwrap(), "frame {t}");
        let of_cluster = &session.objects().unwrap().of_cluster;
        let clusters = session.cluster_labels(t).unwrap();
        assert_eq!(clusters.map(|cluster| of_cluster[cluster as usize]), mask, "frame {t}");
        // Colours that label tools know by heart: black, red, green, olive, blue at half strength.
        assert_eq!(palette[..15], [0, 0, 0, 128, 0, 0, 0, 128, 0, 128, 128, 0, 0, 0, 128]);
        mask.data().iter().for_each(|&label| pixels[usize::from(label)] += 1);
    }
    let report = json(&out.join("result.json"));
    assert_eq!(report["background"]["pixels"], pixels[0]);
    let mut clusters: Vec<u64> = numbers(&report["background"]["clusters"]);
    for (object, label) in report["objects"].as_array().unwrap().iter().zip(1..) {
        assert_eq!((&object["label"], &object["pixels"]), (&label.into(), &pixels[label].into()));
        let seen = |t: &usize| session.labels(*t).unwrap().data().contains(&(label as u8));
        let frames: Vec<usize> = (0..FRAMES as usize).filter(seen).collect();
        assert_eq!(object["firstFrame"].as_u64(), frames.first().map(|&t| t as u64));
        assert_eq!(object["lastFrame"].as_u64(), frames.last().map(|&t| t as u64));
        clusters.extend(numbers(&object["clusters"]));
    }
    assert_eq!(report["objects"].as_array().unwrap().len() + 1, pixels.len());
    assert_eq!(clusters.iter().collect::<BTreeSet<_>>().len() as u64, report["clusters"].as_u64().unwrap());
    let superpixels: Vec<u64> = (0..FRAMES as usize).map(|t| session.superpixels(t).unwrap().count as u64).collect();
    assert_eq!(numbers(&report["superpixels"]), superpixels);
}

fn numbers(list: &serde_json::Value) -> Vec<u64> {
    list.as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).collect()
}

/// A square of the same kind of noise as the ground, which is still, goes right and down.
fn camouflaged(x: i32, y: i32, t: i32) -> u8 {
    let noise = |x: i32, y: i32, seed: u64| {
        let value =
            |x: i32, y: i32| i32::from(tracecut::rng::mix(seed ^ ((x as u64) << 32) ^ u64::from(y as u32)) as u8);
        let weights = [[1, 2, 1], [2, 4, 2], [1, 2, 1]];
        let around = (0..9).map(|k| weights[k as usize / 3][k as usize % 3] * value(x + k % 3, y + k / 3));
        128 + (around.sum::<i32>() / 16 - 128) * 3 / 10
    };
    let (left, top) = (12 + 3 * t, 19 + t);
    let is_inside = (left..left + 40).contains(&x) && (top..top + 40).contains(&y);
    (if is_inside { noise(x - left, y - top, 2) } else { noise(x, y, 1) }) as u8
}

#[test]
fn an_object_without_a_pixel_is_in_no_list_and_in_no_number() {
    let (input, out) = (folder("camouflage-in"), absent("camouflage-out"));
    clip(&input, FRAMES, SIZE, &camouflaged);
    // With faint contours it would be found.
    let output = segment(&input, &out, &["--format", "png,rle,prompts", "--set", "contour.minShare=0"]);
    assert_done(&output);
    let mut params = Params::default();
    params.contour.min_share = 0.0;
    let session = session_with(params, FRAMES, &camouflaged);
    // It has trajectories, and the cut gave their pixels to the ground.
    assert_eq!(session.objects().unwrap().labels(), [1]);
    assert!((0..FRAMES as usize).all(|t| session.labels(t).unwrap().data().iter().all(|&label| label == 0)));

    assert!(text(&output.stdout).contains("in 2 clusters, 0 object(s), "), "{}", text(&output.stdout));
    let report = json(&out.join("result.json"));
    assert_eq!((&report["clusters"], &report["objects"]), (&2.into(), &serde_json::json!([])));
    assert_eq!(report["windows"][0].get("objects"), None);
    assert_eq!(fs::read_to_string(out.join("objects.csv")).unwrap().lines().count(), 1);
    let coco = json(&out.join("masks.json"));
    assert_eq!((&coco["tracks"], &coco["annotations"]), (&serde_json::json!([]), &serde_json::json!([])));
    assert_eq!(json(&out.join("prompts.json"))["prompts"], serde_json::json!([]));
}

#[test]
fn mask_overlays_tint_objects_and_leave_the_background_as_it_is() {
    let (input, out) = moving_clip("tint", 4);
    assert_done(&segment(&input, &out, &["--format", "png,overlay"]));
    let picture = image::open(out.join("overlay-masks/00001.png")).unwrap().into_rgb8();
    let (mask, _) = read_mask(&out.join("masks/00001.png"));
    let frame = rgb(SIZE.0, SIZE.1, &|x, y| moving(x, y, 1));
    let mut tinted = 0;
    for ((&label, new), old) in mask.data().iter().zip(picture.as_raw().chunks(3)).zip(frame.chunks(3)) {
        assert!(label > 0 || new == old, "a background pixel went from {old:?} to {new:?}");
        tinted += usize::from(new != old);
    }
    let objects = mask.data().iter().filter(|&&label| label > 0).count();
    assert!(objects > 500 && tinted == objects, "{tinted} pixels tinted, {objects} on objects");
}

#[test]
fn backgrounds_are_written_where_they_are_asked_for() {
    let (input, out) = moving_clip("background", FRAMES);
    assert_done(&segment(&input, &out, &["--background"]));
    assert_eq!(names_in(&out.join("background")).len(), FRAMES as usize);
    let picture = image::open(out.join("background/00002.png")).unwrap().into_rgba8();
    assert_eq!(picture.as_raw(), session(FRAMES).background(2).unwrap().data().as_flattened());
    // Where the object was, the scene is shown that it uncovers in other frames.
    let (mask, _) = read_mask(&out.join("masks/00002.png"));
    let frame = rgb(SIZE.0, SIZE.1, &|x, y| moving(x, y, 2));
    let scene = rgb(SIZE.0, SIZE.1, &|x, y| texture(x + 2, y, 2));
    let (mut replaced, mut right) = (0, 0);
    for (p, (&label, new)) in mask.data().iter().zip(picture.pixels()).enumerate() {
        if label > 0 && new.0[3] == 255 && new.0[0] != frame[3 * p] {
            replaced += 1;
            right += usize::from(new.0[0].abs_diff(scene[3 * p]) < 30);
        }
    }
    assert!(replaced > 300 && 10 * right > 7 * replaced, "{right} of {replaced}");
}

#[test]
fn a_run_without_masks_has_none_in_its_report() {
    let (input, out) = moving_clip("sparse", 6);
    assert_done(&segment(&input, &out, &["--no-dense"]));
    assert_eq!(names_in(&out), ["result.json", "tracks.dat"]);
    let report = json(&out.join("result.json"));
    assert!(report["objects"].is_null() && report["superpixels"].is_null(), "{report}");
    assert_eq!(report["params"]["clip"]["dense"], false);
}

#[test]
fn tracks_of_a_file_take_the_place_of_those_of_the_tracker() {
    let (input, out, again) = (folder("tracks-in"), folder("tracks-out"), folder("tracks-again"));
    clip(&input, FRAMES, SIZE, &moving);
    assert_done(&segment(&input, &out, &[]));
    let file = out.join("tracks.dat");
    let given = fs::read_to_string(&file).unwrap();
    let (tracks, _) = tracks::parse(&given).unwrap();
    // Those of them that stay in the upper half.
    let mut upper = Trajectories::empty(tracks.num_frames, (0, 0));
    let is_upper = |i: usize| tracks.points(i).all(|p| tracks.y[p] < 48.0);
    for i in (0..tracks.len()).filter(|&i| is_upper(i)) {
        upper.push(tracks.frames(i).start, tracks.points(i).map(|p| (tracks.x[p], tracks.y[p], 0.0)));
    }
    let one = Clusters { count: 1, label: vec![0; upper.len()] };
    let half = input.join("half.dat");
    fs::write(&half, tracks::write(&upper, &one).unwrap()).unwrap();
    assert_done(&segment(&input, &again, &["--tracks", half.to_str().unwrap()]));
    let (found, clusters) = tracks::parse(&fs::read_to_string(again.join("tracks.dat")).unwrap()).unwrap();
    assert_eq!((found.x, found.y), (upper.x, upper.y));
    assert!(clusters.count > 1);
    let table = fs::read_to_string(again.join("objects.csv")).unwrap();
    assert!(table.starts_with("frame,time,object,") && table.contains("\n0,,1,"), "{table}");
    let (mask, _) = read_mask(&again.join("masks/00004.png"));
    assert_ne!(mask[(50, 35)], mask[(5, 5)]);
    fs::write(&half, given.replacen("10\n", "11\n", 1)).unwrap();
    let refused = segment(&input, &folder("tracks-refused"), &["--tracks", half.to_str().unwrap()]);
    assert_refused(&refused, 3, &["trajectories of 11 frames (expected 10"]);
}

#[test]
fn explain_says_in_numbers_what_the_library_does_and_refuses_what_is_not_there() {
    let input = folder("explain-in");
    clip(&input, FRAMES, SIZE, &moving);
    let asked = |at: &str| tracecut(["explain", input.to_str().unwrap(), "--at", at]);
    let output = asked("4,50,45");
    assert_done(&output);
    let (words, why) = (text(&output.stdout), session(FRAMES).explain(4, (50, 45)).unwrap());
    assert!(words.starts_with(&format!("frame 4, pixel 50,45: object {}", why.label)), "{words}");
    for cost in &why.costs {
        let sum = format!("{:.4}", cost.total);
        assert!(words.contains(&sum), "{sum} is not in\n{words}");
    }
    let margin = format!("costs {:.4} more", why.flip.unwrap().margin);
    assert!(words.contains(&margin), "{margin} is not in\n{words}");
    // Of a clip that is cut off the frames before are explained.
    let cut = input.join("cut.y4m");
    fs::write(&cut, &y4m(FRAMES + 1)[..(FRAMES as usize + 1) * 12294]).unwrap();
    let explained = tracecut(["explain", cut.to_str().unwrap(), "--at", "4,50,45"]);
    assert_refused(&explained, 3, &["cut.y4m: is truncated: frame 10 has"]);
    assert_eq!(text(&explained.stdout), words);
    assert_refused(&asked("4,128,0"), 2, &["128", "0..128"]);
    assert_refused(&asked("10,0,0"), 2, &["10", "0..10"]);
    assert_refused(&asked("4,x"), 2, &["three whole numbers"]);
}
