//! Hints for each URDF error.

use std::io::ErrorKind;

use crate::UrdfError;

/// The hint of an error.
pub(crate) fn hint(error: &UrdfError) -> Option<String> {
    let text = match error {
        UrdfError::Unreadable { cause, .. } => match cause.kind() {
            ErrorKind::NotFound => "check the path; it is relative to the current directory".into(),
            ErrorKind::IsADirectory => "name the .urdf file inside it".into(),
            ErrorKind::PermissionDenied => "allow reading the file".into(),
            _ => return None,
        },
        UrdfError::NotUtf8 { utf16: true, .. } => {
            "the file looks like UTF-16: save it as UTF-8".into()
        }
        UrdfError::NotUtf8 { .. } => "save the file as UTF-8, and check that it is a URDF".into(),
        UrdfError::Empty { .. } => "copy or write the file again: it is empty".into(),
        UrdfError::NotXml { advice, .. }
        | UrdfError::BadValue { advice, .. }
        | UrdfError::Mjcf { advice, .. } => advice.clone(),
        UrdfError::NotRobot { found, .. } => other_format(found).into(),
        UrdfError::Xacro { place, .. } => {
            format!(
                "expand it: `xacro {} > expanded.urdf`, then use expanded.urdf (without ROS: `pip install xacro`)",
                place.source
            )
        }
        UrdfError::NoLinks { misspelt: Some(element), .. }
        | UrdfError::SeveralRoots { misspelt: Some(element), .. } => {
            format!("correct `<{}>` in line {} if it is misspelt", element.tag, element.line)
        }
        UrdfError::NoLinks { .. } => {
            "check that this is the right file: a URDF lists its links directly inside `<robot>`"
                .into()
        }
        UrdfError::MissingAttribute { similar: Some(similar), attribute, .. } => {
            format!("did you mean `{attribute}` instead of `{similar}`?")
        }
        UrdfError::MissingAttribute { tag: "inertia", attribute, .. } => {
            format!("write all six; {attribute}=\"0\" only if it is known to be zero")
        }
        UrdfError::MissingAttribute { tag, attribute, .. } => {
            format!("write `<{tag} {attribute}=\"...\">`")
        }
        UrdfError::ConflictingAttributes { first, second, .. } => {
            format!("remove `{first}` or `{second}`")
        }
        UrdfError::MissingElement { similar: Some(similar), tag, .. } => {
            format!("did you mean `<{tag}>` instead of `<{similar}>`?")
        }
        UrdfError::MissingElement { parent: "inertial", tag, .. } => {
            format!("add `<{tag}>`, or remove `<inertial>` if the link has no mass")
        }
        UrdfError::MissingElement { tag, .. } => format!("add `<{tag} link=\"...\"/>`"),
        UrdfError::RepeatedElement { tag: "inertial", .. } => {
            "keep one, or move the second body to a separate link with a fixed joint".into()
        }
        UrdfError::RepeatedElement { .. } => "remove one of the two".into(),
        UrdfError::DuplicateName { tag, .. } => format!("rename or remove one of the two {tag}s"),
        UrdfError::UnknownLink { similar: Some(similar), .. }
        | UrdfError::UnknownMimicJoint { similar: Some(similar), .. } => {
            format!("did you mean `{similar}`?")
        }
        UrdfError::UnknownLink { name, .. } => format!("add `<link name=\"{name}\"/>`"),
        UrdfError::UnknownMimicJoint { .. } => {
            "use the name of a joint in the file, or remove `<mimic>`".into()
        }
        UrdfError::MimicLoop { .. } => "remove `<mimic>` from the leading joint".into(),
        UrdfError::SelfJoint { .. } => "set the child to the link that the joint moves".into(),
        UrdfError::TwoParents { .. } => {
            "remove one of the joints; a URDF cannot describe closed chains".into()
        }
        UrdfError::Loop { .. } => {
            "cut the loop by removing one joint; a URDF cannot describe closed chains".into()
        }
        UrdfError::SeveralRoots { .. } => {
            "connect them by joints (type fixed if nothing moves), or remove all but one".into()
        }
        UrdfError::ZeroAxis { .. } => {
            "set the direction of the joint, such as xyz=\"0 0 1\", or make the joint fixed".into()
        }
        UrdfError::Refused { .. } => return None,
    };
    Some(text)
}

fn other_format(root: &str) -> &'static str {
    match root {
        "sdf" => "this is SDF, the format of Gazebo; use the URDF of the same arm or export one",
        "mujoco" => "this is MJCF, the format of MuJoCo: give the file its extension .xml",
        "COLLADA" => "this is a COLLADA mesh or scene; use the URDF that refers to it",
        "launch" => "this is a ROS launch file; use the URDF that it loads",
        _ => "use the URDF of the arm; its first element is `<robot name=\"...\">`",
    }
}
