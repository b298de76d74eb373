//! Measures one scene: its stages, and its pictures along the curved and the straight path by turns.

use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use cpu_time::ProcessTime;
use pelage::compile::{Loaded, Prepared};
use pelage::output::replace;
use pelage::scene_file::{SceneFile, TexelEntry};
use pelage::texel::BuildOptions;
use pelage::texel::file::FileOptions;
use pelage::texel_file::{read_texel, write_texel};
use pelage::tracer::{Counts, render_counted};
use pelage::{Error, build};
use rayon::ThreadPool;

use super::moving::frames;
use super::report::{Along, Picture, SceneReport, Seconds, Work};
use super::scenes::{BenchScene, Content, Distance};
use crate::failure::Failure;
use crate::stats::peak_memory;

/// How scenes are measured.
pub struct Plan {
    /// From how far they are seen.
    pub distances: Vec<Distance>,
    /// Numbers of threads, each with its pool.
    pub pools: Vec<(usize, ThreadPool)>,
    /// How often each time is taken; the median is told.
    pub runs: usize,
    /// Width and height of the pictures.
    pub size: [u32; 2],
    /// The folder where scenes and texels are kept.
    pub cache: PathBuf,
    /// Voxels a side of the texels.
    pub resolution: u32,
}

impl Plan {
    /// Writes the files of a scene, one a distance, and its texel if it is not there yet.
    pub fn write(&self, scene: &BenchScene) -> Result<(), Failure> {
        let texel = format!("{}-{}.texel", scene.content.name(), self.resolution);
        self.bake(scene.content, &self.cache.join(&texel))?;
        for &distance in &self.distances {
            let text = scene.text(distance, self.size, &texel);
            replace(&self.file(scene, distance), |file| file.write_all(text.as_bytes()))?;
        }
        Ok(())
    }

    fn file(&self, scene: &BenchScene, distance: Distance) -> PathBuf {
        self.cache.join(format!("{}-{}.toml", scene.name, distance.name()))
    }

    fn bake(&self, content: Content, path: &Path) -> Result<(), Failure> {
        let TexelEntry::Grown { kind, resolution } = content.entry(self.resolution) else { return Ok(()) };
        // What an earlier version wrote may be no file of this one.
        if read_texel(path).is_ok() {
            return Ok(());
        }
        let options = BuildOptions { depth: resolution.ilog2(), ..BuildOptions::standard() };
        let texel = build(content.name(), kind, &options, &|_| ())
            .map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
        Ok(write_texel(&texel, path, &FileOptions::default())?)
    }

    /// Measures a scene whose files are written.
    pub fn measure(&self, scene: &BenchScene) -> Result<SceneReport, Failure> {
        let widest = self.pools.iter().max_by_key(|(threads, _)| threads);
        let (Some(&distance), Some((threads, pool))) = (self.distances.first(), widest) else {
            return Err(Failure::Usage("--distance, --threads: none".into()));
        };
        let file = self.file(scene, distance);
        let mut report = SceneReport::of(scene, *threads);
        let mut takes = self.takes();
        let mut stages: [Vec<f64>; 3] = Default::default();
        for run in 0..self.runs {
            let (mut prepared, seconds) = pool.install(|| stage(&file))?;
            stages.iter_mut().zip(seconds).for_each(|(list, s)| list.push(s));
            report.describe(&prepared.scene);
            let shoot = |take: &mut Take| take.shoot(scene, &mut prepared, &self.pools);
            // Curved and straight by turns; which of them is first, by turns too.
            if run % 2 == 0 {
                takes.iter_mut().try_for_each(shoot)?;
            } else {
                takes.iter_mut().rev().try_for_each(shoot)?;
            }
        }
        let [load, extrude, compile] = stages.map(|list| median(&list));
        report.seconds = Seconds { load, extrude, compile };
        report.pictures = takes.iter().map(|take| self.picture(take, &takes, &report.seconds)).collect();
        if scene.moves {
            report.frame = Some(pool.install(|| frames(&file, self.runs))?);
        }
        report.peak_memory = peak_memory();
        Ok(report)
    }

    fn takes(&self) -> Vec<Take> {
        let mut takes = Vec::new();
        for &distance in &self.distances {
            for pool in 0..self.pools.len() {
                for along in [Along::Curved, Along::Straight] {
                    let counts = Counts::default();
                    takes.push(Take { distance, pool, along, wall: vec![], cpu: vec![], counts });
                }
            }
        }
        takes
    }

