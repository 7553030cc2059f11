"""The parameters as types, from the declarations of the library.

Written by ``REGENERATE=1 python3 python/run_tests.py python/tests/test_types.py``.
"""

from __future__ import annotations

from typing import Literal, TypedDict

Preset = Literal["default", "fast", "paper"]


class ClipParams(TypedDict, total=False):
    """Parameters of the section ``clip``, with their defaults and ranges."""

    max_side: int
    """Longest side at which frames are processed, in pixels; larger frames are reduced and every result is mapped back
    to input pixels. Higher is slower and finds smaller objects. Default: 640 (16 to 4096)."""
    reference_side: int
    """Side of the square frame that lengths refer to, in pixels: in a smaller frame the distances of trajectories and
    radii around them are reduced in proportion, down to one half, so that an object has the same number of points at
    any size. 0 turns this off. Default: the area of 480×270. Default: 360 (0 to 4096)."""
    dense: bool
    """Computes masks; otherwise a run ends with the labels of the trajectories. Default: True."""
    max_pixels: int
    """Largest number of pixels of an input frame. Larger frames are errors (`too-large`), before memory is allocated.
    Default: 67108864 (1 to 268435456)."""
    max_frames: int
    """Largest number of frames of a session, or of a window of a long clip. Default: 10000 (2 to 1000000)."""
    max_trajectories: int
    """Largest number of trajectories. Default: 1000000 (1 to 100000000)."""
    max_points: int
    """Largest number of points of trajectories from another tracker. Default: 100000000 (1 to 4294967295)."""
    seed: int
    """Seed of all pseudo-random numbers. Default: 0 (0 to 4294967295)."""


class ShotParams(TypedDict, total=False):
    """Parameters of the section ``shot``, with their defaults and ranges."""

    max_unmatched: float
    """A clip that is processed window by window begins a new shot where more than this share of the picture is
    unmatched in the next frame. 1 never begins one. Neighbouring frames of 20 of our 21 sequences stay below 0.2,
    frames of a fast swinging camera reach 0.69; of 1384 pairs of frames from different sequences all but 14 are above
    0.97. Default: 0.72 (0.0 to 1.0)."""


class FlowParams(TypedDict, total=False):
    """Parameters of the section ``flow``, with their defaults and ranges."""

    patch_stride: int
    """Pixels between neighbouring patches down to the finest level that is searched, the patch's side at most; three
    quarters of it at coarser ones. Lower is slower. Default: 4 (1 to 8)."""
    search_level: int
    """Finest level at which patches are searched, 0 being full size; in finer ones each pixel takes the motion near it
    that fits best. Higher is faster and loses what is small. Default: 0 (0 to 4)."""
    max_side: int
    """Longest side at which the flow of a clip is computed, in pixels; larger frames are reduced for it, and the field
    is enlarged. Single pairs, and runs that end with the labels of trajectories, keep their size. Higher is slower.
    Default: 480 (16 to 4096)."""
    smoothness: float
    """Weight of smoothness in the refinement. Default: 25.0 (0.001 to 1000.0)."""
    fixed_points: int
    """Fixed-point iterations of the refinement at every level, each with new robust weights; 0 skips the refinement.
    Higher is slower. Default: 4 (0 to 12)."""


class TrajectoryParams(TypedDict, total=False):
    """Parameters of the section ``trajectory``, with their defaults and ranges."""

    grid_step: float
    """Spacing of the seed grid, in pixels of the processed frames. Lower is slower and finds smaller objects. Default:
    the published tracker's 8. Default: 8.0 (3.0 to 64.0)."""
    min_length: int
    """Shortest trajectory kept, in frames (section 5: 7). Clips of fewer than 13 frames use half their length, but at
    least 2. Default: 7 (2 to 1000)."""
    mask_step: float
    """Spacing of the denser trajectories that the masks are made from, in pixels of the processed frames. Default: 4.0
    (2.0 to 64.0)."""
    mask_min_length: int
    """Shortest trajectory that the masks are made from, in frames. Default: 2 (2 to 1000)."""
    structure_mean: float
    """A seed needs a structure of more than this fraction of the frame's mean, and eleven times as much on the border
    (published tracker: 0.1). Lower tracks weaker texture, which the checks below then have to judge. Default: 0.03 (0.0
    to 10.0)."""
    structure_floor: float
    """A seed needs more than this structure, in grey levels squared (published tracker: 1). 0 seeds all but constant
    areas. Default: 0.02 (0.0 to 1000.0)."""


