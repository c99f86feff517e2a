//! The numbers of Lin 1992 for the Stanford arm (Fig. 2, Tables I and II), from `urdf/stanford.urdf`,
//! and the structure of the other arms of `urdf/`.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;
use std::path::Path;

use armident_dynamics::RigidArm;
use armident_ident::MinimalSet;
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, load_urdf};
use nalgebra::Vector3;

fn chain_of(name: &str, gravity_base: [f64; 3]) -> DrivingAxisChain {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../urdf/{name}.urdf"));
    let robot = load_urdf(&path).unwrap();
    let selection = ChainSelection { gravity_base, ..ChainSelection::default() };
    let chain = SerialChain::from_description(&robot, &selection).unwrap();
    DrivingAxisChain::from_chain(&chain)
}

const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

fn stanford() -> RigidArm {
    RigidArm::from_chain(&chain_of("stanford", GRAVITY))
}

#[track_caller]
fn assert_near(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= tolerance, "{what}: found {found:?}, expected {expected:?}");
    }
}

/// Fig. 2: `θ, β` [deg], `b, d` [m] at q = 0; masses, centres, diagonal inertias.
#[test]
fn fig_2_frames_and_links() {
    let chain = chain_of("stanford", GRAVITY);
    assert_eq!(chain.types(), "RRPRRR");
    assert_eq!(chain.gravity_e0.as_slice(), GRAVITY);
    assert!(chain.snap_error < 1e-12, "{}", chain.snap_error);
    let frames = [
        [0.0, 0.0, 0.0, 0.0],
        [90.0, 90.0, 0.0, 0.1529],
        [0.0, 90.0, 0.0, 0.6447],
        [0.0, 0.0, 0.0, 0.0],
        [-90.0, 90.0, 0.0, 0.0],
        [0.0, 90.0, 0.0, 0.0],
    ];
    let links: [(f64, [f64; 3], [f64; 3]); 6] = [
        (9.29, [0.0, 0.1105, 0.0175], [0.276, 0.255, 0.71]),
        (5.01, [0.0, 0.0, -0.1054], [0.108, 0.018, 0.1]),
        (4.25, [0.0, 0.0, -0.6447], [2.51, 2.51, 0.006]),
        (1.08, [0.0092, 0.0054, 0.0], [0.002, 0.001, 0.001]),
        (0.63, [0.0, -0.0566, 0.0], [0.003, 0.003, 0.0004]),
        (0.51, [0.0, 0.0, 0.1554], [0.013, 0.013, 0.0003]),
    ];
    for ((joint, frame), (mass, com, inertia)) in chain.joints.iter().zip(frames).zip(links) {
        let f = joint.frame;
        let found = [f.theta_rad.to_degrees(), f.beta_rad.to_degrees(), f.b_m, f.d_m];
        assert_near(&joint.name, &found, &frame, 1e-12);
        assert_near("mass", &[joint.link.mass_kg], &[mass], 1e-12);
        assert_near("com", joint.link.com_m().as_slice(), &com, 1e-12);
        let about_com = joint.link.inertia_com_kgm2();
        let diagonal = nalgebra::Matrix3::from_diagonal(&Vector3::from(inertia));
        assert_near("inertia", about_com.as_slice(), diagonal.as_slice(), 1e-12);
    }
}

/// Section 4 of the paper: `r = 1`, `s = 2`, `δ_1 = 0`, 33 constants, and they are independent.
#[test]
fn theorem_2_gives_the_33_constants() {
    let set = MinimalSet::of(&stanford()).unwrap();
    assert_eq!((set.theorem.r, set.theorem.s), (Some(0), Some(1)));
    assert_eq!(set.theorem.delta, BTreeMap::from([(0, false)]));
    assert!(set.theorem.sigma.is_empty());
    assert_eq!((set.len(), set.rank.rank), (33, 33));
    assert!(set.is_confirmed() && set.dropped.is_empty());
    let labels: Vec<&str> = TABLE_II.iter().map(|(label, ..)| *label).collect();
    assert_eq!(set.labels(), labels);
}

