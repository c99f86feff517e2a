//! USD: an overlay with the masses and joint losses of a robot, as text.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use armident_effects::{Export, Library};
use armident_model::ArmModel;
use nalgebra::{Matrix3, Rotation3, SymmetricEigen, UnitQuaternion};

use crate::chain::{Moved, gravity_note, inertia_about_com, moved, notes};
use crate::xml::number;
use crate::{Exported, Held, effects};

/// Angles of joints are degrees in USD.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;
const STATIC: &str = "staticFrictionEffort";
const DYNAMIC: &str = "dynamicFrictionEffort";
const VISCOUS: &str = "viscousFrictionCoefficient";

/// The model as an overlay of the USD of a robot: mass, centre of mass and inertia of links, rotor inertia and friction of joints.
///
/// Prims are `/<robot>/<link>` and `/<robot>/joints/<joint>`, as the URDF importer of Isaac Sim names them. The overlay is a
/// sublayer above the file of the robot, whose units are metres and kilograms.
pub fn usd(model: &ArmModel) -> Exported {
    usd_in(Library::standard(), model)
}

/// The model as an overlay, whose effects are of this library.
pub fn usd_in(library: &Library, model: &ArmModel) -> Exported {
    let (held, lost) = effects::sorted(library, &model.effects, attribute_of);
    let mut remarks = notes(model);
    remarks.extend(gravity_note(model, "the overlay has no gravity"));
    let (chain, _) = moved(model);
    let robot = identifier(&model.chain.robot, &mut remarks);
    remarks.push(format!(
        "prims are /{robot}/<link> and /{robot}/joints/<joint>, as the URDF importer of Isaac Sim names them"
    ));
    let mut text = "#usda 1.0\n(\n".to_owned();
    let origin: Vec<String> = model.provenance.iter().map(|line| quoted(line)).collect();
    if !origin.is_empty() {
        let _ = writeln!(text, "    doc = \"{}\"", origin.join("; "));
    }
    let _ = write!(
        text,
        "    defaultPrim = \"{robot}\"\n    kilogramsPerUnit = 1\n    metersPerUnit = 1\n    upAxis = \"Z\"\n)\n\nover \
         \"{robot}\"\n{{\n"
    );
    let mut known = BTreeSet::new();
    for link in &chain {
        let name = identifier(link.link, &mut remarks);
        if !known.insert(name.clone()) {
            remarks.push(format!(
                "two links are named `{name}` in USD; the second replaces the first"
            ));
        }
        text += &mass(link, &name, &mut remarks);
    }
    text += "    over \"joints\"\n    {\n";
    for link in &chain {
        let name = identifier(link.joint, &mut remarks);
        text += &joint(link, &name, &held);
    }
    text += "    }\n}\n";
    Exported { text, companion: None, held, lost, notes: remarks }
}

/// The attribute of PhysX that holds what MJCF holds in an attribute of a joint.
fn attribute_of(export: &Export) -> Option<&'static str> {
    match export.mjcf? {
        "damping" => Some(VISCOUS),
        "frictionloss" => Some(DYNAMIC),
        "armature" => Some("armature"),
        _ => None,
    }
}

fn mass(link: &Moved<'_>, name: &str, notes: &mut Vec<String>) -> String {
    let [xx, xy, xz, yy, yz, zz] = inertia_about_com(link, notes);
    let (principal, axes) = principal_axes(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz));
    if principal.iter().any(|moment| *moment <= 0.0) {
        notes.push(format!(
            "link `{}` has no extent: its inertia is computed from shapes by the simulator",
            link.link
        ));
    }
    let com = link.inertia.com_m();
    let q = axes.quaternion();
    let list = |values: &[f64]| -> String {
        // single precision holds no more
        let clean = |x: &f64| number(if x.abs() < 1e-15 { 0.0 } else { *x });
        values.iter().map(clean).collect::<Vec<_>>().join(", ")
    };
    let (com, principal) = (list(com.as_slice()), list(&principal));
    let (mass, turn) = (number(link.inertia.mass_kg), list(&[q.w, q.i, q.j, q.k]));
    format!(
        "    over \"{name}\" (\n        prepend apiSchemas = [\"PhysicsMassAPI\"]\n    )\n    {{\n        point3f \
         physics:centerOfMass = ({com})\n        float3 physics:diagonalInertia = ({principal})\n        float \
         physics:mass = {mass}\n        quatf physics:principalAxes = ({turn})\n    }}\n\n"
    )
}

/// Principal moments, and the rotation from the principal axes.
fn principal_axes(inertia: Matrix3<f64>) -> ([f64; 3], UnitQuaternion<f64>) {
    let SymmetricEigen { eigenvectors, eigenvalues } = inertia.symmetric_eigen();
    let mut axes = eigenvectors;
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    ([eigenvalues[0], eigenvalues[1], eigenvalues[2]], turn)
}

fn joint(link: &Moved<'_>, name: &str, held: &[Held]) -> String {
    let attributes = effects::attributes(held, link.joint);
    if attributes.is_empty() {
        return String::new();
    }
    let is_rotational = link.kind.is_rotational();
    let axis = if is_rotational { "angular" } else { "linear" };
    let mut text = format!(
        "        over \"{name}\" (\n            prepend apiSchemas = [\"PhysxJointAxisAPI:{axis}\"]\n        )\n        {{\n"
    );
    for (attribute, value) in attributes {
        // per degree a second
        let value = if attribute == VISCOUS && is_rotational { value / DEGREES } else { value };
        let mut line = |attribute: &str| {
            let _ = writeln!(
                text,
                "            float physxJointAxis:{axis}:{attribute} = {}",
                number(value)
            );
        };
        line(attribute);
        if attribute == DYNAMIC {
            line(STATIC);
        }
    }
    text + "        }\n"
}

/// A name of a prim: letters, digits and underscores, not a digit first.
fn identifier(name: &str, notes: &mut Vec<String>) -> String {
    let plain = |letter: char| if letter.is_ascii_alphanumeric() { letter } else { '_' };
    let mut valid: String = name.chars().map(plain).collect();
    if valid.starts_with(|first: char| first.is_ascii_digit()) || valid.is_empty() {
        valid.insert(0, '_');
    }
    if valid != name {
        notes.push(format!("`{name}` is `{valid}` in USD"));
    }
    valid
}

fn quoted(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "'").replace('\n', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_prims() {
        let mut notes = Vec::new();
        assert_eq!(identifier("elbow_joint", &mut notes), "elbow_joint");
        assert!(notes.is_empty());
        assert_eq!(identifier("left/arm-2", &mut notes), "left_arm_2");
        assert_eq!(identifier("2r", &mut notes), "_2r");
        assert_eq!(notes.join("; "), "`left/arm-2` is `left_arm_2` in USD; `2r` is `_2r` in USD");
    }

    #[test]
    fn principal_axes_give_the_tensor_back() {
        let inertia = Matrix3::new(0.3, 0.02, -0.05, 0.02, 0.4, 0.01, -0.05, 0.01, 0.2);
        let (principal, axes) = principal_axes(inertia);
        let turn = axes.to_rotation_matrix();
        let again =
            turn.matrix() * Matrix3::from_diagonal(&principal.into()) * turn.matrix().transpose();
        assert!((again - inertia).norm() < 1e-15, "{again}");
    }
}
