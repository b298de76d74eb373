//! A level as the bytes of a file: counts, then tables whose records stand in [`planes`](super::planes).
//!
//! ```text
//! byte 0  form        u32  bit 0: compact, not as it was measured; bit 1: of a density, with scatterers; bit 2: with
//!                          reflectances; bit 3: balanced; bit 4: with bearings
//!      4  bricks      u32
//!      8  voxels      u32
//!     12  surfels     u32
//!     16  openness    u32  as many as voxels, or none
//!     20  directions  u32  of the compact form; else 0
//!     24  colours     u32  of the compact form; else 0
//!     28  scatterers  u32
//!     32  map         u32  cells along an axis of their maps, or 0 for none
//!     36  bricks      Morton code u32
//!         occupancy   8 × u64 a brick, one for each of its 4³ blocks
//!         openness    u8
//!
//! exact   voxels      32 bytes, as in memory
//!         counts      u16: the surfels of each voxel
//!         surfels     14 bytes, as in memory
//!
//! compact directions  2 × i16
//!         colours     3 × i16
//!         voxels      21 bytes: each number in bytes of its own
//!         counts      u8: the records of each voxel
//!         records     of a surfel or of the two sides of a sheet, as in memory: the low u16 of each; the high u16, one
//!                     record after the other, since neighbours face alike; u8
//!
//! reflectances
//!         largest     f32 a voxel
//!         nodes       16 bytes, as in memory: 125 a voxel
//!         facings     5 bytes, as in memory: 56 a voxel
//!         tables      7875 bytes a voxel, as in memory
//!
//! balanced            96 × f32
//!
//! bearings            i8, as in memory: 100 a voxel of levels 0 to 2, 800 in all beyond
//!
//! density counts      u32: the scatterers of each voxel
//!         scatterers  6 bytes, as in memory
//!         maps        (map + 1)² bytes a scatterer
//! ```

use super::planes::{Planes, write};
use crate::balance::NODES as BALANCED;
use crate::bearings::{self, Bearings};
use crate::bricks::Bricks;
use crate::compact::{Compact, CompactSurfels, CompactVoxel};
use crate::octree::Content;
use crate::packed::Packed;
use crate::palette::Palette;
use crate::reflectance::{FACINGS, NODES, PAIRS, Parts, Reflectances};
use crate::sample::Sample;
use crate::scatterer::{Cloud, Scatterer};
use crate::surfel::{Surfel, Surfels};
use crate::{Balance, Level};

/// The bytes of a level.
pub(super) fn encode(level: &Level) -> Vec<u8> {
    let bricks: Vec<(u32, [u64; 8])> = level.bricks().occupied().collect();
    let (compact, surfels, palettes) = match level.content() {
        Content::Exact(_, surfels) => (0, surfels.all().len(), [0; 2]),
        Content::Compact(c) => {
            (1, c.surfels.tables().0.len(), [c.directions.points().len(), c.colors.points().len()])
        }
    };
    let [directions, colors] = palettes;
    let reflectances = level.reflectances();
    let form = compact
        | usize::from(level.cloud().is_there()) << 1
        | usize::from(reflectances.is_there()) << 2
        | usize::from(level.balance().is_some()) << 3
        | usize::from(level.bearings().is_some()) << 4;
    let (scatterers, maps, side) = level.cloud().tables();
    let counts = [form, bricks.len(), level.len(), surfels, level.openness().len(), directions, colors];
    let mut out = Vec::new();
    for count in counts.into_iter().chain([scatterers.len(), side]) {
        out.extend((count as u32).to_le_bytes());
    }
    write(&mut out, bricks.iter().map(|(code, _)| code.to_le_bytes()));
    write(&mut out, bricks.iter().map(|(_, words)| occupancy(words)));
    out.extend(level.openness());
    match level.content() {
        Content::Exact(voxels, surfels) => {
            let counts = (0..voxels.len() as u32).map(|voxel| surfels.of(voxel).len() as u16);
            write(&mut out, voxels.iter().map(|voxel| voxel.to_bytes()));
            write(&mut out, counts.map(u16::to_le_bytes));
            write(&mut out, surfels.all().iter().map(|surfel| surfel.to_bytes()));
        }
        Content::Compact(compact) => {
            write(&mut out, compact.directions.points().iter().map(point::<2, 4>));
            write(&mut out, compact.colors.points().iter().map(point::<3, 6>));
            write(&mut out, compact.voxels.iter().map(|voxel| voxel.to_bytes()));
            out.extend(compact.surfels.counts());
            let (bits, shares) = compact.surfels.tables();
            write(&mut out, bits.iter().map(|&bits| (bits as u16).to_le_bytes()));
            out.extend(bits.iter().flat_map(|bits| ((bits >> 16) as u16).to_le_bytes()));
            out.extend(shares);
        }
    }
    let parts = reflectances.parts();
    write(&mut out, parts.largest);
    write(&mut out, parts.nodes);
    write(&mut out, parts.facings);
    out.extend(parts.tables);
    let balance = level.balance().into_iter().flat_map(Balance::nodes);
    out.extend(balance.flat_map(|factor| factor.to_le_bytes()));
    let bearings = level.bearings().into_iter().flat_map(Bearings::logs);
    out.extend(bearings.map(|&log| log as u8));
    write(&mut out, level.cloud().counts().map(u32::to_le_bytes));
    write(&mut out, scatterers.iter().map(|scatterer| scatterer.0.to_bytes()));
    out.extend(maps);
    out
}

