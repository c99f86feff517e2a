//! Text of `armident identify`.

use crate::layout::{Bars, render, significant};
use crate::results::{ConsistencyReport, IdentifyReport};
use crate::sections;
use crate::words::counted;

impl IdentifyReport {
    /// Human-readable text.
    pub fn text(&self, bars: Bars) -> String {
        let identified = match self.method == "batch" {
            true => format!("{} parameters identified", self.parameters),
            false => format!("{} constants identified", self.constants.len()),
        };
        let low_pass = match self.cutoff_hz {
            Some(cutoff) => format!("low-pass {} Hz", significant(cutoff, 3, 0.0)),
            None => "recorded accelerations, no filter".to_owned(),
        };
        let mut text = format!(
            "{}: {identified} from {} by {}\nrank {} of {}, condition number {}, {} rows (effective sample size {} %), \
             {low_pass}\n",
            self.robot,
            counted(self.recordings.len(), "recording"),
            self.method_in_words(),
            self.rank,
            self.parameters,
            significant(self.condition, 3, 0.0),
            self.rows,
            significant(100.0 * self.effective_sample_share, 2, 0.0),
        );
        if let Some(scale) = self.prior_scale {
            text += &format!(
                "prior: URDF link inertias, prior scale {} % (disable with --prior none)\n",
                significant(100.0 * scale, 2, 0.0)
            );
        }
        if let Some(links) = &self.consistency {
            text += &format!("links: {}\n", links.text());
        }
        let blocks = sections::IDENTIFY.iter().flat_map(|section| section.text(self));
        text + &render(blocks, bars)
    }
}

impl ConsistencyReport {
    /// Whether the estimate is physically consistent, and else how far the nearest consistent links are.
    pub fn text(&self) -> String {
        if self.exact {
            return "physically consistent".to_owned();
        }
        let bound = match self.distance_at_least {
            0.0 => String::new(),
            least => format!(" (lower bound {})", significant(least, 3, 0.0)),
        };
        format!(
            "projected to the nearest physically consistent inertias, {} standard errors away{bound}",
            significant(self.distance_in_standard_errors, 3, 0.0),
        )
    }
}
