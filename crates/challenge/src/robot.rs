//! The believed robot of a case.

use std::collections::BTreeMap;

use armident_dynamics::RigidArm;
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};

use crate::error::ChallengeError;

/// Name of the tool frame by the rules of the challenge; that of the arms of this project is another.
const TOOL: (&str, &str) = ("\"flange\"", "\"tool0\"");

/// A URDF with what is needed of it.
pub(crate) struct Robot {
    pub(crate) urdf: String,
    pub(crate) chain: DrivingAxisChain,
    pub(crate) names: Vec<String>,
}

impl Robot {
    pub(crate) fn parse(urdf: &str) -> Result<Self, ChallengeError> {
        let urdf = urdf.replace(TOOL.0, TOOL.1);
        let fault = |reason: String| ChallengeError::Robot { reason };
        let description =
            parse_urdf(&urdf, "robot.urdf").map_err(|error| fault(error.to_string()))?;
        let chain = SerialChain::from_description(&description, &ChainSelection::default())
            .map_err(|error| fault(error.to_string()))?;
        let chain = DrivingAxisChain::from_chain(&chain);
        let names = chain.joint_names().into_iter().map(str::to_owned).collect();
        Ok(Self { urdf, chain, names })
    }

    pub(crate) fn dof(&self) -> usize {
        self.names.len()
    }

    pub(crate) fn arm(&self) -> RigidArm {
        RigidArm::from_chain(&self.chain)
    }

    pub(crate) fn is_rotational(&self, joint: usize) -> bool {
        self.chain.joints[joint].kind.is_rotational()
    }

    pub(crate) fn bodies(&self) -> BTreeMap<String, Vec<String>> {
        let joints = self.chain.joints.iter();
        joints.map(|joint| (joint.name.clone(), joint.body_links.clone())).collect()
    }
}