_Lambda = TypedDict("_Lambda", {"lambda": float}, total=False)


class AffinityParams(_Lambda, total=False):
    """Parameters of the section ``affinity``, with their defaults and ranges."""

    horizon: int
    """Horizon of a velocity, in frames (Brox and Malik 2010: 5). Default: 5 (1 to 50)."""
    noise_floor: float
    """Floor of the velocity noise, in pixels per frame, added in quadrature to the local flow variation. Lower
    separates weaker motion differences and fragments more. Default: 0.2 (0.001 to 10.0)."""
    variation_weight: float
    """Factor of the local flow variation in the velocity noise (Brox and Malik 2010: 1). Lower separates weaker motion
    differences and fragments objects that turn, zoom or bend. Default: 0.5 (0.0 to 10.0)."""
    local_radius: float
    """Radius within which every pair is compared, in steps of the seed grid. Higher is slower. Default: 7.5 (1.0 to
    1000.0)."""
    far_sampling: int
    """One of this many farther pairs is compared, with this weight. 0 leaves them out. Lower is slower. Default: 32 (0
    to 1000)."""
    min_overlap: int
    """Fewest common frames of a pair, in frames; short clips use all frames they have. Default: 4 (2 to 100)."""


class EmbeddingParams(TypedDict, total=False):
    """Parameters of the section ``embedding``, with their defaults and ranges."""

    min_eigenvalue: float
    """Eigenvectors are kept while their eigenvalue is at least this. Lower keeps more of them and finds weaker motion
    differences, but breaks uniform regions sooner. The paper does not say. Default: 0.7 (0.0 to 1.0)."""
    min_dimensions: int
    """Smallest number of eigenvectors, whatever their eigenvalues. Default: 8 (1 to 64)."""
    max_dimensions: int
    """Largest number of eigenvectors; overrides a larger `minDimensions`. Higher is slower. Default: 24 (2 to 64)."""
    min_component: int
    """Connected groups of fewer trajectories than this are not embedded (where no group is as large, the largest are).
    Default: 1 (1 to 1000000)."""


class DiscontinuityParams(TypedDict, total=False):
    """Parameters of the section ``discontinuity``, with their defaults and ranges."""

    threshold: float
    """d_ij above which an edge lies on an object boundary (section 2.2: 0.6). Used by the thresholded segmentation of
    Figure 1(c). Default: 0.6 (0.0 to 1.0)."""
    min_dimensions: int
    """Smallest number of eigenvectors for d. Default: 6 (1 to 64)."""
    min_eigenvalue: float
    """Eigenvectors with at least this eigenvalue are used for d beyond the smallest number. Default: 0.96 (0.0 to
    1.0)."""


class SaliencyParams(TypedDict, total=False):
    """Parameters of the section ``saliency``, with their defaults and ranges."""

    compensation: Literal["off", "affine", "homography"]
    """Model of the camera's motion that is subtracted from the flow (the paper: off). Default: homography."""
    tolerance: float
    """Residual at which a point of the flow counts half in the fit of the dominant motion, in pixels a frame. Default:
    0.5 (0.01 to 100.0)."""
    bins: int
    """Bins of the magnitude (Rahtu et al.: 15). Higher is slower. Default: 15 (2 to 32)."""
    range: float
    """Magnitude at which the last bin ends, in pixels a frame (Rahtu et al.: 15); 0 takes it from the clip. Default:
    0.0 (0.0 to 250.0)."""
    prior: float
    """Prior probability that a pixel of a window is salient (Rahtu et al.: 0.2). Default: 0.2 (0.001 to 0.999)."""
    neighborhood: float
    """ℓ: trajectories are near in the embedding if their embedding affinity is above this part of their density
    (section 3; the value is not given there). Higher averages over fewer. Default: 0.4 (0.0 to 1.0)."""
    form: Literal["max", "min"]
    """Density of two trajectories: the greater or the smaller (the paper: min). Default: max."""
    threshold: float
    """Trajectories of a context-aware saliency above this are foreground (section 3: 0.5). Default: 0.5 (0.0 to
    1.0)."""


