//! The supported part of the URDF format as a table: elements, attributes and value types.

/// Type of an attribute value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// A name, not empty.
    Name,
    /// Any text.
    Text,
    /// One of the six joint types.
    JointType,
    /// One finite number.
    Number,
    /// One finite number, zero or positive.
    NotNegative,
    /// As many finite numbers.
    Numbers(usize),
}

/// The joint types of the format.
pub(super) const JOINT_TYPES: [&str; 6] =
    ["revolute", "continuous", "prismatic", "fixed", "floating", "planar"];

impl Form {
    /// The form in words, to follow "must be".
    pub(super) fn expected(self) -> &'static str {
        match self {
            Self::Name => "a name",
            Self::Text => "a text",
            Self::JointType => "one of revolute, continuous, prismatic, fixed, floating and planar",
            Self::Number => "a number",
            Self::NotNegative => "zero or a positive number",
            Self::Numbers(3) => "three numbers",
            Self::Numbers(4) => "four numbers",
            Self::Numbers(_) => "a list of numbers",
        }
    }
}

/// One attribute of an element.
#[derive(Debug)]
pub(super) struct AttributeRule {
    pub(super) name: &'static str,
    pub(super) form: Form,
    pub(super) required: bool,
}

/// How often an element occurs inside its parent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Count {
    Optional,
    Required,
    Many,
}

/// Who reads an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Reader {
    /// `urdf-rs`.
    UrdfRs,
    /// This crate, because `urdf-rs` does not distinguish an absent attribute from zero.
    Armident,
    /// Not read: part of the format without influence on the result; its content is not checked.
    Nobody,
}

/// One element of the format.
#[derive(Debug)]
pub(super) struct ElementRule {
    pub(super) tag: &'static str,
    pub(super) count: Count,
    pub(super) reader: Reader,
    pub(super) attributes: &'static [AttributeRule],
    pub(super) children: &'static [ElementRule],
}

const fn required(name: &'static str, form: Form) -> AttributeRule {
    AttributeRule { name, form, required: true }
}

const fn optional(name: &'static str, form: Form) -> AttributeRule {
    AttributeRule { name, form, required: false }
}

const fn element(
    tag: &'static str,
    count: Count,
    attributes: &'static [AttributeRule],
    children: &'static [ElementRule],
) -> ElementRule {
    ElementRule { tag, count, reader: Reader::UrdfRs, attributes, children }
}

const fn unused(tag: &'static str) -> ElementRule {
    ElementRule { tag, count: Count::Many, reader: Reader::Nobody, attributes: &[], children: &[] }
}

const ORIGIN: ElementRule = element(
    "origin",
    Count::Optional,
    &[
        optional("xyz", Form::Numbers(3)),
        optional("rpy", Form::Numbers(3)),
        optional("quat_xyzw", Form::Numbers(4)),
    ],
    &[],
);

const INERTIAL: ElementRule = element(
    "inertial",
    Count::Optional,
    &[],
    &[
        ORIGIN,
        element("mass", Count::Required, &[required("value", Form::NotNegative)], &[]),
        element(
            "inertia",
            Count::Required,
            &[
                required("ixx", Form::Number),
                required("ixy", Form::Number),
                required("ixz", Form::Number),
                required("iyy", Form::Number),
                required("iyz", Form::Number),
                required("izz", Form::Number),
            ],
            &[],
        ),
    ],
);

/// `<link>`.
pub(super) static LINK: ElementRule = element(
    "link",
    Count::Many,
    // `type` is a relic of early ROS that old files still carry
    &[required("name", Form::Name), optional("type", Form::Text)],
    &[INERTIAL, unused("visual"), unused("collision")],
);

const LIMIT: ElementRule = ElementRule {
    tag: "limit",
    count: Count::Optional,
    reader: Reader::Armident,
    attributes: &[
        optional("lower", Form::Number),
        optional("upper", Form::Number),
        optional("effort", Form::Number),
        optional("velocity", Form::Number),
        optional("acceleration", Form::Number),
        optional("deceleration", Form::Number),
        optional("jerk", Form::Number),
    ],
    children: &[],
};

/// `<joint>`.
pub(super) static JOINT: ElementRule = element(
    "joint",
    Count::Many,
    &[required("name", Form::Name), required("type", Form::JointType)],
    &[
        ORIGIN,
        element("parent", Count::Required, &[required("link", Form::Name)], &[]),
        element("child", Count::Required, &[required("link", Form::Name)], &[]),
        element("axis", Count::Optional, &[required("xyz", Form::Numbers(3))], &[]),
        LIMIT,
        element(
            "dynamics",
            Count::Optional,
            &[optional("damping", Form::Number), optional("friction", Form::Number)],
            &[],
        ),
        element(
            "mimic",
            Count::Optional,
            &[
                required("joint", Form::Name),
                optional("multiplier", Form::Number),
                optional("offset", Form::Number),
            ],
            &[],
        ),
        unused("calibration"),
        unused("safety_controller"),
    ],
);
