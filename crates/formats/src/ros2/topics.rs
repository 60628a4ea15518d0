//! Which topics a log has, and which of them are read.

use std::collections::BTreeMap;

use mcap::records::{Channel, Record};

use super::cdr::Cdr;
use super::container::{for_each_record, unpacked_message};
use super::message::{Kind, header};
use super::topic::{Stamps, Topic};
use super::velocity;
use crate::assembly::Assembly;
use crate::choice::Counts;
use crate::damages::Damages;
use crate::log::Options;
use crate::window::Input;
use hovernav_log::LogError;

/// No topic's name is longer, bytes: what a chunk unpacks to could hold any number of such.
const LONGEST_NAME: usize = 1024;

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
        let unusable = |reason| LogError::Unusable { path: input.path.to_path_buf(), reason };
        let mut chosen = Vec::new();
        for (kind, wanted) in [
            (Kind::Imu, options.imu),
            (Kind::Fix, options.gps),
            (Kind::Field, options.magnetometer),
            (Kind::Pressure, options.baro),
            (Kind::Odometry, None),
            (Kind::Range, None),
        ] {
            let of_kind: Vec<&Topic> = found.iter().filter(|topic| topic.kind == kind).collect();
            let counts = Counts::new(of_kind.iter().map(|t| t.stamps.messages).enumerate());
            let (index, sentence) = counts
                .choose(wanted, |index| index, |index| of_kind[index].name.clone())
                .map_err(unusable)?;
            sentence.into_iter().for_each(|sentence| assembly.note(sentence));
            chosen.extend(index.map(|index| of_kind[index].channel));
        }
        chosen.extend(velocity_of(&found, &chosen, options, assembly).map_err(unusable)?);
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

/// The channel of the receiver's own velocity, of the `chosen` fixes, with a sentence about why, and about
/// those that are left out.
///
/// # Errors
/// A sentence where no topic has the name that was asked for.
fn velocity_of(
    found: &[Topic],
    chosen: &[u16],
    options: &Options,
    assembly: &mut Assembly,
) -> Result<Option<u16>, String> {
    let is_velocity =
        |topic: &&Topic| matches!(topic.kind, Kind::Velocity | Kind::VelocityCovariance);
    let velocities: Vec<&Topic> = found.iter().filter(is_velocity).collect();
    let in_words = |topic: &&Topic| format!("{} ({} messages)", topic.name, topic.stamps.messages);
    let listed = |topics: &[&Topic]| topics.iter().map(in_words).collect::<Vec<_>>().join(", ");
    let fixes =
        found.iter().find(|topic| topic.kind == Kind::Fix && chosen.contains(&topic.channel));
    let wanted = options.velocity.as_deref();
    let taken = match (wanted, fixes) {
        (Some("none"), _) | (None, None) => None,
        (Some(wanted), _) => {
            let named = velocities.iter().copied().find(|topic| topic.name == wanted);
            let named = named.ok_or_else(|| {
                format!("found no velocity topic {wanted}; the log has {}", listed(&velocities))
            })?;
            Some((named, "it was asked for"))
        }
        (None, Some(fixes)) => {
            let reasons = velocities
                .iter()
                .filter_map(|topic| velocity::reason(topic, fixes).map(|reason| (*topic, reason)));
            reasons.min_by_key(|(_, (rank, _))| *rank).map(|(topic, (_, why))| (topic, why))
        }
    };
    if let Some((topic, why)) = taken {
        assembly.note(format!("velocity of the fixes from {}: {why}", topic.name));
    }
    let others: Vec<&Topic> = velocities
        .into_iter()
        .filter(|topic| taken.is_none_or(|(taken, _)| taken.channel != topic.channel))
        .collect();
    if !others.is_empty() {
        let others = listed(&others);
        assembly.note(format!(
            "not taken for the receiver's velocity: {others}; --velocity TOPIC takes one"
        ));
    }
    Ok(taken.map(|(topic, _)| topic.channel))
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
    // Of each its times, and the frame of its first message.
    let mut stamps: BTreeMap<u16, (Stamps, String)> = BTreeMap::new();
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
            let data = unpacked_message(&data);
            let header = Cdr::new(&data).and_then(|mut cdr| header(&mut cdr));
            let (stamps, _) = stamps.entry(sent.channel_id).or_insert_with(|| {
                let frame = header.map_or(&b""[..], |header| header.frame);
                let frame = &frame[..frame.len().min(LONGEST_NAME)];
                (Stamps::NONE, String::from_utf8_lossy(frame).into_owned())
            });
            stamps.count(&sent, header.as_ref());
        }
        _ => {}
    })?;
    let (mut topics, mut others) = (Vec::new(), Vec::new());
    for (channel, (schema, name, is_cdr)) in channels {
        match (kinds.get(&schema).filter(|_| is_cdr), stamps.remove(&channel)) {
            (Some(&kind), Some((stamps, frame))) => {
                topics.push(Topic { channel, name, frame, kind, stamps });
            }
            (Some(_), None) => {}
            (None, _) => others.push(name),
        }
    }
    // Those that name themselves raw come after those that do not.
    topics.sort_by_key(|topic| (topic.name.contains("raw"), topic.name.clone()));
    Ok((topics, others, damages))
}
