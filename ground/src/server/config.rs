//! Configuration of the server.

use std::net::SocketAddr;
use std::path::PathBuf;

use hovernav::flight_control::Geofence;
use hovernav_dataset::Manifest;

use super::access::Access;
use crate::folder::Folder;
use crate::tiles::Tiles;

/// The configuration of the server.
pub struct ServerConfig {
    /// Address to listen on.
    pub address: SocketAddr,
    /// Access rules.
    pub access: Access,
    /// The directory of the records.
    pub folder: Folder,
    /// The executable `hovernav`, which evaluates records; `None` disables evaluation.
    pub command: Option<PathBuf>,
    /// Mounting of the vehicle's sensors.
    pub manifest: Manifest,
    /// The vehicle's geofence, for the map.
    pub geofence: Option<Geofence>,
    /// Tiles for the map.
    pub tiles: Option<Tiles>,
}
