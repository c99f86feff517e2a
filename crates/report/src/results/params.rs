//! `armident params`: the chain table and the minimal set, as data and text.

use std::collections::BTreeMap;

use armident_dynamics::RigidArm;
use armident_ident::MinimalSet;
use armident_model::ArmModel;
use nalgebra::{Isometry3, Matrix3};
use serde::Serialize;

use crate::layout::{aligned, significant};

/// The result of `params`; field names are those of the shared golden data.
#[derive(Debug, Clone, Serialize)]
pub struct ParamsReport {
    schema: &'static str,
    robot: String,
    urdf: String,
    note: String,
    base_link: String,
    tip_link: String,
    gravity: [f64; 3],
    locked: BTreeMap<String, f64>,
    n: usize,
    joint_names: Vec<String>,
    types: String,
    child_links: Vec<String>,
    axis_pairs: Vec<&'static str>,
    #[serde(rename = "E0_in_base")]
    e0_in_base: [[f64; 4]; 4],
    #[serde(rename = "gravity_E0")]
    gravity_e0: [f64; 3],
    dh: Vec<FrameRow>,
    links: Vec<LinkRow>,
    constants: Vec<BodyRow>,
    r: Option<usize>,
    s: Option<usize>,
    delta: BTreeMap<String, u8>,
    sigma: BTreeMap<String, u8>,
    theorem2: Vec<TheoremRow>,
    count_theorem2: usize,
    rank_numeric: usize,
    rank_smallest_kept: f64,
    rank_largest_dropped: f64,
    standard_parameters: usize,
    minimal: Vec<MinimalRow>,
    dropped: Vec<DroppedRow>,
    sufficiency_error: f64,
    confirmed: bool,
    snap_error: f64,
    ignored_elements: Vec<String>,
    warnings: Vec<String>,
}

#[derive(Debug, Clone, Serialize)]
struct FrameRow {
    joint: usize,
    #[serde(rename = "type")]
    kind: char,
    b: f64,
    d: f64,
    beta: f64,
    theta: f64,
}

#[derive(Debug, Clone, Serialize)]
struct LinkRow {
    mass: f64,
    com: [f64; 3],
    inertia_com: [[f64; 3]; 3],
    #[serde(rename = "child_link_in_E")]
    child_link_in_e: [[f64; 4]; 4],
    urdf_links: Vec<String>,
}

#[derive(Debug, Clone, Serialize)]
struct BodyRow {
    mhat: f64,
    k: [f64; 3],
    #[serde(rename = "U")]
    u: [[f64; 3]; 3],
}

#[derive(Debug, Clone, Serialize)]
struct TheoremRow {
    label: String,
    item: u8,
    joint: usize,
    value: f64,
}

#[derive(Debug, Clone, Serialize)]
struct MinimalRow {
    label: String,
    value: f64,
    unit: &'static str,
}

#[derive(Debug, Clone, Serialize)]
struct DroppedRow {
    label: String,
    regrouped_into: BTreeMap<String, f64>,
}

fn rows3(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]))
}

fn rows4(pose: &Isometry3<f64>) -> [[f64; 4]; 4] {
    let m = pose.to_homogeneous();
    std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]))
}

