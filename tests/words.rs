//! Vocabulary: words that CONVENTIONS.md replaces are not used again.
//!
//! A ratchet: [`WORDS`] lists how often each word may still occur, and the numbers may only fall.
//! `cargo test --test acceptance words -- --nocapture` prints the rows to lower.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use crate::figures::without_code;
use crate::shared::project;

/// Word or words, the term that replaces it, and occurrences allowed in prose, in `--help`, and in code.
const WORDS: &[(&str, &str, [usize; 3])] = &[
    ("books|bookkeeping", "input checks", [0, 0, 5]),
    ("heard|hear|hears", "diagnose, report", [0, 0, 0]),
    ("everyday", "baseline", [4, 0, 6]),
    ("stretch|stretches", "fold, block, interval", [0, 0, 19]),
    ("misfit|misfits", "residual, model discrepancy", [0, 0, 12]),
    ("whitened", "marginalised", [0, 0, 0]),
    (
        "told apart|tell apart|tells apart|tell them apart|tells them apart",
        "distinguish, separate",
        [0, 0, 4],
    ),
    ("told|tells|tell", "report, detect", [1, 0, 76]),
    ("says|said|say", "state, report", [3, 0, 292]),
    ("speaks|speak|asks|asked", "require, indicate", [0, 0, 59]),
    ("left over|leaves over|leave over", "residual", [0, 0, 14]),
    ("what is left", "residual", [0, 0, 11]),
    (
        "goes with|go with|goes most with|go together",
        "correlated with, strongest regressor",
        [1, 0, 5],
    ),
    ("by links", "links only, diagnosed", [0, 0, 0]),
    ("real links|real bodies|real body|real link|no body", "physically consistent", [0, 0, 12]),
    ("believed|belief|believes", "prior", [0, 0, 39]),
    ("urdf s word", "prior share", [0, 0, 0]),
    ("turning|turn speed|turning speed", "reversal", [0, 0, 46]),
    ("at once", "immediately, SHARP", [4, 0, 30]),
    ("fades|faded|fade", "is regularised", [1, 0, 8]),
    ("bending|bends|bend", "sublinear", [1, 0, 22]),
    ("grows more slowly", "sublinear", [0, 0, 1]),
    ("builds up over", "presliding", [1, 0, 6]),
    ("gives way|give way", "breakaway", [0, 0, 10]),
    ("rests|lasts", "standstill, dwell", [0, 0, 72]),
    ("stands still|stand still", "at rest", [0, 0, 0]),
    ("essential", "significant", [0, 0, 2]),
    ("unknowns", "parameters", [0, 0, 130]),
    ("cannot tell|cannot be told", "inconclusive, not identifiable", [0, 0, 25]),
    ("may be chance|by chance", "not significant, random", [0, 0, 6]),
    ("without a name|nameless", "unmodelled", [1, 0, 1]),
    ("matters", "is material", [1, 0, 24]),
    ("nobody", "(rewrite)", [0, 0, 6]),
    ("as far as can be told|by themselves", "(rewrite)", [0, 0, 6]),
    ("leaves out|leave out|leaves small efforts out", "lacks, has a dead zone", [1, 0, 5]),
    ("in the place of|in its place|in their place", "instead of", [2, 0, 15]),
    ("kept back|kept out", "held out", [0, 0, 33]),
    ("conceal|conceals|concealed", "hidden", [4, 0, 6]),
    ("dear|seldom|likeliest", "expensive, rare, most likely", [0, 0, 16]),
    ("off by", "differs by", [1, 0, 15]),
    ("atlas", "residual map", [0, 0, 22]),
    ("hats|hat", "linear B-spline basis", [0, 0, 26]),
    ("sprung", "compliant", [0, 0, 45]),
    ("unreported", "dead zone", [0, 0, 0]),
    ("onset|onsets", "change prior", [0, 0, 65]),
    ("doubt|doubts", "uncertainty, inconclusive", [1, 0, 16]),
    ("hidden link|hidden links", "link-side motion", [0, 0, 1]),
    ("surely|how sure", "confidence", [0, 0, 5]),
    ("what else", "alternative", [0, 0, 1]),
];

/// Files of a folder and below it.
fn files(folder: &Path, end: &str, found: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.map(|entry| entry.unwrap().path()) {
        if path.is_dir() {
            files(&path, end, found);
        } else if path.extension().is_some_and(|extension| extension == end) {
            found.push(path);
        }
    }
}

fn text_of(paths: &[PathBuf], filtered: fn(&str) -> String) -> String {
    paths.iter().map(|path| filtered(&std::fs::read_to_string(path).unwrap()) + "\n").collect()
}

/// Markdown pages without their code, `--help`, and Rust code with its comments and texts.
fn areas() -> [String; 3] {
    let pages = ["README.md", "CONTRIBUTING.md", "ARCHITECTURE.md", "CONVENTIONS.md"];
    let mut prose: Vec<PathBuf> = pages.iter().map(|page| project(page)).collect();
    files(&project("docs"), "md", &mut prose);
    let mut help = vec![project("src/args.rs")];
    files(&project("src/args"), "rs", &mut help);
    let mut code = Vec::new();
    for folder in ["crates", "src", "tests", "examples"] {
        files(&project(folder), "rs", &mut code);
    }
    // this table, and the arguments, which are counted as help
    code.retain(|path| !path.ends_with("tests/words.rs") && !help.contains(path));
    [text_of(&prose, without_code), text_of(&help, str::to_owned), text_of(&code, str::to_owned)]
}

/// Lower-case words of a text, one space between them; `left_over` and `LeftOver` are two words.
fn words(text: &str) -> String {
    let mut words = String::from(" ");
    let mut before = ' ';
    for c in text.chars() {
        let starts_word = c.is_uppercase() && before.is_lowercase();
        if (!c.is_alphabetic() || starts_word) && !words.ends_with(' ') {
            words.push(' ');
        }
        if c.is_alphabetic() {
            words.extend(c.to_lowercase());
        }
        before = c;
    }
    words.push(' ');
    words
}

fn count(words: &str, wanted: &str) -> usize {
    let wanted = format!(" {wanted} ");
    let mut count = 0;
    let mut rest = words;
    while let Some(at) = rest.find(&wanted) {
        count += 1;
        // the space between two neighbours belongs to both
        rest = &rest[at + wanted.len() - 1..];
    }
    count
}

#[test]
fn replaced_words_only_become_fewer() {
    let areas = areas().map(|text| words(&text));
    let mut more = String::new();
    for (word, instead, allowed) in WORDS {
        let found =
            [0, 1, 2].map(|k| word.split('|').map(|form| count(&areas[k], form)).sum::<usize>());
        for (area, (found, allowed)) in
            ["prose", "--help", "code"].iter().zip(found.iter().zip(allowed))
        {
            if found > allowed {
                let _ =
                    writeln!(more, "{word}: {found} in {area}, at most {allowed}; use {instead}");
            } else if found < allowed {
                eprintln!("lower the row of {word}: {found} in {area}, allowed {allowed}");
            }
        }
    }
    assert!(more.is_empty(), "CONVENTIONS.md has terms for these words:\n{more}");
}

#[test]
fn identifiers_are_split_into_words() {
    let words = words("let left_over = LeftOver::of(books); // books, the book\n");
    assert_eq!(count(&words, "left over"), 2);
    assert_eq!(count(&words, "books"), 2);
    assert_eq!(count(" books books ", "books"), 2);
}
