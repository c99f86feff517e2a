//! Sections: the parts a result is shown in, on a terminal and on a page.

use std::marker::PhantomData;

use armident_diagnose::Diagnosis;
use armident_kinematics::DrivingAxisChain;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::layout::Block;
use crate::results::{DiagnoseInputs, DiagnoseReport};

/// A part of a result of type `R`.
pub trait Section<R>: Sync {
    /// Key of its data in the JSON, or a name; also its anchor on the page.
    fn key(&self) -> &'static str;

    /// Its content on a terminal.
    fn text(&self, result: &R) -> Vec<Block>;

    /// Its content on a page.
    fn page(&self, result: &R) -> Vec<Block> {
        self.text(result)
    }
}

/// What the data of a section of a diagnosis is made of.
#[derive(Debug, Clone, Copy)]
pub struct Source<'a> {
    /// The chain of the given model.
    pub chain: &'a DrivingAxisChain,
    /// The diagnosis.
    pub diagnosis: &'a Diagnosis,
    /// What was diagnosed.
    pub inputs: &'a DiagnoseInputs,
}

/// A section of a diagnosis, which may have data of its own.
pub trait DiagnosisSection: Section<DiagnoseReport> {
    /// Its data, for the JSON; none where there is nothing to report, or where it is shown from fields that the
    /// result has anyway.
    fn data(&self, _: &Source<'_>) -> Option<Value> {
        None
    }

    /// Whether its data, if the result has any, is of the form it should be.
    ///
    /// # Errors
    /// Data of another form.
    fn check(&self, _: &DiagnoseReport) -> Result<(), serde_json::Error> {
        Ok(())
    }

    /// Schema of its data; none without data of its own.
    fn schema(&self, _: &mut SchemaGenerator) -> Option<Schema> {
        None
    }
}

/// Data of one section of a diagnosis, with all that is shown of it. This is all a new section needs, beside its line
/// in the list of [`crate::standard_sections`].
pub trait SectionData: Serialize + DeserializeOwned + JsonSchema + Send + Sync {
    /// Key in the JSON.
    const KEY: &'static str;
    /// Keys that older files have instead.
    const FORMER_KEYS: &'static [&'static str] = &[];

    /// From a diagnosis; none where there is nothing to report, or where the command adds it
    /// ([`DiagnoseReport::set`]).
    fn of(_: &Source<'_>) -> Option<Self> {
        None
    }

    /// Content on a terminal.
    fn text(&self, result: &DiagnoseReport) -> Vec<Block>;

    /// Content on a page.
    fn page(&self, result: &DiagnoseReport) -> Vec<Block> {
        self.text(result)
    }
}

/// The section that shows data of type `D`.
pub struct Shows<D>(PhantomData<fn() -> D>);

/// The section that shows data of type `D`, for a list of sections.
pub const fn shows<D: SectionData>() -> Shows<D> {
    Shows(PhantomData)
}

impl<D: SectionData> Section<DiagnoseReport> for Shows<D> {
    fn key(&self) -> &'static str {
        D::KEY
    }

    fn text(&self, result: &DiagnoseReport) -> Vec<Block> {
        result.section::<D>().map_or_else(Vec::new, |data| data.text(result))
    }

    fn page(&self, result: &DiagnoseReport) -> Vec<Block> {
        result.section::<D>().map_or_else(Vec::new, |data| data.page(result))
    }
}

impl<D: SectionData> DiagnosisSection for Shows<D> {
    fn data(&self, source: &Source<'_>) -> Option<Value> {
        serde_json::to_value(D::of(source)?).ok()
    }

    fn check(&self, result: &DiagnoseReport) -> Result<(), serde_json::Error> {
        keys::<D>()
            .filter_map(|key| result.more.get(key))
            .try_for_each(|data| D::deserialize(data).map(drop))
    }

    fn schema(&self, generator: &mut SchemaGenerator) -> Option<Schema> {
        Some(generator.subschema_for::<D>())
    }
}

/// The key of data, and those it had before.
fn keys<D: SectionData>() -> impl Iterator<Item = &'static str> {
    std::iter::once(D::KEY).chain(D::FORMER_KEYS.iter().copied())
}

impl DiagnoseReport {
    /// The data of a section; none where the result has none.
    pub fn section<D: SectionData>(&self) -> Option<D> {
        keys::<D>().find_map(|key| self.more.read(key))
    }

    /// Sets the data of a section.
    pub fn set<D: SectionData>(&mut self, data: &D) {
        // data of a section is plain: it can always be written
        if let Ok(value) = serde_json::to_value(data) {
            self.more.set(D::KEY, value);
        }
    }
}
