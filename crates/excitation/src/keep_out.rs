//! Regions that the arm keeps out of, as a user gives them.

use serde::{Deserialize, Serialize};

use crate::error::ExcitationError;

/// A box, or the far side of a plane, in the axes of the base link. A box has `centre`, `size` and perhaps `rpy`; a plane
/// has `point` and `normal`, which points to the side where the arm moves.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KeepOut {
    /// Centre of a box \[m\].
    pub centre: Option<[f64; 3]>,
    /// Edges of a box \[m\].
    pub size: Option<[f64; 3]>,
    /// Roll, pitch, yaw of a box \[rad\].
    pub rpy: Option<[f64; 3]>,
    /// A point of a plane \[m\].
    pub point: Option<[f64; 3]>,
    /// Normal of a plane, towards the free side; of any length.
    pub normal: Option<[f64; 3]>,
}

/// A checked region.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Region {
    Cuboid { centre_m: [f64; 3], rpy_rad: [f64; 3], half_edges_m: [f64; 3] },
    HalfSpace { point_m: [f64; 3], normal: [f64; 3] },
}

impl KeepOut {
    /// The region.
    ///
    /// # Errors
    /// [`ExcitationError::KeepOut`]: keys of both kinds or of neither, edges that are not positive, no direction.
    pub(crate) fn region(&self, name: &str) -> Result<Region, ExcitationError> {
        let fault = |key: &'static str, found: String, expected: &'static str| {
            Err(ExcitationError::KeepOut { name: name.to_owned(), key, found, expected })
        };
        let keys = [
            ("centre", self.centre),
            ("size", self.size),
            ("rpy", self.rpy),
            ("point", self.point),
            ("normal", self.normal),
        ];
        for (key, value) in keys {
            if let Some(value) = value.filter(|v| v.iter().any(|x| !x.is_finite())) {
                return fault(key, format!("{value:?}"), "three finite numbers");
            }
        }
        match (self.centre, self.size, self.point, self.normal) {
            (Some(centre_m), Some(size), None, None) => {
                if size.iter().any(|edge| *edge <= 0.0) {
                    return fault("size", format!("{size:?}"), "three positive lengths [m]");
                }
                let rpy_rad = self.rpy.unwrap_or([0.0; 3]);
                Ok(Region::Cuboid { centre_m, rpy_rad, half_edges_m: size.map(|edge| 0.5 * edge) })
            }
            (None, None, Some(point_m), Some(normal)) if self.rpy.is_none() => {
                let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
                if !(length.is_finite() && length > f64::MIN_POSITIVE.sqrt()) {
                    return fault("normal", format!("{normal:?}"), "a direction that is not zero");
                }
                Ok(Region::HalfSpace { point_m, normal: normal.map(|x| x / length) })
            }
            _ => {
                let given = keys.iter().filter(|(_, value)| value.is_some());
                let found: Vec<&str> = given.map(|(key, _)| *key).collect();
                let found = if found.is_empty() { "none".to_owned() } else { found.join(", ") };
                fault(
                    "keys",
                    found,
                    "centre and size (with rpy or without) of a box, or point and normal of a plane",
                )
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a failed test may panic")]
mod tests {
    use super::*;

    #[test]
    fn regions_are_boxes_or_planes() {
        let table = KeepOut { centre: Some([0.0; 3]), size: Some([1.0; 3]), ..KeepOut::default() };
        assert!(table.region("table").is_ok());
        let wall =
            KeepOut { point: Some([0.0; 3]), normal: Some([0.0, 0.0, 2.0]), ..KeepOut::default() };
        assert!(matches!(
            wall.region("wall"),
            Ok(Region::HalfSpace { normal: [0.0, 0.0, 1.0], .. })
        ));
        let wrong = [
            KeepOut::default(),
            KeepOut { size: Some([1.0, 0.0, 1.0]), ..table },
            KeepOut { centre: Some([f64::NAN; 3]), ..table },
            KeepOut { normal: Some([0.0; 3]), ..wall },
            KeepOut { point: Some([0.0; 3]), ..table },
        ];
        for region in wrong {
            let error = region.region("shelf").unwrap_err().to_string();
            assert!(error.contains("`shelf`"), "{error}");
        }
    }
}
