//! Compares the file with the table of the format, element by element.

use roxmltree::Node;

use super::format::{AttributeRule, Count, ElementRule, Form, JOINT_TYPES, Reader};
use super::notes::{Concerned, Notes};
use super::xml::{UrdfText, most_similar, qualified_tag, urdf_tag, xacro_expression};
use crate::error::UrdfError;

/// Checks one element and all inside it that is read.
///
/// What is not part of the format is noted under `owner`, the link or joint around it.
pub(super) fn check_element(
    text: &UrdfText<'_>,
    node: Node<'_, '_>,
    rule: &'static ElementRule,
    owner: &Concerned,
    notes: &mut Notes,
) -> Result<(), UrdfError> {
    let unknown = unknown_attributes(node, rule);
    for attribute in rule.attributes {
        match node.attribute(attribute.name) {
            Some(value) => check_value(text, node, rule, attribute, value)?,
            None if attribute.required => {
                return Err(UrdfError::MissingAttribute {
                    place: text.place_of(node),
                    tag: rule.tag,
                    attribute: attribute.name,
                    expected: attribute.form.expected(),
                    similar: most_similar(attribute.name, unknown.iter().copied()),
                });
            }
            None => {}
        }
    }
    let absent = || rule.attributes.iter().map(|a| a.name).filter(|&a| !node.has_attribute(a));
    let mut note = |sentence: String| {
        notes.add("element-ignored", at_line(owner, text.line(node)), sentence);
    };
    let mut foreign = Vec::new();
    for &name in &unknown {
        match most_similar(name, absent()) {
            Some(meant) => note(format!(
                "ignored attribute `{name}` of `<{}>`; did you mean `{meant}`?",
                rule.tag
            )),
            None => foreign.push(format!("`{name}`")),
        }
    }
    match foreign.len() {
        0 => {}
        1 => note(format!("ignored attribute {} of `<{}>`", foreign[0], rule.tag)),
        _ => note(format!("ignored attributes {} of `<{}>`", foreign.join(", "), rule.tag)),
    }
    check_children(text, node, rule, owner, notes)
}

fn check_children(
    text: &UrdfText<'_>,
    node: Node<'_, '_>,
    rule: &'static ElementRule,
    owner: &Concerned,
    notes: &mut Notes,
) -> Result<(), UrdfError> {
    let mut seen: Vec<Option<u32>> = vec![None; rule.children.len()];
    let mut unknown: Vec<(String, u32)> = Vec::new();
    for child in node.children().filter(Node::is_element) {
        let line = text.line(child);
        let known = urdf_tag(child).and_then(|tag| rule.children.iter().position(|c| c.tag == tag));
        let Some(index) = known else {
            unknown.push((qualified_tag(child), line));
            continue;
        };
        let child_rule = &rule.children[index];
        if let (Some(first), true) = (seen[index], child_rule.count != Count::Many) {
            return Err(UrdfError::RepeatedElement {
                place: text.place_of(child),
                parent: rule.tag,
                tag: child_rule.tag,
                first,
            });
        }
        seen[index].get_or_insert(line);
        if child_rule.reader != Reader::Nobody {
            check_element(text, child, child_rule, owner, notes)?;
        }
    }
    let absent = || rule.children.iter().zip(&seen).filter(|(_, s)| s.is_none()).map(|(c, _)| c);
    if let Some(missing) = absent().find(|c| c.count == Count::Required) {
        let tags = unknown.iter().map(|(tag, _)| tag.as_str());
        return Err(UrdfError::MissingElement {
            place: text.place_of(node),
            parent: rule.tag,
            tag: missing.tag,
            similar: most_similar(missing.tag, tags),
        });
    }
    for (tag, line) in unknown {
        let meant = most_similar(&tag, absent().map(|c| c.tag))
            .map_or_else(String::new, |meant| format!("; did you mean `<{meant}>`?"));
        let sentence = format!("ignored `<{tag}>` in `<{}>`{meant}", rule.tag);
        notes.add("element-ignored", at_line(owner, line), sentence);
    }
    Ok(())
}

fn at_line(owner: &Concerned, line: u32) -> Concerned {
    Concerned { line, ..owner.clone() }
}

fn unknown_attributes<'a>(node: Node<'a, '_>, rule: &ElementRule) -> Vec<&'a str> {
    let known = |name: &str| rule.attributes.iter().any(|a| a.name == name);
    let foreign = |a: &roxmltree::Attribute<'_, '_>| a.namespace().is_some();
    node.attributes().filter(|a| foreign(a) || !known(a.name())).map(|a| a.name()).collect()
}

