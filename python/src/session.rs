//! The session as Python's files see it: plain arrays, tuples and dictionaries.

use crate::arrays::{self, copy, explanation, frame_from, image_from, list, matrix, plane};
use crate::error::{Failure, Result};
use crate::params::{params_from, params_in_force};
use crate::run::{Clip, Run, Shared, Sources, report};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tracecut::correction::{Correction, Stroke};
use tracecut::discretize::DiscretizeMethod;
use tracecut::mask::{Agreement, ObjectRow, enlarge, object_rows, object_table};
use tracecut::params::Choice;
use tracecut::sparse::SymCsr;
use tracecut::trajectory::Trajectories;
use tracecut::{Error, Step};

/// One clip on its way through the stages, or the session of a window, whose results can be read and corrected.
#[pyclass(frozen, module = "tracecut._tracecut")]
pub(crate) struct Session {
    pub(crate) run: Shared,
    /// The window that it was handed out for; its results are gone with the next.
    pub(crate) window: Option<usize>,
    /// The frames of that window at the size of the source, and the clip's number of its first.
    pub(crate) sources: Option<(Sources, usize)>,
}

const GONE: &str = "the window's results are gone: the next window was asked for";
const NO_FRAMES: &str = "a window's session can be corrected only: run a Session over the clip to change it otherwise";
const NO_WINDOW: &str = "this session is no window's";

type Size = (usize, usize);
/// Frames, size of the input, working size, corrections.
type Info = (usize, Size, Size, usize);
/// Frame, radius, and points of a stroke, x and y in turn.
type RawStroke = (usize, f32, Vec<f32>);

impl Session {
    /// Looks at the session.
    fn read<T>(&self, look: impl FnOnce(&tracecut::Session) -> Result<T>) -> Result<T> {
        self.run.read(|run| match (run, self.window) {
            (Run::Windows(_, at), Some(window)) if *at != window => Err(Failure::state(GONE)),
            _ => look(run.session()),
        })
    }

    /// The same without the interpreter's lock: for what is computed at the call.
    fn compute<T: Send>(
        &self,
        py: Python<'_>,
        look: impl FnOnce(&tracecut::Session) -> std::result::Result<T, tracecut::Error> + Send,
    ) -> Result<T> {
        py.detach(|| self.read(|session| Ok(look(session)?)))
    }

    /// Changes the session, without the interpreter's lock.
    fn change<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut tracecut::Session) -> Result<T> + Send,
    ) -> Result<T> {
        let changed = |run: &mut Run| match run {
            Run::Session(session) => work(session),
            Run::Windows(..) => Err(Failure::state(NO_FRAMES)),
        };
        py.detach(|| self.run.write(changed))
    }

    /// Changes the window that this session is of.
    fn change_window<T: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut Clip) -> Result<T> + Send) -> Result<T> {
        let changed = |run: &mut Run| match run {
            Run::Windows(windows, at) if self.window == Some(*at) => work(windows),
            Run::Windows(..) => Err(Failure::state(GONE)),
            Run::Session(_) => Err(Failure::state(NO_WINDOW)),
        };
        py.detach(|| self.run.write(changed))
    }

    fn correct(&self, py: Python<'_>, correction: Correction) -> Result<()> {
        match self.window {
            None => self.change(py, |session| Ok(session.correct(&correction)?)),
            Some(_) => self.change_window(py, |windows| Ok(windows.correct(&correction)?)),
        }
    }
}

#[pymethods]
impl Session {
    #[new]
    fn new(params: &Bound<'_, PyDict>) -> Result<Self> {
        let session = tracecut::Session::new(params_from(params)?)?;
        Ok(Self { run: Shared::new(Run::Session(Box::new(session))), window: None, sources: None })
    }

    fn push(&self, py: Python<'_>, frame: &Bound<'_, PyAny>) -> Result<()> {
        let params = self.run.read(|run| Ok(run.session().params().clone()))?;
        let frame = image_from(frame, &params)?;
        self.change(py, |session| Ok(session.push_frame(frame)?))
    }

