//! Figures in prose agree with the committed tables they come from.
//!
//! A figure carries an invisible marker, `<!-- fig:irls_geomean -->0.657`, whose name [`FIGURES`] maps to a table.
//! CONTRIBUTING.md lists the command that renews each table.

use std::collections::BTreeSet;
use std::path::PathBuf;

use crate::shared::project;

const REAL: &str = "docs/real-data.md";
const DIAGNOSIS: &str = "docs/studies/diagnosis.md";
const MIXED: &str = "docs/studies/challenge_mixed.md";
const CHANGE: &str = "docs/studies/challenge_change.md";
const HARD: &str = "docs/studies/challenge_hard.md";
const NULLS: &str = "docs/studies/challenge_nulls.md";
const PERTURBED: &str = "docs/studies/challenge_perturbed.md";
const COVERAGE: &str = "docs/studies/batch_coverage.md";
const COVERAGE_DRAWN: &str = "docs/studies/batch_coverage_drawn_arms.md";
const COVERAGE_WITHOUT_PRIOR: &str = "docs/studies/batch_coverage_without_prior.md";
const COVERAGE_ALGORITHM_2: &str = "docs/studies/algorithm2_coverage.md";
const COMPARISON: &str = "docs/book/src/comparison.md";

/// Error of the diagnosed model relative to plain least squares.
const RATIO: &[&str] = &["diagnosed / plain"];
/// Correct findings of a payload, and comparisons.
const RIGHT: &[&str] = &["right", "comparisons"];

/// Largest placebo term of each set.
const PLACEBO: &str = "ur10-unisa # %, panda-unisa # %, staubli-tx40 # %, tiago-arm # %, \
                       dfki-double-pendulum # %, dfki-simple-pendulum # %, bam-xl330 # %";

