//! The ten standard inertial parameters of one rigid body and their change of frame.

use nalgebra::{Isometry3, Matrix3, Matrix4, Vector3};

/// Mass, first moment and inertia about the frame **origin** of one rigid body, in one frame.
///
/// The vector order is `m, mcx, mcy, mcz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz`; products of inertia carry
/// the sign of the tensor (as in URDF).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InertialParameters {
    /// Mass \[kg\].
    pub mass_kg: f64,
    /// Mass times centre of mass \[kg m\].
    pub first_moment_kgm: Vector3<f64>,
    /// Inertia tensor about the frame origin \[kg m2\], symmetric.
    pub inertia_origin_kgm2: Matrix3<f64>,
}

impl InertialParameters {
    /// Number of standard parameters of a body.
    pub const COUNT: usize = 10;

    /// A body without mass.
    pub fn zero() -> Self {
        Self {
            mass_kg: 0.0,
            first_moment_kgm: Vector3::zeros(),
            inertia_origin_kgm2: Matrix3::zeros(),
        }
    }

    /// From mass \[kg\], centre of mass \[m\] and inertia about the centre of mass \[kg m2\], one frame.
    pub fn from_com(mass_kg: f64, com_m: Vector3<f64>, inertia_com_kgm2: Matrix3<f64>) -> Self {
        Self {
            mass_kg,
            first_moment_kgm: mass_kg * com_m,
            inertia_origin_kgm2: inertia_com_kgm2 + mass_kg * steiner(com_m),
        }
    }

    /// Centre of mass \[m\]; the origin for a body without mass.
    pub fn com_m(&self) -> Vector3<f64> {
        if self.mass_kg == 0.0 { Vector3::zeros() } else { self.first_moment_kgm / self.mass_kg }
    }

    /// Inertia about the centre of mass \[kg m2\], axes of the frame.
    pub fn inertia_com_kgm2(&self) -> Matrix3<f64> {
        self.inertia_origin_kgm2 - self.mass_kg * steiner(self.com_m())
    }

    /// The same body seen from another frame; `pose` places this frame in the other one.
    #[must_use]
    pub fn expressed_in(&self, pose: &Isometry3<f64>) -> Self {
        let rotation = pose.rotation.to_rotation_matrix();
        let (turned, t) = (rotation * self.first_moment_kgm, pose.translation.vector);
        // parallel axes in terms of first moments, so that a body without mass needs no special case
        let shift = Matrix3::identity() * (2.0 * t.dot(&turned))
            - (t * turned.transpose() + turned * t.transpose());
        let inertia = rotation * self.inertia_origin_kgm2 * rotation.transpose();
        Self {
            mass_kg: self.mass_kg,
            first_moment_kgm: turned + self.mass_kg * t,
            inertia_origin_kgm2: symmetrized(inertia) + self.mass_kg * steiner(t) + shift,
        }
    }

