//! Which texels grow on a skin, and how the copies of them differ.

use std::fmt;

use pelage_texel::Kind;
use schemars::JsonSchema;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use super::texel::{OneOf, TexelEntry};

/// One of the texels of a skin, with its weight.
#[derive(Clone, Debug, PartialEq)]
pub struct ShareEntry {
    /// What grows.
    pub texel: TexelEntry,
    /// How many copies it stands in: as great a part as its weight is of all. 1 unless given.
    pub weight: f32,
    /// How many texels are grown of it: its variants, the kind's own, the next, and so on, or of kinds that have none, from
    /// one seed after the other. They share its weight. 1 unless given, and only 1 of a file.
    pub variants: u32,
}

impl From<TexelEntry> for ShareEntry {
    fn from(texel: TexelEntry) -> Self {
        Self { texel, weight: 1.0, variants: 1 }
    }
}

impl ShareEntry {
    /// Each of its texels, with its part of the weight.
    pub fn texels(&self) -> impl Iterator<Item = (TexelEntry, f32)> + '_ {
        let count = self.variants.max(1);
        (0..count).map(move |i| (self.texel.variant_after(i), self.weight / count as f32))
    }

    /// The first field that is out of its domain, and what is wrong with it.
    pub(super) fn fault(&self) -> Option<(String, String)> {
        const MOST_VARIANTS: u32 = 64;
        let fault = |field: &str, reason: &str| Some((field.to_owned(), reason.to_owned()));
        if !(0.0..=1e12).contains(&self.weight) {
            return fault("weight", "must be from 0 to 1e12");
        }
        if !(1..=MOST_VARIANTS).contains(&self.variants) {
            return fault("variants", &format!("must be from 1 to {MOST_VARIANTS}"));
        }
        if self.variants > 1 && self.texel.variant_after(1) == self.texel {
            return fault("variants", "are of grown kinds with a seed only");
        }
        self.texel.fault()
    }
}

/// How copies of the texels of a skin differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct VarietyEntry {
    /// Whether copies are turned by quarter turns.
    pub turns: bool,
    /// Whether copies are mirrored.
    pub mirrors: bool,
    /// By which part of its height a copy is lower at most.
    pub height: f32,
    /// By which part the tone of a copy is off at most.
    pub color: f32,
    /// Which of many choices.
    pub seed: u32,
}

/// One texel, or a list of them.
pub(super) fn one_or_more<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<ShareEntry>, D::Error> {
    struct OneOrMore;
    impl<'de> Visitor<'de> for OneOrMore {
        type Value = Vec<ShareEntry>;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("a table of one kind, as in `texel.fur = {}`, or a list of them")
        }

        fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<Vec<ShareEntry>, A::Error> {
            OneShare.visit_map(table).map(|share| vec![share])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<ShareEntry>, A::Error> {
            let mut shares = Vec::new();
            while let Some(share) = list.next_element()? {
                shares.push(share);
            }
            Ok(shares)
        }
    }
    deserializer.deserialize_any(OneOrMore)
}

impl<'de> Deserialize<'de> for ShareEntry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(OneShare)
    }
}

struct OneShare;

impl<'de> Visitor<'de> for OneShare {
    type Value = ShareEntry;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a table of one kind, as in `texel.fur = {}`")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<ShareEntry, A::Error> {
        const ONE: &str = "a texel is of one kind, as in `texel.fur = {}`";
        let keys = || {
            let kinds = Kind::PRESETS.iter().map(|preset| preset.kind);
            kinds.chain(["file", "weight", "variants"]).collect()
        };
        let (mut texel, mut weight, mut variants) = (None, None, None);
        while let Some(key) = table.next_key_seed(OneOf("texel", keys()))? {
            let again = match key.as_str() {
                "weight" => weight.replace(table.next_value()?).is_some(),
                "variants" => variants.replace(table.next_value()?).is_some(),
                _ if texel.is_some() => return Err(A::Error::custom(ONE)),
                kind => texel.replace(TexelEntry::of_kind(kind, &mut table)?).is_some(),
            };
            if again {
                return Err(A::Error::custom(format!("`{key}` is there twice")));
            }
        }
        let texel = texel.ok_or_else(|| A::Error::custom(ONE))?;
        Ok(ShareEntry { texel, weight: weight.unwrap_or(1.0), variants: variants.unwrap_or(1) })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use pelage_texel::{Fur, Grass, Hypertexture, Sheet};

