//! Triangles that cannot be queried, and exact duplicates: found (zero area by exact signs, duplicates by a hash of the
//! corners), counted and listed, never dropped silently.

use rayon::prelude::*;

use crate::constants::{DEFECT_IDS_KEPT, LARGEST_COORDINATE, SMALL_MESH};
use crate::error::Result;
use crate::geometry::bounds::{Point, Triangle};
use crate::geometry::predicates::is_collinear;
use crate::saved::{check, damaged, Reader, Sections};

/// The defects of a triangle. A triangle is counted under the first that applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
#[non_exhaustive]
pub enum DefectKind {
    /// A vertex index past the last vertex. Not queried.
    IndexOutOfRange = 0,
    /// A corner with NaN or an infinity. Not queried.
    NonFinite = 1,
    /// A corner with a coordinate beyond 1e100 m. Not queried.
    TooLarge = 2,
    /// Corners exactly on one line. Not queried.
    ZeroArea = 3,
    /// The same three corners as an earlier triangle, in any order. Queried like any other.
    Duplicate = 4,
}

impl DefectKind {
    /// All kinds, in the order they are reported.
    pub const ALL: &'static [DefectKind] = &[
        DefectKind::IndexOutOfRange,
        DefectKind::NonFinite,
        DefectKind::TooLarge,
        DefectKind::ZeroArea,
        DefectKind::Duplicate,
    ];

    /// The name used in reports.
    pub fn name(self) -> &'static str {
        match self {
            DefectKind::IndexOutOfRange => "index_out_of_range",
            DefectKind::NonFinite => "non_finite",
            DefectKind::TooLarge => "too_large",
            DefectKind::ZeroArea => "zero_area",
            DefectKind::Duplicate => "duplicate",
        }
    }
}

/// How many triangles have one kind of defect, and which come first.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Defect {
    /// Triangles with this defect.
    pub count: usize,
    /// The first ids, sorted, at most 100.
    pub first: Vec<u32>,
}

/// The defects of a mesh.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Defects {
    /// One entry per [`DefectKind`], in its order.
    by_kind: [Defect; DefectKind::ALL.len()],
    /// Ids of all triangles that are not queried, sorted.
    pub excluded: Vec<u32>,
}

impl Defects {
    /// The triangles with one kind of defect.
    pub fn of(&self, kind: DefectKind) -> &Defect {
        &self.by_kind[kind as usize]
    }

    /// Looks at every triangle.
    pub(crate) fn find(vertices: &[Point], faces: &[[u32; 3]]) -> Defects {
        let defect = |(id, face): (usize, &[u32; 3])| defect_of(vertices, face).map(|kind| (id as u32, kind));
        let mut bad: Vec<(u32, DefectKind)> = if faces.len() < SMALL_MESH {
            faces.iter().enumerate().filter_map(defect).collect()
        } else {
            faces.par_iter().enumerate().filter_map(defect).collect()
        };
        bad.sort_unstable();
        Defects::of_bad(vertices, faces, bad)
    }

    /// Those of a mesh whose triangles that are not queried (sorted) are known: of parts that moved, these that had no area where they
    /// are modelled.
    pub(crate) fn find_beside(vertices: &[Point], faces: &[[u32; 3]], excluded: &[u32]) -> Defects {
        let kind = |id: &u32| defect_of(vertices, &faces[*id as usize]).unwrap_or(DefectKind::ZeroArea);
        Defects::of_bad(vertices, faces, excluded.iter().map(|id| (*id, kind(id))).collect())
    }

    /// `bad`: the triangles that are not queried, sorted.
    fn of_bad(vertices: &[Point], faces: &[[u32; 3]], bad: Vec<(u32, DefectKind)>) -> Defects {
        let mut defects = Defects { excluded: bad.iter().map(|(id, _)| *id).collect(), ..Defects::default() };
        for (id, kind) in bad {
            defects.by_kind[kind as usize].add(id);
        }
        for id in duplicates(vertices, faces, &defects.excluded) {
            defects.by_kind[DefectKind::Duplicate as usize].add(id);
        }
        defects
    }

    /// Adds them to the sections of a saved scene.
    pub(crate) fn save<'a>(&'a self, sections: &mut Sections<'a>) {
        sections.add("mesh.excluded", &self.excluded);
        let counts: Vec<[u64; 2]> = self.by_kind.iter().map(|d| [d.count as u64, d.first.len() as u64]).collect();
        sections.add_made("mesh.defect_counts", &counts);
        let first: Vec<u32> = self.by_kind.iter().flat_map(|d| d.first.iter().copied()).collect();
        sections.add_made("mesh.defects", &first);
    }

    /// From the sections of a saved scene of so many triangles.
    pub(crate) fn of_saved(saved: Reader<'_>, triangles: usize) -> Result<Defects> {
        let mut defects = Defects { excluded: saved.column("mesh.excluded")?.to_vec(), ..Defects::default() };
        let is_right =
            |ids: &[u32]| ids.is_sorted_by(|a, b| a < b) && ids.last().is_none_or(|t| (*t as usize) < triangles);
        check(is_right(&defects.excluded) && defects.excluded.len() < triangles, || "mesh.excluded".into())?;
        let counts = saved.column_of::<[u64; 2]>("mesh.defect_counts", DefectKind::ALL.len())?;
        let first = saved.column::<u32>("mesh.defects")?;
        let mut rest = &first[..];
        for (defect, [count, kept]) in defects.by_kind.iter_mut().zip(&counts) {
            let own = usize::try_from(*kept).ok().and_then(|kept| rest.split_at_checked(kept));
            let (own, others) = own.ok_or_else(|| damaged("mesh.defects ends too early"))?;
            check(kept <= count && *count <= triangles as u64 && is_right(own), || "mesh.defects".into())?;
            *defect = Defect { count: *count as usize, first: own.to_vec() };
            rest = others;
        }
        Ok(defects)
    }

    /// The counts in words, for messages.
    pub(crate) fn summary(&self) -> String {
        let words: Vec<String> = DefectKind::ALL
            .iter()
            .filter(|kind| self.by_kind[**kind as usize].count > 0)
            .map(|kind| format!("{} {}", self.by_kind[*kind as usize].count, kind.name()))
            .collect();
        if words.is_empty() {
            "no defects".into()
        } else {
            words.join(", ")
        }
    }
}

