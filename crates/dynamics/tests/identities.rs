//! Identities that tie the kernels together, on random arms. Equation numbers: Lin 1992.
//!
//! Tolerances are fractions of the largest entry compared (of 1 where that is smaller): 1e-12 for what
//! is equal in exact arithmetic (round-off is below 1e-13), more only where a finite difference or an
//! inverse stands, said there.

mod random_arms;

use armident_dynamics::{
    BodyConstants, JointGeometry, ParameterColumns, RigidArm, composite_bodies,
    constants_from_links, coriolis_effort, energy, forward_dynamics, gravity_effort,
    inertia_matrix, inertia_matrix_derivatives, inverse_dynamics, inverse_dynamics_of_motion,
    links_from_constants, pi, sigma, standard_regressor, varying_parts,
};
use armident_kinematics::{InertialParameters, JointKind};
use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use random_arms::{Case, assert_close, cases, largest, physical_link, repeated};

const EXACT: f64 = 1e-12;

/// Pose of `E_i` in `E_{i-1}` as the product of the four elementary motions.
fn pose_at(joint: &JointGeometry, q: f64) -> Isometry3<f64> {
    let (turn, slide) = if joint.kind.is_rotational() { (q, 0.0) } else { (0.0, q) };
    let about = UnitQuaternion::from_axis_angle;
    about(&Vector3::x_axis(), joint.frame.beta_rad)
        * Translation3::new(joint.frame.b_m, 0.0, 0.0)
        * about(&Vector3::z_axis(), joint.frame.theta_rad + turn)
        * Translation3::new(0.0, 0.0, joint.frame.d_m + slide)
}

/// First moment, then inertia.
fn numbers(first_moment: &Vector3<f64>, inertia: &Matrix3<f64>) -> Vec<f64> {
    first_moment.iter().chain(inertia.iter()).copied().collect()
}

fn flat(links: &[InertialParameters]) -> Vec<f64> {
    links.iter().flat_map(InertialParameters::to_array).collect()
}

fn product(rows: &[f64], values: &[f64]) -> Vec<f64> {
    rows.chunks(values.len()).map(|row| row.iter().zip(values).map(|(y, x)| y * x).sum()).collect()
}

/// Derivative at 0 by four-point central differences: error `h⁴ f⁽⁵⁾/30` and `2 ε |f|/h`.
fn derivative(f: impl Fn(f64) -> f64) -> f64 {
    let h = 2e-4;
    (8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h)
}

/// Cases in which every link has mass and inertia, so that every motion has kinetic energy.
fn heavy_cases() -> impl Strategy<Value = Case> {
    (cases(), prop::collection::vec(physical_link(), 7)).prop_map(|(mut case, links)| {
        case.arm.links = links[..case.arm.dof()].to_vec();
        case
    })
}

/// Any ten numbers per joint: no body need have them.
fn any_numbers() -> impl Strategy<Value = Vec<InertialParameters>> {
    let ten = prop::array::uniform10(-1.0..1.0);
    prop::collection::vec(ten.prop_map(|n| InertialParameters::from_array(&n)), 7)
}

// ---- kinematics and composite bodies

