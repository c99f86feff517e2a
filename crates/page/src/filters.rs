//! What the templates do with a text.

#![allow(unreachable_pub, reason = "the macro of a filter makes it public")]

use askama::filters::{Html, Safe, escape};

/// A text as HTML; what stands between two backticks is code.
#[askama::filter_fn]
pub(crate) fn coded(
    text: impl std::fmt::Display,
    _: &dyn askama::Values,
) -> askama::Result<Safe<String>> {
    Ok(Safe(code_of(&escape(text, Html)?.to_string())))
}

fn code_of(escaped: &str) -> String {
    let mut html = String::new();
    let mut rest = escaped;
    while let Some((before, (code, behind))) =
        rest.split_once('`').and_then(|(before, from)| Some((before, from.split_once('`')?)))
    {
        html += before;
        html += &format!("<code>{code}</code>");
        rest = behind;
    }
    html + rest
}

#[cfg(test)]
mod tests {
    use super::code_of;

    #[test]
    fn backticks_become_code() {
        assert_eq!(
            code_of("link `a` and `b`: a ` alone"),
            "link <code>a</code> and <code>b</code>: a ` alone"
        );
    }
}
