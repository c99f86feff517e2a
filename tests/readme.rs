//! The commands of README.md and of the book: what they show is what the program says.

use std::path::{Path, PathBuf};

use crate::shared::project;
use crate::tool::scratch;

#[path = "../examples/effect_pages/pages.rs"]
mod effect_pages;

fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        std::fs::create_dir_all(to).unwrap();
        for entry in std::fs::read_dir(from).unwrap() {
            let entry = entry.unwrap();
            copy(&entry.path(), &to.join(entry.file_name()));
        }
    } else {
        std::fs::copy(from, to).unwrap();
    }
}

/// Runs every ```` ```console ```` block of a page, one after the other in one folder that holds the
/// project's `urdf` and `examples` and the files of the book. `TRYCMD=overwrite cargo test --test acceptance
/// readme` writes the output of today into the pages.
fn run_pages(test: &str, pages: &[PathBuf]) {
    let folder = scratch(test);
    let cases = trycmd::TestCases::new();
    cases.register_bin("armident", Path::new(env!("CARGO_BIN_EXE_armident")));
    let mut copies = Vec::new();
    for page in pages {
        let text = std::fs::read_to_string(page).unwrap();
        let name = page.file_name().unwrap().to_str().unwrap();
        // what includes another file has no commands of its own
        if !text.contains("```console") {
            continue;
        }
        let copied = folder.join(name);
        copy(page, &copied);
        let inputs = copied.with_extension("in");
        for given in ["urdf", "examples"] {
            copy(&project(given), &inputs.join(given));
        }
        copy(&project("docs/book/files"), &inputs);
        // its presence makes the commands share a folder they may write to
        std::fs::create_dir_all(copied.with_extension("out")).unwrap();
        cases.case(&copied);
        copies.push((copied, page));
    }
    assert!(!copies.is_empty());
    cases.run();
    if std::env::var_os("TRYCMD").is_some_and(|wish| wish == "overwrite") {
        for (copied, page) in copies {
            copy(&copied, page);
        }
    }
}

#[test]
fn readme_commands_print_as_shown() {
    let readme = project("README.md");
    if readme.exists() {
        run_pages("readme", &[readme]);
    }
}

fn pages_in(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(project(folder)).unwrap().map(|entry| entry.unwrap().path());
    let mut pages: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|end| end == "md")).collect();
    pages.sort();
    pages
}

#[test]
fn book_commands_print_as_shown() {
    run_pages("book", &pages_in("docs/book/src"));
    run_pages("book_effects", &pages_in("docs/book/src/effects"));
}

/// Every page is in the table of contents, every entry and every link between pages has its page, and no
/// console block of the book hides in a page that is not run.
#[test]
fn book_links_and_contents_are_complete() {
    let root = project("docs/book/src");
    let summary = std::fs::read_to_string(root.join("SUMMARY.md")).unwrap();
    let mut pages = pages_in("docs/book/src");
    pages.extend(pages_in("docs/book/src/effects"));
    for page in pages.iter().filter(|page| !page.ends_with("SUMMARY.md")) {
        let inside = page.strip_prefix(&root).unwrap().to_str().unwrap();
        assert!(summary.contains(&format!("({inside})")), "{inside} is not in SUMMARY.md");
    }
    for page in &pages {
        let text = std::fs::read_to_string(page).unwrap();
        for link in text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next()) {
            let outside = link.starts_with("http") || link.is_empty();
            let target = page.parent().unwrap().join(link);
            assert!(outside || target.exists(), "{}: no {link}", page.display());
        }
    }
}

/// The pages of the catalogue are those that the laws give today.
#[test]
fn catalogue_matches_the_laws() {
    let numbers = |svg: &str| -> Vec<f64> {
        svg.split(|c: char| !(c.is_ascii_digit() || c == '.'))
            .filter_map(|word| word.parse().ok())
            .collect()
    };
    for (path, text) in effect_pages::pages().unwrap() {
        let file = project("docs/book/src").join(&path);
        let written = std::fs::read_to_string(&file).unwrap_or_default();
        let same = match path.ends_with(".svg") {
            // another machine may round a pixel otherwise
            true => {
                let (now, then) = (numbers(&text), numbers(&written));
                now.len() == then.len() && now.iter().zip(&then).all(|(a, b)| (a - b).abs() <= 2.0)
            }
            false => text == written,
        };
        assert!(same, "{path} is old: cargo run --release --example effect_pages");
    }
}
