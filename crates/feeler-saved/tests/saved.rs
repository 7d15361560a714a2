//! Saved scenes: the same answers, and an error for every file that is not whole.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};
use std::sync::Arc;

use feeler_core::{Mockup, Pose, Progress, Scene, SceneOptions, Storage, Tool};
use feeler_saved::{open, save, Error, OpenOptions, LAYOUT};
use feeler_shapes::random::Random;
use feeler_shapes::{ball, box_mesh, cylinder, joined, soups};

/// A folder that is removed again.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Folder {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name = format!("feeler-saved-{}-{}", std::process::id(), COUNT.fetch_add(1, Relaxed));
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).unwrap();
        Folder(path)
    }

    fn names(&self) -> Vec<String> {
        let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
        let mut names: Vec<String> = fs::read_dir(&self.0).unwrap().map(name).collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn plain() -> OpenOptions<'static> {
    OpenOptions::default()
}

/// Closed and open parts, loose triangles, defects and a doubled triangle.
fn mockup() -> Mockup {
    let parts =
        [box_mesh([0.0; 3], [1.0, 1.0, 0.2], 3), ball(0.3, 12), cylinder(0.1, 1.5, 20, 3), soups::soup(5, 200, 0.3)];
    let of_face = parts.iter().zip(0u32..).flat_map(|((_, faces), part)| vec![part; faces.len()]).collect::<Vec<_>>();
    let (vertices, mut faces) = joined(parts);
    let mut of_face = of_face;
    faces.extend([[0, 0, 1], [0, 1, u32::MAX], faces[0]]);
    of_face.extend([0, 1, 2]);
    Mockup::new(vertices, faces, of_face, 5).unwrap()
}

fn scene(storage: Storage) -> Scene {
    Scene::build(Arc::new(mockup()), &SceneOptions::default().with_storage(storage).with_voxel_size(0.05)).unwrap()
}

fn tool() -> Tool {
    let (vertices, faces) = ball(0.2, 8);
    Tool::new(vertices, faces).unwrap()
}

fn poses() -> Vec<Pose> {
    let mut random = Random::new(3);
    (0..40).map(|_| Pose::new(&random.motion(0.6)).unwrap()).collect()
}

/// Queries of all kinds; those that need the connectivity, too.
fn answers(scene: &Scene) -> Vec<String> {
    let tool = tool();
    let of_pose = |pose: &Pose| {
        let (hit, gap) = (scene.collide(&tool, pose), scene.distance(&tool, pose, f64::INFINITY).unwrap());
        let near = scene.near_pairs(&tool, pose, 0.05).unwrap();
        format!("{:?} {:?} {gap:?} {near:?} {}", hit.pairs, hit.kinds, scene.is_entering(&tool, pose))
    };
    poses().iter().map(of_pose).collect()
}

#[test]
fn an_opened_scene_answers_as_the_one_that_was_saved() {
    let folder = Folder::new();
    let tables = [Storage::Blocks, Storage::Dense, Storage::Hashed { level: 0.3 }];
    for storage in tables {
        let (path, made) = (folder.0.join("scene.feeler"), scene(storage));
        let hash = save(&path, &made, &[("names", b"four parts"), ("empty", b"")], Progress::default()).unwrap();
        for verify in [true, false] {
            let saved = open(&path, &plain().with_verify(verify)).unwrap();
            assert_eq!((saved.content_hash, saved.extra("names")), (hash, Some(&b"four parts"[..])));
            assert_eq!((saved.extra("empty"), saved.extra("other")), (Some(&b""[..]), None));
            let opened = &saved.scene;
            assert_eq!((opened.storage(), opened.voxel_size()), (storage, made.voxel_size()));
            assert!(opened.mockup().has_adjacency(), "no query finds it again");
            opened.validate().unwrap();
            let (one, other) = (opened.mockup(), made.mockup());
            assert_eq!(one.mesh().defects(), other.mesh().defects());
            assert_eq!(one.mesh().defects().excluded.len(), 2);
            assert_eq!((one.part_bounds(), one.part_triangles()), (other.part_bounds(), other.part_triangles()));
            assert_eq!((one.mesh().vertices(), one.mesh().faces()), (other.mesh().vertices(), other.mesh().faces()));
            assert_eq!(answers(opened), answers(&made));
        }
    }
}

