//! `hovernav ground`: the ground station, until a signal or `--duration` ends it.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use anyhow::Context as _;
use hovernav_dataset::{HeadingReference, Manifest};
use hovernav_ground::decode::Protocol;
use hovernav_ground::folder::Folder;
use hovernav_ground::frames::Rigging;
use hovernav_ground::link::{Link, Source};
use hovernav_ground::server::{Access, Bound, ServerConfig};
use hovernav_ground::station::Station;
use hovernav_ground::tiles::Tiles;
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::arguments::read_fly_config;

#[derive(clap::Args)]
pub struct Arguments {
    /// The link to the vehicle: a serial port with an optional speed, such as /dev/ttyUSB0:57600, udp:PORT for a
    /// program on this computer, or udp:ADDRESS:PORT with this computer's address in the vehicle's network (0.0.0.0:
    /// any); without a link, recorded flights can be viewed
    #[arg(value_name = "LINK")]
    link: Option<Source>,
    /// The protocol of the vehicle [default: detected]
    #[arg(long, value_enum)]
    protocol: Option<ProtocolArgument>,
    /// The vehicle's fly.toml, for the trim and travel of its channels and the mounting of its sensors
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// The directory of the records
    #[arg(long, value_name = "DIR", default_value = "records")]
    folder: PathBuf,
    /// A directory of map tiles, z/x/y.png, .jpg or .webp in Web Mercator, drawn below the track
    #[arg(long, value_name = "DIR")]
    tiles: Option<PathBuf>,
    /// Start a recording at once, under this name
    #[arg(long, value_name = "NAME")]
    record: Option<String>,
    /// The address to serve the page at; any address except loopback requires a token
    #[arg(long, value_name = "ADDRESS", default_value_t = IpAddr::V4(Ipv4Addr::LOCALHOST))]
    address: IpAddr,
    /// The port to serve the page at; 0 selects a free port
    #[arg(long, value_name = "PORT", default_value_t = 8033)]
    port: u16,
    /// The token that the page requires, 16 to 128 characters [default: random, where one is needed]
    #[arg(long, value_name = "TOKEN", value_parser = token)]
    token: Option<String>,
    /// End after this many seconds; otherwise Ctrl-C or SIGTERM ends the program
    #[arg(long, value_name = "SECONDS", value_parser = crate::arguments::duration)]
    duration: Option<f64>,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum ProtocolArgument {
    /// The packed telemetry frames of hovernav
    Frames,
    /// MAVLink, 1 or 2
    Mavlink,
}

fn token(text: &str) -> Result<String, String> {
    let plain = text.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '_'));
    if plain && (16..=128).contains(&text.len()) {
        Ok(text.to_owned())
    } else {
        Err("expected 16 to 128 letters, digits, - and _".into())
    }
}

pub fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let (rigging, manifest, geofence) = match &arguments.config {
        Some(path) => {
            let config = read_fly_config(path)?;
            let (channels, swashplate) = (config.servo.channels, config.servo.swashplate);
            let autopilot = config.autopilot.as_ref();
            let geofence = autopilot.and_then(|own| own.geofence_about(config.site.as_ref()));
            (Rigging { channels, swashplate }, config.navigation, geofence)
        }
        None => (Rigging::default(), Manifest::default(), None),
    };
    let mut manifest = manifest;
    // Telemetry carries the attitude of the estimator, not of the inertial unit.
    manifest.imu.heading_reference = HeadingReference::True;
    let folder = Folder::open(&arguments.folder)
        .with_context(|| format!("cannot create {}", arguments.folder.display()))?;
    let tiles = match &arguments.tiles {
        Some(root) => {
            Some(Tiles::open(root).with_context(|| format!("--tiles {}", root.display()))?)
        }
        None => None,
    };
    let protocol = arguments.protocol.map(|protocol| match protocol {
        ProtocolArgument::Frames => Protocol::Frames,
        ProtocolArgument::Mavlink => Protocol::Mavlink,
    });
    let name = arguments.link.as_ref().map_or_else(|| "no link".into(), ToString::to_string);
    let mut station = Station::new(rigging, protocol, &name);
    if let Some(name) = &arguments.record {
        station.record(&folder.record(name)?, name)?;
    }
    // Without a link no frames are requested, and missing telemetry raises no alarm.
    station.want_frames(arguments.link.is_some());
    let station = Arc::new(Mutex::new(station));
    let access = Access::new(arguments.address.is_loopback(), arguments.token.clone())
        .context("cannot generate a random token; set one with --token")?;
    let page_token = access.token().map(|token| format!("#token={token}")).unwrap_or_default();
    let address = SocketAddr::new(arguments.address, arguments.port);
    let command = std::env::current_exe().ok();
    let config = ServerConfig { address, access, folder, command, manifest, geofence, tiles };
    let bound = Bound::new(config, Arc::clone(&station))
        .with_context(|| format!("cannot serve at {address}"))?;
    let _link = match &arguments.link {
        Some(source) => Some(Link::open(source, Arc::clone(&station))?),
        None => None,
    };

    if let Some(Source::Serial { path, .. }) = &arguments.link
        && !Path::new(path).exists()
    {
        crate::output::complain(format_args!(
            "warning: {path}: no such port, expected one such as /dev/ttyUSB0 or udp:PORT; the station opens it as soon as it appears"
        ));
    }
    let stop = crate::stop::when_asked(&[SIGINT, SIGTERM])?;
    let page = bound.address();
    crate::output::say(format_args!("ready: {name}, page at http://{page}/{page_token}"));
    crate::stop::after(arguments.duration, &stop);
    bound.run(&stop).context("cannot continue to serve the page")?;
    if let Some(recording) = hovernav_ground::link::lock(&station).stop_recording() {
        crate::output::say(format_args!("recorded {} frames", recording.frames));
    }
    Ok(())
}
