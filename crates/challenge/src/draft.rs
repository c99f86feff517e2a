//! Effects by chance: constants first, then one number that sets their size.

use std::f64::consts::TAU;

use armident_dynamics::{RigidArm, inertia_matrix};
use armident_effects::{Effect, EffectOnJoint};
use armident_simulation::EffectWithParameters;

use crate::own_laws::{Detent, QuadraticDahl, SmoothCoulomb, TriangularRipple, UnevenDrag};
use crate::random::Draw;
use crate::recorder::Exact;
use crate::robot::Robot;

/// Laws that have a variant of their own: smooth for sharp Coulomb friction, Dahl friction of second order
/// for `LuGre`, straight flanks for the sine of a ripple.
pub const PERTURBED: [&str; 3] = ["coulomb_friction", "presliding_hysteresis", "torque_ripple"];

/// What sizes are drawn from.
pub(crate) struct Context<'a> {
    pub(crate) robot: &'a Robot,
    pub(crate) arm: &'a RigidArm,
    /// The planned motions of both training recordings.
    pub(crate) plans: &'a [Exact],
    /// Noise \[N m or N\].
    pub(crate) sigma: &'a [f64],
    /// Effort range of each joint \[N m or N\].
    pub(crate) range: &'a [f64],
    /// Dry friction and viscous coefficient that a joint has or would have.
    pub(crate) level: &'a [f64],
    pub(crate) viscous: &'a [f64],
    /// Length of a training recording \[s\].
    pub(crate) duration_s: f64,
}

impl Context<'_> {
    fn spread(&self, pick: fn(&Exact) -> &Vec<Vec<f64>>, joint: usize) -> [f64; 2] {
        let all: Vec<f64> = self.plans.iter().flat_map(|plan| pick(plan)[joint].clone()).collect();
        let mean = all.iter().sum::<f64>() / all.len().max(1) as f64;
        let variance =
            all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / all.len().max(1) as f64;
        [mean, variance.sqrt()]
    }

    pub(crate) fn speed(&self, joint: usize) -> f64 {
        self.spread(|plan| &plan.velocity, joint)[1]
    }
}

/// Everyday friction that an effect contains.
pub(crate) fn replaces(slug: &str) -> Option<&'static str> {
    match slug {
        "stribeck_friction"
        | "load_dependent_friction"
        | "asymmetric_coulomb_friction"
        | "presliding_hysteresis" => Some("coulomb_friction"),
        "friction_drift" => Some("viscous_friction"),
        _ => None,
    }
}

/// An effect up to its size.
pub(crate) struct Draft {
    /// Slug of the library, or `unlisted`.
    pub(crate) slug: &'static str,
    pub(crate) joint: usize,
    pub(crate) other: Option<usize>,
    pub(crate) window_s: Option<[f64; 2]>,
    /// Training recording of a contact, from 0.
    pub(crate) recording: Option<usize>,
    /// A law that stands in for the library's.
    pub(crate) own: Option<&'static dyn Effect>,
    constants: Vec<f64>,
    /// Size to start with, and the largest.
    pub(crate) start: f64,
    pub(crate) most: f64,
}

