use std::sync::OnceLock;

use proptest::prelude::*;

use super::*;
use crate::balance::NODES;
use crate::{Balance, BuildOptions, Fur, Grass, Hypertexture, Kind, build, build_exact};

/// A little grass, of levels 0 to 6: the last two compact. All but one are balanced, anyhow.
fn grass() -> &'static Texel {
    static GRASS: OnceLock<Texel> = OnceLock::new();
    GRASS.get_or_init(|| {
        let options = BuildOptions { depth: 6, ..BuildOptions::preview() };
        let grass = build("a few blades", Grass { count: 4, ..Grass::lawn() }, &options, &|_| ()).unwrap();
        let balance = |l: u8| Balance::from_nodes([0.01 * f32::from(l); NODES]);
        grass.balanced((0..7).map(|l| balance(l).filter(|_| l != 1)))
    })
}

/// The smallest fur.
fn fur() -> &'static Texel {
    static FUR: OnceLock<Texel> = OnceLock::new();
    FUR.get_or_init(|| {
        let options = BuildOptions { depth: 2, points: 16, ..BuildOptions::preview() };
        build("fur", Fur { count: 1, segments: 1, ..Fur::long() }, &options, &|_| ()).unwrap()
    })
}

fn written(texel: &Texel, options: &FileOptions) -> Vec<u8> {
    let mut bytes = Vec::new();
    texel.write(&mut bytes, options).unwrap();
    bytes
}

fn read(bytes: &[u8]) -> Result<TexelFile, FileError> {
    TexelFile::read(bytes, &Limits::default())
}

/// A file of these parts, its checksums right.
fn forged(parts: &[(PartKind, Vec<u8>)]) -> Vec<u8> {
    let mut header = Header::default();
    let mut body = Vec::new();
    for (kind, content) in parts {
        let bytes = zstd::bulk::compress(content, 3).unwrap();
        let (stored, unpacked) = (bytes.len() as u64, content.len() as u64);
        header.parts.push(Part { kind: *kind, stored, unpacked, checksum: crc32fast::hash(&bytes) });
        body.extend(bytes);
    }
    [header.encode(), body].concat()
}

/// The parts of a file and their contents.
fn parts_of(bytes: &[u8]) -> Vec<(PartKind, Vec<u8>)> {
    let mut input = bytes;
    let header = Header::read(&mut input, &Limits::default()).unwrap();
    header.parts.iter().map(|part| (part.kind, unpack(&mut input, part).unwrap())).collect()
}

#[test]
fn what_is_written_returns() {
    let metadata = Metadata {
        licence: "CC0-1.0".into(),
        origin: "grown by a test".into(),
        parameters: [("count".to_owned(), "4".to_owned())].into(),
    };
    let options = FileOptions { metadata, ..FileOptions::default() };
    let bytes = written(grass(), &options);
    assert_eq!(bytes, written(grass(), &options));
    let file = read(&bytes).unwrap();
    assert_eq!(&file.texel, grass());
    assert_eq!(file.metadata, options.metadata);
    assert_eq!(file.length, bytes.len() as u64);
    // Metadata, seven levels, the kind.
    assert_eq!(file.parts.len(), 9);
    assert!(matches!(file.texel.source(), Source::Grown(Kind::Grass(grass)) if grass.count == 4));
}

