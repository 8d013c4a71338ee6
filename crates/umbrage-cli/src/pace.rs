//! How far a stage is and how long it will take, for whoever waits without a terminal: a line every ten seconds.
//!
//! A stage is taken to go on as it went so far. What tells no total tells nothing new; a share never falls.
//!
//! Holds: no line comes sooner than [`EVERY`] after the one before, nor before so much time has passed at all.

use std::fmt::Write;
use std::time::Duration;

/// How often a line comes.
const EVERY: Duration = Duration::from_secs(10);
/// What is left is not foreseen from less than this share.
const LEAST_SHARE: f64 = 0.02;

/// When the last line was told, and when the stage began, both since the beginning.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pace {
    told: Duration,
    begin: Duration,
    stage: String,
    share: f64,
}

impl Pace {
    /// The line to tell at a time since the beginning, if one is due.
    pub(crate) fn line(&mut self, now: Duration, stage: &str, done: u64, total: u64) -> Option<String> {
        if self.stage != stage {
            (self.stage, self.begin, self.share) = (stage.to_owned(), now, 0.0);
        }
        if total > 0 {
            self.share = self.share.max(done as f64 / total as f64).min(1.0);
        }
        if now.saturating_sub(self.told) < EVERY {
            return None;
        }
        self.told = now;
        let mut line = format!("{stage}: ");
        let took_s = now.saturating_sub(self.begin).as_secs_f64();
        // Writing to a string cannot fail.
        let _ = match self.share {
            share if share < LEAST_SHARE => write!(line, "{:.1} %", 100.0 * share),
            share => write!(line, "{:.0} %, about {} left", 100.0 * share, seconds(took_s * (1.0 - share) / share)),
        };
        let _ = write!(line, ", {} in all so far", seconds(now.as_secs_f64()));
        Some(line)
    }
}

/// A time in words, to the second, minutes from a hundred on.
fn seconds(s: f64) -> String {
    if s < 100.0 { format!("{s:.0} s") } else { format!("{:.0} min", s / 60.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_comes_every_ten_seconds_with_the_share_and_the_time_left() {
        let mut pace = Pace::default();
        let s = Duration::from_secs;
        assert_eq!(pace.line(s(5), "transport", 1, 10), None);
        // A quarter took 5 s of the stage, which began at 5 s.
        let line = pace.line(s(10), "transport", 25, 100);
        assert_eq!(line.as_deref(), Some("transport: 25 %, about 15 s left, 10 s in all so far"));
        assert_eq!(pace.line(s(19), "shade", 1, 10), None);
        // Nothing new, and what falls back, leave the share as it was.
        pace.line(s(150), "shade", 5, 10);
        let line = pace.line(s(200), "shade", 7, 0);
        assert_eq!(line.as_deref(), Some("shade: 50 %, about 3 min left, 3 min in all so far"));
        assert_eq!(pace.line(s(210), "solve", 0, 9).as_deref(), Some("solve: 0.0 %, 4 min in all so far"));
    }
}
