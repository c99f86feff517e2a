//! ROS 2 bags in SQLite: joints of one topic (cargo feature `all-formats`).

use super::format::{FileStart, Format, Support};
#[cfg(feature = "all-formats")]
use {
    super::bag_metadata::part_note,
    super::format::{ColumnRequest, Input},
    super::ros::Topics,
    crate::error::{Fault, RecordingError},
    crate::raw::RawColumns,
    rusqlite::{Connection, OpenFlags},
    std::collections::BTreeMap,
    std::path::Path,
};

/// ROS 2 bags in SQLite.
#[derive(Debug, Clone, Copy)]
pub struct Db3;

impl Format for Db3 {
    fn name(&self) -> &'static str {
        "ROS 2 bag (SQLite)"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["db3"]
    }

    fn support(&self) -> Support {
        if cfg!(feature = "all-formats") { Support::Read } else { Support::Feature("all-formats") }
    }

    fn is_it(&self, start: &FileStart<'_>) -> bool {
        start.bytes.starts_with(b"SQLite format 3\0")
    }

    #[cfg(feature = "all-formats")]
    fn read(
        &self,
        input: Input,
        request: &ColumnRequest<'_>,
    ) -> Result<RawColumns, RecordingError> {
        let mut topics = Topics::new(request);
        let ended = read_file(input.path(), &mut topics, request.source())?;
        let mut raw = topics.columns(request, ended)?;
        raw.notes.extend(part_note(input.path()));
        Ok(raw)
    }
}

/// Reads the messages of a file; the reason if it ends early.
///
/// # Errors
/// No message can be read.
#[cfg(feature = "all-formats")]
pub(super) fn read_file(
    path: &Path,
    topics: &mut Topics,
    source: &str,
) -> Result<Option<String>, RecordingError> {
    let broken = |error: rusqlite::Error| {
        let what = error.to_string();
        RecordingError::new(Fault::Broken { format: "SQLite", what }, source)
    };
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let bag = Connection::open_with_flags(path, flags).map_err(broken)?;
    let ended = read_messages(&bag, topics).err();
    match ended {
        Some(error) if topics.is_empty() => Err(broken(error)),
        ended => Ok(ended.map(|error| error.to_string())),
    }
}

/// Without the feature no file comes here: the format states what is missing.
#[cfg(all(feature = "mcap", not(feature = "all-formats")))]
pub(super) fn read_file(
    _path: &std::path::Path,
    _topics: &mut super::ros::Topics,
    source: &str,
) -> Result<Option<String>, crate::error::RecordingError> {
    let fault = crate::error::Fault::NotBuilt { format: Db3.name(), feature: "all-formats" };
    Err(crate::error::RecordingError::new(fault, source))
}

/// Reads the messages of all wanted topics in the order in which they were written.
#[cfg(feature = "all-formats")]
fn read_messages(bag: &Connection, topics: &mut Topics) -> rusqlite::Result<()> {
    let mut listed = bag.prepare("SELECT id, name, type, serialization_format FROM topics")?;
    let rows = listed
        .query_map([], |row| Ok((row.get::<_, i64>(0)?, row.get(1)?, row.get(2)?, row.get(3)?)))?;
    let mut named = BTreeMap::new();
    for row in rows {
        let (id, topic, schema, encoding): (i64, String, String, String) = row?;
        topics.declare(&topic, &schema);
        if topics.wants(&topic) {
            named.insert(id, (topic, encoding));
        }
    }
    // the order of rows needs no sorting: what stands before a damaged page is read
    let mut messages = bag.prepare("SELECT topic_id, timestamp, data FROM messages ORDER BY id")?;
    let mut rows = messages.query([])?;
    while let Some(row) = rows.next()? {
        let Some((topic, encoding)) = named.get(&row.get::<_, i64>(0)?) else { continue };
        let log_ns = u64::try_from(row.get::<_, i64>(1)?).unwrap_or(0);
        let data = row.get_ref(2)?.as_blob().unwrap_or_default();
        topics.take(topic, encoding, data, log_ns);
    }
    Ok(())
}