/// All constants of the arm: `m̂`, `k`, `U_11, U_22, U_33`, `U_12, U_13, U_23`.
#[test]
fn all_constants_to_eight_digits() {
    type Row = (f64, [f64; 3], [f64; 3], [f64; 3]);
    let expected: [Row; 6] = [
        (
            20.77,
            [0.0, -0.200693, 0.162575],
            [0.58326331, 4.66313267, 1.01441825],
            [0.0, 0.0, -0.01796454],
        ),
        (11.48, [0.0, 2.739975, -0.528054], [4.46894450, 0.08407980, 4.40528761], [0.0; 3]),
        (6.47, [0.0, 0.0, -2.739975], [4.30528761, 4.30528761, 0.01042290], [0.0; 3]),
        (
            2.22,
            [0.009936, 0.005832, 0.0],
            [0.00533149, 0.02882573, 0.00442290],
            [-0.00005365, 0.0, 0.0],
        ),
        (1.14, [0.0, -0.114912, 0.0], [0.03033431, 0.00330000, 0.02773431], [0.0; 3]),
        (0.51, [0.0, 0.0, 0.079254], [0.02531607, 0.02531607, 0.00030000], [0.0; 3]),
    ];
    for (i, (body, (mass, k, diagonal, products))) in
        stanford().constants().iter().zip(expected).enumerate()
    {
        let u = body.inertia_origin_kgm2;
        let name = format!("body {}", i + 1);
        assert_near(&name, &[body.mass_kg], &[mass], 1e-12);
        // printed with six and eight decimals: half a unit of the last one
        assert_near(&name, body.first_moment_kgm.as_slice(), &k, 0.51e-6);
        assert_near(&name, &[u[(0, 0)], u[(1, 1)], u[(2, 2)]], &diagonal, 0.51e-8);
        assert_near(&name, &[u[(0, 1)], u[(0, 2)], u[(1, 2)]], &products, 0.51e-8);
    }
}

/// Table II: minimal constants to four decimals. The paper's values are identified ones, from simulated
/// torques of 5 or 6 decimals; `Some` is a printed number that is off by their round-off.
const TABLE_II: [(&str, f64, Option<f64>); 33] = [
    ("U1_33", 1.0144, None),
    ("U2_11-U2_22", 4.3849, Some(4.3850)),
    ("U2_33", 4.4053, None),
    ("U2_12", 0.0, Some(0.00003)),
    ("U2_13", 0.0, None),
    ("U2_23", 0.0, Some(-0.00003)),
    ("k2_x", 0.0, Some(-0.00001)),
    ("k2_y", 2.7400, None),
    ("U4_11-U4_22", -0.0235, None),
    ("U4_33", 0.0044, None),
    ("U4_12", -0.0001, None),
    ("U4_13", 0.0, None),
    ("U4_23", 0.0, None),
    ("k4_x", 0.0099, None),
    ("k4_y", 0.0058, None),
    ("U5_11-U5_22", 0.0270, None),
    ("U5_33", 0.0277, None),
    ("U5_12", 0.0, None),
    ("U5_13", 0.0, None),
    ("U5_23", 0.0, None),
    ("k5_x", 0.0, None),
    ("k5_y", -0.1149, None),
    ("U6_11-U6_22", 0.0, None),
    ("U6_33", 0.0003, None),
    ("U6_12", 0.0, None),
    ("U6_13", 0.0, None),
    ("U6_23", 0.0, None),
    ("k6_x", 0.0, None),
    ("k6_y", 0.0, None),
    ("m3", 6.47, None),
    ("k3_x", 0.0, None),
    ("k3_y", 0.0, None),
    ("k3_z", -2.7400, None),
];

