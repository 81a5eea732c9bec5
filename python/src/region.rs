//! Boxes, as Python has them: sequences of numbers.

use crate::refused;
use pyo3::prelude::*;
use trackfail_judge::region::Region;

/// Number of the top left pixel, checked.
///
/// # Errors
/// Another number than 0 or 1.
pub fn origin(base: i64) -> PyResult<u8> {
    match base {
        0 => Ok(0),
        1 => Ok(1),
        _ => Err(refused(format!("base: want 0 or 1, the number of the top left pixel, not {base}"))),
    }
}

/// The region of a box whose top left pixel is `base`; `None` where it is `None`, or has one or NaN among its numbers.
///
/// # Errors
/// An object that is no sequence of numbers, and numbers that are no region.
pub fn region(given: &Bound<'_, PyAny>, what: &str, base: f64) -> PyResult<Option<Region>> {
    if given.is_none() {
        return Ok(None);
    }
    let numbers: Vec<Option<f64>> = given.extract().map_err(|_| {
        refused(format!(
            "{what}: want the numbers x, y, w, h, or the corners of a convex polygon, x1, y1, x2, y2, ..."
        ))
    })?;
    let Some(mut numbers) = numbers.into_iter().collect::<Option<Vec<f64>>>() else { return Ok(None) };
    if numbers.iter().any(|number| number.is_nan()) {
        return Ok(None);
    }
    // The sides of a box do not depend on where pixels begin to count.
    let places = if numbers.len() == 4 { 2 } else { numbers.len() };
    numbers.iter_mut().take(places).for_each(|place| *place -= base);
    let region = Region::from_numbers(&numbers);
    region.map(Some).map_err(|e| refused(format!("{what}: {e}; for a tracker that has no box, give None")))
}

/// The regions of the frames of a track.
///
/// # Errors
/// An object that cannot be iterated, and the first box that is refused, with its frame.
pub fn track(given: &Bound<'_, PyAny>, what: &str, base: f64) -> PyResult<Vec<Option<Region>>> {
    let of = |(t, given): (usize, PyResult<Bound<'_, PyAny>>)| {
        region(&given?, &format!("{what}, frame {t}"), base)
    };
    given.try_iter()?.enumerate().map(of).collect()
}
