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
    ("books|bookkeeping", "input checks", [2, 0, 100]),
    ("heard|hear|hears", "diagnose, report", [0, 0, 36]),
    ("everyday", "baseline", [4, 0, 176]),
    ("stretch|stretches", "fold, block, interval", [4, 0, 154]),
    ("misfit|misfits", "residual, model discrepancy", [0, 0, 114]),
    ("whitened", "marginalised", [0, 0, 196]),
    (
        "told apart|tell apart|tells apart|tell them apart|tells them apart",
        "distinguish, separate",
        [24, 0, 41],
    ),
    ("told|tells|tell", "report, detect", [53, 0, 270]),
    ("says|said|say", "state, report", [28, 0, 524]),
    ("speaks|speak|asks|asked", "require, indicate", [1, 0, 91]),
    ("left over|leaves over|leave over", "residual", [3, 0, 65]),
    ("what is left", "residual", [2, 0, 44]),
    (
        "goes with|go with|goes most with|go together",
        "correlated with, strongest regressor",
        [1, 0, 17],
    ),
    ("by links", "links only, diagnosed", [0, 0, 1]),
    ("real links|real bodies|real body|real link|no body", "physically consistent", [5, 0, 37]),
    ("believed|belief|believes", "prior", [2, 0, 199]),
    ("urdf s word", "prior share", [0, 0, 3]),
    ("turning|turn speed|turning speed", "reversal", [0, 0, 84]),
    ("at once", "immediately, SHARP", [5, 0, 50]),
    ("fades|faded|fade", "is regularised", [2, 0, 26]),
    ("bending|bends|bend", "sublinear", [2, 0, 167]),
    ("grows more slowly", "sublinear", [1, 0, 7]),
    ("builds up over", "presliding", [1, 0, 11]),
    ("gives way|give way", "breakaway", [0, 0, 11]),
    ("rests|lasts", "standstill, dwell", [1, 0, 117]),
    ("stands still|stand still", "at rest", [0, 0, 4]),
    ("essential", "significant", [0, 0, 13]),
    ("unknowns", "parameters", [1, 0, 170]),
    ("cannot tell|cannot be told", "inconclusive, not identifiable", [3, 0, 37]),
    ("may be chance|by chance", "not significant, random", [0, 0, 19]),
    ("without a name|nameless", "unmodelled", [1, 0, 17]),
    ("matters", "is material", [4, 0, 40]),
    ("nobody", "(rewrite)", [0, 0, 11]),
    ("as far as can be told|by themselves", "(rewrite)", [0, 0, 12]),
    ("leaves out|leave out|leaves small efforts out", "lacks, has a dead zone", [2, 0, 21]),
    ("in the place of|in its place|in their place", "instead of", [5, 0, 35]),
    ("kept back|kept out", "held out", [0, 0, 46]),
    ("conceal|conceals|concealed", "hidden", [6, 0, 61]),
    ("dear|seldom|likeliest", "expensive, rare, most likely", [0, 0, 26]),
    ("off by", "differs by", [1, 0, 27]),
    ("atlas", "residual map", [0, 0, 54]),
    ("hats|hat", "linear B-spline basis", [0, 0, 31]),
    ("sprung", "compliant", [0, 0, 70]),
    ("unreported", "dead zone", [0, 0, 60]),
    ("onset|onsets", "change prior", [0, 0, 65]),
    ("doubt|doubts", "uncertainty, inconclusive", [1, 0, 103]),
    ("hidden link|hidden links", "link-side motion", [0, 0, 10]),
    ("surely|how sure", "confidence", [0, 0, 12]),
    ("what else", "alternative", [0, 0, 7]),
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
