//! Links and joints by name, and the checks that they form one tree.

use std::collections::HashMap;

use roxmltree::Node;

use super::xml::{UrdfText, most_similar, urdf_tag};
use crate::error::UrdfError;

/// The checked structure of the file; lists are in file order.
pub(super) struct Tree<'a> {
    pub(super) link_names: Vec<&'a str>,
    pub(super) joint_names: Vec<&'a str>,
    /// Parent and child link of each joint.
    pub(super) ends: Vec<(usize, usize)>,
    /// The link without a parent joint.
    pub(super) root: usize,
}

impl<'a> Tree<'a> {
    /// Checks names and structure of the `<link>` and `<joint>` elements.
    pub(super) fn new(
        text: &UrdfText<'_>,
        links: &[Node<'a, '_>],
        joints: &[Node<'a, '_>],
    ) -> Result<Self, UrdfError> {
        let Some(robot) = links.first().and_then(Node::parent) else {
            return Err(UrdfError::NoLinks { place: text.whole(), misspelt: None });
        };
        let link_index = unique_names(text, links, "link")?;
        let joint_index = unique_names(text, joints, "joint")?;
        let mut ends = Vec::with_capacity(joints.len());
        for &joint in joints {
            ends.push((
                link_of(text, joint, "parent", links, &link_index)?,
                link_of(text, joint, "child", links, &link_index)?,
            ));
        }
        let tree = Self {
            link_names: links.iter().map(|&link| name_of(link)).collect(),
            joint_names: joints.iter().map(|&joint| name_of(joint)).collect(),
            ends,
            root: 0,
        };
        check_mimics(text, joints, &joint_index)?;
        let parent_joint = tree.parent_joints(text, joints)?;
        tree.check_loops(text, joints, &parent_joint)?;
        let roots: Vec<usize> =
            (0..links.len()).filter(|&link| parent_joint[link].is_none()).collect();
        match roots[..] {
            [root] => Ok(Self { root, ..tree }),
            _ => Err(UrdfError::SeveralRoots {
                place: text.place(text.line(robot), None),
                roots: roots.iter().map(|&link| tree.link_names[link].to_owned()).collect(),
                misspelt: None,
            }),
        }
    }

    /// The joint above each link.
    fn parent_joints(
        &self,
        text: &UrdfText<'_>,
        joints: &[Node<'a, '_>],
    ) -> Result<Vec<Option<usize>>, UrdfError> {
        let mut above = vec![None; self.link_names.len()];
        for (joint, &(parent, child)) in self.ends.iter().enumerate() {
            let place = || text.place_of(joints[joint]);
            let link = self.link_names[child].to_owned();
            if parent == child {
                return Err(UrdfError::SelfJoint { place: place(), link });
            }
            if let Some(first) = above[child].replace(joint) {
                return Err(UrdfError::TwoParents {
                    place: place(),
                    link,
                    first_joint: self.joint_names[first].to_owned(),
                    first: text.line(joints[first]),
                });
            }
        }
        Ok(above)
    }

    /// Going up from every link must end at a root.
    fn check_loops(
        &self,
        text: &UrdfText<'_>,
        joints: &[Node<'a, '_>],
        above: &[Option<usize>],
    ) -> Result<(), UrdfError> {
        let up = |link: usize| above[link].map(|joint| self.ends[joint].0);
        let Some(path) = cycle(self.link_names.len(), up) else { return Ok(()) };
        // from parent to child, starting with the link that comes first in the file
        let links: Vec<usize> = rotated_to_first(path.into_iter().rev().collect());
        let joint = links.iter().filter_map(|&link| above[link]).min().unwrap_or(0);
        Err(UrdfError::Loop {
            place: text.place_of(joints[joint]),
            links: closed(&links, &self.link_names),
        })
    }

    /// For each link, the highest link that is fixed to it through fixed joints.
    pub(super) fn rigid_groups(&self, is_fixed: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut below: Vec<Vec<usize>> = vec![Vec::new(); self.link_names.len()];
        for (joint, &(parent, _)) in self.ends.iter().enumerate() {
            below[parent].push(joint);
        }
        let mut group: Vec<usize> = (0..self.link_names.len()).collect();
        let mut open = vec![self.root];
        while let Some(link) = open.pop() {
            for &joint in &below[link] {
                let child = self.ends[joint].1;
                if is_fixed(joint) {
                    group[child] = group[link];
                }
                open.push(child);
            }
        }
        group
    }
}

