//! The given robot of a case.

use std::collections::BTreeMap;

use armident_dynamics::RigidArm;
use armident_kinematics::{ChainSelection, DrivingAxisChain, SerialChain, parse_urdf};

use crate::error::ChallengeError;

/// Name of the tool frame by the rules of the challenge; that of the arms of this project is another. Arms that have
/// both keep them.
const TOOL: (&str, &str) = ("\"flange\"", "\"tool0\"");

/// A URDF with what is needed of it.
pub(crate) struct Robot {
    pub(crate) urdf: String,
    pub(crate) chain: DrivingAxisChain,
    pub(crate) names: Vec<String>,
}

impl Robot {
    pub(crate) fn parse(urdf: &str) -> Result<Self, ChallengeError> {
        let urdf = match urdf.contains(TOOL.1) {
            true => urdf.to_owned(),
            false => urdf.replace(TOOL.0, TOOL.1),
        };
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arm_with_flange_and_tool_keeps_both() {
        let text = include_str!("../../../../urdf/ur5.urdf");
        assert!(text.contains(TOOL.0) && !text.contains(TOOL.1));
        let renamed = Robot::parse(text).unwrap();
        assert_eq!(renamed.chain.tip_link, "tool0");
        let tool = r#"<link name="tool0"/><joint name="on_flange" type="fixed">
            <parent link="flange"/><child link="tool0"/></joint></robot>"#;
        let both = Robot::parse(&text.replace("</robot>", tool)).unwrap();
        assert_eq!(both.chain.tip_link, "tool0");
        assert!(both.urdf.contains(TOOL.0));
    }
}
