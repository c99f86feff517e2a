//! Every method, the check, the diagnosis, and what it says changed, on every public recording, judged on motion they have not seen.
//!
//! The folder holds one folder a set, with its URDF, recordings and `dataset.toml`
//! (`joints`, `baseline.filter_hz`).
//!
//! ```text
//! cargo run --release --example real_data -- ../shared/data > docs/real-data.md
//! ```
//!
//! `estimators`, `check`, `diagnosis` or `changes` behind the folder prints that section alone, `placebos` the changes
//! without payloads.

#![allow(clippy::print_stdout, reason = "the tables are the output")]

mod changes;
mod diagnosis;
mod estimators;
mod pieces;
mod sets;

use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().ok_or("the folder of the sets is missing")?;
    let folder = Path::new(&folder);
    type Section = (&'static str, fn(&Path) -> Result<(), Box<dyn Error>>);
    let sections: [Section; 4] = [
        ("estimators", estimators::print),
        ("check", pieces::print),
        ("diagnosis", diagnosis::print),
        ("changes", changes::print),
    ];
    if let Some(only) = arguments.next() {
        if only == "placebos" {
            return changes::print_placebos(folder);
        }
        let (_, print) =
            sections.into_iter().find(|(name, _)| *name == only).ok_or("no such section")?;
        return print(folder);
    }
    println!("# Recordings of real arms\n");
    println!(
        "Made by `cargo run --release --example real_data -- ../shared/data`, armident {}. Sources and \
         licences are in each set's `dataset.toml`.\n",
        env!("CARGO_PKG_VERSION")
    );
    sections.into_iter().try_for_each(|(_, print)| print(folder))
}
