//! What malformed and doubtful URDFs are answered: one sentence, its place, and what to do.
//!
//! Every case is the arm of `arm.urdf` with one change; the snapshots are what a user reads.

#![allow(clippy::panic, reason = "a helper that meets the unexpected fails its test")]

use armident_kinematics::{UrdfError, load_urdf, parse_urdf, parse_urdf_bytes};

const ARM: &str = include_str!("arm.urdf");

const LIMIT: &str = r#"<limit lower="-3" upper="3" effort="50" velocity="2"/>"#;
const AXIS: &str = r#"<axis xyz="0 1 0"/>"#;
const DYNAMICS: &str = r#"<dynamics damping="0.1" friction="0.2"/>"#;
const MASS: &str = r#"<mass value="2.5"/>"#;
const INERTIA: &str = r#"<inertia ixx="0.04" ixy="0" ixz="0" iyy="0.04" iyz="0" izz="0.01"/>"#;

/// The arm with the first occurrence of a piece of text replaced.
fn arm_with(old: &str, new: &str) -> String {
    assert!(ARM.contains(old), "the arm has no `{old}`");
    ARM.replacen(old, new, 1)
}

/// The arm with more elements before `</robot>`.
fn arm_and(more: &str) -> String {
    arm_with("</robot>", &format!("{more}\n</robot>"))
}

/// The arm with more inside the elbow joint.
fn elbow_and(more: &str) -> String {
    arm_with(DYNAMICS, &format!("{DYNAMICS}\n    {more}"))
}

fn message(name: &str, error: &UrdfError) -> String {
    let hint = error.hint().unwrap_or_else(|| "-".to_owned());
    format!("== {name}\nerror: {error}\nin: {}\nhint: {hint}\n", error.place())
}

/// Every text is refused; the messages in one page.
fn refusals(cases: &[(&str, String)]) -> String {
    let refuse = |(name, text): &(&str, String)| match parse_urdf(text, "arm.urdf") {
        Ok(_) => panic!("{name}: accepted"),
        Err(error) => message(name, &error),
    };
    cases.iter().map(refuse).collect::<Vec<_>>().join("\n")
}

#[test]
fn rejects_text_that_is_not_urdf() {
    let xacro_root = r#"<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">"#;
    let root = r#"<robot name="arm">"#;
    let page = refusals(&[
        ("empty", String::new()),
        ("only white space", " \n\t\n".to_owned()),
        ("only a byte order mark", "\u{feff}".to_owned()),
        ("plain text", "joint,position\nshoulder,0.1\n".to_owned()),
        ("only a declaration", "<?xml version=\"1.0\"?>\n".to_owned()),
        ("cut between elements", ARM[..ARM.find("  <joint name=\"elbow\"").unwrap()].to_owned()),
        ("cut inside a tag", ARM[..ARM.find(" type=\"revolute\"").unwrap()].to_owned()),
        ("cut inside a value", ARM[..ARM.find("volute").unwrap()].to_owned()),
        ("comment cut", arm_with("</robot>", "<!-- the end")),
        ("tags crossed", arm_with("</inertial>", "</link>")),
        ("attribute twice", arm_with("value=\"2.5\"", "value=\"2.5\" value=\"3\"")),
        ("value without quotes", arm_with("value=\"2.5\"", "value=2.5")),
        ("ampersand", arm_with("name=\"arm\"", "name=\"pick & place\"")),
        ("text before the declaration", format!("\n{ARM}")),
        ("two roots", format!("{ARM}<robot name=\"other\"/>\n")),
        ("prefix not declared", arm_and("  <drake:joint name=\"x\"/>")),
        ("doctype", arm_with("<robot name", "<!DOCTYPE robot []>\n<robot name")),
        ("sdf", "<sdf version=\"1.9\"><model name=\"arm\"/></sdf>".to_owned()),
        ("mjcf", "<mujoco model=\"arm\">\n<worldbody/>\n</mujoco>".to_owned()),
        ("collada", "<COLLADA version=\"1.4.1\"/>".to_owned()),
        ("another root", "<arm><link name=\"base\"/></arm>".to_owned()),
        (
            "xacro element",
            arm_with(root, &format!("{xacro_root}\n  <xacro:include filename=\"a\"/>")),
        ),
        ("xacro, not declared", arm_and("  <xacro:arm parent=\"base\"/>")),
        ("xacro expression in a number", arm_with("\"2.5\"", "\"${2 * half_mass}\"")),
        ("xacro expression in a name", arm_with("name=\"base\"", "name=\"${prefix}base\"")),
        ("xacro argument", arm_with("name=\"base\"", "name=\"$(arg prefix)base\"")),
        ("links misspelt", "<robot name=\"arm\">\n<Link name=\"base\"/></robot>".to_owned()),
        ("no links", "<robot name=\"arm\">\n</robot>".to_owned()),
    ]);
    insta::assert_snapshot!(page);
}

