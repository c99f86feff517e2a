//! Inertia matrix of a block of samples: composite bodies, and the wrench of a unit acceleration of each joint carried to the base
//! (Walker and Orin 1982).

use pulp::Simd;

use super::arm::{AtJoint, Frame, KernelJoint, Pose, at_joint};
use super::block::{Block, JointBlock};
use super::wrench::{Wrench, carried_to_parent};
use crate::lanes::BLOCK;
use crate::lanes::{Lanes, Vector, lanes, store};

/// First moment and inertia of the links from one on, about its origin and in its frame; the mass does not move.
#[derive(Debug, Clone, Copy)]
struct Body<S: Simd> {
    first_moment: Vector<S>,
    /// xx, xy, xz, yy, yz, zz
    inertia: [Lanes<S>; 6],
}

/// Memory between the joints, kept from block to block.
pub(super) struct Memory<S: Simd> {
    bodies: Vec<Body<S>>,
    /// per joint: wrench of its unit acceleration
    wrenches: Vec<Vec<Wrench<S>>>,
    masses: Vec<f64>,
}

impl<S: Simd> Memory<S> {
    pub(super) fn new(simd: S, joints: &[KernelJoint]) -> Self {
        let zero = Lanes::splat(simd, 0.0);
        let chunks = BLOCK / S::F64_LANES;
        let wrench = Wrench { force: [zero; 3], moment: [zero; 3] };
        let mut masses: Vec<f64> = joints.iter().map(|joint| joint.link[0]).collect();
        for i in (1..masses.len()).rev() {
            masses[i - 1] += masses[i];
        }
        Self {
            bodies: vec![Body { first_moment: [zero; 3], inertia: [zero; 6] }; chunks],
            wrenches: vec![vec![wrench; chunks]; joints.len()],
            masses,
        }
    }
}

/// Upper triangle of the inertia matrices of a block, row by row: `matrix[place(i, k)]`, `i <= k`.
#[inline(always)]
pub(super) fn matrices_of_block<S: Simd>(
    simd: S,
    joints: &[KernelJoint],
    block: &Block<'_>,
    place: impl Fn(usize, usize) -> usize,
    memory: &mut Memory<S>,
    matrix: &mut [Vec<f64>],
) {
    let chunks = block.chunks::<S>();
    let zero = Lanes::splat(simd, 0.0);
    let bodies = &mut memory.bodies[..chunks];
    for body in &mut *bodies {
        *body = Body { first_moment: [zero; 3], inertia: [zero; 6] };
    }
    for i in (0..joints.len()).rev() {
        let (joint, mass) = (&joints[i], memory.masses[i]);
        add_link(simd, joint, mass, bodies, &mut memory.wrenches[i]);
        for (k, wrenches) in memory.wrenches.iter().enumerate().skip(i) {
            let mut spare = [0.0; BLOCK];
            let (column, rest) = block.place(&mut matrix[place(i, k)], &mut spare);
            for (chunk, wrench) in wrenches[..chunks].iter().enumerate() {
                let along = if joint.rotational { wrench.moment[2] } else { wrench.force[2] };
                store(column, chunk, along);
            }
            if let Some(rest) = rest {
                rest.copy_from_slice(&column[..block.len]);
            }
        }
        if i > 0 {
            let (samples, wrenches) = (block.at(i), &mut memory.wrenches[i..]);
            at_joint(joint, Inward { simd, joint, samples, mass, bodies, wrenches });
        }
    }
}

/// Adds the link of a joint to the body, and starts the column of the joint.
#[inline(always)]
fn add_link<S: Simd>(
    simd: S,
    joint: &KernelJoint,
    mass: f64,
    bodies: &mut [Body<S>],
    wrenches: &mut [Wrench<S>],
) {
    let (zero, mass) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, mass));
    for (body, wrench) in bodies.iter_mut().zip(wrenches) {
        for k in 0..3 {
            body.first_moment[k] = body.first_moment[k] + Lanes::splat(simd, joint.link[1 + k]);
        }
        for k in 0..6 {
            body.inertia[k] = body.inertia[k] + Lanes::splat(simd, joint.link[4 + k]);
        }
        let Body { first_moment: c, inertia: [_, _, xz, _, yz, zz] } = *body;
        *wrench = if joint.rotational {
            Wrench { force: [-c[1], c[0], zero], moment: [xz, yz, zz] }
        } else {
            Wrench { force: [zero, zero, mass], moment: [c[1], -c[0], zero] }
        };
    }
}

/// The body and all wrenches, carried to the link before.
struct Inward<'a, S: Simd> {
    simd: S,
    joint: &'a KernelJoint,
    samples: JointBlock<'a>,
    mass: f64,
    bodies: &'a mut [Body<S>],
    wrenches: &'a mut [Vec<Wrench<S>>],
}

impl<S: Simd> AtJoint for Inward<'_, S> {
    #[inline(always)]
    fn run<const TURNS: bool, const TILT: u8>(self) {
        let Self { simd, joint, samples, mass, bodies, wrenches } = self;
        let frame = Frame::<S, TURNS, TILT>::of(simd, joint);
        let (sin, cos) = (lanes(simd, samples.sin), lanes(simd, samples.cos));
        let q = lanes(simd, samples.q);
        let mass = Lanes::splat(simd, mass);
        for (chunk, body) in bodies.iter_mut().enumerate() {
            let pose = frame.at(sin(chunk), cos(chunk), || q(chunk));
            *body = body_in_parent(&pose, mass, body);
        }
        for wrenches in wrenches {
            for (chunk, wrench) in wrenches[..bodies.len()].iter_mut().enumerate() {
                let pose = frame.at(sin(chunk), cos(chunk), || q(chunk));
                *wrench = carried_to_parent(&pose, wrench);
            }
        }
    }
}

/// A body about the origin of the frame before: moved along z of its frame, turned, moved along x of the frame before.
#[inline(always)]
fn body_in_parent<S: Simd, const TILT: u8>(
    pose: &Pose<S, TILT>,
    mass: Lanes<S>,
    Body { first_moment: c, inertia: [xx, xy, xz, yy, yz, zz] }: &Body<S>,
) -> Body<S> {
    let d = pose.d;
    let moved = mass * d;
    let mut c = *c;
    // Σ m ((z + d)² - z²)
    let more = d * (c[2] + c[2] + moved);
    let along = [*xx + more, *xy, *yy + more];
    let (across, zz) = ([d.times_from(c[0], *xz), d.times_from(c[1], *yz)], *zz);
    c[2] = c[2] + moved;

    let mut c = pose.to_parent(c);
    let [xx, xy, xz, yy, yz, zz] = pose.tensor_to_parent(along, across, zz);

    let b = pose.b;
    let moved = mass * b;
    let more = b * (c[0] + c[0] + moved);
    let inertia = [xx, b.times_from(c[1], xy), b.times_from(c[2], xz), yy + more, yz, zz + more];
    c[0] = c[0] + moved;
    Body { first_moment: c, inertia }
}
