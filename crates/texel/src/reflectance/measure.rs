//! The reflectance of a voxel, summed over points of its surface.

use std::f32::consts::PI;

use glam::Vec3;

use super::brightness;
use super::facing::{FACINGS, Facing};
use super::nodes::{FIT, NODES, around, solid_angle};
use super::outlook::{Open, Outlook};
use super::table::Node;
use crate::packed::bytes;

/// The reflectance of one voxel.
pub(crate) struct Measured {
    pub(super) nodes: [Node; NODES],
    pub(super) facings: [Facing; FACINGS],
    pub(super) largest: f32,
    pub(super) table: Vec<u8>,
}

/// What is summed of the points that are seen from a node.
#[derive(Clone, Copy, Default)]
struct Sums {
    seen: f32,
    /// What is both seen and lit from about there, as brightness.
    lit: f32,
    /// What is seen from about there: what the following are weighed by.
    weight: f32,
    color: Vec3,
    normal: Vec3,
    sky: [(f32, Vec3); 2],
}

/// What is summed of the points of a voxel.
pub(crate) struct Tally {
    sums: [Sums; NODES],
    /// What is seen from each cell.
    seen: [f32; NODES],
    /// What is seen from one cell and lit from another.
    table: Vec<[f32; NODES]>,
    facings: [(Vec3, f32); FACINGS],
}

impl Tally {
    /// Of no points.
    pub(crate) fn new() -> Self {
        Self {
            sums: [Sums::default(); NODES],
            seen: [0.0; NODES],
            table: vec![[0.0; NODES]; NODES],
            facings: [(Vec3::ZERO, 0.0); FACINGS],
        }
    }

    /// And of one more, as a level sees it.
    pub(crate) fn add(&mut self, level: usize, point: &Outlook) {
        let Outlook { normal, color, weight, open } = point;
        let bright = weight * brightness(*color);
        let (mut visible, mut sky) = ([0.0; NODES], [(0.0, Vec3::ZERO); 2]);
        let cosines = [0, 1].map(|set| {
            let mut cosines = [0.0; NODES];
            for Open { cell, direction, .. } in
                open[set].iter().filter(|open| usize::from(open.level) <= level)
            {
                let cosine = normal.dot(*direction);
                cosines[usize::from(*cell)] = cosine;
                around(*direction).iter().for_each(|(node, weight)| visible[*node] += 0.5 * cosine * weight);
                let part = 0.5 / PI * cosine * solid_angle(*direction);
                let half = &mut sky[usize::from(direction.z < 0.0)];
                half.0 += part;
                half.1 += part * direction;
            }
            cosines
        });
        for (a, one) in cosines[0].iter().enumerate().filter(|(_, cosine)| **cosine > 0.0) {
            for (entry, other) in self.table[a].iter_mut().zip(&cosines[1]) {
                *entry += bright * one * other;
            }
        }
        for (cell, seen) in self.seen.iter_mut().enumerate() {
            *seen += weight * 0.5 * (cosines[0][cell] + cosines[1][cell]);
        }
        let mut whole = 0.0;
        for (sums, visible) in self.sums.iter_mut().zip(visible).filter(|(_, visible)| *visible > 0.0) {
            let weight = weight * visible;
            whole += weight;
            sums.lit += bright * visible * visible;
            sums.weight += weight;
            sums.color += weight * color;
            sums.normal += weight * normal;
            for (sum, (open, directions)) in sums.sky.iter_mut().zip(sky) {
                sum.0 += weight * open;
                sum.1 += weight * directions;
            }
        }
        let (sum, weight) = &mut self.facings[Facing::number(*normal)];
        *sum += whole * normal;
        *weight += whole;
    }

    /// And of those of another voxel.
    pub(crate) fn add_all(&mut self, other: &Self) {
        for (sums, other) in self.sums.iter_mut().zip(&other.sums) {
            sums.lit += other.lit;
            sums.weight += other.weight;
            sums.color += other.color;
            sums.normal += other.normal;
            for (sum, other) in sums.sky.iter_mut().zip(other.sky) {
                *sum = (sum.0 + other.0, sum.1 + other.1);
            }
        }
        self.seen.iter_mut().zip(other.seen).for_each(|(sum, other)| *sum += other);
        let entries = self.table.as_flattened_mut().iter_mut().zip(other.table.as_flattened());
        entries.for_each(|(sum, other)| *sum += other);
        for (sum, other) in self.facings.iter_mut().zip(other.facings) {
            *sum = (sum.0 + other.0, sum.1 + other.1);
        }
    }

    /// What a voxel with these points reflects.
    pub(crate) fn measured(&self) -> Measured {
        // From cells to nodes.
        let mut sums = self.sums;
        sums.iter_mut().zip(FIT.of_means(&self.seen)).for_each(|(sums, seen)| sums.seen = seen);
        let table = FIT.of_pairs(&self.table);
        let most = sums.iter().fold(f32::MIN_POSITIVE, |most, sums| most.max(sums.seen));
        let most_lit = sums.iter().fold(f32::MIN_POSITIVE, |most, sums| most.max(sums.lit));
        let nodes = sums.map(|sums| Node::new(&sums, most, most_lit));
        let scales = nodes.map(|node| node.scale() * most_lit.sqrt());
        // No more is seen and lit than what is seen from either, as bright as that is.
        let seen = nodes.map(|node| most * node.root().powi(2) * brightness(node.color()));
        // D takes either way alike.
        let entry = |a: usize, b: usize| {
            let both = scales[a] * scales[b];
            let entry = (0.5 * (table[a][b] + table[b][a])).min(seen[a]).min(seen[b]);
            if both > 0.0 { entry / both } else { 0.0 }
        };
        let table: Vec<f32> = (0..NODES).flat_map(|a| (0..=a).map(move |b| entry(a, b))).collect();
        let largest = table.iter().fold(f32::MIN_POSITIVE, |largest, entry| largest.max(*entry));
        let root = |entry: &f32| (255.0 * (entry / largest).sqrt()).round() as u8;
        let table = table.iter().map(root).collect();
        Measured { nodes, facings: Facing::all(&self.facings), largest: largest * most_lit / most, table }
    }
}

impl Node {
    fn new(sums: &Sums, most: f32, most_lit: f32) -> Self {
        let Sums { seen, lit, weight, color, normal, sky } = *sums;
        if weight <= 0.0 {
            return Self::default();
        }
        let part = 1.0 / weight;
        let byte = |part: f32| (255.0 * part).round() as u8;
        let signed = |v: Vec3| v.to_array().map(|x| (127.0 * x).round() as i8);
        Self {
            root: byte((seen / most).max(0.0).sqrt()),
            scale: byte((lit / most_lit).sqrt().sqrt()),
            color: bytes((color * part).clamp(Vec3::ZERO, Vec3::ONE).map(f32::sqrt)),
            normal: signed(normal * part),
            sky: sky.map(|(open, sum)| (byte(open * part), signed(sum * part))),
        }
    }
}
