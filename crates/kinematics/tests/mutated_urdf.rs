//! No text and no bytes make the URDF reader panic, and its answers keep their promises.

use armident_kinematics::{UrdfError, parse_urdf, parse_urdf_bytes};
use proptest::prelude::*;

const ARM: &str = include_str!("arm.urdf");

#[test]
fn deep_nesting_does_not_overflow() {
    let deep = format!("{}{}", "<gazebo>".repeat(200_000), "</gazebo>".repeat(200_000));
    assert!(parse_urdf(&ARM.replace("</robot>", &format!("{deep}</robot>")), "deep.urdf").is_ok());
    let deep = deep.replace("gazebo", "link");
    assert!(parse_urdf(&ARM.replace("</robot>", &format!("{deep}</robot>")), "deep.urdf").is_err());
}

/// One edit of the bytes of a file.
#[derive(Debug, Clone)]
enum Edit {
    Flip(usize, u8),
    Delete(usize, usize),
    Insert(usize, Vec<u8>),
    Duplicate(usize, usize, usize),
    Truncate(usize),
}

fn edit() -> impl Strategy<Value = Edit> {
    let at = 0..ARM.len();
    // pieces that keep the XML intact more often than single bytes do
    let piece = prop::sample::select(vec![
        "<",
        ">",
        "/>",
        "\"",
        " ",
        "&#0;",
        "&amp;",
        "${x}",
        "nan",
        "1e999",
        "-",
        "<link/>",
        "<joint/>",
        "<inertial>",
        "</link>",
        "<!--",
        "-->",
        "]]>",
        "<?x?>",
        "\u{feff}",
        "xmlns=\"\"",
    ]);
    prop_oneof![
        (at.clone(), any::<u8>()).prop_map(|(i, byte)| Edit::Flip(i, byte)),
        (at.clone(), 1..60_usize).prop_map(|(i, n)| Edit::Delete(i, n)),
        (at.clone(), prop::collection::vec(any::<u8>(), 1..6))
            .prop_map(|(i, b)| Edit::Insert(i, b)),
        (at.clone(), piece).prop_map(|(i, p)| Edit::Insert(i, p.as_bytes().to_vec())),
        (at.clone(), 1..400_usize, at.clone()).prop_map(|(i, n, to)| Edit::Duplicate(i, n, to)),
        at.prop_map(Edit::Truncate),
    ]
}

fn apply(bytes: &mut Vec<u8>, edit: &Edit) {
    let len = bytes.len();
    match edit {
        Edit::Flip(i, byte) if *i < len => bytes[*i] ^= byte,
        Edit::Flip(..) => {}
        Edit::Delete(i, n) => drop(bytes.drain((*i).min(len)..(i + n).min(len))),
        Edit::Insert(i, new) => drop(bytes.splice((*i).min(len)..(*i).min(len), new.clone())),
        Edit::Duplicate(i, n, to) => {
            let piece = bytes[(*i).min(len)..(i + n).min(len)].to_vec();
            bytes.splice((*to).min(len)..(*to).min(len), piece);
        }
        Edit::Truncate(i) => bytes.truncate(*i),
    }
}

fn answer(bytes: &[u8]) -> Result<(), TestCaseError> {
    match parse_urdf_bytes(bytes, "arm.urdf") {
        Ok(robot) => {
            prop_assert!(robot.root < robot.links.len());
            for joint in &robot.joints {
                let norm: f64 = joint.axis.iter().map(|a| a * a).sum();
                prop_assert!((norm - 1.0).abs() < 1e-12);
                prop_assert!(joint.origin_rpy_rad.iter().all(|angle| angle.is_finite()));
            }
        }
        Err(error) => {
            prop_assert!(!error.to_string().is_empty());
            prop_assert!(error.place().starts_with("arm.urdf"));
            // what only the second parser notices would have no line
            prop_assert!(!matches!(error, UrdfError::Refused { .. }), "{error}");
            let _ = error.hint();
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 512,
        failure_persistence: None,
        ..Default::default()
    })]

    #[test]
    fn mutated_files_never_panic(edits in prop::collection::vec(edit(), 1..5)) {
        let mut bytes = ARM.as_bytes().to_vec();
        for edit in &edits {
            apply(&mut bytes, edit);
        }
        answer(&bytes)?;
    }

    #[test]
    fn any_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        answer(&bytes)?;
    }
}
