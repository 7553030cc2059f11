//! Measures against ground truth.
//!
//! Nothing here touches the file system: callers read the files and pass their bytes or text.
//!
//! - [`agreement`]: how well the agreement of masks in time predicts their J;
//! - [`definition`]: which frames of a shot are labelled, and with which regions (`Def.dat`, PGM masks);
//! - [`flow`]: end-point error of optical flow against a `.flo` file;
//! - [`foreground`]: which trajectories are foreground, against labelled frames;
//! - [`logistic`]: the weights of terms whose sum is a log-odds, from examples;
//! - [`davis`]: region similarity and boundary measure of masks, as the DAVIS benchmark has them;
//! - [`masks`]: masks of any clip, with pixels that are not scored, and which objects were found;
//! - [`contours`]: boundary maps against the outlines that people drew (ODS, OIS);
//! - [`estimate`]: means and their standard errors;
//! - [`superpixels`]: boundary recall, under-segmentation error and achievable accuracy of superpixels;
//! - [`discretization`]: missed objects and over-segmentation of clusters, and curves of both (the paper's Figure 10);
//! - [`figment`]: the measures of the paper's Table 1, for entangled people;
//! - [`moseg`]: the five numbers of the Moseg benchmark (Brox and Malik 2010) for points or pixels, their mean and
//!   trimmed mean.

pub mod agreement;
pub mod contours;
pub mod davis;
pub mod definition;
pub mod discretization;
pub mod estimate;
pub mod figment;
pub mod flow;
pub mod foreground;
pub mod logistic;
pub mod masks;
pub mod moseg;
pub mod superpixels;
