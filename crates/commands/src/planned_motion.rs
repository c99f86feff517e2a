//! Files of planned motions, for controllers.

use std::fmt::Write;

use armident_kinematics::DrivingAxisChain;
use armident_recording::{JointChannels, Recording, write_csv_to};
use serde::Serialize;

use crate::failure::Failure;

/// A format of planned motions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionFormat {
    /// A table with a column for the time and for position, velocity and acceleration of each joint.
    Csv,
    /// `trajectory_msgs/msg/JointTrajectory` of ROS 2 as YAML.
    Ros2,
    /// A function in URScript that goes to the start and sends each position by `servoj`.
    Urscript,
    /// Lists by joint.
    Json,
}

#[derive(Serialize)]
struct MotionDocument<'a> {
    schema: &'static str,
    joints: Vec<&'a str>,
    time_s: &'a [f64],
    /// `[joint][sample]`
    position: Vec<&'a [f64]>,
    velocity: Vec<&'a [f64]>,
    acceleration: Vec<&'a [f64]>,
}

fn channels(motion: &Recording) -> [Vec<&[f64]>; 3] {
    let of = |get: fn(&JointChannels) -> &Option<Vec<f64>>| {
        motion.joints.iter().map(|joint| get(joint).as_deref().unwrap_or_default()).collect()
    };
    [of(|j| &j.position), of(|j| &j.velocity), of(|j| &j.acceleration)]
}

impl MotionFormat {
    /// All formats.
    pub const ALL: [Self; 4] = [Self::Csv, Self::Ros2, Self::Urscript, Self::Json];

    /// Its name in options.
    pub fn name(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Ros2 => "ros2",
            Self::Urscript => "urscript",
            Self::Json => "json",
        }
    }

    /// Extension of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Ros2 => "yaml",
            Self::Urscript => "script",
            Self::Json => "json",
        }
    }

    /// Whether motions of an arm can be written, before they are designed.
    ///
    /// # Errors
    /// URScript of an arm that does not have six rotational joints.
    pub fn check(self, chain: &DrivingAxisChain) -> Result<(), Failure> {
        if self != Self::Urscript || chain.types() == "RRRRRR" {
            return Ok(());
        }
        Err(Failure::new(
            format!("URScript: expected six rotational joints, found {}", chain.types()),
            &chain.source,
            Some("choose another --format: csv, ros2, json"),
        ))
    }

    /// The file of a motion.
    ///
    /// # Errors
    /// URScript of an arm that does not have six rotational joints.
    pub fn bytes(self, motion: &Recording, chain: &DrivingAxisChain) -> Result<Vec<u8>, Failure> {
        match self {
            Self::Csv => {
                let mut bytes = Vec::new();
                write_csv_to(&mut bytes, motion)?;
                Ok(bytes)
            }
            Self::Ros2 => Ok(ros2(motion).into_bytes()),
            Self::Urscript => urscript(motion, chain).map(String::into_bytes),
            Self::Json => {
                let [position, velocity, acceleration] = channels(motion);
                let document = MotionDocument {
                    schema: "armident.motion/1",
                    joints: motion.joints.iter().map(|joint| joint.name.as_str()).collect(),
                    time_s: &motion.time_s,
                    position,
                    velocity,
                    acceleration,
                };
                let failure = |error: serde_json::Error| {
                    Failure::new(
                        format!("cannot write JSON: {error}"),
                        &motion.source,
                        None::<String>,
                    )
                };
                serde_json::to_vec(&document).map_err(failure)
            }
        }
    }
}

fn row(columns: &[&[f64]], sample: usize) -> String {
    let values: Vec<String> = columns
        .iter()
        .map(|column| format!("{:.9}", column.get(sample).copied().unwrap_or(0.0)))
        .collect();
    format!("[{}]", values.join(", "))
}

fn ros2(motion: &Recording) -> String {
    let columns = channels(motion);
    // a quoted string of Rust is one of YAML for the characters of names
    let names: Vec<String> =
        motion.joints.iter().map(|joint| format!("{:?}", joint.name)).collect();
    let mut text = format!(
        "header: {{stamp: {{sec: 0, nanosec: 0}}, frame_id: ''}}\njoint_names: [{}]\npoints:\n",
        names.join(", ")
    );
    for (k, time_s) in motion.time_s.iter().enumerate() {
        let nanoseconds = (time_s * 1e9).round() as u64;
        let [position, velocity, acceleration] = [0, 1, 2].map(|c| row(&columns[c], k));
        // writing to a string does not fail
        let _ = write!(
            text,
            "- positions: {position}\n  velocities: {velocity}\n  accelerations: {acceleration}\n  \
             time_from_start: {{sec: {}, nanosec: {}}}\n",
            nanoseconds / 1_000_000_000,
            nanoseconds % 1_000_000_000
        );
    }
    text
}

fn urscript(motion: &Recording, chain: &DrivingAxisChain) -> Result<String, Failure> {
    /// Speed \[rad/s\] and acceleration \[rad/s²\] of the move to the start: slow beside a robot.
    const TO_START: [f64; 2] = [0.3, 0.3];
    MotionFormat::Urscript.check(chain)?;
    let [position, ..] = channels(motion);
    let samples = motion.time_s.len();
    let step_s = match motion.time_s.as_slice() {
        [first, .., last] => (last - first) / (samples - 1) as f64,
        _ => 0.0,
    };
    let name: String =
        motion.source.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let [speed, acceleration] = TO_START;
    let mut text = format!(
        "# positions every {step_s} s; record joint positions and currents while it runs\ndef {name}():\n  movej({}, a={acceleration}, v={speed})\n  sleep(0.5)\n",
        row(&position, 0)
    );
    for k in 0..samples {
        let _ = writeln!(
            text,
            "  servoj({}, t={step_s:.6}, lookahead_time=0.1, gain=300)",
            row(&position, k)
        );
    }
    text += &format!("  stopj(2.0)\nend\n{name}()\n");
    Ok(text)
}
