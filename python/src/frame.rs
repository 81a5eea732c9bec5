//! Frames, as Python has them: arrays, files of images, or decoded ones that several monitors share.

use crate::refused;
use numpy::ndarray::{ArrayViewD, Axis};
use numpy::{
    PyArray1, PyArray3, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use trackfail_judge::image::{self, MAX_FILE_BYTES, MAX_PIXELS, PixelFormat};

/// A decoded frame.
#[pyclass(frozen, module = "trackfail")]
pub struct Frame(Arc<image::Frame>);

#[pymethods]
impl Frame {
    #[new]
    #[pyo3(signature = (array, colors=None))]
    fn new(array: &Bound<'_, PyAny>, colors: Option<&str>) -> PyResult<Self> {
        Taken::of(array, order(colors)?)?.frame(array.py()).map(Self)
    }

    /// The frame of the bytes of a JPEG or PNG file.
    #[staticmethod]
    fn decode(py: Python<'_>, data: &[u8]) -> PyResult<Self> {
        let decoded = py.detach(|| image::decode(data));
        decoded.map(|frame| Self(Arc::new(frame))).map_err(|e| refused(format!("frame: {e}")))
    }

    /// Width in pixels.
    #[getter]
    fn width(&self) -> usize {
        self.0.width()
    }

    /// Height in pixels.
    #[getter]
    fn height(&self) -> usize {
        self.0.height()
    }

    /// An array of the shape (height, width, 3).
    #[pyo3(signature = (colors="rgb"))]
    fn to_numpy<'py>(&self, py: Python<'py>, colors: &str) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let mut bytes = self.0.bytes().to_vec();
        if order(Some(colors))? == Some(PixelFormat::Bgr) {
            bytes.as_chunks_mut::<3>().0.iter_mut().for_each(|pixel| pixel.swap(0, 2));
        }
        PyArray1::from_vec(py, bytes).reshape([self.0.height(), self.0.width(), 3])
    }

    fn __repr__(&self) -> String {
        format!("<trackfail.Frame of {}x{} pixels>", self.0.width(), self.0.height())
    }
}

/// The order of the bytes of a colored pixel.
///
/// # Errors
/// Another word than `rgb` or `bgr`.
pub fn order(colors: Option<&str>) -> PyResult<Option<PixelFormat>> {
    match colors {
        None => Ok(None),
        Some("rgb") => Ok(Some(PixelFormat::Rgb)),
        Some("bgr") => Ok(Some(PixelFormat::Bgr)),
        Some(other) => Err(refused(format!("colors: want \"rgb\" or \"bgr\", not \"{other}\""))),
    }
}

/// A frame that is checked but not read yet.
pub enum Taken<'py> {
    /// Decoded before.
    Shared(Arc<image::Frame>),
    /// An array.
    Pixels {
        /// Its bytes.
        array: PyReadonlyArrayDyn<'py, u8>,
        /// Width and height.
        size: (usize, usize),
        /// Order of the bytes of a pixel.
        format: PixelFormat,
    },
    /// An image file.
    File(PathBuf),
}

impl<'py> Taken<'py> {
    /// The frame of a Python object.
    ///
    /// # Errors
    /// Another object than a frame, an array or a path; an array of another type or shape, or of colors in an order that nobody
    /// has told.
    pub fn of(given: &Bound<'py, PyAny>, colors: Option<PixelFormat>) -> PyResult<Self> {
        if let Ok(frame) = given.cast::<Frame>() {
            return Ok(Self::Shared(frame.get().0.clone()));
        }
        if let Ok(array) = given.cast::<PyUntypedArray>() {
            return Self::of_array(given, array, colors);
        }
        given.extract::<PathBuf>().map(Self::File).map_err(|_| {
            let kind = given.get_type();
            let kind = kind.name().map_or_else(|_| "another object".to_string(), |name| name.to_string());
            PyTypeError::new_err(format!(
                "frame: want an array, a trackfail.Frame or the path of an image, not {kind}"
            ))
        })
    }

