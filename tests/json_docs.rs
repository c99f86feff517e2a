//! `docs/json.md` describes the results as their schemas do. `RENEW=1 cargo test json_docs` writes the page anew.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde_json::{Map, Value};

use crate::shared::project;

/// Fields of one object, as a table; objects that it refers to are added to `open`.
fn table(object: &Value, definitions: &Map<String, Value>, open: &mut Vec<String>) -> String {
    let mut text = String::from("| field | type | meaning |\n| --- | --- | --- |\n");
    for (name, field) in object["properties"].as_object().unwrap() {
        let kind = kind(field, definitions, open);
        let meaning = description(field, definitions);
        writeln!(text, "| `{name}` | {kind} | {meaning} |").unwrap();
    }
    text
}

/// What a field means: its own words, or else those of its type.
fn description(field: &Value, definitions: &Map<String, Value>) -> String {
    let own = field.get("description").and_then(Value::as_str);
    let of_type = || definition(field, definitions).and_then(|d| d["description"].as_str());
    let text = own.or_else(of_type).unwrap_or_default();
    // doc comments escape brackets and wrap lines
    text.replace("\\[", "[").replace("\\]", "]").split_whitespace().collect::<Vec<_>>().join(" ")
}

fn name_of(field: &Value) -> Option<&str> {
    field.get("$ref")?.as_str()?.strip_prefix("#/$defs/")
}

fn definition<'d>(field: &Value, definitions: &'d Map<String, Value>) -> Option<&'d Value> {
    definitions.get(name_of(field)?)
}

/// The type of a field in words.
fn kind(field: &Value, definitions: &Map<String, Value>, open: &mut Vec<String>) -> String {
    if let (Some(name), Some(of)) = (name_of(field), definition(field, definitions)) {
        if of.get("properties").is_none() {
            return kind(of, definitions, open);
        }
        if !open.iter().any(|known| known == name) {
            open.push(name.to_owned());
        }
        return format!("[{name}](#{})", name.to_lowercase());
    }
    for choice in ["anyOf", "oneOf"] {
        let Some(choices) = field.get(choice).and_then(Value::as_array) else { continue };
        let words: Vec<String> = choices.iter().map(|c| kind(c, definitions, open)).collect();
        return words.join(" or ");
    }
    if let Some(constant) = field.get("const").and_then(Value::as_str) {
        return format!("`{constant}`");
    }
    if let Some(all) = field.get("enum").and_then(Value::as_array) {
        let words: Vec<String> = all.iter().map(|c| format!("`{}`", c.as_str().unwrap())).collect();
        return words.join(" or ");
    }
    let types: Vec<&str> = match field.get("type") {
        Some(Value::String(one)) => vec![one],
        Some(Value::Array(some)) => some.iter().filter_map(Value::as_str).collect(),
        _ => return "any".to_owned(),
    };
    let words: Vec<String> = types
        .into_iter()
        .map(|name| match name {
            "array" => match field.get("items") {
                Some(items) => format!("list of {}", kind(items, definitions, open)),
                None => "list".to_owned(),
            },
            "object" => match field.get("additionalProperties") {
                Some(of) if of.is_object() => {
                    format!("{{name: {}}}", kind(of, definitions, open))
                }
                _ => "object".to_owned(),
            },
            "null" => "`null`".to_owned(),
            other => other.to_owned(),
        })
        .collect();
    words.join(" or ")
}

/// All fields of a result: those of the document, then those of the objects in it.
fn described(schema: &Value) -> String {
    let definitions = schema["$defs"].as_object().unwrap();
    let mut open = Vec::new();
    let mut text = table(schema, definitions, &mut open);
    let mut k = 0;
    while k < open.len() {
        let name = open[k].clone();
        let object = &definitions[&name];
        let about = object["description"].as_str().unwrap_or_default();
        let about: Vec<&str> = about.split_whitespace().collect();
        let about = about.join(" ").replace("\\[", "[").replace("\\]", "]");
        let fields = table(object, definitions, &mut open);
        write!(text, "\n### {name}\n\n{about}\n\n{fields}").unwrap();
        k += 1;
    }
    text
}

#[test]
fn page_matches_schemas() {
    let path = project("docs/json.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let schemas: BTreeMap<&str, String> = armident_report::schemas()
        .into_iter()
        .map(|(name, schema)| (name, described(schema.as_value())))
        .collect();
    let mut renewed = page.clone();
    for (name, text) in &schemas {
        let (begin, end) = (format!("<!-- fields of {name} -->\n"), "<!-- end of fields -->");
        let from = renewed.find(&begin).unwrap_or_else(|| panic!("{begin} is missing"));
        let from = from + begin.len();
        let to = from + renewed[from..].find(end).unwrap();
        renewed.replace_range(from..to, &format!("\n{text}\n"));
    }
    if std::env::var_os("RENEW").is_some() {
        std::fs::write(&path, &renewed).unwrap();
        return;
    }
    assert!(
        page == renewed,
        "docs/json.md is not what the schemas are: RENEW=1 cargo test json_docs"
    );
}
