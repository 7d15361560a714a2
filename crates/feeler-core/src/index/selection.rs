//! The selection of a query: the present parts of the mock-up, and the pairs of parts that are not ignored.
//!
//! Both are laid over one index, which does not change. Nodes without present parts are skipped, and each offered
//! triangle is checked: one bit per triangle, and one per node.

use std::sync::Arc;

use crate::mesh::mockup::Mockup;
use crate::tool::moving_tool::Tool;

/// A selection as queries carry it.
#[derive(Debug, Clone, Default)]
pub struct Selection {
    presence: Option<Arc<Presence>>,
    ignored: Option<Arc<IgnoredPairs>>,
    /// Of all parts one alone.
    only: Option<OnlyPart>,
}

/// One part of a mock-up: costs nothing to choose, where a bit a triangle takes as long as reading all of them.
#[derive(Debug, Clone)]
struct OnlyPart {
    part: u32,
    mockup: Arc<Mockup>,
}

/// Which parts of a mock-up are there.
#[derive(Debug)]
pub struct Presence {
    /// By part.
    parts: Vec<bool>,
    /// A bit a triangle: whether its part is there.
    triangles: Vec<u64>,
    /// For each level of nodes a word a node: which of its children have anything below them that is there. Empty for the blocks
    /// themselves, and for stores without nodes.
    children: Vec<Vec<u32>>,
}

/// Pairs of tool part and mock-up part that queries ignore, like a robot's allowed collision matrix; also pairs of their surfaces.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct IgnoredPairs {
    of_parts: Matrix,
    /// By part of the mock-up: whether it is ignored with all parts of the tool.
    whole: Vec<bool>,
    of_surfaces: Option<IgnoredSurfaces>,
}

/// The surface number of some triangles of a mesh.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SurfaceNumbers {
    /// A bit a triangle: whether it has a number.
    has: Vec<u64>,
    /// Sorted by triangle.
    numbers: Vec<(u32, u32)>,
    count: usize,
}

/// Pairs of surfaces that are not asked.
#[derive(Debug, Clone, PartialEq, Eq)]
struct IgnoredSurfaces {
    tool: Arc<SurfaceNumbers>,
    mockup: Arc<SurfaceNumbers>,
    pairs: Matrix,
}

/// A bit a pair.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Matrix {
    size: [usize; 2],
    bits: Vec<u64>,
}

impl Matrix {
    fn new(size: [usize; 2], pairs: impl IntoIterator<Item = [u32; 2]>) -> Matrix {
        let mut bits = vec![0; (size[0] * size[1]).div_ceil(64)];
        for [t, m] in pairs.into_iter().map(|pair| pair.map(|number| number as usize)) {
            if t < size[0] && m < size[1] {
                let at = t * size[1] + m;
                bits[at / 64] |= 1 << (at % 64);
            }
        }
        Matrix { size, bits }
    }

    #[inline]
    fn contains(&self, t: u32, m: u32) -> bool {
        let (t, m) = (t as usize, m as usize);
        let at = t * self.size[1] + m;
        t < self.size[0] && m < self.size[1] && self.bits[at / 64] >> (at % 64) & 1 == 1
    }
}

impl SurfaceNumbers {
    /// `triangles`: how many the mesh has. `numbers`: `(triangle, surface)`, sorted by triangle.
    pub fn new(triangles: usize, numbers: Vec<(u32, u32)>) -> SurfaceNumbers {
        let mut has = vec![0; triangles.div_ceil(64)];
        numbers.iter().for_each(|(t, _)| has[*t as usize / 64] |= 1 << (t % 64));
        let count = numbers.iter().map(|(_, surface)| *surface as usize + 1).max().unwrap_or(0);
        SurfaceNumbers { has, numbers, count }
    }

    /// The surface of a triangle; `None` if it has no number.
    #[inline]
    pub fn of(&self, triangle: u32) -> Option<u32> {
        if !is_set(&self.has, triangle) {
            return None;
        }
        self.numbers.binary_search_by_key(&triangle, |(t, _)| *t).ok().map(|at| self.numbers[at].1)
    }

    /// Each triangle that has a number, ascending, and its number.
    pub fn all(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.numbers.iter().copied()
    }

    /// One more than the largest number.
    pub fn count(&self) -> usize {
        self.count
    }
}

