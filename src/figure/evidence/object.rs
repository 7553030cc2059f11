//! The log-odds that a cluster is an object and not the scene behind.

use super::pair::{Known, Summary, count_of, log_odds};
use super::weights::{OBJECT, OBJECT_BEFORE_PLATE};

/// The log-odds at which an object is as well kept as left out: what pixels say can still take one away, but not bring it
/// back.
const CAUTION: f64 = -0.8;
/// What holds more of the rim than this is scene whatever its motion, such as what is near in a scene of depth.
const RUNS_ON: f64 = 1.0;
/// Without the motion, what holds less of the rim than usual is an object.
const OBJECT_BY_RIM: [f64; 2] = [-0.2, -2.0];

/// What a cluster is judged by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Signs {
    /// Where the camera moves, or nothing is known of it.
    Moving {
        /// Its share of the frame's rim over its share of the frame: 1 on average.
        rim: f64,
        /// How far it is from the camera's motion ([`strangeness`]), where that is known.
        strangeness: Option<f64>,
    },
    /// Where the camera stands still: how far it is from the background plate, 0 to 1.
    Still { unlike: f64 },
}

impl Signs {
    /// The terms of [`OBJECT`] or of [`OBJECT_BEFORE_PLATE`]; `None` where motion is not known.
    pub(crate) fn terms(&self) -> Option<Vec<f64>> {
        match *self {
            Self::Moving { rim, strangeness } => Some(vec![of_rim(rim), strangeness?]),
            Self::Still { unlike } => Some(vec![of_plate(unlike)]),
        }
    }

    /// What speaks for an object, above 0.
    pub(crate) fn value(&self) -> f64 {
        match *self {
            Self::Still { unlike } => log_odds(&OBJECT_BEFORE_PLATE, &[of_plate(unlike)]) - CAUTION,
            Self::Moving { rim, strangeness: None } => log_odds(&OBJECT_BY_RIM, &[of_rim(rim)]),
            Self::Moving { rim, strangeness: Some(_) } if rim > RUNS_ON => f64::NEG_INFINITY,
            Self::Moving { rim, strangeness: Some(far) } => log_odds(&OBJECT, &[of_rim(rim), far]) - CAUTION,
        }
    }
}

fn of_rim(rim: f64) -> f64 {
    libm::log(rim + 0.1)
}

fn of_plate(unlike: f64) -> f64 {
    libm::log(unlike + 0.02)
}

/// How far each cluster is from the camera's motion: the mean of ln(1 + r²) over its velocities, whose difference from
/// that motion is r in units of the noise.
pub(crate) fn strangeness(label: &[u32], known: &Known) -> Vec<f64> {
    Summary::of_clusters(label, count_of(label), known).iter().map(Summary::strangeness).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_holds_the_rim_and_goes_with_the_camera_is_scene_and_what_does_neither_an_object() {
        let value = |rim: f64, strangeness| Signs::Moving { rim, strangeness }.value();
        for rim in [0.9, 0.1] {
            assert!(value(rim, Some(5.0)) > value(rim, Some(0.2)));
        }
        assert!(value(1.1, Some(0.2)) < 0.0 && value(0.0, Some(5.0)) > 0.0);
        // A piece of the scene in the middle of the frame; what is near in a scene of depth.
        assert!(value(0.6, Some(0.3)) < 0.0 && value(2.0, Some(9.0)) < 0.0);
        assert!(value(1.1, None) < 0.0 && value(0.0, None) > 0.0);
    }

    #[test]
    fn what_is_like_the_plate_is_scene_and_what_is_not_an_object() {
        let value = |unlike| Signs::Still { unlike }.value();
        // Leaves sway over what looks like them. An object is like the plate in places.
        assert!(value(0.02) < -1.5 && value(0.4) > 0.0);
    }
}
