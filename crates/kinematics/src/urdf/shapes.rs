//! Primitives of `<collision>`, where they are well formed: a file with other shapes is as good for all else.

use roxmltree::Node;

use super::check::numbers;
use super::tree::child;
use super::xml::urdf_tag;
use crate::description::pose;
use crate::{CollisionGeometry, CollisionShape};

/// The shapes of a link in its frame.
pub(super) fn read_shapes(node: Node<'_, '_>, link: &str) -> Vec<CollisionShape> {
    node.children().filter(|n| urdf_tag(*n) == Some("collision")).map(|n| shape(n, link)).collect()
}

fn shape(node: Node<'_, '_>, link: &str) -> CollisionShape {
    let of = |geometry, pose| CollisionShape { link: link.to_owned(), pose, geometry };
    let unread =
        |tag: &str| of(CollisionGeometry::NotRead(tag.to_owned()), pose([0.0; 3], [0.0; 3]));
    let form = child(node, "geometry").and_then(|g| g.children().find(Node::is_element));
    let Some(form) = form else { return unread("geometry") };
    let tag = form.tag_name().name();
    let origin = child(node, "origin");
    // a quaternion is not read: the shape would be elsewhere
    let triple = |name: &str| match origin.and_then(|o| o.attribute(name)) {
        Some(text) => numbers::<3>(text).filter(|values| values.iter().all(|x| x.is_finite())),
        None => Some([0.0; 3]),
    };
    let has_quat = origin.is_some_and(|o| o.has_attribute("quat_xyzw"));
    let (Some(xyz), Some(rpy), false) = (triple("xyz"), triple("rpy"), has_quat) else {
        return unread(tag);
    };
    match geometry(form, tag) {
        Some(geometry) => of(geometry, pose(xyz, rpy)),
        None => unread(tag),
    }
}

fn geometry(form: Node<'_, '_>, tag: &str) -> Option<CollisionGeometry> {
    let positive = |x: f64| (x.is_finite() && x > 0.0).then_some(x);
    let length = |name: &str| positive(numbers::<1>(form.attribute(name)?)?[0]);
    match tag {
        "box" => {
            let edges = numbers::<3>(form.attribute("size")?)?;
            edges
                .iter()
                .all(|edge| positive(*edge).is_some())
                .then(|| CollisionGeometry::Cuboid { half_edges_m: edges.map(|edge| 0.5 * edge) })
        }
        "cylinder" => Some(CollisionGeometry::Cylinder {
            radius_m: length("radius")?,
            length_m: length("length")?,
        }),
        "sphere" => Some(CollisionGeometry::Sphere { radius_m: length("radius")? }),
        _ => None,
    }
}
