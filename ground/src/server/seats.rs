//! A limited number of slots, shared fairly between addresses.

use std::collections::HashMap;
use std::net::{IpAddr, Ipv6Addr};
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};

use tokio::sync::oneshot;

/// Slots for connections. While all slots are taken, an address with fewer slots takes one from the address with the
/// most. Connections from other addresses therefore cannot shut out an operator.
#[derive(Clone)]
pub struct Seats {
    room: usize,
    taken: Arc<Mutex<Taken>>,
}

/// The taken slots of each address, oldest first. Each has a number, and a sender that ends the connection when it is
/// dropped.
#[derive(Default)]
struct Taken {
    next: u64,
    of: HashMap<IpAddr, Vec<(u64, oneshot::Sender<()>)>>,
}

impl Taken {
    fn count(&self) -> usize {
        self.of.values().map(Vec::len).sum()
    }

    /// The address with the most slots. `None` unless that address has more slots than `address` would have with one
    /// more.
    fn greediest(&self, address: IpAddr) -> Option<IpAddr> {
        let own = self.of.get(&address).map_or(0, Vec::len);
        let (greediest, held) = self.of.iter().max_by_key(|(_, held)| held.len())?;
        (held.len() > own + 1).then_some(*greediest)
    }

    fn remove(&mut self, address: IpAddr, number: u64) {
        if let Some(held) = self.of.get_mut(&address) {
            held.retain(|(own, _)| *own != number);
            if held.is_empty() {
                self.of.remove(&address);
            }
        }
    }
}

/// The network of an address that a host cannot choose by itself: a host has a whole /64 network of IPv6 addresses.
fn host(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(v6) => IpAddr::V6(Ipv6Addr::from_bits(v6.to_bits() & !u128::from(u64::MAX))),
        v4 => v4,
    }
}

impl Seats {
    pub fn new(room: usize) -> Self {
        Self { room, taken: Arc::default() }
    }

    /// Whether [`take`](Self::take) would succeed.
    pub fn has_room(&self, address: IpAddr) -> bool {
        let taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        taken.count() < self.room || taken.greediest(host(address)).is_some()
    }

    /// A slot for `address`, if necessary the newest slot of the address with the most; `None` if no address has more.
    pub fn take(&self, address: IpAddr) -> Option<Seat> {
        let address = host(address);
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        if taken.count() >= self.room {
            let greediest = taken.greediest(address)?;
            // Dropping the sender ends that connection.
            taken.of.get_mut(&greediest)?.pop();
        }
        let (stays, ended) = oneshot::channel();
        let number = taken.next;
        taken.next += 1;
        taken.of.entry(address).or_default().push((number, stays));
        Some(Seat { taken: Arc::clone(&self.taken), address, number, ended })
    }
}

/// One slot, freed when dropped.
pub struct Seat {
    taken: Arc<Mutex<Taken>>,
    address: IpAddr,
    number: u64,
    ended: oneshot::Receiver<()>,
}

impl Seat {
    /// Ready once another address has taken the slot.
    pub fn poll_lost(&mut self, context: &mut Context<'_>) -> Poll<()> {
        Pin::new(&mut self.ended).poll(context).map(|_| ())
    }

    /// Waits until another address has taken the slot.
    pub async fn lost(&mut self) {
        std::future::poll_fn(|context| self.poll_lost(context)).await;
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        taken.remove(self.address, self.number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_lost(seat: &mut Seat) -> bool {
        let mut context = Context::from_waker(std::task::Waker::noop());
        seat.poll_lost(&mut context).is_ready()
    }

    #[test]
    fn addresses_that_hold_every_slot_give_one_to_another_and_keep_their_oldest() {
        let seats = Seats::new(6);
        let [a, b, operator] = [1, 2, 3].map(|last| IpAddr::from([10, 0, 0, last]));
        let mut held: Vec<_> =
            (0..3).flat_map(|_| [a, b]).map(|address| seats.take(address).unwrap()).collect();
        assert!(seats.take(a).is_none() && seats.take(b).is_none());
        let mut own = [seats.take(operator).unwrap(), seats.take(operator).unwrap()];
        let lost: Vec<bool> = held.iter_mut().map(is_lost).collect();
        assert_eq!(lost, [false, false, false, false, true, true]);
        // All addresses have two slots now, and keep them.
        assert!([a, b, operator].iter().all(|address| !seats.has_room(*address)));
        assert!([a, b, operator].iter().all(|address| seats.take(*address).is_none()));
        assert!(!own.iter_mut().any(is_lost));
        drop((held, own));
        assert!(seats.taken.lock().unwrap().of.is_empty());
    }

    #[test]
    fn a_network_of_addresses_is_one_host() {
        let seats = Seats::new(4);
        let of = |text: &str| text.parse::<IpAddr>().unwrap();
        let mut held: Vec<_> =
            (1..5).map(|last| seats.take(of(&format!("2001:db8::{last}"))).unwrap()).collect();
        assert!(seats.take(of("2001:db8::ffff")).is_none());
        let one = seats.take(of("10.0.0.1")).unwrap();
        assert!(is_lost(&mut held[3]) && !is_lost(&mut held[0]));
        assert_eq!(one.address, host(of("::ffff:10.0.0.1")));
    }
}
