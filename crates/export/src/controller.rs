//! C99 source for a controller: inverse dynamics, gravity, friction, inertia matrix and a momentum observer.
//!
//! The algorithms are in `c/controller.c`, the numbers of the arm and its effects are written into it. References: J. Y. S.
//! Luh, M. W. Walker, R. P. Paul, On-line computational scheme for mechanical manipulators, ASME Journal of Dynamic Systems,
//! Measurement, and Control 102, 1980; M. W. Walker, D. E. Orin, Efficient dynamic computer simulation of robotic
//! mechanisms, the same journal 104, 1982; A. De Luca, R. Mattone, Actuator failure detection and isolation using generalized
//! momenta, ICRA 2003.

use std::fmt::{Display, Write};

use armident_dynamics::{JointGeometry, RigidArm};
use armident_effects::{
    ControllerVariables, Effect, EffectOnJoint, EncoderOffset, Mechanism, ReversalModel, tilted,
};
use armident_kinematics::JointKind;
use armident_model::ArmModel;
use nalgebra::Vector3;

use crate::thresholds::{AlarmThresholds, JointThresholds};
use crate::{Companion, Exported, Held, Lost};

/// The model as C source, whose header is the companion.
///
/// Identifiers begin with the name of the robot. Efforts are in recorded terms, as those of
/// [`predict`](ArmModel::predict): with the gains of the channels, in recorded positions.
pub fn controller(model: &ArmModel) -> Exported {
    with_alarm(model, None)
}

/// The same with thresholds of the observer's residual.
pub fn controller_with_alarm(model: &ArmModel, thresholds: &AlarmThresholds) -> Exported {
    with_alarm(model, Some(thresholds))
}

/// The arm that the source has: with its tilt and its encoder zeros.
pub(crate) fn controlled_arm(model: &ArmModel) -> RigidArm {
    let chain = &model.chain;
    let mut arm = RigidArm::from_chain(chain);
    let tilt = Vector3::new(model.base_tilt_rad[0], model.base_tilt_rad[1], 0.0);
    arm.gravity_e0 = tilted(&chain.base_from_e0, &arm.gravity_e0, &tilt);
    arm
}

/// Inertia that effects add to each joint \[kg m² or kg\].
pub(crate) fn rotor_inertias(model: &ArmModel) -> Vec<f64> {
    let of = |name: &str| {
        let own = model.joint_effects().filter(|on| on.joint == name);
        own.filter_map(|on| Some(model.library.get(&on.effect)?.added_inertia(&on.parameters)))
            .sum()
    };
    model.chain.joint_names().into_iter().map(of).collect()
}

fn with_alarm(model: &ArmModel, thresholds: Option<&AlarmThresholds>) -> Exported {
    let mut source = Source::of(model);
    source.thresholds = thresholds.cloned();
    for on_joint in &model.effects {
        source.add(model, on_joint);
    }
    source.omit_what_has_no_place(model);
    let name = identifier(&model.chain.robot);
    let text = source.fill(include_str!("c/controller.c"), model, &name);
    let header = source.fill(include_str!("c/controller.h"), model, &name);
    let companion = Companion { file: format!("{name}.h"), text: header };
    Exported {
        text,
        companion: Some(companion),
        held: source.held,
        lost: source.lost,
        notes: source.notes,
    }
}

/// What dry friction of a joint remembers, by its travel \[rad or m\].
struct Memory {
    joint: usize,
    travel: f64,
}

/// Numbers and statements to be filled in.
struct Source {
    arm: RigidArm,
    rotor: Vec<f64>,
    reversals: Vec<ReversalModel>,
    memories: Vec<Memory>,
    /// statements that set directions from memories
    remembered: String,
    /// statements that add efforts
    friction: String,
    thresholds: Option<AlarmThresholds>,
    held: Vec<Held>,
    lost: Vec<Lost>,
    notes: Vec<String>,
}