class ConnectednessParams(TypedDict, total=False):
    """Parameters of the section ``connectedness``, with their defaults and ranges."""

    mode: Literal["off", "paper", "agents", "foreground-only"]
    """Constraint of the foreground on affinities. Default: agents."""
    min_violations: int
    """Frames in which two trajectories must be in different components to lose their affinity (section 3: 1). Higher
    forgives more holes in the foreground. Default: 4 (1 to 1000)."""
    max_edge: float
    """Longest Delaunay edge along which the foreground is connected, in steps of the seed grid. Default: 4.0 (1.0 to
    1000.0)."""
    min_component: int
    """Components of fewer trajectories are ignored; counted at a grid step of 8 pixels and scaled with the inverse
    square of the step. Default: 10 (1 to 100000)."""


class DiscretizeParams(TypedDict, total=False):
    """Parameters of the section ``discretize``, with their defaults and ranges."""

    method: Literal["rotation-merge", "rotation", "k-means", "rotation-evidence"]
    """rotation-evidence merges by discontinuities, motion and size, rotation-merge by discontinuities alone (section
    2.3); rotation and k-means do not merge (Figure 10). Default: rotation-evidence."""
    count: Literal["eigenvalues", "gap"]
    """Number of clusters before merging: eigenvalues takes one for each eigenvector of the embedding, gap one for each
    eigenvalue before the first gap of at least `minGap`. Default: eigenvalues."""
    min_gap: float
    """With the count by gap: K is the least number for which λ_K − λ_K+1 reaches this, or all eigenvalues of the
    embedding if none does. Higher gives more clusters. Default: 0.02 (0.0 to 1.0)."""
    merge_log_odds: float
    """With rotation-evidence: log-odds above which two clusters are merged, lower for small ones. Higher splits more,
    lower makes fewer, larger clusters. Default: 2.8 (0.0 to 20.0)."""
    min_agreement: float
    """Masks that agree less than this with the masks of nearby frames along the flow are made again from other
    clusters; the masks that agree most are kept. 0 keeps the first. Not in the paper; docs/choices.md. Default: 0.7
    (0.0 to 1.0)."""
    merge_threshold: float
    """ρ of rotation-merge: clusters whose mean discontinuity along their common border is below it are merged (section
    2.3: 0.4). Higher merges more. Default: 0.77 (0.0 to 1.0)."""


class ContourParams(TypedDict, total=False):
    """Parameters of the section ``contour``, with their defaults and ranges."""

    low_threshold: float
    """Contours are linked where Pb is above this value. Default: 0.03 (0.0 to 1.0)."""
    high_threshold: float
    """A contour is kept if its Pb is above this value somewhere. Default: 0.08 (0.0 to 1.0)."""
    min_share: float
    """If fewer pixels than this share of an image exceed the high threshold, as in fog, both thresholds fall until as
    many do, at most to an eighth. Not in the paper. Default: 0.01 (0.0 to 1.0)."""
    min_length: int
    """Contours of fewer pixels with a free end are left out. Default: 8 (1 to 10000)."""
    max_deviation: float
    """Largest distance of a line from its contour, in pixels. Higher gives fewer lines. Default: 1.5 (0.1 to 20.0)."""
    max_line_length: float
    """Longer lines are split, in pixels, so that edges across a gap can begin in their middle; 0 keeps them. Default:
    0.0 (0.0 to 10000.0)."""
    half_size_min_side: int
    """Least longer side, in pixels, from which Pb of a clip's frames is measured at half size, in less than half of the
    time; smaller frames and single images are measured at full size. Default: 400 (1 to 65536)."""


class SuperpixelParams(TypedDict, total=False):
    """Parameters of the section ``superpixel``, with their defaults and ranges."""

    merge_threshold: float
    """Superpixels of areas p and q in pixels are merged while the mean Pb between them, times pq / (p + q), is below
    this. 0 keeps the faces of the Gabriel graph. Default: 0.0 (0.0 to 1000000.0)."""


