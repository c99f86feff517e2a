//! Text of a model card.

use crate::layout::{Bars, render};
use crate::results::ModelCard;
use crate::sections;

impl ModelCard {
    /// Human-readable text.
    pub fn text(&self, bars: Bars) -> String {
        let serial = self.serial.as_deref().unwrap_or("not given");
        let date = self.date.as_deref().unwrap_or("not given");
        let blocks = sections::CARD.iter().flat_map(|section| section.text(self));
        format!("{}: serial number {serial}, date {date}\n{}", self.robot, render(blocks, bars))
    }
}