impl ParamsReport {
    /// Collects the report of a model and its minimal set.
    pub fn new(model: &ArmModel, set: &MinimalSet) -> Self {
        let chain = &model.chain;
        let arm: RigidArm = model.rigid_arm();
        let bodies = arm.constants();
        let flags = |map: &BTreeMap<usize, bool>| {
            map.iter().map(|(j, &flag)| ((j + 1).to_string(), u8::from(flag))).collect()
        };
        let labels = set.labels();
        let values = set.values(&bodies);
        let mut warnings: Vec<String> = chain.warnings.iter().map(ToString::to_string).collect();
        if !set.is_confirmed() {
            warnings.push(format!(
                "minimal set size ({}) and regressor rank ({}) disagree (smallest kept singular \
                 value {:.1e}, largest dropped {:.1e}; sufficiency error {:.1e}): nearly \
                 degenerate geometry. Try --snap-rpy 2e-3 [minimal-set-ambiguous]",
                set.len(),
                set.rank.rank,
                set.rank.smallest_kept,
                set.rank.largest_dropped,
                set.sufficiency_error
            ));
        }
        Self {
            schema: "armident.params/1",
            robot: chain.robot.clone(),
            urdf: chain.source.clone(),
            note: String::new(),
            base_link: chain.base_link.clone(),
            tip_link: chain.tip_link.clone(),
            gravity: chain.gravity_base.into(),
            locked: chain.locked.clone(),
            n: chain.dof(),
            joint_names: chain.joints.iter().map(|j| j.name.clone()).collect(),
            types: chain.types(),
            child_links: chain.joints.iter().map(|j| j.child_link.clone()).collect(),
            axis_pairs: chain.axis_pairs.iter().map(|p| p.name()).collect(),
            e0_in_base: rows4(&chain.base_from_e0),
            gravity_e0: chain.gravity_e0.into(),
            dh: chain
                .joints
                .iter()
                .enumerate()
                .map(|(i, j)| FrameRow {
                    joint: i + 1,
                    kind: j.kind.letter(),
                    b: j.frame.b_m,
                    d: j.frame.d_m,
                    beta: j.frame.beta_rad,
                    theta: j.frame.theta_rad,
                })
                .collect(),
            links: chain
                .joints
                .iter()
                .map(|j| LinkRow {
                    mass: j.link.mass_kg,
                    com: j.link.com_m().into(),
                    inertia_com: rows3(&j.link.inertia_com_kgm2()),
                    child_link_in_e: rows4(&j.child_link_in_e),
                    urdf_links: j.body_links.clone(),
                })
                .collect(),
            constants: bodies
                .iter()
                .map(|body| BodyRow {
                    mhat: body.mass_kg,
                    k: body.first_moment_kgm.into(),
                    u: rows3(&body.inertia_origin_kgm2),
                })
                .collect(),
            r: set.theorem.r.map(|j| j + 1),
            s: set.theorem.s.map(|j| j + 1),
            delta: flags(&set.theorem.delta),
            sigma: flags(&set.theorem.sigma),
            theorem2: set
                .theorem
                .constants
                .iter()
                .map(|(item, constant)| TheoremRow {
                    label: constant.label(),
                    item: *item,
                    joint: constant.joint + 1,
                    value: constant.value(&bodies),
                })
                .collect(),
            count_theorem2: set.theorem.constants.len(),
            rank_numeric: set.rank.rank,
            rank_smallest_kept: set.rank.smallest_kept,
            rank_largest_dropped: set.rank.largest_dropped,
            standard_parameters: 10 * chain.dof(),
            minimal: set
                .constants
                .iter()
                .zip(&values)
                .map(|(constant, &value)| MinimalRow {
                    label: constant.label(),
                    value,
                    unit: constant.unit(),
                })
                .collect(),
            dropped: set
                .dropped
                .iter()
                .map(|d| DroppedRow {
                    label: d.constant.label(),
                    regrouped_into: d
                        .regrouped_into
                        .iter()
                        .map(|&(k, factor)| (labels[k].clone(), factor))
                        .collect(),
                })
                .collect(),
            sufficiency_error: set.sufficiency_error,
            confirmed: set.is_confirmed(),
            snap_error: chain.snap_error,
            ignored_elements: chain
                .ignored
                .iter()
                .map(|e| format!("<{}>, line {}", e.tag, e.line))
                .collect(),
            warnings,
        }
    }

