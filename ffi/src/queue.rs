//! Queue of unread notices.

use hovernav::ekf::Notice;

/// Largest number of notices in the queue. One sample causes fewer notices, so a caller that reads after each call
/// loses none.
const ROOM: usize = 12;

/// The unread notices; new ones overwrite the oldest.
#[derive(Debug, Default)]
pub(crate) struct NoticeQueue {
    waiting: [Option<Notice>; ROOM],
    first: usize,
    count: usize,
    lost: u32,
}

impl NoticeQueue {
    /// Appends a notice; the oldest of a full queue is lost.
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

    /// Removes and returns the oldest notice.
    pub(crate) fn pop(&mut self) -> Option<Notice> {
        let notice = self.waiting.get_mut(self.first)?.take()?;
        self.first = (self.first + 1) % ROOM;
        self.count = self.count.saturating_sub(1);
        Some(notice)
    }

    /// Number of notices overwritten by newer ones.
    pub(crate) const fn lost(&self) -> u32 {
        self.lost
    }
}