#[test]
fn table_ii_to_four_decimals() {
    let arm = stanford();
    let set = MinimalSet::of(&arm).unwrap();
    let values = set.values(&arm.constants());
    for ((label, exact, printed), value) in TABLE_II.into_iter().zip(values) {
        let four_decimals = (value * 1e4).round() / 1e4;
        assert!((four_decimals - exact).abs() < 1e-12, "{label}: {value}");
        if let Some(printed) = printed {
            assert!(four_decimals != printed, "{label} is printed right");
            assert!((value - printed).abs() < 2e-4, "{label}: {value}, printed {printed}");
        }
    }
    // Table II does not depend on the size of gravity, which the paper does not state
    let light = RigidArm { gravity_e0: arm.gravity_e0 * 0.1, ..arm.clone() };
    assert_eq!(set.labels(), MinimalSet::of(&light).unwrap().labels());
    // only 0.71, not 0.071, of link 1 gives the printed (U_1)_33
    let mut links = arm.links.clone();
    links[0].inertia_origin_kgm2[(2, 2)] += 0.071 - 0.71;
    let usual = arm.with_links(links).constants()[0].inertia_origin_kgm2[(2, 2)];
    assert!((usual - 0.3754).abs() < 5e-5);
}

/// Table I: `u_1` in frame `j` at q = (0.7, 0.7, 0, 0.7, 0.7, 0.7), then with `q_j` = -0.7 and -0.6
/// (body 3: `q_2` = -0.7).
#[test]
fn table_i_directions_of_joint_1() {
    let arm = stanford();
    let direction = |frame: usize, joint: usize, value: f64| {
        let mut q = [0.7, 0.7, 0.0, 0.7, 0.7, 0.7];
        q[joint - 1] = value;
        arm.axis_in_frames(&arm.poses(&q), 0)[frame - 1].0
    };
    let rows: [(usize, usize, f64, [f64; 3]); 14] = [
        (2, 2, 0.7, [0.7648, -0.6442, 0.0]),
        (2, 2, -0.7, [0.7648, 0.6442, 0.0]),
        (2, 2, -0.6, [0.8253, 0.5646, 0.0]),
        (3, 2, 0.7, [0.7648, 0.0, 0.6442]),
        (3, 2, -0.7, [0.7648, 0.0, -0.6442]),
        (4, 4, 0.7, [0.5850, -0.4927, 0.6442]),
        (4, 4, -0.7, [0.5850, 0.4927, 0.6442]),
        (4, 4, -0.6, [0.6313, 0.4319, 0.6442]),
        (5, 5, 0.7, [-0.1159, 0.8624, 0.4927]),
        (5, 5, -0.7, [-0.8696, 0.0324, 0.4927]),
        (5, 5, -0.6, [-0.8620, 0.1191, 0.4927]),
        (6, 6, 0.7, [0.2288, 0.4515, -0.8624]),
        (6, 6, -0.7, [-0.4060, 0.3022, -0.8624]),
        (6, 6, -0.6, [-0.3738, 0.3412, -0.8624]),
    ];
    for (frame, joint, value, expected) in rows {
        let name = format!("frame {frame}, q{joint} = {value}");
        assert_near(&name, direction(frame, joint, value).as_slice(), &expected, 0.51e-4);
    }
    // row 3 as printed: y of frame 5 cut and not rounded, z of frame 6 with two digits exchanged
    let y = direction(5, 5, -0.6).y;
    assert!((y - 0.1190).abs() > 0.51e-4 && (y * 1e4).floor() / 1e4 == 0.1190, "{y}");
    assert!((direction(6, 6, -0.6).z - -0.8264).abs() > 0.03);
    // z does not depend on the frame's own joint
    for value in [-0.7, -0.6] {
        assert!((direction(6, 6, value).z - direction(6, 6, 0.7).z).abs() < 1e-15);
    }
}

/// Structure of one arm, joints counted from 1: `r`, `s`, `δ`, `σ`, size with gravity and without.
struct Arm {
    name: &'static str,
    types: &'static str,
    r: usize,
    s: Option<usize>,
    delta: &'static [(usize, bool)],
    sigma: &'static [(usize, bool)],
    size: usize,
    size_without_gravity: usize,
}

/// An upright arm of rotations with axis 2 level: `r = 1`, `s = 2`, `δ_1 = 0`, `1 + 7 (n - 1)` constants.
const fn upright(name: &'static str, types: &'static str, size_without_gravity: usize) -> Arm {
    Arm {
        name,
        types,
        r: 1,
        s: Some(2),
        delta: &[(1, false)],
        sigma: &[],
        size: 1 + 7 * (types.len() - 1),
        size_without_gravity,
    }
}

