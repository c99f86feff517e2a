//! Files of states that are read one state at a time, so that memory does not grow with their number.

use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use armident_ident::{RecordingState, ReducedArm};
use armident_report::SetAside;
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::failure::Failure;

/// What is read of every state at first.
#[derive(Debug, Deserialize)]
pub(crate) struct Head {
    pub(crate) schema: String,
    pub(crate) recording: String,
    #[serde(default)]
    pub(crate) robot: Option<String>,
    #[serde(default)]
    pub(crate) recorded_at_s: Option<f64>,
    #[serde(default)]
    pub(crate) content: Option<String>,
    pub(crate) arm: ReducedArm,
    #[serde(rename = "joints")]
    _joints: IgnoredAny,
}

/// Where a state stands.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    pub(crate) file: PathBuf,
    offset: u64,
    bytes: usize,
}

/// Calls with each state of a file and its place; lines that are no states are set aside.
pub(crate) fn heads(
    path: &Path,
    mut each: impl FnMut(Head, Place),
    set_aside: &mut Vec<SetAside>,
) -> Result<(), Failure> {
    let mut reader = BufReader::new(File::open(path).map_err(|error| unreadable(path, &error))?);
    let (mut line, mut offset, mut number) = (Vec::new(), 0, 0);
    loop {
        line.clear();
        let bytes =
            reader.read_until(b'\n', &mut line).map_err(|error| unreadable(path, &error))?;
        if bytes == 0 {
            return Ok(());
        }
        number += 1;
        let place = Place { file: path.to_owned(), offset, bytes };
        offset += bytes as u64;
        if line.iter().all(u8::is_ascii_whitespace) {
            continue;
        }
        match serde_json::from_slice::<Head>(&line) {
            Ok(head) => each(head, place),
            Err(error) => set_aside.push(SetAside {
                file: format!("{}, line {number}", path.display()),
                reason: format!("this is no state of a recording: {error}"),
            }),
        }
    }
}

impl Place {
    /// The state that stands here.
    pub(crate) fn read(&self) -> Result<RecordingState, Failure> {
        let unreadable = |error: std::io::Error| unreadable(&self.file, &error);
        let mut file = File::open(&self.file).map_err(unreadable)?;
        file.seek(SeekFrom::Start(self.offset)).map_err(unreadable)?;
        let mut bytes = vec![0; self.bytes];
        file.read_exact(&mut bytes).map_err(unreadable)?;
        serde_json::from_slice(&bytes).map_err(|error| {
            Failure::new(
                format!("this is no state of a recording: {error}"),
                self.file.display(),
                Some("pass files that `armident accumulate` has written"),
            )
        })
    }
}

/// Whether a file holds states: its first bytes are those of one.
pub(crate) fn holds_states(path: &Path) -> bool {
    let mut start = [0; 64];
    let Ok(read) = File::open(path).and_then(|mut file| file.read(&mut start)) else {
        return false;
    };
    String::from_utf8_lossy(&start[..read]).starts_with(r#"{"schema":"armident.state/"#)
}

fn unreadable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(
        format!("cannot read: {error}"),
        path.display(),
        Some("pass a file that `armident accumulate` has written"),
    )
}
