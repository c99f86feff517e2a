//! Shapes of links: the primitives of `<collision>`.

use nalgebra::Isometry3;

/// Form and size of a shape, centred in its own frame.
#[derive(Debug, Clone, PartialEq)]
pub enum CollisionGeometry {
    /// A box.
    Cuboid {
        /// Half of its edges \[m\].
        half_edges_m: [f64; 3],
    },
    /// A cylinder along z.
    Cylinder {
        /// Radius \[m\].
        radius_m: f64,
        /// Length \[m\].
        length_m: f64,
    },
    /// A sphere.
    Sphere {
        /// Radius \[m\].
        radius_m: f64,
    },
    /// Not read: a mesh, another tag, or sizes that are not positive numbers; the tag, or `geometry` where it is empty.
    NotRead(String),
}

/// One `<collision>` of a link.
#[derive(Debug, Clone, PartialEq)]
pub struct CollisionShape {
    /// Name of the link.
    pub link: String,
    /// Pose of the shape in the frame of its owner: of the link, or of the body that the link belongs to.
    pub pose: Isometry3<f64>,
    /// Form and size.
    pub geometry: CollisionGeometry,
}

impl CollisionShape {
    /// The same shape in a frame in which its owner has this pose.
    #[must_use]
    pub fn moved(&self, pose: &Isometry3<f64>) -> Self {
        Self { pose: pose * self.pose, ..self.clone() }
    }
}
