//! Inertial errors of every link.

use armident_effects::Draw;
use armident_kinematics::{DrivingAxisChain, InertialParameters};
use nalgebra::{Matrix3, Vector3};

use crate::random::RandomStream;

/// Changes mass, centre of mass and inertia of every link by relative errors of this scale.
pub(crate) fn changed_links(chain: &mut DrivingAxisChain, scale: f64, random: &mut RandomStream) {
    if scale == 0.0 {
        return;
    }
    for joint in &mut chain.joints {
        let link = joint.link;
        let mass = link.mass_kg * (1.0 + scale * random.normal()).max(0.2);
        let centre = link.com_m();
        let reach = scale * (centre.norm() / 3.0_f64.sqrt() + 0.01);
        let centre = centre + Vector3::from_fn(|_, _| reach * random.normal());
        // stretched along the axes, so that it stays a body's
        let stretch = Vector3::from_fn(|_, _| 1.0 + 0.5 * scale * random.normal());
        let stretch = Matrix3::from_diagonal(&stretch);
        let inertia = stretch * link.inertia_com_kgm2() * stretch;
        joint.link = InertialParameters::from_com(mass, centre, inertia);
    }
}
