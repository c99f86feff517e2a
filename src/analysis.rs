//! `armident.toml`: an analysis as a list of steps, each a command with its options.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use armident_commands::{Excerpt, Failure};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, CommandFactory, Parser};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::args::{Cli, Command};

/// Commands that cannot be a step of an analysis.
const NO_STEPS: [&str; 5] = ["run", "completions", "man", "help", "demo"];
/// The list of all commands, as owner of an unknown name.
const COMMANDS: &str = "the commands";

/// One step of the file.
pub(crate) struct Step {
    /// `name` of the step, or else its command.
    pub(crate) name: String,
    /// The step as a command line.
    pub(crate) argv: Vec<String>,
    /// The parsed command line.
    pub(crate) command: Command,
}

/// A file of steps.
pub(crate) struct Analysis {
    path: PathBuf,
    text: String,
}

type Value<'a> = Spanned<DeValue<'a>>;
type Keys<'a> = BTreeMap<String, (Range<usize>, &'a Value<'a>)>;

impl Analysis {
    /// Reads the text.
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        let text = std::fs::read_to_string(path).map_err(|error| {
            let what = match error.kind() {
                std::io::ErrorKind::NotFound => "the file does not exist".to_owned(),
                _ => format!("cannot read: {error}"),
            };
            Failure::new(
                what,
                path.display(),
                Some("create it; `armident run --help` shows an example"),
            )
        })?;
        Ok(Self { path: path.to_owned(), text })
    }

    /// All steps, validated before the first one runs.
    pub(crate) fn steps(&self) -> Result<Vec<Step>, Failure> {
        let file = DeTable::parse(&self.text).map_err(|error| {
            let said = error.message().lines().next().unwrap_or_default().to_owned();
            let span = error.span().unwrap_or(0..0);
            self.fault(&span, "", format!("invalid TOML: {said}"), "correct the line")
        })?;
        let file = file.get_ref();
        let known = ["defaults", "step"];
        for key in file.keys() {
            if !known.contains(&key.get_ref().as_ref()) {
                let names = known.map(str::to_owned);
                return Err(self.unknown(
                    &key.span(),
                    "",
                    key.get_ref(),
                    "the analysis file",
                    &names,
                ));
            }
        }
        let defaults = match file.get("defaults") {
            Some(value) => self.keys(value, "[defaults]")?,
            None => Keys::new(),
        };
        let commands = step_commands();
        self.check_defaults(&defaults, &commands)?;
        let steps = match file.get("step").map(|steps| (steps.span(), steps.get_ref())) {
            Some((_, DeValue::Array(steps))) => steps.iter().collect::<Vec<_>>(),
            Some((span, _)) => {
                let advice = "write [[step]] in double brackets";
                return Err(self.fault(&span, "", "`step` must be an array of tables", advice));
            }
            None => Vec::new(),
        };
        if steps.is_empty() {
            let advice =
                "add [[step]] with command = \"identify\", robot = \"..\", recordings = [\"..\"]";
            return Err(self.fault(&(0..0), "", "missing [[step]]", advice));
        }
        let read = |(k, step)| self.step(k, step, &defaults, &commands);
        steps.into_iter().enumerate().map(read).collect()
    }

    fn step(
        &self,
        k: usize,
        value: &Value<'_>,
        defaults: &Keys<'_>,
        commands: &[clap::Command],
    ) -> Result<Step, Failure> {
        let mut place = format!("step {}", k + 1);
        let mut keys = self.keys(value, "[[step]]")?;
        let Some((_, given)) = keys.remove("command") else {
            let advice = format!("add command = \"identify\"; valid commands: {}", names(commands));
            return Err(self.fault(&value.span(), &place, "the step has no `command`", advice));
        };
        let name = self.text_of(given, "command", &place)?;
        let Some(command) = commands.iter().find(|c| c.get_name() == name) else {
            let known: Vec<String> = commands.iter().map(|c| c.get_name().to_owned()).collect();
            return Err(self.unknown(&given.span(), &place, &name, COMMANDS, &known));
        };
        place = format!("{place} ({name})");
        let title = match keys.remove("name") {
            Some((_, value)) => self.text_of(value, "name", &place)?,
            None => name.clone(),
        };
        let options: Vec<(String, &Arg)> = options(command);
        for (key, (span, _)) in &keys {
            if !options.iter().any(|(known, _)| known == key) {
                let known: Vec<String> = options.iter().map(|(name, _)| name.clone()).collect();
                let whose = format!("`armident {name}`");
                return Err(self.unknown(span, &place, key, &whose, &known));
            }
        }
        let mut argv = vec!["armident".to_owned(), name];
        let mut optional = Vec::new();
        for (key, arg) in &options {
            let Some((_, value)) = keys.get(key).or_else(|| defaults.get(key)) else { continue };
            let words = self.words(key, arg, value, &place)?;
            if arg.is_positional() { argv.extend(words) } else { optional.extend(words) }
        }
        argv.extend(optional);
        match Cli::try_parse_from(&argv) {
            Ok(cli) => Ok(Step { name: title, argv, command: cli.command }),
            Err(error) => Err(self.refused(&error, value, &keys, defaults, &place)),
        }
    }

    /// Rejects defaults that no command has.
    fn check_defaults(
        &self,
        defaults: &Keys<'_>,
        commands: &[clap::Command],
    ) -> Result<(), Failure> {
        let mut known: Vec<String> =
            commands.iter().flat_map(options).map(|(name, _)| name).collect();
        known.sort();
        known.dedup();
        match defaults.iter().find(|(key, _)| !known.contains(key)) {
            Some((key, (span, _))) => {
                Err(self.unknown(span, "[defaults]", key, "any command", &known))
            }
            None => Ok(()),
        }
    }

    /// Words of the command line for one key.
    fn words(
        &self,
        key: &str,
        arg: &Arg,
        value: &Value<'_>,
        place: &str,
    ) -> Result<Vec<String>, Failure> {
        let span = value.span();
        let switch = matches!(arg.get_action(), ArgAction::SetTrue);
        let many = matches!(arg.get_action(), ArgAction::Append)
            || arg.get_num_args().is_some_and(|n| n.max_values() > 1);
        let one = |value: &Value<'_>| {
            scalar(value.get_ref()).ok_or_else(|| {
                let advice = "write a quoted string or a number";
                self.fault(&value.span(), place, format!("invalid value for `{key}`"), advice)
            })
        };
        let values: Vec<String> = match value.get_ref() {
            DeValue::Boolean(given) if switch => {
                return Ok(if *given { vec![format!("--{key}")] } else { Vec::new() });
            }
            _ if switch => {
                let what = format!("`{key}` must be true or false");
                return Err(self.fault(&span, place, what, "remove the quotation marks"));
            }
            DeValue::Array(values) => {
                let mut texts = Vec::new();
                for value in values {
                    texts.push(match value.get_ref().as_table() {
                        Some(table) => parts(table).ok_or_else(|| {
                            let what = format!("invalid value for `{key}`");
                            self.fault(&value.span(), place, what, "use strings and numbers")
                        })?,
                        None => one(value)?,
                    });
                }
                if many { texts } else { vec![texts.join(",")] }
            }
            DeValue::Table(table) => {
                let texts = table
                    .iter()
                    .map(|(name, value)| Ok(format!("{}={}", name.get_ref(), one(value)?)));
                texts.collect::<Result<_, Failure>>()?
            }
            _ => vec![one(value)?],
        };
        if arg.is_positional() {
            return Ok(values);
        }
        // a value that looks like an option is attached to its own option
        if values.iter().any(|value| value.starts_with('-') && value != "-") {
            return Ok(values.iter().map(|value| format!("--{key}={value}")).collect());
        }
        let takes_several = arg.get_num_args().is_some_and(|n| n.max_values() > 1);
        let option = format!("--{key}");
        Ok(if takes_several {
            std::iter::once(option).chain(values).collect()
        } else {
            values.into_iter().flat_map(|value| [option.clone(), value]).collect()
        })
    }

    /// Error of the command-line parser for a step.
    fn refused(
        &self,
        error: &clap::Error,
        step: &Value<'_>,
        keys: &Keys<'_>,
        defaults: &Keys<'_>,
        place: &str,
    ) -> Failure {
        let named: Vec<String> = match error.get(ContextKind::InvalidArg) {
            Some(ContextValue::String(arg)) => vec![key_of(arg)],
            Some(ContextValue::Strings(args)) => args.iter().map(|arg| key_of(arg)).collect(),
            _ => Vec::new(),
        };
        if error.kind() == ErrorKind::MissingRequiredArgument {
            let missing =
                named.iter().map(|key| format!("`{key}`")).collect::<Vec<_>>().join(" and ");
            let advice = "add it to the step, or to [defaults]";
            return self.fault(&step.span(), place, format!("missing {missing}"), advice);
        }
        let span = named
            .first()
            .and_then(|key| keys.get(key).or_else(|| defaults.get(key)))
            .map_or_else(|| step.span(), |(_, value)| value.span());
        let said = error.to_string();
        let what = said.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
        let command = place.split(['(', ')']).nth(1).unwrap_or_default().to_owned();
        self.fault(&span, place, what, format!("see `armident {command} --help`"))
    }

    fn keys<'t>(&self, value: &'t Value<'t>, what: &str) -> Result<Keys<'t>, Failure> {
        let Some(table) = value.get_ref().as_table() else {
            let advice = format!("write {what} with its keys below it");
            return Err(self.fault(&value.span(), "", format!("{what} must be a table"), advice));
        };
        // save_model is accepted for save-model
        let entry = |(key, value): (&Spanned<std::borrow::Cow<'_, str>>, &'t Value<'t>)| {
            (key.get_ref().replace('_', "-"), (key.span(), value))
        };
        Ok(table.iter().map(entry).collect())
    }

    fn text_of(&self, value: &Value<'_>, key: &str, place: &str) -> Result<String, Failure> {
        value.get_ref().as_str().map(ToOwned::to_owned).ok_or_else(|| {
            let what = format!("`{key}` must be a quoted string");
            self.fault(&value.span(), place, what, format!("for example {key} = \"...\""))
        })
    }

    fn unknown(
        &self,
        span: &Range<usize>,
        place: &str,
        key: &str,
        of: &str,
        known: &[String],
    ) -> Failure {
        let valid = if of == COMMANDS { "valid commands:" } else { "valid keys:" };
        let advice = meant(key, known, valid);
        self.fault(
            span,
            place,
            match of == COMMANDS {
                true => format!("unknown command `{key}`"),
                false => format!("unknown key `{key}` for {of}"),
            },
            advice,
        )
    }

    fn fault(
        &self,
        span: &Range<usize>,
        place: &str,
        what: impl Into<String>,
        advice: impl Into<String>,
    ) -> Failure {
        let excerpt = Excerpt::of_text(&self.text, span).filter(|_| span.end > 0);
        let line = excerpt.as_ref().map(|e| format!(", line {}", e.number())).unwrap_or_default();
        let place = if place.is_empty() { String::new() } else { format!(", {place}") };
        let place = format!("{}{line}{place}", self.path.display());
        Failure::new(what.into(), place, Some(advice.into())).showing(excerpt)
    }
}