    use super::super::{SceneFile, Source};
    use super::*;

    #[derive(Deserialize)]
    struct Holder {
        #[serde(deserialize_with = "one_or_more")]
        texel: Vec<ShareEntry>,
    }

    fn parse(text: &str) -> Result<Vec<ShareEntry>, String> {
        let source = Source::parse(text, Path::new("s.toml")).expect("TOML");
        source.read::<Holder>().map(|h| h.texel).map_err(|e| e.to_string())
    }

    #[test]
    fn one_texel_or_a_list_of_them() {
        let grass = ShareEntry { weight: 3.0, variants: 2, ..TexelEntry::from(Grass::meadow()).into() };
        assert_eq!(parse("texel.grass = {}\ntexel.variants = 2\ntexel.weight = 3"), Ok(vec![grass.clone()]));
        let list = "texel = [{ weight = 3, grass = {}, variants = 2 }, { file = 'a.texel' }]";
        assert_eq!(parse(list), Ok(vec![grass, TexelEntry::File("a.texel".into()).into()]));
        for (text, message) in [
            ("texel = [{ weight = 1 }]", "a texel is of one kind"),
            ("texel = [{ fur = {}, grass = {} }]", "a texel is of one kind"),
            ("texel = [{ fur = {}, wieght = 1 }]", "`wieght`"),
            ("texel = [{ fur = {}, variants = 1.5 }]", "1.5"),
            ("texel = 3", "a table of one kind, as in `texel.fur = {}`, or a list of them"),
        ] {
            let error = parse(text).expect_err(text);
            assert!(error.contains(message), "{text}: {error}");
        }
    }

    #[test]
    fn variants_follow_each_other_and_share_the_weight() {
        let variant = |variant: u32| TexelEntry::from(Fur { variant, ..Fur::plush() });
        let share = ShareEntry { weight: 3.0, variants: 3, ..variant(5).into() };
        assert_eq!(share.texels().collect::<Vec<_>>(), [5, 6, 7].map(|n| (variant(n), 1.0)));
        let seed = |seed: u64| TexelEntry::from(Hypertexture { seed, ..Hypertexture::calm() });
        let share = ShareEntry { variants: 2, ..seed(5).into() };
        assert_eq!(share.texels().map(|(texel, _)| texel).collect::<Vec<_>>(), [5, 6].map(seed));
        let file = ShareEntry { variants: 2, ..TexelEntry::File("a.texel".into()).into() };
        let sheet = ShareEntry { variants: 2, ..TexelEntry::from(Sheet::tilted()).into() };
        for alike in [file, sheet] {
            assert_eq!(alike.fault().map(|(field, _)| field), Some("variants".into()));
        }
    }

    #[test]
    fn what_cannot_be_is_named() {
        let scene = |skin: &str| {
            let text = format!("geometry = [{{ file = 'a.obj' }}]\n[[skin]]\n{skin}\n");
            SceneFile::parse(&text, Path::new("s.toml")).map_err(|error| error.to_string())
        };
        let entry =
            scene("texel = [{ fur = {} }]\nvariety = { turns = true, height = 0.25 }").expect("a scene");
        let expected = VarietyEntry { turns: true, height: 0.25, ..VarietyEntry::default() };
        assert_eq!(entry.skin[0].variety, expected);
        for (skin, message) in [
            ("texel = []", "skin[0].texel: needs one texel at least"),
            (
                "texel = [{ fur = {}, weight = 0 }]",
                "skin[0].texel: needs one texel at least whose weight is not 0",
            ),
            (
                "texel = [{ fur = {} }, { fur = {}, weight = -1 }]",
                "skin[0].texel[1].weight: must be from 0 to 1e12",
            ),
            ("texel = [{ fur = {} }, { fur = { count = 0 } }]", "skin[0].texel[1].fur.count"),
            ("texel.fur = {}\ntexel.variants = 65", "skin[0].texel.variants: must be from 1 to 64"),
            ("variety = { height = 1 }", "skin[0].variety.height: must be from 0 to 0.9"),
            ("variety = { color = nan }", "skin[0].variety.color: must be from 0 to 1"),
            ("variety = { turn = true }", "`turn`"),
        ] {
            let error = scene(skin).expect_err(skin);
            assert!(error.contains(message) && !error.contains('\n'), "{skin}: {error}");
        }
    }
}
