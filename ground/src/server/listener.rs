//! Connections: a limited number, without idle and stuck ones.

use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::extract::connect_info::Connected;
use axum::serve::{IncomingStream, Listener};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::{Sleep, sleep};

use super::seats::{Seat, Seats};

/// Idle time after which a connection is closed.
const SILENT: Duration = Duration::from_secs(60);
/// Time after which a connection whose client reads nothing is closed.
const STUCK: Duration = Duration::from_secs(20);
/// Pause after a failed accept.
const RETRY: Duration = Duration::from_millis(100);

/// A listener with a limited number of connections. Further ones are closed at once; see [`Seats`].
pub struct Limited {
    listener: TcpListener,
    seats: Seats,
}

impl Limited {
    pub fn new(listener: TcpListener, connections: usize) -> Self {
        Self { listener, seats: Seats::new(connections) }
    }
}

/// The address of a client.
#[derive(Clone, Copy)]
pub struct Peer(pub SocketAddr);

impl Connected<IncomingStream<'_, Limited>> for Peer {
    fn connect_info(stream: IncomingStream<'_, Limited>) -> Self {
        Self(*stream.remote_addr())
    }
}

impl Listener for Limited {
    type Io = Connection;
    type Addr = SocketAddr;

    async fn accept(&mut self) -> (Connection, SocketAddr) {
        loop {
            match self.listener.accept().await {
                Ok((stream, address)) => {
                    let Some(seat) = self.seats.take(address.ip()) else { continue };
                    // Small messages are sent at once, because late ones are useless.
                    let _ = stream.set_nodelay(true);
                    let silence = Box::pin(sleep(SILENT));
                    return (Connection { stream, silence, stuck: None, seat }, address);
                }
                Err(_) => sleep(RETRY).await,
            }
        }
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }
}

/// A connection that frees its slot when it ends.
pub struct Connection {
    stream: TcpStream,
    silence: Pin<Box<Sleep>>,
    /// Timeout that runs since the client's buffer has been full.
    stuck: Option<Pin<Box<Sleep>>>,
    seat: Seat,
}

impl Connection {
    /// Ready with an error once another address has taken the slot.
    fn poll_lost(&mut self, context: &mut Context<'_>) -> Poll<io::Error> {
        self.seat.poll_lost(context).map(|()| io::ErrorKind::ConnectionAborted.into())
    }
}

impl AsyncRead for Connection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        if let Poll::Ready(error) = self.poll_lost(context) {
            return Poll::Ready(Err(error));
        }
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
        if let Poll::Ready(error) = self.poll_lost(context) {
            return Poll::Ready(Err(error));
        }
        if let Poll::Ready(written) = Pin::new(&mut self.stream).poll_write(context, bytes) {
            self.stuck = None;
            return Poll::Ready(written);
        }
        let stuck = self.stuck.get_or_insert_with(|| Box::pin(sleep(STUCK)));
        match stuck.as_mut().poll(context) {
            Poll::Ready(()) => Poll::Ready(Err(io::ErrorKind::TimedOut.into())),
            Poll::Pending => Poll::Pending,
        }
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}