    fn of_array(
        given: &Bound<'py, PyAny>,
        array: &Bound<'py, PyUntypedArray>,
        colors: Option<PixelFormat>,
    ) -> PyResult<Self> {
        let Ok(bytes) = given.cast::<PyArrayDyn<u8>>() else {
            let kind = array.dtype();
            return Err(refused(format!("frame: the array has values of type {kind}; frames have uint8")));
        };
        let format = match *array.shape() {
            [_, _] => PixelFormat::Gray,
            [_, _, 3] => colors.ok_or_else(|| {
                refused("frame: say in which order its colors are: colors=\"bgr\", as OpenCV has them, or colors=\"rgb\"")
            })?,
            _ => {
                let shape = given.getattr("shape")?;
                let want = "frames have (height, width, 3) or (height, width)";
                return Err(refused(format!("frame: the array has the shape {shape}; {want}")));
            }
        };
        let size = (array.shape()[1], array.shape()[0]);
        let array = bytes.try_readonly().map_err(|e| refused(format!("frame: {e}")))?;
        Ok(Self::Pixels { array, size, format })
    }

    /// Width and height; `None` of a file, which nobody has opened.
    pub fn size(&self) -> Option<(usize, usize)> {
        match self {
            Self::Shared(frame) => Some((frame.width(), frame.height())),
            Self::Pixels { size, .. } => Some(*size),
            Self::File(_) => None,
        }
    }

    /// The frame itself. The pixels of an array are read once, into the layout that signals read.
    ///
    /// # Errors
    /// A file that cannot be read or is no image, and a frame that is empty or too large.
    pub fn frame(self, py: Python<'_>) -> PyResult<Arc<image::Frame>> {
        match self {
            Self::Shared(frame) => Ok(frame),
            Self::Pixels { array, size: (width, height), format } => {
                let mut view = array.as_array();
                let mut format = format;
                if view.ndim() == 3 && view.strides()[2] < 0 {
                    // Reversed colors, `array[..., ::-1]`: the bytes as they lie have the other order.
                    view.invert_axis(Axis(2));
                    format = if format == PixelFormat::Rgb { PixelFormat::Bgr } else { PixelFormat::Rgb };
                }
                // A view of one pixel may have any size: of a frame that is refused nothing is copied.
                let fits = (width as u64).saturating_mul(height as u64) <= MAX_PIXELS;
                let bytes = if fits { read_array(&view) } else { Vec::new() };
                // A side that is too long for the number is too long for a frame.
                let [width, height] = [width, height].map(|side| u32::try_from(side).unwrap_or(u32::MAX));
                let frame = image::Frame::from_raw(width, height, format, bytes);
                frame.map(Arc::new).map_err(|e| refused(format!("frame: {e}")))
            }
            Self::File(path) => py.detach(|| read(&path)).map(Arc::new),
        }
    }
}

/// The bytes of an array, row by row.
fn read_array(view: &ArrayViewD<'_, u8>) -> Vec<u8> {
    if let Some(bytes) = view.as_slice() {
        return bytes.to_vec();
    }
    let mut bytes = Vec::with_capacity(view.len());
    for row in view.outer_iter() {
        match row.as_slice() {
            Some(row) => bytes.extend_from_slice(row),
            None => bytes.extend(&row),
        }
    }
    bytes
}

/// The frame of an image file.
fn read(path: &Path) -> PyResult<image::Frame> {
    let name = path.display();
    let mut bytes = Vec::new();
    let all = File::open(path).and_then(|file| file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes));
    all.map_err(|e| PyErr::from(io::Error::new(e.kind(), format!("frame: {name}: {e}"))))?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(refused(format!("frame {name}: the file has more than {} MiB", MAX_FILE_BYTES >> 20)));
    }
    image::decode(&bytes).map_err(|e| refused(format!("frame {name}: {e}")))
}