fn name_of<'a>(node: Node<'a, '_>) -> &'a str {
    node.attribute("name").unwrap_or_default()
}

/// Index of each name.
fn unique_names<'a>(
    text: &UrdfText<'_>,
    nodes: &[Node<'a, '_>],
    tag: &'static str,
) -> Result<HashMap<&'a str, usize>, UrdfError> {
    let mut index = HashMap::with_capacity(nodes.len());
    for (i, &node) in nodes.iter().enumerate() {
        if let Some(first) = index.insert(name_of(node), i) {
            return Err(UrdfError::DuplicateName {
                place: text.place_of(node),
                tag,
                name: name_of(node).to_owned(),
                first: text.line(nodes[first]),
            });
        }
    }
    Ok(index)
}

/// The first child element of a tag.
pub(super) fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|&c| urdf_tag(c) == Some(tag))
}

/// Index of the link that `<parent>` or `<child>` names.
fn link_of<'a>(
    text: &UrdfText<'_>,
    joint: Node<'a, '_>,
    role: &'static str,
    links: &[Node<'a, '_>],
    index: &HashMap<&str, usize>,
) -> Result<usize, UrdfError> {
    let end = child(joint, role);
    let name = end.and_then(|e| e.attribute("link")).unwrap_or_default();
    index.get(name).copied().ok_or_else(|| UrdfError::UnknownLink {
        place: text.place_of(end.unwrap_or(joint)),
        role,
        name: name.to_owned(),
        similar: most_similar(name, links.iter().map(|&l| name_of(l))),
    })
}

/// Every mimicked joint exists, and no joint follows itself.
fn check_mimics(
    text: &UrdfText<'_>,
    joints: &[Node<'_, '_>],
    index: &HashMap<&str, usize>,
) -> Result<(), UrdfError> {
    let mut leads = vec![None; joints.len()];
    for (joint, &node) in joints.iter().enumerate() {
        let Some(mimic) = child(node, "mimic") else { continue };
        let name = mimic.attribute("joint").unwrap_or_default();
        let lead = index.get(name).copied().ok_or_else(|| {
            // a joint is no candidate to mimic itself
            let others = joints.iter().map(|&j| name_of(j)).filter(|&j| j != name_of(node));
            UrdfError::UnknownMimicJoint {
                place: text.place_of(mimic),
                name: name.to_owned(),
                similar: most_similar(name, others),
            }
        })?;
        leads[joint] = Some(lead);
    }
    let Some(path) = cycle(joints.len(), |joint| leads[joint]) else { return Ok(()) };
    let path = rotated_to_first(path);
    let names: Vec<&str> = joints.iter().map(|&joint| name_of(joint)).collect();
    let first = joints[path[0]];
    Err(UrdfError::MimicLoop {
        place: text.place_of(child(first, "mimic").unwrap_or(first)),
        joints: closed(&path, &names),
    })
}

/// A cycle of the map `next` on `0..count`, if there is one.
fn cycle(count: usize, next: impl Fn(usize) -> Option<usize>) -> Option<Vec<usize>> {
    // number of the walk that came by; 0: none yet
    let mut walk = vec![0; count];
    for start in 0..count {
        let mut at = Some(start);
        while let Some(node) = at.filter(|&node| walk[node] == 0) {
            walk[node] = start + 1;
            at = next(node);
        }
        if let Some(first) = at.filter(|&node| walk[node] == start + 1) {
            let rest = std::iter::successors(next(first), |&node| next(node));
            return Some(std::iter::once(first).chain(rest.take_while(|&n| n != first)).collect());
        }
    }
    None
}

fn rotated_to_first(mut path: Vec<usize>) -> Vec<usize> {
    let start = (0..path.len()).min_by_key(|&i| path[i]).unwrap_or(0);
    path.rotate_left(start);
    path
}

fn closed(path: &[usize], names: &[&str]) -> Vec<String> {
    path.iter().chain(path.first()).map(|&i| names[i].to_owned()).collect()
}
