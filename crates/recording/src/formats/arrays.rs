//! Files of named arrays (NumPy, MATLAB): from arrays to columns.

use std::collections::BTreeMap;

use super::format::ColumnRequest;
use crate::error::{Fault, RecordingError};
use crate::mapping::{looks_like_time, synonym};
use crate::raw::{RawColumn, RawColumns};

/// A named array.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Array {
    /// Its name in the file.
    pub(super) name: String,
    /// What it holds.
    pub(super) content: Content,
}

/// What an array holds.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Content {
    /// Numbers: length of each dimension, and the values with the first index running slowest.
    Numbers(Vec<usize>, Vec<f64>),
    /// Text, an entry per element.
    Texts(Vec<String>),
    /// Anything else, in words: `objects`.
    Other(String),
}

/// The columns of a file of arrays, as many rows as there are time stamps: an array of one dimension is a column, one of
/// samples by joints is a column `<name>_<number>` per joint, counted from 1. Where an array of text has a name for each
/// joint, the column is `<joint>/<name>`. Other arrays are columns without values.
///
/// # Errors
/// The names lack what the request needs, or what it needs are no numbers.
pub(super) fn columns(
    arrays: Vec<Array>,
    request: &ColumnRequest<'_>,
) -> Result<RawColumns, RecordingError> {
    let mut raw = RawColumns::new(request.source());
    let samples = samples(&arrays);
    let joints = joint_names(&arrays);
    let mut columns: Vec<(String, Result<Vec<f64>, String>)> = Vec::new();
    for array in arrays {
        let Array { name, content } = array;
        match content {
            Content::Numbers(shape, values) => match sizes(&shape) {
                [length] if *length == samples => columns.push((name, Ok(values))),
                [rows, joints_here] if *rows == samples || *joints_here == samples => {
                    // joints by samples is turned; of a square, rows are samples
                    let is_turned = *rows != samples;
                    let count = if is_turned { *rows } else { *joints_here };
                    for joint in 0..count {
                        let at = |k: usize| match is_turned {
                            true => joint * samples + k,
                            false => k * count + joint,
                        };
                        let column = (0..samples).map(|k| values[at(k)]).collect();
                        let named = joints.as_ref().filter(|names| names.len() == count);
                        let label = match named {
                            Some(names) => format!("{}/{}", names[joint], quantity_or(&name)),
                            None => format!("{name}_{}", joint + 1),
                        };
                        columns.push((label, Ok(column)));
                    }
                }
                other => {
                    let sizes: Vec<String> = other.iter().map(ToString::to_string).collect();
                    let what = match sizes.len() {
                        0 => "one number".to_owned(),
                        _ => format!("{} numbers", sizes.join(" by ")),
                    };
                    if synonym(&name.to_lowercase()).is_some() && samples > 0 {
                        raw.notes.push(format!(
                            "array `{name}` has {what}, expected {samples} by joints: not read"
                        ));
                    }
                    columns.push((name, Err(what)));
                }
            },
            Content::Texts(_) => {
                if synonym(&name.to_lowercase()).is_some() {
                    raw.notes.push(format!("array `{name}` has text, expected numbers: not read"));
                }
                columns.push((name, Err("text".to_owned())));
            }
            Content::Other(what) => columns.push((name, Err(what))),
        }
    }
    let names: Vec<String> = columns.iter().map(|(name, _)| name.clone()).collect();
    let wanted = request.wanted(&names, 0)?;
    for ((name, values), wanted) in columns.into_iter().zip(wanted) {
        let values = match values {
            Ok(values) => Some(values),
            Err(text) if wanted => {
                let fault = Fault::NotANumber { text };
                return Err(RecordingError::new(fault, request.source()).in_column(&name));
            }
            Err(_) => None,
        };
        raw.columns.push(RawColumn { name, values });
    }
    Ok(raw)
}

/// The standard name of the quantity that an array's name stands for, or else that name.
fn quantity_or(name: &str) -> &str {
    synonym(&name.to_lowercase()).map_or(name, |(quantity, _)| quantity.suffix())
}

/// Lengths other than 1: MATLAB has no arrays of one dimension.
fn sizes(shape: &[usize]) -> &[usize] {
    match shape {
        [1, rest @ ..] => sizes(rest),
        [rest @ .., 1] => sizes(rest),
        _ => shape,
    }
}

/// The number of samples: the length of the time stamps, else the length that most arrays have.
fn samples(arrays: &[Array]) -> usize {
    let mut counts: BTreeMap<usize, usize> = BTreeMap::new();
    for array in arrays {
        let Content::Numbers(shape, _) = &array.content else { continue };
        match sizes(shape) {
            [length] if looks_like_time(&array.name) => return *length,
            sizes => {
                if let Some(longest) = sizes.iter().max() {
                    *counts.entry(*longest).or_insert(0) += 1;
                }
            }
        }
    }
    counts
        .into_iter()
        .max_by_key(|(length, count)| (*count, *length))
        .map_or(0, |(length, _)| length)
}

/// Names of the joints, if an array of text has them.
fn joint_names(arrays: &[Array]) -> Option<Vec<String>> {
    arrays.iter().find_map(|array| match &array.content {
        Content::Texts(names) if names.len() > 1 => {
            let name = array.name.to_lowercase();
            let are_names = name.contains("joint") || name.contains("name");
            are_names.then(|| names.iter().map(|name| name.trim().to_owned()).collect())
        }
        _ => None,
    })
}

/// Fields without the names of their structures, where they differ without them.
pub(super) fn with_short_names(mut arrays: Vec<Array>) -> Vec<Array> {
    let short = |name: &str| name.rsplit('.').next().unwrap_or_default().to_owned();
    let names: Vec<String> = arrays.iter().map(|array| short(&array.name)).collect();
    for (array, name) in arrays.iter_mut().zip(&names) {
        if names.iter().filter(|other| *other == name).count() == 1 {
            array.name.clone_from(name);
        }
    }
    arrays
}

/// Values whose first index runs fastest, in the order of rows.
pub(super) fn by_rows(values: &[f64], shape: &[usize]) -> Vec<f64> {
    let [rows, others @ ..] = shape else { return values.to_vec() };
    let columns: usize = others.iter().product();
    if others.len() != 1 {
        return values.to_vec();
    }
    (0..values.len()).map(|k| values[(k % columns) * rows + k / columns]).collect()
}