#[test]
fn parameters_that_came_later_are_as_in_the_first_preset() {
    let with_kind = |kind: &str| {
        let mut parts = parts_of(&written(grass(), &FileOptions::default()));
        parts.last_mut().unwrap().1 = kind.into();
        read(&forged(&parts))
    };
    let file = with_kind(r#"{"grass":{"count":4}}"#).unwrap();
    let expected = Grass { count: 4, ..Grass::default() };
    assert!(matches!(file.texel.source(), Source::Grown(Kind::Grass(grass)) if *grass == expected));
    // What a newer version has and this one cannot grow is named.
    let error = with_kind(r#"{"grass":{"count":4,"dew":1}}"#).unwrap_err().to_string();
    assert!(error.starts_with("the kind cannot be grown: unknown field `dew`"), "{error}");
}

#[test]
fn every_form_returns() {
    let triangles = grass().source().geometry().unwrap();
    let options = BuildOptions { depth: 5, ..BuildOptions::preview() };
    let measured = build_exact("exact", triangles.clone(), &options, &|_| ()).unwrap();
    let with_triangles = FileOptions { with_triangles: true, ..FileOptions::default() };
    assert_eq!(read(&written(&measured, &with_triangles)).unwrap().texel, measured);
    // Triangles stay behind unless they are asked for.
    let short = read(&written(&measured, &FileOptions::default())).unwrap().texel;
    assert_eq!(short, measured.clone().without_source());
    let density =
        build("density", Hypertexture::default(), &BuildOptions { depth: 4, ..options.clone() }, &|_| ());
    let density = density.unwrap();
    assert_eq!(read(&written(&density, &FileOptions::default())).unwrap().texel, density);
    let nothing = build("", crate::Geometry::default(), &options, &|_| ()).unwrap().without_source();
    assert_eq!(read(&written(&nothing, &FileOptions::default())).unwrap().texel, nothing);
}

#[test]
fn every_flipped_bit_is_found() {
    let bytes = written(fur(), &FileOptions::default());
    let header = 32 * (1 + 5);
    for at in 0..bytes.len() {
        let mut bad = bytes.clone();
        bad[at] ^= 1 << (at % 8);
        match read(&bad).unwrap_err() {
            FileError::Foreign => assert!(at < 8, "{at}"),
            // A header that is said to be longer is looked for further on.
            FileError::Damaged { part: None } | FileError::Truncated { part: None } => {
                assert!((8..header).contains(&at), "{at}");
            }
            FileError::Damaged { part: Some(_) } => assert!(at >= header, "{at}"),
            error => panic!("{at}: {error}"),
        }
    }
}

#[test]
fn every_early_end_is_found() {
    let bytes = written(fur(), &FileOptions::default());
    assert!(matches!(read(&[]), Err(FileError::Foreign)));
    for end in 1..bytes.len() {
        assert!(matches!(read(&bytes[..end]), Err(FileError::Truncated { .. })), "{end}");
    }
    let longer = [&bytes[..], &[0]].concat();
    assert!(matches!(read(&longer), Err(FileError::Trailing { length }) if length == bytes.len() as u64));
}

#[test]
fn other_versions_are_told_from_damaged_ones() {
    let mut bytes = written(fur(), &FileOptions::default());
    bytes[8] = 7;
    assert!(matches!(read(&bytes), Err(FileError::Damaged { part: None })));
    let mut of_version = |version: u8| {
        bytes[8] = version;
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&bytes[..24]);
        hasher.update(&bytes[28..32 * (1 + 5)]);
        bytes[24..28].copy_from_slice(&hasher.finalize().to_le_bytes());
        read(&bytes)
    };
    assert!(matches!(of_version(7), Err(FileError::Newer { version: 7, known: 6 })));
    assert!(matches!(of_version(4), Err(FileError::Older { version: 4, known: 6 })));
}

#[test]
fn large_claims_allocate_nothing() {
    let kinds = [PartKind::Metadata, PartKind::Level(0)];
    let part = |kind, unpacked| Part { kind, stored: 1 << 40, unpacked, checksum: 0 };
    let claim = |unpacked| Header { parts: kinds.map(|kind| part(kind, unpacked)).into() }.encode();
    for unpacked in [1 << 60, u64::MAX] {
        assert!(matches!(read(&claim(unpacked)), Err(FileError::TooLarge { size, .. }) if size >= 1 << 60));
    }
    // What is stored is believed when it is there.
    assert!(matches!(read(&claim(100)), Err(FileError::Truncated { part: Some(PartKind::Metadata) })));
    // 64 MiB of zeros in a few kilobytes: neither what they claim to be, nor what they are.
    let bomb = zstd::bulk::compress(&vec![0; 64 << 20], 3).unwrap();
    for unpacked in [64 << 20, 1000] {
        let parts = vec![Part {
            kind: PartKind::Metadata,
            stored: bomb.len() as u64,
            unpacked,
            checksum: crc32fast::hash(&bomb),
        }];
        let error = read(&[Header { parts }.encode(), bomb.clone()].concat()).unwrap_err();
        assert!(matches!(error, FileError::TooLarge { .. } | FileError::Malformed { .. }), "{error}");
    }
    let deep = (0..40).map(|l| (PartKind::Level(l), vec![]));
    let deep: Vec<_> = [(PartKind::Metadata, vec![])].into_iter().chain(deep).collect();
    assert!(matches!(read(&forged(&deep)), Err(FileError::TooLarge { what: "the finest level", .. })));
}

#[test]
fn parts_out_of_order_are_refused() {
    let parts = parts_of(&written(fur(), &FileOptions::default()));
    assert!(read(&forged(&parts)).is_ok());
    let mut swapped = parts.clone();
    swapped.swap(1, 2);
    let twice = [&parts[..], &parts[4..]].concat();
    for bad in [&parts[1..], &parts[..1], &swapped, &twice, &[]] {
        assert!(
            matches!(read(&forged(bad)), Err(FileError::Header { .. } | FileError::Texel(_))),
            "{}",
            bad.len()
        );
    }
}

#[test]
fn errors_are_one_line() {
    let mut parts = parts_of(&written(fur(), &FileOptions::default()));
    parts[4].1 = br#"{"fur":{"seed":1,"wings":2}}"#.to_vec();
    let error = read(&forged(&parts)).unwrap_err().to_string();
    assert!(error.contains("wings") && !error.contains('\n'), "{error}");
    let mut unready = fur().clone();
    unready.specular = f32::NAN;
    let error = unready.write(&mut Vec::new(), &FileOptions::default()).unwrap_err();
    assert_eq!(error.to_string(), "specular is not in [0, 1]");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn what_is_no_texel_is_refused_and_nothing_panics(
        part in 0_usize..9,
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        static PARTS: OnceLock<Vec<(PartKind, Vec<u8>)>> = OnceLock::new();
        let mut parts = PARTS.get_or_init(|| parts_of(&written(grass(), &FileOptions::default()))).clone();
        let content = &mut parts[part].1;
        for (at, byte) in edits {
            // Half of them where the counts are.
            let len = if byte % 2 == 0 { content.len() } else { content.len().min(40) };
            let at = at.index(len);
            content[at] = byte;
        }
        if let Some(cut) = cut {
            let end = cut.index(content.len());
            content.truncate(end);
        }
        // Whatever is let in is sound.
        if let Ok(file) = read(&forged(&parts)) {
            prop_assert_eq!(file.texel.validate(), Ok(()));
            for level in file.texel.levels() {
                let surfels: usize = (0..level.len() as u32).map(|voxel| level.surfels(voxel).count()).sum();
                prop_assert!(surfels < 1 << 20);
            }
        }
    }

    #[test]
    fn noise_is_no_texel(bytes in prop::collection::vec(any::<u8>(), 0..300), magic in any::<bool>()) {
        let bytes = if magic { [&b"\x89TEXEL\r\n"[..], &bytes].concat() } else { bytes };
        prop_assert!(read(&bytes).is_err());
    }
}