proptest! {
    #![proptest_config(repeated(300))]

    /// (3), (4) against quaternions.
    #[test]
    fn joint_poses_equal_elementary_products(case in cases()) {
        for (joint, &q) in case.arm.joints.iter().zip(&case.q) {
            let (found, expected) = (joint.at(q), pose_at(joint, q));
            let rotation = expected.rotation.to_rotation_matrix();
            assert_close("R", found.rotation().as_slice(), rotation.matrix().as_slice(), EXACT);
            assert_close("s", found.s.as_slice(), expected.translation.vector.as_slice(), EXACT);
            let (v, m) = (Vector3::new(0.3, -0.5, 0.7), sigma(&Vector3::new(0.2, 0.4, -0.1)));
            let there = found.to_parent(&v);
            assert_close("R v", there.as_slice(), (rotation * v).as_slice(), EXACT);
            assert_close("R' R v", found.to_child(&there).as_slice(), v.as_slice(), EXACT);
            let turned = rotation * m * rotation.inverse();
            assert_close("R M R'", found.tensor_to_parent(&m).as_slice(), turned.as_slice(), EXACT);
        }
    }

    /// (5)-(7), the sums written out over link poses from products of isometries.
    #[test]
    fn composite_bodies_equal_link_sums(case in cases()) {
        let Case { arm, q, .. } = &case;
        let bodies = composite_bodies(arm, &arm.poses(q));
        for i in 0..arm.dof() {
            let mut mass = 0.0;
            let mut first_moment = Vector3::zeros();
            let mut inertia = Matrix3::zeros();
            let mut pose = Isometry3::identity();
            for j in i..arm.dof() {
                if j > i {
                    pose *= pose_at(&arm.joints[j], q[j]);
                }
                let link = &arm.links[j];
                let rotation = pose.rotation.to_rotation_matrix();
                let centre = (pose * nalgebra::Point3::from(link.com_m())).coords;
                mass += link.mass_kg;
                first_moment += link.mass_kg * centre;
                inertia += rotation * link.inertia_com_kgm2() * rotation.inverse()
                    + link.mass_kg * sigma(&centre);
            }
            assert_close("mass", &[bodies[i].mass], &[mass], EXACT);
            assert_close("c", bodies[i].first_moment.as_slice(), first_moment.as_slice(), EXACT);
            assert_close("J", bodies[i].inertia.as_slice(), inertia.as_slice(), EXACT);
        }
    }

    /// `Σ(a) = -[a×]²`, `Π(a, b) = -[a×][b×] - [b×][a×]`.
    #[test]
    fn sigma_and_pi_are_products_of_cross_matrices(
        a in prop::array::uniform3(-1.0..1.0), b in prop::array::uniform3(-1.0..1.0),
    ) {
        let (a, b) = (Vector3::from(a), Vector3::from(b));
        let (ax, bx) = (a.cross_matrix(), b.cross_matrix());
        assert_close("sigma", sigma(&a).as_slice(), (-ax * ax).as_slice(), EXACT);
        assert_close("pi", pi(&a, &b).as_slice(), (-ax * bx - bx * ax).as_slice(), EXACT);
    }
}

// ---- constants and varying parts (Lemma 1)