impl Source {
    fn of(model: &ArmModel) -> Self {
        let chain = &model.chain;
        let mut arm = controlled_arm(model);
        let frames = armident_effects::ArmFrames::of_chain(chain);
        for (joint, offset) in model.encoder_offset.iter().enumerate() {
            EncoderOffset.change_arm(&[*offset], joint, &frames, &mut arm);
        }
        let reversals = model
            .reversals
            .clone()
            .unwrap_or_else(|| vec![ReversalModel::regularised(0.0); chain.dof()]);
        let mut source = Self {
            rotor: vec![0.0; chain.dof()],
            arm,
            reversals: reversals.clone(),
            memories: Vec::new(),
            remembered: String::new(),
            friction: String::new(),
            thresholds: None,
            held: Vec::new(),
            lost: Vec::new(),
            notes: Vec::new(),
        };
        for (joint, reversal) in reversals.iter().enumerate() {
            let travel = reversal.presliding_travel();
            if travel > 0.0 {
                let memory = source.remember(joint, travel);
                source.remembered +=
                    &format!("    direction[{joint}] = memory->deflection[{memory}];\n");
            }
        }
        source
    }

    /// The index of a memory.
    fn remember(&mut self, joint: usize, travel: f64) -> usize {
        self.memories.push(Memory { joint, travel });
        self.memories.len() - 1
    }

    fn add(&mut self, model: &ArmModel, on_joint: &EffectOnJoint) {
        if on_joint.parameters.iter().all(|p| *p == 0.0) {
            return;
        }
        let index = |name: &str| model.chain.joints.iter().position(|j| j.name == name);
        let law = model.library.get(&on_joint.effect);
        let other = on_joint.other_joint.as_deref().and_then(index);
        let written = match (law, index(&on_joint.joint)) {
            (Some(law), Some(joint)) => {
                self.write(model, law, (joint, other), &on_joint.parameters)
            }
            _ => None,
        };
        let Some(attribute) = written else {
            self.lost.push(Lost {
                effect: on_joint.effect.clone(),
                joint: on_joint.joint.clone(),
                parameters: on_joint.parameters.clone(),
                reason: "needs more than the state of its joint",
            });
            return;
        };
        self.held.push(Held {
            effect: on_joint.effect.clone(),
            joint: on_joint.joint.clone(),
            attribute,
            value: on_joint.parameters[0],
        });
    }

