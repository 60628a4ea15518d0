//! Writing of messages to an MCAP file.

use std::collections::BTreeMap;
use std::io::{self, Write};

use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{McapError, McapResult, WriteOptions};
use serde::Serialize;

use crate::channel::Channel;
use crate::header::Header;
use crate::message::ConfigurationMessage;
use hovernav::time::Time;

/// Writes messages to the topics of a record.
pub struct MessageWriter<W: Write> {
    mcap: mcap::Writer<NoSeek<W>>,
    channels: [u16; Channel::ALL.len()],
    pub header: Header,
    json: Vec<u8>,
    /// Number of the current or last entry.
    pub sequence: u32,
    /// Time at which the loop received that entry.
    pub now: Time,
    /// Time of the last configuration.
    configured: Time,
}

/// Interval at which the configuration is written again, s, so that a record with damaged first bytes stays readable.
const CONFIGURATION_S: f64 = 5.0;

impl<W: Write> MessageWriter<W> {
    /// Writes the beginning of the record, before the flight.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn begin(out: W, header: &Header) -> io::Result<Self> {
        let mut writer = Self::new(out, header).map_err(into_io)?;
        writer.configuration().map_err(into_io)?;
        writer.flush()?;
        Ok(writer)
    }

    /// Writes the topics, without a configuration.
    pub fn new(out: W, header: &Header) -> McapResult<Self> {
        let mut mcap = WriteOptions::new()
            .compression(None)
            .library(format!("hovernav {}", header.version))
            .chunk_size(None)
            .disable_seeking(true)
            .create(NoSeek::new(out))?;
        let mut channels = [0; Channel::ALL.len()];
        for (id, channel) in channels.iter_mut().zip(Channel::ALL) {
            let schema = channel.schema().to_string();
            let schema = mcap.add_schema(channel.schema_name(), "jsonschema", schema.as_bytes())?;
            *id = mcap.add_channel(schema, channel.topic(), "json", &BTreeMap::new())?;
        }
        Ok(Self {
            mcap,
            channels,
            header: header.clone(),
            json: Vec::new(),
            sequence: 0,
            now: header.start,
            configured: header.start,
        })
    }

    fn configuration(&mut self) -> McapResult<()> {
        let fly_toml = self.header.config.to_toml().map_err(io::Error::other)?;
        let message = ConfigurationMessage {
            version: self.header.version.clone(),
            start_ns: self.header.start.nanoseconds(),
            start_unix_ns: self.header.start_unix_ns,
            fly_toml,
        };
        self.message(Channel::Configuration, self.header.start, &message)
    }

    /// Writes the configuration again if it is due.
    pub fn configure_again(&mut self) -> McapResult<()> {
        if self.now - self.configured < CONFIGURATION_S {
            return Ok(());
        }
        self.configured = self.now;
        self.configuration()
    }

    /// Writes a message with the time of validity `time`.
    pub fn message(
        &mut self,
        channel: Channel,
        time: Time,
        message: &impl Serialize,
    ) -> McapResult<()> {
        self.json.clear();
        serde_json::to_writer(&mut self.json, message).map_err(io::Error::from)?;
        let header = MessageHeader {
            channel_id: self.channels[channel as usize],
            sequence: self.sequence,
            log_time: self.header.unix_ns(self.now),
            publish_time: self.header.unix_ns(time),
        };
        self.mcap.write_to_known_channel(&header, &self.json)
    }

    /// Copies a message from another file unchanged.
    pub fn copy(&mut self, channel: Channel, header: MessageHeader, data: &[u8]) -> McapResult<()> {
        let header = MessageHeader { channel_id: self.channels[channel as usize], ..header };
        self.mcap.write_to_known_channel(&header, data)
    }

    /// Writes metadata on the file itself.
    pub fn metadata(&mut self, metadata: &Metadata) -> McapResult<()> {
        self.mcap.write_metadata(metadata)
    }

    /// Ends the current chunk and writes it.
    pub fn flush(&mut self) -> io::Result<()> {
        self.mcap.flush().map_err(into_io)
    }

    /// Ends the file with its index.
    pub fn finish(&mut self) -> io::Result<()> {
        self.mcap.finish().map(|_| ()).map_err(into_io)
    }
}

fn into_io(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}
