//! XML document with a `<robot>` root, and the place of each position in it.

use std::ops::Range;

use roxmltree::{Document, Node};

use crate::error::{UrdfError, UrdfPlace};

/// A text with its label and the start of each line.
pub(super) struct UrdfText<'a> {
    pub(super) text: &'a str,
    source: &'a str,
    line_starts: Vec<usize>,
}

impl<'a> UrdfText<'a> {
    pub(super) fn new(text: &'a str, source: &'a str) -> Self {
        let ends = text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n');
        let line_starts = std::iter::once(0).chain(ends.map(|(i, _)| i + 1)).collect();
        Self { text, source, line_starts }
    }

    /// Line, from 1, of a byte offset.
    pub(super) fn line_at(&self, offset: usize) -> u32 {
        let line = self.line_starts.partition_point(|&start| start <= offset);
        u32::try_from(line).unwrap_or(u32::MAX)
    }

    /// Line, from 1, on which an element starts.
    pub(super) fn line(&self, node: Node<'_, '_>) -> u32 {
        self.line_at(node.range().start)
    }

    /// The text as a whole.
    pub(super) fn whole(&self) -> Box<UrdfPlace> {
        Box::new(UrdfPlace {
            source: self.source.to_owned(),
            line: None,
            element: None,
            span: None,
        })
    }

    /// A line, with the link or joint if one is concerned.
    pub(super) fn place(&self, line: u32, element: Option<String>) -> Box<UrdfPlace> {
        Box::new(UrdfPlace {
            source: self.source.to_owned(),
            line: Some(line),
            element,
            span: None,
        })
    }

    /// An element, with the link or joint it belongs to.
    pub(super) fn place_of(&self, node: Node<'_, '_>) -> Box<UrdfPlace> {
        let mut place = self.place(self.line(node), owner(node));
        place.span = Some(tag_range(node));
        place
    }

    /// An attribute, with the link or joint it belongs to; the element if it is absent.
    pub(super) fn place_of_attribute(&self, node: Node<'_, '_>, name: &str) -> Box<UrdfPlace> {
        let range = node.attribute_node(name).map_or_else(|| tag_range(node), |a| a.range());
        let mut place = self.place(self.line_at(range.start), owner(node));
        place.span = Some(range);
        place
    }