impl Draft {
    /// Draws joint and constants; nothing if this joint cannot have the effect.
    pub(crate) fn draw(
        slug: &'static str,
        perturbed: bool,
        context: &Context<'_>,
        random: &mut Draw,
    ) -> Option<Self> {
        let robot = context.robot;
        let n = robot.dof();
        let joint = match slug {
            "payload" => n - 1,
            "joint_coupling" => random.index(n - 1),
            _ => random.index(n),
        };
        let rotational = robot.is_rotational(joint);
        let sigma = context.sigma[joint];
        let [mean, deviation] = context.spread(|plan| &plan.position, joint);
        let speed = context.speed(joint);
        let acceleration = context.spread(|plan| &plan.acceleration, joint)[1];
        let centre: Vec<f64> =
            (0..n).map(|j| context.spread(|plan| &plan.position, j)[0]).collect();
        let inertia = inertia_matrix(context.arm, &centre)[(joint, joint)];
        let level = context.level[joint].max(4.0 * sigma);
        let side = random.sign();
        let endless = f64::INFINITY;
        let mut draft = Self {
            slug,
            joint,
            other: None,
            window_s: None,
            recording: None,
            own: None,
            constants: Vec::new(),
            start: 4.0 * sigma,
            most: endless,
        };
        let mut set = |constants: &[f64], start: f64, most: f64| {
            draft.constants = constants.to_vec();
            (draft.start, draft.most) = (start, most);
        };
        match slug {
            "viscous_friction" => set(&[], 4.0 * sigma / speed, endless),
            "coulomb_friction" => set(&[0.12 * speed], 4.0 * sigma, endless),
            "quadratic_drag" => set(&[], 4.0 * sigma / speed.powi(2), endless),
            "asymmetric_coulomb_friction" => set(&[level, side], 0.3, 0.8),
            // break-away is up to 3.5 times sliding friction
            "stribeck_friction" => set(&[level, random.between(0.15, 0.45) * speed], 1.0, 2.5),
            "load_dependent_friction" => set(&[level], 0.1, 0.35),
            "presliding_hysteresis" => {
                let level = level * random.between(1.0, 4.0);
                set(&[level, deviation], 0.1, 0.4);
            }
            "rotor_inertia" => set(&[], 4.0 * sigma / acceleration, 3.0 * inertia),
            "joint_elasticity" => {
                let motor = inertia * random.between(0.08, 0.3);
                let both = motor * inertia / (motor + inertia);
                // the resonance stays above 6 Hz, and the gear is no rubber: several times what a harmonic drive
                // winds up under its rated load
                let twist = if rotational { 0.04 } else { 4e-3 };
                let of_resonance = 1.0 / (both * (TAU * 6.0).powi(2));
                let most = of_resonance.min(twist / context.range[joint]);
                set(&[motor, both], 0.25 * most, most);
            }
            "backlash" => {
                let motor = inertia * random.between(0.1, 0.4);
                if rotational { set(&[motor], 3e-3, 0.03) } else { set(&[motor], 1e-3, 0.01) }
            }
            "torque_ripple" => {
                let order = if rotational {
                    random.between(6.0, 60.0).round()
                } else {
                    random.between(8.0, 50.0)
                };
                let second = if random.chance(0.3) { random.between(0.2, 0.5) } else { 0.0 };
                let phases = [random.between(-3.0, 3.0), random.between(-3.0, 3.0)];
                set(&[order, phases[0], second, phases[1]], 4.0 * sigma, endless);
            }
            "joint_spring" => {
                let rest = mean + deviation * random.between(-1.0, 1.0);
                set(&[rest], 4.0 * sigma / deviation, endless);
            }
            "torque_offset" => set(&[side], 4.0 * sigma, endless),
            "torque_scale" => set(&[side], 0.15, 0.45),
            "time_delay" => set(&[side], 5e-3, 0.015),
            "encoder_offset" => set(&[side], 0.03, 0.12),
            "gravity_direction" => set(&[random.between(0.0, TAU)], 0.05, 0.2),
            "payload" => {
                let centre: [f64; 3] = std::array::from_fn(|_| random.between(-0.06, 0.06));
                set(&[centre[0], centre[1], centre[2] + 0.08], 0.3, 20.0);
            }
            "link_inertia_error" => {
                let link = context.arm.links[joint];
                let in_e = robot.chain.joints[joint].child_link_in_e;
                let own = link.expressed_in(&in_e.inverse()).com_m();
                let reach = 0.5 * own.norm() + 0.03;
                let at = own.map(|c| c + reach * random.between(-0.7, 0.7));
                let most = if side < 0.0 { 0.4 } else { 1.5 } * link.mass_kg;
                set(&[side, at.x, at.y, at.z], 0.2 * link.mass_kg, most);
            }
            "friction_drift" => {
                let warm = context.viscous[joint].max(2.0 * sigma / speed);
                let constant = random.between(0.12, 0.4) * context.duration_s;
                set(&[warm, constant], 1.0, 15.0);
            }
            "joint_coupling" => {
                let sigma = sigma.max(context.sigma[joint + 1]);
                let ratio = random.one_of(&[1.0, -1.0, 0.5, -0.5]);
                let viscous = random.between(0.3, 1.0) / context.speed(joint + 1);
                set(&[ratio, viscous], 4.0 * sigma, endless);
                draft.other = Some(joint + 1);
            }
            "external_contact" => {
                let direction: [f64; 3] = std::array::from_fn(|_| random.normal());
                let length = random.between(1.4, 3.0);
                let start = random.between(2.0, context.duration_s - length - 1.0);
                set(&direction, 5.0, endless);
                draft.window_s = Some([start, start + length]);
                draft.recording = Some(random.index(2));
            }
            "unlisted" => {
                if random.chance(0.5) {
                    let width = deviation * random.between(0.4, 0.8);
                    let order = random.between(4.0, 7.0) / width;
                    set(&[mean + 0.5 * deviation * side, width, order], 8.0 * sigma, endless);
                    draft.own = Some(&Detent);
                } else {
                    let order = random.between(2.0, 4.0) / deviation;
                    set(&[order, random.between(-3.0, 3.0)], 4.0 * sigma / speed, endless);
                    draft.own = Some(&UnevenDrag);
                }
            }
            _ => return None,
        }
        if perturbed {
            draft.own = match slug {
                "coulomb_friction" => Some(&SmoothCoulomb),
                "presliding_hysteresis" => Some(&QuadraticDahl),
                "torque_ripple" => Some(&TriangularRipple),
                _ => draft.own,
            };
        }
        Some(draft)
    }

