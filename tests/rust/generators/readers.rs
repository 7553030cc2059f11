//! Readers of the library: any bytes give an error or a valid value, which is the same after writing and reading.

use std::collections::BTreeMap;
use tracecut::Params;
use tracecut::image::Frame;
use tracecut::params::ParamValue;
use tracecut::tracks;

/// An image file: PNG, JPEG or PPM.
pub fn image_file(bytes: &[u8]) {
    match Frame::decode(bytes) {
        Ok(frame) => assert_eq!(frame.rgb().len(), 3 * frame.width() * frame.height()),
        Err(error) => assert!(["decode", "frame-size", "too-large"].contains(&error.code()), "{error}"),
    }
}

/// A `tracks.dat`. Coordinates are written with three decimals, so what was written once stays the same.
pub fn tracks_dat(bytes: &[u8]) {
    let Ok((found, clusters)) = tracks::parse(&String::from_utf8_lossy(bytes)) else { return };
    found.check().unwrap();
    let text = tracks::write(&found, &clusters).unwrap();
    let (again, same) = tracks::parse(&text).unwrap();
    assert_eq!(same, clusters);
    assert_eq!(again.start_frame, found.start_frame);
    assert_eq!(tracks::write(&again, &same).unwrap(), text);
}

/// Parameters from JSON. What was taken is legal, and gives the same again.
pub fn parameters(bytes: &[u8]) {
    let Ok(tree) = serde_json::from_slice::<BTreeMap<String, ParamValue>>(bytes) else { return };
    let mut params = Params::default();
    if let Err(error) = params.apply(&tree) {
        assert_eq!(error.code(), "param");
        assert_eq!(params, Params::default(), "refused parameters changed others");
        return;
    }
    params.validate().unwrap();
    let mut again = Params::default();
    again.apply(&serde_json::from_str(&serde_json::to_string(&params).unwrap()).unwrap()).unwrap();
    assert_eq!(again, params);
}
