//! Elements to text.

use std::io;

use nalgebra::Vector3;
use quick_xml::Writer;
use quick_xml::events::{BytesText, Event};

/// An element with its attributes in order.
pub(crate) struct Element {
    tag: &'static str,
    attributes: Vec<(&'static str, String)>,
    children: Vec<Element>,
    /// instead of children
    text: Option<String>,
}

impl Element {
    pub(crate) fn new(tag: &'static str) -> Self {
        Self { tag, attributes: Vec::new(), children: Vec::new(), text: None }
    }

    pub(crate) fn with(mut self, name: &'static str, value: impl Into<String>) -> Self {
        self.attributes.push((name, value.into()));
        self
    }

    pub(crate) fn numbers(self, name: &'static str, values: &[f64]) -> Self {
        let list: Vec<String> = values.iter().map(|&x| number(x)).collect();
        self.with(name, list.join(" "))
    }

    pub(crate) fn vector(self, name: &'static str, v: &Vector3<f64>) -> Self {
        self.numbers(name, v.as_slice())
    }

    /// Text between the tags.
    pub(crate) fn containing(mut self, text: &str) -> Self {
        self.text = Some(text.to_owned());
        self
    }

    pub(crate) fn containing_numbers(self, values: &[f64]) -> Self {
        let list: Vec<String> = values.iter().map(|&x| number(x)).collect();
        self.containing(&list.join(" "))
    }

    pub(crate) fn children_of(&mut self, child: Option<Self>) {
        self.children.extend(child);
    }

    pub(crate) fn child(mut self, child: Self) -> Self {
        self.children.push(child);
        self
    }

    pub(crate) fn push(&mut self, child: Self) {
        self.children.push(child);
    }

    fn write(&self, writer: &mut Writer<Vec<u8>>) -> io::Result<()> {
        let attributes = self.attributes.iter().map(|(name, value)| (*name, value.as_str()));
        let element = writer.create_element(self.tag).with_attributes(attributes);
        if let Some(text) = &self.text {
            element.write_text_content(BytesText::new(text))?;
        } else if self.children.is_empty() {
            element.write_empty()?;
        } else {
            element.write_inner_content(|writer| {
                self.children.iter().try_for_each(|child| child.write(writer))
            })?;
        }
        Ok(())
    }

    /// The document: declaration, a comment per sentence, the element.
    pub(crate) fn document(&self, comments: &[String]) -> String {
        let mut writer = Writer::new_with_indent(Vec::new(), b' ', 2);
        let write = |writer: &mut Writer<Vec<u8>>| -> io::Result<()> {
            for comment in comments {
                // two hyphens end a comment
                let text = format!(" {} ", comment.replace("--", "- -"));
                writer.write_event(Event::Comment(BytesText::from_escaped(text)))?;
            }
            self.write(writer)
        };
        // writing to memory does not fail
        let _ = write(&mut writer);
        let body = String::from_utf8_lossy(&writer.into_inner()).into_owned();
        format!("<?xml version=\"1.0\"?>\n{body}\n")
    }
}

/// The shortest digits that give the number back.
pub(crate) fn number(x: f64) -> String {
    if x == 0.0 {
        "0".to_owned()
    } else if (1e-4..1e7).contains(&x.abs()) {
        x.to_string()
    } else {
        format!("{x:e}")
    }
}
