//! Tables of states in Parquet: a row for each recording and joint, as `armident.fleet` in Python writes and reads them.

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::path::{Path, PathBuf};

use armident_ident::{JointTriangle, RecordingState};
use armident_numeric::AccumulatedQr;
use armident_recording::{
    RecordingError, TableColumn, TableFile, TableKind, write_table, write_whole,
};
use armident_report::SetAside;

use crate::failure::Failure;
use crate::state_lines::{Head, each_line};

/// Version of the columns.
const SCHEMA: &str = "armident.state-table/1";
/// Recordings of a group of rows: what is in memory when a table is written or read.
const GROUP: usize = 8;
/// Below this share of the largest singular value a combination of columns is none, as in Python.
const RANK_CUT: f64 = 1e-9;

const COLUMNS: [(&str, TableKind); 12] = [
    ("schema", TableKind::Text),
    ("robot", TableKind::Text),
    ("recording", TableKind::Text),
    ("recorded_at_s", TableKind::Number),
    ("joint", TableKind::Text),
    ("rows", TableKind::Whole),
    ("effective_rows", TableKind::Number),
    ("noise", TableKind::Number),
    ("triangle", TableKind::Numbers),
    ("effort_sum", TableKind::Number),
    ("effort_squares", TableKind::Number),
    ("head", TableKind::Text),
];

/// A table of states that is open.
pub(crate) struct StateTable {
    table: TableFile,
    path: PathBuf,
}

/// One recording of a group: all of its state but the joints, as JSON, and the row of each joint.
struct Rows {
    head: String,
    robot: Option<String>,
    named: Option<String>,
    by_joint: BTreeMap<String, usize>,
}

/// A state of a group, or why there is none.
pub(crate) type InGroup<T> = Result<T, SetAside>;

/// Whether a file is a table of states.
pub(crate) fn is_state_table(path: &Path) -> bool {
    let starts = |path: &Path| -> io::Result<bool> {
        let mut start = [0; 4];
        io::Read::read_exact(&mut std::fs::File::open(path)?, &mut start)?;
        Ok(&start == b"PAR1")
    };
    starts(path).unwrap_or(false) && StateTable::open(path).is_ok_and(|table| table.is_of_states())
}

/// Whether states are written to a table by the name of the file.
pub(crate) fn is_named_table(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet"))
}

impl StateTable {
    pub(crate) fn open(path: &Path) -> Result<Self, RecordingError> {
        Ok(Self { table: TableFile::open(path)?, path: path.to_owned() })
    }

    fn is_of_states(&self) -> bool {
        let names = self.table.names();
        ["joint", "triangle", "head"].iter().all(|needed| names.iter().any(|name| name == needed))
    }

    pub(crate) fn groups(&self) -> usize {
        self.table.groups()
    }

    /// A column of texts, whole numbers as text; empty where there is none.
    fn texts(&self, group: usize, name: &str) -> Result<Vec<Option<String>>, RecordingError> {
        let texts = self.table.column(group, name)?.and_then(TableColumn::into_texts);
        Ok(texts.unwrap_or_default())
    }

    /// Recordings of a group in the order of their first rows; the number of its rows.
    fn recordings(
        &self,
        group: usize,
        column: Option<&str>,
    ) -> Result<(Vec<InGroup<Rows>>, usize), RecordingError> {
        let text = |name: &str| self.texts(group, name);
        let (schemas, heads, joints) = (text("schema")?, text("head")?, text("joint")?);
        let robots = text("robot")?;
        let named = column.map_or_else(|| Ok(Vec::new()), text)?;
        let mut order: Vec<InGroup<Rows>> = Vec::new();
        let mut places: BTreeMap<&str, usize> = BTreeMap::new();
        for (row, head) in heads.iter().enumerate() {
            let head = head.as_deref().unwrap_or_default();
            let of = |column: &[Option<String>]| column.get(row).cloned().flatten();
            let place = *places.entry(head).or_insert_with(|| {
                order.push(match of(&schemas).unwrap_or_default() {
                    schema if schema == SCHEMA => Ok(Rows {
                        head: head.to_owned(),
                        robot: of(&robots),
                        named: of(&named),
                        by_joint: BTreeMap::new(),
                    }),
                    schema => {
                        Err(self
                            .aside(group, format!("expected a table `{SCHEMA}`, found `{schema}`")))
                    }
                });
                order.len() - 1
            });
            if let (Ok(rows), Some(joint)) = (&mut order[place], of(&joints)) {
                rows.by_joint.insert(joint, row);
            }
        }
        let count = heads.len();
        Ok((order, count))
    }

    fn aside(&self, group: usize, reason: String) -> SetAside {
        SetAside { file: format!("{}, row group {}", self.path.display(), group + 1), reason }
    }

    fn no_state(&self, group: usize, error: &serde_json::Error) -> SetAside {
        self.aside(group, format!("this is no state of a recording: {error}"))
    }

    /// What stands in front of the numbers of each state of a group.
    pub(crate) fn heads(
        &self,
        group: usize,
        column: Option<&str>,
    ) -> Result<Vec<InGroup<Head>>, RecordingError> {
        let (recordings, _) = self.recordings(group, column)?;
        let of = |rows: InGroup<Rows>| {
            let rows = rows?;
            let mut head: Head =
                serde_json::from_str(&rows.head).map_err(|error| self.no_state(group, &error))?;
            // the column is what users of tables change
            head.robot = rows.robot.or(head.robot);
            head.named = rows.named;
            Ok(head)
        };
        Ok(recordings.into_iter().map(of).collect())
    }

