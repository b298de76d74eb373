//! What was measured: the fields of `pelage bench --json`. Times are medians in seconds, sizes bytes.

use pelage::tracer::{self, Counts, Scene};
use serde::{Deserialize, Serialize};

use super::scenes::{BenchScene, Distance};

/// A whole run.
#[derive(Debug, Serialize, Deserialize)]
pub struct Report {
    /// Of pelage.
    pub version: String,
    /// Width and height of the pictures.
    pub size: [u32; 2],
    /// How often each time was taken.
    pub runs: usize,
    /// Voxels a side of the texels.
    pub resolution: u32,
    /// Each measured in a process of its own.
    pub scenes: Vec<SceneReport>,
}

/// A scene.
#[derive(Debug, Serialize, Deserialize)]
pub struct SceneReport {
    /// Its name.
    pub scene: String,
    /// What it shows.
    pub about: String,
    /// Boxes of its skin.
    pub boxes: usize,
    /// Triangles of the content of a box times boxes, and those of the ground.
    pub triangles: u64,
    /// Of the texel.
    pub texel_bytes: usize,
    /// Of the skin: corners and patches, before they are compiled.
    pub skin_bytes: usize,
    /// The most memory that the process had in use, all pictures and runs included, where the system tells.
    pub peak_memory: Option<u64>,
    /// Threads of the stages before rendering.
    pub threads: usize,
    /// Of these stages.
    pub seconds: Seconds,
    /// Of every distance, number of threads and path.
    pub pictures: Vec<Picture>,
    /// Of a scene that moves.
    pub frame: Option<Frame>,
}

/// Times of what comes before rendering.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Seconds {
    /// To read the scene and its texel.
    pub load: f64,
    /// To raise, groom and certify the boxes.
    pub extrude: f64,
    /// To build the trees and what else rays ask for.
    pub compile: f64,
}

/// A picture.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Picture {
    /// From how far.
    pub distance: Distance,
    /// Along which path.
    pub path: Along,
    /// With how many threads.
    pub threads: usize,
    /// To render it.
    pub seconds: f64,
    /// The same of all threads together.
    pub cpu_seconds: f64,
    /// From the scene file to the picture.
    pub from_file_seconds: f64,
    /// Pictures a second, once the scene is ready.
    pub pictures_per_second: f64,
    /// Of a curved path: its CPU time over that of the straight path, the median of runs by turns.
    pub over_straight: Option<f64>,
    /// Of several threads, if there was also one: the time of one over this time, a thread.
    pub efficiency: Option<f64>,
    /// What was done for it.
    #[serde(flatten)]
    pub work: Work,
}

/// What was done for a picture. A *ray* is a ray from the camera or a cone to a light.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Work {
    /// Rays, in millions a second.
    pub mrays_per_second: f64,
    /// Light cones a pixel.
    pub light_cones_per_pixel: f64,
    /// Passages of a ray through boxes.
    pub passages_per_ray: f64,
    /// Chords of a ray.
    pub chords_per_ray: f64,
    /// Walks of a ray through a level.
    pub walks_per_ray: f64,
    /// Occupied cells that a ray met.
    pub cells_per_ray: f64,
    /// CPU time over rays, in nanoseconds: finding boxes, walking, blending and shading.
    pub ns_per_ray: f64,
    /// The same over cells.
    pub ns_per_cell: f64,
    /// Camera rays, light cones, passages, chords, walks and cells in all.
    pub counts: [u64; 6],
}

/// Which way through a bent box.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Along {
    /// The true curve.
    Curved,
    /// A straight line from entry to exit, as in the paper.
    Straight,
}

/// A frame of a scene that moves.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Frame {
    /// To move the ground.
    pub deform: f64,
    /// To move the skin on it, and certify and mend its boxes.
    pub certify: f64,
    /// To build the scene.
    pub build: f64,
    /// To render it, along the curved path.
    pub render: f64,
    /// All of it.
    pub total: f64,
}

impl SceneReport {
    /// Of a scene that is not measured yet.
    pub fn of(scene: &BenchScene, threads: usize) -> Self {
        Self {
            scene: scene.name.into(),
            about: scene.about.into(),
            boxes: 0,
            triangles: 0,
            texel_bytes: 0,
            skin_bytes: 0,
            peak_memory: None,
            threads,
            seconds: Seconds::default(),
            pictures: Vec::new(),
            frame: None,
        }
    }

    /// Notes what there is in the scene.
    pub fn describe(&mut self, scene: &Scene) {
        let texels = || scene.coats().iter().flat_map(|coat| &coat.texels.texels);
        self.boxes = scene.box_count();
        self.texel_bytes = texels().map(|(texel, _)| texel.memory()).sum();
        self.skin_bytes = scene.coats().iter().map(|coat| coat.skin.bytes()).sum();
        if self.triangles == 0 {
            let of_box =
                texels().filter_map(|(texel, _)| texel.source().geometry()).map(|g| g.triangles.len());
            self.triangles = (self.boxes * of_box.sum::<usize>() + scene.triangle_count()) as u64;
        }
    }
}

impl Seconds {
    /// All of them.
    pub fn sum(&self) -> f64 {
        self.load + self.extrude + self.compile
    }
}

impl Work {
    /// Of a picture of `size` that took so many seconds.
    pub fn new(counts: &Counts, seconds: f64, cpu_seconds: f64, size: [u32; 2]) -> Self {
        let Counts { rays, light_cones, passages, chords, walks, cells } = *counts;
        let traced = (rays + light_cones).max(1) as f64;
        Self {
            mrays_per_second: 1e-6 * traced / seconds,
            light_cones_per_pixel: light_cones as f64 / size.map(f64::from).iter().product::<f64>(),
            passages_per_ray: passages as f64 / traced,
            chords_per_ray: chords as f64 / traced,
            walks_per_ray: walks as f64 / traced,
            cells_per_ray: cells as f64 / traced,
            ns_per_ray: 1e9 * cpu_seconds / traced,
            ns_per_cell: 1e9 * cpu_seconds / cells.max(1) as f64,
            counts: [rays, light_cones, passages, chords, walks, cells],
        }
    }
}

impl Along {
    /// As the tracer knows it.
    pub fn path(self) -> tracer::Path {
        match self {
            Self::Curved => tracer::Path::Curved,
            Self::Straight => tracer::Path::Straight,
        }
    }
}
