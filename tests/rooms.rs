//! The structure inside crates: which room may use which, no circles of files, one meaning a name.
//!
//! A room is a folder of `src`; the files beside the folders are the crate's face. Arrows are the `crate::`, `super::` and
//! `self::` paths of code that is not a test.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemUse, UseTree, Visibility};

use crate::shared::project;

/// Rooms of a crate in the order of the data, base first: a room may use those before it. The face is last.
const ROOMS: [(&str, &[&str]); 7] = [
    ("diagnose", &["checks", "design", "regression", "uncertainty", "selection", "findings"]),
    ("effects", &["laws"]),
    ("recording", &["mapping", "formats"]),
    (
        "ident",
        &[
            "minimal_set",
            "consistency",
            "regression",
            "estimators",
            "structure",
            "calibration",
            "checks",
            "experiment",
            "servo",
            "identify",
        ],
    ),
    ("report", &["layout", "results", "sections", "text"]),
    ("challenge", &["contract", "arms", "hidden", "cases", "score", "studies", "commands"]),
    ("motion", &["standstill", "quality"]),
];

/// Rooms whose files hold methods of statistics: each says which, and where it comes from.
const ROOMS_OF_METHODS: [&str; 3] = [
    "crates/diagnose/src/regression",
    "crates/diagnose/src/uncertainty",
    "crates/diagnose/src/selection",
];

/// Files of these rooms that hold no method: data types, and steps that only call others.
const WITHOUT_METHOD: [&str; 1] = ["crates/diagnose/src/selection/solution.rs"];

/// Public type names that two crates have. The list may only get shorter.
const IN_TWO_CRATES: [&str; 0] = [];

/// The source files of a crate: path below `src`, and what it holds.
fn sources(krate: &Path) -> BTreeMap<PathBuf, syn::File> {
    fn walk(folder: &Path, base: &Path, into: &mut BTreeMap<PathBuf, syn::File>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(&path, base, into);
            } else if path.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                let parsed = syn::parse_file(&text).unwrap_or_else(|e| panic!("{path:?}: {e}"));
                into.insert(path.strip_prefix(base).unwrap().to_owned(), parsed);
            }
        }
    }
    let mut all = BTreeMap::new();
    let base = krate.join("src");
    walk(&base, &base, &mut all);
    all
}

fn crates() -> Vec<(String, PathBuf)> {
    let mut all: Vec<_> = std::fs::read_dir(project("crates"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .map(|path| (path.file_name().unwrap().to_string_lossy().into_owned(), path))
        .collect();
    all.push((String::new(), project("")));
    all.sort();
    all
}

/// `a/b` of `a/b.rs` and of `a/b/mod.rs`; empty for the root of a crate.
fn module(file: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        file.with_extension("").iter().map(|n| n.to_string_lossy().into_owned()).collect();
    if matches!(names.last().map(String::as_str), Some("mod" | "lib" | "main")) {
        names.pop();
    }
    names
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|a| {
        a.path().is_ident("cfg") && a.parse_args::<syn::Path>().is_ok_and(|p| p.is_ident("test"))
    })
}

/// Collects the paths into the own crate.
struct Paths<'m> {
    module: &'m [String],
    found: BTreeSet<Vec<String>>,
}

impl Paths<'_> {
    fn add(&mut self, path: &[String]) {
        let mut place = match path.first().map(String::as_str) {
            Some("crate") => Vec::new(),
            Some("self" | "super") => self.module.to_vec(),
            _ => return,
        };
        for name in path {
            match name.as_str() {
                "crate" | "self" => {}
                "super" => drop(place.pop()),
                _ => place.push(name.clone()),
            }
        }
        self.found.insert(place);
    }

    fn expand(&mut self, tree: &UseTree, before: &[String]) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        match tree {
            UseTree::Path(path) => self.expand(&path.tree, &with(&path.ident)),
            UseTree::Name(name) => self.add(&with(&name.ident)),
            UseTree::Rename(rename) => self.add(&with(&rename.ident)),
            UseTree::Glob(_) => self.add(before),
            UseTree::Group(group) => group.items.iter().for_each(|t| self.expand(t, before)),
        }
    }
}

impl<'ast> Visit<'ast> for Paths<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        let attributes = match item {
            Item::Mod(module) => &module.attrs,
            Item::Fn(function) => &function.attrs,
            Item::Use(used) => &used.attrs,
            Item::Impl(block) => &block.attrs,
            _ => return visit::visit_item(self, item),
        };
        if !is_test(attributes) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        self.expand(&item.tree, &[]);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        self.add(&names);
        visit::visit_path(self, path);
    }
}

