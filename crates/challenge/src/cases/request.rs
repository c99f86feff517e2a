//! What is asked of a case.

use armident_effects::{Draw, Effect, Library};

use crate::contract::kind::CaseKind;
use crate::error::ChallengeError;
use crate::hidden::hidden_effect::Hidden;
use crate::random::RandomStream;

/// A case to be made. The same request gives the same case.
#[derive(Debug, Clone)]
pub struct CaseRequest {
    /// Name of the case.
    pub name: String,
    /// Name of the robot.
    pub robot: String,
    /// Text of its URDF.
    pub robot_urdf: String,
    /// Random seed.
    pub seed: u64,
    /// Clean, field, hard or change.
    pub kind: CaseKind,
    /// Slugs of the effects to hide, or `unlisted`; none for a null case.
    pub effects: Vec<String>,
    /// Relative standard deviation of the inertial errors of every link; random if it is not given.
    pub background: Option<f64>,
    /// Whether laws that have a variant are replaced by it.
    pub perturbed: bool,
    /// Naming margin of every effect; random if it is not given.
    pub margin: Option<f64>,
}

/// Slugs that a case of this kind can hide: those of the standard library and `unlisted`.
pub fn hideable(kind: CaseKind) -> Vec<&'static str> {
    all_hideable(kind, Library::standard()).into_iter().map(Hidden::slug).collect()
}

fn all_hideable(kind: CaseKind, library: &Library) -> Vec<Hidden> {
    let can_be_hidden = |effect: &&dyn Effect| match kind {
        CaseKind::Clean => true,
        // every joint has it anyway
        CaseKind::Field | CaseKind::Hard => !effect.law().is_baseline_friction(),
        // a law in the place of another one is a change of two
        CaseKind::Change => library.contained_friction(effect.law()).is_none(),
    };
    // no case records temperatures
    let is_shown = |effect: &&dyn Effect| !effect.law().follows_temperature;
    let listed = library.named().filter(is_shown).filter(can_be_hidden).map(Hidden::Listed);
    listed.chain([Hidden::Unlisted]).collect()
}

/// Most effects of a hard case.
const MOST_EFFECTS: usize = 4;

/// Effects of a case by its seed: mostly one, sometimes two, of hard cases up to four, and in all but clean cases sometimes
/// none; slugs take turns.
pub fn case_effects(kind: CaseKind, seed: u64) -> Vec<String> {
    let mut random = RandomStream::new(seed ^ 0x5eed);
    let slugs = hideable(kind);
    if kind.is_field() && random.chance(0.1) {
        return Vec::new();
    }
    let first = slugs[(seed % slugs.len() as u64) as usize];
    let mut chosen = vec![first.to_owned()];
    if kind == CaseKind::Hard {
        for _ in 0..random.index(MOST_EFFECTS) {
            let next = random.choose(&slugs).to_owned();
            if !chosen.contains(&next) {
                chosen.push(next);
            }
        }
    } else if random.chance(0.2) {
        let second = random.choose(&slugs);
        if second != first {
            chosen.push(second.to_owned());
        }
    }
    chosen
}

/// What a slug hides in a case of this kind.
pub(crate) fn hidden_by_slug(
    slug: &str,
    kind: CaseKind,
    library: &Library,
) -> Result<Hidden, ChallengeError> {
    let known = all_hideable(kind, library).into_iter().find(|hidden| hidden.slug() == slug);
    known.ok_or_else(|| ChallengeError::UnknownEffect { effect: slug.to_owned() })
}
