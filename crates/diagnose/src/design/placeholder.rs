//! Inertials without a measurement: what is written where a file needs some.
//!
//! Relative errors of such links mean nothing for the arm. Instead of them stand links of the lengths of the chain, as heavy as
//! those of large arms: a prior that is too wide costs little where recordings determine a link, one that is too narrow
//! holds it at a number without meaning.
//!
//! References: own.

use armident_kinematics::{DrivingAxisChain, InertialParameters};
use nalgebra::{Matrix3, Vector3};

/// Mass of a link of which nothing is known \[kg\]: those of arms for 5 to 20 kg weigh 1 to 20 kg.
const MASS_KG: f64 = 5.0;
/// Least length of it \[m\]: frames of wrists coincide, their links do not.
const LENGTH_M: f64 = 0.3;
/// Share of the links that are equal from which on none was measured: two arms of the same segments are built, three are not.
const EQUAL_SHARE: f64 = 0.6;
const FEWEST_EQUAL: usize = 3;
/// Relative difference below which two links are equal: the digits of a file.
const DIGITS: f64 = 1e-6;
/// Largest radius of gyration over the reach of the arm: 1 kg m² of a link of 1 kg is a ring of a metre.
const WIDEST: f64 = 1.0;

/// Whether the inertial of each link is a placeholder: no mass or no inertia, one wider than the arm reaches, or the same for
/// most links.
pub(crate) fn placeholders(chain: &DrivingAxisChain) -> Vec<bool> {
    let links: Vec<InertialParameters> = chain.joints.iter().map(|joint| joint.link).collect();
    let reach: f64 = lengths(chain).iter().sum::<f64>().max(LENGTH_M);
    let spread = |link: &InertialParameters| link.inertia_com_kgm2().trace();
    let near = |a: f64, b: f64| (a - b).abs() <= DIGITS * a.abs().max(b.abs());
    let equal = |a: &InertialParameters, b: &InertialParameters| {
        near(a.mass_kg, b.mass_kg) && near(spread(a), spread(b))
    };
    let alike = |link: &InertialParameters| links.iter().filter(|other| equal(link, other)).count();
    let most = links.iter().map(alike).max().unwrap_or(0);
    if most >= FEWEST_EQUAL && most as f64 >= EQUAL_SHARE * links.len() as f64 {
        return vec![true; links.len()];
    }
    let is_one = |link: &InertialParameters| {
        // half the trace is the second moment about the centre
        let gyration = (0.5 * spread(link) / link.mass_kg).sqrt();
        link.mass_kg == 0.0 || spread(link) == 0.0 || gyration > WIDEST * reach
    };
    links.iter().map(is_one).collect()
}

/// Distance of the axis of each joint from the one before, along the link between \[m\].
fn lengths(chain: &DrivingAxisChain) -> Vec<f64> {
    chain.joints.iter().map(|joint| joint.frame.b_m.hypot(joint.frame.d_m)).collect()
}

/// The links to which errors are relative: those given, and a body of its length for each placeholder.
pub(crate) fn sizes_of_links(chain: &DrivingAxisChain) -> Vec<InertialParameters> {
    let lengths = lengths(chain);
    (chain.joints.iter().zip(placeholders(chain)).enumerate())
        .map(|(k, (joint, is_placeholder))| {
            if !is_placeholder {
                return joint.link;
            }
            let length = lengths.get(k + 1).copied().unwrap_or(0.0).max(LENGTH_M);
            let along = chain.joints.get(k + 1).map_or_else(Vector3::z, |next| {
                let (sin, cos) = next.frame.beta_rad.sin_cos();
                Vector3::new(next.frame.b_m, -sin * next.frame.d_m, cos * next.frame.d_m)
            });
            let along = along.try_normalize(f64::EPSILON).unwrap_or_else(Vector3::z);
            let given = joint.link.com_m();
            let known = given.iter().all(|x| x.is_finite()) && given.norm() > 0.0;
            let centre = if known { given } else { along * (0.5 * length) };
            // what is too large must be able to vanish
            let inertia = Matrix3::identity() * (MASS_KG * length * length)
                + if known {
                    joint.link.inertia_com_kgm2()
                } else {
                    joint.link.inertia_origin_kgm2
                };
            InertialParameters::from_com(MASS_KG.max(joint.link.mass_kg), centre, inertia)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_arms::ur5;

    /// A UR5 whose links are all this one.
    fn all(link: InertialParameters) -> DrivingAxisChain {
        let mut chain = ur5();
        chain.joints.iter_mut().for_each(|joint| joint.link = link);
        chain
    }

    #[test]
    fn given_links_of_arm_are_no_placeholders() {
        let chain = ur5();
        assert_eq!(placeholders(&chain), [false; 6]);
        let given: Vec<InertialParameters> = chain.joints.iter().map(|joint| joint.link).collect();
        assert_eq!(sizes_of_links(&chain), given);
    }

    #[test]
    fn equal_empty_and_wide_links_are_placeholders() {
        let body = |mass: f64, inertia: f64| {
            InertialParameters::from_com(mass, Vector3::zeros(), Matrix3::identity() * inertia)
        };
        for link in [body(0.1, 1e-3), body(1.0, 1.0), InertialParameters::zero()] {
            let chain = all(link);
            assert_eq!(placeholders(&chain), [true; 6]);
            assert!(sizes_of_links(&chain).iter().all(|size| size.mass_kg == MASS_KG));
        }
        let mut chain = ur5();
        chain.joints[3].link = body(1.0, 10.0);
        assert_eq!(placeholders(&chain), [false, false, false, true, false, false]);
    }
}