/// Arrows between the files of a crate: from, to. A file and those in the folder of its name are one thought: arrows
/// between it and them are left out.
fn arrows(files: &BTreeMap<PathBuf, syn::File>) -> BTreeSet<(PathBuf, PathBuf)> {
    let by_module: BTreeMap<Vec<String>, &PathBuf> =
        files.keys().map(|file| (module(file), file)).collect();
    let mut all = BTreeSet::new();
    for (file, parsed) in files {
        let own = module(file);
        let mut paths = Paths { module: &own, found: BTreeSet::new() };
        paths.visit_file(parsed);
        for path in paths.found {
            let target = (0..=path.len()).rev().find_map(|k| by_module.get(&path[..k]));
            let Some(target) = target else { continue };
            let other = module(target);
            if !own.starts_with(&other) && !other.starts_with(&own) {
                all.insert((file.clone(), (*target).clone()));
            }
        }
    }
    all
}

fn room(file: &Path) -> String {
    let mut names = file.iter().map(|n| n.to_string_lossy().into_owned());
    match (names.next(), names.next()) {
        (Some(folder), Some(_)) => folder,
        _ => String::new(),
    }
}

#[test]
fn no_room_uses_a_room_above_it() {
    for (name, rooms) in ROOMS {
        let files = sources(&project("crates").join(name));
        let rank = |file: &Path| {
            let room = room(file);
            // the face, and what lies beside the rooms
            rooms.iter().position(|r| *r == room).unwrap_or(rooms.len())
        };
        let found: BTreeSet<String> = files.keys().map(|f| room(f)).collect();
        for room in rooms {
            assert!(found.contains(*room), "{name} has no room {room}");
        }
        let climbing: Vec<String> = arrows(&files)
            .into_iter()
            .filter(|(from, to)| rank(to) > rank(from) && !room(from).is_empty())
            .filter(|(_, to)| !room(to).is_empty())
            .map(|(from, to)| format!("{name}: {} -> {}", from.display(), to.display()))
            .collect();
        assert!(climbing.is_empty(), "{}", climbing.join("\n"));
    }
}

#[test]
fn no_files_use_each_other_in_a_circle() {
    for (name, path) in crates() {
        let mut arrows = arrows(&sources(&path));
        // what has no arrow out is in no circle, nor what only leads there
        loop {
            let from: BTreeSet<PathBuf> = arrows.iter().map(|(from, _)| from.clone()).collect();
            let before = arrows.len();
            arrows.retain(|(_, to)| from.contains(to));
            if arrows.len() == before {
                break;
            }
        }
        // the same from the other end, so that only circles and what joins two remain
        loop {
            let to: BTreeSet<PathBuf> = arrows.iter().map(|(_, to)| to.clone()).collect();
            let before = arrows.len();
            arrows.retain(|(from, _)| to.contains(from));
            if arrows.len() == before {
                break;
            }
        }
        let circle: Vec<String> =
            arrows.iter().map(|(a, b)| format!("{} -> {}", a.display(), b.display())).collect();
        assert!(circle.is_empty(), "{name}:\n{}", circle.join("\n"));
    }
}

/// Names of types that are public in the root of each crate.
#[test]
fn no_public_type_name_means_two_things() {
    let mut of_name: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (name, path) in crates().into_iter().filter(|(name, _)| !name.is_empty()) {
        for (file, parsed) in sources(&path) {
            for item in &parsed.items {
                let (visibility, ident) = match item {
                    Item::Struct(i) => (&i.vis, &i.ident),
                    Item::Enum(i) => (&i.vis, &i.ident),
                    Item::Trait(i) => (&i.vis, &i.ident),
                    Item::Type(i) => (&i.vis, &i.ident),
                    _ => continue,
                };
                if matches!(visibility, Visibility::Public(_)) {
                    let place = format!("{name}/{}", file.display());
                    of_name.entry(ident.to_string()).or_default().insert(place);
                }
            }
        }
    }
    let in_two = |places: &BTreeSet<String>| {
        let crates: BTreeSet<&str> = places.iter().filter_map(|p| p.split('/').next()).collect();
        crates.len() > 1
    };
    let found: BTreeMap<&String, &BTreeSet<String>> =
        of_name.iter().filter(|(_, places)| in_two(places)).collect();
    let new: Vec<String> = found
        .iter()
        .filter(|(name, _)| !IN_TWO_CRATES.contains(&name.as_str()))
        .map(|(name, places)| format!("{name}: {places:?}"))
        .collect();
    assert!(new.is_empty(), "{}", new.join("\n"));
    for name in IN_TWO_CRATES {
        assert!(found.keys().any(|n| *n == name), "{name} is one thing now: take it off the list");
    }
}

#[test]
fn files_of_methods_state_method_and_source() {
    let mut lacking = Vec::new();
    for room in ROOMS_OF_METHODS {
        for entry in std::fs::read_dir(project(room)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let place = format!("{room}/{name}");
            if name == "mod.rs" || WITHOUT_METHOD.contains(&place.as_str()) {
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            let head: Vec<&str> = text.lines().take_while(|l| l.starts_with("//!")).collect();
            let states = |words: &[&str]| {
                head.iter().any(|l| words.iter().any(|w| l.starts_with(&format!("//! {w}:"))))
            };
            if !states(&["Method", "Hypothesis", "Statistic"]) || !states(&["References"]) {
                lacking.push(place);
            }
        }
    }
    assert!(lacking.is_empty(), "neither method nor source in:\n{}", lacking.join("\n"));
}
