//! Measures against ground truth, and the track file format that the Moseg benchmark exchanges.
//!
//! Nothing here touches the file system: callers read the files and pass their bytes or text.
//!
//! - [`tracks`]: labelled trajectories to and from `tracks.dat`;
//! - [`definition`]: which frames of a shot are labelled, and with which regions (`Def.dat`, PGM masks);
//! - [`flow`]: end-point error of optical flow against a `.flo` file;
//! - [`davis`]: region similarity and boundary measure of masks, as the DAVIS benchmark has them;
//! - [`moseg`]: the five numbers of the Moseg benchmark (Brox and Malik 2010) for points or pixels, their mean and trimmed mean.

pub mod davis;
pub mod definition;
pub mod flow;
pub mod moseg;
pub mod tracks;