#[test]
fn rejects_wrong_names_and_structure() {
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "  <joint name=\"{name}\" type=\"fixed\">\n    <parent link=\"{parent}\"/>\n    \
             <child link=\"{child}\"/>\n  </joint>"
        )
    };
    let page = refusals(&[
        ("link without name", arm_with("<link name=\"base\"/>", "<link/>")),
        ("link with empty name", arm_with("name=\"base\"", "name=\"\"")),
        ("joint without name", arm_with("<joint name=\"elbow\"", "<joint")),
        ("joint name misspelt", arm_with("joint name=\"elbow\"", "joint nmae=\"elbow\"")),
        ("two links of one name", arm_with("link name=\"forearm\"", "link name=\"upper_arm\"")),
        ("two joints of one name", arm_with("name=\"elbow\"", "name=\"shoulder\"")),
        ("joint without type", arm_with("\"elbow\" type=\"revolute\"", "\"elbow\"")),
        (
            "joint type with capital",
            arm_with("\"elbow\" type=\"revolute\"", "\"elbow\" type=\"Revolute\""),
        ),
        ("unknown joint type", arm_with("\"elbow\" type=\"revolute\"", "\"elbow\" type=\"hinge\"")),
        (
            "spherical joint",
            arm_with("\"elbow\" type=\"revolute\"", "\"elbow\" type=\"spherical\""),
        ),
        ("joint without parent", arm_with("<parent link=\"upper_arm\"/>", "")),
        (
            "parent misspelt",
            arm_with("<parent link=\"upper_arm\"/>", "<parnet link=\"upper_arm\"/>"),
        ),
        ("joint without child", arm_with("<child link=\"forearm\"/>", "")),
        ("parent as text", arm_with("<parent link=\"upper_arm\"/>", "<parent>upper_arm</parent>")),
        (
            "two parents in a joint",
            arm_with(
                "<parent link=\"upper_arm\"/>",
                "<parent link=\"upper_arm\"/><parent link=\"base\"/>",
            ),
        ),
        (
            "unknown parent, near",
            arm_with("<parent link=\"upper_arm\"/>", "<parent link=\"uper_arm\"/>"),
        ),
        (
            "unknown child, not near",
            arm_with("<child link=\"forearm\"/>", "<child link=\"gripper\"/>"),
        ),
        (
            "joint of a link with itself",
            arm_with("<child link=\"forearm\"/>", "<child link=\"upper_arm\"/>"),
        ),
        ("child of two joints", arm_and(&joint("bracket", "base", "forearm"))),
        (
            "loop beside the arm",
            arm_and(&format!(
                "  <link name=\"a\"/>\n  <link name=\"b\"/>\n{}\n{}",
                joint("ab", "a", "b"),
                joint("ba", "b", "a")
            )),
        ),
        ("loop of all links", arm_and(&joint("back", "forearm", "base"))),
        ("two roots", arm_and("  <link name=\"tool\"/>")),
        ("joints misspelt", ARM.replace("<joint", "<jiont").replace("</joint", "</jiont")),
        ("mimic of an unknown joint", elbow_and("<mimic joint=\"sholder\"/>")),
        ("mimic of an unknown joint, not near", elbow_and("<mimic joint=\"gripper\"/>")),
        ("mimic of itself", elbow_and("<mimic joint=\"elbow\"/>")),
        (
            "mimic in a circle",
            elbow_and("<mimic joint=\"shoulder\"/>")
                .replace(LIMIT, &format!("{LIMIT}\n    <mimic joint=\"elbow\"/>")),
        ),
        ("mimic without joint", elbow_and("<mimic multiplier=\"2\"/>")),
    ]);
    insta::assert_snapshot!(page);
}

