//! The scenes that are measured: each is a scene file of its own, told by a few numbers.

use std::fmt::Write;

use clap::ValueEnum;
use pelage::geom::glam::Vec3;
use pelage::scene_file::TexelEntry;
use pelage::texel::{Fur, Grass, Kind};
use pelage::tracer::Camera;
use serde::{Deserialize, Serialize};

/// A scene to measure.
#[derive(Debug)]
pub struct BenchScene {
    /// What it is called.
    pub name: &'static str,
    /// What it shows.
    pub about: &'static str,
    /// What fills its boxes.
    pub content: Content,
    ground: Ground,
    /// Boxes along the two sides of the ground.
    boxes: [u32; 2],
    bend: Bend,
    /// Whether it moves: then a frame is measured, and not only a picture.
    pub moves: bool,
}

/// What fills the boxes. All of it is matt, so that other programs can show the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// 200 blades of 8 triangles.
    Blades,
    /// 400 hairs of 24 triangles.
    Hairs,
}

/// What the boxes stand on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Ground {
    /// A square of so many metres.
    Square(f32),
    /// One of 2 m, with waves.
    Waves,
    /// A torus of radii 1 m and 0.4 m.
    Torus,
}

/// How the boxes are bent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bend {
    /// As the ground has them.
    Upright,
    /// Each vector is turned a little its own way.
    Mild,
    /// All lean, and each is turned far its own way and of its own length.
    Strong,
}

/// From how far a scene is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Distance {
    /// A part of it fills the picture
    Near,
    /// All of it fills the picture
    Mid,
    /// It is a quarter as wide as the picture
    Far,
}

impl Distance {
    /// As in file names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Near => "near",
            Self::Mid => "mid",
            Self::Far => "far",
        }
    }

    /// Metres from the middle of the scene.
    fn metres(self) -> f32 {
        match self {
            Self::Near => 1.5,
            Self::Mid => 5.4,
            Self::Far => 21.6,
        }
    }
}

/// Vertical angle of view, in degrees.
const FOV: f32 = 30.0;

/// A skin of blades on waves, strongly bent.
const fn blades(name: &'static str, about: &'static str, side: u32) -> BenchScene {
    BenchScene {
        name,
        about,
        content: Content::Blades,
        ground: Ground::Waves,
        boxes: [side, side],
        bend: Bend::Strong,
        moves: false,
    }
}

/// All of them.
pub const SCENES: [BenchScene; 12] = [
    blades("blades-256", "256 strongly bent boxes of 200 blades", 16),
    blades("blades-4096", "4096 of them on the same ground", 64),
    blades("blades-16384", "16384 of them", 128),
    blades("blades-65536", "65536 of them", 256),
    BenchScene {
        bend: Bend::Upright,
        ground: Ground::Square(2.0),
        ..blades("blades-upright", "4096 boxes of blades that are not bent at all", 64)
    },
    BenchScene {
        bend: Bend::Mild,
        ..blades("blades-mild", "4096 boxes of blades that are bent a little", 64)
    },
    BenchScene {
        content: Content::Hairs,
        ground: Ground::Torus,
        boxes: [64, 32],
        bend: Bend::Upright,
        ..blades("hairs", "a torus of 2048 boxes of 400 hairs", 0)
    },
    BenchScene {
        ground: Ground::Square(1.5),
        ..blades("one-box", "one strongly bent box, as in the paper", 1)
    },
    BenchScene {
        content: Content::Hairs,
        ground: Ground::Square(2.0),
        bend: Bend::Upright,
        ..blades("flat", "a flat surface under fur, as in the paper", 16)
    },
    BenchScene {
        content: Content::Hairs,
        ..blades("bent", "a strongly bent surface under fur, as in the paper", 16)
    },
    blades("million", "a million boxes of blades", 1000),
    BenchScene { moves: true, ..blades("moving", "4096 boxes of blades that move, frame after frame", 64) },
];

/// The scene of this name.
pub fn scene(name: &str) -> Result<&'static BenchScene, String> {
    let names = || SCENES.iter().map(|scene| scene.name).collect::<Vec<_>>().join(", ");
    SCENES.iter().find(|scene| scene.name == name).ok_or_else(|| format!("expected one of {}", names()))
}

