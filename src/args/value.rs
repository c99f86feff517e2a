//! Parsers for argument values.

use std::path::PathBuf;

use armident_commands::MotionFormat;
use armident_excitation::Part;
use armident_ident::estimators::{self, Estimator};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// The estimators of the library, by their names.
pub(super) fn estimators() -> impl TypedValueParser<Value = &'static dyn Estimator> {
    let values = estimators::ALL
        .map(|estimator| PossibleValue::new(estimator.name()).help(estimator.description()));
    PossibleValuesParser::new(values)
        .try_map(|name| estimators::by_name(&name).ok_or("there is no such estimator"))
}

pub(super) fn parse_number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err(format!("`{text}` is not a finite number")),
    }
}

pub(super) fn parse_positive(text: &str) -> Result<f64, String> {
    match parse_number(text)? {
        x if x > 0.0 => Ok(x),
        x => Err(format!("must be positive, found {x}")),
    }
}

pub(super) fn parse_probability(text: &str) -> Result<f64, String> {
    match parse_number(text)? {
        x if x > 0.0 && x < 1.0 => Ok(x),
        x => Err(format!("must be between 0 and 1, found {x}")),
    }
}

/// Parses a time such as `30` or `30s`.
pub(super) fn parse_seconds(text: &str) -> Result<f64, String> {
    parse_positive(text.trim().trim_end_matches('s'))
}

/// The parts of a suite, by their names.
pub(super) fn parts() -> impl TypedValueParser<Value = Part> {
    let values = Part::ALL.map(|part| PossibleValue::new(part.name()).help(part.purpose()));
    PossibleValuesParser::new(values).try_map(|name| {
        Part::ALL.into_iter().find(|part| part.name() == name).ok_or("there is no such part")
    })
}

pub(super) fn motion_formats() -> impl TypedValueParser<Value = MotionFormat> {
    PossibleValuesParser::new(MotionFormat::ALL.map(MotionFormat::name)).try_map(|name| {
        let mut all = MotionFormat::ALL.into_iter();
        all.find(|format| format.name() == name).ok_or("there is no such format")
    })
}

pub(super) fn parse_within(text: &str, low: f64, high: f64) -> Result<f64, String> {
    match parse_number(text)? {
        x if (low..=high).contains(&x) => Ok(x),
        x => Err(format!("must be between {low} and {high}, found {x}")),
    }
}

pub(super) fn parse_amplitude(text: &str) -> Result<f64, String> {
    parse_within(text, 1e-3, 10.0)
}

/// Parses a step bandwidth: slower steps last minutes, faster ones are impacts.
pub(super) fn parse_sigma(text: &str) -> Result<f64, String> {
    parse_within(text, 0.2, 200.0)
}

pub(super) fn parse_rate(text: &str) -> Result<f64, String> {
    parse_within(text, 10.0, 20_000.0)
}

/// Message for an unknown effect, with the nearest known name.
pub(super) fn no_effect(text: &str, more: &[&'static str]) -> String {
    /// Similarity by Jaro and Winkler, 0 to 1, which weighs the beginning.
    const SIMILAR: f64 = 0.85;
    let named = armident_effects::Library::standard().named().map(|effect| effect.slug());
    let slugs = named.chain(more.iter().copied());
    let known: Vec<&str> = slugs.collect();
    let near = known
        .iter()
        .map(|slug| (strsim::jaro_winkler(text, slug), slug))
        .filter(|(similarity, _)| *similarity > SIMILAR)
        .max_by(|a, b| a.0.total_cmp(&b.0));
    let meant = near.map_or_else(String::new, |(_, slug)| format!("; did you mean {slug}?"));
    format!("unknown effect `{text}`{meant} (known effects: {})", known.join(", "))
}

pub(super) fn parse_named_number(text: &str) -> Result<(String, f64), String> {
    let (name, value) =
        text.rsplit_once('=').ok_or_else(|| format!("expected JOINT=VALUE, found `{text}`"))?;
    Ok((name.to_owned(), parse_number(value)?))
}

pub(super) fn parse_numbers(text: &str) -> Result<Vec<f64>, String> {
    text.split(',').map(parse_number).collect()
}

pub(super) fn parse_vector(text: &str) -> Result<[f64; 3], String> {
    let numbers = parse_numbers(text)?;
    <[f64; 3]>::try_from(numbers)
        .map_err(|n| format!("expected three numbers X,Y,Z, found {}", n.len()))
}

pub(super) fn parse_pair(text: &str) -> Result<(f64, f64), String> {
    match parse_numbers(text)?[..] {
        [a, f] if a > 0.0 && f > 0.0 => Ok((a, f)),
        [_, _] => Err("amplitude and frequency must be positive".to_owned()),
        _ => Err("expected AMPLITUDE,HZ, for example 0.004,3".to_owned()),
    }
}

/// A recording with the gain of its controllers.
pub(super) fn parse_file_gain(text: &str) -> Result<(PathBuf, f64), String> {
    let (file, gain) =
        text.rsplit_once('=').ok_or_else(|| format!("expected FILE=RATIO, found `{text}`"))?;
    Ok((PathBuf::from(file), parse_positive(gain)?))
}

/// Known payload in one of the recordings, not yet validated.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PayloadArg {
    pub(crate) file: PathBuf,
    pub(crate) mass_kg: f64,
    pub(crate) com_m: Option<[f64; 3]>,
    pub(crate) com_error_m: f64,
}

pub(super) fn parse_payload(text: &str) -> Result<PayloadArg, String> {
    let form = "expected file=F,mass=KG[,com=X:Y:Z][,com_error=M], for example \
                file=heavy.csv,mass=2,com=0:0:0.05";
    let (mut file, mut mass_kg, mut com_m, mut com_error_m) = (None, None, None, 0.0);
    for part in text.split(',') {
        let (key, value) = part.split_once('=').ok_or(form)?;
        match key.trim() {
            "file" => file = Some(PathBuf::from(value)),
            "mass" => mass_kg = Some(parse_number(value)?),
            "com" => {
                let numbers: Vec<f64> =
                    value.split(':').map(parse_number).collect::<Result<_, _>>()?;
                let found = numbers.len();
                let com: [f64; 3] = numbers
                    .try_into()
                    .map_err(|_| format!("com needs three numbers X:Y:Z, found {found}"))?;
                com_m = Some(com);
            }
            "com_error" => com_error_m = parse_number(value)?,
            other => return Err(format!("unknown key `{other}`; {form}")),
        }
    }
    let (Some(file), Some(mass_kg)) = (file, mass_kg) else { return Err(form.to_owned()) };
    Ok(PayloadArg { file, mass_kg, com_m, com_error_m })
}

pub(super) fn parse_effect(text: &str) -> Result<armident_effects::EffectOnJoint, String> {
    let form = "expected EFFECT:JOINT=P1[,P2..], for example coulomb_friction:joint_2=4.5";
    let (effect, rest) = text.split_once(':').ok_or(form)?;
    let (joint, numbers) = rest.rsplit_once('=').ok_or(form)?;
    if armident_effects::effect(effect).is_none() {
        return Err(no_effect(effect, &[]));
    }
    let on_joint = armident_effects::EffectOnJoint::new(effect, joint, parse_numbers(numbers)?);
    on_joint.resolve().map_err(|e| e.to_string())?;
    Ok(on_joint)
}
