//! Errors of URDF files: fault, place and hint.

use std::fmt;
use std::ops::Range;

use crate::IgnoredElement;

/// Place of a fault: file, line and the link or joint it belongs to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UrdfPlace {
    /// Path or label of the text.
    pub source: String,
    /// Line in the file, from 1; `None` when the fault concerns the file as a whole.
    pub line: Option<u32>,
    /// The link or joint, as ``joint `elbow` ``.
    pub element: Option<String>,
    /// Faulty bytes of the text, if known: an attribute, or the start of a tag.
    pub span: Option<Range<usize>>,
}

impl fmt::Display for UrdfPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.source)?;
        if let Some(line) = self.line {
            write!(f, ", line {line}")?;
        }
        if let Some(element) = &self.element {
            write!(f, ", {element}")?;
        }
        Ok(())
    }
}

/// A URDF that cannot be used.
///
/// `Display` states what was expected and found, [`place`](Self::place) the file and line, and
/// [`hint`](Self::hint) the remedy: the lines `error:`, `in:` and `hint:` of a message.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UrdfError {
    /// The file cannot be opened or read.
    #[error("cannot read the file: {}", io_reason(cause))]
    Unreadable {
        /// The path.
        place: Box<UrdfPlace>,
        /// Error of the operating system.
        #[source]
        cause: std::io::Error,
    },
    /// The text is not UTF-8.
    #[error("the text must be UTF-8, found byte 0x{byte:02X} at offset {offset}")]
    NotUtf8 {
        /// Line of the first wrong byte.
        place: Box<UrdfPlace>,
        /// Offset of the first wrong byte, from 0.
        offset: usize,
        /// The wrong byte.
        byte: u8,
        /// Whether the text starts with the byte order mark of UTF-16.
        utf16: bool,
    },
    /// Nothing but white space.
    #[error("expected a URDF, found an empty text")]
    Empty {
        /// The file.
        place: Box<UrdfPlace>,
    },
    /// Not well-formed XML.
    #[error("the text must be well-formed XML: {found}")]
    NotXml {
        /// Line at which reading stopped.
        place: Box<UrdfPlace>,
        /// Message of the XML reader.
        found: String,
        /// Hint for the user.
        advice: String,
    },
    /// XML of another format.
    #[error("the root element must be `<robot>`, found `<{found}>`")]
    NotRobot {
        /// Line of the root element.
        place: Box<UrdfPlace>,
        /// Tag of the root element.
        found: String,
    },
    /// MJCF that is not read, or whose values have no meaning.
    #[error("{what}")]
    Mjcf {
        /// The element or attribute.
        place: Box<UrdfPlace>,
        /// What was expected and found.
        what: String,
        /// Hint for the user.
        advice: String,
    },
    /// A xacro file that was not expanded.
    #[error("expected a URDF, found unexpanded xacro: `{found}`")]
    Xacro {
        /// The first piece of xacro.
        place: Box<UrdfPlace>,
        /// The element or expression.
        found: String,
    },
    /// A `<robot>` without any `<link>`.
    #[error("`<robot>` must have at least one `<link>`, found none")]
    NoLinks {
        /// Line of `<robot>`.
        place: Box<UrdfPlace>,
        /// A child of `<robot>` that may be a misspelt link or joint.
        misspelt: Option<IgnoredElement>,
    },
    /// An attribute that must be present is not.
    #[error("`<{tag}>` needs the attribute `{attribute}`{}, found none", bracketed(expected))]
    MissingAttribute {
        /// The element.
        place: Box<UrdfPlace>,
        /// Its tag.
        tag: &'static str,
        /// The missing attribute.
        attribute: &'static str,
        /// What the attribute holds.
        expected: &'static str,
        /// An unknown attribute of the element with a similar name.
        similar: Option<String>,
    },
    /// An attribute whose value has no meaning.
    #[error("`{attribute}` of `<{tag}>` must be {expected}, found `{found}`")]
    BadValue {
        /// The attribute.
        place: Box<UrdfPlace>,
        /// Tag of its element.
        tag: &'static str,
        /// The attribute.
        attribute: &'static str,
        /// What the attribute holds.
        expected: &'static str,
        /// Text in the file.
        found: String,
        /// Hint for the user.
        advice: String,
    },
    /// Two attributes that exclude each other.
    #[error("`<{tag}>` must have either `{first}` or `{second}`, found both")]
    ConflictingAttributes {
        /// The element.
        place: Box<UrdfPlace>,
        /// Its tag.
        tag: &'static str,
        /// One attribute.
        first: &'static str,
        /// The other.
        second: &'static str,
    },
    /// A child element that must be present is not.
    #[error("`<{parent}>` needs the element `<{tag}>`, found none")]
    MissingElement {
        /// The element that lacks the child.
        place: Box<UrdfPlace>,
        /// Tag of the element that lacks the child.
        parent: &'static str,
        /// Tag of the missing child.
        tag: &'static str,
        /// An unknown child with a similar tag.
        similar: Option<String>,
    },
    /// A child element that may occur once occurs twice.
    #[error("`<{tag}>` must occur once in `<{parent}>`, found a second one (first: line {first})")]
    RepeatedElement {
        /// The second occurrence.
        place: Box<UrdfPlace>,
        /// Tag of the element around it.
        parent: &'static str,
        /// The repeated tag.
        tag: &'static str,
        /// Line of the first occurrence.
        first: u32,
    },
    /// Two links or two joints of one name.
    #[error("{tag} names must be unique, found `{name}` again (first: line {first})")]
    DuplicateName {
        /// The second occurrence.
        place: Box<UrdfPlace>,
        /// `link` or `joint`.
        tag: &'static str,
        /// The name.
        name: String,
        /// Line of the first occurrence.
        first: u32,
    },
    /// A joint names a link that does not exist.
    #[error("the {role} must be a link of the file, found `{name}`")]
    UnknownLink {
        /// The `<parent>` or `<child>` element.
        place: Box<UrdfPlace>,
        /// `parent` or `child`.
        role: &'static str,
        /// The name that no link has.
        name: String,
        /// The link with the most similar name.
        similar: Option<String>,
    },
    /// A joint mimics a joint that does not exist.
    #[error("`joint` of `<mimic>` must be a joint of the file, found `{name}`")]
    UnknownMimicJoint {
        /// The `<mimic>` element.
        place: Box<UrdfPlace>,
        /// The name that no joint has.
        name: String,
        /// The joint with the most similar name.
        similar: Option<String>,
    },
    /// Joints that mimic each other in a circle, or one that mimics itself.
    #[error("cyclic `<mimic>`: {}", arrows(joints))]
    MimicLoop {
        /// The `<mimic>` element.
        place: Box<UrdfPlace>,
        /// Joint names; each mimics the next, the last is the first again.
        joints: Vec<String>,
    },
    /// A joint whose parent and child are the same link.
    #[error("parent and child must be different links, found `{link}` for both")]
    SelfJoint {
        /// The joint.
        place: Box<UrdfPlace>,
        /// The link.
        link: String,
    },
    /// A link that is the child of two joints.
    #[error(
        "a link must be the child of one joint only, found `{link}` again \
         (first: joint `{first_joint}`, line {first})"
    )]
    TwoParents {
        /// The second joint.
        place: Box<UrdfPlace>,
        /// The link.
        link: String,
        /// The first joint.
        first_joint: String,
        /// Line of the first joint.
        first: u32,
    },
    /// Links in a closed loop.
    #[error("the links must form a tree, found the loop {}", arrows(links))]
    Loop {
        /// A joint of the loop.
        place: Box<UrdfPlace>,
        /// Link names from parent to child; the last is the first again.
        links: Vec<String>,
    },
    /// More than one link without a parent joint.
    #[error("exactly one link must have no parent joint, found {}", listed(roots))]
    SeveralRoots {
        /// The file.
        place: Box<UrdfPlace>,
        /// The links without a parent joint, in file order.
        roots: Vec<String>,
        /// A child of `<robot>` that may be a misspelt link or joint.
        misspelt: Option<IgnoredElement>,
    },
    /// The axis of a movable joint has no direction.
    #[error("the axis must be a vector longer than 1e-9, found `{found}`")]
    ZeroAxis {
        /// The `<axis>` element.
        place: Box<UrdfPlace>,
        /// Text of its `xyz`.
        found: String,
    },
    /// Error of the URDF parser in a file that passed the checks.
    #[error("URDF parser error: {found}")]
    Refused {
        /// The file.
        place: Box<UrdfPlace>,
        /// Its message.
        found: String,
    },
}

