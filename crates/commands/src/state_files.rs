//! Files of states, as lines of JSON or as tables, which are read one state or one group of rows at a time, so that memory
//! does not grow with their number.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use armident_ident::RecordingState;
use armident_report::SetAside;

use crate::failure::Failure;
use crate::state_lines::{Head, each_line, unreadable};
use crate::state_table::{InGroup, StateTable, is_state_table};

/// Where a state stands.
#[derive(Debug, Clone)]
pub(crate) struct Place {
    file: PathBuf,
    at: At,
}

#[derive(Debug, Clone, Copy)]
enum At {
    Line { offset: u64, bytes: usize },
    Row { group: usize, index: usize },
}

/// Calls with each state of a file and its place; what is no state is set aside. `column` is one of tables that names states.
pub(crate) fn heads(
    path: &Path,
    column: Option<&str>,
    mut each: impl FnMut(Head, Place),
    set_aside: &mut Vec<SetAside>,
) -> Result<(), Failure> {
    if !is_state_table(path) {
        return heads_of_lines(path, each, set_aside);
    }
    let table = StateTable::open(path)?;
    for group in 0..table.groups() {
        for (index, head) in table.heads(group, column)?.into_iter().enumerate() {
            let place = Place { file: path.to_owned(), at: At::Row { group, index } };
            match head {
                Ok(head) => each(head, place),
                Err(aside) => set_aside.push(aside),
            }
        }
    }
    Ok(())
}

fn heads_of_lines(
    path: &Path,
    mut each: impl FnMut(Head, Place),
    set_aside: &mut Vec<SetAside>,
) -> Result<(), Failure> {
    let mut offset = 0;
    for (number, line) in each_line(path)?.enumerate() {
        let line = line.map_err(|error| unreadable(path, &error))?;
        let at = At::Line { offset, bytes: line.len() };
        offset += line.len() as u64;
        if line.iter().all(u8::is_ascii_whitespace) {
            continue;
        }
        let reason = match serde_json::from_slice::<Head>(&line) {
            Ok(head) if head.joints.is_some() => {
                each(head, Place { file: path.to_owned(), at });
                continue;
            }
            Ok(_) => "missing field `joints`".to_owned(),
            Err(error) => error.to_string(),
        };
        set_aside.push(SetAside {
            file: format!("{}, line {}", path.display(), number + 1),
            reason: format!("this is no state of a recording: {reason}"),
        });
    }
    Ok(())
}

/// All states of a file; what is none is set aside.
pub(crate) fn states(
    path: &Path,
    mut each: impl FnMut(RecordingState),
    set_aside: &mut Vec<SetAside>,
) -> Result<(), Failure> {
    let mut places = Vec::new();
    heads(path, None, |_, place| places.push(place), set_aside)?;
    let mut reader = StateReader::default();
    for place in places {
        match reader.read(&place)? {
            Ok(state) => each(state),
            Err(aside) => set_aside.push(aside),
        }
    }
    Ok(())
}

/// Reads states by their places.
#[derive(Default)]
pub(crate) struct StateReader {
    /// The group of a table that was read last: its neighbours are read next.
    last: Option<Group>,
}

struct Group {
    file: PathBuf,
    table: StateTable,
    number: usize,
    states: Vec<InGroup<RecordingState>>,
}

impl StateReader {
    /// The state of a place, or why there is none.
    pub(crate) fn read(&mut self, place: &Place) -> Result<InGroup<RecordingState>, Failure> {
        let (group, index) = match place.at {
            At::Line { offset, bytes } => return read_line(&place.file, offset, bytes),
            At::Row { group, index } => (group, index),
        };
        let last = match self.last.take() {
            Some(last) if last.file == place.file && last.number == group => last,
            other => {
                let table = match other {
                    Some(last) if last.file == place.file => last.table,
                    _ => StateTable::open(&place.file)?,
                };
                let states = table.states(group)?;
                Group { file: place.file.clone(), table, number: group, states }
            }
        };
        let state = last.states.get(index).cloned();
        self.last = Some(last);
        state.ok_or_else(|| {
            let hint = Some("do not write to a file of states while it is read");
            Failure::new("the file has changed", place.file.display(), hint)
        })
    }
}

fn read_line(path: &Path, offset: u64, bytes: usize) -> Result<InGroup<RecordingState>, Failure> {
    let unreadable = |error: io::Error| unreadable(path, &error);
    let mut file = File::open(path).map_err(unreadable)?;
    file.seek(SeekFrom::Start(offset)).map_err(unreadable)?;
    let mut line = vec![0; bytes];
    file.read_exact(&mut line).map_err(unreadable)?;
    Ok(serde_json::from_slice(&line).map_err(|error| SetAside {
        file: path.display().to_string(),
        reason: format!("this is no state of a recording: {error}"),
    }))
}

/// Whether a file holds states: its first bytes are those of one, or it is a table of them.
pub(crate) fn holds_states(path: &Path) -> bool {
    let mut start = [0; 64];
    let Ok(read) = File::open(path).and_then(|mut file| file.read(&mut start)) else {
        return false;
    };
    let is_line =
        String::from_utf8_lossy(&start[..read]).starts_with(r#"{"schema":"armident.state/"#);
    is_line || is_state_table(path)
}
