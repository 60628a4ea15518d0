//! Playback of a record: seek, speed, pause.

use std::sync::Arc;

use crate::flight_record;
use crate::record::RecordError;
use crate::store::{Batch, Store};
use crate::test_points::TestPoints;
use crate::{channel::Id, record};

/// Range of the playback speed, as a factor of real time.
pub const SPEEDS: (f64, f64) = (0.1, 50.0);

/// A record in memory, shared by several clients.
pub struct Loaded {
    /// Name.
    pub name: String,
    /// The data.
    pub store: Store,
    /// Whether the record is truncated.
    pub is_cut: bool,
    /// The test points of the flight.
    pub test_points: TestPoints,
}

impl Loaded {
    /// Reads the record in `path`, of a ground station or of a flight computer.
    ///
    /// # Errors
    /// If the file is not a record, or cannot be read.
    pub fn read(path: &std::path::Path, name: &str) -> Result<Self, RecordError> {
        let (store, is_cut) = match record::read(path) {
            Err(RecordError::NotARecord { .. }) => {
                flight_record::read(path).map_err(|source| RecordError::Flight { source })?
            }
            read => read?,
        };
        let mut test_points = TestPoints::default();
        const STICKS: [Id; 4] =
            [Id::StickLateral, Id::StickLongitudinal, Id::StickCollective, Id::StickPedal];
        let (from_s, to_s) = (f64::NEG_INFINITY, f64::INFINITY);
        for (time_s, _) in store.series(Id::StickLateral).between(from_s, to_s) {
            let values = STICKS.map(|id| (id, store.at(id, time_s))).to_vec();
            test_points.observe(&Batch { time_s, values });
        }
        test_points.judge(&store);
        Ok(Self { name: name.to_owned(), store, is_cut, test_points })
    }
}

/// The playback position of one client.
#[derive(Clone)]
pub struct Player {
    /// The record.
    pub record: Arc<Loaded>,
    position_s: f64,
    speed: f64,
    plays: bool,
}

impl Player {
    /// A paused player at the end of the record, so that the whole record is visible.
    #[must_use]
    pub fn new(record: Arc<Loaded>) -> Self {
        let position_s = record.store.span().map_or(0.0, |(_, to_s)| to_s);
        Self { record, position_s, speed: 1.0, plays: false }
    }

    /// Moves to a time, seconds since the start of 1970, limited to the span of the record.
    pub fn seek(&mut self, time_s: f64) {
        if let Some((from_s, to_s)) = self.record.store.span()
            && !time_s.is_nan()
        {
            self.position_s = time_s.clamp(from_s, to_s);
        }
    }

    /// Plays at `speed` times real time, limited to [`SPEEDS`]. At the end of the record, playback restarts from the
    /// beginning.
    pub fn play(&mut self, speed: f64) {
        if !speed.is_nan() {
            self.speed = speed.clamp(SPEEDS.0, SPEEDS.1);
        }
        if let Some((from_s, to_s)) = self.record.store.span()
            && self.position_s >= to_s
        {
            self.position_s = from_s;
        }
        self.plays = true;
    }

    /// Pauses.
    pub fn pause(&mut self) {
        self.plays = false;
    }

    /// Advances by `elapsed_s` of the client's time, s; pauses at the end.
    pub fn advance(&mut self, elapsed_s: f64) {
        if !self.plays {
            return;
        }
        let Some((_, to_s)) = self.record.store.span() else { return };
        self.position_s = (self.position_s + elapsed_s.max(0.0) * self.speed).min(to_s);
        self.plays = self.position_s < to_s;
    }

    /// The position, seconds since the start of 1970.
    #[must_use]
    pub const fn position_s(&self) -> f64 {
        self.position_s
    }

    /// Whether the player plays, and its speed.
    #[must_use]
    pub const fn state(&self) -> (bool, f64) {
        (self.plays, self.speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_record_is_sought_and_played_within_its_ends() {
        let mut store = Store::new(1000);
        for k in 0..100 {
            store.push(&Batch { time_s: 50.0 + f64::from(k), values: vec![(Id::Roll, 1.0)] });
        }
        let test_points = TestPoints::default();
        let loaded = Loaded { name: "x".into(), store, is_cut: false, test_points };
        let mut player = Player::new(Arc::new(loaded));
        assert_eq!(player.position_s(), 149.0);
        player.play(10.0);
        assert_eq!(player.position_s(), 50.0);
        player.advance(2.0);
        assert_eq!((player.position_s(), player.state()), (70.0, (true, 10.0)));
        player.seek(1e9);
        player.advance(1.0);
        assert_eq!((player.position_s(), player.state().0), (149.0, false));
        player.seek(f64::NAN);
        player.play(f64::INFINITY);
        assert_eq!(player.state().1, SPEEDS.1);
    }
}