fn check_value(
    text: &UrdfText<'_>,
    node: Node<'_, '_>,
    rule: &'static ElementRule,
    attribute: &'static AttributeRule,
    value: &str,
) -> Result<(), UrdfError> {
    let place = || text.place_of_attribute(node, attribute.name);
    if let Some(expression) = xacro_expression(value) {
        return Err(UrdfError::Xacro { place: place(), found: expression.to_owned() });
    }
    let Some(advice) = fault(attribute.form, value, rule.tag) else { return Ok(()) };
    Err(UrdfError::BadValue {
        place: place(),
        tag: rule.tag,
        attribute: attribute.name,
        expected: attribute.form.expected(),
        found: value.to_owned(),
        advice,
    })
}

/// Hint for a malformed value; `None` if it is well-formed.
fn fault(form: Form, value: &str, tag: &str) -> Option<String> {
    match form {
        Form::Text => None,
        Form::Name if value.trim().is_empty() => Some("add a name".to_owned()),
        Form::Name => None,
        Form::JointType if JOINT_TYPES.contains(&value) => None,
        Form::JointType if value == "spherical" => {
            Some("describe a ball joint as three revolute joints in a row".to_owned())
        }
        Form::JointType => Some(most_similar(value, JOINT_TYPES).map_or_else(
            || "use revolute for a rotation with limits, fixed if nothing moves".to_owned(),
            |near| format!("did you mean `{near}`?"),
        )),
        Form::Number | Form::NotNegative | Form::Numbers(_) => number_fault(form, value, tag),
    }
}

fn number_fault(form: Form, value: &str, tag: &str) -> Option<String> {
    let words: Vec<&str> = value.split_whitespace().collect();
    let (count, counted) = match form {
        Form::Numbers(count) => (count, form.expected()),
        _ => (1, "one number"),
    };
    let is_finite = |word: &&&str| word.parse::<f64>().is_ok_and(f64::is_finite);
    if let Some(word) = words.iter().find(|word| !is_finite(word)) {
        return Some(match word.parse::<f64>() {
            Ok(_) if tag == "limit" => "omit the attribute for no limit".to_owned(),
            Ok(_) => "use a finite number".to_owned(),
            Err(_) if word.contains(',') => {
                "use decimal points, and spaces between numbers, no commas".to_owned()
            }
            Err(_) if word.contains("pi") => {
                "write the number out, such as 3.141592653589793 for pi".to_owned()
            }
            Err(_) => format!("`{word}` is not a number"),
        });
    }
    match words.len() {
        0 => Some(format!("empty; write {counted}")),
        n if n != count => Some(format!("write {counted}, found {n}")),
        _ if form == Form::NotNegative && numbers::<1>(value)?[0] < 0.0 => {
            Some("check the sign".to_owned())
        }
        _ => None,
    }
}

/// The `N` numbers of a checked value.
pub(super) fn numbers<const N: usize>(value: &str) -> Option<[f64; N]> {
    let mut result = [0.0; N];
    let mut words = value.split_whitespace();
    for slot in &mut result {
        *slot = words.next()?.parse().ok()?;
    }
    words.next().is_none().then_some(result)
}

/// One number of a checked element.
pub(super) fn number(node: Node<'_, '_>, attribute: &str) -> Option<f64> {
    numbers::<1>(node.attribute(attribute)?).map(|[value]| value)
}

/// Writes the input of `urdf-rs`: only elements of the table, so that meshes, materials and
/// extensions cannot cause errors.
pub(super) fn write_element(out: &mut String, node: Node<'_, '_>, rule: &ElementRule) {
    out.push('<');
    out.push_str(rule.tag);
    // orientations by quaternion are converted here
    for attribute in rule.attributes.iter().filter(|a| a.form != Form::Numbers(4)) {
        if let Some(value) = node.attribute(attribute.name) {
            out.push(' ');
            out.push_str(attribute.name);
            out.push_str("=\"");
            escape_into(out, value);
            out.push('"');
        }
    }
    out.push('>');
    for child in node.children() {
        let known = |c: &&ElementRule| Some(c.tag) == urdf_tag(child);
        if let Some(rule) = rule.children.iter().filter(|c| c.reader == Reader::UrdfRs).find(known)
        {
            write_element(out, child, rule);
        }
    }
    out.push_str("</");
    out.push_str(rule.tag);
    out.push('>');
}

fn escape_into(out: &mut String, value: &str) {
    for c in value.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
}
