//! Origins and directions: what `<origin>` and `<axis>` hold, in the versions of the format.

use nalgebra::{Quaternion, Rotation3, UnitQuaternion};
use roxmltree::Node;

use super::check::numbers;
use super::xml::UrdfText;
use crate::error::UrdfError;

/// The `version` attribute of `<robot>`: major, minor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct UrdfVersion(u32, u32);

impl UrdfVersion {
    /// Orientations may be quaternions from here on.
    pub(super) const QUATERNION: Self = Self(1, 1);
    /// Each limit may be left out from here on; before, `lower` and `upper` default to 0.
    pub(super) const OPEN_LIMITS: Self = Self(1, 2);

    /// Version 1.0 where the attribute is absent or malformed, as other readers do.
    pub(super) fn of(robot: Node<'_, '_>) -> Self {
        let parse = |text: &str| {
            let (major, minor) = text.trim().split_once('.')?;
            Some(Self(major.parse().ok()?, minor.parse().ok()?))
        };
        robot.attribute("version").and_then(parse).unwrap_or(Self(1, 0))
    }
}

/// `xyz` \[m\] and `rpy` \[rad\] of an origin; zeros where the file has none.
pub(super) fn read_pose(
    text: &UrdfText<'_>,
    node: Option<Node<'_, '_>>,
    urdf: &urdf_rs::Pose,
    version: UrdfVersion,
    note: &mut impl FnMut(&'static str, String),
) -> Result<([f64; 3], [f64; 3]), UrdfError> {
    let quat = node.and_then(|n| Some((n, n.attribute("quat_xyzw")?)));
    let Some((node, found)) = quat else { return Ok((*urdf.xyz, *urdf.rpy)) };
    if version < UrdfVersion::QUATERNION {
        let sentence = "ignored attribute `quat_xyzw` of `<origin>`; it requires \
                        `<robot version=\"1.1\">`";
        note("element-ignored", sentence.to_owned());
        return Ok((*urdf.xyz, *urdf.rpy));
    }
    if node.has_attribute("rpy") {
        return Err(UrdfError::ConflictingAttributes {
            place: text.place_of(node),
            tag: "origin",
            first: "rpy",
            second: "quat_xyzw",
        });
    }
    let rpy = numbers::<4>(found).and_then(rpy_from_quat).ok_or_else(|| UrdfError::BadValue {
        place: text.place_of_attribute(node, "quat_xyzw"),
        tag: "origin",
        attribute: "quat_xyzw",
        expected: "a quaternion x y z w that is not zero",
        found: found.to_owned(),
        advice: "for no rotation write 0 0 0 1".to_owned(),
    })?;
    Ok((*urdf.xyz, rpy))
}

/// Roll, pitch, yaw \[rad\] of a quaternion x, y, z, w; `None` if it is zero.
fn rpy_from_quat(xyzw: [f64; 4]) -> Option<[f64; 3]> {
    let (xyzw, _) = unit_vector(xyzw)?;
    let rotation = UnitQuaternion::from_quaternion(Quaternion::from(xyzw)).to_rotation_matrix();
    Some(roll_pitch_yaw(&rotation))
}

/// Roll, pitch, yaw \[rad\] of a rotation `Rz(yaw) Ry(pitch) Rx(roll)`, as URDF writes it.
///
/// urdf-rs sets the pitch to 90 degrees within 0.26 degrees of it; here every angle is exact.
pub fn roll_pitch_yaw(rotation: &Rotation3<f64>) -> [f64; 3] {
    let r = rotation.matrix();
    let yaw = r[(1, 0)].atan2(r[(0, 0)]);
    let pitch = (-r[(2, 0)]).atan2(r[(0, 0)].hypot(r[(1, 0)]));
    // roll after yaw is undone, so that both agree where pitch is 90 degrees
    let (sin, cos) = yaw.sin_cos();
    let roll = (sin * r[(0, 2)] - cos * r[(1, 2)]).atan2(cos * r[(1, 1)] - sin * r[(0, 1)]);
    [roll, pitch, yaw]
}

/// The unit vector along a vector, and its length; `None` below 1e-9, where a direction printed
/// with the digits of a file is mere rounding.
pub(super) fn unit_vector<const N: usize>(vector: [f64; N]) -> Option<([f64; N], f64)> {
    let largest = vector.iter().fold(0.0_f64, |max, entry| max.max(entry.abs()));
    if largest < 1e-9 {
        return None;
    }
    // scaled first, so that huge entries do not overflow
    let scaled = vector.map(|entry| entry / largest);
    let norm = scaled.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
    Some((scaled.map(|entry| entry / norm), largest * norm))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quaternion_rpy_rebuilds_its_rotation() {
        for from_right in [0.0, 1e-12, 1e-9, 1e-6, 1.8e-3, 0.4, 2.0, 3.1] {
            let pitch = std::f64::consts::FRAC_PI_2 - from_right;
            for (roll, yaw) in [(0.0, 0.0), (0.3, -2.5), (-3.0, 1.0), (1.0, 1.0)] {
                let rotation = Rotation3::from_euler_angles(roll, pitch, yaw);
                let q = UnitQuaternion::from_rotation_matrix(&rotation);
                let [r, p, y] =
                    rpy_from_quat([3.0 * q.i, 3.0 * q.j, 3.0 * q.k, 3.0 * q.w]).unwrap();
                let rebuilt = Rotation3::from_euler_angles(r, p, y);
                let error = (rebuilt.matrix() - rotation.matrix()).amax();
                assert!(error < 1e-14, "{roll} {pitch} {yaw}: {error:e}");
            }
        }
    }

    #[test]
    fn extreme_lengths_normalise_exactly() {
        assert_eq!(unit_vector([0.0, 1e300, 0.0]).unwrap(), ([0.0, 1.0, 0.0], 1e300));
        assert!(unit_vector([1e-12, 0.0, 0.0]).is_none());
        let (unit, norm) = unit_vector([3.0, 0.0, -4.0]).unwrap();
        assert!((norm - 5.0).abs() < 1e-15 && (unit[2] + 0.8).abs() < 1e-15);
    }
}
