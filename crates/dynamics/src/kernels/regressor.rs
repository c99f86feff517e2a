//! Regressor of a block of samples in the standard parameters, row by row.

use std::ops::Range;

use armident_kinematics::InertialParameters;
use pulp::Simd;

use super::arm::{AtJoint, Frame, KernelJoint, at_joint};
use super::block::{Block, JointBlock};
use super::link_motion::{LinkMotion, Rates, at_base, next};
use crate::lanes::BLOCK;
use crate::lanes::{Column, Lanes, Vector, dot, lanes, store};

const TEN: usize = InertialParameters::COUNT;
/// Parameters that a chain of rotational joints does not need of a link, because those of the link before it do the same:
/// mass, z of the first moment, yy of the inertia.
const NEEDLESS: [usize; 3] = [0, 3, 7];

/// Which of a link's parameters are wanted.
pub(crate) type Wanted = [bool; TEN];

/// What the parameters of a link are multiplied with.
#[derive(Debug, Clone, Copy)]
struct LinkTerms<S: Simd> {
    a: Vector<S>,
    dw: Vector<S>,
    rates: Rates<S>,
    /// `B_xx - B_yy`, `B_yy - B_zz`, `B_zz - B_xx`
    differences: Vector<S>,
}

/// Axis of a joint in the frame of a link: effort of the joint is `moment · N + force · F` for a force and a moment on the link.
#[derive(Debug, Clone, Copy)]
struct Axis<S: Simd> {
    moment: Vector<S>,
    force: Vector<S>,
}

/// Memory between the joints, kept from block to block.
pub(super) struct Memory<S: Simd> {
    motions: Vec<LinkMotion<S>>,
    terms: Vec<Vec<LinkTerms<S>>>,
    axes: Vec<Axis<S>>,
    row: Vec<Column>,
}

impl<S: Simd> Memory<S> {
    pub(super) fn new(simd: S, joints: usize) -> Self {
        let chunks = BLOCK / S::F64_LANES;
        let motion = at_base(simd, &[0.0; 3]);
        let none = motion.w;
        let terms = LinkTerms { a: none, dw: none, rates: Rates::of(&motion), differences: none };
        Self {
            motions: vec![motion; chunks],
            terms: vec![vec![terms; chunks]; joints],
            axes: vec![Axis { moment: none, force: none }; chunks],
            row: vec![[0.0; BLOCK]; TEN * joints],
        }
    }
}

/// Calls `each` with the rows of some joints: entry `10 i + k` is the column of parameter `k` of link `i`. Links before the joint,
/// and what is not wanted, have any value.
#[inline(always)]
pub(super) fn rows_of_block<S: Simd>(
    simd: S,
    joints: &[KernelJoint],
    gravity: &[f64; 3],
    block: &Block<'_>,
    rows: Range<usize>,
    wanted: &[Wanted],
    memory: &mut Memory<S>,
    mut each: impl FnMut(usize, &[Column]),
) {
    let chunks = block.chunks::<S>();
    let base = at_base(simd, gravity);
    let motions = &mut memory.motions[..chunks];
    for motion in &mut *motions {
        *motion = base;
    }
    for (i, (joint, terms)) in joints.iter().zip(&mut memory.terms).enumerate() {
        let needed = i >= rows.start;
        at_joint(joint, Outward { simd, joint, samples: block.at(i), motions, terms, needed });
    }
    for j in rows {
        let axes = &mut memory.axes[..chunks];
        own_link(simd, &joints[j], &memory.terms[j], axes, &mut memory.row[TEN * j..]);
        for i in j + 1..joints.len() {
            let (samples, terms) = (block.at(i), &memory.terms[i]);
            let row = &mut memory.row[TEN * i..];
            if NEEDLESS.iter().any(|&k| wanted[i][k]) {
                at_joint(
                    &joints[i],
                    Link::<S, true> { simd, joint: &joints[i], samples, terms, axes, row },
                );
            } else {
                at_joint(
                    &joints[i],
                    Link::<S, false> { simd, joint: &joints[i], samples, terms, axes, row },
                );
            }
        }
        each(j, &memory.row);
    }
}

/// Motion of a link, and the terms of its parameters.
struct Outward<'a, S: Simd> {
    simd: S,
    joint: &'a KernelJoint,
    samples: JointBlock<'a>,
    motions: &'a mut [LinkMotion<S>],
    terms: &'a mut [LinkTerms<S>],
    /// whether some row needs the terms
    needed: bool,
}