/// Place of a figure in its file.
enum Cell {
    /// The numbers `#` of the first text that matches the pattern; the figure is the one with this index.
    Text(&'static str, usize),
    /// The same numbers, reduced.
    Numbers(Over, &'static str),
    /// Columns of the rows whose first cells are these; an empty string matches any cell.
    Rows(Over, &'static [&'static str], &'static [&'static str]),
    /// `a of b` or `a` behind a label of a scoreboard, summed over its groups.
    Score(&'static str),
    /// The sum of `b - a` of the same.
    Missed(&'static str),
    /// The product of two figures.
    Product(&'static Cell, &'static Cell),
}

/// Reduction of a column.
enum Over {
    Only,
    Sum,
    Median,
    Least,
    Most,
    Count,
}

use Cell::{Missed, Numbers, Product, Rows, Score, Text};
use Over::{Count, Least, Median, Most, Only, Sum};

/// Name, file and place of every figure.
const FIGURES: &[(&str, &str, Cell)] = &[
    // simulated arms
    ("independent_cases", DIAGNOSIS, Rows(Sum, &[], &["cases"])),
    ("independent_found", DIAGNOSIS, Rows(Sum, &[], &["found"])),
    ("independent_false_alarms", DIAGNOSIS, Rows(Sum, &[], &["false alarms on nulls"])),
    ("mixed_cases", MIXED, Score("cases")),
    ("mixed_found", MIXED, Score("pairs: recall")),
    ("mixed_false_positives", MIXED, Missed("pairs: precision")),
    ("mixed_false_alarms", MIXED, Score("false alarms")),
    ("change_cases", CHANGE, Score("cases")),
    ("change_found", CHANGE, Score("pairs: recall")),
    ("change_false_positives", CHANGE, Missed("pairs: precision")),
    ("hard_cases", HARD, Score("cases")),
    ("hard_found", HARD, Score("recall")),
    ("hard_false_positives", HARD, Missed("precision")),
    ("hard_false_alarms", HARD, Score("false alarms")),
    ("null_cases", NULLS, Rows(Only, &["all"], &["cases"])),
    ("null_false_alarms", NULLS, Rows(Only, &["all"], &["false alarms"])),
    ("perturbed_cases", PERTURBED, Score("cases")),
    ("perturbed_found", PERTURBED, Score("pairs: recall")),
    ("perturbed_false_positives", PERTURBED, Missed("pairs: precision")),
    // estimators on real arms
    ("estimators_joints", REAL, Text("* `irls`: #, above *plain* on # of #", 2)),
    ("ols_geomean", REAL, Text("* `ols`: #,", 0)),
    ("wls_geomean", REAL, Text("* `wls`: #,", 0)),
    ("irls_geomean", REAL, Text("* `irls`: #,", 0)),
    ("iv_geomean", REAL, Text("* `iv`: #,", 0)),
    ("prior_scale_ur10", REAL, Text("* ur10-unisa: prior scale # %", 0)),
    ("prior_scale_panda", REAL, Text("* panda-unisa: prior scale # %", 0)),
    // diagnosis on real arms
    ("diagnosed_geomean", REAL, Text("Geometric mean of the ratio: **#**, median #", 0)),
    ("diagnosed_median", REAL, Text("Geometric mean of the ratio: **#**, median #", 1)),
    ("identified_geomean", REAL, Text("(`identify`: #)", 0)),
    ("splits_joints", REAL, Rows(Only, &["all", "each"], &["joints"])),
    ("splits_diagnosed", REAL, Rows(Only, &["all", "each"], &["diagnosed / plain"])),
    ("splits_diagnosed_worse", REAL, Text("| all | each | # | # (#) | # (#) |", 4)),
    ("splits_identified", REAL, Rows(Only, &["all", "each"], &["identified / plain"])),
    ("splits_identified_worse", REAL, Text("| all | each | # | # (#) | # (#) |", 2)),
    ("tx40_middle", REAL, Rows(Only, &["staubli-tx40", "middle"], RATIO)),
    ("tx40_median", REAL, Rows(Median, &["staubli-tx40"], RATIO)),
    ("tx40_best", REAL, Rows(Least, &["staubli-tx40"], RATIO)),
    ("tx40_worst", REAL, Rows(Most, &["staubli-tx40"], RATIO)),
    ("tx40_joint_5", REAL, Rows(Only, &["staubli-tx40", "joint_5"], RATIO)),
    ("tx40_joint_6", REAL, Rows(Only, &["staubli-tx40", "joint_6"], RATIO)),
    ("ur10_median", REAL, Rows(Median, &["ur10-unisa"], RATIO)),
    ("ur10_best", REAL, Rows(Least, &["ur10-unisa"], RATIO)),
    ("ur10_worst", REAL, Rows(Most, &["ur10-unisa"], RATIO)),
    ("panda_median", REAL, Rows(Median, &["panda-unisa"], RATIO)),
    ("panda_best", REAL, Rows(Least, &["panda-unisa"], RATIO)),
    ("panda_worst", REAL, Rows(Most, &["panda-unisa"], RATIO)),
    ("panda_joint_1", REAL, Rows(Only, &["panda-unisa", "panda_joint1"], RATIO)),
    ("panda_joint_2", REAL, Rows(Only, &["panda-unisa", "panda_joint2"], RATIO)),
    ("panda_joint_4", REAL, Rows(Only, &["panda-unisa", "panda_joint4"], RATIO)),
    ("tiago_median", REAL, Rows(Median, &["tiago-arm"], RATIO)),
    ("tiago_best", REAL, Rows(Least, &["tiago-arm"], RATIO)),
    ("tiago_worst", REAL, Rows(Most, &["tiago-arm"], RATIO)),
    ("double_pendulum_median", REAL, Rows(Median, &["dfki-double-pendulum"], RATIO)),
    ("simple_pendulum_median", REAL, Rows(Median, &["dfki-simple-pendulum"], RATIO)),
    ("servo_median", REAL, Rows(Median, &["bam-xl330"], RATIO)),
    ("tiago_joint_3", REAL, Rows(Only, &["tiago-arm", "arm_3_joint"], RATIO)),
    (
        "simple_pendulum_friction",
        REAL,
        Text("friction, joint1 (confidence #, confirmed): level #", 1),
    ),
    (
        "tx40_viscous_1",
        REAL,
        Text("viscous friction, joint_1 (confidence #, confirmed): coefficient #", 1),
    ),
    (
        "tx40_viscous_2",
        REAL,
        Text("viscous friction, joint_2 (confidence #, confirmed): coefficient #", 1),
    ),
    (
        "tx40_viscous_3",
        REAL,
        Text("viscous friction, joint_3 (confidence #, confirmed): coefficient #", 1),
    ),
    (
        "tx40_viscous_4",
        REAL,
        Text("viscous friction, joint_4 (confidence #, confirmed): coefficient #", 1),
    ),
    (
        "tx40_viscous_5",
        REAL,
        Text("viscous friction, joint_5 (confidence #, confirmed): coefficient #", 1),
    ),
    (
        "tx40_coulomb_1",
        REAL,
        Text("coulomb friction, joint_1 (confidence #, confirmed): level #", 1),
    ),
    (
        "tx40_coulomb_2",
        REAL,
        Text("coulomb friction, joint_2 (confidence #, confirmed): level #", 1),
    ),
    (
        "tx40_coulomb_4",
        REAL,
        Text("coulomb friction, joint_4 (confidence #, confirmed): level #", 1),
    ),
    (
        "tx40_coulomb_5",
        REAL,
        Text("coulomb friction, joint_5 (confidence #, confirmed): level #", 1),
    ),
    ("tx40_coupling_coulomb", REAL, Text("(confidence #, confirmed): coulomb #", 1)),
    ("tx40_coupling_viscous", REAL, Text(" N m, ratio # +- #, viscous #", 2)),
    ("tx40_ratio", REAL, Text("ratio # +- #,", 0)),
    ("tx40_ratio_se", REAL, Text("ratio # +- #,", 1)),
    ("placebo_median", REAL, Numbers(Median, PLACEBO)),
    ("placebo_worst", REAL, Numbers(Most, PLACEBO)),
    // changes on real arms
    ("change_ur10_1", REAL, Rows(Only, &["ur10-unisa", "thirds", "1", "wrist_3_link"], RIGHT)),
    ("change_ur10_3", REAL, Rows(Only, &["ur10-unisa", "thirds", "3", "wrist_3_link"], RIGHT)),
    ("change_panda_05", REAL, Rows(Only, &["panda-unisa", "thirds", "0.5"], RIGHT)),
    ("change_tx40_1", REAL, Rows(Only, &["staubli-tx40", "thirds", "1", "link_6"], RIGHT)),
    ("change_tx40_3", REAL, Rows(Only, &["staubli-tx40", "thirds", "3", "link_6"], RIGHT)),
    ("change_tx40_link_3", REAL, Rows(Only, &["staubli-tx40", "thirds", "4", "link_3"], RIGHT)),
    (
        "change_tx40_link_3_alternative",
        REAL,
        Rows(Only, &["staubli-tx40", "thirds", "4", "link_3"], &["as alternative"]),
    ),
    ("change_tiago_1", REAL, Rows(Only, &["tiago-arm", "thirds", "1"], RIGHT)),
    (
        "change_pendulum_003",
        REAL,
        Rows(Only, &["dfki-double-pendulum", "thirds", "0.03"], &["right"]),
    ),
    ("change_false_names", REAL, Rows(Sum, &["", "", "0"], &["other findings"])),
    // comparison with other tools
    ("by_hand_pan", COMPARISON, Rows(Only, &["Pinocchio and NumPy"], &["shoulder_pan"])),
    ("by_hand_lift", COMPARISON, Rows(Only, &["Pinocchio and NumPy"], &["shoulder_lift"])),
    ("by_hand_elbow", COMPARISON, Rows(Only, &["Pinocchio and NumPy"], &["elbow"])),
    ("by_hand_wrist_1", COMPARISON, Rows(Only, &["Pinocchio and NumPy"], &["wrist_1"])),
    ("by_hand_wrist_2", COMPARISON, Rows(Only, &["Pinocchio and NumPy"], &["wrist_2"])),
    ("by_hand_wrist_3", COMPARISON, Rows(Only, &["Pinocchio and NumPy"], &["wrist_3"])),
    // coverage of intervals
    ("coverage_drawn", COVERAGE_DRAWN, Text("parameters: **# %**", 0)),
    ("coverage_drawn_lowest", COVERAGE_DRAWN, Rows(Least, &[], &["inside"])),
    ("coverage_drawn_highest", COVERAGE_DRAWN, Rows(Most, &[], &["inside"])),
    (
        "coverage_drawn_count",
        COVERAGE_DRAWN,
        Product(&Text("# recordings of", 0), &Rows(Count, &[], &["inside"])),
    ),
    ("coverage_without_prior", COVERAGE_WITHOUT_PRIOR, Text("parameters: **# %**", 0)),
    ("coverage_right_urdf", COVERAGE, Text("parameters: **# %**", 0)),
    ("coverage_algorithm2", COVERAGE_ALGORITHM_2, Text("seeds: # % inside", 0)),
    (
        "coverage_algorithm2_count",
        COVERAGE_ALGORITHM_2,
        Product(&Text("coverage_algorithm2 -- # ", 0), &Rows(Count, &[], &["true value"])),
    ),
];

/// Pages in which every decimal number carries a marker, except these: versions, and figures of no committed table.
const UNMARKED: &[(&str, &[&str])] = &[
    ("README.md", &["1.95", "2.0", "7.3"]),
    ("docs/book/src/estimators.md", &["0.001", "0.0003", "0.13", "0.04", "0.11"]),
    ("docs/book/src/case-studies.md", &["0.5", "3.8", "4.0"]),
];

/// Pages that may contain markers.
fn pages() -> Vec<PathBuf> {
    let mut pages = vec![project("README.md")];
    for folder in ["docs/book/src", "docs/studies", "docs"] {
        let entries =
            std::fs::read_dir(project(folder)).unwrap().map(|entry| entry.unwrap().path());
        pages.extend(entries.filter(|path| path.extension().is_some_and(|end| end == "md")));
    }
    pages.sort();
    pages
}

/// The number at the start of a text, and its length. Thousands may be separated by a space: `11 600`.
fn leading_number(text: &str) -> Option<(f64, usize)> {
    let bytes = text.as_bytes();
    let digit = |k: usize| bytes.get(k).is_some_and(u8::is_ascii_digit);
    let sign = usize::from(matches!(bytes.first(), Some(b'-' | b'+')));
    let mut end = sign;
    while digit(end)
        || (end > sign
            && bytes.get(end) == Some(&b' ')
            && (1..4).all(|k| digit(end + k))
            && !digit(end + 4))
    {
        end += 1;
    }
    if end == sign {
        return None;
    }
    if bytes.get(end) == Some(&b'.') && digit(end + 1) {
        end += 1;
        while digit(end) {
            end += 1;
        }
    }
    let number = text[..end].replace(' ', "").parse().ok()?;
    Some((number, end))
}

/// The numbers of `a of b`, or of `a`.
fn leading_pair(text: &str) -> Vec<f64> {
    let Some((first, end)) = leading_number(text) else { return Vec::new() };
    let second = text[end..].strip_prefix(" of ").and_then(leading_number);
    std::iter::once(first).chain(second.map(|(number, _)| number)).collect()
}

/// The numbers at the places `#` of the first match of a pattern.
fn matched(text: &str, pattern: &str) -> Option<Vec<f64>> {
    let parts: Vec<&str> = pattern.split('#').collect();
    let (first, others) = parts.split_first()?;
    let from_start = |start: usize| {
        let mut rest = &text[start + first.len()..];
        let mut numbers = Vec::new();
        for part in others {
            let (number, end) = leading_number(rest)?;
            numbers.push(number);
            rest = rest[end..].strip_prefix(part)?;
        }
        Some(numbers)
    };
    match first.is_empty() {
        true => text.char_indices().find_map(|(start, _)| from_start(start)),
        false => text.match_indices(first).find_map(|(start, _)| from_start(start)),
    }
}

/// The tables of a page: rows of cells, the first is the heading.
fn tables(text: &str) -> Vec<Vec<Vec<&str>>> {
    let mut tables = vec![Vec::new()];
    for line in text.lines() {
        match line.strip_prefix('|') {
            Some(row) if row.trim_start().starts_with("---") || row.starts_with("--") => {}
            Some(row) => {
                let cells =
                    row.trim_end().trim_end_matches('|').split('|').map(str::trim).collect();
                tables.last_mut().unwrap().push(cells);
            }
            None => tables.push(Vec::new()),
        }
    }
    tables.retain(|table| table.len() > 1);
    tables
}

/// Values of the columns in the rows that match, of the first table that has both.
fn rows(text: &str, cells: &[&str], columns: &[&str]) -> Vec<Vec<f64>> {
    for table in tables(text) {
        let (heading, body) = table.split_first().unwrap();
        let indices: Vec<usize> =
            columns.iter().filter_map(|column| heading.iter().position(|h| h == column)).collect();
        if indices.len() < columns.len() {
            continue;
        }
        let is_wanted = |row: &&Vec<&str>| {
            row.len() >= cells.len()
                && cells
                    .iter()
                    .zip(row.iter())
                    .all(|(cell, found)| cell.is_empty() || cell == found)
        };
        let values: Vec<Vec<f64>> = body
            .iter()
            .filter(is_wanted)
            .map(|row| indices.iter().flat_map(|&k| leading_pair(row[k])).collect())
            .filter(|values: &Vec<f64>| !values.is_empty())
            .collect();
        if !values.is_empty() {
            return values;
        }
    }
    Vec::new()
}

/// `a of b` or `a` of every line of a scoreboard with this label.
fn scores(text: &str, label: &str) -> Vec<Vec<f64>> {
    let values = text.lines().filter_map(|line| {
        Some(leading_pair(line.strip_prefix(label)?.strip_prefix("  ")?.trim_start()))
    });
    values.filter(|values| !values.is_empty()).collect()
}

fn sums(values: &[Vec<f64>]) -> Vec<f64> {
    let width = values.first().map_or(0, Vec::len);
    (0..width).map(|k| values.iter().map(|row| row[k]).sum()).collect()
}

fn reduced(over: &Over, values: &[Vec<f64>]) -> Option<Vec<f64>> {
    let mut column: Vec<f64> = values.iter().filter_map(|row| row.first().copied()).collect();
    column.sort_by(f64::total_cmp);
    let middle = column.len() / 2;
    Some(match over {
        Only if values.len() == 1 => values[0].clone(),
        Only => return None,
        Sum => sums(values),
        Median if column.len() % 2 == 1 => vec![column[middle]],
        Median => vec![f64::midpoint(*column.get(middle.checked_sub(1)?)?, column[middle])],
        Least => vec![*column.first()?],
        Most => vec![*column.last()?],
        Count => vec![column.len() as f64],
    })
}

/// The value of a figure in the text of its file: one number, or `a` and `b` of `a of b`.
fn value(text: &str, cell: &Cell) -> Option<Vec<f64>> {
    match cell {
        Text(pattern, index) => matched(text, pattern)?.get(*index).map(|number| vec![*number]),
        Numbers(over, pattern) => {
            let numbers: Vec<Vec<f64>> =
                matched(text, pattern)?.into_iter().map(|n| vec![n]).collect();
            reduced(over, &numbers)
        }
        Rows(over, cells, columns) => reduced(over, &rows(text, cells, columns)),
        Score(label) => Some(sums(&scores(text, label))),
        Missed(label) => match sums(&scores(text, label))[..] {
            [right, all] => Some(vec![all - right]),
            _ => None,
        },
        Product(a, b) => Some(vec![value(text, a)?.first()? * value(text, b)?.first()?]),
    }
    .filter(|values| !values.is_empty())
}

/// Decimals of the number at the start of a text.
fn decimals(text: &str) -> i32 {
    let Some((_, end)) = leading_number(text) else { return 0 };
    text[..end].split_once('.').map_or(0, |(_, decimals)| decimals.len() as i32)
}

/// Why a marked figure differs from its table; `None` if it agrees to its last digit.
fn difference(name: &str, prose: &str) -> Option<String> {
    let Some((_, file, cell)) = FIGURES.iter().find(|figure| figure.0 == name) else {
        return Some("not in FIGURES".to_owned());
    };
    let Some(expected) = value(&std::fs::read_to_string(project(file)).unwrap(), cell) else {
        return Some(format!("not found in {file}"));
    };
    let found: Vec<f64> = leading_pair(prose).into_iter().take(expected.len()).collect();
    let tolerance = 0.5 * 10_f64.powi(-decimals(prose)) + 1e-9;
    let agrees = found.len() == expected.len()
        && found.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= tolerance);
    (!agrees).then(|| format!("{found:?}, but {expected:?} in {file}"))
}

#[test]
fn marked_figures_agree_with_their_tables() {
    let mut used = BTreeSet::new();
    let mut wrong = Vec::new();
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        for marked in text.split("<!-- fig:").skip(1) {
            let (name, prose) = marked.split_once(" -->").unwrap();
            used.insert(name.to_owned());
            if let Some(difference) = difference(name, prose) {
                wrong.push(format!("{}: {name}: {difference}", page.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let unused: Vec<&str> =
        FIGURES.iter().map(|figure| figure.0).filter(|name| !used.contains(*name)).collect();
    assert!(unused.is_empty(), "figures without a marker: {unused:?}");
}

/// A page without its code.
pub(crate) fn without_code(text: &str) -> String {
    let mut prose = String::new();
    let mut in_block = false;
    for line in text.lines() {
        if line.starts_with("```") {
            in_block = !in_block;
        } else if !in_block {
            for (k, part) in line.split('`').enumerate() {
                prose.push_str(if k % 2 == 0 { part } else { " " });
            }
            prose.push('\n');
        }
    }
    prose
}

/// Decimal numbers in prose that follow no marker.
fn unmarked_decimals(prose: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut at = 0;
    while at < prose.len() {
        let rest = &prose[at..];
        let Some((_, length)) = leading_number(rest).filter(|_| !rest.starts_with(['-', '+']))
        else {
            at += rest.chars().next().map_or(1, char::len_utf8);
            continue;
        };
        let number = &rest[..length];
        if number.contains('.') && !prose[..at].trim_end().ends_with("-->") {
            found.push(number.to_owned());
        }
        at += length;
    }
    found
}

#[test]
fn decimal_figures_carry_a_marker() {
    for (page, exceptions) in UNMARKED {
        let prose = without_code(&std::fs::read_to_string(project(page)).unwrap());
        for number in unmarked_decimals(&prose) {
            assert!(
                exceptions.contains(&number.as_str()),
                "{page}: mark {number} with the figure of its table, or list it in UNMARKED"
            );
        }
    }
}

#[test]
fn renewed_table_fails_its_figures() {
    let text = "| set | load | right | comparisons |\n| --- | ---: | ---: | ---: |\n| a | 1 | 4 | 9 |\n\
                | a | 3 | 9 | 9 |\n| b | 1 | left out | 9 |\n\npairs: recall   10 of 12 (83 %)\n\
                pairs: recall   12 of 12 (100 %)\n* `ols`: 0.664, above *plain* on 3 of 27\n";
    let of = |cell: Cell| value(text, &cell);
    assert_eq!(of(Rows(Only, &["a", "1"], &["right", "comparisons"])), Some(vec![4.0, 9.0]));
    assert_eq!(of(Rows(Sum, &["", "1"], &["comparisons"])), Some(vec![18.0]));
    assert_eq!(of(Rows(Only, &["c"], &["right"])), None);
    assert_eq!(of(Rows(Median, &["a"], &["right"])), Some(vec![6.5]));
    assert_eq!(of(Score("pairs: recall")), Some(vec![22.0, 24.0]));
    assert_eq!(of(Missed("pairs: recall")), Some(vec![2.0]));
    assert_eq!(of(Text("* `ols`: #, above *plain* on # of #", 2)), Some(vec![27.0]));
    assert_eq!(leading_pair("11 600 cases"), [11600.0]);
    assert_eq!(unmarked_decimals("<!-- fig:a -->0.5 and 0.6, 7"), ["0.6"]);
}
