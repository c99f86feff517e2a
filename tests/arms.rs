//! The arms of `urdf/`.

use armident_kinematics::{
    ChainSelection, DrivingAxisChain, RobotDescription, SerialChain, UrdfJointType, load_urdf,
};
use nalgebra::{Matrix3, Matrix4, Vector3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::shared::{project, urdfs};
use crate::tool::{list, number, run, string, text};

/// The page without the size of rounding errors, which is that of a machine.
fn without_rounding(page: &str) -> String {
    let (kept, dropped) = page.trim_end().rsplit_once("dropped below ").unwrap();
    assert!(dropped.parse::<f64>().unwrap() <= 1e-9, "{dropped}");
    format!("{kept}dropped far below\n")
}

/// A snapshot is the page `params` prints.
#[test]
fn pages_match_snapshots() {
    for path in urdfs(&project("urdf")) {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let page = run(&["params", &format!("urdf/{name}.urdf")]).fine().stdout;
        insta::with_settings!({prepend_module_to_snapshot => false, omit_expression => true}, {
            insta::assert_snapshot!(format!("minimal__{name}"), without_rounding(&page));
        });
    }
}

/// `Rz(yaw) Ry(pitch) Rx(roll)`, entry by entry.
fn rotation_of([roll, pitch, yaw]: [f64; 3]) -> Matrix3<f64> {
    let ((sr, cr), (sp, cp), (sy, cy)) = (roll.sin_cos(), pitch.sin_cos(), yaw.sin_cos());
    Matrix3::new(
        cy * cp,
        cy * sp * sr - sy * cr,
        cy * sp * cr + sy * sr,
        sy * cp,
        sy * sp * sr + cy * cr,
        sy * sp * cr - cy * sr,
        -sp,
        cp * sr,
        cp * cr,
    )
}

/// ReversalModel by an angle about a unit axis (Rodrigues).
fn turn(axis: Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let k = axis.cross_matrix();
    Matrix3::identity() + k * angle.sin() + k * k * (1.0 - angle.cos())
}

fn pose(rotation: Matrix3<f64>, position: Vector3<f64>) -> Matrix4<f64> {
    let mut pose = rotation.to_homogeneous();
    pose.fixed_view_mut::<3, 1>(0, 3).copy_from(&position);
    pose
}

/// Pose of a link in the root as the URDF says: origins, roll-pitch-yaw, axes, and nothing else.
fn pose_as_written(
    robot: &RobotDescription,
    link: usize,
    position_of: &dyn Fn(&str) -> f64,
) -> Matrix4<f64> {
    let Some(joint) = robot.joints.iter().find(|joint| joint.child == link) else {
        return Matrix4::identity();
    };
    let origin = pose(rotation_of(joint.origin_rpy_rad), Vector3::from(joint.origin_xyz_m));
    let axis = Vector3::from(joint.axis);
    let moved = match joint.joint_type {
        UrdfJointType::Revolute | UrdfJointType::Continuous => {
            pose(turn(axis, position_of(&joint.name)), Vector3::zeros())
        }
        UrdfJointType::Prismatic => pose(Matrix3::identity(), axis * position_of(&joint.name)),
        _ => Matrix4::identity(),
    };
    pose_as_written(robot, joint.parent, position_of) * origin * moved
}

/// The driving-axis chain puts every link where the URDF puts it.
#[test]
fn chain_rebuilds_urdf_poses() {
    for path in urdfs(&project("urdf")) {
        let name = path.display();
        let robot = load_urdf(&path).unwrap();
        let serial = SerialChain::from_description(&robot, &ChainSelection::default()).unwrap();
        let chain = DrivingAxisChain::from_chain(&serial);
        let mut random = Pcg64::seed_from_u64(20);
        for _ in 0..20 {
            let q: Vec<f64> = chain
                .joints
                .iter()
                .map(|joint| {
                    let reach = if joint.kind.is_rotational() { 3.2 } else { 1.0 };
                    random.random_range(-reach..reach)
                })
                .collect();
            let position_of = |joint: &str| {
                chain.joints.iter().position(|j| j.name == joint).map_or(0.0, |i| q[i])
            };
            for (joint, found) in chain.joints.iter().zip(chain.child_links_in_base(&q)) {
                let link = robot.links.iter().position(|l| l.name == joint.child_link).unwrap();
                let expected = pose_as_written(&robot, link, &position_of);
                let off = (found.to_homogeneous() - expected).amax();
                assert!(off < 1e-9, "{name}: link `{}` is off by {off}", joint.child_link);
            }
            let tip = robot.links.iter().position(|l| l.name == chain.tip_link).unwrap();
            let found = chain.frames_in_base(&q)[chain.dof() - 1] * chain.tip_in_e;
            let off = (found.to_homogeneous() - pose_as_written(&robot, tip, &position_of)).amax();
            assert!(off < 1e-9, "{name}: the tip is off by {off}");
        }
    }
}

/// `6R` is `RRRRRR`.
fn types_in_full(short: &str) -> String {
    match short.strip_suffix('R').and_then(|n| n.parse::<usize>().ok()) {
        Some(n) => "R".repeat(n),
        None => short.to_owned(),
    }
}

/// The table of `urdf/README.md` names every file, with its joints and the sizes of its set.
#[test]
fn readme_table_matches_arms() {
    let readme = std::fs::read_to_string(project("urdf/README.md")).unwrap();
    let rows: Vec<Vec<&str>> = readme
        .lines()
        .filter(|line| line.starts_with("| `"))
        .map(|line| line.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    let mut named: Vec<String> =
        rows.iter().map(|cells| cells[0].trim_matches('`').to_owned()).collect();
    named.sort();
    let files: Vec<String> = urdfs(&project("urdf"))
        .iter()
        .map(|path| text(std::path::Path::new(path.file_name().unwrap())).to_owned())
        .collect();
    assert_eq!(named, files);
    for cells in rows {
        let file = format!("urdf/{}", cells[0].trim_matches('`'));
        let size = |options: &[&str]| {
            let params = run(&[&["params", &file, "--json", "-"], options].concat()).fine().json();
            assert_eq!(string(&params["types"]), types_in_full(cells[2]), "{file}");
            assert_eq!(params["confirmed"], true, "{file}");
            assert!(number(&params["snap_error"]) < 1e-9, "{file}");
            list(&params["minimal"]).len()
        };
        let found = format!("{} ({})", size(&[]), size(&["--gravity", "0,0,0"]));
        assert_eq!(found, cells[6], "{file}");
    }
}
