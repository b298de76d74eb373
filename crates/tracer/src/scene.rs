//! The scene in memory: described by plain structs, compiled once, then only read.

use std::sync::LazyLock;

use glam::{DVec3, Vec2, Vec3};
use pelage_geom::{Hexahedron, Material, MaterialId, Mesh, MeshError, Texture};
use pelage_skin::{Patch, Skin};
use pelage_texel::Texel;
use rayon::prelude::*;

use crate::accel::Accel;
use crate::reference::Lighting;
use crate::surface::Surfaces;
use crate::variety::Tile;
use crate::{Environment, Light, Variety};

/// A skin with the texel that fills its boxes.
#[derive(Clone, Debug)]
pub struct Coat {
    /// The boxes.
    pub skin: Skin,
    /// What stands in the copies laid out on them: a texel, by `texel.into()`, or several; shared, never copied.
    pub texels: Variety,
    /// Multiplies the texels' colours.
    pub tint: Vec3,
    /// Whether the base colour (and texture) of each patch's material multiplies the texels' colours too.
    pub wears_material: bool,
}

impl Coat {
    /// What stands in a copy of a patch's lattice, and how where copies differ.
    #[inline]
    pub(crate) fn standing(&self, patch: &Patch, copy: [i32; 2]) -> (&Texel, Option<Tile>) {
        match self.texels.plain() {
            Some(texel) => (texel, None),
            None => {
                let tile = self.texels.tile(&patch.anchor, copy);
                (self.texels.of(&tile), Some(tile))
            }
        }
    }
}

/// A scene as it is described: what [`Scene::new`] compiles.
#[derive(Clone, Debug)]
pub struct Description {
    /// Opaque meshes: the surfaces under the skins among them.
    pub meshes: Vec<Mesh>,
    /// The dressed skins.
    pub coats: Vec<Coat>,
    /// What [`pelage_geom::MaterialId`]s index.
    pub materials: Vec<Material>,
    /// What [`pelage_geom::TextureId`]s index.
    pub textures: Vec<Texture>,
    /// Lights with a place or a direction.
    pub lights: Vec<Light>,
    /// The light of the surroundings.
    pub environment: Environment,
}

