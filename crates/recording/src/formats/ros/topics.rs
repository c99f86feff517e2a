//! Messages of joints by topic, whatever file they come from.

use std::collections::BTreeMap;

use super::messages::{Kind, Message};
use super::serialised::{BadMessage, Encoding};
use crate::error::{Fault, RecordingError, plural};
use crate::formats::format::ColumnRequest;
use crate::quantity::Quantity;
use crate::raw::{RawColumn, RawColumns};

/// Preferred topic if several have joint states, and the topic that is written.
pub(in crate::formats) const JOINT_STATES: &str = "/joint_states";
/// Stamps above this are clock times \[ns\]; their origin becomes the whole second of the first.
const CLOCK_NS: i64 = 100_000_000_000_000_000;

/// The topics of a file, with the messages of joints read so far.
#[derive(Default)]
pub(in crate::formats) struct Topics {
    /// topic to read; all if none
    wanted: Option<String>,
    /// name of the messages of each topic
    schemas: BTreeMap<String, String>,
    read: BTreeMap<String, Topic>,
}

/// The messages of a topic.
#[derive(Default)]
struct Topic {
    /// names of the joints as messages list them: few lists, many messages
    names: Vec<Vec<String>>,
    /// index of the names, and the message without them
    states: Vec<(usize, Message)>,
    /// messages without header stamp, which have the log time instead
    without_stamp: usize,
    /// number of the first message that cannot be read, and why
    broken: Option<(usize, BadMessage)>,
}

impl Message {
    fn list(&self, quantity: Quantity) -> &[f64] {
        self.values.iter().find(|(of, _)| *of == quantity).map_or(&[], |(_, list)| list)
    }
}

impl Topics {
    /// No topic yet, of which a request may want one.
    pub(in crate::formats) fn new(request: &ColumnRequest<'_>) -> Self {
        Self { wanted: request.topic().map(str::to_owned), ..Self::default() }
    }

    /// A topic of the file; `schema` is the name of its messages, empty if there is none.
    pub(in crate::formats) fn declare(&mut self, topic: &str, schema: &str) {
        self.schemas.insert(topic.to_owned(), schema.to_owned());
    }

    /// Whether the messages of a topic are read.
    pub(in crate::formats) fn wants(&self, topic: &str) -> bool {
        self.wanted.as_ref().is_none_or(|wanted| wanted == topic)
            && self.schemas.get(topic).is_some_and(|schema| Kind::of(schema).is_some())
    }

    /// Whether no message was read yet.
    pub(in crate::formats) fn is_empty(&self) -> bool {
        self.read.is_empty()
    }

    /// Adds a message; `log_ns` is when it was logged. The encoding has the name that files give it.
    pub(in crate::formats) fn take(
        &mut self,
        topic: &str,
        encoding: &str,
        data: &[u8],
        log_ns: u64,
    ) {
        let kind = self.schemas.get(topic).and_then(|schema| Kind::of(schema));
        let Some(kind) = kind.filter(|_| self.wants(topic)) else { return };
        let of_topic = self.read.entry(topic.to_owned()).or_default();
        if of_topic.broken.is_some() {
            return;
        }
        let read = match encoding {
            "cdr" => kind.decode(data, Encoding::Cdr),
            "ros1" => kind.decode(data, Encoding::Ros1),
            other => Err(BadMessage {
                offset: 0,
                what: format!("its encoding `{other}` is neither cdr nor ros1"),
            }),
        };
        let mut message = match read {
            Ok(message) => message,
            Err(bad) => {
                of_topic.broken = Some((of_topic.states.len() + 1, bad));
                return;
            }
        };
        if message.stamp_ns == 0 {
            of_topic.without_stamp += 1;
            message.stamp_ns = i64::try_from(log_ns).unwrap_or(i64::MAX);
        }
        let names = std::mem::take(&mut message.joints);
        let known = of_topic.names.iter().position(|n| *n == names).unwrap_or_else(|| {
            of_topic.names.push(names);
            of_topic.names.len() - 1
        });
        of_topic.states.push((known, message));
    }

