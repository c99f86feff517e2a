//! Small bars in tables.

/// Characters of a bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Bars {
    /// Blocks in eighths of a character.
    #[default]
    Unicode,
    /// For terminals that have no other characters.
    Ascii,
}

/// Characters of the whole bar.
const WIDTH: usize = 12;
const EIGHTHS: [&str; 8] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉"];

impl Bars {
    /// What is left of an error: the whole bar is the error before, the filled part the error after,
    /// which is never empty; one that grew ends in `>`. Nothing without an error before.
    ///
    /// # Examples
    /// ```
    /// use armident_report::Bars;
    /// assert_eq!(Bars::Unicode.left(4.0, 1.0), "███·········");
    /// assert_eq!(Bars::Ascii.left(4.0, 1.0), "###.........");
    /// assert_eq!(Bars::Ascii.left(1.0, 2.0), "###########>");
    /// ```
    pub fn left(self, before: f64, after: f64) -> String {
        let share = after / before;
        if !share.is_finite() || share < 0.0 {
            return String::new();
        }
        let (full, rest) = match self {
            Self::Unicode => ("█", "·"),
            Self::Ascii => ("#", "."),
        };
        if share > 1.0 {
            return full.repeat(WIDTH - 1) + ">";
        }
        let eighths = ((share * 8.0 * WIDTH as f64).round() as usize).max(1);
        let (whole, part) = match self {
            Self::Unicode => (eighths / 8, EIGHTHS[eighths % 8]),
            Self::Ascii => (eighths.div_ceil(8), ""),
        };
        let taken = whole + usize::from(!part.is_empty());
        full.repeat(whole) + part + &rest.repeat(WIDTH.saturating_sub(taken))
    }
}

#[cfg(test)]
mod tests {
    use super::{Bars, WIDTH};

    #[test]
    fn every_bar_is_as_wide() {
        for bars in [Bars::Unicode, Bars::Ascii] {
            for k in 0..=200 {
                let bar = bars.left(1.0, f64::from(k) / 100.0);
                assert_eq!(bar.chars().count(), WIDTH, "{k} {bar}");
            }
            assert_eq!(bars.left(0.0, 0.0), "");
            assert_eq!(bars.left(f64::NAN, 1.0), "");
        }
        // a little is more than nothing
        assert!(Bars::Unicode.left(1.0, 1e-6).starts_with('▏'));
        assert_eq!(Bars::Unicode.left(1.0, 1.0), "█".repeat(WIDTH));
    }
}
