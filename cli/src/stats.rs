//! What `--stats` tells: the times of the stages, and how much of everything there was.

use std::fmt::Write;
use std::time::Duration;

/// Figures of one run, in the order in which they came up.
#[derive(Default)]
pub struct Stats {
    times: Vec<(&'static str, Duration)>,
    counts: Vec<(&'static str, u64)>,
}

impl Stats {
    /// Notes how long a stage took.
    pub fn time(&mut self, stage: &'static str, taken: Duration) {
        self.times.push((stage, taken));
    }

    /// Notes how many of something there were.
    pub fn count(&mut self, what: &'static str, count: impl TryInto<u64>) {
        self.counts.push((what, count.try_into().unwrap_or(u64::MAX)));
    }

    /// For people: a line each.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for (stage, taken) in &self.times {
            let _ = writeln!(text, "{stage:>16} {:10.3} s", taken.as_secs_f64());
        }
        for (what, count) in &self.counts {
            let _ = writeln!(text, "{:>16} {count:>10}", what.replace('_', " "));
        }
        text
    }

    /// For programs: one line of JSON, seconds and counts by name.
    pub fn json(&self) -> String {
        let times = self.times.iter().map(|(stage, t)| format!("\"{stage}\":{:.6}", t.as_secs_f64()));
        let counts = self.counts.iter().map(|(what, count)| format!("\"{what}\":{count}"));
        let list = |items: Vec<String>| items.join(",");
        format!("{{\"seconds\":{{{}}},\"counts\":{{{}}}}}", list(times.collect()), list(counts.collect()))
    }
}

/// The most memory that this process has used so far, in bytes, where the system tells.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kibibytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_in_one_line() {
        let mut stats = Stats::default();
        stats.time("load", Duration::from_millis(1500));
        stats.count("boxes", 12_usize);
        assert_eq!(stats.json(), "{\"seconds\":{\"load\":1.500000},\"counts\":{\"boxes\":12}}");
    }
}