/// The level of a number, or what is wrong with its bytes.
pub(super) fn decode(l: u32, periodic: bool, bytes: &[u8]) -> Result<Level, &'static str> {
    const SHORT: &str = "is shorter than its counts say";
    let mut planes = Planes(bytes);
    let counts = planes.counts().ok_or(SHORT)?;
    let [form, bricks, voxels, surfels, openness, directions, colors, scatterers, side] = counts;
    if form > 31 {
        return Err("is of a form that there is not");
    }
    let codes = planes.read(bricks).ok_or(SHORT)?.map(u32::from_le_bytes);
    let bricks: Vec<_> = codes.zip(planes.read(bricks).ok_or(SHORT)?.map(words)).collect();
    let bricks = Bricks::from_occupied(1 << l, &bricks)?;
    let openness = planes.read(openness).ok_or(SHORT)?.map(|[open]| open).collect();
    let content = match form & 1 {
        0 => {
            let voxels: Vec<_> = planes.read(voxels).ok_or(SHORT)?.map(Packed::from_bytes).collect();
            let counts: Vec<_> = planes.read(voxels.len()).ok_or(SHORT)?.map(u16::from_le_bytes).collect();
            let surfels = planes.read(surfels).ok_or(SHORT)?.map(Surfel::from_bytes).collect();
            Content::Exact(voxels, Surfels::from_counts(&counts, surfels).ok_or("miscounts its surfels")?)
        }
        _ => {
            let directions = planes.read(directions).ok_or(SHORT)?.map(coordinates::<2, 4>).collect();
            let directions = Palette::from_points(directions);
            let colors = planes.read(colors).ok_or(SHORT)?.map(coordinates::<3, 6>).collect();
            let colors = Palette::from_points(colors);
            let voxels: Option<Vec<_>> =
                planes.read(voxels).ok_or(SHORT)?.map(CompactVoxel::from_bytes).collect();
            let voxels = voxels.ok_or("has a voxel of a number that is too large")?;
            let counts: Vec<_> = planes.read(voxels.len()).ok_or(SHORT)?.map(|[count]| count).collect();
            let low = planes.read(surfels).ok_or(SHORT)?.map(u16::from_le_bytes);
            let high = planes.read_rows(surfels).ok_or(SHORT)?.map(u16::from_le_bytes);
            let bits = low.zip(high).map(|(low, high)| u32::from(low) | u32::from(high) << 16).collect();
            let shares = planes.read(surfels).ok_or(SHORT)?.map(|[share]| share).collect();
            let surfels = CompactSurfels::from_tables(&counts, bits, shares)?;
            Content::Compact(Compact::from_tables(directions, colors, voxels, surfels)?)
        }
    };
    let mut level = Level::of_parts(bricks, content, openness, periodic);
    if form & 4 != 0 {
        let largest = planes.read(voxels).ok_or(SHORT)?;
        let nodes = planes.read(NODES.checked_mul(voxels).ok_or(SHORT)?).ok_or(SHORT)?;
        let facings = planes.read(FACINGS.checked_mul(voxels).ok_or(SHORT)?).ok_or(SHORT)?;
        let size = voxels.checked_mul(PAIRS).ok_or(SHORT)?;
        let (tables, rest) = planes.0.split_at_checked(size).ok_or(SHORT)?;
        planes.0 = rest;
        let parts = Parts { largest, nodes, facings, tables: tables.to_vec() };
        let reflectances = Reflectances::from_parts(parts);
        level.set_reflectances(reflectances.ok_or("has a reflectance that is no number")?);
    }
    if form & 8 != 0 {
        let mut factors = [0.0; BALANCED];
        for (factor, bytes) in factors.iter_mut().zip(planes.read_rows(BALANCED).ok_or(SHORT)?) {
            *factor = f32::from_le_bytes(bytes);
        }
        let balance = Balance::from_nodes(factors);
        level.set_balance(Some(balance.ok_or("has a balance that is no number")?));
    }
    if form & 16 != 0 {
        let logs =
            planes.read(bearings::count(1 << l, voxels)).ok_or(SHORT)?.map(|[log]| log as i8).collect();
        level.set_bearings(Some(Bearings::new(logs)));
    }
    if form & 2 != 0 {
        let counts = planes.read(voxels).ok_or(SHORT)?.map(u32::from_le_bytes);
        let points =
            planes.read(scatterers).ok_or(SHORT)?.map(|bytes| Scatterer(Sample::from_bytes(bytes))).collect();
        let maps = std::mem::take(&mut planes.0).to_vec();
        level.set_cloud(Cloud::from_tables(counts, points, maps, side).ok_or("miscounts its scatterers")?);
    }
    if !planes.0.is_empty() {
        return Err("is longer than its counts say");
    }
    Ok(level)
}

fn occupancy(words: &[u64; 8]) -> [u8; 64] {
    std::array::from_fn(|byte| words[byte / 8].to_le_bytes()[byte % 8])
}

fn words(bytes: [u8; 64]) -> [u64; 8] {
    std::array::from_fn(|word| u64::from_le_bytes(std::array::from_fn(|byte| bytes[8 * word + byte])))
}

/// D coordinates as N = 2 D bytes.
fn point<const D: usize, const N: usize>(point: &[i16; D]) -> [u8; N] {
    std::array::from_fn(|byte| point[byte / 2].to_le_bytes()[byte % 2])
}

fn coordinates<const D: usize, const N: usize>(bytes: [u8; N]) -> [i16; D] {
    std::array::from_fn(|axis| i16::from_le_bytes([bytes[2 * axis], bytes[2 * axis + 1]]))
}
