//! Lists the topics of a log and chooses those that are read.

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

/// Largest length of a topic's name, bytes. It limits the memory that a compressed chunk can demand.
const LONGEST_NAME: usize = 1024;

/// The channels that are read.
#[derive(Debug)]
pub(super) struct Topics {
    chosen: Vec<Topic>,
    /// Whether times are the messages' own stamps; otherwise the times at which they were logged.
    pub by_stamp: bool,
}

impl Topics {
    /// The kind of the messages of `channel`, if they are read.
    pub fn kind(&self, channel: u16) -> Option<Kind> {
        self.chosen.iter().find(|topic| topic.channel == channel).map(|topic| topic.kind)
    }

    /// Surveys the log, chooses topics, and notes the others.
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
            assembly.note(format!("unused topics: {}{more}", names.join(", ")));
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
                "the topics' own stamps are missing or from different clocks: log times are used \
                 instead",
            );
        }
        Ok(Self { chosen, by_stamp })
    }
}

/// The channel of the receiver's velocity, which belongs to the `chosen` fixes. Notes the reason and the other
/// velocity topics.
///
/// # Errors
/// A sentence where no topic has the requested name.
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
            Some((named, "as requested"))
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
            "not used as the receiver's velocity: {others}; --velocity TOPIC selects one"
        ));
    }
    Ok(taken.map(|(topic, _)| topic.channel))
}

/// Whether all topics are stamped, by clocks that agree within 0.5 s.
fn stamps_agree(topics: &[Topic]) -> bool {
    const ALIKE_NS: i64 = 500_000_000;
    let delays = || topics.iter().map(|topic| topic.stamps.least_delay_ns);
    topics.iter().all(|topic| 10 * topic.stamps.stamped > 9 * topic.stamps.messages)
        && delays().max().zip(delays().min()).is_some_and(|(most, least)| {
            most.checked_sub(least).is_some_and(|spread| spread <= ALIKE_NS)
        })
}

/// The topics whose messages are read, the names of the others, and damage.
fn survey(input: Input<'_>) -> Result<(Vec<Topic>, Vec<String>, Damages), LogError> {
    let mut kinds: BTreeMap<u16, Kind> = BTreeMap::new();
    // Per channel: schema, name, and whether its messages can be read.
    let mut channels: BTreeMap<u16, (u16, String, bool)> = BTreeMap::new();
    // Per channel: time stamps, and the frame of the first message.
    let mut stamps: BTreeMap<u16, (Stamps, String)> = BTreeMap::new();
    // Channels are repeated at the end of the file, in case the first description is damaged.
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
    // Topics with "raw" in their name come last.
    topics.sort_by_key(|topic| (topic.name.contains("raw"), topic.name.clone()));
    Ok((topics, others, damages))
}