/// What makes a description unusable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SceneError {
    /// A mesh is unusable.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A patch of a skin cannot stand.
    #[error("coat {coat}, patch {patch}: {reason}")]
    Patch {
        /// Which coat.
        coat: usize,
        /// Which patch of its skin.
        patch: usize,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// What a coat's copies hold cannot be chosen.
    #[error("coat {coat}: {reason}")]
    Variety {
        /// Which coat.
        coat: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// A coat's tint, a material or the environment holds a number that is not finite or a negative colour.
    #[error("{what} {index} holds a colour that is negative or not finite")]
    Color {
        /// `coat`, `material` or `environment`.
        what: &'static str,
        /// Which of them.
        index: usize,
    },
    /// A light holds a number that is not finite, or a direction without length.
    #[error("light {light} is not usable: {reason}")]
    Light {
        /// Which light.
        light: usize,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// There are more boxes than a `u32` counts.
    #[error("the coats have {count} boxes in all; {limit} is the most")]
    TooManyBoxes {
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
}

/// Says what keeps a patch from standing, if anything does.
fn check_patch(skin: &Skin, patch: &Patch) -> Result<(), &'static str> {
    let mut corners =
        patch.corners().iter().map(|&i| skin.base.get(i as usize).zip(skin.top.get(i as usize)));
    if !corners.all(|corner| corner.is_some_and(|(base, top)| base.is_finite() && top.is_finite())) {
        return Err("a corner of the box does not exist, or is not a finite number");
    }
    let area = patch.lattice.determinant();
    if !(patch.lattice.origin.is_finite() && area.is_finite() && area != 0.0) {
        return Err("its lattice has no area, or is not finite");
    }
    Ok(())
}

/// The bounds around two.
fn around([lo, hi]: [Vec3; 2], [a, b]: [Vec3; 2]) -> [Vec3; 2] {
    [lo.min(a), hi.max(b)]
}

fn check_color(what: &'static str, index: usize, color: Vec3) -> Result<(), SceneError> {
    if color.is_finite() && color.min_element() >= 0.0 {
        Ok(())
    } else {
        Err(SceneError::Color { what, index })
    }
}

/// Checks every light, and the light of the surroundings.
pub(crate) fn check_lighting(lights: &[Light], environment: &Environment) -> Result<(), SceneError> {
    for (light, l) in lights.iter().enumerate() {
        l.check().map_err(|reason| SceneError::Light { light, reason })?;
    }
    [environment.sky, environment.ground].into_iter().try_for_each(|c| check_color("environment", 0, c))
}

/// The geometric mean of the edges that texels have in the middle of some hundred boxes of each coat; 1 without any.
fn mean_edge(coats: &[Coat]) -> f64 {
    const MOST: usize = 500;
    let (mut sum, mut count) = (0.0, 0.0);
    for Coat { skin, .. } in coats {
        for (i, patch) in skin.patches.iter().enumerate().step_by(skin.patches.len().div_ceil(MOST).max(1)) {
            let jacobian = skin.hexahedron(i).map().jacobian(DVec3::splat(0.5));
            let volume = (jacobian.determinant() / f64::from(patch.lattice.determinant())).abs();
            if volume > 0.0 && volume.is_finite() {
                sum += volume.ln() / 3.0;
                count += 1.0;
            }
        }
    }
    if count > 0.0 { f64::exp(sum / count) } else { 1.0 }
}

/// A compiled scene: immutable, shared by all threads.
pub struct Scene {
    pub(crate) coats: Vec<Coat>,
    /// Number of the first box of each coat, and one past the last.
    first_box: Vec<u32>,
    /// The bent boxes of all coats, ready to be asked: preparing one costs more than a ray through it.
    hexahedra: Vec<Hexahedron>,
    /// Of each box, which of its walls are open: where its skin ends.
    open_sides: Vec<[bool; 4]>,
    pub(crate) boxes: Accel,
    pub(crate) surfaces: Surfaces,
    pub(crate) materials: Vec<Material>,
    pub(crate) textures: Vec<Texture>,
    pub(crate) lights: Vec<Light>,
    pub(crate) environment: Environment,
    /// How far a coat reaches from its surface at most, in scene units.
    pub(crate) reach: f32,
    bounds: Option<[Vec3; 2]>,
    /// The edge of a texel in most of the boxes, in scene units.
    pub(crate) edge: f64,
}

impl Scene {
    /// Checks the description and builds the trees over boxes and triangles.
    ///
    /// # Errors
    /// The first thing found that cannot be rendered, with its index.
    pub fn new(description: Description) -> Result<Self, SceneError> {
        let Description { meshes, coats, materials, textures, lights, environment } = description;
        for mesh in &meshes {
            mesh.validate()?;
        }
        check_lighting(&lights, &environment)?;
        let colors = (coats.iter().enumerate().map(|(i, c)| ("coat", i, c.tint))).chain(
            materials.iter().enumerate().flat_map(|(i, m)| {
                [m.base_color, m.emissive, Vec3::new(m.specular, m.roughness, 0.0)]
                    .map(|c| ("material", i, c))
            }),
        );
        for (what, index, color) in colors {
            check_color(what, index, color)?;
        }
        let mesh_bounds = meshes.iter().filter_map(Mesh::bounds).reduce(around);
        // What takes the most memory while it is made comes before what stays.
        let surfaces = Surfaces::new(meshes);
        let mut first_box = vec![0_u32];
        let mut box_bounds = vec![];
        let mut hexahedra = vec![];
        let mut open_sides = vec![];
        let mut reach = 0.0_f32;
        for (coat, c) in coats.iter().enumerate() {
            c.texels.fault().map_or(Ok(()), |reason| Err(SceneError::Variety { coat, reason }))?;
            let patches = || c.skin.patches.par_iter().enumerate();
            let fault = patches().find_map_first(|(patch, p)| Some((patch, check_patch(&c.skin, p).err()?)));
            fault.map_or(Ok(()), |(patch, reason)| Err(SceneError::Patch { coat, patch, reason }))?;
            open_sides.extend(c.skin.open_sides());
            hexahedra.par_extend(patches().map(|(patch, _)| c.skin.hexahedron(patch)));
            box_bounds.par_extend(patches().map(|(patch, _)| c.skin.bounds(patch)));
            for (base, top) in c.skin.base.iter().zip(&c.skin.top) {
                reach = reach.max(base.distance(*top));
            }
            let count = box_bounds.len();
            // The tree's own indices are 32 bits wide, a few of them for flags.
            let limit = 1 << 28;
            if count > limit {
                return Err(SceneError::TooManyBoxes { count, limit });
            }
            first_box.push(count as u32);
        }
        let bounds = mesh_bounds.into_iter().chain(box_bounds.iter().copied()).reduce(around);
        Ok(Self {
            edge: mean_edge(&coats),
            boxes: Accel::new(box_bounds),
            surfaces,
            coats,
            first_box,
            hexahedra,
            open_sides,
            materials,
            textures,
            lights,
            environment,
            reach,
            bounds,
        })
    }

    /// Changes the light, and nothing else.
    ///
    /// # Errors
    /// The first light that cannot be used, or an environment that is not a colour; the scene is then as it was.
    pub fn set_lighting(&mut self, lighting: Lighting) -> Result<(), SceneError> {
        check_lighting(&lighting.lights, &lighting.environment)?;
        self.lights = lighting.lights;
        self.environment = lighting.environment;
        Ok(())
    }

    /// The light of the scene.
    pub fn lighting(&self) -> Lighting {
        Lighting { lights: self.lights.clone(), environment: self.environment }
    }

    /// The smallest and largest coordinates of everything, or `None` for an empty scene.
    pub fn bounds(&self) -> Option<[Vec3; 2]> {
        self.bounds
    }

    /// The coats, as they were described.
    pub fn coats(&self) -> &[Coat] {
        &self.coats
    }

    /// How many boxes stand in the scene.
    pub fn box_count(&self) -> usize {
        self.first_box.last().map_or(0, |&n| n as usize)
    }

    /// How many opaque triangles there are.
    pub fn triangle_count(&self) -> usize {
        self.surfaces.len()
    }

    pub(crate) fn coat_index(&self, patch: u32) -> usize {
        self.first_box.partition_point(|&first| first <= patch) - 1
    }

    /// The numbers of the boxes of each coat.
    pub(crate) fn boxes_of_coats(&self) -> impl Iterator<Item = std::ops::Range<u32>> + '_ {
        self.first_box.windows(2).map(|ends| ends[0]..ends[1])
    }

    /// The place of a box among the patches of its own coat.
    pub(crate) fn patch_index(&self, patch: u32) -> usize {
        (patch - self.first_box[self.coat_index(patch)]) as usize
    }

    /// The coat and the patch of a box.
    pub(crate) fn patch(&self, patch: u32) -> (&Coat, &Patch) {
        let index = self.coat_index(patch);
        let coat = &self.coats[index];
        (coat, &coat.skin.patches[(patch - self.first_box[index]) as usize])
    }

    /// The bent box of a patch.
    #[inline]
    pub(crate) fn hexahedron(&self, patch: u32) -> &Hexahedron {
        &self.hexahedra[patch as usize]
    }

    /// Which walls of a box are open, in the order of its patch's outline; `None` if none is.
    #[inline]
    pub(crate) fn open_sides(&self, patch: u32) -> Option<[bool; 4]> {
        Some(self.open_sides[patch as usize]).filter(|sides| sides.contains(&true))
    }

    /// The material of an opaque surface.
    pub(crate) fn material(&self, id: MaterialId) -> &Material {
        static PLAIN: LazyLock<Material> = LazyLock::new(Material::default);
        self.materials.get(id.0 as usize).unwrap_or(&PLAIN)
    }

    /// Diffuse albedo of a material at `uv`, averaged over `footprint` units of uv.
    pub(crate) fn colour_of(&self, material: &Material, uv: Vec2, footprint: f32) -> Vec3 {
        let texture = material.base_color_texture.and_then(|id| self.textures.get(id.0 as usize));
        material.base_color * texture.map_or(Vec3::ONE, |texture| texture.sample(uv, footprint))
    }

    /// By how much a point on a surface may lie off it, in scene units: a part of the largest coordinate that
    /// is far above the rounding of `f64` and far below anything seen.
    pub(crate) fn rounding(&self) -> f64 {
        self.bounds.map_or(0.0, |[lo, hi]| 1e-8 * f64::from(lo.abs().max(hi.abs()).max_element()))
    }
}
