//! A bound on how often polygons may meet: what passes it would take hours, and memory without end.
//!
//! A building has two to four contacts for each polygon; thousands of leaves that cross each other some twenty. Where each of a
//! thousand polygons meets each other one, there are half a million contacts, and the square of that many crossings of their lines.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::PrepareError;

/// So many meetings are allowed in any scene: a second's work, and a hundred megabytes.
const FREE: usize = 250_000;
/// And so many for each polygon.
const PER_POLYGON: usize = 32;

/// Counts meetings, from many threads.
#[derive(Debug)]
pub(super) struct Meetings {
    polygons: usize,
    limit: usize,
    count: AtomicUsize,
}

impl Meetings {
    /// None yet, among so many polygons.
    pub(super) fn of(polygons: usize) -> Self {
        let limit = FREE.saturating_add(PER_POLYGON.saturating_mul(polygons));
        Self { polygons, limit, count: AtomicUsize::new(0) }
    }

    /// Counts so many more; false once there are too many, and going on is of no use.
    pub(super) fn add(&self, more: usize) -> bool {
        self.count.fetch_add(more, Ordering::Relaxed).saturating_add(more) <= self.limit
    }

    /// Begins to count anew: what was found by then is another thing.
    pub(super) fn restart(&self) {
        self.count.store(0, Ordering::Relaxed);
    }

    /// Fails if there were too many.
    pub(super) fn check(&self) -> Result<(), PrepareError> {
        if self.count.load(Ordering::Relaxed) <= self.limit {
            return Ok(());
        }
        Err(PrepareError::Entangled { polygons: self.polygons, limit: self.limit })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_meets_too_often_is_refused() {
        let meetings = Meetings::of(10);
        assert!(meetings.add(FREE) && meetings.check().is_ok());
        assert!(!meetings.add(PER_POLYGON * 10 + 1));
        let message = meetings.check().unwrap_err().to_string();
        assert!(message.starts_with("10 polygons cross or overlap") && message.contains("--no-intersect"), "{message}");
        meetings.restart();
        assert!(meetings.check().is_ok());
    }
}