    /// Whether a link of its own moves behind the motor.
    pub(crate) fn has_transmission(&self) -> bool {
        matches!(self.slug, "joint_elasticity" | "backlash")
    }

    /// Whether some joint laws of the library have a stand-in.
    pub(crate) fn can_be_perturbed(slug: &str) -> bool {
        PERTURBED.contains(&slug)
    }

    /// Travel over which the effect builds up at a size \[rad or m\]; infinite where it needs none.
    pub(crate) fn travel(&self, x: f64) -> f64 {
        if self.slug == "presliding_hysteresis" { x * self.constants[1] } else { f64::INFINITY }
    }

    /// What a joint with the effect takes at most while it sticks, over what it would with everyday friction.
    pub(crate) fn sticking(&self, x: f64) -> f64 {
        if self.slug == "stribeck_friction" { 1.0 + x } else { 1.0 }
    }

    /// Parameters of the library's law, or of an unlisted one, at a size.
    pub(crate) fn parameters(&self, x: f64) -> Vec<f64> {
        let c = &self.constants;
        match self.slug {
            "asymmetric_coulomb_friction" => vec![c[0] * (1.0 + c[1] * x), c[0] * (1.0 - c[1] * x)],
            "stribeck_friction" => vec![c[0] * (1.0 + x), c[0], c[1]],
            "load_dependent_friction" => vec![c[0], x],
            "presliding_hysteresis" => {
                let stiffness = c[0] / (x * c[1]);
                let damping = if self.own.is_some() { 0.0 } else { 1e-3 * stiffness };
                vec![c[0], stiffness, damping]
            }
            "joint_elasticity" => {
                let stiffness = 1.0 / x;
                vec![stiffness, 2.0 * 0.06 * (stiffness * c[1]).sqrt(), c[0]]
            }
            "backlash" => {
                let stiffness = c[0] * 700.0_f64.powi(2);
                vec![x, stiffness, 0.8 * (stiffness * c[0]).sqrt(), c[0]]
            }
            "torque_ripple" => vec![x, c[0], c[1], c[2] * x, c[3]],
            "joint_spring" => vec![x, c[0]],
            "torque_offset" | "time_delay" | "encoder_offset" => vec![c[0] * x],
            "torque_scale" => vec![1.0 + c[0] * x],
            "gravity_direction" => vec![x, x * c[0].cos(), x * c[0].sin()],
            "payload" => vec![x, c[0], c[1], c[2]],
            "link_inertia_error" => {
                let mass = c[0] * x;
                vec![mass, mass * c[1], mass * c[2], mass * c[3]]
            }
            "friction_drift" => vec![c[0] * (1.0 + x), c[0], c[1]],
            "joint_coupling" => vec![c[0], x * c[1], x],
            "external_contact" => {
                let size = (c[0] * c[0] + c[1] * c[1] + c[2] * c[2]).sqrt();
                vec![x, x * c[0] / size, x * c[1] / size, x * c[2] / size]
            }
            "unlisted" => [vec![x], c.clone()].concat(),
            _ => vec![x],
        }
    }

