#!/usr/bin/env python3
"""Superpixels by SLIC (and, if asked for, Felzenszwalb and Huttenlocher's method), to compare ours with.

    pip install scikit-image
    python3 bench/slic.py BSDS/images MAPS --counts 400,700 --compactness 10
    cargo run --release -p tracecut-bench -- superpixels BSDS --counts 400,700 --compare slic=MAPS

Writes MAPS/NAME_COUNT.png for each image: a 16-bit grey PNG that holds the number of each pixel's superpixel. SLIC runs on the Lab image
with scikit-image's defaults but for the compactness, whose best value differs from one kind of image to another: run it with several
(5, 10, 20, 40) and compare with the best. It delivers more or fewer superpixels than asked for; `bench superpixels` scores ours at the
number that each map really has.
"""

import argparse
from pathlib import Path

import numpy as np
from skimage import io, segmentation


def slic(image, count, compactness):
    return segmentation.slic(image, n_segments=count, compactness=compactness, start_label=0)


def felzenszwalb(image, count):
    """The scale that comes nearest to `count` segments, by bisection."""
    low, high = 1.0, 3000.0
    best = None
    for _ in range(12):
        scale = (low * high) ** 0.5
        labels = segmentation.felzenszwalb(image, scale=scale, sigma=0.8, min_size=20)
        found = labels.max() + 1
        if best is None or abs(found - count) < abs(best.max() + 1 - count):
            best = labels
        low, high = (scale, high) if found > count else (low, scale)
    return best


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("images", type=Path, help="folder of images")
    parser.add_argument("out", type=Path, help="folder for the label maps")
    parser.add_argument("--counts", default="400,700", help="numbers of superpixels, with commas between them")
    parser.add_argument("--compactness", type=float, default=10.0, help="SLIC's weight of distance against colour")
    parser.add_argument("--method", choices=["slic", "felzenszwalb"], default="slic")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    counts = [int(n) for n in options.counts.split(",")]
    for path in sorted(options.images.iterdir()):
        if path.suffix.lower() not in (".jpg", ".jpeg", ".png"):
            continue
        image = io.imread(path)[..., :3]
        for count in counts:
            labels = slic(image, count, options.compactness) if options.method == "slic" else felzenszwalb(image, count)
            io.imsave(options.out / f"{path.stem}_{count}.png", labels.astype(np.uint16), check_contrast=False)


if __name__ == "__main__":
    main()