#[test]
fn the_hash_is_that_of_the_mock_up() {
    let folder = Folder::new();
    let path = folder.0.join("scene.feeler");
    let hash_of = |scene: &Scene| save(&path, scene, &[], Progress::default()).unwrap();
    let first = hash_of(&scene(Storage::Blocks));
    assert_eq!(first, hash_of(&scene(Storage::Dense)));
    let other =
        Mockup::new(mockup().mesh().vertices().to_vec(), mockup().mesh().faces().to_vec(), Vec::new(), 1).unwrap();
    assert_ne!(first, hash_of(&Scene::build(Arc::new(other), &SceneOptions::default()).unwrap()));
}

/// Elsewhere a zero may have another sign.
#[cfg(target_arch = "x86_64")]
#[test]
fn the_bytes_of_a_layout_do_not_change() {
    let mut hash = feeler_shapes::golden::Hash::NEW;
    for section in scene(Storage::Blocks).sections().0 {
        section.name.bytes().chain(section.bytes.iter().copied()).for_each(|byte| hash.add(byte.into()));
    }
    // Another value: raise `LAYOUT` in the core, so that older files are refused, and keep the value under the new number.
    hash.assert_golden(&format!("saved_layout_{LAYOUT}"));
}

#[test]
fn parts_that_are_out_stay_out() {
    let folder = Folder::new();
    let (path, made) = (folder.0.join("scene.feeler"), scene(Storage::Blocks).without(&[1, 3]).unwrap());
    save(&path, &made, &[], Progress::default()).unwrap();
    let saved = open(&path, &plain()).unwrap();
    assert_eq!([0, 1, 2, 3, 4].map(|part| saved.scene.has_part(part)), [true, false, true, false, true]);
    assert_eq!(answers(&saved.scene), answers(&made));
    assert_ne!(answers(&saved.scene), answers(&scene(Storage::Blocks)));
}

#[test]
fn a_file_that_ends_anywhere_else_is_refused() {
    let folder = Folder::new();
    let path = folder.0.join("scene.feeler");
    save(&path, &scene(Storage::Blocks), &[], Progress::default()).unwrap();
    let bytes = fs::read(&path).unwrap();
    let cut = folder.0.join("cut.feeler");
    let lengths = [0, 1, 7, 8, 9, 20, 63, 64, 1000, 65_535, 65_536, 65_537, bytes.len() - 65_536, bytes.len() - 1];
    for verify in [true, false] {
        for length in lengths {
            fs::write(&cut, &bytes[..length]).unwrap();
            let error = open(&cut, &plain().with_verify(verify)).unwrap_err();
            let is_right =
                if length < 8 { matches!(error, Error::NotSaved) } else { matches!(error, Error::Length { .. }) };
            assert!(is_right, "{length}: {error}");
        }
        fs::write(&cut, [&bytes[..], b"more"].concat()).unwrap();
        assert!(matches!(open(&cut, &plain().with_verify(verify)), Err(Error::Length { .. })));
    }
    fs::write(&cut, "solid a text\n").unwrap();
    assert!(matches!(open(&cut, &plain()), Err(Error::NotSaved)));
    assert!(matches!(open(&folder.0, &plain()), Err(Error::NotSaved | Error::Io(_))));
    assert!(matches!(open(folder.0.join("none"), &plain()), Err(Error::Io(_))));
}

