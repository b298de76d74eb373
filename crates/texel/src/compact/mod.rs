//! A fine level in little room: 16 bytes a voxel, 5 a surfel or the two sides of a sheet.
//!
//! Fine voxels are many and small: of each a pixel shows a part, so a last percent of it does not show. Directions and
//! colours are names in the level's palettes.

mod surfels;
mod voxel;

use rayon::prelude::*;

use crate::Voxel;
use crate::packed::{Packed, normal, unit};
use crate::palette::Palette;
use crate::surfel::{Surfel, Surfels};
pub(crate) use surfels::CompactSurfels;
use surfels::{Pair, Record};
pub(crate) use voxel::{CompactView, CompactVoxel};

/// The voxels and surfels of a fine level.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Compact {
    /// Of slabs; octahedral, as in a [`Packed`].
    pub(crate) directions: Palette<2>,
    /// As in a [`Packed`].
    pub(crate) colors: Palette<3>,
    pub(crate) voxels: Vec<CompactVoxel>,
    pub(crate) surfels: CompactSurfels,
}

impl Compact {
    /// From what was measured; `None` where that is too much: a voxel with more than 15 surfels, or a mask in which the
    /// squares of 2 × 2 cells are not all of one kind.
    pub(crate) fn new(voxels: &[Packed], surfels: &Surfels) -> Option<Self> {
        let each = || (0..voxels.len() as u32).map(|voxel| surfels.of(voxel));
        if surfels.all().iter().any(|s| s.coarse_mask().is_none()) || each().any(|of| of.len() > 15) {
            return None;
        }
        let normals: Vec<[i16; 2]> = voxels.iter().map(Packed::normal).collect();
        let (directions, names) = Palette::gather(&normals, voxel::DIRECTIONS);
        let slabs = || names.iter().map(|&name| normal(directions.get(name.into())));
        // Where there are surfels, theirs are the colours that are seen.
        let plain =
            voxels.iter().zip(each()).filter(|(_, of)| of.is_empty()).map(|(voxel, _)| voxel.albedo());
        let all = surfels.all().iter().map(|surfel| surfel.sample().root_color()).chain(plain);
        let all: Vec<[i16; 3]> = all.map(|color| color.map(i16::from)).collect();
        let (colors, named) = Palette::gather(&all, voxel::COLORS);
        let (mut named, plain) = named.split_at(surfels.all().len());

        let mut plain = plain.iter();
        let mut records: Vec<Vec<Record>> = Vec::with_capacity(voxels.len());
        let mut looks = Vec::with_capacity(voxels.len());
        for (of, slab) in each().zip(slabs()) {
            let (own, others) = named.split_at(of.len());
            named = others;
            if let Some((pair, [front, back])) = Pair::new(of, slab) {
                records
                    .push(Some(pair.record()).filter(|&record| record != Record::OPEN).into_iter().collect());
                looks.push(([own[front], own[back]], true));
                continue;
            }
            let colours = match (own, plain.len()) {
                ([], 0) => [0; 2],
                ([], _) => [plain.next().copied().unwrap_or_default(); 2],
                _ => furthest(own, &colors),
            };
            let is_second =
                |color| distance(&colors, color, colours[1]) < distance(&colors, color, colours[0]);
            let record = |(surfel, &color): (&Surfel, &u16)| Record::new(surfel, is_second(color));
            records.push(of.iter().zip(own).map(record).collect());
            looks.push((colours, false));
        }
        let voxels =
            voxels.par_iter().zip(&names).zip(&looks).map(|((voxel, &name), &(colors, is_sheet))| {
                CompactVoxel::new(voxel, name, normal(directions.get(name.into())), colors, is_sheet)
            });
        let voxels = voxels.collect();
        let surfels = CompactSurfels::new(&records);
        Some(Self { directions, colors, voxels, surfels })
    }

