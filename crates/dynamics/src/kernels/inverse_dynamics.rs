//! Newton-Euler inverse dynamics of a block of samples.

use pulp::Simd;

use super::arm::{AtJoint, Frame, KernelJoint, at_joint};
use super::block::{Block, JointBlock};
use super::link_motion::{LinkMotion, Rates, at_base, next};
use super::wrench::{Wrench, carried_to_parent};
use crate::lanes::BLOCK;
use crate::lanes::{Lanes, dot, lanes, store};

/// Efforts of joints `least` to n of the samples of a block, one column a joint.
#[inline(always)]
pub(super) fn efforts_of_block<S: Simd>(
    simd: S,
    joints: &[KernelJoint],
    gravity: &[f64; 3],
    block: &Block<'_>,
    least: usize,
    memory: &mut Memory<S>,
    effort: &mut [Vec<f64>],
) {
    let chunks = block.chunks::<S>();
    let motions = &mut memory.motions[..chunks];
    let base = at_base(simd, gravity);
    for motion in &mut *motions {
        *motion = base;
    }
    for (i, (joint, wrenches)) in joints.iter().zip(&mut memory.wrenches).enumerate() {
        at_joint(joint, Outward { simd, joint, samples: block.at(i), motions, wrenches });
    }
    for i in (least..joints.len()).rev() {
        let (before, own) = memory.wrenches.split_at_mut(i);
        let (joint, samples, wrenches) = (&joints[i], block.at(i), &own[0][..chunks]);
        let mut spare = [0.0; BLOCK];
        let (column, rest) = block.place(&mut effort[i], &mut spare);
        for (chunk, wrench) in wrenches.iter().enumerate() {
            let along = if joint.rotational { wrench.moment[2] } else { wrench.force[2] };
            store(column, chunk, along);
        }
        if let Some(rest) = rest {
            rest.copy_from_slice(&column[..block.len]);
        }
        if i > least {
            at_joint(joint, Inward { simd, joint, samples, wrenches, before: &mut before[i - 1] });
        }
    }
}

/// Memory between the joints, kept from block to block.
pub(super) struct Memory<S: Simd> {
    motions: Vec<LinkMotion<S>>,
    wrenches: Vec<Vec<Wrench<S>>>,
}

impl<S: Simd> Memory<S> {
    pub(super) fn new(simd: S, joints: usize) -> Self {
        let none = [Lanes::splat(simd, 0.0); 3];
        let chunks = BLOCK / S::F64_LANES;
        Self {
            motions: vec![LinkMotion { w: none, dw: none, a: none }; chunks],
            wrenches: vec![vec![Wrench { force: none, moment: none }; chunks]; joints],
        }
    }
}

/// Motion of a link and the wrench that moves it.
struct Outward<'a, S: Simd> {
    simd: S,
    joint: &'a KernelJoint,
    samples: JointBlock<'a>,
    motions: &'a mut [LinkMotion<S>],
    wrenches: &'a mut [Wrench<S>],
}

impl<S: Simd> AtJoint for Outward<'_, S> {
    #[inline(always)]
    fn run<const TURNS: bool, const TILT: u8>(self) {
        let Self { simd, joint, samples, motions, wrenches } = self;
        let frame = Frame::<S, TURNS, TILT>::of(simd, joint);
        let (sin, cos) = (lanes(simd, samples.sin), lanes(simd, samples.cos));
        let (q, dq, ddq) =
            (lanes(simd, samples.q), lanes(simd, samples.dq), lanes(simd, samples.ddq));
        let mut link = [Lanes::splat(simd, 0.0); 10];
        for (lanes, number) in link.iter_mut().zip(joint.link) {
            *lanes = Lanes::splat(simd, number);
        }
        for (chunk, (motion, wrench)) in motions.iter_mut().zip(wrenches).enumerate() {
            let pose = frame.at(sin(chunk), cos(chunk), || q(chunk));
            let (moved, rates) = next::<S, TURNS, TILT>(&pose, motion, dq(chunk), ddq(chunk));
            *motion = moved;
            *wrench = if TURNS {
                rotational_link(&link, &moved, &rates)
            } else {
                translational_link(&link, &moved, &rates)
            };
        }
    }
}