    /// The states of a group, in the order of [`Self::heads`].
    pub(crate) fn states(
        &self,
        group: usize,
    ) -> Result<Vec<InGroup<RecordingState>>, RecordingError> {
        let (recordings, count) = self.recordings(group, None)?;
        let whole = match self.table.column(group, "rows")? {
            Some(TableColumn::Whole(rows)) => rows,
            _ => Vec::new(),
        };
        let number = |name: &str| -> Result<Vec<Option<f64>>, RecordingError> {
            Ok(match self.table.column(group, name)? {
                Some(TableColumn::Number(numbers)) => numbers,
                _ => Vec::new(),
            })
        };
        let (sums, squares) = (number("effort_sum")?, number("effort_squares")?);
        let mut triangles = match self.table.column(group, "triangle")? {
            Some(TableColumn::Numbers(lists)) => lists,
            _ => Vec::new(),
        };
        triangles.resize(count, Vec::new());
        let at = |column: &[Option<f64>], row: usize| {
            column.get(row).copied().flatten().unwrap_or(f64::NAN)
        };
        let mut of = |rows: InGroup<Rows>| {
            let rows = rows?;
            let mut state: RecordingState =
                serde_json::from_str(&rows.head).map_err(|error| self.no_state(group, &error))?;
            for joint in &state.arm.joints {
                let Some(&row) = rows.by_joint.get(joint) else {
                    let reason = format!("no row of joint `{joint}`");
                    return Err(SetAside { file: state.recording, reason });
                };
                let samples = whole.get(row).copied().flatten().unwrap_or(0);
                let samples = usize::try_from(samples).unwrap_or(0);
                state.joints.push(JointTriangle {
                    rows: samples,
                    triangle: std::mem::take(&mut triangles[row]),
                    effort: (samples, at(&sums, row), at(&squares, row)),
                });
            }
            state.robot = rows.robot.or(state.robot);
            Ok(state)
        };
        Ok(recordings.into_iter().map(&mut of).collect())
    }
}

/// Root mean square of what the columns of a triangle leave of its effort; none of numbers that are no triangle.
fn noise_of(joint: &JointTriangle) -> Option<f64> {
    let numbers = joint.triangle.len();
    let width = (((8 * numbers + 1) as f64).sqrt() as usize).saturating_sub(1) / 2;
    if width == 0 || width * (width + 1) / 2 != numbers {
        return None;
    }
    let rows = AccumulatedQr::from_upper(width - 1, joint.rows, &joint.triangle);
    let fit = rows.solve(RANK_CUT).ok()?;
    Some((fit.residual_sum_of_squares / joint.effort.0.max(1) as f64).max(0.0).sqrt())
}

/// States as a group of rows.
fn columns_of(states: Vec<RecordingState>) -> serde_json::Result<Vec<TableColumn>> {
    let rows: usize = states.iter().map(|state| state.joints.len()).sum();
    let mut texts: [Vec<Option<String>>; 5] = Default::default();
    let mut numbers: [Vec<Option<f64>>; 5] = Default::default();
    let (mut whole, mut triangles) = (Vec::with_capacity(rows), Vec::with_capacity(rows));
    for mut state in states {
        let joints = std::mem::take(&mut state.joints);
        let head = serde_json::to_string(&state)?;
        for (name, joint) in state.arm.joints.iter().zip(joints) {
            let of = [Some(SCHEMA), state.robot.as_deref(), Some(&state.recording)];
            let of = of.into_iter().chain([Some(name.as_str()), Some(&head)]);
            texts.iter_mut().zip(of).for_each(|(c, of)| c.push(of.map(ToOwned::to_owned)));
            let effective = joint.rows as f64 * state.independent_share;
            let (_, sum, squares) = joint.effort;
            let of =
                [state.recorded_at_s, Some(effective), noise_of(&joint), Some(sum), Some(squares)];
            numbers.iter_mut().zip(of).for_each(|(column, of)| column.push(of));
            whole.push(i64::try_from(joint.rows).ok());
            triangles.push(joint.triangle);
        }
    }
    let [schema, robot, recording, joint, head] = texts.map(TableColumn::Text);
    let [recorded_at, effective, noise, sum, squares] = numbers.map(TableColumn::Number);
    let (rows, triangle) = (TableColumn::Whole(whole), TableColumn::Numbers(triangles));
    Ok(vec![
        schema,
        robot,
        recording,
        recorded_at,
        joint,
        rows,
        effective,
        noise,
        triangle,
        sum,
        squares,
        head,
    ])
}

/// Writes the states of a table and, behind them, those of a file of lines to the table anew; the states of both are read one
/// group at a time.
///
/// # Errors
/// A file that cannot be read or written; the table is as it was then.
pub(crate) fn with_lines(path: &Path, lines: &Path) -> Result<(), Failure> {
    let old = if path.exists() { Some(StateTable::open(path)?) } else { None };
    let mut groups = 0..old.as_ref().map_or(0, StateTable::groups);
    let mut waiting: VecDeque<RecordingState> = VecDeque::new();
    let mut more = each_line(lines)?;
    let next = || -> io::Result<Option<Vec<TableColumn>>> {
        while waiting.len() < GROUP {
            if let (Some(table), Some(group)) = (&old, groups.next()) {
                let states = table.states(group).map_err(io::Error::other)?;
                waiting.extend(states.into_iter().flatten());
            } else if let Some(line) = more.next().transpose()? {
                // a line that an interrupted run has cut off is none
                waiting.extend(serde_json::from_slice::<RecordingState>(&line));
            } else {
                break;
            }
        }
        let count = waiting.len().min(GROUP);
        if count == 0 {
            return Ok(None);
        }
        Ok(Some(columns_of(waiting.drain(..count).collect())?))
    };
    write_whole(path, |out| write_table(out, &COLUMNS, next))
        .map_err(|error| Failure::unwritable(path, &error))
}