impl<S: Simd> AtJoint for Outward<'_, S> {
    #[inline(always)]
    fn run<const TURNS: bool, const TILT: u8>(self) {
        let Self { simd, joint, samples, motions, terms, needed } = self;
        let frame = Frame::<S, TURNS, TILT>::of(simd, joint);
        let (sin, cos) = (lanes(simd, samples.sin), lanes(simd, samples.cos));
        let (q, dq, ddq) =
            (lanes(simd, samples.q), lanes(simd, samples.dq), lanes(simd, samples.ddq));
        for (chunk, (motion, terms)) in motions.iter_mut().zip(terms).enumerate() {
            let pose = frame.at(sin(chunk), cos(chunk), || q(chunk));
            let (moved, rates) = next::<S, TURNS, TILT>(&pose, motion, dq(chunk), ddq(chunk));
            *motion = moved;
            if needed {
                let LinkMotion { dw, a, .. } = moved;
                let b = &rates.b;
                let (xx, yy, zz) = (b[0][0], b[1][1], b[2][2]);
                *terms = LinkTerms { a, dw, rates, differences: [xx - yy, yy - zz, zz - xx] };
            }
        }
    }
}

/// Row of a joint at its own link, whose axis is z.
#[inline(always)]
fn own_link<S: Simd>(
    simd: S,
    joint: &KernelJoint,
    terms: &[LinkTerms<S>],
    axes: &mut [Axis<S>],
    row: &mut [Column],
) {
    let (zero, one) = (Lanes::splat(simd, 0.0), Lanes::splat(simd, 1.0));
    for (chunk, (axis, terms)) in axes.iter_mut().zip(terms).enumerate() {
        let LinkTerms { a, dw, rates, differences } = terms;
        let b = &rates.b;
        let (moment, force, entries) = if joint.rotational {
            let inertia = [-rates.xy, differences[0], -b[1][2], rates.xy, b[0][2], dw[2]];
            (
                one,
                zero,
                [
                    zero, a[1], -a[0], zero, inertia[0], inertia[1], inertia[2], inertia[3],
                    inertia[4], inertia[5],
                ],
            )
        } else {
            (zero, one, [a[2], b[2][0], b[2][1], b[2][2], zero, zero, zero, zero, zero, zero])
        };
        *axis = Axis { moment: [zero, zero, moment], force: [zero, zero, force] };
        for (entry, column) in entries.into_iter().zip(&mut *row) {
            store(column, chunk, entry);
        }
    }
}

/// Row of a joint at a later link: the axis is carried to it first. `ALL`: also the entries of needless parameters.
struct Link<'a, S: Simd, const ALL: bool> {
    simd: S,
    joint: &'a KernelJoint,
    samples: JointBlock<'a>,
    terms: &'a [LinkTerms<S>],
    axes: &'a mut [Axis<S>],
    row: &'a mut [Column],
}

impl<S: Simd, const ALL: bool> AtJoint for Link<'_, S, ALL> {
    #[inline(always)]
    fn run<const TURNS: bool, const TILT: u8>(self) {
        let Self { simd, joint, samples, terms, axes, row } = self;
        let Some(row) = row.first_chunk_mut::<TEN>() else { return };
        let frame = Frame::<S, TURNS, TILT>::of(simd, joint);
        let (sin, cos) = (lanes(simd, samples.sin), lanes(simd, samples.cos));
        let q = lanes(simd, samples.q);
        for (chunk, (axis, terms)) in axes.iter_mut().zip(terms).enumerate() {
            let pose = frame.at(sin(chunk), cos(chunk), || q(chunk));
            let Axis { moment: u, force: mut f } = *axis;
            // u × b x
            if pose.apart {
                f[1] = pose.b.times_plus(u[2], f[1]);
                f[2] = pose.b.times_from(u[1], f[2]);
            }
            let (u, mut f) = (pose.to_child(u), pose.to_child(f));
            // u × d z
            f[0] = pose.d.times_plus(u[1], f[0]);
            f[1] = pose.d.times_from(u[0], f[1]);
            *axis = Axis { moment: u, force: f };

            let LinkTerms { a, dw, rates: Rates { b, xy, xz, yz }, differences } = terms;
            let mut put = |k: usize, entry| store(&mut row[k], chunk, entry);
            let along =
                |k: usize| f[0].times_plus(b[0][k], f[1].times_plus(b[1][k], f[2] * b[2][k]));
            put(1, a[1].times_plus(u[2], a[2].times_from(u[1], along(0))));
            put(2, a[2].times_plus(u[0], a[0].times_from(u[2], along(1))));
            put(4, u[0].times_plus(dw[0], u[1].times_plus(*xz, -(u[2] * *xy))));
            put(5, u[1].times_plus(b[2][1], u[0].times_from(b[2][0], u[2] * differences[0])));
            put(6, u[0].times_plus(b[1][0], u[2].times_from(b[1][2], u[1] * differences[2])));
            put(8, u[2].times_plus(b[0][2], u[1].times_from(b[0][1], u[0] * differences[1])));
            put(9, u[2].times_plus(dw[2], u[1].times_from(*xz, u[0] * *yz)));
            if ALL {
                put(0, dot(f, *a));
                put(3, a[0].times_plus(u[1], a[1].times_from(u[0], along(2))));
                put(7, u[1].times_plus(dw[1], u[0].times_from(*yz, u[2] * *xy)));
            }
        }
    }
}
