//! Payloads of known mass.

use crate::layout::Block;
use crate::results::IdentifyReport;
use crate::section::Section;

/// Known payloads, and their centres of mass.
pub(crate) struct Payloads;

impl Section<IdentifyReport> for Payloads {
    fn key(&self) -> &'static str {
        "payloads"
    }

    fn text(&self, result: &IdentifyReport) -> Vec<Block> {
        let payloads = result.payloads.iter().map(|payload| {
            let [x, y, z] = payload.centre_of_mass_m;
            Block::Paragraph(format!(
                "Payload of {} kg in {}, centre of mass {} ({x:.4}, {y:.4}, {z:.4}) m",
                payload.mass_kg,
                payload.recordings.join(", "),
                if payload.is_estimated { "estimated at" } else { "at" },
            ))
        });
        payloads.collect()
    }

    fn page(&self, result: &IdentifyReport) -> Vec<Block> {
        let text = self.text(result);
        let heading = (!text.is_empty()).then(|| Block::heading("Payloads"));
        heading.into_iter().chain(text).collect()
    }
}