    #[allow(clippy::too_many_arguments, reason = "the columns of the Python class")]
    fn set_trajectories(
        &self,
        py: Python<'_>,
        num_frames: usize,
        size: (usize, usize),
        start_frame: Vec<u32>,
        offset: Vec<u32>,
        x: &Bound<'_, PyArray1<f32>>,
        y: &Bound<'_, PyArray1<f32>>,
    ) -> Result<()> {
        let (x, y) = (x.to_vec().map_err(PyErr::from)?, y.to_vec().map_err(PyErr::from)?);
        let variation = vec![0.0; x.len()];
        let tracks = Trajectories { num_frames, size, start_frame, offset, x, y, variation };
        self.change(py, |session| Ok(session.set_trajectories(tracks)?))
    }

    /// Stage, steps done and steps in all; `None` when nothing is left to do.
    fn step(&self, py: Python<'_>) -> Result<Option<(&'static str, u32, u32)>> {
        self.change(py, |session| match session.step()? {
            Step::Working(progress) => Ok(Some((progress.stage.name(), progress.done, progress.total))),
            Step::Done => Ok(None),
        })
    }

    fn run(&self, py: Python<'_>, threads: usize, listener: Option<Py<PyAny>>) -> Result<()> {
        let mut outcome = Ok(());
        let goes_on = |progress| {
            outcome = report(listener.as_ref(), progress);
            outcome.is_ok()
        };
        match self.window {
            None => self.change(py, |session| Ok(session.run_while(threads, goes_on)?)),
            Some(_) => self.change_window(py, |windows| Ok(windows.rerun_while(threads, goes_on)?)),
        }?;
        outcome
    }

    fn clear(&self, py: Python<'_>) -> Result<()> {
        self.change(py, |session| {
            session.clear();
            Ok(())
        })
    }

    fn merge(&self, py: Python<'_>, into: u8, from: u8) -> Result<()> {
        self.correct(py, Correction::Merge { into, from })
    }

    fn split(&self, py: Python<'_>, label: u8, at: Option<(usize, f32, f32)>) -> Result<()> {
        self.correct(py, Correction::Split { label, at })
    }

    fn strokes(&self, py: Python<'_>, apart: bool, strokes: Vec<RawStroke>) -> Result<()> {
        let stroke = |(t, radius, points): RawStroke| {
            let points = points.chunks_exact(2).map(|p| (p[0], p[1])).collect();
            Stroke { t, points, radius }
        };
        let strokes = strokes.into_iter().map(stroke).collect();
        self.correct(py, if apart { Correction::SplitStrokes(strokes) } else { Correction::JoinStrokes(strokes) })
    }

    fn undo_correction(&self, py: Python<'_>) -> Result<()> {
        match self.window {
            None => self.change(py, |session| Ok(session.undo_correction()?)),
            Some(_) => self.change_window(py, |windows| Ok(windows.undo_correction()?)),
        }
    }

