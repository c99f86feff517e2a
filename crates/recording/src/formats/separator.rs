//! Columns separated by semicolons, tabs, bars or spaces instead of commas.

/// A separator other than the comma.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Separator {
    /// none for runs of white space
    sign: Option<u8>,
    /// "semicolons", "tabs", ...
    name: &'static str,
}

/// Separators in the order in which they are looked for: spaces may be part of names.
const SEPARATORS: [Separator; 4] = [
    Separator { sign: Some(b';'), name: "semicolons" },
    Separator { sign: Some(b'\t'), name: "tabs" },
    Separator { sign: Some(b'|'), name: "vertical bars" },
    Separator { sign: None, name: "spaces" },
];

impl Separator {
    /// That of text by its first line that is not blank; none for commas, a single column or CR line ends.
    pub(super) fn of(text: &[u8]) -> Option<Self> {
        let mut lines = text.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
        let header = lines.find(|line| !line.is_empty())?;
        if header.contains(&b',') || header.contains(&b'\r') {
            return None;
        }
        let occurs = |separator: &Self| separator.fields(header).len() > 1;
        SEPARATORS.into_iter().find(occurs)
    }

    /// The same text separated by commas, line by line, and whether numbers had decimal commas. A field that holds a comma
    /// beside its decimal point is quoted.
    pub(super) fn to_commas(self, text: &[u8]) -> (Vec<u8>, bool) {
        let mut out = Vec::with_capacity(text.len());
        let mut decimal_commas = false;
        for (number, line) in text.split(|byte| *byte == b'\n').enumerate() {
            if number > 0 {
                out.push(b'\n');
            }
            let line = line.strip_suffix(b"\r").unwrap_or(line);
            for (place, field) in self.fields(line).into_iter().enumerate() {
                if place > 0 {
                    out.push(b',');
                }
                let commas = field.iter().filter(|byte| **byte == b',').count();
                if commas == 0 || field.contains(&b'"') {
                    out.extend(field);
                } else if commas == 1 && !field.contains(&b'.') {
                    decimal_commas = true;
                    out.extend(field.iter().map(|byte| if *byte == b',' { b'.' } else { *byte }));
                } else {
                    out.push(b'"');
                    out.extend(field);
                    out.push(b'"');
                }
            }
        }
        (out, decimal_commas)
    }

    /// The note on text that had it.
    pub(super) fn note(self, decimal_commas: bool) -> String {
        let decimals = if decimal_commas { ", numbers have decimal commas" } else { "" };
        format!("columns are separated by {}{decimals}", self.name)
    }

    /// Fields of a line without white space around; quotes hide the separator.
    fn fields(self, line: &[u8]) -> Vec<&[u8]> {
        let (mut fields, mut from, mut is_quoted) = (Vec::new(), 0, false);
        for (k, byte) in line.iter().enumerate() {
            is_quoted ^= *byte == b'"';
            let separates = match self.sign {
                Some(sign) => *byte == sign,
                None => matches!(*byte, b' ' | b'\t'),
            };
            if separates && !is_quoted {
                fields.push(line[from..k].trim_ascii());
                from = k + 1;
            }
        }
        fields.push(line[from..].trim_ascii());
        if self.sign.is_none() {
            fields.retain(|field| !field.is_empty());
        }
        fields
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn translated(text: &str) -> Option<(String, bool)> {
        let (bytes, decimal_commas) = Separator::of(text.as_bytes())?.to_commas(text.as_bytes());
        Some((String::from_utf8(bytes).unwrap(), decimal_commas))
    }

    #[test]
    fn other_separators_become_commas() {
        for (text, commas, decimal) in [
            ("t;a/effort\n0.1;2\n", "t,a/effort\n0.1,2\n", false),
            ("t;a/effort\r\n0,1;-2,5e-3\r\n", "t,a/effort\n0.1,-2.5e-3\n", true),
            ("t\ta b\n1\t\n", "t,a b\n1,\n", false),
            ("\n t  q_0   q_1 \n  0.1 2\t3\n", "\nt,q_0,q_1\n0.1,2,3\n", false),
            ("\"the time\" q\n1 2\n", "\"the time\",q\n1,2\n", false),
            ("t;q\n1.000,5;2\n", "t,q\n\"1.000,5\",2\n", false),
        ] {
            assert_eq!(translated(text), Some((commas.to_owned(), decimal)), "{text}");
        }
    }

    #[test]
    fn commas_and_single_columns_stay() {
        for text in ["t,a b;c\n0 1\n", "t\n0\n", "", "\n\n", "t;q\r0;1\r"] {
            assert_eq!(translated(text), None, "{text}");
        }
    }
}