proptest! {
    #![proptest_config(repeated(300))]

    /// (12), (13): `ĉ = k + ℓ`, `Ĵ = U + V`; the masses are those of (5).
    #[test]
    fn composite_bodies_equal_constant_plus_varying(case in cases()) {
        let Case { arm, q, .. } = &case;
        let bodies = composite_bodies(arm, &arm.poses(q));
        let (constants, parts) = (arm.constants(), varying_parts(&arm.joints, &arm.constants(), q));
        for ((body, constant), part) in bodies.iter().zip(&constants).zip(&parts) {
            assert_close("m", &[constant.mass_kg], &[body.mass], EXACT);
            let sum = numbers(
                &(constant.first_moment_kgm + part.first_moment),
                &(constant.inertia_origin_kgm2 + part.inertia),
            );
            assert_close("c, J", &sum, &numbers(&body.first_moment, &body.inertia), EXACT);
        }
    }

    /// What is left of a composite body without its varying part is the same at two positions.
    #[test]
    fn constants_are_independent_of_position(case in cases()) {
        let Case { arm, q, dq, .. } = &case;
        let constants = arm.constants();
        let left = |q: &[f64]| -> Vec<f64> {
            let parts = varying_parts(&arm.joints, &constants, q);
            composite_bodies(arm, &arm.poses(q))
                .iter()
                .zip(&parts)
                .flat_map(|(body, part)| {
                    let (c, j) = (body.first_moment, body.inertia);
                    numbers(&(c - part.first_moment), &(j - part.inertia))
                })
                .collect()
        };
        assert_close("k, U", &left(dq), &left(q), EXACT);
    }

    /// The ten constants of every joint are an invertible linear function of the links.
    #[test]
    fn links_and_constants_map_one_to_one(case in cases(), any in any_numbers()) {
        let joints = &case.arm.joints;
        let any = &any[..joints.len()];
        let back = links_from_constants(joints, &constants_from_links(joints, any));
        assert_close("links", &flat(&back), &flat(any), EXACT);
        let back = constants_from_links(joints, &links_from_constants(joints, any));
        assert_close("constants", &flat(&back), &flat(any), EXACT);
        let same = case.arm.with_constants(&case.arm.constants());
        assert_close("arm", &flat(&same.links), &flat(&case.arm.links), EXACT);
    }

    /// (36) is (25), the part of `Ĵ` carried over a translational joint `p` that depends on `d_p`:
    /// `V_i = R V_p Rᵀ + m̂ (Σ(s) - Σ(b)) + Π(s, R ĉ_p) - Π(b, R k_p)`.
    #[test]
    fn equation_36_equals_equation_25(case in cases()) {
        let Case { arm, q, .. } = &case;
        let (constants, poses) = (arm.constants(), arm.poses(q));
        let parts = varying_parts(&arm.joints, &constants, q);
        for p in (1..arm.dof()).filter(|&p| !arm.joints[p].kind.is_rotational()) {
            let (k, m) = (constants[p].first_moment_kgm, constants[p].mass_kg);
            let (s, b) = (poses[p].s, Vector3::new(arm.joints[p].frame.b_m, 0.0, 0.0));
            let expected = poses[p].tensor_to_parent(&parts[p].inertia)
                + (sigma(&s) - sigma(&b)) * m
                + pi(&s, &poses[p].to_parent(&(k + parts[p].first_moment)))
                - pi(&b, &poses[p].to_parent(&k));
            assert_close("V", parts[p - 1].inertia.as_slice(), expected.as_slice(), EXACT);
        }
    }

    /// (41): `(V_i)₃₃` of a rotational joint `i` from the next rotational joint `m` and the
    /// translational joints `t` between them; without `m` its part is absent.
    #[test]
    fn equation_41_gives_v33_alone(case in cases()) {
        let Case { arm, q, .. } = &case;
        let (constants, poses) = (arm.constants(), arm.poses(q));
        let parts = varying_parts(&arm.joints, &constants, q);
        for i in (0..arm.dof()).filter(|&i| arm.joints[i].kind.is_rotational()) {
            let axis = arm.axis_in_frames(&poses, i);
            let mut v33 = 0.0;
            for t in i + 1..arm.dof() {
                let u = axis[t - i].0;
                let quadratic = |m: &Matrix3<f64>| u.dot(&(m * u));
                let (k, l) = (constants[t].first_moment_kgm, parts[t].first_moment);
                if arm.joints[t].kind.is_rotational() {
                    let c = constants[t].inertia_origin_kgm2;
                    let w = Matrix3::new(
                        c[(0, 0)] - c[(1, 1)], c[(0, 1)], c[(0, 2)],
                        c[(0, 1)], 0.0, c[(1, 2)],
                        c[(0, 2)], c[(1, 2)], 0.0,
                    );
                    let s = poses[t].to_child(&poses[t].s);
                    let turning = l + Vector3::new(k.x, k.y, 0.0);
                    v33 += quadratic(&(parts[t].inertia + w + pi(&s, &turning)));
                    break;
                }
                let (m, b) = (constants[t].mass_kg, arm.joints[t].frame.b_m);
                let d = arm.joints[t].offset_m(q[t]);
                let (sin, cos) = arm.joints[t].frame.theta_rad.sin_cos();
                let t12 = b * (sin * l.x - cos * l.y);
                let (t13, t23) = (-b * cos * (l.z + m * d), b * sin * (l.z + m * d));
                let table = Matrix3::new(
                    m * d * d - 2.0 * b * sin * l.y, t12, t13,
                    t12, m * d * d + 2.0 * b * cos * l.x, t23,
                    t13, t23, 2.0 * b * (cos * l.x - sin * l.y),
                );
                let slide = Matrix3::new(
                    2.0 * d * l.z, 0.0, -d * l.x,
                    0.0, 2.0 * d * l.z, -d * l.y,
                    -d * l.x, -d * l.y, 0.0,
                );
                v33 += quadratic(&(table + slide))
                    + 2.0 * d * ((1.0 - u.z * u.z) * k.z - u.z * (u.x * k.x + u.y * k.y));
            }
            assert_close("V33", &[parts[i].inertia[(2, 2)]], &[v33], EXACT);
        }
    }
}

