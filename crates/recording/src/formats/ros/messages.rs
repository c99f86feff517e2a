//! Messages of joints: which there are, and their channels.
//!
//! ```text
//! sensor_msgs/JointState                         header, name[], position[], velocity[], effort[]
//! control_msgs/DynamicJointState                 header, joint_names[], interface_values[] { interface_names[], values[] }
//! control_msgs/JointTrajectoryControllerState    header, joint_names[], reference, feedback, error, output
//!     each point                                 positions[], velocities[], accelerations[], effort[], time_from_start
//! ```
//!
//! Of a controller's state the feedback is read, and the reference positions as commands; older versions call the points
//! desired, actual and error.

use super::joint_state::JointState;
use super::serialised::{BadMessage, Encoding, Reader};
use crate::quantity::Quantity;

/// Kind of a message of joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    State,
    Dynamic,
    Controller,
}

/// The joints of one message with their values.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Message {
    /// stamp of the header \[ns\]; 0 if it has none
    pub(super) stamp_ns: i64,
    pub(super) joints: Vec<String>,
    /// a value for each joint, NaN where there is none
    pub(super) values: Vec<(Quantity, Vec<f64>)>,
}

/// Quantities of interfaces of hardware, by their names in ros2_control.
const INTERFACES: [(&str, Quantity); 8] = [
    ("position", Quantity::Position),
    ("velocity", Quantity::Velocity),
    ("acceleration", Quantity::Acceleration),
    ("effort", Quantity::Effort),
    ("torque", Quantity::Effort),
    ("current", Quantity::Current),
    ("voltage", Quantity::Voltage),
    ("temperature", Quantity::Temperature),
];

impl Kind {
    /// By the name of the message in ROS 2 or ROS 1.
    pub(super) fn of(schema: &str) -> Option<Self> {
        match schema.replacen("/msg/", "/", 1).as_str() {
            "sensor_msgs/JointState" => Some(Self::State),
            "control_msgs/DynamicJointState" => Some(Self::Dynamic),
            "control_msgs/JointTrajectoryControllerState" => Some(Self::Controller),
            _ => None,
        }
    }

    /// Reads a message of this kind.
    pub(super) fn decode(self, bytes: &[u8], encoding: Encoding) -> Result<Message, BadMessage> {
        match self {
            Self::State => {
                let state = JointState::decode(bytes, encoding)?;
                let values = vec![
                    (Quantity::Position, state.position),
                    (Quantity::Velocity, state.velocity),
                    (Quantity::Effort, state.effort),
                ];
                Ok(Message { stamp_ns: state.stamp_ns, joints: state.name, values })
            }
            Self::Dynamic => dynamic(&mut Reader::new(bytes, encoding)?),
            Self::Controller => controller(&mut Reader::new(bytes, encoding)?),
        }
    }
}

fn dynamic(reader: &mut Reader<'_>) -> Result<Message, BadMessage> {
    let stamp_ns = reader.header()?;
    let joints = reader.names()?;
    let count = reader.count("the interfaces", 8)?;
    if count != joints.len() {
        return Err(reader.bad(format!("it has {} names, but interfaces of {count}", joints.len())));
    }
    let mut values: Vec<(Quantity, Vec<f64>)> = Vec::new();
    for joint in 0..count {
        let (names, numbers) = (reader.names()?, reader.list("the values")?);
        if names.len() != numbers.len() {
            let what = format!("it has {} interfaces, but {} values", names.len(), numbers.len());
            return Err(reader.bad(what));
        }
        for (name, number) in names.iter().zip(numbers) {
            let Some((_, quantity)) = INTERFACES.iter().find(|known| known.0 == name) else {
                continue;
            };
            let place = values.iter().position(|(of, _)| of == quantity).unwrap_or_else(|| {
                values.push((*quantity, vec![f64::NAN; count]));
                values.len() - 1
            });
            values[place].1[joint] = number;
        }
    }
    Ok(Message { stamp_ns, joints, values })
}