#[test]
fn rejects_malformed_numbers() {
    let inertia = |new: &str| arm_with(INERTIA, new);
    let axis = |xyz: &str| arm_with(AXIS, &format!("<axis xyz=\"{xyz}\"/>"));
    let limit = |attributes: &str| arm_with(LIMIT, &format!("<limit {attributes}/>"));
    let origin = |attributes: &str| {
        arm_with("<origin xyz=\"0 0 0.4\" rpy=\"1.5708 0 0\"/>", &format!("<origin {attributes}/>"))
    };
    let version_1_1 = |text: String| text.replace("\"arm\"", "\"arm\" version=\"1.1\"");
    let page = refusals(&[
        ("negative mass", arm_with("\"2.5\"", "\"-2.5\"")),
        ("mass NaN", arm_with("\"2.5\"", "\"nan\"")),
        ("mass infinite", arm_with("\"2.5\"", "\"inf\"")),
        ("mass that overflows", arm_with("\"2.5\"", "\"1e999\"")),
        ("mass with unit", arm_with("\"2.5\"", "\"2.5 kg\"")),
        ("mass with comma", arm_with("\"2.5\"", "\"2,5\"")),
        ("mass empty", arm_with("\"2.5\"", "\"\"")),
        ("mass as text", arm_with(MASS, "<mass>2.5</mass>")),
        ("mass attribute misspelt", arm_with("value=\"2.5\"", "vlaue=\"2.5\"")),
        ("inertial without mass", arm_with(MASS, "")),
        ("inertial without inertia", inertia("")),
        (
            "inertia misspelt",
            inertia("<intertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>"),
        ),
        (
            "inertia without ixy",
            inertia("<inertia ixx=\"1\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>"),
        ),
        (
            "inertia with a word",
            inertia("<inertia ixx=\"1\" ixy=\"zero\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/>"),
        ),
        ("two inertials", arm_with("</inertial>", "</inertial>\n    <inertial/>")),
        ("two masses", arm_with(MASS, "<mass value=\"1\"/>\n      <mass value=\"2\"/>")),
        ("com with two numbers", arm_with("xyz=\"0 0 0.2\"", "xyz=\"0 0.2\"")),
        ("com NaN", arm_with("xyz=\"0 0 0.2\"", "xyz=\"0 NaN 0.2\"")),
        ("zero axis", axis("0 0 0")),
        ("axis of rounding noise", axis("0 1e-17 0")),
        ("axis NaN", axis("nan 0 1")),
        ("axis with a word", axis("0 zero 0 1")),
        ("axis with two numbers", axis("0 1")),
        ("axis with four numbers", axis("0 1 0 0")),
        ("axis with commas", axis("0,1,0")),
        ("axis without xyz", arm_with(AXIS, "<axis/>")),
        ("axis misspelt", arm_with(AXIS, "<axis xzy=\"0 1 0\"/>")),
        ("two axes", arm_with(AXIS, "<axis xyz=\"0 1 0\"/><axis xyz=\"1 0 0\"/>")),
        (
            "zero axis of a planar joint",
            axis("0 0 0").replace("\"elbow\" type=\"revolute\"", "\"elbow\" type=\"planar\""),
        ),
        ("origin with two numbers", origin("xyz=\"0 0\"")),
        ("origin rpy with a degree sign", origin("rpy=\"90° 0 0\"")),
        ("origin on several lines", origin("\n      xyz=\"0 0 0\"\n      rpy=\"0 0 pi\"")),
        ("limit with infinity", limit("lower=\"-inf\" upper=\"inf\" effort=\"1\" velocity=\"1\"")),
        ("limit with a word", limit("lower=\"-pi\" upper=\"3\" effort=\"1\" velocity=\"1\"")),
        ("effort NaN", limit("lower=\"-3\" upper=\"3\" effort=\"NaN\" velocity=\"1\"")),
        ("damping with a word", arm_with("damping=\"0.1\"", "damping=\"low\"")),
        ("friction infinite", arm_with("friction=\"0.2\"", "friction=\"1e400\"")),
        ("multiplier with a word", elbow_and("<mimic joint=\"shoulder\" multiplier=\"-1x\"/>")),
        ("rpy and quaternion", version_1_1(origin("rpy=\"0 0 0\" quat_xyzw=\"0 0 0 1\""))),
        ("zero quaternion", version_1_1(origin("quat_xyzw=\"0 0 0 0\""))),
        ("quaternion with three numbers", version_1_1(origin("quat_xyzw=\"0 0 1\""))),
    ]);
    insta::assert_snapshot!(page);
}

