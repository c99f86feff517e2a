//! An effect that a case hides.

use armident_effects::{
    Baseline, Draw, DrawContext, DrawnEffect, Effect, EffectOnJoint, Law, Library, Scope,
};
use armident_simulation::EffectWithParameters;

use crate::hidden::UNLISTED;
use crate::hidden::variants::{self, Unlisted};

/// What a case hides.
#[derive(Clone, Copy)]
pub(crate) enum Hidden {
    /// A law of the library.
    Listed(&'static dyn Effect),
    /// Some law that the library does not have.
    Unlisted,
}

impl Hidden {
    /// Name in requests and answers.
    pub(crate) fn slug(self) -> &'static str {
        match self {
            Self::Listed(effect) => effect.slug(),
            Self::Unlisted => UNLISTED,
        }
    }

    /// Whether a link of its own moves behind the motor.
    pub(crate) fn has_transmission(self) -> bool {
        matches!(self, Self::Listed(effect) if effect.law().link_side().is_some())
    }
}

/// An effect up to its size.
pub(crate) struct HiddenEffect {
    law: &'static Law,
    drawn: DrawnEffect,
    /// A law that acts instead of the library's.
    variant: Option<&'static dyn Effect>,
    /// Channels that an unlisted law depends on.
    pub(crate) variables: &'static [&'static str],
    /// Baseline friction that the law contains.
    pub(crate) replaces: Option<Baseline>,
}

impl HiddenEffect {
    /// Draws joint and constants; nothing if the law cannot act on what was drawn.
    pub(crate) fn draw(
        what: Hidden,
        perturbed: bool,
        library: &Library,
        context: &DrawContext<'_>,
        random: &mut dyn Draw,
    ) -> Option<Self> {
        match what {
            Hidden::Listed(effect) => {
                let law = effect.law();
                let variant = if perturbed { variants::of(law.slug) } else { None };
                let drawn = variant.unwrap_or(effect).draw(random, context)?;
                let replaces = library.contained_friction(law);
                Some(Self { law, drawn, variant, variables: &[], replaces })
            }
            Hidden::Unlisted => {
                let Unlisted { effect, drawn, variables } = variants::unlisted(random, context);
                let law = effect.law();
                Some(Self { law, drawn, variant: Some(effect), variables, replaces: None })
            }
        }
    }

    /// The law whose name is right.
    pub(crate) fn law(&self) -> &'static Law {
        self.law
    }

    /// Name of the law, or `unlisted`.
    pub(crate) fn slug(&self) -> &'static str {
        self.law.slug
    }

    /// Title and formula of the law that acts instead of the library's.
    pub(crate) fn variant(&self) -> Option<&'static Law> {
        self.variant.map(|effect| effect.law())
    }

    /// The joint, or the joint that moves its link.
    pub(crate) fn joint(&self) -> usize {
        self.drawn.joint
    }

    /// Its joint and, of two neighbours, the second one.
    pub(crate) fn joints(&self) -> impl Iterator<Item = usize> + use<> {
        [Some(self.drawn.joint), self.drawn.other_joint].into_iter().flatten()
    }

    /// Start and end of a contact \[s\].
    pub(crate) fn window_s(&self) -> Option<[f64; 2]> {
        self.drawn.window_s
    }

    /// Training recording of a contact, from 0.
    pub(crate) fn recording(&self) -> Option<usize> {
        self.drawn.recording
    }

    /// Size to start from, and the largest.
    pub(crate) fn sizes(&self) -> [f64; 2] {
        [self.drawn.start, self.drawn.most]
    }

    /// Whether it is an inertial error of a link.
    pub(crate) fn is_body(&self) -> bool {
        self.law.scope == Scope::Link
    }

    /// Whether a link of its own moves behind the motor.
    pub(crate) fn has_transmission(&self) -> bool {
        self.law.link_side().is_some()
    }

    /// Travel over which the effect builds up at a size \[rad or m\]; infinite where it needs none.
    pub(crate) fn travel(&self, size: f64) -> f64 {
        self.drawn.travel(size)
    }

    /// Static friction of its joint over that of baseline friction.
    pub(crate) fn breakaway(&self, size: f64) -> f64 {
        self.drawn.breakaway(size)
    }

    /// Parameters at a size.
    pub(crate) fn parameters(&self, size: f64) -> Vec<f64> {
        self.drawn.parameters(size)
    }

    /// The law of the library at a size, if no variant acts instead.
    pub(crate) fn of_library(&self, size: f64, names: &[String]) -> Option<EffectOnJoint> {
        if self.variant.is_some() {
            return None;
        }
        let everywhere = self.law.scope == Scope::Arm;
        let joint = if everywhere { String::new() } else { names[self.drawn.joint].clone() };
        Some(EffectOnJoint {
            other_joint: self.drawn.other_joint.map(|other| names[other].clone()),
            window_s: self.drawn.window_s,
            ..EffectOnJoint::new(self.law.slug, joint, self.parameters(size))
        })
    }

    /// The variant that acts instead of the library's law, at a size.
    pub(crate) fn of_variant(&self, size: f64) -> Option<EffectWithParameters> {
        let effect = self.variant?;
        Some(EffectWithParameters { effect, parameters: self.parameters(size) })
    }
}

/// A hidden effect with its size.
pub(crate) struct Sized {
    pub(crate) effect: HiddenEffect,
    pub(crate) size: f64,
    /// RMS of its torque on each joint \[N m or N\].
    pub(crate) torque: Vec<f64>,
}
