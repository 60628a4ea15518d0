//! Lists the topics of a log and chooses those that are read.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use mcap::records::{Channel, Record};

use super::cdr::Cdr;
use super::container::{ChannelId, for_each_record, unpacked_message};
use super::message::{Kind, fix_of, header, is_good};
use super::topic::{Stamps, Topic};
use super::velocity;
use crate::assembly::Assembly;
use crate::choice::{Counts, Tally, listed};
use crate::damages::Damages;
use crate::log::Options;
use crate::receivers::Tracks;
use crate::window::Input;
use hovernav_dataset::LogError;

/// Largest length of a topic's name, bytes. It limits the memory that a compressed chunk can demand.
const LONGEST_NAME: usize = 1024;

/// The channels that are read.
#[derive(Debug)]
pub(super) struct Topics {
    kinds: BTreeMap<ChannelId, Kind>,
    /// Whether times are the messages' own stamps; otherwise the times at which they were logged.
    pub by_stamp: bool,
}

impl Topics {
    /// The kind of the messages of `channel`, if they are read.
    pub fn kind(&self, channel: ChannelId) -> Option<Kind> {
        self.kinds.get(&channel).copied()
    }

    /// Surveys the log, chooses topics, and notes the others.
    pub fn of(
        path: &Path,
        inputs: &[Input<'_>],
        options: &Options,
        assembly: &mut Assembly,
    ) -> Result<Self, LogError> {
        let (found, others, damages) = survey(inputs)?;
        for (offset, reason) in damages.iter() {
            assembly.say(format!("damaged at byte {offset}: {reason}"));
        }
        if !others.is_empty() {
            assembly.note(format!("unused topics: {}", listed(others.into_iter())));
        }
        let unusable = |reason| LogError::Unusable { path: path.to_path_buf(), reason };
        let mut chosen = Vec::new();
        for (kind, wanted) in [
            (Kind::Imu, ("--imu", options.imu)),
            (Kind::Fix, ("--gps", options.gps)),
            (Kind::Field, ("--mag", options.magnetometer)),
            (Kind::Pressure, ("--baro", options.baro)),
            (Kind::Odometry, ("", None)),
            (Kind::Range, ("", None)),
        ] {
            let is_such = |topic: &&Topic| {
                topic.kind == kind || kind == Kind::Fix && topic.kind == Kind::GpsFix
            };
            let of_kind: Vec<&Topic> = found.iter().filter(is_such).collect();
            let tally = |t: &&Topic| Tally::of(t.stamps.messages, t.stamps.good);
            let counts = Counts::new(of_kind.iter().map(tally).enumerate());
            let (index, sentence) = counts
                .choose(wanted, |index| index, |index| of_kind[index].name.clone())
                .map_err(unusable)?;
            sentence.into_iter().for_each(|sentence| assembly.note(sentence));
            chosen.extend(index.map(|index| of_kind[index].name.clone()));
        }
        chosen.extend(velocity_of(&found, &chosen, options, assembly).map_err(unusable)?);
        let chosen: Vec<Topic> =
            found.into_iter().filter(|topic| chosen.contains(&topic.name)).collect();
        let by_stamp = stamps_agree(&chosen);
        if !by_stamp && !chosen.is_empty() {
            assembly.say(
                "the topics' own stamps are missing or from different clocks: log times are used \
                 instead",
            );
        }
        let kinds = chosen
            .iter()
            .flat_map(|topic| topic.channels.iter().map(|channel| (*channel, topic.kind)));
        Ok(Self { kinds: kinds.collect(), by_stamp })
    }
}

/// The topic of the receiver's velocity, which belongs to the `chosen` fixes. Notes the reason and the other
/// velocity topics.
///
/// # Errors
/// A sentence if no topic has the requested name.
fn velocity_of(
    found: &[Topic],
    chosen: &[String],
    options: &Options,
    assembly: &mut Assembly,
) -> Result<Option<String>, String> {
    let is_velocity =
        |topic: &&Topic| matches!(topic.kind, Kind::Velocity | Kind::VelocityCovariance);
    let velocities: Vec<&Topic> = found.iter().filter(is_velocity).collect();
    let in_words = |topic: &&Topic| format!("{} ({} messages)", topic.name, topic.stamps.messages);
    let listed = |topics: &[&Topic]| listed(topics.iter().map(in_words));
    let fixes = found.iter().find(|topic| topic.kind == Kind::Fix && chosen.contains(&topic.name));
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
        .filter(|topic| taken.is_none_or(|(taken, _)| !taken.is(topic)))
        .collect();
    if !others.is_empty() {
        let others = listed(&others);
        assembly.note(format!(
            "not used as the receiver's velocity: {others}; --velocity TOPIC selects one"
        ));
    }
    Ok(taken.map(|(topic, _)| topic.name.clone()))
}

/// Whether all topics have time stamps from clocks that agree within 0.5 s.
fn stamps_agree(topics: &[Topic]) -> bool {
    const ALIKE_NS: i64 = 500_000_000;
    let delays = || topics.iter().map(|topic| topic.stamps.min_delay_ns);
    topics.iter().all(|topic| 10 * topic.stamps.stamped > 9 * topic.stamps.messages)
        && delays().max().zip(delays().min()).is_some_and(|(most, least)| {
            most.checked_sub(least).is_some_and(|spread| spread <= ALIKE_NS)
        })
}

/// The topics whose messages are read, the names of the others, and damage.
fn survey(inputs: &[Input<'_>]) -> Result<(Vec<Topic>, BTreeSet<String>, Damages), LogError> {
    let mut kinds: BTreeMap<ChannelId, Kind> = BTreeMap::new();
    // Per channel: schema, name, and whether its messages can be read.
    let mut channels: BTreeMap<ChannelId, (u16, String, bool)> = BTreeMap::new();
    // Per channel: time stamps, and the frame of the first message.
    let mut stamps: BTreeMap<ChannelId, (Stamps, String)> = BTreeMap::new();
    let mut tracks: Tracks<ChannelId> = Tracks::default();
    // The file repeats its channels at the end, in case the first description is damaged.
    let damages = for_each_record(inputs, |file, record, _| match record {
        Record::Schema { header, .. } => {
            if let Some(kind) = Kind::of(&header.name) {
                kinds.entry((file, header.id)).or_insert(kind);
            }
        }
        Record::Channel(Channel { id, schema_id, topic, message_encoding, .. })
            if topic.len() <= LONGEST_NAME =>
        {
            let is_cdr = message_encoding == "cdr";
            channels.entry((file, id)).or_insert((schema_id, topic, is_cdr));
        }
        Record::Message { header: sent, data } => {
            let data = unpacked_message(&data);
            let mut cdr = Cdr::new(&data);
            let header = cdr.as_mut().and_then(header);
            let channel = (file, sent.channel_id);
            let kind = channels.get(&channel).and_then(|(schema, ..)| kinds.get(&(file, *schema)));
            if let (Some(kind @ (Kind::Fix | Kind::GpsFix)), Some(cdr)) = (kind, &cdr)
                && let Some(fix) = fix_of(*kind, &mut cdr.clone())
            {
                let speed_mps = fix.motion.map_or(f64::NAN, |[speed_mps, ..]| speed_mps);
                let place_deg = [fix.latitude_deg, fix.longitude_deg];
                let time_s = 1e-9 * sent.log_time as f64;
                tracks.push(channel, time_s, place_deg, [speed_mps, f64::NAN]);
            }
            let is_good = kind.zip(cdr.as_mut()).is_none_or(|(kind, cdr)| is_good(*kind, cdr));
            let (stamps, _) = stamps.entry(channel).or_insert_with(|| {
                let frame = header.map_or(&b""[..], |header| header.frame);
                let frame = &frame[..frame.len().min(LONGEST_NAME)];
                (Stamps::NONE, String::from_utf8_lossy(frame).into_owned())
            });
            stamps.count(&sent, header.as_ref(), is_good);
        }
        _ => {}
    })?;
    let (mut topics, mut others) = (BTreeMap::<(String, Kind), Topic>::new(), BTreeSet::new());
    for (channel, (schema, name, is_cdr)) in channels {
        let kind = kinds.get(&(channel.0, schema)).filter(|_| is_cdr);
        match (kind, stamps.remove(&channel)) {
            (Some(&kind), Some((mut stamps, frame))) => {
                stamps.good = stamps.good.saturating_sub(tracks.held(&channel));
                let topic = topics.entry((name.clone(), kind)).or_insert_with(|| Topic {
                    channels: Vec::new(),
                    name,
                    frame,
                    kind,
                    stamps: Stamps::NONE,
                });
                topic.channels.push(channel);
                topic.stamps.add(stamps);
            }
            (Some(_), None) => {}
            (None, _) => {
                others.insert(name);
            }
        }
    }
    let mut topics: Vec<Topic> = topics.into_values().collect();
    // Topics with "raw" in their name come last.
    topics.sort_by_key(|topic| (topic.name.contains("raw"), topic.name.clone()));
    Ok((topics, others, damages))
}
