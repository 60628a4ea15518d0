//! Emulated time, which passes only while every thread of the emulation waits.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, Thread};

use super::wire::Wire;
use hovernav::time::Time;

/// The time and the serial lines that the threads of an emulation share.
///
/// One thread runs at a time. A waiting thread holds a ticket; the earliest ticket runs next, and of equal ones the
/// one issued first. The order of events therefore depends only on the threads, not on the machine.
#[derive(Debug)]
pub(super) struct Emulation {
    state: Mutex<State>,
    wires: Mutex<BTreeMap<PathBuf, Arc<Wire>>>,
}

#[derive(Debug)]
struct State {
    now: Time,
    /// Number of tickets issued.
    taken: u64,
    /// Tickets of the waiting threads.
    tickets: Vec<Ticket>,
    /// Ticket of the running thread.
    running: u64,
    /// Time until which each processor is held.
    held_until: Vec<Time>,
}

#[derive(Debug)]
struct Ticket {
    number: u64,
    at: Time,
    /// Signal that ends the wait early.
    signal: Option<u64>,
    processor: usize,
    thread: Thread,
}

impl Emulation {
    /// An emulation with the calling thread only, on processor 0.
    pub fn begin() -> Self {
        let state = State {
            now: Time::ZERO,
            taken: 0,
            tickets: Vec::new(),
            running: 0,
            held_until: vec![Time::ZERO],
        };
        Self { state: Mutex::new(state), wires: Mutex::default() }
    }

    pub fn now(&self) -> Time {
        self.state().now
    }

    /// Number of a new processor.
    pub fn add_processor(&self) -> usize {
        let mut state = self.state();
        state.held_until.push(Time::ZERO);
        state.held_until.len() - 1
    }

    /// Runs no thread of `processor` before `time`.
    pub fn hold_until(&self, processor: usize, time: Time) {
        let mut state = self.state();
        let held_until = &mut state.held_until[processor];
        *held_until = time.max(*held_until);
    }

    /// Lets the other threads run until `at`, or until `signal` is raised.
    pub fn wait(&self, processor: usize, at: Time, signal: Option<u64>) {
        let mut state = self.state();
        let at = at.max(state.now);
        let number = state.take_ticket(processor, at, signal, thread::current());
        state.run_next();
        drop(state);
        self.wait_for_turn(number);
    }

    /// Wakes the threads that wait for `signal`.
    pub fn raise(&self, signal: u64) {
        let mut state = self.state();
        let now = state.now;
        for ticket in state.tickets.iter_mut().filter(|ticket| ticket.signal == Some(signal)) {
            ticket.at = now;
        }
    }

    /// Reserves a ticket number for a thread before it starts.
    pub fn reserve(&self) -> u64 {
        self.state().next_number()
    }

    /// Adds `thread` with its reserved ticket, to run as soon as possible.
    pub fn admit(&self, number: u64, processor: usize, thread: Thread) {
        let mut state = self.state();
        let at = state.now;
        state.tickets.push(Ticket { number, at, signal: None, processor, thread });
    }

    /// Waits for the turn of the ticket.
    pub fn wait_for_turn(&self, number: u64) {
        while self.state().running != number {
            thread::park();
        }
    }

    /// Ends the calling thread; another runs.
    pub fn leave(&self) {
        self.state().run_next();
    }

    /// The serial lines by path.
    pub fn wires(&self) -> MutexGuard<'_, BTreeMap<PathBuf, Arc<Wire>>> {
        self.wires.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The serial line at `path`.
    pub fn wire(&self, path: &Path) -> Option<Arc<Wire>> {
        self.wires().get(path).map(Arc::clone)
    }

    /// A panic in another thread leaves this state consistent.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn next_number(&mut self) -> u64 {
        self.taken += 1;
        self.taken
    }

    fn take_ticket(
        &mut self,
        processor: usize,
        at: Time,
        signal: Option<u64>,
        thread: Thread,
    ) -> u64 {
        let number = self.next_number();
        self.tickets.push(Ticket { number, at, signal, processor, thread });
        number
    }

    /// Runs the thread with the earliest ticket.
    fn run_next(&mut self) {
        let at = |ticket: &Ticket| ticket.at.max(self.held_until[ticket.processor]);
        let tickets = self.tickets.iter().enumerate();
        let Some((index, time)) = tickets
            .map(|(index, ticket)| (index, (at(ticket), ticket.number)))
            .min_by_key(|(_, key)| *key)
            .map(|(index, (time, _))| (index, time))
        else {
            return;
        };
        let next = self.tickets.swap_remove(index);
        self.now = self.now.max(time);
        self.running = next.number;
        next.thread.unpark();
    }
}