    /// Warnings.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Human-readable text: chain table, structure, minimal set, rank.
    pub fn text(&self) -> String {
        let degrees = |angle: f64| significant(angle.to_degrees(), 6, 1e-12);
        let metres = |length: f64| significant(length, 6, 1e-12);
        let vector = |v: &[f64; 3]| {
            v.iter().map(|x| significant(*x, 6, 1e-12)).collect::<Vec<_>>().join(", ")
        };
        let mut text = format!(
            "{}: {} joints {}, {} to {}, gravity ({}) m/s2\n",
            self.robot,
            self.n,
            self.types,
            self.base_link,
            self.tip_link,
            vector(&self.gravity)
        );
        if !self.locked.is_empty() {
            let held: Vec<String> = self
                .locked
                .iter()
                .map(|(joint, at)| format!("{joint} = {}", significant(*at, 6, 0.0)))
                .collect();
            text += &format!("locked: {}\n", held.join(", "));
        }
        let rows: Vec<Vec<String>> = self
            .dh
            .iter()
            .zip(&self.joint_names)
            .zip(&self.links)
            .map(|((frame, name), link)| {
                let (q_angle, q_length) = match frame.kind {
                    'R' => (variable(&degrees(frame.theta)), metres(frame.d)),
                    _ => (degrees(frame.theta), variable(&metres(frame.d))),
                };
                vec![
                    frame.joint.to_string(),
                    name.clone(),
                    frame.kind.to_string(),
                    metres(frame.b),
                    q_length,
                    degrees(frame.beta),
                    q_angle,
                    significant(link.mass, 6, 0.0),
                ]
            })
            .collect();
        text += "\nDriving-axis frames\n";
        text += &aligned(
            &["i", "joint", "type", "b [m]", "d [m]", "beta [deg]", "theta [deg]", "m [kg]"],
            &rows,
            3,
        );
        text += &format!("\n{}\n", self.structure());
        text += &format!(
            "\nMinimal set: {} constants for {} standard parameters\n",
            self.minimal.len(),
            self.standard_parameters
        );
        text += &self.constants_by_joint();
        for dropped in &self.dropped {
            let into: Vec<String> = dropped
                .regrouped_into
                .iter()
                .map(|(label, factor)| format!("{label} (x {})", significant(*factor, 6, 1e-12)))
                .collect();
            text += &if into.is_empty() {
                format!("{} has no influence without gravity\n", dropped.label)
            } else {
                format!("{} is regrouped into {}\n", dropped.label, into.join(", "))
            };
        }
        text += &format!(
            "\nRank of the regressor at random states: {} ({}); singular values kept above {:.0e}, \
             dropped below {:.0e}\n",
            self.rank_numeric,
            if self.rank_numeric == self.minimal.len() { "agrees" } else { "DIFFERS" },
            power_below(self.rank_smallest_kept),
            // round-off differs between machines: only its order is printed
            (10.0 * power_below(self.rank_largest_dropped)).max(1e-12)
        );
        text
    }

    fn structure(&self) -> String {
        let joint = |name: &str, index: Option<usize>, meaning: &str| match index {
            Some(j) => format!("{name} = {j}"),
            None => format!("{name} does not exist ({meaning})"),
        };
        let mut parts = vec![
            joint("r", self.r, "no joint turns"),
            joint("s", self.s, "all turning axes are parallel"),
        ];
        parts.extend(self.delta.iter().map(|(j, flag)| format!("delta_{j} = {flag}")));
        parts.extend(self.sigma.iter().map(|(i, flag)| format!("sigma_{i} = {flag}")));
        parts.join(", ")
    }

    /// One line a joint and unit, so that the structure of the set shows.
    fn constants_by_joint(&self) -> String {
        let rows: Vec<Vec<String>> = self
            .minimal
            .iter()
            .map(|row| {
                let scale = self
                    .minimal
                    .iter()
                    .filter(|other| other.unit == row.unit)
                    .fold(0.0_f64, |largest, other| largest.max(other.value.abs()));
                let joint: String =
                    row.label[1..].chars().take_while(char::is_ascii_digit).collect();
                let name = joint
                    .parse::<usize>()
                    .ok()
                    .and_then(|j| self.joint_names.get(j - 1))
                    .cloned()
                    .unwrap_or_default();
                vec![
                    row.label.clone(),
                    name,
                    significant(row.value, 6, 1e-12 * scale),
                    row.unit.to_owned(),
                ]
            })
            .collect();
        let mut sorted = rows;
        // by joint, and within a joint in the order of the theorem
        sorted.sort_by_key(|row| {
            self.joint_names.iter().position(|name| *name == row[1]).unwrap_or(usize::MAX)
        });
        aligned(&["constant", "joint", "value", "unit"], &sorted, 2)
    }
}

/// `q` plus a constant.
fn variable(constant: &str) -> String {
    match constant.strip_prefix('-') {
        _ if constant == "0" => "q".to_owned(),
        Some(positive) => format!("q - {positive}"),
        None => format!("q + {constant}"),
    }
}

/// The power of ten at or below a positive number.
fn power_below(x: f64) -> f64 {
    if x > 0.0 { 10f64.powf(x.log10().floor()) } else { 0.0 }
}
