//! Packing for the page: gzip in base 64, which browsers unpack by themselves.

use std::io::Write;

use base64::Engine;
use flate2::{Compression, write::GzEncoder};

/// The text, packed.
pub(crate) fn packed(text: &str) -> std::io::Result<String> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::new(7));
    encoder.write_all(text.as_bytes())?;
    Ok(base64::engine::general_purpose::STANDARD.encode(encoder.finish()?))
}

/// plotly.js, the first of the scripts that the crate embeds; the second, MathJax, is not used.
pub(crate) fn library() -> String {
    let sources = plotly::Plot::offline_js_sources();
    let script = sources.split("</script>").next().unwrap_or_default();
    script.split_once('>').map_or(script, |(_, code)| code).to_owned()
}

/// JSON that may stand in a script element: nothing in it ends the element.
pub(crate) fn in_script(json: &str) -> String {
    json.replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_library_is_whole_and_alone() {
        let library = library();
        assert!(library.trim_start().starts_with("/**\n* plotly.js v"), "{}", &library[..40]);
        assert!(library.len() > 4_000_000, "{}", library.len());
        assert!(!library.contains("<script"), "two scripts");
        assert!(
            library.trim_end().ends_with("));")
                || library.trim_end().ends_with(");")
                || library.trim_end().ends_with("})"),
            "{}",
            &library[library.len() - 60..]
        );
    }

    #[test]
    fn nothing_ends_the_script() {
        assert_eq!(in_script(r#"{"a":"</script>"}"#), r#"{"a":"\u003c/script>"}"#);
    }
}