    /// What is told of one of `all` takes.
    fn picture(&self, take: &Take, all: &[Take], stages: &Seconds) -> Picture {
        let other = |pool: usize, along: Along| {
            all.iter().find(|t| (t.distance, t.pool, t.along) == (take.distance, pool, along))
        };
        let (threads, _) = self.pools[take.pool];
        let single = self.pools.iter().position(|&(threads, _)| threads == 1);
        let [seconds, cpu_seconds] = [&take.wall, &take.cpu].map(|list| median(list));
        Picture {
            distance: take.distance,
            path: take.along,
            threads,
            seconds,
            cpu_seconds,
            from_file_seconds: stages.sum() + seconds,
            pictures_per_second: 1.0 / seconds,
            over_straight: match take.along {
                Along::Curved => other(take.pool, Along::Straight).map(|s| ratio(&take.cpu, &s.cpu)),
                Along::Straight => None,
            },
            efficiency: (single.filter(|_| threads > 1))
                .and_then(|pool| other(pool, take.along))
                .map(|single| ratio(&single.wall, &take.wall) / threads as f64),
            work: Work::new(&take.counts, seconds, cpu_seconds, self.size),
        }
    }
}

/// A picture that is taken again and again.
struct Take {
    distance: Distance,
    /// Which of the pools.
    pool: usize,
    along: Along,
    /// By run, seconds.
    wall: Vec<f64>,
    cpu: Vec<f64>,
    counts: Counts,
}

impl Take {
    fn shoot(
        &mut self,
        scene: &BenchScene,
        prepared: &mut Prepared,
        pools: &[(usize, ThreadPool)],
    ) -> Result<(), Failure> {
        prepared.camera = scene.camera(self.distance);
        prepared.settings.path = self.along.path();
        let cpu = ProcessTime::now();
        let (counts, wall) = pools[self.pool].1.install(|| picture(prepared))?;
        self.cpu.push(cpu.elapsed().as_secs_f64());
        self.wall.push(wall);
        self.counts = counts;
        Ok(())
    }
}

/// Renders a picture; what that took, in steps and in seconds.
pub fn picture(prepared: &Prepared) -> Result<(Counts, f64), Error> {
    let Prepared { scene, camera, settings, .. } = prepared;
    let ((_, counts), seconds) =
        timed(|| Ok(render_counted(scene, camera, settings, &|_| ControlFlow::Continue(()))?))?;
    Ok((counts, seconds))
}

/// Makes a scene ready; how long loading, extruding and compiling took.
pub fn stage(file: &Path) -> Result<(Prepared, [f64; 3]), Error> {
    let (loaded, load) = timed(|| Loaded::new(SceneFile::open(file)?))?;
    let (skins, extrude) = timed(|| loaded.extrude())?;
    // From its file: there is nothing to build.
    let texels = loaded.bake(&|_| ())?;
    let (prepared, compile) = timed(|| loaded.compile(&texels, skins))?;
    Ok((prepared, [load, extrude, compile]))
}

/// What `work` makes, and how many seconds that takes.
pub fn timed<T>(work: impl FnOnce() -> Result<T, Error>) -> Result<(T, f64), Error> {
    let begun = Instant::now();
    let made = work()?;
    Ok((made, begun.elapsed().as_secs_f64()))
}

/// The middle one; of an even number, the mean of the two in the middle. 0 of none.
pub fn median(list: &[f64]) -> f64 {
    let mut sorted = list.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let middle = sorted.len() / 2;
    match sorted.len() {
        0 => 0.0,
        n if n % 2 == 1 => sorted[middle],
        _ => 0.5 * (sorted[middle - 1] + sorted[middle]),
    }
}

/// The median of the ratios run by run: what disturbs both sides of a run alike shows in none.
fn ratio(above: &[f64], below: &[f64]) -> f64 {
    median(&above.iter().zip(below).map(|(a, b)| a / b).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(&[]), 0.0);
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        // 2, 3, 1: the second pair was disturbed, both sides of it.
        assert_eq!(ratio(&[2.0, 30.0, 1.0], &[1.0, 10.0, 1.0]), 2.0);
    }
}