impl IgnoredPairs {
    /// Ignores the pairs `[tool part, mock-up part]`. `tool_parts`, `parts`: how many there are; larger numbers in pairs are dropped.
    pub fn new(tool_parts: usize, parts: usize, pairs: impl IntoIterator<Item = [u32; 2]>) -> IgnoredPairs {
        let of_parts = Matrix::new([tool_parts, parts], pairs);
        let is_whole = |part: u32| (0..tool_parts as u32).all(|tool_part| of_parts.contains(tool_part, part));
        let whole = (0..parts as u32).map(is_whole).collect();
        IgnoredPairs { of_parts, whole, of_surfaces: None }
    }

    /// Also ignores pairs `[tool surface, mock-up surface]`, by the surface numbers of tool and mock-up.
    pub fn with_surfaces(
        self,
        [tool, mockup]: [&Arc<SurfaceNumbers>; 2],
        pairs: impl IntoIterator<Item = [u32; 2]>,
    ) -> IgnoredPairs {
        let pairs = Matrix::new([tool.count, mockup.count], pairs);
        let of_surfaces = Some(IgnoredSurfaces { tool: tool.clone(), mockup: mockup.clone(), pairs });
        IgnoredPairs { of_surfaces, ..self }
    }

    /// Whether a pair of parts is ignored, all of it.
    #[inline]
    pub fn contains(&self, tool_part: u32, part: u32) -> bool {
        self.of_parts.contains(tool_part, part)
    }

    /// Whether a pair of triangles is ignored by their surfaces.
    #[inline]
    fn contains_surfaces(&self, tool_triangle: u32, triangle: u32) -> bool {
        let Some(ignored) = &self.of_surfaces else { return false };
        let Some(m) = ignored.mockup.of(triangle) else { return false };
        ignored.tool.of(tool_triangle).is_some_and(|t| ignored.pairs.contains(t, m))
    }
}

impl Presence {
    fn new(mockup: &Mockup, parts: Vec<bool>, children: impl FnOnce(TrianglesThere<'_>) -> Vec<Vec<u32>>) -> Presence {
        let triangles: Vec<u64> = mockup
            .parts_of_faces()
            .chunks(64)
            .map(|chunk| chunk.iter().rev().fold(0, |bits, part| bits << 1 | u64::from(parts[*part as usize])))
            .collect();
        // A mock-up of one part says nothing of its triangles.
        let triangles = if triangles.is_empty() {
            vec![if parts[0] { u64::MAX } else { 0 }; mockup.mesh().faces().len().div_ceil(64)]
        } else {
            triangles
        };
        let children = children(TrianglesThere(&triangles));
        Presence { parts, triangles, children }
    }

    /// All of a mock-up.
    fn all(mockup: &Mockup) -> Presence {
        let triangles = vec![u64::MAX; mockup.mesh().faces().len().div_ceil(64)];
        Presence { parts: vec![true; mockup.part_bounds().len()], triangles, children: Vec::new() }
    }

    fn memory(&self) -> usize {
        self.parts.capacity()
            + self.triangles.capacity() * size_of::<u64>()
            + self.children.iter().map(|level| level.capacity() * size_of::<u32>()).sum::<usize>()
    }
}

/// A bit a triangle: whether it is there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TrianglesThere<'a>(&'a [u64]);

impl TrianglesThere<'_> {
    /// Whether a triangle is there.
    #[inline(always)]
    pub fn has(self, triangle: u32) -> bool {
        is_set(self.0, triangle)
    }
}

#[inline(always)]
fn is_set(bits: &[u64], at: u32) -> bool {
    bits[at as usize / 64] >> (at % 64) & 1 == 1
}

