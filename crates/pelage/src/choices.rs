//! The words by which scene files and command lines name choices: one parser for both.

use pelage_geom::Footprint;
use pelage_skin::{Folds, Layout};
use pelage_tracer::{Lod, Opacity, Path, Quality, Rays};
use serde::{Deserializer, de};

use crate::bake::Fit;
use crate::import::Up;
use crate::output::{Aov, Tone};

/// What stands behind the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Background {
    /// The sky and the ground that light it.
    Sky,
    /// Nothing: the picture is transparent there.
    None,
    /// This sRGB colour, as the screen shows it.
    Color([u8; 3]),
}

/// How a picture is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// By cones through voxels.
    #[default]
    Cone,
    /// By rays through the geometry that the texels were made from: slow, to compare with.
    Reference,
}

/// A choice that has a word.
pub trait Choice: Sized {
    /// What may be written, for messages.
    const EXPECTED: &'static str;

    /// The words; others may be possible besides.
    const WORDS: &'static [&'static str];

    /// The choice that `word` names.
    fn from_word(word: &str) -> Option<Self>;

    /// The choice that `word` names, or a message that says what may be written.
    ///
    /// # Errors
    /// The word is none of them.
    fn parse(word: &str) -> Result<Self, String> {
        Self::from_word(word).ok_or_else(|| format!("`{word}`: expected {}", Self::EXPECTED))
    }
}

/// Implements [`Choice`] for a type by a table of words.
macro_rules! words {
    ($type:ty, $expected:literal, $($word:literal => $value:expr),+) => {
        impl Choice for $type {
            const EXPECTED: &'static str = $expected;
            const WORDS: &'static [&'static str] = &[$($word),+];

            fn from_word(word: &str) -> Option<Self> {
                match word {
                    $($word => Some($value),)+
                    _ => None,
                }
            }
        }
    };
}

words!(Up, "y or z", "y" => Up::Y, "z" => Up::Z);
words!(Fit, "cube, floor or keep", "cube" => Fit::Cube, "floor" => Fit::Floor, "keep" => Fit::Keep);
words!(Quality, "draft, normal or high",
    "draft" => Quality::Draft, "normal" => Quality::Normal, "high" => Quality::High);
words!(Rays, "adaptive, 1, 4 or 16", "adaptive" => Rays::Adaptive, "1" => Rays::One, "4" => Rays::Four, "16" => Rays::Sixteen);
words!(Path, "curved or straight", "curved" => Path::Curved, "straight" => Path::Straight);
words!(Opacity, "exponential or linear", "exponential" => Opacity::Exponential, "linear" => Opacity::Linear);
words!(Tone, "filmic or none", "filmic" => Tone::Filmic, "none" => Tone::None);
words!(Method, "cone or reference", "cone" => Method::Cone, "reference" => Method::Reference);
words!(Layout, "auto, uv, conformal or per-patch",
    "auto" => Layout::Auto, "uv" => Layout::Uv, "conformal" => Layout::Conformal, "per-patch" => Layout::PerPatch);
words!(Aov, "patch, stretch or normal",
    "patch" => Aov::Patch, "stretch" => Aov::Stretch, "normal" => Aov::Normal);
words!(Folds, "mend, leave-out or refuse",
    "mend" => Folds::Mend, "leave-out" => Folds::LeaveOut, "refuse" => Folds::Refuse);

impl Choice for Lod {
    const EXPECTED: &'static str = "auto, sharp, smooth, or a level from 0 to 12";
    const WORDS: &'static [&'static str] =
        &["auto", "sharp", "smooth", "0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "10", "11", "12"];

    fn from_word(word: &str) -> Option<Self> {
        match word {
            "auto" => Some(Self::Footprint(Footprint::Auto)),
            "sharp" => Some(Self::Footprint(Footprint::Sharp)),
            "smooth" => Some(Self::Footprint(Footprint::Smooth)),
            level => level.parse().ok().filter(|&n| n <= 12).map(Self::Level),
        }
    }
}

impl Choice for Background {
    const EXPECTED: &'static str = "sky, none, or a colour like #a0c4ff";
    const WORDS: &'static [&'static str] = &["sky", "none"];

    fn from_word(word: &str) -> Option<Self> {
        match word {
            "sky" => Some(Self::Sky),
            "none" => Some(Self::None),
            color => {
                let digits = color.strip_prefix('#').filter(|d| d.len() == 6 && d.is_ascii())?;
                let byte = |i: usize| u8::from_str_radix(&digits[2 * i..2 * i + 2], 16).ok();
                Some(Self::Color([byte(0)?, byte(1)?, byte(2)?]))
            }
        }
    }
}

/// Reads a choice from a scene file: a string, or a whole number for those that are numbers.
pub(crate) fn deserialize<'de, D: Deserializer<'de>, C: Choice>(deserializer: D) -> Result<C, D::Error> {
    struct Word<C>(std::marker::PhantomData<C>);
    impl<C: Choice> de::Visitor<'_> for Word<C> {
        type Value = C;

        fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
            f.write_str(C::EXPECTED)
        }

        fn visit_str<E: de::Error>(self, word: &str) -> Result<C, E> {
            C::parse(word).map_err(E::custom)
        }

        fn visit_i64<E: de::Error>(self, number: i64) -> Result<C, E> {
            self.visit_str(&number.to_string())
        }

        // What JSON has.
        fn visit_u64<E: de::Error>(self, number: u64) -> Result<C, E> {
            self.visit_str(&number.to_string())
        }
    }
    deserializer.deserialize_any(Word(std::marker::PhantomData))
}

/// Reads a choice that may be missing.
pub(crate) fn deserialize_some<'de, D, C>(deserializer: D) -> Result<Option<C>, D::Error>
where
    D: Deserializer<'de>,
    C: Choice,
{
    deserialize(deserializer).map(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_what_is_none() {
        assert_eq!(Background::parse("#0aFf10"), Ok(Background::Color([10, 255, 16])));
        assert_eq!(Lod::parse("7"), Ok(Lod::Level(7)));
        assert_eq!(Rays::parse("16"), Ok(Rays::Sixteen));
        for bad in ["#12345", "#12345g", "#ééé", "Sky", ""] {
            assert!(Background::parse(bad).is_err(), "{bad}");
        }
        assert_eq!(
            Lod::parse("13"),
            Err("`13`: expected auto, sharp, smooth, or a level from 0 to 12".into())
        );
    }
}
