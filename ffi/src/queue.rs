//! Notices that wait until the caller asks.

use hovernav::ekf::Notice;

/// More than one sample can cause: a caller that reads after each call loses none.
const ROOM: usize = 12;

/// The notices that wait; the oldest give way.
#[derive(Debug, Default)]
pub(crate) struct NoticeQueue {
    waiting: [Option<Notice>; ROOM],
    first: usize,
    count: usize,
    lost: u32,
}

impl NoticeQueue {
    /// Behind those that wait; the oldest of a full queue is lost.
    pub(crate) fn push(&mut self, notice: Notice) {
        if self.count == ROOM {
            self.first = (self.first + 1) % ROOM;
            self.count -= 1;
            self.lost = self.lost.saturating_add(1);
        }
        if let Some(slot) = self.waiting.get_mut((self.first + self.count) % ROOM) {
            *slot = Some(notice);
            self.count += 1;
        }
    }

    /// The oldest, which waits no longer.
    pub(crate) fn pop(&mut self) -> Option<Notice> {
        let notice = self.waiting.get_mut(self.first)?.take()?;
        self.first = (self.first + 1) % ROOM;
        self.count = self.count.saturating_sub(1);
        Some(notice)
    }

    /// How many gave way to newer ones.
    pub(crate) const fn lost(&self) -> u32 {
        self.lost
    }
}
