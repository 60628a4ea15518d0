//! Connections: a limited number, without idle ones.

use std::collections::HashMap;
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
use std::time::Duration;

use axum::serve::Listener;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Sleep, sleep};

/// Idle time after which a connection is closed.
const SILENT: Duration = Duration::from_secs(60);
/// Pause after a failed accept.
const RETRY: Duration = Duration::from_millis(100);

/// A listener with a limited number of connections; further ones wait until one ends. One address gets at most three
/// quarters of them, so that idle connections of one host cannot block all others.
pub struct Limited {
    listener: TcpListener,
    room: Arc<Semaphore>,
    seats: Seats,
}

impl Limited {
    pub fn new(listener: TcpListener, connections: usize) -> Self {
        let room = Arc::new(Semaphore::new(connections));
        let seats = Seats { of_one: connections * 3 / 4, taken: Arc::default() };
        Self { listener, room, seats }
    }
}

/// The number of connections of each address, and its limit.
struct Seats {
    of_one: usize,
    taken: Arc<Mutex<HashMap<IpAddr, usize>>>,
}

impl Seats {
    /// A connection slot for `address`; `None` at its limit.
    fn take(&self, address: IpAddr) -> Option<Seat> {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        let count = taken.entry(address).or_default();
        if *count >= self.of_one {
            return None;
        }
        *count += 1;
        Some(Seat { taken: Arc::clone(&self.taken), address })
    }
}

/// One connection slot of an address, freed when dropped.
struct Seat {
    taken: Arc<Mutex<HashMap<IpAddr, usize>>>,
    address: IpAddr,
}

impl Drop for Seat {
    fn drop(&mut self) {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(count) = taken.get_mut(&self.address) {
            *count -= 1;
            if *count == 0 {
                taken.remove(&self.address);
            }
        }
    }
}

impl Listener for Limited {
    type Io = Connection;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Connection, SocketAddr) {
        loop {
            let Ok(permit) = Arc::clone(&self.room).acquire_owned().await else {
                // The semaphore is never closed.
                sleep(RETRY).await;
                continue;
            };
            match self.listener.accept().await {
                Ok((stream, address)) => {
                    let Some(seat) = self.seats.take(address.ip()) else { continue };
                    // Small messages are sent at once, because late ones are useless.
                    let _ = stream.set_nodelay(true);
                    let silence = Box::pin(sleep(SILENT));
                    let connection = Connection { stream, silence, _places: (permit, seat) };
                    return (connection, address);
                }
                Err(_) => sleep(RETRY).await,
            }
        }
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }
}

/// A connection that frees its slots when it ends.
pub struct Connection {
    stream: TcpStream,
    silence: Pin<Box<Sleep>>,
    _places: (OwnedSemaphorePermit, Seat),
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        if let Poll::Ready(read) = Pin::new(&mut self.stream).poll_read(context, buffer) {
            let until = tokio::time::Instant::now() + SILENT;
            self.silence.as_mut().reset(until);
            return Poll::Ready(read);
        }
        match self.silence.as_mut().poll(context) {
            Poll::Ready(()) => Poll::Ready(Err(io::ErrorKind::TimedOut.into())),
            Poll::Pending => Poll::Pending,
        }
    }
}

impl AsyncWrite for Connection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(context, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_that_has_enough_leaves_room_for_others_and_gets_it_back() {
        let seats = Seats { of_one: 3, taken: Arc::default() };
        let [one, other] = [1, 2].map(|last| IpAddr::from([10, 0, 0, last]));
        let mut held: Vec<_> = (0..3).map(|_| seats.take(one).unwrap()).collect();
        assert!(seats.take(one).is_none());
        assert!(seats.take(other).is_some());
        held.pop();
        assert!(seats.take(one).is_some());
        held.clear();
        assert!(seats.taken.lock().unwrap().is_empty());
    }
}