// ---- effort, inertia matrix, energy

proptest! {
    #![proptest_config(repeated(200))]

    /// `Y π = τ`, in standard parameters and in the constants.
    #[test]
    fn regressor_times_parameters_equals_newton_euler(case in cases(), any in any_numbers()) {
        let Case { arm, q, dq, ddq } = &case;
        let arm = &arm.with_links(any[..arm.dof()].to_vec());
        let effort = inverse_dynamics(arm, q, dq, ddq);
        let regressor = standard_regressor(arm, q, dq, ddq);
        assert_close("links", &product(&regressor, &flat(&arm.links)), &effort, EXACT);
        let standard = ParameterColumns::standard(arm.dof()).regressor(arm, q, dq, ddq);
        assert_close("columns", &standard, &regressor, EXACT);

        let units: Vec<Vec<BodyConstants>> = (0..10 * arm.dof())
            .map(|unit| {
                let mut numbers = vec![[0.0; 10]; arm.dof()];
                numbers[unit / 10][unit % 10] = 1.0;
                numbers.iter().map(BodyConstants::from_array).collect()
            })
            .collect();
        let columns = ParameterColumns::from_constants(arm, &units);
        let regressor = columns.regressor(arm, q, dq, ddq);
        assert_close("constants", &product(&regressor, &flat(&arm.constants())), &effort, EXACT);
    }

    /// (9), (10): column `j` of `H` is the effort of a unit acceleration of joint `j` from rest.
    #[test]
    fn inertia_matrix_columns_equal_newton_euler(case in cases()) {
        let Case { arm, q, .. } = &case;
        let n = arm.dof();
        let rest = vec![0.0; n];
        let held = inverse_dynamics(arm, q, &rest, &rest);
        let h = inertia_matrix(arm, q);
        for j in 0..n {
            let mut unit = rest.clone();
            unit[j] = 1.0;
            let pushed = inverse_dynamics(arm, q, &rest, &unit);
            let column: Vec<f64> = pushed.iter().zip(&held).map(|(p, h)| p - h).collect();
            assert_close("H", h.column(j).as_slice(), &column, EXACT);
        }
    }

    #[test]
    fn inertia_matrix_is_symmetric_and_positive_definite(case in heavy_cases()) {
        let h = inertia_matrix(&case.arm, &case.q);
        prop_assert_eq!(&h, &h.transpose());
        prop_assert!(h.symmetric_eigenvalues().min() > 0.0, "{}", h);
    }

    /// Links without mass leave no more than zero eigenvalues.
    #[test]
    fn inertia_matrix_is_semidefinite_for_consistent_links(case in cases()) {
        let h = inertia_matrix(&case.arm, &case.q);
        prop_assert!(h.symmetric_eigenvalues().min() >= -EXACT * h.amax(), "{}", h);
    }

    /// (11) is the effort at rest.
    #[test]
    fn gravity_effort_equals_newton_euler_at_rest(case in cases()) {
        let Case { arm, q, .. } = &case;
        let rest = vec![0.0; arm.dof()];
        let held = inverse_dynamics(arm, q, &rest, &rest);
        assert_close("gravity", &gravity_effort(arm, q), &held, EXACT);
    }

    /// `τᵍ = ∂V/∂q`. Differences of at most 1e3 J: round-off 1e-9, below 1e-8 of the largest effort.
    #[test]
    fn gravity_effort_is_gradient_of_potential_energy(case in cases()) {
        let Case { arm, q, .. } = &case;
        let rest = vec![0.0; arm.dof()];
        let gradient: Vec<f64> = (0..arm.dof())
            .map(|k| {
                derivative(|by| {
                    let mut at = q.clone();
                    at[k] += by;
                    energy(arm, &at, &rest)
                })
            })
            .collect();
        assert_close("gravity", &gradient, &gravity_effort(arm, q), 1e-8);
    }

    /// (30)-(32) and (29): the effort without acceleration is Coriolis plus gravity.
    #[test]
    fn coriolis_effort_equals_newton_euler_without_gravity(case in cases()) {
        let Case { arm, q, dq, ddq } = &case;
        let (coriolis, gravity) = (coriolis_effort(arm, q, dq), gravity_effort(arm, q));
        let bias = inverse_dynamics(arm, q, dq, &vec![0.0; arm.dof()]);
        let sum: Vec<f64> = coriolis.iter().zip(&gravity).map(|(c, g)| c + g).collect();
        assert_close("Coriolis", &sum, &bias, EXACT);
        let inertial = inertia_matrix(arm, q) * DVector::from_column_slice(ddq);
        let all: Vec<f64> = sum.iter().zip(inertial.iter()).map(|(s, i)| s + i).collect();
        assert_close("(29)", &all, &inverse_dynamics(arm, q, dq, ddq), EXACT);
    }

    /// `q̇ᵀ (Ḣ/2) q̇ = q̇ᵀ τᶜ`: Coriolis forces exchange kinetic energy only.
    #[test]
    fn coriolis_power_equals_half_inertia_rate(case in cases()) {
        let Case { arm, q, dq, .. } = &case;
        let v = DVector::from_column_slice(dq);
        let rate = inertia_matrix_derivatives(arm, q)
            .iter()
            .zip(dq)
            .fold(DMatrix::zeros(dq.len(), dq.len()), |sum, (dh, &speed)| sum + dh * speed);
        let effort = DVector::from_vec(coriolis_effort(arm, q, dq));
        let scale = largest(effort.component_mul(&v).as_slice()).max(1.0);
        let (found, expected) = (v.dot(&effort) / scale, 0.5 * v.dot(&(rate * &v)) / scale);
        assert_close("power", &[found], &[expected], EXACT);
    }

    /// `d/dt energy = q̇ · τ`. Relative to the largest power of a joint; the fifth derivative along the
    /// motion is some 1e7 times the energy (angular speeds up to 14 rad/s): 1e-8.
    #[test]
    fn effort_power_equals_energy_rate(case in cases()) {
        let Case { arm, q, dq, ddq } = &case;
        let rate = derivative(|t| {
            let moved = |x: f64, v: f64, a: f64| x + v * t + 0.5 * a * t * t;
            let at: Vec<f64> = (0..q.len()).map(|i| moved(q[i], dq[i], ddq[i])).collect();
            let speed: Vec<f64> = (0..q.len()).map(|i| dq[i] + ddq[i] * t).collect();
            energy(arm, &at, &speed)
        });
        let effort = inverse_dynamics(arm, q, dq, ddq);
        let power: Vec<f64> = effort.iter().zip(dq).map(|(e, v)| e * v).collect();
        let scale = largest(&power).max(1.0);
        assert_close("power", &[rate / scale], &[power.iter().sum::<f64>() / scale], 1e-8);
    }

    /// Exact interpolation against differences; entries of `H` up to some hundreds: 1e-9.
    #[test]
    fn inertia_matrix_derivatives_match_differences(case in cases()) {
        let Case { arm, q, .. } = &case;
        let derivatives = inertia_matrix_derivatives(arm, q);
        for k in 0..arm.dof() {
            let h = |by: f64| {
                let mut at = q.clone();
                at[k] += by;
                inertia_matrix(arm, &at)
            };
            let size = h(0.0).amax().max(1.0);
            for (index, found) in derivatives[k].iter().enumerate() {
                let expected = derivative(|by| h(by)[index]);
                prop_assert!((found - expected).abs() <= 1e-9 * size, "{found} {expected}");
            }
        }
    }

    /// Solving with `H` loses as many digits as its condition number has.
    #[test]
    fn forward_dynamics_inverts_inverse_dynamics(case in heavy_cases()) {
        let Case { arm, q, dq, ddq } = &case;
        let effort = inverse_dynamics(arm, q, dq, ddq);
        let found = forward_dynamics(arm, q, dq, &effort).unwrap();
        let eigenvalues = inertia_matrix(arm, q).symmetric_eigenvalues();
        // relative to the size of the efforts, of which the Coriolis and gravity parts cancel
        let size = largest(&effort).max(1.0) / eigenvalues.min();
        let scaled = |values: &[f64]| values.iter().map(|a| a / size).collect::<Vec<f64>>();
        assert_close("acceleration", &scaled(&found), &scaled(ddq), EXACT);
        let again = inverse_dynamics(arm, q, dq, &found);
        assert_close("effort", &again, &effort, 1e-9);
    }

    #[test]
    fn forward_dynamics_rejects_massless_joint(mut case in heavy_cases()) {
        let last = case.arm.dof() - 1;
        case.arm.links[last] = InertialParameters::zero();
        let effort = vec![0.0; case.arm.dof()];
        prop_assert!(forward_dynamics(&case.arm, &case.q, &case.dq, &effort).is_err());
    }
}

