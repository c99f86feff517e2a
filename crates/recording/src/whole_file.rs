//! Atomic replacement of files.
//!
//! Written here rather than by `tempfile` 3.27, whose `NamedTempFile::persist` was measured to need
//! the same code around it: a file object is not dropped when the handler of Ctrl-C calls
//! `process::exit`, so the list of partial files would stay; `persist` replaces a symbolic link
//! instead of the file behind it, and renames into the folder of a device, so both cases would stay
//! too; and files get mode 0600 instead of 0644 unless it is set.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Files being written, by their temporary names.
static PARTIAL: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Writes a file under a temporary name (`.part`) and then renames it, so that readers see the old
/// file or the complete new one, and an interrupted program leaves no partial file.
///
/// A symbolic link is kept: the file that it points to is replaced. Devices and pipes are written
/// in place.
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
    // created while the list is locked, so that none escapes `remove_partial_files`
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

/// Removes the unfinished files of [`write_whole`], for a program that is about to exit: calls of
/// [`write_whole`] after this one block.
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