class CutParams(TypedDict, total=False):
    """Parameters of the section ``cut``, with their defaults and ranges."""

    unary_weight: float
    """Weight of a superpixel's own trajectories (λ of section 4.2, whose value the paper does not give). Default: 1.0
    (0.0 to 1000.0)."""
    spatial_weight: float
    """Weight of the border between two superpixels of a frame. Higher makes labels smoother. Default: 2.0 (0.0 to
    1000.0)."""
    pb_scale: float
    """A border costs `exp(−mean Pb / this)` to cut. The paper prints the mean Pb itself, a misprint. Default: 0.03
    (0.001 to 100.0)."""
    weight_by_length: bool
    """Weights borders by their length, relative to the mean and within 0.05 to 4. The paper does not. Default: True."""
    temporal_weight: float
    """Weight of the share of common trajectories between superpixels of consecutive frames. Default: 1.0 (0.0 to
    1000.0)."""
    appearance_rounds: int
    """Number of further cuts, each with the appearance of objects and background, as learned from the cut before. Not
    in the paper; docs/choices.md. Default: 3 (0 to 10)."""
    appearance_weight: float
    """Weight of the log-odds by appearance in these cuts. Default: 0.8 (0.0 to 100.0)."""
    appearance_unary_factor: float
    """Factor on the weight of trajectories in these cuts, as what they told is learned. Default: 0.35 (0.0 to 1.0)."""
    ambiguous_share: float
    """A superpixel's own trajectories do not count if a larger share of it than this lies between trajectories of
    different labels (section 4.2: 0.3). 1 turns the rule off. Default: 0.3 (0.0 to 1.0)."""


class BackgroundParams(TypedDict, total=False):
    """Parameters of the section ``background``, with their defaults and ranges."""

    enabled: bool
    """Classifies clusters and superpixels by the background. Not in the paper. Default: True."""
    neutral_motion: float
    """Still camera: motion that is as likely an object's as the background's, in pixels a frame. Default: 0.4 (0.01 to
    100.0)."""
    plate_weight: float
    """Still camera: weight of the log-odds by the distance from the plate. Default: 0.8 (0.0 to 100.0)."""
    motion_weight: float
    """Still camera: weight of the log-odds by motion. Default: 0.3 (0.0 to 100.0)."""
    reprojection_weight: float
    """Moving camera: weight of the reprojection errors, by the scene's motion against the objects'. Default: 2.5 (0.0
    to 100.0)."""
    prior_log_odds: float
    """Moving camera: prior log-odds against an object in each superpixel. Default: 1.3 (0.0 to 100.0)."""
    rigid_scene: bool
    """Forward camera: takes tracks that violate a rigid scene on a ground for objects. Default: True."""


class RefineParams(TypedDict, total=False):
    """Parameters of the section ``refine``, with their defaults and ranges."""

    band: int
    """Furthest that a border may move to either side, in pixels of the processed frames; 0 leaves masks as they are.
    Higher is slower. Default: 8 (0 to 64)."""
    colour_weight: float
    """Weight of local colours. Default: 2.0 (0.0 to 1000.0)."""
    displacement_weight: float
    """Cost of moving the border by the whole band; it grows with the square of the distance. Default: 2.0 (0.0 to
    1000.0)."""
    smoothness: float
    """Cost of a border between two pixels of the same colour. Default: 2.0 (0.0 to 1000.0)."""
    min_part: float
    """A part of an object that lies apart and has hardly any of its trajectories goes to what surrounds it, if its area
    is less than this share of the object's largest part in the frame. 0 keeps all. Not in the paper; docs/choices.md.
    Default: 0.1 (0.0 to 1.0)."""


class StillParams(TypedDict, total=False):
    """Parameters of the section ``still``, with their defaults and ranges."""

    max_side: int
    """Longest side at which an image is processed, in pixels; larger ones are reduced. Higher is slower and takes more
    memory. Default: 640 (16 to 4096)."""
    radius: int
    """Radius within which pixels are compared, in pixels. Higher is slower. Default: 5 (1 to 10)."""
    sigma: float
    """Pb between two pixels that lowers their affinity to 1/e. Default: 0.1 (0.001 to 10.0)."""
    dimensions: int
    """Number of eigenvectors, the constant one included. Higher is slower. Default: 24 (2 to 64)."""
    grouping: Literal["joint", "single"]
    """Eigenvectors that d is computed from: all together (the paper: joint), or each with the constant one and then a
    mean. Default: single."""
    weight: float
    """Weight of the discontinuities in the combined map; 0 gives Pb. Default: 1.0 (0.0 to 100.0)."""


class Params(TypedDict, total=False):
    """All parameters: a preset, and a dictionary for each section."""

    preset: Preset
    clip: ClipParams
    shot: ShotParams
    flow: FlowParams
    trajectory: TrajectoryParams
    affinity: AffinityParams
    embedding: EmbeddingParams
    discontinuity: DiscontinuityParams
    saliency: SaliencyParams
    connectedness: ConnectednessParams
    discretize: DiscretizeParams
    contour: ContourParams
    superpixel: SuperpixelParams
    cut: CutParams
    background: BackgroundParams
    refine: RefineParams
    still: StillParams