    /// Reads the XML.
    pub(super) fn document(&self) -> Result<Document<'a>, UrdfError> {
        if self.text.trim_matches(|c: char| c.is_whitespace() || c == '\u{feff}').is_empty() {
            return Err(UrdfError::Empty { place: self.whole() });
        }
        Document::parse(self.text).map_err(|error| self.not_xml(&error))
    }

    /// Reads the XML and checks that its root is a `<robot>` without xacro.
    pub(super) fn open(&self) -> Result<Document<'a>, UrdfError> {
        let document = self.document()?;
        let root = document.root_element();
        if root.tag_name().name() != "robot" {
            let found = qualified_tag(root);
            return Err(UrdfError::NotRobot { place: self.place_of(root), found });
        }
        if let Some(node) = root.descendants().find(|&node| is_xacro(node)) {
            let found = format!("<{}>", qualified_tag(node));
            return Err(UrdfError::Xacro { place: self.place_of(node), found });
        }
        Ok(document)
    }

    fn not_xml(&self, error: &roxmltree::Error) -> UrdfError {
        use roxmltree::Error;
        let pos = error.pos();
        let mut line = pos.row;
        let mut found = error.to_string().replace(&format!(" at {pos}"), "");
        let advice = match error {
            Error::UnknownNamespace(prefix, _) if prefix == "xacro" => {
                let found = "xacro:".to_owned();
                return UrdfError::Xacro { place: self.place(line, None), found };
            }
            Error::NoRootNode => {
                found = "no element found".to_owned();
                "check that this is a URDF: it starts with `<robot name=\"...\">`".to_owned()
            }
            // these carry no position
            Error::UnclosedRootNode | Error::UnexpectedEndOfStream => {
                line = self.line_at(self.text.trim_end().len());
                found = "the text ends before the root element is closed".to_owned();
                "the file is truncated: copy or write it again".to_owned()
            }
            Error::UnexpectedCloseTag(expected, actual, _) => {
                found = format!("expected `</{expected}>`, found `</{actual}>`");
                format!("close `<{expected}>` before, or make it `<{expected} .../>`")
            }
            Error::DuplicatedAttribute(name, _) => {
                found = format!("the attribute `{name}` occurs twice in one element");
                format!("remove one `{name}`")
            }
            Error::UnknownNamespace(prefix, _) => {
                found = format!("the prefix `{prefix}:` is used but not declared");
                format!("remove what starts with `{prefix}:`, or declare `xmlns:{prefix}`")
            }
            Error::UnexpectedDeclaration(_) => {
                found = "`<?xml ...?>` after other text".to_owned();
                "move `<?xml ...?>` to the very start of the file".to_owned()
            }
            Error::UnknownToken(_) if self.text.trim_start().starts_with(['<', '\u{feff}']) => {
                found = "content outside the root element".to_owned();
                "remove everything before and after `<robot ...> ... </robot>`".to_owned()
            }
            Error::InvalidString(expected, _) => {
                found = format!("`{expected}` is missing");
                format!("add `{expected}`")
            }
            Error::InvalidChar2("a quote", actual, _) => {
                found = format!("expected a quote, found `{}`", char::from(*actual));
                "put every value in quotes, such as value=\"1\"".to_owned()
            }
            Error::InvalidComment(_) => "remove `--` inside the comment".to_owned(),
            Error::MalformedEntityReference(_) | Error::UnknownEntityReference(..) => {
                found = "`&` does not start a known character reference".to_owned();
                "write `&amp;` for the character &".to_owned()
            }
            Error::DtdDetected => {
                line = self.line_at(self.text.find("<!DOCTYPE").unwrap_or(0));
                found = "a `<!DOCTYPE>` is not supported".to_owned();
                "remove `<!DOCTYPE ...>`; an HTML page is not a URDF".to_owned()
            }
            _ if !self.text.trim_start().starts_with(['<', '\u{feff}']) => {
                found = "the text does not start with `<`".to_owned();
                "check that this is a URDF: it starts with `<robot name=\"...\">`".to_owned()
            }
            _ => "correct the XML near this line".to_owned(),
        };
        UrdfError::NotXml { place: self.place(line, None), found, advice }
    }
}

/// `<tag`, where an element starts.
fn tag_range(node: Node<'_, '_>) -> Range<usize> {
    let start = node.range().start;
    start..start + 1 + qualified_tag(node).len()
}

/// The link or joint around an element, as ``joint `elbow` ``.
fn owner(node: Node<'_, '_>) -> Option<String> {
    let tags = ["link", "joint"];
    let owner = node.ancestors().filter(|n| tags.contains(&n.tag_name().name())).last()?;
    let tag = owner.tag_name().name();
    Some(match owner.attribute("name").map(str::trim) {
        None | Some("") => format!("a {tag} without name"),
        Some(name) => format!("{tag} `{name}`"),
    })
}

/// Tag with its prefix, as written.
pub(super) fn qualified_tag(node: Node<'_, '_>) -> String {
    let name = node.tag_name();
    match name.namespace().and_then(|uri| node.lookup_prefix(uri)) {
        Some(prefix) => format!("{prefix}:{}", name.name()),
        None => name.name().to_owned(),
    }
}

/// Tag of an element that belongs to the format, that is, to the namespace of `<robot>`.
pub(super) fn urdf_tag<'a>(node: Node<'a, '_>) -> Option<&'a str> {
    let root = node.document().root_element();
    let name = node.tag_name();
    (node.is_element() && name.namespace() == root.tag_name().namespace()).then(|| name.name())
}

fn is_xacro(node: Node<'_, '_>) -> bool {
    node.tag_name().namespace().is_some_and(|uri| uri.contains("xacro"))
}

/// The first `${...}` or `$(...)` of a value.
pub(super) fn xacro_expression(value: &str) -> Option<&str> {
    let start = value.find("${").or_else(|| value.find("$("))?;
    let rest = &value[start..];
    Some(rest.find(['}', ')']).map_or(rest, |end| &rest[..=end]))
}

/// The candidate most similar to an unknown name.
pub(super) fn most_similar<'n>(
    name: &str,
    candidates: impl IntoIterator<Item = &'n str>,
) -> Option<String> {
    let candidates: Vec<String> = candidates.into_iter().map(str::to_owned).collect();
    crate::nearest(name, &candidates).map(str::to_owned)
}