    /// Joints of one topic as columns, time in seconds: `t` and `<joint>/<quantity>`, or, for a mapping, `__time` and
    /// `<topic>/<joint>/<quantity>`. `ended_early` states why the file was not read to its end.
    ///
    /// # Errors
    /// No topic has messages of joints, the wanted one has none, several have and none is `/joint_states`, or one of its
    /// messages breaks the rules.
    pub(in crate::formats) fn columns(
        self,
        request: &ColumnRequest<'_>,
        ended_early: Option<String>,
    ) -> Result<RawColumns, RecordingError> {
        let source = request.source();
        let fault = |fault| RecordingError::new(fault, source);
        let [states, others, without] = self.by_kind();
        let joints: Vec<String> = states.iter().chain(&others).cloned().collect();
        // states of joints before states of controllers
        let candidates = if states.is_empty() { &others } else { &states };
        let chosen = match request.topic() {
            Some(topic) if joints.iter().any(|t| t == topic) => topic.to_owned(),
            Some(topic) => {
                return Err(fault(Fault::UnknownTopic { topic: topic.to_owned(), found: joints }));
            }
            None => match &candidates[..] {
                [] => return Err(fault(Fault::NoJointStates { topics: without })),
                [only] => only.clone(),
                several if several.iter().any(|t| t == JOINT_STATES) => JOINT_STATES.to_owned(),
                several => {
                    return Err(fault(Fault::SeveralJointStates { topics: several.to_vec() }));
                }
            },
        };
        let what = match self.schemas.get(&chosen).map(|schema| Kind::of(schema)) {
            Some(Some(Kind::Dynamic)) => "dynamic joint states",
            Some(Some(Kind::Controller)) => "feedback of the controller",
            _ => "joint states",
        };
        let mut raw = self.columns_of(&chosen, source, request.is_mapped())?;
        raw.notes.insert(0, format!("{what} of the topic {chosen}"));
        let others: Vec<String> =
            joints.into_iter().filter(|t| *t != chosen).chain(without).collect();
        if !others.is_empty() {
            raw.notes.push(format!("ignored topics: {}", others.join(", ")));
        }
        if let Some(why) = ended_early {
            raw.notes.push(format!("truncated file ({why}); read up to that point"));
        }
        Ok(raw)
    }

    /// Topics with joint states, those with other messages of joints, and the others with the names of their messages.
    fn by_kind(&self) -> [Vec<String>; 3] {
        let [mut states, mut joints, mut others] = [Vec::new(), Vec::new(), Vec::new()];
        for (topic, schema) in &self.schemas {
            match Kind::of(schema) {
                Some(Kind::State) => states.push(topic.clone()),
                Some(_) => joints.push(topic.clone()),
                None if schema.is_empty() => others.push(format!("{topic} (no schema)")),
                None => others.push(format!("{topic} ({schema})")),
            }
        }
        [states, joints, others]
    }

    fn columns_of(
        mut self,
        topic: &str,
        source: &str,
        with_topic: bool,
    ) -> Result<RawColumns, RecordingError> {
        let read = self.read.remove(topic).unwrap_or_default();
        if let Some((number, BadMessage { offset, what })) = read.broken {
            let fault = Fault::BadMessage { topic: topic.to_owned(), number, offset, what };
            return Err(RecordingError::new(fault, source));
        }
        let Some(Publishers { sets, skipped }) = read.publishers() else {
            return Err(RecordingError::new(Fault::HeaderOnly, source));
        };
        let joints: Vec<String> = sets.concat();
        let mut raw = RawColumns::new(source);
        if sets.len() > 1 {
            let lists: Vec<String> = sets.iter().map(|set| set.join(", ")).collect();
            raw.notes.push(format!(
                "{} publishers of joints ({}); messages merged on their stamps",
                sets.len(),
                lists.join("; ")
            ));
        }
        if !skipped.is_empty() {
            raw.notes.push(format!("ignored messages with other joints: {skipped}"));
        }
        if read.without_stamp > 0 {
            raw.notes.push(format!(
                "{} message{} without header stamp; using log time",
                read.without_stamp,
                plural(read.without_stamp)
            ));
        }
        // place of every joint in each list of names; none for lists of other joints
        let places: Vec<Option<Vec<Option<usize>>>> = (read.names.iter())
            .map(|list| {
                let is_whole = |set: &&Vec<String>| {
                    set.len() == list.len() && set.iter().all(|joint| list.contains(joint))
                };
                sets.iter().find(is_whole)?;
                let place = |joint: &String| list.iter().position(|n| n == joint);
                Some(joints.iter().map(place).collect())
            })
            .collect();
        let mut taken: Vec<(&Message, &[Option<usize>])> = (read.states.iter())
            .filter_map(|(names, state)| Some((state, places[*names].as_deref()?)))
            .collect();
        if sets.len() > 1 {
            taken.sort_by_key(|(state, _)| state.stamp_ns);
        }
        let first = taken.first().map_or(0, |(state, _)| state.stamp_ns);
        let zero = if first > CLOCK_NS { first - first % 1_000_000_000 } else { 0 };
        if zero != 0 {
            raw.notes.push(format!("time origin: {} s", zero / 1_000_000_000));
        }
        let stamps = taken.iter().map(|(s, _)| (s.stamp_ns - zero) as f64 / 1e9).collect();
        let time = if with_topic { "__time" } else { "t" };
        raw.columns.push(RawColumn { name: time.to_owned(), values: Some(stamps) });
        for (joint, name) in joints.iter().enumerate() {
            for quantity in Quantity::ALL {
                let value = |(message, places): &(&Message, &[Option<usize>])| {
                    let of_joint =
                        places[joint].and_then(|place| message.list(quantity).get(place));
                    of_joint.copied().unwrap_or(f64::NAN)
                };
                let values: Vec<f64> = taken.iter().map(value).collect();
                if values.iter().all(|v| v.is_nan()) {
                    continue;
                }
                let column = if with_topic {
                    format!("{topic}/{name}/{quantity}")
                } else {
                    format!("{name}/{quantity}")
                };
                raw = raw.with(column, values);
            }
        }
        Ok(raw)
    }
}