    /// The law of the library at a size, if no other stands in for it.
    pub(crate) fn of_library(&self, x: f64, names: &[String]) -> Option<EffectOnJoint> {
        if self.own.is_some() {
            return None;
        }
        let everywhere = matches!(
            self.slug,
            "gravity_direction" | "time_delay" | "external_contact" | "payload"
        );
        let joint = if everywhere { String::new() } else { names[self.joint].clone() };
        Some(EffectOnJoint {
            other_joint: self.other.map(|other| names[other].clone()),
            window_s: self.window_s,
            ..EffectOnJoint::new(self.slug, joint, self.parameters(x))
        })
    }

    /// The law that stands in for the library's at a size.
    pub(crate) fn of_its_own(&self, x: f64) -> Option<EffectWithParameters> {
        let effect = self.own?;
        let mut parameters = self.parameters(x);
        if self.slug == "coulomb_friction" {
            parameters.push(self.constants[0]);
        }
        Some(EffectWithParameters { effect, parameters })
    }

    /// Everyday friction that the effect contains.
    pub(crate) fn replaces(&self) -> Option<&'static str> {
        replaces(self.slug)
    }

    /// Parameters whose error is scored.
    pub(crate) fn main_parameters(&self) -> &'static [&'static str] {
        match self.slug {
            "viscous_friction" | "quadratic_drag" => &["coefficient"],
            "coulomb_friction" => &["level"],
            "asymmetric_coulomb_friction" => &["level_positive", "level_negative"],
            "stribeck_friction" => &["static_level"],
            "load_dependent_friction" => &["load_coefficient"],
            "presliding_hysteresis" => &["level", "stiffness"],
            "rotor_inertia" => &["inertia"],
            "joint_elasticity" | "joint_spring" => &["stiffness"],
            "backlash" => &["gap"],
            "torque_ripple" => &["amplitude", "order"],
            "payload" => &["mass"],
            "gravity_direction" => &["tilt"],
            "torque_offset" | "encoder_offset" => &["offset"],
            "torque_scale" => &["gain"],
            "time_delay" => &["delay"],
            "friction_drift" => &["cold_coefficient", "warm_coefficient"],
            "joint_coupling" => &["ratio"],
            "external_contact" => &["force"],
            _ => &[],
        }
    }

    /// Findings that may stand beside the right one.
    pub(crate) fn tolerated(&self) -> &'static [&'static str] {
        match self.slug {
            "stribeck_friction" => &["coulomb_friction", "viscous_friction"],
            "load_dependent_friction" | "presliding_hysteresis" => &["coulomb_friction"],
            "asymmetric_coulomb_friction" => &["coulomb_friction", "torque_offset"],
            "joint_elasticity" | "backlash" => &["rotor_inertia"],
            "joint_spring" => &["torque_offset"],
            "friction_drift" => &["viscous_friction"],
            "joint_coupling" => &["viscous_friction", "coulomb_friction", "rotor_inertia"],
            "payload" | "link_inertia_error" => &["link_inertia_error"],
            _ => &[],
        }
    }
}