/// Wrench on a link without mass, z of the first moment and yy of the inertia.
#[inline(always)]
fn rotational_link<S: Simd>(
    &[_, cx, cy, _, xx, xy, xz, _, yz, zz]: &[Lanes<S>; 10],
    LinkMotion { dw, a, .. }: &LinkMotion<S>,
    rates: &Rates<S>,
) -> Wrench<S> {
    let b = &rates.b;
    // F = B c, N = I dw + w × I w + c × a; the moment of each product of inertia is an entry of B or a difference of two
    let force = [
        cx.times_plus(b[0][0], cy * b[0][1]),
        cx.times_plus(b[1][0], cy * b[1][1]),
        cx.times_plus(b[2][0], cy * b[2][1]),
    ];
    let nx = cy * a[2];
    let nx = xx.times_plus(dw[0], nx);
    let nx = xy.times_from(b[2][0], nx);
    let nx = xz.times_plus(b[1][0], nx);
    let nx = yz.times_plus(b[1][1] - b[2][2], nx);
    let nx = zz.times_plus(rates.yz, nx);
    let ny = xy * b[2][1];
    let ny = cx.times_from(a[2], ny);
    let ny = xx.times_plus(rates.xz, ny);
    let ny = xz.times_plus(b[2][2] - b[0][0], ny);
    let ny = yz.times_from(b[0][1], ny);
    let ny = zz.times_from(rates.xz, ny);
    let nz = cx * a[1];
    let nz = cy.times_from(a[0], nz);
    let nz = xx.times_from(rates.xy, nz);
    let nz = xy.times_plus(b[0][0] - b[1][1], nz);
    let nz = xz.times_from(b[1][2], nz);
    let nz = yz.times_plus(b[0][2], nz);
    let nz = zz.times_plus(dw[2], nz);
    Wrench { force, moment: [nx, ny, nz] }
}

/// Wrench on a link without inertia.
#[inline(always)]
fn translational_link<S: Simd>(
    &[mass, cx, cy, cz, ..]: &[Lanes<S>; 10],
    LinkMotion { a, .. }: &LinkMotion<S>,
    rates: &Rates<S>,
) -> Wrench<S> {
    let (b, c) = (&rates.b, [cx, cy, cz]);
    Wrench {
        force: [
            mass.times_plus(a[0], dot(c, b[0])),
            mass.times_plus(a[1], dot(c, b[1])),
            mass.times_plus(a[2], dot(c, b[2])),
        ],
        moment: [
            cz.times_from(a[1], cy * a[2]),
            cx.times_from(a[2], cz * a[0]),
            cy.times_from(a[0], cx * a[1]),
        ],
    }
}

/// The wrench on a link, carried to the link before it.
struct Inward<'a, S: Simd> {
    simd: S,
    joint: &'a KernelJoint,
    samples: JointBlock<'a>,
    wrenches: &'a [Wrench<S>],
    before: &'a mut [Wrench<S>],
}

impl<S: Simd> AtJoint for Inward<'_, S> {
    #[inline(always)]
    fn run<const TURNS: bool, const TILT: u8>(self) {
        let Self { simd, joint, samples, wrenches, before } = self;
        let frame = Frame::<S, TURNS, TILT>::of(simd, joint);
        let (sin, cos) = (lanes(simd, samples.sin), lanes(simd, samples.cos));
        let q = lanes(simd, samples.q);
        for (chunk, (wrench, before)) in wrenches.iter().zip(before).enumerate() {
            let pose = frame.at(sin(chunk), cos(chunk), || q(chunk));
            let Wrench { force, moment } = carried_to_parent(&pose, wrench);
            for k in 0..3 {
                before.force[k] = before.force[k] + force[k];
                before.moment[k] = before.moment[k] + moment[k];
            }
        }
    }
}