    /// Sum of two bodies fixed to each other, in the same frame.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            mass_kg: self.mass_kg + other.mass_kg,
            first_moment_kgm: self.first_moment_kgm + other.first_moment_kgm,
            inertia_origin_kgm2: self.inertia_origin_kgm2 + other.inertia_origin_kgm2,
        }
    }

    /// The ten numbers in the order of the type's documentation.
    pub fn to_array(&self) -> [f64; 10] {
        let (c, i) = (&self.first_moment_kgm, &self.inertia_origin_kgm2);
        [
            self.mass_kg,
            c.x,
            c.y,
            c.z,
            i[(0, 0)],
            i[(0, 1)],
            i[(0, 2)],
            i[(1, 1)],
            i[(1, 2)],
            i[(2, 2)],
        ]
    }

    /// Inverse of [`Self::to_array`].
    pub fn from_array(p: &[f64; 10]) -> Self {
        Self {
            mass_kg: p[0],
            first_moment_kgm: Vector3::new(p[1], p[2], p[3]),
            inertia_origin_kgm2: Matrix3::new(p[4], p[5], p[6], p[5], p[7], p[8], p[6], p[8], p[9]),
        }
    }

    /// The pseudo-inertia `[[S, mc], [mcᵀ, m]]` with `S = tr(I)/2 1 - I = ∫ r rᵀ dm`.
    ///
    /// Linear in the ten parameters, and positive semidefinite exactly when some distribution of
    /// non-negative mass has them (Wensing, Kim, Slotine 2018, eq. 6-11).
    pub fn pseudo_inertia(&self) -> Matrix4<f64> {
        let mut pseudo = Matrix4::zeros();
        pseudo.fixed_view_mut::<3, 3>(0, 0).copy_from(&second_moment(&self.inertia_origin_kgm2));
        pseudo.fixed_view_mut::<3, 1>(0, 3).copy_from(&self.first_moment_kgm);
        pseudo.fixed_view_mut::<1, 3>(3, 0).copy_from(&self.first_moment_kgm.transpose());
        pseudo[(3, 3)] = self.mass_kg;
        pseudo
    }

    /// Inverse of [`Self::pseudo_inertia`]; of a matrix that is not symmetric its symmetric part.
    pub fn from_pseudo_inertia(pseudo: &Matrix4<f64>) -> Self {
        let pseudo = (pseudo + pseudo.transpose()) * 0.5;
        Self {
            mass_kg: pseudo[(3, 3)],
            first_moment_kgm: pseudo.fixed_view::<3, 1>(0, 3).into(),
            inertia_origin_kgm2: inertia_of(&pseudo.fixed_view::<3, 3>(0, 0).into()),
        }
    }

    /// Second moment `∫ r rᵀ dm` about the centre of mass \[kg m2\], axes of the frame.
    pub fn second_moment_com_kgm2(&self) -> Matrix3<f64> {
        second_moment(&self.inertia_com_kgm2())
    }

    /// A root `Λ` of the pseudo-inertia `J = Λ Λᵀ` of the body with this mass and centre of mass, whose second
    /// moment about it has these `axes` (columns) and these principal values, none negative.
    pub fn pseudo_inertia_root(
        mass_kg: f64,
        com_m: Vector3<f64>,
        axes: &Matrix3<f64>,
        principal_kgm2: &Vector3<f64>,
    ) -> Matrix4<f64> {
        let mut root = Matrix4::zeros();
        let shape = axes * Matrix3::from_diagonal(&principal_kgm2.map(f64::sqrt));
        root.fixed_view_mut::<3, 3>(0, 0).copy_from(&shape);
        root.fixed_view_mut::<3, 1>(0, 3).copy_from(&(com_m * mass_kg.sqrt()));
        root[(3, 3)] = mass_kg.sqrt();
        root
    }

    /// Smallest eigenvalue of the pseudo-inertia; not negative for a physically consistent body.
    pub fn smallest_pseudo_inertia_eigenvalue(&self) -> f64 {
        self.pseudo_inertia().symmetric_eigenvalues().min()
    }

    /// Whether the parameters are physically consistent (to round-off): some distribution of
    /// non-negative mass has them.
    pub fn is_physical(&self) -> bool {
        let scale = self.inertia_origin_kgm2.amax().max(self.mass_kg.abs());
        self.smallest_pseudo_inertia_eigenvalue() >= -1e-9 * scale
    }

    /// Projection to the nearest physically consistent body; a consistent body is unchanged.
    ///
    /// Mass and centre of mass are kept, and the second moment about the centre of mass is replaced
    /// by the nearest positive semidefinite one in the Frobenius norm, which does not depend on the
    /// frame: its negative principal values become zero. A negative mass becomes zero, and with it
    /// the first moment.
    #[must_use]
    pub fn nearest_physical(&self) -> Self {
        let (mass, com) =
            if self.mass_kg > 0.0 { (self.mass_kg, self.com_m()) } else { (0.0, Vector3::zeros()) };
        let inertia = if mass > 0.0 { self.inertia_com_kgm2() } else { self.inertia_origin_kgm2 };
        let eigen = second_moment(&inertia).symmetric_eigen();
        let raised = Matrix3::from_diagonal(&eigen.eigenvalues.map(|x| x.max(0.0)));
        let moment = eigen.eigenvectors * raised * eigen.eigenvectors.transpose();
        Self::from_com(mass, com, inertia_of(&moment))
    }
}

/// `tr(I)/2 1 - I`: second moment `∫ r rᵀ dm` of a body with inertia `I`.
fn second_moment(inertia: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * (0.5 * inertia.trace()) - inertia
}

/// `tr(S) 1 - S`, the inverse of [`second_moment`].
fn inertia_of(moment: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * moment.trace() - moment
}

/// `Σ(a) = (a·a) 1 - a aᵀ`, the inertia of a unit point mass at `a` about the origin.
fn steiner(a: Vector3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * a.norm_squared() - a * a.transpose()
}