    /// The function that the effect was written into; none if it has no place.
    fn write(
        &mut self,
        model: &ArmModel,
        law: &dyn Effect,
        (joint, other): (usize, Option<usize>),
        parameters: &[f64],
    ) -> Option<&'static str> {
        let inertia = law.added_inertia(parameters);
        if inertia != 0.0 {
            self.rotor[joint] += inertia;
            return Some("rotor");
        }
        if let (Mechanism::Pair { ratio, viscous, coulomb }, Some(other)) =
            (law.mechanism(parameters), other)
        {
            let speed = format!("dq[{other}] + {ratio:?} * dq[{joint}]");
            self.friction += &format!(
                "  {{\n    const double speed = {speed};\n    \
                 const double f = {viscous:?} * speed + {coulomb:?} * arm_direction(speed, 0.0);\n    \
                 effort[{other}] += f;\n    effort[{joint}] += {ratio:?} * f;\n  }}\n"
            );
            return Some("friction");
        }
        let direction = if law.has_deflection() {
            let (shape, _) = law.shape_and_coefficients(parameters);
            let memory = self.remember(joint, *shape.first()?);
            format!("(memory ? memory->deflection[{memory}] : direction[{joint}])")
        } else {
            format!("direction[{joint}]")
        };
        // laws are of true positions
        let position = match model.encoder_offset[joint] {
            0.0 => format!("q[{joint}]"),
            offset => format!("(q[{joint}] - {offset:?})"),
        };
        let expression = law.c_expression(
            parameters,
            &ControllerVariables {
                kind: model.chain.joints[joint].kind,
                position: &position,
                velocity: &format!("dq[{joint}]"),
                direction: &direction,
                load: &format!("load[{joint}]"),
            },
        )?;
        self.friction +=
            &format!("  /* {} */\n  effort[{joint}] += {expression};\n", law.law().title);
        Some("friction")
    }

    /// What is in the model and neither a link nor an effect.
    fn omit_what_has_no_place(&mut self, model: &ArmModel) {
        let mut omit = |what: String| self.notes.push(format!("omitted: {what}"));
        for term in &model.transmissions {
            omit(format!("the compliance of the drive of {}", term.joint));
        }
        for term in &model.smooth_terms {
            omit(format!("unmodelled structure on {}", term.joint));
        }
        if model.effort_delay_s != 0.0 {
            omit(format!("the lag of the efforts, {:.4} s", model.effort_delay_s));
        }
        if model.effort_low_pass_s != 0.0 {
            omit(format!("the low-pass of the efforts, {:.4} s", model.effort_low_pass_s));
        }
        if model.effort_clock_drift != 0.0 {
            omit(format!(
                "the drift of the clock of the efforts, {:.0} ppm",
                1e6 * model.effort_clock_drift
            ));
        }
        for (joint, shown) in model.chain.joints.iter().zip(model.shown.iter().flatten()) {
            if let Some(shown) = shown {
                let percent = 100.0 * shown.share;
                omit(format!(
                    "the {percent:.1} % of its effort that the column of {} shows",
                    joint.name
                ));
            }
        }
    }

    fn fill(&self, template: &str, model: &ArmModel, name: &str) -> String {
        let (chain, frames) = (&model.chain, &self.arm.joints);
        let frame = |of: &dyn Fn(&JointGeometry) -> f64| list(frames.iter().map(of).map(number));
        let kind = |joint: &JointGeometry| u8::from(joint.kind.is_rotational());
        let mut joints = String::new();
        for (i, joint) in chain.joints.iter().enumerate() {
            let unit = if joint.kind == JointKind::Rotational { "rad" } else { "m" };
            let _ = writeln!(joints, " *   {i} {} [{unit}]", comment(&joint.name));
        }
        let notes = self.lost.iter().map(|lost| format!("{} of {}", lost.effect, lost.joint));
        let notes: String = notes
            .map(|lost| format!("omitted: {lost}"))
            .chain(self.notes.iter().cloned())
            .map(|note| format!(" * {}\n", comment(&note)))
            .collect();
        let links = self.arm.links.iter().map(|link| {
            let numbers = link.to_array().into_iter().map(number);
            format!("  {{ {} }},\n", list(numbers))
        });
        let below = self.reversals.iter().map(|reversal| number(reversal.regularised_below()));
        let code = [
            ("deflected", self.deflected()),
            ("remember", self.remember_statements()),
            ("friction", self.friction.clone()),
            ("alarm", self.alarm(include_str!("c/alarm.c"))),
            ("alarm_header", self.alarm(include_str!("c/alarm.h"))),
        ];
        // identifiers before names: these may hold the same letters
        let text = filled(template.to_owned(), code)
            .replace("arm_", &format!("{name}_"))
            .replace("ARM_", &format!("{}_", name.to_uppercase()));
        let values = [
            ("title", format!("{}, {} joints", comment(&chain.robot), chain.dof())),
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("header", format!("{name}.h")),
            ("joints", joints),
            ("notes", notes),
            ("dof", chain.dof().to_string()),
            ("memories", self.memories.len().to_string()),
            ("b", frame(&|j| j.frame.b_m)),
            ("d", frame(&|j| j.frame.d_m)),
            ("theta", frame(&|j| j.frame.theta_rad)),
            ("cos_beta", frame(&|j| j.frame.beta_rad.cos())),
            ("sin_beta", frame(&|j| j.frame.beta_rad.sin())),
            ("is_revolute", list(frames.iter().map(kind))),
            ("links", links.collect()),
            ("rotor", list(self.rotor.iter().copied().map(number))),
            ("gain", list(model.channel_gain.iter().copied().map(number))),
            ("linear_below", list(below)),
            ("follows_load", u8::from(self.friction.contains("load[")).to_string()),
            ("gravity", list(self.arm.gravity_e0.iter().copied().map(number))),
        ];
        filled(text, values)
    }

    /// What thresholds need; nothing without them.
    fn alarm(&self, template: &str) -> String {
        let Some(thresholds) = &self.thresholds else { return String::new() };
        let joints = &thresholds.joints;
        let columns = joints.iter().map(|joint| joint.speed.len()).max().unwrap_or(1);
        let rows = |of: fn(&JointThresholds) -> &Vec<f64>| -> String {
            let row = |joint: &JointThresholds| {
                let values = of(joint);
                let last = values.last().copied().unwrap_or_default();
                let padded = values.iter().copied().chain(std::iter::repeat(last)).take(columns);
                format!("  {{ {} }},\n", list(padded.map(number)))
            };
            joints.iter().map(row).collect()
        };
        let values = [
            ("speeds", list(joints.iter().map(|joint| joint.speed.len()))),
            ("columns", columns.to_string()),
            ("speed", rows(|joint| &joint.speed)),
            ("threshold", rows(|joint| &joint.threshold)),
            ("gain", number(thresholds.gain)),
            ("rate_hz", format!("{:.0}", thresholds.rate_hz)),
            ("per_hour", thresholds.false_alarms_per_hour.to_string()),
        ];
        filled(template.to_owned(), values)
    }

    /// The function that memories need.
    fn deflected(&self) -> String {
        if self.memories.is_empty() {
            return String::new();
        }
        "/* solution of dz/dx = 1 - z sign(dx) after a one-way travel (Dahl 1968) */\n\
         static double arm_deflected(double deflection, double travel) {\n  \
         const double side = travel > 0.0 ? 1.0 : -1.0;\n  \
         return travel == 0.0 ? deflection : side + (deflection - side) * exp(-fabs(travel));\n\
         }\n\n"
            .to_owned()
    }

    /// The statements that move all memories on to this position.
    fn remember_statements(&self) -> String {
        if self.memories.is_empty() {
            return String::new();
        }
        let mut statements = "  if (memory) {\n    \
             for (i = 0; i < ARM_JOINTS; i++) {\n      \
             if (!memory->is_set) memory->position[i] = q[i];\n    }\n    \
             memory->is_set = 1;\n"
            .to_owned();
        for (k, Memory { joint, travel }) in self.memories.iter().enumerate() {
            let _ = writeln!(
                statements,
                "    memory->deflection[{k}] =\n        arm_deflected(memory->deflection[{k}], \
                 (q[{joint}] - memory->position[{joint}]) / {travel:?});"
            );
        }
        statements += &self.remembered;
        statements + "    for (i = 0; i < ARM_JOINTS; i++) memory->position[i] = q[i];\n  }\n"
    }
}

/// A template with the values of its keys.
fn filled<const N: usize>(template: String, values: [(&str, String); N]) -> String {
    let fill = |text: String, (key, value): (&str, String)| {
        text.replace(&format!("{{{{{key}}}}}"), &value)
    };
    values.into_iter().fold(template, fill)
}

/// A number with all its digits.
fn number(x: f64) -> String {
    format!("{x:?}")
}

fn list(numbers: impl Iterator<Item = impl Display>) -> String {
    numbers.map(|x| x.to_string()).collect::<Vec<_>>().join(", ")
}

/// Text that does not end a comment.
fn comment(text: &str) -> String {
    text.replace("*/", "* /")
}

/// The name of a robot as the beginning of C identifiers.
fn identifier(robot: &str) -> String {
    let valid = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    let name: String = robot.chars().map(valid).collect();
    match name.chars().next() {
        Some(first) if first.is_ascii_digit() => format!("arm_{name}"),
        Some(_) => name,
        None => "arm".to_owned(),
    }
}