#[test]
fn rejects_unreadable_files() {
    let folder = std::env::temp_dir().join(format!("armident_malformed_{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let missing = load_urdf(&folder.join("missing.urdf")).unwrap_err();
    let directory = load_urdf(&folder).unwrap_err();
    std::fs::write(folder.join("latin1.urdf"), b"<robot name=\"arm\">\n<!-- bras \xe9 -->")
        .unwrap();
    let latin1 = load_urdf(&folder.join("latin1.urdf")).unwrap_err();
    std::fs::remove_dir_all(&folder).unwrap();
    let utf16: Vec<u8> = "\u{feff}<robot/>".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let page = [
        message("missing file", &missing),
        message("directory", &directory),
        message("latin-1", &latin1),
        message("utf-16", &parse_urdf_bytes(&utf16, "arm.urdf").unwrap_err()),
        message("mesh", &parse_urdf_bytes(b"solid\0\x80\x3f\0", "arm.stl").unwrap_err()),
    ]
    .join("\n");
    let page = page.replace(&folder.display().to_string(), "<folder>").replace("\\", "/");
    insta::assert_snapshot!(page);
}

/// Every text is read; its warnings and ignored elements in one page.
fn warnings(cases: &[(&str, String)]) -> String {
    let read = |(name, text): &(&str, String)| {
        let robot = parse_urdf(text, "arm.urdf")
            .unwrap_or_else(|error| panic!("{}", message(name, &error)));
        let mut page = format!("== {name}\n");
        for warning in &robot.warnings {
            page.push_str(&format!("warning: {warning}\n"));
        }
        for ignored in &robot.ignored {
            page.push_str(&format!("ignored: <{}> in line {}\n", ignored.tag, ignored.line));
        }
        page
    };
    cases.iter().map(read).collect::<Vec<_>>().join("\n")
}

#[test]
fn warns_about_doubtful_values() {
    let inertia = |xx: &str, yy: &str, zz: &str| {
        let new = format!(
            "<inertia ixx=\"{xx}\" ixy=\"0\" ixz=\"0\" iyy=\"{yy}\" iyz=\"0\" izz=\"{zz}\"/>"
        );
        arm_with(INERTIA, &new)
    };
    let limit = |attributes: &str| arm_with(LIMIT, &format!("<limit {attributes}/>"));
    let axis = |new: &str| arm_with(AXIS, new);
    let tool = |content: &str| {
        arm_and(&format!(
            "  <link name=\"tool\">{content}</link>\n  <joint name=\"flange\" type=\"fixed\">\n    \
             <parent link=\"forearm\"/>\n    <child link=\"tool\"/>\n    <axis xyz=\"0 0 0\"/>\n  \
             </joint>"
        ))
    };
    let no_inertials = {
        let start = ARM.find("    <inertial>").unwrap();
        let end = ARM.find("</inertial>").unwrap() + "</inertial>".len();
        arm_with(&ARM[start..end], "").replace("inertial>", "inertal>")
    };
    let warned = warnings(&[
        ("axis missing", axis("")),
        ("axis missing on two joints", axis("").replace("<axis xyz=\"0 0 1\"/>", "")),
        ("axis not of unit length", axis("<axis xyz=\"0 1 1\"/>")),
        ("axis of huge length", axis("<axis xyz=\"0 -1e300 0\"/>")),
        ("limit missing", arm_with(LIMIT, "")),
        ("limit all zero", limit("lower=\"0\" upper=\"0\" effort=\"0\" velocity=\"0\"")),
        ("limit swapped", limit("lower=\"3\" upper=\"-3\" effort=\"50\" velocity=\"2\"")),
        ("limit without range", limit("effort=\"50\" velocity=\"2\"")),
        ("limit without velocity", limit("lower=\"-3\" upper=\"3\" effort=\"50\"")),
        ("limit without effort and velocity", limit("lower=\"-3\" upper=\"3\"")),
        (
            "limit negative velocity",
            limit("lower=\"-3\" upper=\"3\" effort=\"50\" velocity=\"-2\""),
        ),
        (
            "limits misspelt",
            limit("lower=\"-3\" upper=\"3\" effort=\"50\" velocity=\"2\"")
                .replacen("<limit ", "<limits ", 1),
        ),
        ("limit attribute misspelt", limit("lower=\"-3\" uper=\"3\" effort=\"50\" velocity=\"2\"")),
        ("mimic", elbow_and("<mimic joint=\"shoulder\" multiplier=\"-1\"/>")),
        (
            "negative damping and friction",
            arm_with(DYNAMICS, "<dynamics damping=\"-0.1\" friction=\"-1\"/>"),
        ),
        ("own attributes", arm_with("damping=\"0.1\"", "damping=\"0.1\" mu_coulomb=\"1\" K=\"7\"")),
        ("no inertial on moving links", no_inertials),
        ("no inertial on a tool with shape", tool("<visual/>")),
        ("zero mass with inertia", arm_with("\"2.5\"", "\"0\"")),
        ("inertia with a negative moment", inertia("0.04", "-0.04", "0.01")),
        ("inertia against the triangle inequality", inertia("0.276", "0.255", "0.71")),
        ("inertia of huge numbers", inertia("1e300", "1e-300", "0")),
        ("origin attribute misspelt", arm_with("xyz=\"0 0 0.4\"", "xzy=\"0 0 0.4\"")),
        (
            "quaternion in version 1.0",
            arm_with("<origin xyz=\"0 0 0.4\"", "<origin quat_xyzw=\"0 0 1 0\" xyz=\"0 0 0.4\""),
        ),
        ("robot without name", arm_with(" name=\"arm\"", "")),
        ("misspelt robot child", arm_and("  <Joint name=\"x\"/>")),
        (
            "elements of others",
            arm_and(
                "  <material name=\"red\"/>\n  <transmission name=\"t\">\n    \
                 <joint name=\"elbow\"/>\n  </transmission>\n  <gazebo reference=\"base\"/>\n  \
                 <ros2_control/>",
            ),
        ),
        (
            "foreign element in a link",
            arm_with("<inertial>", "<self_collision_checking/>\n    <inertial>"),
        ),
    ]);
    for case in warned.split("\n\n") {
        assert!(case.contains("\nwarning: ") || case.contains("\nignored: "), "{case}");
    }
    insta::assert_snapshot!(warned);

    // what other tools need and this one does not may be absent, broken or exotic
    let silent = [
        ("the arm itself", ARM.to_owned()),
        ("byte order mark", format!("\u{feff}{ARM}")),
        ("windows line ends", ARM.replace('\n', "\r\n")),
        (
            "xacro declared but expanded",
            arm_with("name=\"arm\"", "name=\"arm\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\""),
        ),
        (
            "default namespace",
            arm_with("name=\"arm\"", "name=\"arm\" xmlns=\"http://www.ros.org\""),
        ),
        ("tool frame, zero axis on its fixed joint", tool("")),
        (
            "broken visual",
            arm_with("<inertial>", "<visual><geometry><ball/></geometry></visual><inertial>"),
        ),
        (
            "mesh of a package",
            arm_with(
                "<inertial>",
                "<collision><geometry><mesh filename=\"package://none/a.stl\"/></geometry>\
                 </collision><inertial>",
            ),
        ),
        (
            "safety controller without k_velocity",
            elbow_and("<safety_controller soft_lower_limit=\"x\"/>"),
        ),
        ("thin rod", inertia("0.04", "0.04", "0")),
        ("point mass", inertia("0", "0", "0")),
        (
            "version 1.2, limits left out",
            limit("lower=\"-3\"").replace("\"arm\"", "\"arm\" version=\"1.2\""),
        ),
        ("comments and text", elbow_and("<!-- <axis/> --> text <![CDATA[<limit/>]]>")),
    ];
    for (name, text) in &silent {
        let page = warnings(&[(name, text.clone())]);
        assert_eq!(page, format!("== {name}\n"));
    }
}
