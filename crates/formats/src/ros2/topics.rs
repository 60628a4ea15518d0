//! Which topics a log has, and which of them are read.

use std::collections::BTreeMap;

use mcap::records::{Channel, MessageHeader, Record};

use super::cdr::Cdr;
use super::container::for_each_record;
use super::message::{Kind, header};
use crate::assembly::Assembly;
use crate::choice::Counts;
use crate::damages::Damages;
use crate::open::Options;
use crate::window::Input;
use hovernav_log::LogError;

/// No topic's name is longer, bytes: what a chunk unpacks to could hold any number of such.
const LONGEST_NAME: usize = 1024;

/// A channel with messages that are read.
#[derive(Debug)]
struct Topic {
    channel: u16,
    name: String,
    kind: Kind,
    stamps: Stamps,
}

/// What a channel's messages say of their times.
#[derive(Clone, Copy, Debug)]
struct Stamps {
    messages: usize,
    stamped: usize,
    /// How much later the log says a message was than its own stamp, least, ns.
    least_delay_ns: i64,
}

impl Stamps {
    const NONE: Self = Self { messages: 0, stamped: 0, least_delay_ns: i64::MAX };

    fn count(&mut self, sent: &MessageHeader, data: &[u8]) {
        self.messages += 1;
        let stamp_ns = Cdr::new(data).and_then(|mut cdr| header(&mut cdr)).map(|h| h.stamp_ns);
        if let Some(stamp_ns) = stamp_ns.filter(|stamp_ns| *stamp_ns != 0) {
            self.stamped += 1;
            let logged_ns = i64::try_from(sent.log_time).unwrap_or(i64::MAX);
            let delay_ns = logged_ns.saturating_sub(stamp_ns);
            self.least_delay_ns = self.least_delay_ns.min(delay_ns);
        }
    }
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
        let (found, others, damages) = survey(input)?;
        for (offset, reason) in damages.iter() {
            assembly.say(format!("damaged at byte {offset}: {reason}"));
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
            let counts = Counts::new(of_kind.iter().map(|t| t.stamps.messages).enumerate());
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
    let delays = || topics.iter().map(|topic| topic.stamps.least_delay_ns);
    topics.iter().all(|topic| 10 * topic.stamps.stamped > 9 * topic.stamps.messages)
        && delays().max().zip(delays().min()).is_some_and(|(most, least)| {
            most.checked_sub(least).is_some_and(|spread| spread <= ALIKE_NS)
        })
}

/// The topics with messages that are read, the others by name, and damage.
fn survey(input: Input<'_>) -> Result<(Vec<Topic>, Vec<String>, Damages), LogError> {
    let mut kinds: BTreeMap<u16, Kind> = BTreeMap::new();
    // Of each channel its schema, its name and whether its messages can be read.
    let mut channels: BTreeMap<u16, (u16, String, bool)> = BTreeMap::new();
    let mut stamps: BTreeMap<u16, Stamps> = BTreeMap::new();
    // Where the chunk that tells of a channel is damaged, the end of the file tells of it again.
    let damages = for_each_record(input, |record, _| match record {
        Record::Schema { header, .. } => {
            if let Some(kind) = Kind::of(&header.name) {
                kinds.entry(header.id).or_insert(kind);
            }
        }
        Record::Channel(Channel { id, schema_id, topic, message_encoding, .. })
            if topic.len() <= LONGEST_NAME =>
        {
            let is_cdr = message_encoding == "cdr";
            channels.entry(id).or_insert((schema_id, topic, is_cdr));
        }
        Record::Message { header: sent, data } => {
            stamps.entry(sent.channel_id).or_insert(Stamps::NONE).count(&sent, &data);
        }
        _ => {}
    })?;
    let (mut topics, mut others) = (Vec::new(), Vec::new());
    for (channel, (schema, name, is_cdr)) in channels {
        // Speeds that are asked of a vehicle are not those of a receiver.
        let kind = kinds.get(&schema).filter(|_| is_cdr && !name.contains("cmd"));
        match (kind, stamps.get(&channel)) {
            (Some(&kind), Some(&stamps)) => topics.push(Topic { channel, name, kind, stamps }),
            (Some(_), None) => {}
            (None, _) => others.push(name),
        }
    }
    // Those that name themselves raw come after those that do not.
    topics.sort_by_key(|topic| (topic.name.contains("raw"), topic.name.clone()));
    Ok((topics, others, damages))
}
