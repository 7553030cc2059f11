//! Measures against ground truth.
//!
//! Nothing here touches the file system: callers read the files and pass their bytes or text.
//!
//! - [`agreement`]: how well the agreement of masks and their expected J predict J;
//! - [`definition`]: which frames of a shot are labelled, and with which regions (`Def.dat`, PGM masks);
//! - [`expected_j`]: the weights by which J is expected, and how well it is on kinds of clips that were left out;
//! - [`flow`]: end-point error of optical flow against a `.flo` file;
//! - [`logistic`]: the weights of terms whose sum is a log-odds, from examples;
//! - [`davis`]: region similarity and boundary measure of masks, as the DAVIS benchmark has them;
//! - [`masks`]: masks of any clip, with pixels that are not scored, and which objects were found;
//! - [`estimate`]: means and their standard errors;
//! - [`moseg`]: the five numbers of the Moseg benchmark (Brox and Malik 2010) for points or pixels, their mean and
//!   trimmed mean.

pub mod agreement;
pub mod davis;
pub mod definition;
pub mod estimate;
pub mod expected_j;
pub mod flow;
pub mod logistic;
pub mod masks;
pub mod moseg;
