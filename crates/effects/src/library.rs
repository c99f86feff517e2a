//! The laws that are known, by their slugs.

use std::borrow::Cow;
use std::fmt;

use crate::effect::Effect;
use crate::law::{Baseline, Law, Naming, Scope};
use crate::laws::STANDARD;
use crate::on_joint::{EffectOnJoint, UnknownEffect};

/// A set of laws, in the order in which tables list them.
///
/// [`standard`](Self::standard) has all of this crate; a law from elsewhere joins with [`with`](Self::with), and what is
/// given the new library knows it.
#[derive(Clone)]
pub struct Library {
    laws: Cow<'static, [&'static dyn Effect]>,
}

impl fmt::Debug for Library {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(self.laws.iter().map(|law| law.slug())).finish()
    }
}

impl Library {
    /// The laws of this crate.
    pub fn standard() -> &'static Self {
        static LIBRARY: Library = Library { laws: Cow::Borrowed(STANDARD) };
        &LIBRARY
    }

    /// The same library with one law more, in the place of one of the same slug if there is one.
    #[must_use]
    pub fn with(&self, law: &'static dyn Effect) -> Self {
        let mut laws = self.laws.to_vec();
        match laws.iter_mut().find(|other| other.slug() == law.slug()) {
            Some(other) => *other = law,
            None => laws.push(law),
        }
        Self { laws: Cow::Owned(laws) }
    }

    /// All laws.
    pub fn all(&self) -> impl Iterator<Item = &'static dyn Effect> + '_ {
        self.laws.iter().copied()
    }

    /// Laws that a diagnosis may report.
    pub fn named(&self) -> impl Iterator<Item = &'static dyn Effect> + '_ {
        self.all().filter(|effect| effect.law().naming == Naming::Named)
    }

    /// The law with a slug.
    pub fn get(&self, slug: &str) -> Option<&'static dyn Effect> {
        self.all().find(|effect| effect.slug() == slug)
    }

    /// Metadata of the law with a slug.
    pub fn law(&self, slug: &str) -> Option<&'static Law> {
        self.get(slug).map(|effect| effect.law())
    }

    /// The baseline friction that a law of one joint contains: it takes its place.
    pub fn contained_friction(&self, law: &Law) -> Option<Baseline> {
        if law.scope != Scope::Joint {
            return None;
        }
        let contained = law.contains.iter().filter_map(|slug| self.law(slug)?.baseline);
        contained.into_iter().find(|term| term.is_friction())
    }

    /// The law of a placed effect.
    ///
    /// # Errors
    /// [`UnknownEffect`] when the library has no such slug or the number of parameters is not that
    /// of the law.
    pub fn resolve(&self, placed: &EffectOnJoint) -> Result<&'static dyn Effect, UnknownEffect> {
        let known = || self.all().map(Effect::slug).collect::<Vec<_>>().join(", ");
        let effect = self
            .get(&placed.effect)
            .ok_or_else(|| UnknownEffect::Slug { found: placed.effect.clone(), known: known() })?;
        let expected = effect.law().parameters;
        if placed.parameters.len() != expected.len() {
            return Err(UnknownEffect::Parameters {
                effect: effect.slug(),
                expected: expected.iter().map(|p| p.name).collect::<Vec<_>>().join(", "),
                found: placed.parameters.len(),
            });
        }
        Ok(effect)
    }

    /// Whether each parameter of a placed effect has a sign that it may have.
    pub fn has_admissible_signs(&self, placed: &EffectOnJoint) -> bool {
        let parameters = self.law(&placed.effect).map_or(&[][..], |law| law.parameters);
        parameters.iter().zip(&placed.parameters).all(|(p, value)| p.admissible.allows(*value))
    }
}

/// The effect of the [standard](Library::standard) library with a slug.
pub fn effect(slug: &str) -> Option<&'static dyn Effect> {
    Library::standard().get(slug)
}

impl EffectOnJoint {
    /// Whether each parameter has a sign that it may have, by the standard library.
    pub fn has_admissible_signs(&self) -> bool {
        Library::standard().has_admissible_signs(self)
    }

    /// Its law in the standard library.
    ///
    /// # Errors
    /// As [`Library::resolve`].
    pub fn resolve(&self) -> Result<&'static dyn Effect, UnknownEffect> {
        Library::standard().resolve(self)
    }
}
