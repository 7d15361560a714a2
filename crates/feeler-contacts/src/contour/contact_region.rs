//! Contact zones: the curves along which the tool cuts one part, and what each has beyond the other's surface.
//!
//! A curve does not know how finely the surfaces are cut into triangles, and neither does what it encloses: tool triangles
//! behind the part's surface and the part's triangles inside the tool, found by walking from the curve over shared edges.

use feeler_core::constants::NONE;
use feeler_core::{Point, Triangle};

use crate::containers::counting_sort::lay_out;
use crate::containers::interner::{BoundedInterner, Interner};
use crate::context::QueryContext;
use crate::surface::{Side, Surface};

/// A triangle that is cut.
#[derive(Debug, Clone)]
pub(crate) struct Face {
    pub id: u32,
    pub corners: Triangle,
    /// Unit, away from the solid or from the side it counts as.
    pub normal: Point,
    /// Whether the surface is closed, so that it has an inside of its own.
    pub closed: bool,
    /// For each corner, of the other solid.
    pub side: [Side; 3],
    /// The cut nearest to each corner, which says so.
    pub nearest: [u32; 3],
}

impl Face {
    /// Its normal is not known yet.
    pub fn new(id: u32, corners: Triangle, closed: bool) -> Face {
        Face { id, corners, normal: [0.0; 3], closed, side: [Side::On; 3], nearest: [NONE; 3] }
    }

    /// Whether corner `k` was judged by a cut of which `is_of` is true.
    pub fn is_corner_of(&self, k: usize, is_of: impl Fn(u32) -> bool) -> bool {
        self.nearest[k] != NONE && is_of(self.nearest[k])
    }
}

/// A pair of triangles that meet.
#[derive(Debug, Clone)]
pub(crate) struct Segment {
    /// FaceNumbers among the faces.
    pub faces: [u32; 2],
    /// The points shared, in [`ContactRegions::points`].
    pub points: (u32, u32),
    /// Whether the two lie in one plane.
    pub flat: bool,
}

/// Everything between the tool and one part.
#[derive(Debug, Default)]
pub(crate) struct ContactRegions {
    /// Cut triangles of the tool, and of the mock-up.
    pub faces: [Vec<Face>; 2],
    pub segments: Vec<Segment>,
    pub points: Vec<Point>,
    pub regions: Vec<ContactRegion>,
    /// Cuts zone by zone, in each sorted by faces of the tool, and by faces of the mock-up.
    pub(super) region_segments: [Vec<u32>; 2],
    /// ContactRegion by zone whole triangles of the tool behind the part's surface, and of the part inside the tool, each with a cut near
    /// by.
    pub(super) region_inside: [Vec<[u32; 2]>; 2],
    /// Cuts by faces of tool and mock-up, and where those of each face begin and end.
    pub(super) by_face: [Vec<u32>; 2],
    pub(super) segments_of_face: [Vec<(u32, u32)>; 2],
    /// For each cut its zone, and its place among that zone's.
    pub region_of_segment: Vec<u32>,
    pub place_of_segment: Vec<u32>,
    /// Where the tool is taken to have come from, unit: then a corner of it is behind the mock-up's surface where it is behind the
    /// plane across this way through the cut, whatever the surface faces there.
    pub way: Option<Point>,
    /// Whether all was walked over.
    pub complete: bool,
    /// How high triangles of tool and mock-up must be over their longest edges for their normals to count: see [`WELD_SHARE`](feeler_core::constants::WELD_SHARE).
    pub thin: [f64; 2],
    /// Cut triangles by their places among the faces, and after them those that were walked over.
    pub places: FaceNumbers,
}

impl ContactRegions {
    pub(super) fn clear(&mut self) {
        let ContactRegions {
            faces,
            segments,
            points,
            regions,
            by_face,
            segments_of_face,
            region_of_segment,
            place_of_segment,
            ..
        } = self;
        faces.iter_mut().for_each(Vec::clear);
        by_face.iter_mut().for_each(Vec::clear);
        segments_of_face.iter_mut().for_each(Vec::clear);
        segments.clear();
        points.clear();
        regions.clear();
        region_of_segment.clear();
        place_of_segment.clear();
    }

