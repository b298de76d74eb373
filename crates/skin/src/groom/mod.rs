//! *Grooming*: a list of operations, each with masks, that change the vectors of a finished skin. [seed §1]
//!
//! The skin itself stays as it was, and so does the list: [`groom`] makes a new skin from both. After each
//! operation the boxes that it touched are certified and the folded ones counted; after the last, folded
//! boxes are mended, left out or refused.
//!
//! ```
//! use glam::Vec3;
//! use pelage_skin::groom::{GroomOptions, Mask, Operation, Region, Step, Tilt, groom};
//! use pelage_skin::{SkinOptions, extrude, surface};
//! # use pelage_geom::glam;
//!
//! let skin = extrude(&surface::plane(1.0, 8, 8), &|_face| true, &SkinOptions::new(0.1))?;
//! let half = Region::Box { min: Vec3::new(0.0, -1.0, -1.0), max: Vec3::ONE, falloff: 0.1 };
//! let steps = [
//!     Step::everywhere(Operation::Scale(0.5)),
//!     Step { operation: Operation::Tilt(Tilt { towards: Vec3::X, angle: 40.0 }), masks: vec![Mask::new(half)] },
//! ];
//! let groomed = groom(&skin, &steps, &GroomOptions::default())?;
//! assert_eq!(groomed.skin.len(), 64);
//! assert!(groomed.effects.iter().all(|effect| effect.folded == 0));
//! # Ok::<(), pelage_skin::SkinError>(())
//! ```

mod gather;
mod mask;
mod operation;
mod surface;
mod thin;
mod turn;

use core::fmt;

use glam::Vec3;
use rayon::prelude::*;

pub use mask::{Channel, Mask, Region};
pub use operation::{
    Clump, Comb, Field, Misfit, Noise, Operation, Part, Plane, Smooth, Swirl, Tilt, Turn, Wind,
};
use surface::{Ground, along_uv};
use thin::{Density, retain};
use turn::{Strand, by_vertex};

use crate::settle::{Settled, Wanted, settle};
use crate::validate::fault;
use crate::{Fold, Folds, Mending, Outcome, Skin, SkinError};

/// One operation and where it acts.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// What is done.
    pub operation: Operation,
    /// Where: their weights multiply; everywhere without any.
    pub masks: Vec<Mask>,
}

impl Step {
    /// An operation on the whole skin.
    pub fn everywhere(operation: Operation) -> Self {
        Self { operation, masks: Vec::new() }
    }
}

/// How a skin is groomed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroomOptions {
    /// No operation that lays vectors over lays one flatter than this, in degrees from the normal; from 0 to 90.
    /// [`Operation::Move`] and [`Operation::Turn`] do what they are told.
    pub steepest: f32,
    /// What is done with boxes that are folded in the end. Mending turns vectors back to what they were before
    /// grooming where that helps, and shortens them where it does not. [`Operation::Trim`] too leaves
    /// [`Mending::shortest`] of a vector.
    pub mending: Mending,
}

impl Default for GroomOptions {
    /// Up to 80° from the normal, folds mended.
    fn default() -> Self {
        Self { steepest: 80.0, mending: Mending::default() }
    }
}

/// What one operation did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effect {
    /// Vertices whose vectors it changed.
    pub vertices: usize,
    /// Boxes of the skin that were folded after it.
    pub folded: usize,
    /// The first of those that were not folded before it.
    pub first: Option<Fold>,
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} vectors changed, {} boxes folded", self.vertices, self.folded)?;
        self.first.map_or(Ok(()), |fold| write!(f, "; the first is {fold}"))
    }
}

/// A groomed skin, and how it came about.
#[derive(Clone, Debug, PartialEq)]
pub struct Groomed {
    /// The skin; its report tells what was mended in the end.
    pub skin: Skin,
    /// By operation.
    pub effects: Vec<Effect>,
}