impl Defect {
    fn add(&mut self, id: u32) {
        self.count += 1;
        if self.first.len() < DEFECT_IDS_KEPT {
            self.first.push(id);
        }
    }
}

/// Whether a triangle cannot be queried.
pub(crate) fn is_defective(vertices: &[Point], face: &[u32; 3]) -> bool {
    defect_of(vertices, face).is_some()
}

fn defect_of(vertices: &[Point], face: &[u32; 3]) -> Option<DefectKind> {
    if face.iter().any(|i| *i as usize >= vertices.len()) {
        return Some(DefectKind::IndexOutOfRange);
    }
    let t = corners(vertices, face);
    let any = |bad: fn(f64) -> bool| t.iter().flatten().any(|x| bad(*x));
    if any(|x| !x.is_finite()) {
        return Some(DefectKind::NonFinite);
    }
    if any(|x| x.abs() > LARGEST_COORDINATE) {
        return Some(DefectKind::TooLarge);
    }
    is_collinear(&t[0], &t[1], &t[2]).then_some(DefectKind::ZeroArea)
}

/// The corners of a face whose indices are in range.
#[inline]
pub(crate) fn corners(vertices: &[Point], face: &[u32; 3]) -> Triangle {
    let [a, b, c] = *face;
    [vertices[a as usize], vertices[b as usize], vertices[c as usize]]
}

/// Ids of triangles with the same three corners as an earlier one, sorted. Compared by position, so that soups count too.
fn duplicates(vertices: &[Point], faces: &[[u32; 3]], excluded: &[u32]) -> Vec<u32> {
    let hashed = |(id, face): (usize, &[u32; 3])| {
        excluded.binary_search(&(id as u32)).is_err().then(|| {
            // A sum does not depend on the order of the corners.
            (corners(vertices, face).iter().fold(0u64, |h, p| h.wrapping_add(hash(p))), id as u32)
        })
    };
    let hashed: Vec<(u64, u32)> = if faces.len() < SMALL_MESH {
        let mut hashed: Vec<_> = faces.iter().enumerate().filter_map(hashed).collect();
        hashed.sort_unstable();
        hashed
    } else {
        let mut hashed: Vec<_> = faces.par_iter().enumerate().filter_map(hashed).collect();
        hashed.par_sort_unstable();
        hashed
    };
    let key = |id: u32| {
        let mut k = corners(vertices, &faces[id as usize]).map(|p| p.map(|x| (x + 0.0).to_bits()));
        k.sort_unstable();
        k
    };
    let mut found = Vec::new();
    for run in hashed.chunk_by(|a, b| a.0 == b.0).filter(|run| run.len() > 1) {
        let mut keys: Vec<_> = run.iter().map(|(_, id)| (key(*id), *id)).collect();
        keys.sort_unstable();
        found.extend(keys.windows(2).filter(|w| w[0].0 == w[1].0).map(|w| w[1].1));
    }
    found.sort_unstable();
    found
}

/// A hash of a position in which 0.0 and -0.0 are the same.
pub(crate) fn hash(p: &Point) -> u64 {
    p.iter().fold(0x9e37_79b9_7f4a_7c15, |h, x| {
        let mixed = (h ^ (x + 0.0).to_bits()).wrapping_mul(0xff51_afd7_ed55_8ccd);
        mixed ^ mixed >> 32
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_is_found_once() {
        let vertices = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [2.0, 0.0, 0.0],
            [f64::NAN, 0.0, 0.0],
            [1e101, 0.0, 0.0],
            [-0.0, 0.0, 0.0],
        ];
        let faces = [[0, 1, 2], [0, 1, 7], [0, 1, 4], [0, 2, 5], [0, 1, 3], [2, 6, 1], [0, 1, 1], [0, 4, 9]];
        let d = Defects::find(&vertices, &faces);
        let ids = |kind: DefectKind| d.by_kind[kind as usize].first.clone();
        assert_eq!(ids(DefectKind::IndexOutOfRange), [1, 7]);
        assert_eq!(ids(DefectKind::NonFinite), [2]);
        assert_eq!(ids(DefectKind::TooLarge), [3]);
        assert_eq!(ids(DefectKind::ZeroArea), [4, 6]);
        assert_eq!(ids(DefectKind::Duplicate), [5]);
        assert_eq!(d.excluded, [1, 2, 3, 4, 6, 7]);
    }

    #[test]
    fn thousands_of_copies_count_all_but_the_first() {
        let vertices = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let faces = vec![[0, 1, 2]; 5000];
        let d = Defects::find(&vertices, &faces);
        assert_eq!(d.by_kind[DefectKind::Duplicate as usize].count, 4999);
        assert_eq!(d.by_kind[DefectKind::Duplicate as usize].first.len(), DEFECT_IDS_KEPT);
    }
}
