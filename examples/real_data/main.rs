//! Every method, the check, and the diagnosis, on every public recording, judged on motion they have not seen.
//!
//! The folder holds one folder a set, with its URDF, recordings and `dataset.toml`
//! (`joints`, `baseline.filter_hz`).
//!
//! ```text
//! cargo run --release --example real_data -- ../shared/data > docs/real-data.md
//! ```

#![allow(clippy::print_stdout, reason = "the tables are the output")]

mod diagnosis;
mod estimators;
mod pieces;
mod sets;

use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).ok_or("the folder of the sets is missing")?;
    println!("# Recordings of real arms\n");
    println!(
        "Made by `cargo run --release --example real_data -- ../shared/data`, armident {}. Sources and \
         licences are in each set's `dataset.toml`.\n",
        env!("CARGO_PKG_VERSION")
    );
    estimators::print(Path::new(&folder))?;
    pieces::print(Path::new(&folder))?;
    diagnosis::print(Path::new(&folder))
}