/// Applies `steps`, in their order, to the vectors of `skin`. The result is the same bits for any number of threads.
///
/// A skin that is to be groomed is best made with [`Folds::Keep`]: what is folded at its first height
/// need not be in the end.
///
/// # Errors
/// [`SkinError::Groom`] for a number or a mask of a step that makes no sense; an option out of its domain; what
/// [`Skin::validate`] finds, folds aside; under [`Folds::Refuse`], a box that is folded in the end.
pub fn groom(skin: &Skin, steps: &[Step], options: &GroomOptions) -> Result<Groomed, SkinError> {
    options.validate()?;
    skin.check_shape()?;
    let ground = Ground::new(skin);
    let mut vectors: Vec<Vec3> = skin.top.par_iter().zip(&skin.base).map(|(t, b)| *t - *b).collect();
    let upright = vectors.clone();
    let mut top = skin.top.clone();
    let mut folded = vec![false; skin.len()];
    for fold in &skin.report.folds {
        // One that was mended or left out is no longer.
        if let Outcome::Found { patch } = fold.outcome
            && let Some(flag) = folded.get_mut(patch as usize)
        {
            *flag = true;
        }
    }
    // By patch whether a step has certified it; what is known to be valid in the end need not be asked again.
    let mut known = vec![false; skin.len()];
    let mut density = Density::FULL;
    let mut effects = Vec::with_capacity(steps.len());
    for (index, step) in steps.iter().enumerate() {
        let of_step = |reason: SkinError| SkinError::Groom { step: index, reason: Box::new(reason) };
        step.operation
            .validate()
            .map_err(|(field, reason)| of_step(SkinError::Operation { field, reason }))?;
        let weights = mask::product(&step.masks, skin).map_err(of_step)?;
        if let Operation::Density(factor) = step.operation {
            density.thin(factor, &weights);
        }
        let next = apply(step, skin, &ground, &vectors, &weights, options).map_err(of_step)?;
        let changed: Vec<bool> = vectors.par_iter().zip(&next).map(|(a, b)| a != b).collect();
        // What is not touched keeps its bits.
        top.par_iter_mut().enumerate().filter(|(i, _)| changed[*i]).for_each(|(i, t)| {
            *t = skin.base[i] + next[i];
        });
        vectors = next;
        effects.push(effect(skin, &top, &changed, [&mut folded, &mut known], options));
    }
    let mut groomed = skin.clone();
    if let Some(kept) = density.apply(&mut groomed) {
        retain(&mut folded, &kept);
        retain(&mut known, &kept);
    }
    let wanted = Wanted { base: &skin.base, top: &top, upright: Some(&upright) };
    let settled = if folded.contains(&true) || known.contains(&false) {
        let are_valid = |patch: usize| known[patch] && !folded[patch];
        settle(wanted, &groomed.patches, are_valid, &options.mending)
    } else {
        Settled::as_wanted(top, groomed.len())
    };
    if let (Folds::Refuse, Some(&first)) = (options.mending.folds, settled.folds.first()) {
        return Err(SkinError::StillFolded { count: settled.folds.len(), first });
    }
    settled.apply(&mut groomed);
    Ok(Groomed { skin: groomed, effects })
}

impl GroomOptions {
    fn validate(&self) -> Result<(), SkinError> {
        let (value, expected) = (self.steepest, "it must be from 0 to 90 degrees");
        if !(0.0..=90.0).contains(&value) {
            return Err(SkinError::Option { option: "steepest", value, expected });
        }
        self.mending.validate()
    }
}

/// The vectors after one step.
fn apply(
    step: &Step,
    skin: &Skin,
    ground: &Ground,
    vectors: &[Vec3],
    weights: &[f32],
    options: &GroomOptions,
) -> Result<Vec<Vec3>, SkinError> {
    let misfit = |(field, reason): Misfit| SkinError::Operation { field, reason };
    let along_uv = match &step.operation {
        Operation::Comb(Comb { along: Field::Uv(uv), .. }) => {
            let reason = "needs texture coordinates, and the mesh has none";
            Some(along_uv(skin, *uv).ok_or_else(|| misfit(("comb.along.uv", reason)))?)
        }
        _ => None,
    };
    let mut next = match (&step.operation, by_vertex(&step.operation, options.mending.shortest)) {
        (Operation::Clump(clump), _) => gather::clump(skin, ground, vectors, weights, clump),
        (Operation::Smooth(smooth), _) => gather::smooth(skin, vectors, weights, smooth),
        (_, None) => vectors.to_vec(),
        (_, Some(turned)) => (0..vectors.len())
            .into_par_iter()
            .map(|i| {
                let strand = Strand {
                    foot: skin.base[i],
                    normal: ground.normal[i],
                    vector: vectors[i],
                    along_uv: along_uv.as_ref().map_or(Vec3::ZERO, |along| along[i]),
                    weight: weights[i],
                };
                if strand.weight > 0.0 { turned(&strand) } else { strand.vector }
            })
            .collect(),
    };
    if !step.operation.is_exact() {
        let steepest = options.steepest.to_radians();
        next.par_iter_mut().enumerate().for_each(|(i, v)| limit(v, vectors[i], ground.normal[i], steepest));
    }
    Ok(next)
}

/// Turns a vector back to `steepest` from the normal, or to where it was before.
fn limit(vector: &mut Vec3, before: Vec3, normal: Vec3, steepest: f32) {
    if *vector == before || normal == Vec3::ZERO || *vector == Vec3::ZERO {
        return;
    }
    let from_normal = |v: Vec3| if v == Vec3::ZERO { 0.0 } else { v.angle_between(normal) };
    let excess = from_normal(*vector) - from_normal(before).max(steepest);
    if excess > 0.0 {
        *vector = vector.rotate_towards(normal, excess);
    }
}

/// Certifies the boxes at changed vertices and counts all that are folded.
fn effect(
    skin: &Skin,
    top: &[Vec3],
    changed: &[bool],
    [folded, known]: [&mut [bool]; 2],
    options: &GroomOptions,
) -> Effect {
    let found: Vec<(usize, Option<Fold>)> = (skin.patches.par_iter().enumerate())
        .filter(|(_, patch)| patch.corners().iter().any(|&v| changed[v as usize]))
        .map(|(i, patch)| (i, fault(i, patch, &skin.base, top, options.mending.certificate_depth)))
        .collect();
    let mut first = None;
    for (patch, fold) in found {
        if !folded[patch] {
            first = first.or(fold);
        }
        (folded[patch], known[patch]) = (fold.is_some(), true);
    }
    Effect {
        vertices: changed.iter().filter(|c| **c).count(),
        folded: folded.iter().filter(|f| **f).count(),
        first,
    }
}
