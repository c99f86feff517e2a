//! JSON schemas of the results.

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde_json::Value;

use crate::results::{
    CheckReport, ComparisonReport, DiagnoseReport, FleetReport, IdentifyReport, ModelCard,
    ServosReport, ValidateReport,
};
use crate::section::DiagnosisSection;
use crate::sections;

/// JSON schemas of the results, each under the name that its field `schema` has.
pub fn schemas() -> Vec<(&'static str, Schema)> {
    vec![
        (IdentifyReport::SCHEMA, of::<IdentifyReport>(&[])),
        (ServosReport::SCHEMA, of::<ServosReport>(&[])),
        (CheckReport::SCHEMA, of::<CheckReport>(&[])),
        (DiagnoseReport::SCHEMA, of::<DiagnoseReport>(sections::DIAGNOSIS)),
        (ValidateReport::SCHEMA, of::<ValidateReport>(&[])),
        (ComparisonReport::SCHEMA, of::<ComparisonReport>(&[])),
        (FleetReport::SCHEMA, of::<FleetReport>(&[])),
        (ModelCard::SCHEMA, of::<ModelCard>(&[])),
    ]
}

/// The schema of a result with the data of its sections.
fn of<R: JsonSchema>(sections: &[&dyn DiagnosisSection]) -> Schema {
    let mut generator = SchemaGenerator::default();
    let mut schema = R::json_schema(&mut generator);
    for section in sections {
        let Some(data) = section.schema(&mut generator) else { continue };
        let properties = schema.get_mut("properties").and_then(Value::as_object_mut);
        if let Some(properties) = properties {
            properties.insert(section.key().to_owned(), data.to_value());
        }
    }
    schema.insert("$defs".to_owned(), Value::Object(generator.take_definitions(true)));
    schema
}
