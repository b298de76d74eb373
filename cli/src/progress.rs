//! What people see while they wait, on stderr: a bar on a terminal, plain lines elsewhere, or nothing.

use std::fmt::Display;
use std::io::{IsTerminal, Write, stderr};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Says a line on stderr. That nobody listens is no reason to stop.
pub fn say(line: impl Display) {
    let _ = writeln!(stderr(), "{line}");
}

/// How much is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Volume {
    /// Errors only.
    Quiet,
    /// Warnings and progress.
    Normal,
    /// Also what was found and made.
    Verbose,
}

/// The progress of one stage.
pub struct Stage {
    name: &'static str,
    volume: Volume,
    bar: Option<ProgressBar>,
    begun: Instant,
    /// The last tenth that a line was printed for.
    tenth: AtomicU32,
}

impl Stage {
    /// Begins a stage.
    pub fn begin(name: &'static str, volume: Volume) -> Self {
        let bar = (volume > Volume::Quiet && stderr().is_terminal()).then(|| {
            let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr_with_hz(10));
            let style = ProgressStyle::with_template("{msg:>8} {wide_bar} {percent:>3} % {eta:>4} left");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.set_message(name);
            bar
        });
        Self { name, volume, bar, begun: Instant::now(), tenth: AtomicU32::new(0) }
    }

    /// Tells how much is done, from 0 to 1; from any thread.
    pub fn update(&self, fraction: f32) {
        if let Some(bar) = &self.bar {
            bar.set_position((1000.0 * fraction) as u64);
        } else if self.volume > Volume::Quiet {
            let tenth = (10.0 * fraction) as u32;
            // Short stages end before their first line; whoever moves the mark prints it.
            if self.begun.elapsed() > Duration::from_secs(2)
                && self.tenth.fetch_max(tenth, Ordering::Relaxed) < tenth
            {
                say(format_args!("{}: {} %", self.name, 10 * tenth));
            }
        }
    }

    /// Ends the stage and tells how long it took.
    pub fn end(self) -> Duration {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        let taken = self.begun.elapsed();
        if self.volume == Volume::Verbose {
            say(format_args!("{}: {:.2} s", self.name, taken.as_secs_f64()));
        }
        taken
    }
}