#[test]
fn flipped_bits_are_found_and_another_layout_is_named() {
    let folder = Folder::new();
    let path = folder.0.join("scene.feeler");
    save(&path, &scene(Storage::Blocks), &[("names", b"x")], Progress::default()).unwrap();
    let (bytes, expected) = (fs::read(&path).unwrap(), answers(&scene(Storage::Blocks)));
    let flipped = folder.0.join("flipped.feeler");
    let mut random = Random::new(11);
    let (mut found, mut harmless) = (0, 0);
    for _ in 0..150 {
        let mut other = bytes.clone();
        let at = random.below(bytes.len() as u64) as usize;
        other[at] ^= 1 << random.below(8);
        fs::write(&flipped, &other).unwrap();
        match open(&flipped, &plain()) {
            Err(error) => {
                let known = matches!(
                    error,
                    Error::Damaged { .. } | Error::NotSaved | Error::Layout { .. } | Error::Length { .. }
                );
                assert!(known, "{error}");
                found += 1;
            }
            // Between sections nothing is kept.
            Ok(saved) => {
                assert_eq!(answers(&saved.scene), expected, "{at}");
                harmless += 1;
            }
        }
    }
    assert!(found > 10 && harmless > 10, "{found} {harmless}");
    for at in 0..65_536 {
        let mut other = bytes[..65_536].to_vec();
        other[at] ^= 0x10;
        if at % 997 == 0 || at < 128 {
            other.extend(&bytes[65_536..]);
            fs::write(&flipped, &other).unwrap();
            assert!(open(&flipped, &plain().with_verify(false)).is_err(), "{at}");
        }
    }
    let mut other = bytes;
    other[8..12].copy_from_slice(&(LAYOUT + 1).to_le_bytes());
    fs::write(&flipped, &other).unwrap();
    let error = open(&flipped, &plain()).unwrap_err();
    assert!(matches!(error, Error::Layout { found, .. } if found == LAYOUT + 1), "{error}");
    assert!(error.to_string().contains("save the scene again"), "{error}");
}

#[test]
fn a_save_that_ends_early_leaves_the_old_file() {
    let folder = Folder::new();
    let path = folder.0.join("scene.feeler");
    save(&path, &scene(Storage::Blocks), &[], Progress::default()).unwrap();
    let before = fs::read(&path).unwrap();
    let other = scene(Storage::Dense);
    for stage in ["finding the connectivity", "computing checksums", "writing"] {
        let stop = |_: f64, at: &str| at != stage;
        let error = save(&path, &other, &[], Progress::new(&stop)).unwrap_err();
        assert!(matches!(error, Error::Core(feeler_core::Error::Cancelled)), "{error}");
        assert_eq!(folder.names(), ["scene.feeler"]);
    }
    assert!(matches!(save(&path, &other, &[("a", b""), ("a", b"")], Progress::default()), Err(Error::Section { .. })));
    let long = "a".repeat(33);
    assert!(matches!(save(&path, &other, &[(&long, b"")], Progress::default()), Err(Error::Section { .. })));
    assert!(matches!(save(&folder.0, &other, &[], Progress::default()), Err(Error::Io(_))));
    assert!(matches!(save(Path::new("/"), &other, &[], Progress::default()), Err(Error::Io(_))));
    assert!(matches!(save(folder.0.join("no/scene"), &other, &[], Progress::default()), Err(Error::Io(_))));
    assert_eq!((fs::read(&path).unwrap(), folder.names()), (before, vec!["scene.feeler".to_owned()]));
}

#[cfg(unix)]
#[test]
fn devices_are_refused_and_links_followed() {
    let folder = Folder::new();
    let made = scene(Storage::Blocks);
    assert!(matches!(save(Path::new("/dev/null"), &made, &[], Progress::default()), Err(Error::Io(_))));
    assert!(matches!(open("/dev/null", &plain()), Err(Error::NotSaved)));
    let (path, link) = (folder.0.join("scene.feeler"), folder.0.join("link.feeler"));
    fs::write(&path, "old").unwrap();
    std::os::unix::fs::symlink(&path, &link).unwrap();
    save(&link, &made, &[], Progress::default()).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(answers(&open(&path, &plain()).unwrap().scene), answers(&made));
}

#[test]
fn a_replaced_file_leaves_opened_scenes_as_they_are() {
    let folder = Folder::new();
    let path = folder.0.join("scene.feeler");
    save(&path, &scene(Storage::Blocks), &[], Progress::default()).unwrap();
    let saved = open(&path, &plain()).unwrap();
    let (vertices, faces) = ball(0.3, 12);
    let other = Mockup::new(vertices, faces, Vec::new(), 1).unwrap();
    let other = Scene::build(Arc::new(other), &SceneOptions::default()).unwrap();
    save(&path, &other, &[], Progress::default()).unwrap();
    assert_eq!(answers(&saved.scene), answers(&scene(Storage::Blocks)));
    assert_eq!(answers(&open(&path, &plain()).unwrap().scene), answers(&other));
}
