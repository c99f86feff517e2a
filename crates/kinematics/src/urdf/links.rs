//! Masses and inertias of the links.

use nalgebra::Matrix3;
use roxmltree::Node;

use super::notes::{Concerned, Notes, four_digits};
use super::pose::{UrdfVersion, read_pose};
use super::shapes::read_shapes;
use super::tree::{Tree, child};
use super::xml::UrdfText;
use crate::error::UrdfError;
use crate::{InertialDescription, LinkDescription};

/// Tolerance of the consistency conditions relative to the largest principal moment: files print
/// few digits, and thin plates and rods lie on the border.
const INERTIA_TOLERANCE: f64 = 1e-6;

/// One link, with notes on an inconsistent inertia.
pub(super) fn read_link(
    text: &UrdfText<'_>,
    node: Node<'_, '_>,
    link: &urdf_rs::Link,
    version: UrdfVersion,
    name: &str,
    notes: &mut Notes,
) -> Result<LinkDescription, UrdfError> {
    let line = text.line(node);
    // urdf-rs gives zeros for a link without <inertial>
    let inertial = match child(node, "inertial") {
        None => None,
        Some(element) => {
            let urdf = &link.inertial;
            let concerned =
                Concerned { kind: "link", name: name.to_owned(), line: text.line(element) };
            let mut note = |code: &'static str, sentence: String| {
                notes.add(code, concerned.clone(), sentence);
            };
            let origin = child(element, "origin");
            let (com_in_link_m, rpy_rad) =
                read_pose(text, origin, &urdf.origin, version, &mut note)?;
            let i = &urdf.inertia;
            let inertial = InertialDescription {
                mass_kg: urdf.mass.value,
                com_in_link_m,
                rpy_rad,
                inertia_kgm2: [i.ixx, i.ixy, i.ixz, i.iyy, i.iyz, i.izz],
            };
            note_inertia(&inertial, &mut note);
            Some(inertial)
        }
    };
    let collisions = read_shapes(node, name);
    Ok(LinkDescription { name: name.to_owned(), inertial, collisions, line })
}

fn note_inertia(inertial: &InertialDescription, note: &mut impl FnMut(&'static str, String)) {
    let inertia = &inertial.inertia_kgm2;
    if inertial.mass_kg == 0.0 && inertia.iter().any(|&entry| entry != 0.0) {
        let sentence = "mass 0 with a non-zero inertia; used as is";
        note("mass-zero-inertia", sentence.to_owned());
    }
    if let Some(fault) = inertia_fault(inertia) {
        note(
            "inertia-unphysical",
            format!("inertia is not physically consistent ({fault}); used as is"),
        );
    }
}

/// Why an inertia about the centre of mass \[kg m2\] is not physically consistent: principal moments
/// must not be negative and none may exceed the sum of the others. `None` if it is consistent.
fn inertia_fault(&[xx, xy, xz, yy, yz, zz]: &[f64; 6]) -> Option<String> {
    let tensor = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let scale = tensor.amax();
    if scale == 0.0 {
        return None;
    }
    // scaled, so that tiny and huge entries neither vanish nor overflow
    let mut moments: [f64; 3] = (tensor / scale).symmetric_eigenvalues().into();
    moments.sort_by(f64::total_cmp);
    let [least, middle, most] = moments;
    // rounding errors relative to the largest are shown as zero
    let shown = moments.map(|m| four_digits(if m.abs() < 1e-12 { 0.0 } else { m * scale }));
    let relation = if least < -INERTIA_TOLERANCE {
        "include a negative one"
    } else if most - least - middle > INERTIA_TOLERANCE * most {
        "violate the triangle inequality"
    } else {
        return None;
    };
    Some(format!("principal moments {} kg m2 {relation}", shown.join(", ")))
}

/// Notes moving bodies without `<inertial>`.
///
/// A pure frame, such as a tool point fixed to a link with mass, is not a body: a link counts if
/// nothing fixed to it has an `<inertial>` either, or if it has a shape.
pub(super) fn note_massless_bodies(
    tree: &Tree<'_>,
    nodes: &[Node<'_, '_>],
    links: &[LinkDescription],
    is_fixed: impl Fn(usize) -> bool,
    notes: &mut Notes,
) {
    let group = tree.rigid_groups(is_fixed);
    let mut group_has_inertial = vec![false; links.len()];
    for (i, link) in links.iter().enumerate() {
        group_has_inertial[group[i]] |= link.inertial.is_some();
    }
    for (i, link) in links.iter().enumerate() {
        let moves = group[i] != tree.root;
        let has_shape =
            child(nodes[i], "visual").or_else(|| child(nodes[i], "collision")).is_some();
        if moves && link.inertial.is_none() && (has_shape || !group_has_inertial[group[i]]) {
            let concerned = Concerned { kind: "link", name: link.name.clone(), line: link.line };
            notes.add("no-inertial", concerned, "no `<inertial>`; treated as massless");
        }
    }
}