fn symmetrized(m: Matrix3<f64>) -> Matrix3<f64> {
    (m + m.transpose()) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    fn body() -> InertialParameters {
        InertialParameters::from_com(
            2.5,
            Vector3::new(0.1, -0.2, 0.3),
            Matrix3::new(0.05, 0.002, -0.001, 0.002, 0.06, 0.003, -0.001, 0.003, 0.04),
        )
    }

    #[test]
    fn frame_change_round_trips_and_keeps_invariants() {
        let pose = Isometry3::from_parts(
            Vector3::new(0.4, 0.5, -0.6).into(),
            UnitQuaternion::from_euler_angles(0.3, -1.1, 2.0),
        );
        let there = body().expressed_in(&pose);
        let back = there.expressed_in(&pose.inverse());
        for (a, b) in back.to_array().iter().zip(body().to_array()) {
            assert!((a - b).abs() < 1e-14, "{a} {b}");
        }
        // eigenvalues of the inertia about the centre of mass do not depend on the frame
        let (mut e0, mut e1) = (
            body().inertia_com_kgm2().symmetric_eigenvalues().as_slice().to_vec(),
            there.inertia_com_kgm2().symmetric_eigenvalues().as_slice().to_vec(),
        );
        e0.sort_by(f64::total_cmp);
        e1.sort_by(f64::total_cmp);
        for (a, b) in e0.iter().zip(e1) {
            assert!((a - b).abs() < 1e-14);
        }
    }

    #[test]
    fn array_round_trips() {
        let numbers: [f64; 10] = std::array::from_fn(|i| i as f64 + 1.0);
        assert_eq!(InertialParameters::from_array(&numbers).to_array(), numbers);
    }

    #[test]
    fn triangle_inequality_decides_physical_consistency() {
        assert!(body().is_physical());
        // link 1 of the Stanford arm as printed in Fig. 2 of Lin 1992: 0.276 + 0.255 < 0.71
        let printed = InertialParameters::from_com(
            9.29,
            Vector3::new(0.0, 0.1105, 0.0175),
            Matrix3::from_diagonal(&Vector3::new(0.276, 0.255, 0.71)),
        );
        assert!(!printed.is_physical());
        // mass, centre of mass and the 0.71 that the motion depends on stay
        let real = printed.nearest_physical();
        assert!(real.is_physical() && real.mass_kg == printed.mass_kg);
        assert_eq!(real.first_moment_kgm, printed.first_moment_kgm);
        let inertia = real.inertia_com_kgm2();
        for (k, expected) in [0.3655, 0.3445, 0.71].into_iter().enumerate() {
            assert!((inertia[(k, k)] - expected).abs() < 1e-12, "{inertia}");
        }
    }

    #[test]
    fn projection_is_frame_invariant_and_idempotent() {
        let flat = InertialParameters::from_com(
            2.0,
            Vector3::new(0.1, -0.3, 0.2),
            Matrix3::new(0.02, 0.01, 0.0, 0.01, 0.09, -0.02, 0.0, -0.02, 0.01),
        );
        let pose = Isometry3::from_parts(
            Vector3::new(0.4, 0.5, -0.6).into(),
            UnitQuaternion::from_euler_angles(0.3, -1.1, 2.0),
        );
        let one = flat.nearest_physical().expressed_in(&pose);
        let other = flat.expressed_in(&pose).nearest_physical();
        let twice = other.nearest_physical();
        for ((a, b), c) in one.to_array().iter().zip(other.to_array()).zip(twice.to_array()) {
            assert!((a - b).abs() < 1e-12 && (b - c).abs() < 1e-12);
        }
    }

    #[test]
    fn root_squares_to_pseudo_inertia() {
        let body = body();
        let eigen = body.second_moment_com_kgm2().symmetric_eigen();
        let root = InertialParameters::pseudo_inertia_root(
            body.mass_kg,
            body.com_m(),
            &eigen.eigenvectors,
            &eigen.eigenvalues,
        );
        assert!((root * root.transpose() - body.pseudo_inertia()).amax() < 1e-14);
    }

    #[test]
    fn pseudo_inertia_round_trips() {
        let back = InertialParameters::from_pseudo_inertia(&body().pseudo_inertia());
        for (a, b) in back.to_array().iter().zip(body().to_array()) {
            assert!((a - b).abs() < 1e-15);
        }
    }
}