// ---- several samples at once

/// A motion of `samples` samples around the state of a case, joint-major.
fn motion(case: &Case, samples: usize) -> [Vec<Vec<f64>>; 3] {
    let columns = |start: &[f64], step: &[f64]| -> Vec<Vec<f64>> {
        let column = |(x, v): (&f64, &f64)| (0..samples).map(|t| x + 0.1 * t as f64 * v).collect();
        start.iter().zip(step).map(column).collect()
    };
    [columns(&case.q, &case.dq), columns(&case.dq, &case.ddq), columns(&case.ddq, &case.q)]
}

fn sample(columns: &[Vec<f64>], t: usize) -> Vec<f64> {
    columns.iter().map(|column| column[t]).collect()
}

proptest! {
    #![proptest_config(repeated(100))]

    /// Every length: one sample, whole batches, and a rest.
    #[test]
    fn motion_effort_equals_sample_efforts(case in cases(), samples in 1..20_usize) {
        let [q, dq, ddq] = &motion(&case, samples);
        let effort = inverse_dynamics_of_motion(&case.arm, q, dq, ddq);
        for t in 0..samples {
            let single =
                inverse_dynamics(&case.arm, &sample(q, t), &sample(dq, t), &sample(ddq, t));
            assert_close("effort", &sample(&effort, t), &single, EXACT);
        }
        prop_assert!(effort.iter().all(|column| column.len() == samples));
    }

    /// Regressor columns of a motion, any choice of them in any order.
    #[test]
    fn columns_of_a_motion_are_the_columns_of_its_samples(
        case in cases(),
        samples in 1..20_usize,
        any in prop::collection::vec(any_numbers(), 1..5),
        wanted in prop::collection::vec(any::<prop::sample::Index>(), 0..6),
    ) {
        let arm = &case.arm;
        let sets: Vec<_> = any.iter().map(|set| set[..arm.dof()].to_vec()).collect();
        let columns = ParameterColumns::from_constants(arm, &sets);
        prop_assert_eq!(columns.len(), sets.len());
        let wanted: Vec<usize> = wanted.iter().map(|index| index.index(columns.len())).collect();
        let [q, dq, ddq] = &motion(&case, samples);
        for joint in 0..arm.dof() {
            let found = columns.of_motion(arm, joint, q, dq, ddq, &wanted);
            prop_assert_eq!(found.len(), wanted.len());
            for t in 0..samples {
                let all = columns.regressor(arm, &sample(q, t), &sample(dq, t), &sample(ddq, t));
                let row = &all[joint * columns.len()..][..columns.len()];
                let expected: Vec<f64> = wanted.iter().map(|&c| row[c]).collect();
                assert_close("columns", &sample(&found, t), &expected, EXACT);
            }
        }
    }
}

