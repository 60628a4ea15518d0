//! One client: its source, its watched channels, and the messages to it.

use std::sync::Arc;

use serde_json::{Value, json};

use super::request::{Request, channels};
use super::shared::Shared;
use crate::channel::Id;
use crate::lamps::{control, lamps, value_names};
use crate::link::lock;
use crate::player::Player;
use crate::series::Point;
use crate::store::Store;
use crate::test_points::TestPoints;
use crate::tiles::Tiles;

/// Largest number of points of one channel in a message; a view gets more.
const BURST: usize = 4000;
/// Largest number of texts in a message.
const TEXTS: usize = 200;

/// The source that a client watches.
enum Source {
    Live,
    Record(Player),
}

/// One client.
pub struct Session {
    shared: Arc<Shared>,
    source: Source,
    watched: Vec<Id>,
    /// The data already sent: up to this time, and this number of texts and markers.
    sent_s: f64,
    texts: u64,
    markers: u64,
    /// Whether the source or the position changed, so that the client must redraw.
    turned: bool,
}

impl Session {
    pub fn new(shared: Arc<Shared>) -> Self {
        let watched = Vec::new();
        let sent_s = f64::NEG_INFINITY;
        Self { shared, source: Source::Live, watched, sent_s, texts: 0, markers: 0, turned: true }
    }

    /// The first message to a client.
    pub fn hello(&self) -> Value {
        let channels: Vec<Value> = Id::all()
            .map(|id| {
                let channel = id.channel();
                let (below, above) = channel.alarm;
                json!({
                    "name": channel.name, "label": channel.label, "unit": channel.unit,
                    "group": channel.group, "digits": channel.digits,
                    "alarm": [finite(below), finite(above)],
                    "names": value_names(id),
                    "sigma": channel.sigma.map(|id| id.channel().name),
                })
            })
            .collect();
        let geofence = self.shared.config.geofence.map(|geofence| {
            json!({
                "lat_deg": geofence.centre.latitude_deg(), "lon_deg": geofence.centre.longitude_deg(),
                "radius_m": geofence.radius_m,
            })
        });
        let zooms = self.shared.config.tiles.as_ref().map_or(&[][..], Tiles::zooms);
        json!({"hello": {
            "version": env!("CARGO_PKG_VERSION"), "channels": channels, "geofence": geofence, "zooms": zooms,
        }})
    }

    /// Handles a request. Returns the answer, if there is one.
    ///
    /// # Errors
    /// The reason of the failure, for the user.
    pub fn handle(&mut self, request: Request) -> Result<Option<Value>, String> {
        let shared = Arc::clone(&self.shared);
        match request {
            Request::Watch { channels: names } => {
                self.watched = channels(names.iter().map(String::as_str))?;
            }
            Request::View { id, from, to, columns } => {
                let view = self.with_store(|store| {
                    let series = self.watched.iter().map(|&id| {
                        let plotted = store.series(id).plotted(from, to, columns);
                        (id.channel().name.to_owned(), points(&plotted))
                    });
                    Value::Object(series.collect())
                });
                return Ok(Some(
                    json!({"view": {"id": id, "from": from, "to": to, "series": view}}),
                ));
            }
            Request::Record { name } => shared.record(&name)?,
            Request::Stop {} => {
                let recording = lock(&shared.station).stop_recording();
                let recording = recording.ok_or("no record is being written")?;
                return Ok(Some(json!({"recorded": recording})));
            }
            Request::List {} => {
                let records = shared.config.folder.list().map_err(|error| error.to_string())?;
                return Ok(Some(json!({"records": records})));
            }
            Request::Open { name } => {
                self.turn(Source::Record(Player::new(shared.load(&name)?)));
            }
            Request::Live {} => self.turn(Source::Live),
            Request::Seek { to } => {
                self.player()?.seek(to);
                self.sent_s = f64::NEG_INFINITY;
                self.turned = true;
            }
            Request::Play { speed } => {
                let player = self.player()?;
                let before_s = player.position_s();
                player.play(speed);
                if player.position_s() < before_s {
                    self.sent_s = f64::NEG_INFINITY;
                    self.turned = true;
                }
            }
            Request::Pause {} => self.player()?.pause(),
            Request::Mark { note } => match self.source {
                Source::Live => {
                    let mut station = lock(&shared.station);
                    let at_s = station.now_s();
                    station.mark(at_s, &note);
                }
                Source::Record(_) => return Err(
                    "found an open record, expected the live vehicle: a finished record cannot be marked"
                        .into(),
                ),
            },
            Request::Flow { on } => lock(&shared.station).want_frames(on),
            Request::Evaluate { name } => shared.evaluate(&name)?,
        }
        Ok(None)
    }

    fn turn(&mut self, source: Source) {
        self.source = source;
        (self.sent_s, self.texts, self.markers) = (f64::NEG_INFINITY, 0, 0);
        self.turned = true;
    }

    fn player(&mut self) -> Result<&mut Player, String> {
        match &mut self.source {
            Source::Record(player) => Ok(player),
            Source::Live => Err("found the live vehicle, expected an open record".into()),
        }
    }

