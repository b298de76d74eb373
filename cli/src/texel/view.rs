//! `pelage texel view`: a picture of a texel.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use pelage::contact_sheet::contact_sheet;
use pelage::output::{Display, ExrOptions, Format, check_output, write_exr, write_png};
use pelage::texel_file::read_texel;

use crate::args::threads;
use crate::failure::Failure;
use crate::interrupt;
use crate::progress::Volume;
use crate::render::{pool, stage};
use crate::stats::Stats;

#[derive(Args)]
pub struct ViewArgs {
    /// The texel: .texel
    file: PathBuf,

    /// The picture: .png or .exr. Four sides and the top of the finest level, then each level from the front
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,

    /// Width and height of each of its panels in pixels, 16 to 2048
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(16..=2048))]
    size: u32,

    /// Threads, at most 256; 0 for one a core
    #[arg(short, long, default_value_t = 0, value_parser = threads, allow_hyphen_values = true)]
    threads: usize,

    /// Say only what went wrong
    #[arg(short, long)]
    quiet: bool,
}

/// Draws the texel.
pub fn run(args: &ViewArgs) -> Result<(), Failure> {
    let format = check_output(&args.output)?;
    let volume = if args.quiet { Volume::Quiet } else { Volume::Normal };
    let mut stats = Stats::default();
    let texel = Arc::new(read_texel(&args.file)?.texel);
    interrupt::listen()?;
    interrupt::keep_partial_result();
    let display = Display::default();
    let sheet = pool(args.threads)?.install(|| {
        stage("draw", volume, &mut stats, |stage| {
            contact_sheet(&texel, args.size, &display, &|fraction| {
                stage.update(fraction);
                if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })
        })
    })?;
    match format {
        Format::Png => write_png(&sheet, &args.output, &display)?,
        Format::Exr => write_exr(&sheet, &args.output, &ExrOptions { camera: None })?,
    }
    Ok(())
}