fn controller(reader: &mut Reader<'_>) -> Result<Message, BadMessage> {
    let stamp_ns = reader.header()?;
    let joints = reader.names()?;
    let [command, _, _, _] = point(reader)?;
    let [position, velocity, _, effort] = point(reader)?;
    let mut values = Vec::new();
    let lists = [
        (Quantity::Position, position),
        (Quantity::Velocity, velocity),
        (Quantity::Effort, effort),
        (Quantity::Command, command),
    ];
    for (quantity, list) in lists {
        if !list.is_empty() && list.len() != joints.len() {
            let what = format!("it has {} names, but {} of {quantity}", joints.len(), list.len());
            return Err(reader.bad(what));
        }
        values.push((quantity, list));
    }
    Ok(Message { stamp_ns, joints, values })
}

/// Positions, velocities, accelerations and efforts of `trajectory_msgs/JointTrajectoryPoint`.
fn point(reader: &mut Reader<'_>) -> Result<[Vec<f64>; 4], BadMessage> {
    let lists = [
        reader.list("the positions")?,
        reader.list("the velocities")?,
        reader.list("the accelerations")?,
        reader.list("the efforts")?,
    ];
    // time from the start
    reader.u32()?;
    reader.u32()?;
    Ok(lists)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes of ROS 1, which needs no alignment.
    struct Bytes(Vec<u8>);

    impl Bytes {
        fn header() -> Self {
            let mut bytes = Self(Vec::new());
            for number in [0, 3, 500, 0] {
                bytes.number(number);
            }
            bytes
        }

        fn number(&mut self, number: u32) {
            self.0.extend(number.to_le_bytes());
        }

        fn names(&mut self, names: &[&str]) {
            self.number(names.len() as u32);
            for name in names {
                self.number(name.len() as u32);
                self.0.extend(name.as_bytes());
            }
        }

        fn list(&mut self, list: &[f64]) {
            self.number(list.len() as u32);
            self.0.extend(list.iter().flat_map(|x| x.to_le_bytes()));
        }
    }

    #[test]
    fn interfaces_become_quantities() {
        let mut bytes = Bytes::header();
        bytes.names(&["a", "b"]);
        bytes.number(2);
        bytes.names(&["position", "mode", "torque"]);
        bytes.list(&[1.0, 7.0, 2.0]);
        bytes.names(&["position"]);
        bytes.list(&[3.0]);
        let found = Kind::Dynamic.decode(&bytes.0, Encoding::Ros1).unwrap();
        assert_eq!((found.stamp_ns, found.joints.len()), (3_000_000_500, 2));
        assert_eq!(found.values[0], (Quantity::Position, vec![1.0, 3.0]));
        assert_eq!(found.values[1].0, Quantity::Effort);
        assert!(found.values[1].1[0] == 2.0 && found.values[1].1[1].is_nan());
    }

    #[test]
    fn feedback_of_controllers_is_read() {
        let mut bytes = Bytes::header();
        bytes.names(&["a"]);
        for point in 0..3 {
            let base = f64::from(point);
            for list in [&[base][..], &[base + 0.5], &[], if point == 1 { &[9.0] } else { &[] }] {
                bytes.list(list);
            }
            bytes.number(0);
            bytes.number(0);
        }
        let found = Kind::Controller.decode(&bytes.0, Encoding::Ros1).unwrap();
        let expected = [
            (Quantity::Position, vec![1.0]),
            (Quantity::Velocity, vec![1.5]),
            (Quantity::Effort, vec![9.0]),
            (Quantity::Command, vec![0.0]),
        ];
        assert_eq!(found.values, expected);
        for length in 0..bytes.0.len() - 20 {
            let _ = Kind::Controller.decode(&bytes.0[..length], Encoding::Ros1);
        }
    }
}