    /// The first two points of a cut: the ends of its segment where it is not flat.
    pub fn ends(&self, segment: u32) -> [Point; 2] {
        let from = self.segments[segment as usize].points.0 as usize;
        [self.points[from], self.points[from + 1]]
    }

    /// The face of a cut.
    pub fn face(&self, surface: Surface, segment: u32) -> &Face {
        &self.faces[surface][self.segments[segment as usize].faces[surface] as usize]
    }

    /// What tells on which side of a face the other surface is: a normal, and whether there is a solid behind it.
    #[inline(always)]
    pub fn side_of(&self, surface: Surface, face: u32) -> (Point, bool) {
        let face = &self.faces[surface][face as usize];
        self.way.filter(|_| surface == Surface::Mockup).map_or((face.normal, face.closed), |way| (way, false))
    }

    /// The cuts of each face of a surface.
    pub fn by_face(&self, surface: Surface) -> impl Iterator<Item = &[u32]> {
        (0..self.faces[surface].len()).map(move |face| self.of_face(surface, face))
    }

    /// The cuts of one face.
    pub fn of_face(&self, surface: Surface, face: usize) -> &[u32] {
        let (from, to) = self.segments_of_face[surface][face];
        &self.by_face[surface][from as usize..to as usize]
    }

    /// The cuts of a zone, sorted by faces of the tool or of the mock-up.
    pub fn segments_of(&self, region: usize, surface: Surface) -> &[u32] {
        let (from, to) = self.regions[region].segments;
        &self.region_segments[surface][from as usize..to as usize]
    }

    /// Whole triangles of the tool behind the part's surface in a zone, or of the part inside the tool, each with a cut near by.
    pub fn inside_of(&self, region: usize, surface: Surface) -> &[[u32; 2]] {
        let (from, to) = self.regions[region].inside[surface];
        &self.region_inside[surface][from as usize..to as usize]
    }

    /// Puts the cuts of each face together, in their order.
    pub(super) fn sort_by_face(&mut self) {
        let ContactRegions { faces, segments, by_face, segments_of_face, .. } = self;
        for surface in Surface::BOTH {
            let (order, of) = (&mut by_face[surface], &mut segments_of_face[surface]);
            of.resize(faces[surface].len(), (0, 0));
            segments.iter().for_each(|segment| of[segment.faces[surface] as usize].1 += 1);
            lay_out(of.iter_mut());
            order.resize(segments.len(), 0);
            for (i, segment) in (0..).zip(segments.iter()) {
                let end = &mut of[segment.faces[surface] as usize].1;
                order[*end as usize] = i;
                *end += 1;
            }
        }
    }
}

/// One connected place of contact: where its cuts and what is inside are among those of all zones.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ContactRegion {
    pub(super) segments: (u32, u32),
    pub(super) inside: [(u32, u32); 2],
}

/// Triangles of tool and mock-up in the order in which they were found.
#[derive(Debug, Default)]
pub(crate) struct FaceNumbers {
    tool: BoundedInterner,
    mockup: Interner,
}

impl FaceNumbers {
    pub(super) fn clear(&mut self, context: &QueryContext<'_>) {
        self.tool.clear(context.tool.mesh().faces().len());
        self.mockup.clear();
    }

    /// How many there are.
    pub fn len(&self, surface: Surface) -> usize {
        if surface == Surface::Tool {
            self.tool.len()
        } else {
            self.mockup.len()
        }
    }

    /// The place of a triangle, and whether it is new.
    pub fn number(&mut self, surface: Surface, id: u32) -> (u32, bool) {
        if surface == Surface::Tool {
            self.tool.number(id)
        } else {
            self.mockup.number(u64::from(id))
        }
    }

    pub fn get(&self, surface: Surface, id: u32) -> Option<u32> {
        if surface == Surface::Tool {
            self.tool.get(id)
        } else {
            self.mockup.get(u64::from(id))
        }
    }
}
