//! A diagnosis whose input checks are in inconclusive: what physics explains is no fault.

use crate::checks::effort_columns::Books;
use crate::checks::usable::DiagnoseError;
use crate::diagnosis::Diagnosis;
use crate::findings::finding::Finding;
use crate::findings::residual_map::JointAtlas;
use armident_ident::check::Topic;
use armident_recording::Recording;
/// Relative error of all links beyond which they may be anything.
const MOST_BELIEVED: f64 = 0.2;

/// A diagnosis, or why there is none.
pub type Heard = Result<Diagnosis, DiagnoseError>;

impl Books {
    /// Diagnoses recordings, and a reference of theirs, whose columns are in inconclusive: what physics explains is
    /// taken back, and joints whose columns are wrong are left out of a second run, for what is wrong with one
    /// column says nothing against the other joints. `run` is given the recordings and the reference; nothing
    /// comes back where the columns leave nothing to say of physics.
    pub fn hear(
        &mut self,
        joints: usize,
        recordings: &[Recording],
        reference: &[Recording],
        mut run: impl FnMut(&[Recording], &[Recording]) -> Heard,
    ) -> Option<Heard> {
        let heard = run(recordings, reference);
        if let Ok(diagnosis) = &heard {
            self.take_back(diagnosis);
        }
        if self.faults.is_empty() {
            return Some(heard);
        }
        let kept = |recordings: &[Recording]| -> Option<Vec<Recording>> {
            recordings.iter().map(|r| self.without_faulty(r, joints)).collect()
        };
        let heard = run(&kept(recordings)?, &kept(reference)?);
        heard.is_ok().then_some(heard)
    }

    /// Takes back what physics explains: where the diagnosed model leaves over little more than noise, the
    /// columns are what they are called. Only links turned inside out and gains could turn a column of
    /// another joint, sign or unit into that: where these are found, the fault stands. So do faults of what was
    /// recorded at all: a column that is 0 is soon explained.
    fn take_back(&mut self, diagnosis: &Diagnosis) {
        let turned = |f: &Finding| f.link.is_some() || f.effect == "torque_scale";
        if diagnosis.findings.iter().any(turned) || diagnosis.inertial_error > MOST_BELIEVED {
            return;
        }
        let explained = |joint: Option<&String>| {
            let mut of = diagnosis.atlas.iter().filter(|a| joint.is_none_or(|j| a.joint == *j));
            of.all(JointAtlas::explained)
        };
        self.faults
            .retain(|fault| fault.topic == Topic::Quality || !explained(fault.joint.as_ref()));
    }
}
