//! What all clients share: the station, the folder, the records that are open.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use hovernav_log::Manifest;

use crate::evaluate::{Evaluation, Job, SharedJob};
use crate::folder::Folder;
use crate::link::{SharedStation, lock};
use crate::player::Loaded;

/// Records that are kept in memory; the one opened first goes first.
const OPEN: usize = 3;

/// What all clients share.
pub struct Shared {
    pub station: SharedStation,
    pub folder: Folder,
    /// The command that evaluates records.
    pub command: Option<PathBuf>,
    /// How the sensors are mounted.
    pub manifest: Manifest,
    loaded: Mutex<Vec<Arc<Loaded>>>,
    job: SharedJob,
}

impl Shared {
    pub fn new(
        station: SharedStation,
        folder: Folder,
        command: Option<PathBuf>,
        manifest: Manifest,
    ) -> Self {
        let (loaded, job) = (Mutex::default(), SharedJob::default());
        Self { station, folder, command, manifest, loaded, job }
    }

    /// Records to a new file of this name.
    pub fn record(&self, name: &str) -> Result<(), String> {
        let file = self.folder.record(name).map_err(|error| error.to_string())?;
        lock(&self.station).record(&file, name).map_err(|error| error.to_string())
    }

    /// The record of this name, read where it is not open yet.
    pub fn load(&self, name: &str) -> Result<Arc<Loaded>, String> {
        let file = self.folder.record(name).map_err(|error| error.to_string())?;
        let is_growing = lock(&self.station).recording().is_some_and(|one| one.name == name);
        let mut loaded = self.loaded.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) =
            loaded.iter().find(|one| one.name == name && !one.is_cut && !is_growing)
        {
            return Ok(Arc::clone(found));
        }
        let fresh = Arc::new(Loaded::read(&file, name).map_err(|error| error.to_string())?);
        loaded.retain(|one| one.name != name);
        if loaded.len() == OPEN {
            loaded.remove(0);
        }
        loaded.push(Arc::clone(&fresh));
        Ok(fresh)
    }

    /// Estimates and identifies from the record of this name.
    pub fn evaluate(&self, name: &str) -> Result<(), String> {
        let record = self.folder.record(name).map_err(|error| error.to_string())?;
        let results = self.folder.results(name).map_err(|error| error.to_string())?;
        let command = self.command.clone().ok_or("this station cannot run hovernav")?;
        if !record.is_file() {
            return Err(format!("found no record {name}"));
        }
        if lock(&self.station).recording().is_some_and(|one| one.name == name) {
            return Err(format!("found {name} being written, expected a record that is ended"));
        }
        let (name, manifest) = (name.to_owned(), self.manifest.clone());
        let evaluation = Evaluation { command, name, record, results, manifest };
        if evaluation.spawn(&self.job) {
            Ok(())
        } else {
            Err("found another evaluation running, expected none".into())
        }
    }

    /// The last evaluation.
    pub fn job(&self) -> Option<Job> {
        self.job.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