    fn params<'py>(&self, py: Python<'py>) -> Result<Bound<'py, PyDict>> {
        self.read(|session| params_in_force(py, session.params()))
    }

    /// Frames, size of the input, size at which it is processed (both width, height; 0 before the first frame), and
    /// corrections in force.
    fn info(&self) -> Result<Info> {
        self.read(|session| {
            let (input, working) = (session.input_size(), session.working_size());
            let corrections = session.num_corrections();
            Ok((session.num_frames(), input.unwrap_or_default(), working.unwrap_or_default(), corrections))
        })
    }

    fn flow<'py>(&self, py: Python<'py>, t: usize) -> Result<arrays::FlowArrays<'py>> {
        Ok(arrays::flow(py, self.compute(py, |session| session.flow(t))?))
    }

    fn trajectories<'py>(&self, py: Python<'py>) -> Result<Option<Bound<'py, PyDict>>> {
        self.read(|session| {
            let numbers = session.trajectory_numbers();
            session.trajectories().map(|t| arrays::trajectories(py, t, numbers)).transpose()
        })
    }

    /// The denser trajectories that masks are made from, in pixels of the working size.
    fn mask_trajectories<'py>(&self, py: Python<'py>) -> Result<Option<Bound<'py, PyDict>>> {
        self.read(|session| session.mask_trajectories().map(|t| arrays::trajectories(py, t, &[])).transpose())
    }

    /// Offsets of the rows, columns, values: a symmetric matrix.
    #[allow(clippy::type_complexity, reason = "the three arrays of a sparse matrix")]
    fn affinities<'py>(
        &self,
        py: Python<'py>,
    ) -> Result<Option<(Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f32>>)>> {
        let arrays = |a: &SymCsr| (copy(py, &a.offset), copy(py, &a.column), copy(py, &a.value));
        self.read(|session| Ok(session.affinities().map(arrays)))
    }

    fn embedding<'py>(&self, py: Python<'py>) -> Result<Option<Bound<'py, PyDict>>> {
        self.read(|session| {
            let Some(e) = session.embedding() else { return Ok(None) };
            let fields = PyDict::new(py);
            fields.set_item("eigenvalues", copy(py, &e.eigenvalues))?;
            fields.set_item("vectors", matrix(py, e.num_rows, e.dimensions, e.vectors.clone()))?;
            fields.set_item("embedded", copy(py, &e.embedded))?;
            fields.set_item("converged", e.info.converged)?;
            fields.set_item("residual", e.info.residual)?;
            Ok(Some(fields))
        })
    }

    fn discontinuities<'py>(&self, py: Python<'py>) -> Result<Option<Bound<'py, PyDict>>> {
        self.read(|session| {
            let Some(discontinuities) = session.discontinuities() else { return Ok(None) };
            let neighborhoods = &discontinuities.neighborhoods;
            let pairs = neighborhoods.pairs.iter().flat_map(|&(i, j)| [i, j]).collect();
            let fields = PyDict::new(py);
            fields.set_item("pair", matrix::<u32>(py, neighborhoods.pairs.len(), 2, pairs))?;
            fields.set_item("d", copy(py, &discontinuities.d))?;
            fields.set_item("frame_offset", copy(py, &neighborhoods.frame_offset))?;
            fields.set_item("frame_edge", copy(py, &neighborhoods.frame_edges))?;
            Ok(Some(fields))
        })
    }

    fn saliency<'py>(&self, py: Python<'py>) -> Result<Option<Bound<'py, PyDict>>> {
        self.read(|session| {
            let Some(found) = session.saliency() else { return Ok(None) };
            let fields = PyDict::new(py);
            fields.set_item("of_points", copy(py, &found.of_points))?;
            fields.set_item("in_context", copy(py, &found.in_context))?;
            fields.set_item("foreground", copy(py, &found.foreground))?;
            Ok(Some(fields))
        })
    }

    fn saliency_map<'py>(&self, py: Python<'py>, t: usize) -> Result<Bound<'py, PyArray2<f32>>> {
        Ok(plane(py, self.compute(py, |session| session.saliency_map(t))?))
    }

    /// Returns the number of components of each frame, and the component of each point, -1 for none.
    #[allow(clippy::type_complexity, reason = "two arrays")]
    fn components<'py>(
        &self,
        py: Python<'py>,
    ) -> Result<Option<(Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<i32>>)>> {
        let number = |component: &Option<u32>| component.map_or(-1, |number| number as i32);
        self.read(|session| {
            Ok(session.components().map(|c| (copy(py, &c.count), list(py, c.of_point.iter().map(number).collect()))))
        })
    }

    fn clusters<'py>(&self, py: Python<'py>) -> Result<Option<(usize, Bound<'py, PyArray1<u32>>)>> {
        self.read(|session| Ok(session.clusters().map(|c| (c.count, copy(py, &c.label)))))
    }

    fn threshold_clusters<'py>(&self, py: Python<'py>) -> Result<Option<(usize, Bound<'py, PyArray1<u32>>)>> {
        let clusters = self.compute(py, |session| Ok(session.threshold_clusters()))?;
        Ok(clusters.map(|c| (c.count, list(py, c.label))))
    }

    fn motion_clusters<'py>(&self, py: Python<'py>) -> Result<Option<(usize, Bound<'py, PyArray1<u32>>)>> {
        let clusters = self.compute(py, tracecut::Session::motion_clusters)?;
        Ok(clusters.map(|c| (c.count, list(py, c.label))))
    }

    /// `method` is a name; `count` must be legal.
    fn clusters_by<'py>(
        &self,
        py: Python<'py>,
        method: &str,
        count: usize,
    ) -> Result<Option<(usize, Bound<'py, PyArray1<u32>>)>> {
        let method = method_of(method)?;
        let clusters = self.compute(py, |session| Ok(session.clusters_by(method, count)))?;
        Ok(clusters.map(|c| (c.count, list(py, c.label))))
    }

    fn explain<'py>(&self, py: Python<'py>, t: usize, x: usize, y: usize) -> Result<Bound<'py, PyDict>> {
        explanation(py, &self.compute(py, |session| session.explain(t, (x, y)))?)
    }

    fn superpixels<'py>(&self, py: Python<'py>, t: usize) -> Result<Bound<'py, PyDict>> {
        self.read(|session| arrays::superpixels(py, session.superpixels(t)?))
    }

    fn boundaries<'py>(&self, py: Python<'py>, t: usize) -> Result<arrays::FlowArrays<'py>> {
        Ok(arrays::boundaries(py, self.compute(py, |session| session.boundaries(t))?))
    }

    /// Mask label of each cluster.
    fn objects<'py>(&self, py: Python<'py>) -> Result<Option<Bound<'py, PyArray1<u8>>>> {
        self.read(|session| Ok(session.objects().map(|o| copy(py, &o.of_cluster))))
    }

    /// With the frame as it was before it was reduced, borders are where that has them.
    fn labels<'py>(
        &self,
        py: Python<'py>,
        t: usize,
        picture: Option<&Bound<'py, PyAny>>,
    ) -> Result<Bound<'py, PyArray2<u8>>> {
        let picture = picture.map(frame_from).transpose()?;
        let source = || self.sources.as_ref().and_then(|(sources, first)| sources.get(first + t));
        let mask = self.compute(py, |session| match picture.or_else(source) {
            Some(picture) if session.working_size() != session.input_size() => {
                Ok(enlarge(session.working_labels(t)?, &picture, |_| false)?.labels)
            }
            _ => session.labels(t),
        })?;
        Ok(plane(py, mask))
    }

    fn working_labels<'py>(&self, py: Python<'py>, t: usize) -> Result<Bound<'py, PyArray2<u8>>> {
        Ok(plane(py, self.compute(py, |session| session.working_labels(t).cloned())?))
    }

    fn cluster_labels<'py>(&self, py: Python<'py>, t: usize) -> Result<Bound<'py, PyArray2<u32>>> {
        Ok(plane(py, self.compute(py, |session| session.cluster_labels(t))?))
    }

    fn agreement<'py>(&self, py: Python<'py>) -> Result<Option<AgreementArrays<'py>>> {
        let agreement = self.compute(py, |session| Ok(session.agreement().cloned()))?;
        let values = |values: &[Option<f32>]| list(py, values.iter().map(|v| v.unwrap_or(f32::NAN)).collect());
        Ok(agreement.map(|a| (values(&a.frames), a.objects.iter().map(|frames| values(frames)).collect())))
    }

    fn doubts(&self, py: Python<'_>) -> Result<Vec<(usize, usize)>> {
        let doubts = self.compute(py, |session| Ok(session.agreement().map(Agreement::doubts)))?;
        Ok(doubts.unwrap_or_default().into_iter().map(|doubt| (doubt.start, doubt.end)).collect())
    }

    fn background<'py>(&self, py: Python<'py>, t: usize) -> Result<Bound<'py, PyArray3<u8>>> {
        Ok(arrays::pixels(py, self.compute(py, |session| session.background(t))?))
    }

    /// `objects.csv` of the command line: box, area, centre and motion of each object in each frame, and its time in seconds
    /// where `times` has it.
    fn object_table(&self, py: Python<'_>, times: Option<Vec<f64>>) -> Result<String> {
        let time_of = |t: usize| times.as_ref().and_then(|times| times.get(t).copied());
        self.compute(py, |session| {
            let mut rows = Vec::new();
            let doubts = session.agreement().map(Agreement::doubts);
            if let Some(tracks) = session.trajectories() {
                for t in 0..session.num_frames() {
                    let doubt = doubts.as_ref().map(|doubts| doubts.iter().any(|doubt| doubt.contains(&t)));
                    let frame_rows = object_rows(&session.labels(t)?, tracks, t).into_iter();
                    rows.extend(frame_rows.map(|row| ObjectRow { time: time_of(t), doubt, ..row }));
                }
            }
            Ok(object_table(&rows))
        })
    }
}

/// Of all objects as one, then of each object, for each frame.
type AgreementArrays<'py> = (Bound<'py, PyArray1<f32>>, Vec<Bound<'py, PyArray1<f32>>>);

fn method_of(name: &str) -> Result<DiscretizeMethod> {
    let names = DiscretizeMethod::NAMES;
    let Some(index) = names.iter().position(|&method| method == name) else {
        let expected = format!("one of {}", names.join(", "));
        return Err(Error::Param { name: "method".to_owned(), value: format!("{name:?}"), expected }.into());
    };
    Ok(DiscretizeMethod::at(index))
}
