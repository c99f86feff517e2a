//! Files that are there whole or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Files that are being written, under the names they have until then.
static PARTIAL: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Writes a file under another name (`.part`) first and renames it then, so that one who looks sees the
/// old file or the whole new one, and an interrupted program leaves no half of it.
///
/// A link keeps pointing where it points: the file behind it is replaced. What is no regular file (a
/// device, a pipe) is written in place.
///
/// # Errors
/// The file cannot be written, or `content` fails.
///
/// # Examples
/// ```
/// let path = std::env::temp_dir().join("armident_whole.txt");
/// armident_recording::write_whole(&path, |file| std::io::Write::write_all(file, b"all of it"))?;
/// assert_eq!(std::fs::read_to_string(&path)?, "all of it");
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), std::io::Error>(())
/// ```
pub fn write_whole(
    path: &Path,
    content: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let target = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if target.metadata().is_ok_and(|found| !found.is_file()) {
        return filled(OpenOptions::new().write(true).open(&target)?, content);
    }
    let mut partial = target.as_os_str().to_owned();
    partial.push(".part");
    let partial = PathBuf::from(partial);
    // made while the list is held, so that none is made behind the back of a program that ends
    let created = partials(|all| {
        all.push(partial.clone());
        File::create(&partial)
    });
    let written =
        created.and_then(|file| filled(file, content)).and_then(|()| fs::rename(&partial, &target));
    if written.is_err() {
        let _ = fs::remove_file(&partial);
    }
    partials(|all| all.retain(|other| *other != partial));
    written
}

/// Removes what [`write_whole`] has not finished; for a program that is about to end: whoever begins another file after
/// this waits for the end.
pub fn remove_partial_files() {
    let mut all = PARTIAL.lock().unwrap_or_else(PoisonError::into_inner);
    for path in all.drain(..) {
        let _ = fs::remove_file(path);
    }
    std::mem::forget(all);
}

fn filled(file: File, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut writer = BufWriter::with_capacity(1 << 16, file);
    content(&mut writer)?;
    writer.flush()
}

fn partials<T>(change: impl FnOnce(&mut Vec<PathBuf>) -> T) -> T {
    change(&mut PARTIAL.lock().unwrap_or_else(PoisonError::into_inner))
}
