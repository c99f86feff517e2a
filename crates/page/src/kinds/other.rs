//! Results that have no page of their own: their fields, as tables.

use serde_json::Value;

use crate::view::{Grid, Section, View, number};

/// Rows of a table at most; the whole is in the JSON that the page holds.
const ROWS: usize = 400;

pub(crate) fn view(kind: &str, document: &Value) -> View {
    let empty = serde_json::Map::new();
    let fields = document.as_object().unwrap_or(&empty);
    let robot = fields.get("robot").and_then(Value::as_str).unwrap_or(kind).to_owned();
    let mut plain = Vec::new();
    let mut sections = Vec::new();
    for (name, value) in fields {
        match value {
            Value::Array(list) if list.iter().any(Value::is_object) => {
                sections.push(section(name, objects(name, list)));
            }
            Value::Object(map) if !map.is_empty() => {
                let rows =
                    map.iter().take(ROWS).map(|(k, v)| vec![k.clone(), written(v)]).collect();
                sections
                    .push(section(name, Grid::new(name.clone(), &["name", "value"], 2).with(rows)));
            }
            _ if name == "warnings" || name == "schema" => {}
            _ => plain.push(vec![name.replace('_', " "), written(value)]),
        }
    }
    let warnings = fields.get("warnings").and_then(Value::as_array).into_iter().flatten();
    let numbers = section("result", Grid::new("Fields", &["field", "value"], 2).with(plain));
    sections.insert(0, numbers);
    View {
        kind: "Result",
        headline: format!("Result of {}", kind.replace("armident.", "armident ")),
        robot,
        warnings: warnings.filter_map(|w| Some(w.as_str()?.to_owned())).collect(),
        sections,
        ..View::default()
    }
}

fn section(name: &str, table: Grid) -> Section {
    Section::new(name.replace('_', "-"), name.replace('_', " "), Vec::new(), vec![table])
}

fn objects(name: &str, list: &[Value]) -> Grid {
    let mut header: Vec<String> = Vec::new();
    for entry in list.iter().filter_map(Value::as_object) {
        for key in entry.keys() {
            if !header.contains(key) {
                header.push(key.clone());
            }
        }
    }
    let rows = list
        .iter()
        .take(ROWS)
        .map(|entry| {
            header.iter().map(|key| entry.get(key).map_or_else(String::new, written)).collect()
        })
        .collect();
    let heads: Vec<&str> = header.iter().map(String::as_str).collect();
    Grid::new(name.replace('_', " "), &heads, heads.len()).with(rows)
}

fn written(value: &Value) -> String {
    match value {
        Value::Null => "-".to_owned(),
        Value::String(text) => text.clone(),
        Value::Number(n) if n.is_f64() => {
            n.as_f64().map_or_else(|| n.to_string(), |x| number(x, 6))
        }
        Value::Array(list) => list.iter().map(written).collect::<Vec<_>>().join(", "),
        Value::Object(map) => {
            map.iter().map(|(k, v)| format!("{k} {}", written(v))).collect::<Vec<_>>().join(", ")
        }
        other => other.to_string(),
    }
}
