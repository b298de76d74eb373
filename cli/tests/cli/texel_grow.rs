//! `pelage texel kinds` and `pelage texel grow` from outside.

use std::fs;
use std::path::Path;

use pelage::texel::{Grass, Source};
use pelage::texel_file::read_texel;

use super::folder::Folder;

#[test]
fn kinds_are_listed_and_described() {
    let folder = Folder::new();
    let list = folder.told("texel kinds");
    for line in
        ["fur          long, short,", "moss         cushion, star\n", "pile         cut, loops, shag\n"]
    {
        assert!(list.contains(line), "{list}");
    }
    let plush = folder.told("texel kinds fur:plush");
    for line in [
        "  plush    dense, even and matt, like velvet or a soft toy\n",
        "  long     soft, in loose locks (the default)\n",
        "  count = 1600\n      Strands in a copy, undercoat included. From 1 to 1000000 strands.\n",
        "  seed = 1\n      Which of the many furs with these settings. Any whole number.\n",
    ] {
        assert!(plush.contains(line), "{plush}");
    }
    folder.fails("texel kinds gras", 2, "there is no texel `gras`: did you mean `grass`?");
    folder.fails("texel kinds moss:stars", 2, "there is no preset of moss `stars`: did you mean `star`?");
}

/// The page is the program's own; this says how it is made again.
#[test]
fn the_page_of_kinds_is_up_to_date() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/kinds.md");
    let told = Folder::new().told("texel kinds --markdown");
    let page = fs::read_to_string(page).expect("docs/kinds.md");
    assert!(page == told, "run: pelage texel kinds --markdown > docs/kinds.md");
}

#[test]
fn what_grows_is_kept_with_its_parameters() {
    let folder = Folder::new();
    let settings = "--preset lawn --seed 7 --set count=20 --set dry_color=0.6,0.5,0.2 --set bend=0";
    folder.told(&format!("texel grow grass -o turf.texel --resolution 8 -q {settings}"));
    let file = read_texel(&folder.path("turf.texel")).expect("a texel file");
    let grass = Grass { seed: 7, count: 20, dry_color: [0.6, 0.5, 0.2].into(), bend: 0.0, ..Grass::lawn() };
    assert_eq!(file.texel.source(), &Source::Grown(grass.into()));
    assert_eq!((file.texel.name.as_str(), file.texel.levels().len()), ("turf", 4));
    assert_eq!(file.metadata.origin, "grass");
    assert_eq!(file.metadata.parameters["dry_color"], "[0.6, 0.5, 0.2]");
}

#[test]
fn slips_are_named() {
    let folder = Folder::new();
    for (line, message) in [
        ("gras -o a.texel", "there is no texel `gras`: did you mean `grass`?"),
        ("fur -o a.texel --preset lung", "there is no preset of fur `lung`: did you mean `long`?"),
        ("fur -o a.texel --set clmp=1", "there is no field of fur `clmp`: did you mean `clump`?"),
        ("fur -o a.texel --set clump=1.5", "fur.clump is 1.5, which is not in 0 to 1"),
        ("fur -o a.texel --set clump=much", "clump: `much` is no number"),
        ("fur -o a.texel --set count=1e3", "count: "),
        ("fur -o a.texel --set count", "expected KEY=VALUE, as in count=300"),
        ("fur -o a.texel --set tip_color=1,1", "tip_color: "),
        ("fur -o a.texel --set seed=1 --seed 2", "fur.seed is set twice"),
        ("fur -o a.texel --seed -1", "seed: "),
        ("fur -o a.texel --resolution 100", "fur.resolution must be a power of two from 2 to 512"),
        ("fur -o a.texel --set count=1000000 --set segments=32", "192000000 triangles would grow"),
        ("fur -o a.png", "a.png: has an unknown extension: expected .texel"),
    ] {
        folder.fails(&format!("texel grow {line}"), 2, message);
    }
    folder.fails("texel grow fur -o none/a.texel", 3, "none");
}
