//! Play in the transmission: the encoder is on the motor side.

use crate::catalogue::{Against, Catalogue, Example};
use crate::draw::{Draw, DrawContext, DrawnEffect};
use crate::effect::Effect;
use crate::law::{Law, LawRole, LinkSide, LookAlike, Onset, Parameter, Scan, Scope};
use crate::mechanism::Mechanism;
use crate::transmission::{Transmission, is_transmission_fit};

/// `as elasticity, with no effort while `|θ - q| < gap / 2`.
pub struct Backlash;

impl Backlash {
    /// Circular frequency at which a fitted link bounces on the flanks of its gear, which are stiffer than recordings
    /// resolve \[rad/s\].
    pub const FLANK_RATE: f64 = 350.0;
    /// Share of critical damping of the flanks: lubricated, they hardly rebound.
    pub const FLANK_DAMPING: f64 = 0.8;
}

const LAW: Law = Law {
    slug: "backlash",
    title: "backlash",
    formula: "as elasticity, with tJ = 0 while abs(th - q) < gap/2 and a stiff contact outside",
    scope: Scope::ThroughJoint,
    roles: &[LawRole::Inertia],
    parameters: &[
        Parameter::non_negative("gap", "rad", "m").main(),
        Parameter::non_negative("contact_stiffness", "N m/rad", "N/m"),
        Parameter::non_negative("contact_damping", "N m s/rad", "N s/m"),
        Parameter::non_negative("motor_inertia", "kg m2", "kg"),
    ],
    contains: &["rotor_inertia"],
    scan: Scan::Simulated(LinkSide::Play),
    look_alikes: &[
        LookAlike {
            slug: "presliding_hysteresis",
            separated_by: "Record with and without gravity load on the joint: hysteresis stays at the reversals, backlash moves to where the transmitted effort changes sign.",
        },
        LookAlike {
            slug: "joint_elasticity",
            separated_by: "Record with and without gravity load on the joint: backlash acts only where the transmitted effort changes sign.",
        },
    ],
    catalogue: Some(&CATALOGUE),
    ..Law::BLANK
};

const CATALOGUE: Catalogue = Catalogue {
    about: "Play between the teeth: while the load changes its direction the motor moves alone, then the flank is hit.",
    sizes: &[
        "STS3215 hobby servo: about 1 degree (SO-ARM100, issue 134)",
        "Go1 leg: 0.04 rad either way in a user's model (MuJoCo, issue 995)",
        "Precision gears: about one minute of arc (order of magnitude, no measurement at hand)",
    ],
    signature: "Jumps where the effort that is carried changes its sign, not where the speed does. A joint that gravity presses against one flank shows none.",
    example: Example::new("wrist_1_joint", &[0.01, 2000.0, 4.0, 0.05], Against::Time),
};

impl Effect for Backlash {
    fn law(&self) -> &'static Law {
        &LAW
    }

    fn onset(&self) -> Onset {
        Onset::Often
    }

    fn mechanism(&self, parameters: &[f64]) -> Mechanism {
        let [gap, stiffness, damping] = [parameters[0], parameters[1], parameters[2]];
        let motor_inertia = parameters[3];
        Mechanism::Transmission(Transmission { gap, stiffness, damping, motor_inertia })
    }

    fn admits_fit(&self, shape: &[f64], coefficients: &[f64]) -> bool {
        is_transmission_fit(shape, coefficients)
    }

    /// With flanks of assumed stiffness and damping: the shape is the gap alone.
    fn transmission(&self, shape: &[f64], link_inertia: f64) -> Option<Transmission> {
        let &[gap] = shape else { return None };
        Some(Transmission {
            gap,
            stiffness: link_inertia * Self::FLANK_RATE * Self::FLANK_RATE,
            damping: 2.0 * Self::FLANK_DAMPING * link_inertia * Self::FLANK_RATE,
            motor_inertia: 0.0,
        })
    }

    fn parameters_of_transmission(&self, of: &Transmission) -> Vec<f64> {
        vec![of.gap, of.stiffness, of.damping, of.motor_inertia]
    }

    fn draw(&self, random: &mut dyn Draw, context: &DrawContext<'_>) -> Option<DrawnEffect> {
        let (joint, _) = context.draw_joint(random);
        let size = context.joints[joint];
        let motor = context.inertia(joint) * random.between(0.1, 0.4);
        let [start, most] = if size.kind.is_rotational() { [3e-3, 0.03] } else { [1e-3, 0.01] };
        let parameters = move |x: f64| {
            let stiffness = motor * 700.0_f64.powi(2);
            vec![x, stiffness, 0.8 * (stiffness * motor).sqrt(), motor]
        };
        Some(DrawnEffect::new(joint, start, parameters).at_most(most))
    }
}