impl UrdfError {
    /// Place of the fault, as ``arm.urdf, line 12, joint `elbow` ``.
    pub fn place(&self) -> String {
        self.urdf_place().to_string()
    }

    /// Place of the fault, in parts.
    pub fn urdf_place(&self) -> &UrdfPlace {
        match self {
            Self::Unreadable { place, .. }
            | Self::NotUtf8 { place, .. }
            | Self::Empty { place }
            | Self::NotXml { place, .. }
            | Self::NotRobot { place, .. }
            | Self::Mjcf { place, .. }
            | Self::Xacro { place, .. }
            | Self::NoLinks { place, .. }
            | Self::MissingAttribute { place, .. }
            | Self::BadValue { place, .. }
            | Self::ConflictingAttributes { place, .. }
            | Self::MissingElement { place, .. }
            | Self::RepeatedElement { place, .. }
            | Self::DuplicateName { place, .. }
            | Self::UnknownLink { place, .. }
            | Self::UnknownMimicJoint { place, .. }
            | Self::MimicLoop { place, .. }
            | Self::SelfJoint { place, .. }
            | Self::TwoParents { place, .. }
            | Self::Loop { place, .. }
            | Self::SeveralRoots { place, .. }
            | Self::ZeroAxis { place, .. }
            | Self::Refused { place, .. } => place,
        }
    }

    /// Hint for the user.
    pub fn hint(&self) -> Option<String> {
        crate::urdf::hint(self)
    }
}

fn io_reason(cause: &std::io::Error) -> String {
    use std::io::ErrorKind;
    match cause.kind() {
        ErrorKind::NotFound => "no such file".to_owned(),
        ErrorKind::PermissionDenied => "permission denied".to_owned(),
        ErrorKind::IsADirectory => "it is a directory".to_owned(),
        _ => cause.to_string(),
    }
}

fn bracketed(expected: &str) -> String {
    // "attribute `name` (a name)" is redundant
    if expected == "a name" { String::new() } else { format!(" ({expected})") }
}

fn arrows(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" -> ")
}

fn listed(names: &[String]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}
