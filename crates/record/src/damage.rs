//! Damage of a record, and the description of a repair in the repaired file.

use std::collections::BTreeMap;
use std::fmt;

use mcap::records::Metadata;

/// Name of the repair's metadata.
const NAME: &str = "hovernav.repair";

/// An unreadable part of a record's file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Byte offset of its start.
    pub offset: usize,
    /// Number of bytes lost; 0 if a file ends between two records.
    pub bytes: usize,
    /// Reason.
    pub reason: String,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at byte {}: {}", self.offset, self.reason)
    }
}

/// Description of a repair and of the earlier losses, in the metadata of the file, which is itself intact.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Repair {
    /// Version of hovernav that repaired the file.
    pub version: String,
    /// Length of the damaged file, bytes.
    pub bytes: u64,
    /// Number of bytes lost from the damaged file.
    pub bytes_lost: u64,
    /// Whether the original file had been ended regularly, not cut off.
    pub was_ended: bool,
    /// Damages, one plain sentence each.
    pub damages: Vec<String>,
}

impl Repair {
    /// Description of the repair of a file of `bytes` with these `damages`, after an `earlier` repair, if any.
    pub(super) fn new(
        bytes: u64,
        damages: &[Damage],
        was_ended: bool,
        earlier: Option<Self>,
    ) -> Self {
        let lost: usize = damages.iter().map(|damage| damage.bytes).sum();
        let mut repair = earlier.unwrap_or_else(|| Self {
            version: String::new(),
            bytes,
            bytes_lost: 0,
            was_ended,
            damages: Vec::new(),
        });
        repair.version = env!("CARGO_PKG_VERSION").into();
        repair.bytes_lost += lost as u64;
        repair.was_ended &= was_ended;
        repair.damages.extend(damages.iter().map(Damage::to_string));
        repair
    }

    /// The metadata in the file.
    pub(super) fn metadata(&self) -> Metadata {
        let mut metadata = BTreeMap::from([
            ("version".to_owned(), self.version.clone()),
            ("bytes".to_owned(), self.bytes.to_string()),
            ("bytes_lost".to_owned(), self.bytes_lost.to_string()),
            ("was_ended".to_owned(), self.was_ended.to_string()),
        ]);
        // Keys are sorted as text.
        metadata.extend(
            (1..)
                .zip(&self.damages)
                .map(|(number, damage): (u32, _)| (format!("damage_{number:06}"), damage.clone())),
        );
        Metadata { name: NAME.into(), metadata }
    }

    /// Description in `metadata`; `None` for other metadata.
    pub(super) fn of(metadata: &Metadata) -> Option<Self> {
        let own = Some(&metadata.metadata).filter(|_| metadata.name == NAME)?;
        let text = |key: &str| own.get(key).map(String::as_str);
        let number = |key| text(key).and_then(|digits| digits.parse().ok()).unwrap_or_default();
        Some(Self {
            version: text("version").unwrap_or_default().into(),
            bytes: number("bytes"),
            bytes_lost: number("bytes_lost"),
            was_ended: text("was_ended") == Some("true"),
            damages: own
                .iter()
                .filter(|(key, _)| key.starts_with("damage_"))
                .map(|(_, damage)| damage.clone())
                .collect(),
        })
    }

    /// A sentence for each damage of the original of `name`.
    pub(super) fn warnings(&self, name: &str) -> impl Iterator<Item = String> {
        self.damages.iter().map(move |damage| format!("{name}: before its repair, {damage}"))
    }
}

impl fmt::Display for Repair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { version, bytes, bytes_lost, damages, .. } = self;
        let places = if damages.len() == 1 { "place" } else { "places" };
        write!(
            f,
            "by hovernav {version}: {bytes_lost} of {bytes} bytes were lost, in {} {places}",
            damages.len()
        )
    }
}
