//! Arms of `urdf/` on which effects are hidden.

/// A robot by name, with the text of its URDF.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Arm {
    /// Its name.
    pub name: String,
    /// Its URDF.
    pub urdf: String,
}

macro_rules! arms {
    ($($name:literal),*) => {
        /// Arms whose joints load one another enough for every kind of effect.
        const ARMS: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../../../urdf/", $name, ".urdf")))),*];
    };
}

arms![
    "ur5",
    "panda",
    "stanford",
    "scara",
    "iiwa14",
    "puma560",
    "tx40",
    "ur10",
    "kinova_gen3",
    "gantry"
];

impl Arm {
    /// All arms that come with the program.
    pub fn all() -> Vec<Self> {
        let arm = |(name, urdf): &(&str, &str)| Self {
            name: (*name).to_owned(),
            urdf: (*urdf).to_owned(),
        };
        ARMS.iter().map(arm).collect()
    }

    /// One of them by its name.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().into_iter().find(|arm| arm.name == name)
    }
}