// ---- bodies seen from other frames

proptest! {
    #![proptest_config(repeated(300))]

    /// The kinetic energy of a body does not depend on the frame it is written in, whatever its ten
    /// numbers: inertia without mass included.
    #[test]
    fn kinetic_energy_is_the_same_in_two_frames(
        ten in prop::array::uniform10(-1.0..1.0),
        massless in any::<bool>(),
        [x, y, z, roll, pitch, yaw] in prop::array::uniform6(-1.0..1.0),
        [v, w] in prop::array::uniform2(prop::array::uniform3(-1.0..1.0)),
    ) {
        let mut body = InertialParameters::from_array(&ten);
        if massless {
            body.mass_kg = 0.0;
        }
        let pose = Isometry3::from_parts(
            Translation3::new(x, y, z),
            UnitQuaternion::from_euler_angles(3.0 * roll, 3.0 * pitch, 3.0 * yaw),
        );
        // velocity of the frame's origin, angular velocity
        let kinetic = |body: &InertialParameters, v: Vector3<f64>, w: Vector3<f64>| {
            0.5 * body.mass_kg * v.norm_squared()
                + v.dot(&w.cross(&body.first_moment_kgm))
                + 0.5 * w.dot(&(body.inertia_origin_kgm2 * w))
        };
        let (v, w) = (Vector3::from(v), Vector3::from(w));
        let there_w = pose.rotation * w;
        let there_v = pose.rotation * v - there_w.cross(&pose.translation.vector);
        let there = kinetic(&body.expressed_in(&pose), there_v, there_w);
        assert_close("energy", &[there], &[kinetic(&body, v, w)], EXACT);
    }

    /// A last joint at rest may be removed and its link glued to the one before.
    #[test]
    fn fixed_link_gives_lumped_effort(case in cases(), any in any_numbers()) {
        let Case { arm, q, mut dq, mut ddq } = case;
        let last = arm.dof() - 1;
        if last == 0 {
            return Ok(());
        }
        let arm = arm.with_links(any[..=last].to_vec());
        (dq[last], ddq[last]) = (0.0, 0.0);
        let effort = inverse_dynamics(&arm, &q, &dq, &ddq);
        let moved = arm.links[last].expressed_in(&pose_at(&arm.joints[last], q[last]));
        let mut links = arm.links[..last].to_vec();
        links[last - 1] = links[last - 1].plus(&moved);
        let shorter =
            RigidArm { joints: arm.joints[..last].to_vec(), links, gravity_e0: arm.gravity_e0 };
        let found = inverse_dynamics(&shorter, &q[..last], &dq[..last], &ddq[..last]);
        assert_close("effort", &found, &effort[..last], EXACT);
    }
}

/// The kinds of the generated joints are mixed, and all families of special geometry occur.
#[test]
fn generated_arms_cover_all_kinds() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;

    let mut runner = TestRunner::new(repeated(1));
    let mut seen = [0; 8];
    for _ in 0..400 {
        let Case { arm, .. } = cases().new_tree(&mut runner).unwrap().current();
        let later = || arm.joints.iter().skip(1);
        let g = arm.gravity_e0;
        let facts = [
            arm.joints[0].kind == JointKind::Translational,
            later().any(|j| j.frame.b_m == 0.0 && j.frame.beta_rad == 0.0),
            later().any(|j| j.frame.b_m == 0.0 && j.frame.beta_rad.sin() != 0.0),
            later().all(|j| j.frame.b_m != 0.0 && j.frame.beta_rad.sin().abs() > 0.2),
            arm.dof() > 2 && later().all(|j| j.frame.beta_rad.sin().abs() < 1e-9),
            arm.links.iter().any(|link| link.mass_kg == 0.0),
            g == Vector3::zeros(),
            g.x != 0.0,
        ];
        for (count, fact) in seen.iter_mut().zip(facts) {
            *count += usize::from(fact);
        }
    }
    assert!(seen.iter().all(|&count| count > 20), "{seen:?}");
}