impl Selection {
    /// Of the parts that are there only those for which `stays` says so. `children` are the words of a store's nodes.
    pub(crate) fn narrowed(
        &self,
        mockup: &Mockup,
        stays: impl Fn(u32) -> bool,
        children: impl FnOnce(TrianglesThere<'_>) -> Vec<Vec<u32>>,
    ) -> Selection {
        let parts = (0..mockup.part_bounds().len() as u32).map(|part| self.has_part(part) && stays(part)).collect();
        let presence = Some(Arc::new(Presence::new(mockup, parts, children)));
        Selection { presence, ignored: self.ignored.clone(), only: None }
    }

    /// The same without some parts, whose triangles that are queried are given; `children` makes new words of nodes of the old ones.
    pub(crate) fn masked(
        &self,
        mockup: &Mockup,
        (is_out, triangles): (&[bool], &[u32]),
        children: impl FnOnce(&[Vec<u32>], TrianglesThere<'_>) -> Vec<Vec<u32>>,
    ) -> Selection {
        let old: &[Vec<u32>] = self.presence.as_ref().map_or(&[], |presence| &presence.children);
        let mut presence = match &self.presence {
            Some(p) => Presence { parts: p.parts.clone(), triangles: p.triangles.clone(), children: Vec::new() },
            None => Presence::all(mockup),
        };
        for (part, is_out) in presence.parts.iter_mut().zip(is_out) {
            *part &= !is_out;
        }
        triangles.iter().for_each(|t| presence.triangles[*t as usize / 64] &= !(1 << (t % 64)));
        presence.children = children(old, TrianglesThere(&presence.triangles));
        Selection { presence: Some(Arc::new(presence)), ..self.clone() }
    }

    /// The same for any store: without words of nodes.
    pub(crate) fn of_any_store(&self) -> Selection {
        let without = |p: &Arc<Presence>| {
            Arc::new(Presence { parts: p.parts.clone(), triangles: p.triangles.clone(), children: Vec::new() })
        };
        Selection { presence: self.presence.as_ref().map(without), ..self.clone() }
    }

    /// The same with other ignored pairs.
    pub(crate) fn ignoring(&self, ignored: Option<Arc<IgnoredPairs>>) -> Selection {
        Selection { ignored, ..self.clone() }
    }

    /// Of the visible parts one alone, and all pairs: made in no time. The part of each triangle is checked in the query, so
    /// this is for tools that are near little else.
    pub(crate) fn of_one_part(&self, mockup: &Arc<Mockup>, part: u32) -> Selection {
        Selection { ignored: None, only: Some(OnlyPart { part, mockup: mockup.clone() }), ..self.clone() }
    }

    /// Whether everything is there and nothing is ignored.
    #[inline(always)]
    pub(crate) fn is_everything(&self) -> bool {
        self.presence.is_none() && self.ignored.is_none() && self.only.is_none()
    }

    /// Whether every part is there.
    pub(crate) fn has_all_parts(&self) -> bool {
        self.presence.is_none() && self.only.is_none()
    }

    /// Whether pairs of parts are ignored.
    pub fn ignores_any(&self) -> bool {
        self.ignored.is_some()
    }

    /// Whether a part is there.
    #[inline]
    pub fn has_part(&self, part: u32) -> bool {
        self.only.as_ref().is_none_or(|only| only.part == part)
            && self.presence.as_ref().is_none_or(|presence| presence.parts[part as usize])
    }

    /// Whether a triangle of the mock-up is there.
    #[inline(always)]
    pub fn has(&self, triangle: u32) -> bool {
        self.only.as_ref().is_none_or(|only| only.mockup.part_of_face(triangle) == only.part)
            && self.presence.as_ref().is_none_or(|presence| is_set(&presence.triangles, triangle))
    }

    /// Whether a pair of a tool part and a mock-up part is selected, or some surfaces of the two are.
    #[inline]
    pub fn wants_parts(&self, tool_part: u32, part: u32) -> bool {
        self.has_part(part) && self.ignored.as_ref().is_none_or(|ignored| !ignored.contains(tool_part, part))
    }

    /// Whether a pair of triangles is wanted: the tool's by slot.
    #[inline(always)]
    pub(crate) fn wants(&self, tool: &Tool, mockup: &Mockup, slot: u32, triangle: u32) -> bool {
        if !self.has(triangle) {
            return false;
        }
        let Some(ignored) = &self.ignored else { return true };
        let tool_triangle = tool.ids()[slot as usize];
        !ignored.contains(tool.part_of_face(tool_triangle), mockup.part_of_face(triangle))
            && !ignored.contains_surfaces(tool_triangle, triangle)
    }

    /// Whether no pair with a triangle of the mock-up is wanted, since its part is ignored with all parts of the tool.
    #[inline(always)]
    pub(crate) fn ignores_all_with(&self, mockup: &Mockup, triangle: u32) -> bool {
        let is_whole =
            |ignored: &Arc<IgnoredPairs>| ignored.whole.get(mockup.part_of_face(triangle) as usize) == Some(&true);
        self.ignored.as_ref().is_some_and(is_whole)
    }

    /// Words of the nodes of a level: which children have anything below them that is there. Empty: all.
    #[inline(always)]
    pub(crate) fn children(&self, level: usize) -> &[u32] {
        match &self.presence {
            Some(presence) => presence.children.get(level).map_or(&[], Vec::as_slice),
            None => &[],
        }
    }

    /// Bytes held, beyond those of the index.
    pub(crate) fn memory(&self) -> Option<usize> {
        self.presence.as_ref().map(|presence| presence.memory())
    }
}

/// Of the children chosen those that are there, by the words of a level.
#[inline(always)]
pub(crate) fn there(words: &[u32], node: u32, chosen: u32) -> u32 {
    match words.get(node as usize) {
        Some(word) => chosen & word,
        None => chosen,
    }
}
