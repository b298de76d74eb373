//! `pelage render`: load, extrude, bake, compile, render, write.

use std::io::Write;
use std::ops::ControlFlow;
use std::time::Duration;

use pelage::Error;
use pelage::compile::{Dressed, Loaded};
use pelage::output::{Format, check_output};
use pelage::tracer::RenderError;

use crate::args::{RenderArgs, StatsFormat};
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::{Stage, Volume, say};
use crate::stats::{Stats, peak_memory};

/// Renders what the arguments describe.
pub fn run(args: &RenderArgs) -> Result<(), Failure> {
    let scene = args.scene()?;
    // Asked now: after an hour of rendering is too late.
    let format = check_output(&args.output)?;
    if format == Format::Png && args.aov.len() > 1 {
        return Err(Failure::Usage("--aov: a PNG file shows one of them; an EXR file holds several".into()));
    }
    interrupt::listen()?;
    pool(args.run.threads)?.install(|| picture(args, scene, format))
}

/// So many threads; 0 for one a core.
pub fn pool(threads: usize) -> Result<rayon::ThreadPool, Failure> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| Failure::Usage(format!("cannot start {threads} threads: {e}")))
}

fn picture(args: &RenderArgs, scene: pelage::scene_file::SceneFile, format: Format) -> Result<(), Failure> {
    let volume = args.run.volume();
    let mut stats = Stats::default();

    let loaded = stage("load", volume, &mut stats, |_| Loaded::new(scene))?;
    tell_of_input(&loaded, volume);
    stats.count("meshes", loaded.imported.meshes.len());
    stats.count("faces", loaded.imported.meshes.iter().map(|m| m.faces.len()).sum::<usize>());

    // Before the texels: a skin that cannot stand should not have to wait for them.
    let skins = stage("extrude", volume, &mut stats, |_| loaded.extrude())?;
    tell_of_skins(&skins, &loaded, volume, &mut stats);

    let texels = stage("bake", volume, &mut stats, |stage| loaded.bake(&|f| stage.update(f)))?;

    let prepared = stage("compile", volume, &mut stats, |_| loaded.compile(&texels, skins))?;

    if let (Format::Png, [which]) = (format, &args.aov[..]) {
        let aovs = stage("render", volume, &mut stats, |_| prepared.aovs())?;
        stage("write", volume, &mut stats, |_| {
            Ok(prepared.write_false_color(&aovs, *which, &args.output)?)
        })?;
        return Ok(());
    }

    interrupt::keep_partial_result();
    let film = stage("render", volume, &mut stats, |stage| {
        prepared.render(&|progress| {
            stage.update(progress.done as f32 / progress.total as f32);
            if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    });
    let (film, unfinished) = match film {
        Ok(film) => (film, None),
        Err(Error::Render(RenderError::Cancelled { done, total, film })) => (*film, Some((done, total))),
        Err(error) => return Err(error.into()),
    };

    stage("write", volume, &mut stats, |_| {
        if args.aov.is_empty() {
            prepared.write(&film, &args.output, format)?;
        } else {
            prepared.write_with(&film, &prepared.aovs()?, &args.aov, &args.output)?;
        }
        Ok(())
    })?;

    if let Some(bytes) = peak_memory() {
        stats.count("peak_memory", bytes);
    }
    match args.stats {
        Some(StatsFormat::Text) => say(stats.text().trim_end()),
        Some(StatsFormat::Json) => {
            writeln!(std::io::stdout(), "{}", stats.json()).map_err(Failure::Stdout)?;
        }
        None => {}
    }
    match unfinished {
        None => Ok(()),
        Some((done, total)) => {
            let output = args.output.display();
            Err(Failure::Interrupted(format!("interrupted: {output} holds {done} of {total} tiles")))
        }
    }
}

/// Runs a stage, shows its progress and notes its time.
pub fn stage<T>(
    name: &'static str,
    volume: Volume,
    stats: &mut Stats,
    work: impl FnOnce(&Stage) -> Result<T, Error>,
) -> Result<T, Error> {
    let stage = Stage::begin(name, volume);
    let result = work(&stage);
    let taken: Duration = stage.end();
    stats.time(name, taken);
    result
}

/// Warns of what was odd in the mesh files.
pub fn tell_of_input(loaded: &Loaded, volume: Volume) {
    for warning in loaded.imported.warnings.iter().filter(|_| volume > Volume::Quiet) {
        say(format_args!("warning: {warning}"));
    }
}

/// Tells how many boxes there are, and warns of those that are not.
pub fn tell_of_skins(skins: &[Dressed], loaded: &Loaded, volume: Volume, stats: &mut Stats) {
    let sum = |count: &dyn Fn(&Dressed) -> usize| skins.iter().map(count).sum::<usize>();
    stats.count("boxes", sum(&|d| d.skin.report.boxes));
    stats.count("prisms", sum(&|d| d.skin.report.prisms));
    stats.count("folded_mended", sum(&|d| d.skin.report.mended()));
    stats.count("folded_left_out", sum(&|d| d.skin.report.left_out()));
    for dressed in skins {
        let mesh = &loaded.imported.meshes[dressed.mesh].name;
        let report = &dressed.skin.report;
        if volume == Volume::Verbose {
            let report = report.to_string().replace('\n', "; ");
            say(format_args!("skin[{}] on `{mesh}`: {report}", dressed.entry));
            for (step, effect) in dressed.effects.iter().enumerate() {
                say(format_args!("skin[{}] on `{mesh}`: groom[{step}]: {effect}", dressed.entry));
            }
        } else if volume > Volume::Quiet && report.left_out() > 0 {
            // A bald spot is the one thing that nobody should have to find out from the picture.
            say(format_args!(
                "warning: skin[{}] on `{mesh}`: {} folded boxes left out",
                dressed.entry,
                report.left_out()
            ));
        }
    }
}