/// Sizes without gravity as in `urdf/README.md`, where an independent program measured them.
const ARMS: [Arm; 15] = [
    upright("puma560", "RRRRRR", 34),
    upright("ur5", "RRRRRR", 34),
    upright("ur10", "RRRRRR", 34),
    upright("tx40", "RRRRRR", 34),
    // axes 1 and 2 are 70 mm apart: no point is at rest
    upright("irb140", "RRRRRR", 36),
    // axes 1 to 3 meet in the shoulder, gravity or not
    upright("panda", "RRRRRRR", 39),
    upright("iiwa14", "RRRRRRR", 39),
    upright("xarm7", "RRRRRRR", 39),
    upright("kinova_gen3", "RRRRRRR", 41),
    // the slide follows s: item 4
    Arm {
        name: "stanford",
        types: "RRPRRR",
        r: 1,
        s: Some(2),
        delta: &[(1, false)],
        sigma: &[],
        size: 33,
        size_without_gravity: 31,
    },
    // upright axes only: joint 1 turns about gravity, 2 and 4 are beside it
    Arm {
        name: "scara",
        types: "RRPR",
        r: 1,
        s: None,
        delta: &[(1, false), (2, true), (4, true)],
        sigma: &[(3, false)],
        size: 1 + 3 + 3 + 1,
        size_without_gravity: 8,
    },
    // joint 4 turns about gravity, but slides across it carry it
    Arm {
        name: "gantry",
        types: "PPPRRR",
        r: 4,
        s: Some(5),
        delta: &[(4, true)],
        sigma: &[],
        size: 3 + 3 + 7 + 7,
        size_without_gravity: 20,
    },
    // a slide along and a slide across axis 1
    Arm {
        name: "cylindrical",
        types: "RPP",
        r: 1,
        s: None,
        delta: &[(1, false)],
        sigma: &[(2, false), (3, true)],
        size: 1 + 2 + 2,
        size_without_gravity: 5,
    },
    // gravity across the axes
    Arm {
        name: "planar_2r",
        types: "RR",
        r: 1,
        s: None,
        delta: &[(1, true), (2, true)],
        sigma: &[],
        size: 3 + 3,
        size_without_gravity: 1 + 3,
    },
    // gravity along the axes
    Arm {
        name: "planar_3r",
        types: "RRR",
        r: 1,
        s: None,
        delta: &[(1, false), (2, true), (3, true)],
        sigma: &[],
        size: 1 + 3 + 3,
        size_without_gravity: 7,
    },
];

#[test]
fn structure_of_the_arms() {
    for expected in &ARMS {
        let name = expected.name;
        let chain = chain_of(name, GRAVITY);
        assert_eq!(chain.types(), expected.types, "{name}");
        let set = MinimalSet::of(&RigidArm::from_chain(&chain)).unwrap();
        let theorem = &set.theorem;
        let counted = |joints: &BTreeMap<usize, bool>| -> Vec<(usize, bool)> {
            joints.iter().map(|(joint, &flag)| (joint + 1, flag)).collect()
        };
        assert_eq!(theorem.r.map(|r| r + 1), Some(expected.r), "{name}");
        assert_eq!(theorem.s.map(|s| s + 1), expected.s, "{name}");
        assert_eq!(counted(&theorem.delta), expected.delta, "{name}");
        assert_eq!(counted(&theorem.sigma), expected.sigma, "{name}");
        assert_eq!(theorem.constants.len(), expected.size, "{name}");
        assert_eq!((set.len(), set.rank.rank), (expected.size, expected.size), "{name}");
        assert!(set.is_confirmed() && set.dropped.is_empty(), "{name}");

        let weightless = RigidArm::from_chain(&chain_of(name, [0.0; 3]));
        let set = MinimalSet::of(&weightless).unwrap();
        assert!(set.is_confirmed(), "{name} without gravity: {:?}", set.rank);
        assert_eq!(set.len(), expected.size_without_gravity, "{name} without gravity");
    }
}