/// Least messages of a publisher, as a share of those of the first, that are merged with them: between slower ones a motion
/// is not seen.
const LEAST_SHARE: f64 = 0.25;
/// Share of the time of the first publisher in which another publishes as well.
const OVERLAP: f64 = 0.9;

/// Who publishes on a topic.
struct Publishers {
    /// joints of the messages that are read, in their order: those of most messages first
    sets: Vec<Vec<String>>,
    /// the other messages, in words
    skipped: String,
}

impl Topic {
    /// The joints of most messages, those of other publishers of other joints, and a list of the messages of neither: a
    /// gripper may publish now and then, and a second node all joints once more.
    fn publishers(&self) -> Option<Publishers> {
        let sorted = |list: &[String]| {
            let mut list = list.to_vec();
            list.sort();
            list
        };
        let sets: Vec<Vec<String>> = self.names.iter().map(|list| sorted(list)).collect();
        let mut of_set: BTreeMap<&[String], (usize, i64, i64)> = BTreeMap::new();
        for (names, state) in &self.states {
            let (count, first, last) =
                of_set.entry(&sets[*names]).or_insert((0, i64::MAX, i64::MIN));
            *count += 1;
            *first = state.stamp_ns.min(*first);
            *last = state.stamp_ns.max(*last);
        }
        let most = of_set.values().map(|(count, _, _)| *count).max()?;
        let main =
            sets.iter().find(|set| of_set.get(set.as_slice()).is_some_and(|c| c.0 == most))?;
        let (_, first, last) = *of_set.get(main.as_slice())?;
        let mut read: Vec<&[String]> = vec![main];
        for set in &sets {
            let Some((count, from, to)) = of_set.get(set.as_slice()) else { continue };
            let is_other = !set.is_empty()
                && read.iter().all(|known| known.iter().all(|joint| !set.contains(joint)));
            let together = (last.min(*to) - first.max(*from)) as f64;
            if is_other
                && *count as f64 >= LEAST_SHARE * most as f64
                && together >= OVERLAP * (last - first) as f64
            {
                read.push(set);
            }
        }
        let skipped: Vec<String> = (of_set.iter())
            .filter(|(set, _)| !read.contains(*set))
            .map(|(set, (count, _, _))| format!("{count} with {}", set.join(", ")))
            .collect();
        let in_order = |set: &&[String]| {
            self.names
                .iter()
                .zip(&sets)
                .find(|(_, sorted)| sorted == set)
                .map(|(list, _)| list.clone())
        };
        let sets = read.iter().filter_map(in_order).collect();
        Some(Publishers { sets, skipped: skipped.join("; ") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Messages of these joints at so many per second for 10 s.
    fn published(topic: &mut Topic, joints: &[&str], hz: i64) {
        topic.names.push(joints.iter().map(ToString::to_string).collect());
        for k in 0..10 * hz {
            let state = Message { stamp_ns: k * 1_000_000_000 / hz, ..Message::default() };
            topic.states.push((topic.names.len() - 1, state));
        }
    }

    #[test]
    fn publishers_of_other_joints_are_merged() {
        let mut topic = Topic::default();
        published(&mut topic, &["b", "a"], 50);
        published(&mut topic, &["c"], 100);
        published(&mut topic, &["finger"], 2);
        published(&mut topic, &["a", "b", "c"], 20);
        let Publishers { sets, skipped } = topic.publishers().unwrap();
        assert_eq!(sets, [vec!["c".to_owned()], vec!["b".to_owned(), "a".to_owned()]]);
        assert_eq!(skipped, "200 with a, b, c; 20 with finger");
    }
}