impl Content {
    /// As in file names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Blades => "blades",
            Self::Hairs => "hairs",
        }
    }

    /// What grows, so many voxels a side.
    pub fn entry(self, resolution: u32) -> TexelEntry {
        let kind: Kind = match self {
            Self::Blades => Grass { count: 200, segments: 4, specular: 0.0, ..Grass::meadow() }.into(),
            Self::Hairs => Fur { specular: 0.0, ..Fur::hair() }.into(),
        };
        TexelEntry::Grown { kind, resolution }
    }
}

impl BenchScene {
    /// Where the eye is. It always looks at the origin.
    fn eye(&self, distance: Distance) -> [f32; 3] {
        [0.36, 0.78, 0.51].map(|x| x * distance.metres())
    }

    /// The camera that the scene file describes.
    pub fn camera(&self, distance: Distance) -> Camera {
        Camera::look_at(self.eye(distance).into(), Vec3::ZERO, Vec3::Y, FOV.to_radians())
    }

    /// Width of a box, in metres.
    fn width(&self) -> f32 {
        match self.ground {
            Ground::Square(side) => side / self.boxes[0] as f32,
            Ground::Waves => 2.0 / self.boxes[0] as f32,
            Ground::Torus => 0.09,
        }
    }

    /// The scene file, with its texel in the file `texel`.
    pub fn text(&self, distance: Distance, size: [u32; 2], texel: &str) -> String {
        let (ground, [nu, nv], width) = (self.ground.surface(), self.boxes, self.width());
        let (eye, [columns, rows]) = (self.eye(distance), size);
        format!(
            "# {about}\n\
             geometry = [{{ surface = {{ {ground} }}, patches = [{nu}, {nv}], name = \"Ground\", color = [0.25, 0.2, 0.15] }}]\n\n\
             [[skin]]\n\
             texel.file = \"{texel}\"\n\
             layout = \"per-patch\"\n\
             tiling = 1\n\
             height = {height:?}\n\
             wears_material = false\n\
             {bend}\n\
             [camera.look_at]\n\
             eye = {eye:?}\n\
             target = [0, 0, 0]\n\
             fov = {FOV:?}\n\n\
             [[light]]\n\
             directional = {{ direction = [0.5, -0.8, -0.35], illuminance = [3.14159, 3.14159, 3.14159], angle = 0 }}\n\n\
             [render]\n\
             size = [{columns}, {rows}]\n\
             background = \"none\"\n",
            about = self.about,
            height = 0.9 * width,
            bend = self.bend.skin(width),
        )
    }
}

impl Ground {
    /// As in a scene file.
    fn surface(self) -> String {
        match self {
            Self::Square(side) => format!("plane = {{ size = [{side:?}, {side:?}] }}"),
            Self::Torus => "torus = { major = 1, minor = 0.4 }".into(),
            Self::Waves => {
                // The net reaches one step beyond the sides of the surface.
                const COLUMNS: u32 = 20;
                let at = |i: u32| (i as f32 - 1.0) / (COLUMNS - 3) as f32 * 2.0 - 1.0;
                let mut points = String::new();
                for j in 0..COLUMNS {
                    for i in 0..COLUMNS {
                        let (x, z) = (at(i), -at(j));
                        let y = 0.11 * (6.0 * x + 1.5 * z).sin() * (5.0 * z - 1.0).cos();
                        let _ = write!(points, "[{x:.4},{y:.4},{z:.4}],");
                    }
                }
                format!("bspline = {{ columns = {COLUMNS}, points = [{points}] }}")
            }
        }
    }
}

impl Bend {
    /// As in a skin of a scene file, for boxes of this width in metres.
    fn skin(self, width: f32) -> String {
        let noise = |height: f32, tilt: f32| {
            let size = 2.5 * width;
            format!(
                "[[skin.groom]]\nnoise = {{ height = {height:?}, tilt = {tilt:?}, size = {size:?}, seed = 7 }}\n"
            )
        };
        match self {
            Self::Upright => String::new(),
            Self::Mild => noise(0.05, 12.0),
            Self::Strong => format!("lean = [0.35, 0, 0.2]\n{}", noise(0.25, 45.0)),
        }
    }
}
