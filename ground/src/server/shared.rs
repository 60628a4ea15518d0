//! The state shared by all clients: the station, the directory, the open records.

use std::sync::{Arc, Mutex, PoisonError};

use super::config::ServerConfig;
use crate::evaluate::{Evaluation, Job, SharedJob};
use crate::link::{SharedStation, lock};
use crate::player::Loaded;

/// Largest number of records in memory; the oldest is dropped first.
const OPEN: usize = 3;

/// The state shared by all clients.
pub struct Shared {
    pub station: SharedStation,
    pub config: ServerConfig,
    loaded: Mutex<Vec<Arc<Loaded>>>,
    job: SharedJob,
}

impl Shared {
    pub fn new(station: SharedStation, config: ServerConfig) -> Self {
        Self { station, config, loaded: Mutex::default(), job: SharedJob::default() }
    }

    /// Starts a record in a new file with this name.
    pub fn record(&self, name: &str) -> Result<(), String> {
        let file = self.config.folder.record(name).map_err(|error| error.to_string())?;
        lock(&self.station).record(&file, name).map_err(|error| error.to_string())
    }

    /// The record with this name, read from its file if it is not in memory.
    pub fn load(&self, name: &str) -> Result<Arc<Loaded>, String> {
        let file = self.config.folder.record(name).map_err(|error| error.to_string())?;
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

    /// Runs estimate and identify on the record with this name.
    pub fn evaluate(&self, name: &str) -> Result<(), String> {
        let record = self.config.folder.record(name).map_err(|error| error.to_string())?;
        let results = self.config.folder.results(name).map_err(|error| error.to_string())?;
        let command =
            self.config.command.clone().ok_or("this station cannot run the command hovernav")?;
        if !record.is_file() {
            return Err(format!("found no record {name}"));
        }
        if self.config.folder.results_are_elsewhere(name).map_err(|error| error.to_string())? {
            return Err(format!("found a link in the results of {name}, expected a directory"));
        }
        if lock(&self.station).recording().is_some_and(|one| one.name == name) {
            return Err(format!("found {name} still being written, expected a finished record"));
        }
        let (name, manifest) = (name.to_owned(), self.config.manifest.clone());
        let evaluation = Evaluation { command, name, record, results, manifest };
        if evaluation.spawn(&self.job) {
            Ok(())
        } else {
            Err("another evaluation is running: wait for its end".into())
        }
    }

    /// The last evaluation.
    pub fn job(&self) -> Option<Job> {
        self.job.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}
