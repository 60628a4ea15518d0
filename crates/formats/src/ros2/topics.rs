//! Which topics a log has, and which of them are read.

use std::collections::BTreeMap;

use mcap::records::Record;

use super::cdr::Cdr;
use super::container::{CutOff, for_each_record};
use super::message::{Kind, header};
use crate::assembly::Assembly;
use crate::choice::Counts;
use crate::open::Options;
use crate::window::Input;
use hovernav_log::LogError;

/// A channel with messages that are read.
#[derive(Debug)]
struct Topic {
    channel: u16,
    name: String,
    kind: Kind,
    messages: usize,
    /// How much later the log says a message was than its own stamp, least, ns.
    least_delay_ns: i64,
    stamped: usize,
}

/// What is read, channel by channel.
#[derive(Debug)]
pub(super) struct Topics {
    chosen: Vec<Topic>,
    /// Whether stamps count, or when messages were logged.
    pub by_stamp: bool,
}

impl Topics {
    /// What the messages of `channel` are, if they are read.
    pub fn kind(&self, channel: u16) -> Option<Kind> {
        self.chosen.iter().find(|topic| topic.channel == channel).map(|topic| topic.kind)
    }

    /// Looks through the log, chooses, and says what else there was.
    pub fn of(
        input: Input<'_>,
        options: &Options,
        assembly: &mut Assembly,
    ) -> Result<Self, LogError> {
        let (found, others, cut_off) = survey(input)?;
        if let Some(CutOff { offset, reason }) = cut_off {
            assembly.say(format!("damaged at byte {offset}: {reason}; what came before is used"));
        }
        if !others.is_empty() {
            let names: Vec<&str> = others.iter().take(12).map(String::as_str).collect();
            let more = others.len().saturating_sub(names.len());
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            assembly.note(format!("topics without use: {}{more}", names.join(", ")));
        }
        let mut chosen = Vec::new();
        for (kinds, wanted) in [
            (&[Kind::Imu][..], options.imu),
            (&[Kind::Fix], options.gps),
            (&[Kind::Velocity, Kind::VelocityCovariance], None),
            (&[Kind::Field], options.magnetometer),
            (&[Kind::Pressure], options.baro),
            (&[Kind::Odometry], None),
            (&[Kind::Range], None),
        ] {
            let of_kind: Vec<&Topic> =
                found.iter().filter(|topic| kinds.contains(&topic.kind)).collect();
            let counts = Counts::new(of_kind.iter().map(|t| t.messages).enumerate());
            let (index, sentence) = counts
                .choose(wanted, |index| index, |index| of_kind[index].name.clone())
                .map_err(|reason| LogError::Unusable { path: input.path.to_path_buf(), reason })?;
            sentence.into_iter().for_each(|sentence| assembly.note(sentence));
            chosen.extend(index.map(|index| of_kind[index].channel));
        }
        let chosen: Vec<Topic> =
            found.into_iter().filter(|topic| chosen.contains(&topic.channel)).collect();
        let by_stamp = stamps_agree(&chosen);
        if !by_stamp && !chosen.is_empty() {
            assembly.say(
                "the topics' own stamps are missing or of different clocks: the times at which they \
                 were logged are used",
            );
        }
        Ok(Self { chosen, by_stamp })
    }
}

/// Whether all topics are stamped, by clocks that are alike to half a second.
fn stamps_agree(topics: &[Topic]) -> bool {
    const ALIKE_NS: i64 = 500_000_000;
    let delays = || topics.iter().map(|topic| topic.least_delay_ns);
    topics.iter().all(|topic| 10 * topic.stamped > 9 * topic.messages)
        && delays().max().zip(delays().min()).is_some_and(|(most, least)| {
            most.checked_sub(least).is_some_and(|spread| spread <= ALIKE_NS)
        })
}

/// The topics with messages that are read, the others by name, and damage.
#[expect(clippy::type_complexity, reason = "three results that nothing else shares")]
fn survey(input: Input<'_>) -> Result<(Vec<Topic>, Vec<String>, Option<CutOff>), LogError> {
    let mut schemas: BTreeMap<u16, String> = BTreeMap::new();
    let mut topics: BTreeMap<u16, Topic> = BTreeMap::new();
    let mut others: BTreeMap<u16, String> = BTreeMap::new();
    let cut_off = for_each_record(input, |record, _| {
        match record {
            Record::Schema { header, .. } => {
                schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let schema = schemas.get(&channel.schema_id).map_or("", String::as_str);
                let kind = Kind::of(schema).filter(|_| channel.message_encoding == "cdr");
                // Speeds that are asked of a vehicle are not those of a receiver.
                let kind = kind.filter(|_| !channel.topic.contains("cmd"));
                if let Some(kind) = kind {
                    topics.entry(channel.id).or_insert(Topic {
                        channel: channel.id,
                        name: channel.topic,
                        kind,
                        messages: 0,
                        least_delay_ns: i64::MAX,
                        stamped: 0,
                    });
                } else {
                    others.insert(channel.id, channel.topic);
                }
            }
            Record::Message { header: sent, data } => {
                if let Some(topic) = topics.get_mut(&sent.channel_id) {
                    topic.messages += 1;
                    let stamp_ns =
                        Cdr::new(&data).and_then(|mut cdr| header(&mut cdr)).map(|h| h.stamp_ns);
                    if let Some(stamp_ns) = stamp_ns.filter(|stamp_ns| *stamp_ns != 0) {
                        topic.stamped += 1;
                        let logged_ns = i64::try_from(sent.log_time).unwrap_or(i64::MAX);
                        let delay_ns = logged_ns.saturating_sub(stamp_ns);
                        topic.least_delay_ns = topic.least_delay_ns.min(delay_ns);
                    }
                }
            }
            _ => {}
        }
        Ok(())
    })?;
    // Those that name themselves raw come after those that do not.
    let mut topics: Vec<Topic> = topics.into_values().collect();
    topics.sort_by_key(|topic| (topic.name.contains("raw"), topic.name.clone()));
    topics.retain(|topic| topic.messages > 0);
    Ok((topics, others.into_values().collect(), cut_off))
}
