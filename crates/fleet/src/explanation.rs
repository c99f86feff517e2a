//! What can change on a robot, as directions of its parameters.
//!
//! Friction of a joint is one parameter; a body that is gained or lost on a link changes the constants of that link's and of
//! all earlier composite bodies, linearly in its ten parameters.

use armident_ident::{BatchProblem, LAWS, StateColumns, Term};
use armident_kinematics::InertialParameters;

/// Laws of a joint that change as it ages: viscous friction, Coulomb friction and offset. The rotor, fourth in the list, does
/// not.
const AGEING_LAWS: usize = 3;
/// The ten parameters of a body and their units.
const OF_A_BODY: [(&str, &str); InertialParameters::COUNT] = [
    ("mass", "kg"),
    ("mcx", "kg m"),
    ("mcy", "kg m"),
    ("mcz", "kg m"),
    ("Ixx", "kg m2"),
    ("Ixy", "kg m2"),
    ("Ixz", "kg m2"),
    ("Iyy", "kg m2"),
    ("Iyz", "kg m2"),
    ("Izz", "kg m2"),
];

/// What may have changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChangedPart {
    /// A law of a joint.
    Law {
        /// Joint, from 0.
        joint: usize,
        /// Index into [`LAWS`].
        law: usize,
    },
    /// A body on the link that a joint moves.
    Body {
        /// Joint, from 0.
        joint: usize,
    },
}

/// A part with the directions in which it moves the parameters.
#[derive(Debug, Clone)]
pub struct Explanation {
    /// What changed.
    pub part: ChangedPart,
    /// Name and unit of each of its numbers.
    pub numbers: Vec<(&'static str, &'static str)>,
    /// What a unit of each number adds to the parameters.
    pub directions: Vec<Vec<f64>>,
}

impl ChangedPart {
    /// The joint, or that which moves the link.
    pub fn joint(self) -> usize {
        match self {
            Self::Law { joint, .. } | Self::Body { joint } => joint,
        }
    }

    /// `viscous friction`, `body`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Law { law, .. } => LAWS[law].law().title,
            Self::Body { .. } => "body",
        }
    }
}

impl Explanation {
    /// All explanations of changes of an arm.
    pub(crate) fn all(columns: &StateColumns<'_>) -> Vec<Self> {
        let problem = columns.problem();
        let mut all: Vec<Self> = Vec::new();
        for (k, term) in problem.terms.iter().enumerate() {
            let Term::Effect { joint, effect: law, .. } = *term else { continue };
            let (true, Some(parameter)) = (law < AGEING_LAWS, term.parameter()) else { continue };
            let mut direction = vec![0.0; problem.terms.len()];
            direction[k] = 1.0;
            let part = ChangedPart::Law { joint, law };
            let number = (parameter.name, parameter.unit(problem.arm().joints[joint].kind));
            match all.iter_mut().find(|known| known.part == part) {
                Some(known) => {
                    known.numbers.push(number);
                    known.directions.push(direction);
                }
                None => all.push(Self { part, numbers: vec![number], directions: vec![direction] }),
            }
        }
        for joint in 0..problem.arm().dof() {
            all.push(Self {
                part: ChangedPart::Body { joint },
                numbers: OF_A_BODY.to_vec(),
                directions: (0..InertialParameters::COUNT)
                    .map(|number| of_body(problem, joint, number))
                    .collect(),
            });
        }
        all
    }
}

/// What one of the ten parameters of a body on a link adds to the parameters.
fn of_body(problem: &BatchProblem, joint: usize, number: usize) -> Vec<f64> {
    let mut links = vec![InertialParameters::zero(); problem.arm().dof()];
    let mut unit = [0.0; InertialParameters::COUNT];
    unit[number] = 1.0;
    links[joint] = InertialParameters::from_array(&unit);
    let values = problem.set().values(&problem.arm().with_links(links).constants());
    let value = |term: &Term| match *term {
        Term::Constant(k) => values[k],
        Term::Effect { .. } | Term::Shared { .. } | Term::Load { .. } => 0.0,
    };
    problem.terms.iter().map(value).collect()
}