/// The nearest of the known names, then all of them.
pub(crate) fn meant(name: &str, known: &[String], lead: &str) -> String {
    let list = format!("{lead} {}", known.join(", "));
    match armident_kinematics::nearest(name, known) {
        Some(near) => format!("did you mean `{near}`? {list}"),
        None => list,
    }
}

/// Commands that can be steps.
fn step_commands() -> Vec<clap::Command> {
    let mut cli = Cli::command();
    cli.build();
    cli.get_subcommands().filter(|c| !NO_STEPS.contains(&c.get_name())).cloned().collect()
}

fn names(commands: &[clap::Command]) -> String {
    commands.iter().map(clap::Command::get_name).collect::<Vec<_>>().join(", ")
}

/// Keys of a command: its arguments, then its options without dashes.
fn options(command: &clap::Command) -> Vec<(String, &Arg)> {
    let mut positional: Vec<(String, &Arg)> = Vec::new();
    let mut optional = Vec::new();
    for arg in command.get_arguments() {
        match arg.get_long() {
            Some("help" | "version") => {}
            Some(long) => optional.push((long.to_owned(), arg)),
            None => positional.push((arg.get_id().as_str().replace('_', "-"), arg)),
        }
    }
    positional.extend(optional);
    positional
}

/// `--cutoff-hz <HZ>` or `<RECORDINGS>...` as a key.
fn key_of(arg: &str) -> String {
    match arg.strip_prefix("--") {
        Some(rest) => rest.split([' ', '=', '[']).next().unwrap_or_default().to_owned(),
        None => arg.trim_matches(['<', '>', '[', ']', '.']).to_lowercase().replace('_', "-"),
    }
}

fn scalar(value: &DeValue<'_>) -> Option<String> {
    match value {
        DeValue::String(text) => Some(text.to_string()),
        DeValue::Integer(number) => {
            let digits = number.as_str().replace('_', "");
            i64::from_str_radix(&digits, number.radix()).ok().map(|n| n.to_string())
        }
        DeValue::Float(number) => Some(number.as_str().replace('_', "")),
        _ => None,
    }
}

/// `{ file = "heavy.csv", mass = 2, com = [0, 0, 0.05] }` as `com=0:0:0.05,file=heavy.csv,mass=2`.
fn parts(table: &DeTable<'_>) -> Option<String> {
    let part = |(name, value): (&Spanned<std::borrow::Cow<'_, str>>, &Value<'_>)| {
        let text = match value.get_ref() {
            DeValue::Array(values) => {
                let texts: Option<Vec<String>> =
                    values.iter().map(|v| scalar(v.get_ref())).collect();
                texts?.join(":")
            }
            other => scalar(other)?,
        };
        Some(format!("{}={text}", name.get_ref()))
    };
    table.iter().map(part).collect::<Option<Vec<String>>>().map(|parts| parts.join(","))
}
