//! What explanations and confidences are made from, for JavaScript, as lists of numbers; `lib/explain.js` and
//! `lib/confidence.js` make the rest from these and from what a result has.

use super::JsSession;
use crate::cut::{STEPS_PER_UNIT, STRANGER};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(js_class = Session)]
impl JsSession {
    /// The terms behind the pixel `x`, `y` of frame `t`, and the affinities of trajectory `near`; `undefined` where
    /// there are no masks. `lib/explain.js` reads them in the order in which they are written here.
    ///
    /// Costs are in steps of the solver, of which the first number says how many are a unit; lists begin with their
    /// length; strangers are of cluster -2, trajectories whose cluster is not known of -1.
    pub fn terms(&self, t: usize, x: usize, y: usize, near: usize) -> Option<Vec<f64>> {
        let (session, mut list) = (self.session(), Vec::new());
        let why = session.terms(t, x, y)?;
        let (reasons, params) = (&why.reasons, &session.params().cut);
        let weights = [params.unary_weight, params.stranger_weight, reasons.lambda, why.cues, why.looks];
        add(&mut list, &[f64::from(STEPS_PER_UNIT), why.source as u32 as f64]);
        add(&mut list, &[why.superpixel, reasons.label, reasons.strangers].map(f64::from));
        add(&mut list, &weights.map(f64::from));
        add(&mut list, &[reasons.own.len() as f64]);
        for own in &reasons.own {
            add(&mut list, &[own.trajectories, own.colours, own.evidence, own.forbidden].map(f64::from));
        }
        add(&mut list, &[reasons.links.len() as f64]);
        for link in &reasons.links {
            add(&mut list, &[link.t as u32, link.superpixel, link.label, link.tracks, link.cost as u32].map(f64::from));
        }
        add(&mut list, &[why.voters.len() as f64]);
        for voter in &why.voters {
            let known = (voter.cluster as usize) < reasons.own.len();
            let unknown = if voter.cluster == STRANGER { -2.0 } else { -1.0 };
            let cluster = if known { f64::from(voter.cluster) } else { unknown };
            add(&mut list, &[voter.at.0.into(), voter.at.1.into(), cluster]);
        }
        let affinities = session.affinities().filter(|affinities| near < affinities.len());
        for (j, affinity) in affinities.into_iter().flat_map(|affinities| affinities.row(near)) {
            add(&mut list, &[j as f64, affinity]);
        }
        Some(list)
    }

    /// What the confidences of frame `t` are made from: what the background says for each of 256 mask labels, then for
    /// each superpixel its mask label by the cut, and the margin of that; `undefined` where there are no masks.
    pub fn sureness(&self, t: usize) -> Option<Vec<f32>> {
        self.session().sureness(t)
    }
}

/// Out of line, as it is called often.
#[inline(never)]
fn add(list: &mut Vec<f64>, numbers: &[f64]) {
    list.extend_from_slice(numbers);
}