    /// From tables as they are stored, or what is wrong with them.
    pub(crate) fn from_tables(
        directions: Palette<2>,
        colors: Palette<3>,
        voxels: Vec<CompactVoxel>,
        surfels: CompactSurfels,
    ) -> Result<Self, &'static str> {
        let compact = Self { directions, colors, voxels, surfels };
        compact.fault().map_or(Ok(compact), Err)
    }

    /// What is named and not there, if anything.
    pub(crate) fn fault(&self) -> Option<&'static str> {
        let [directions, colors] = [self.directions.points().len(), self.colors.points().len()];
        let sound =
            |v: &CompactVoxel| v.direction() < directions && v.colors().into_iter().all(|c| c < colors);
        if !self.voxels.iter().all(sound) {
            return Some("names a direction or colour that there is not");
        }
        if self.surfels.voxels() != self.voxels.len() {
            return Some("does not count the surfels of every voxel");
        }
        let sheets = self.voxels.iter().zip(self.surfels.counts()).filter(|(voxel, _)| voxel.is_sheet());
        { sheets }.any(|(_, count)| count > 1).then_some("has a sheet of more than two sides")
    }

    /// The voxel as it is walked and shaded.
    pub(crate) fn voxel(&self, index: usize) -> CompactView<'_> {
        CompactView { voxel: &self.voxels[index], directions: &self.directions }
    }

    /// All of a voxel; its albedo is the mean of its two colours.
    pub(crate) fn unpack(&self, index: usize) -> Voxel {
        let view = self.voxel(index);
        let [lo, hi] = view.region_box();
        let (slab_normal, slab) = view.region_slab();
        let [a, b] = view.voxel.colors().map(|name| unit(self.root_color(name)));
        Voxel { sigma: view.sigma(), lo, hi, slab_normal, slab, albedo: 0.5 * (a * a + b * b) }
    }

    fn root_color(&self, name: usize) -> [u8; 3] {
        let [r, g, b] = self.colors.get(name);
        [r.clamp(0, 255) as u8, g.clamp(0, 255) as u8, b.clamp(0, 255) as u8]
    }

    /// The surfels of a voxel.
    pub(crate) fn surfels_of(&self, index: usize) -> impl Iterator<Item = Surfel> + '_ {
        let voxel = self.voxels.get(index);
        let [a, b] = voxel.map_or([0; 2], CompactVoxel::colors);
        let colors = [self.root_color(a), self.root_color(b)];
        let sheet = voxel.filter(|voxel| voxel.is_sheet());
        let slab = sheet.map(|voxel| normal(self.directions.get(voxel.direction())));
        let sides =
            slab.map(|slab| self.surfels.of(index).next().unwrap_or(Record::OPEN).sides(slab, colors));
        let others = if sides.is_none() { Some(self.surfels.of(index)) } else { None };
        let others = others.into_iter().flatten().map(move |record| record.surfel(colors));
        sides.into_iter().flatten().chain(others)
    }

    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        let palettes = self.directions.memory() + self.colors.memory();
        size_of_val(&self.voxels[..]) + self.surfels.memory() + palettes
    }
}

fn distance(colors: &Palette<3>, a: u16, b: u16) -> i32 {
    let [a, b] = [a, b].map(|name| colors.get(name.into()).map(i32::from));
    (0..3).map(|axis| (a[axis] - b[axis]).pow(2)).sum()
}

/// The two of some colours that are furthest apart, the first of the palette first.
fn furthest(names: &[u16], colors: &Palette<3>) -> [u16; 2] {
    let pairs =
        names.iter().enumerate().flat_map(|(i, &a)| names[i..].iter().map(move |&b| [a.min(b), a.max(b)]));
    pairs.max_by_key(|&[a, b]| distance(colors, a, b)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use crate::{BuildOptions, Fur, Grass, Procedure, Surfel, build_exact};

    /// That every surfel of the finest level returns, but for the last percent of its weight; and how many there are.
    fn kept(procedure: &impl Procedure) -> usize {
        let options = BuildOptions { depth: 6, ..BuildOptions::preview() };
        let exact = build_exact("", procedure.geometry(), &options, &|_| ()).unwrap();
        let compact = exact.clone().compacted();
        assert_eq!(compact.validate(), Ok(()));
        let (a, b) = (exact.level(6), compact.level(6));
        assert!(b.memory() < 6 * a.memory() / 10, "{} {}", b.memory(), a.memory());
        let mut seen = 0;
        for voxel in 0..a.len() as u32 {
            let (a, b): (Vec<_>, Vec<_>) = (a.surfels(voxel).collect(), b.surfels(voxel).collect());
            assert_eq!(a.len(), b.len());
            let like = |a: &Surfel, b: &Surfel| {
                a.coarse_mask() == b.coarse_mask()
                    && a.normal() == b.normal()
                    && (a.weight() - b.weight()).abs() <= 1.0 / 32.0
            };
            assert!(a.iter().all(|a| b.iter().any(|b| like(a, b))), "{a:?} {b:?}");
            seen += a.len();
        }
        seen
    }

    #[test]
    fn a_texel_keeps_its_surfels() {
        // Strands, and sheets.
        assert!(kept(&Fur { count: 10, ..Fur::long() }) > 500);
        assert!(kept(&Grass { count: 2, ..Grass::lawn() }) > 500);
    }
}