    fn with_store<T>(&self, look: impl FnOnce(&Store) -> T) -> T {
        match &self.source {
            Source::Live => look(&lock(&self.shared.station).store),
            Source::Record(player) => look(&player.record.store),
        }
    }

    /// The data since the last call, `elapsed_s` ago: the present values, and the new points of the watched channels.
    /// `t` is the present time or the position in the record, `newest` that of the newest data.
    pub fn tick(&mut self, elapsed_s: f64) -> Value {
        if let Source::Record(player) = &mut self.source {
            player.advance(elapsed_s);
        }
        let sent_s = self.sent_s;
        let mut turned = std::mem::take(&mut self.turned);
        let mut until_s = sent_s;
        let mut message = |store: &Store, at_s: f64, newest_s: f64, value: &dyn Fn(Id) -> f64| {
            until_s = newest_s.max(sent_s);
            // After the first values, the client must redraw.
            turned |= !sent_s.is_finite() && until_s.is_finite();
            let now: Vec<Value> = Id::all().map(|id| finite(value(id))).collect();
            let new: serde_json::Map<String, Value> = self
                .watched
                .iter()
                // Points before the client's first view are sent together with the view.
                .filter(|_| sent_s.is_finite() && !turned)
                .filter_map(|&id| {
                    let new: Vec<Point> =
                        store.series(id).between(sent_s, until_s).take(BURST).collect();
                    (!new.is_empty()).then(|| (id.channel().name.to_owned(), points(&new)))
                })
                .collect();
            let t = if until_s.is_finite() { finite(at_s) } else { Value::Null };
            json!({"tick": {
                "t": t, "newest": finite(until_s), "turned": turned, "now": now, "points": new,
            }})
        };
        let message = match &self.source {
            Source::Live => {
                let station = lock(&self.shared.station);
                let now_s = station.now_s();
                let newest_s = station.store.span().map_or(f64::NEG_INFINITY, |(_, to_s)| to_s);
                let at_s = station.present_s(now_s).max(newest_s);
                message(&station.store, at_s, newest_s, &|id| station.latest(id, now_s))
            }
            Source::Record(player) => {
                let (store, at_s) = (&player.record.store, player.position_s());
                message(store, at_s, at_s, &|id| store.at(id, at_s))
            }
        };
        self.sent_s = until_s;
        message
    }

    /// The state of link, record and vehicle, sent several times a second.
    pub fn state(&mut self) -> Value {
        let (mut texts, mut markers): (Vec<_>, Vec<_>) = (Vec::new(), Vec::new());
        let mut numbers = (self.texts, self.markers);
        let mut station = lock(&self.shared.station);
        let now = station.now_s();
        station.tick(now);
        let (link, recording) = (station.link(now), station.recording());
        let describe = |store: &Store,
                        test_points: &TestPoints,
                        at_s: f64,
                        silence: Option<&str>,
                        value: &dyn Fn(Id) -> f64| {
            let alarms: Vec<Value> = Id::all()
                .filter(|&id| id.channel().alarms(value(id)))
                .map(|id| json!([id.channel().name, value(id)]))
                .collect();
            let under_way = test_points.under_way().filter(|_| silence.is_none());
            json!({
                "since": store.in_mode_since(at_s), "span": store.span(), "home": store.home(), "silence": silence,
                "lamps": lamps(value, silence), "control": control(value, silence),
                "alarms": alarms, "steps": test_points.steps(),
                "progress": test_points.progress(), "under_way": under_way,
            })
        };
        let mut collect = |store: &Store| {
            let (new, first) = store.texts_from(self.texts);
            texts = new.take(TEXTS).cloned().collect();
            numbers.0 = first + texts.len() as u64;
            let (new, first) = store.markers_from(self.markers);
            markers = new.cloned().collect();
            numbers.1 = first + markers.len() as u64;
        };
        let (what, record) = match &self.source {
            Source::Live => {
                collect(&station.store);
                let (at_s, silence) = (station.present_s(now), station.silence(now));
                let (store, points) = (&station.store, &station.test_points);
                let value = |id| station.latest(id, now);
                (describe(store, points, at_s, silence.as_deref(), &value), Value::Null)
            }
            Source::Record(player) => {
                drop(station);
                let loaded = &player.record;
                collect(&loaded.store);
                let (plays, speed) = player.state();
                let record = json!({
                    "name": loaded.name, "is_cut": loaded.is_cut, "plays": plays, "speed": speed,
                    "at": player.position_s(),
                });
                let (store, at_s) = (&loaded.store, player.position_s());
                let value = |id| store.at(id, at_s);
                (describe(store, &loaded.test_points, at_s, None, &value), record)
            }
        };
        (self.texts, self.markers) = numbers;
        json!({"state": {
            "time": now, "link": link, "recording": recording, "record": record, "what": what,
            "texts": texts, "markers": markers, "job": self.shared.job(),
        }})
    }
}

/// A number, or `null` if it is not finite.
fn finite(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}

/// Times and values as separate arrays, as the plots expect them.
fn points(points: &[Point]) -> Value {
    let times: Vec<f64> = points.iter().map(|point| point.0).collect();
    let values: Vec<Value> = points.iter().map(|point| finite(point.1)).collect();
    json!([times, values])
}
