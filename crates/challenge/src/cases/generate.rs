//! Cases with hidden effects, made by the simulator.

use armident_effects::Library;

use crate::arms::robot::Robot;
use crate::cases::draw_effects::draw_effects;
use crate::cases::request::{CaseRequest, hidden_by_slug};
use crate::cases::scene::Scene;
use crate::cases::simulate::simulate;
use crate::cases::truth_of::{effective_noise, truth_of};
use crate::contract::case::Case;
use crate::error::ChallengeError;
use crate::hidden::hidden_effect::Hidden;
use crate::random::RandomStream;

/// Simulations before that.
const MOST_SIMULATIONS: usize = 6;
/// What stick phases add to the noise of a field case, until a simulation shows it.
const UNSEEN_STICK_PHASES: f64 = 1.3;

/// Makes a case.
///
/// # Errors
/// A robot that cannot be read or simulated, an effect that the generator does not have or that this
/// arm does not show.
pub fn generate(request: &CaseRequest) -> Result<Case, ChallengeError> {
    generate_in(Library::standard(), request)
}

/// Makes a case with effects of this library, which may have laws of its own.
///
/// # Errors
/// As [`generate`].
pub fn generate_in(library: &Library, request: &CaseRequest) -> Result<Case, ChallengeError> {
    let robot = Robot::parse(&request.robot_urdf)?;
    let hidden: Vec<Hidden> = request
        .effects
        .iter()
        .map(|slug| hidden_by_slug(slug, request.kind, library))
        .collect::<Result<_, _>>()?;
    let mut random = RandomStream::new(request.seed);
    let scene = Scene::draw(library, &robot, request, &mut random);
    let mut last = None;
    // stick phases are not known before the first simulation
    let margin = if scene.kind.is_field() { UNSEEN_STICK_PHASES } else { 1.0 };
    let mut noise: Vec<f64> = scene.sensing.sigma.iter().map(|sigma| margin * sigma).collect();
    for _ in 0..MOST_SIMULATIONS {
        let mut random = random.branch();
        let drafts = draw_effects(&scene, request, &hidden, &noise, &mut random)?;
        let Some(drafts) = drafts else { continue };
        let simulated = simulate(&scene, &drafts, &mut random);
        let made = match simulated {
            Ok(made) => made,
            // a motion that runs away is another draw
            Err(ChallengeError::Simulation(error)) => {
                last = Some(ChallengeError::Simulation(error));
                continue;
            }
            Err(other) => return Err(other),
        };
        noise = effective_noise(&scene, &drafts, &made);
        if let Some(truth) = truth_of(&scene, &drafts, &made, &noise, request)? {
            let [train_1, train_2, holdout, exam] = made.recorded;
            let robot_urdf = robot.urdf.clone();
            let before = made.before;
            return Ok(Case { robot_urdf, before, train_1, train_2, holdout, exam, truth });
        }
    }
    Err(last.unwrap_or_else(|| ChallengeError::Invisible {
        effects: request.effects.join(", "),
        robot: request.robot.clone(),
    }))
}
