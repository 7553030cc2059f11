//! Measures against ground truth. (Essay follows.)
