//! Contact regions: connected intersection contours of the tool and one part, with the triangles that they enclose.
//!
//! A contour bounds the overlap of two surfaces. Neither it nor the region inside depends on how finely the surfaces are
//! triangulated: tool triangles behind the part's surface and the part's triangles inside the tool, flood filled from the contour
//! over shared edges.

use feeler_core::constants::NONE;
use feeler_core::{Point, Triangle};

use crate::containers::bounded_interner::BoundedInterner;
use crate::containers::counting_sort::lay_out;
use crate::context::QueryContext;
use crate::surface::{Side, Surface};
use feeler_core::index::interner::Interner;

/// A triangle that meets one of the other surface.
#[derive(Debug, Clone)]
pub(crate) struct Face {
    pub id: u32,
    pub corners: Triangle,
    /// Unit, outward; of an open surface to the side that counts as outside. Zero where it has none.
    pub normal: Point,
    /// Whether the surface is closed: then it has an inside of its own.
    pub closed: bool,
    /// For each corner its side of the other surface.
    pub side: [Side; 3],
    /// For each corner the nearest segment, which decided its side; [`NONE`] if none did.
    pub nearest: [u32; 3],
}

impl Face {
    /// Normal and sides are found later.
    pub fn new(id: u32, corners: Triangle, closed: bool) -> Face {
        Face { id, corners, normal: [0.0; 3], closed, side: [Side::On; 3], nearest: [NONE; 3] }
    }

    /// Whether the segment that decided the side of corner `k` satisfies `is_of`.
    pub fn is_corner_of(&self, k: usize, is_of: impl Fn(u32) -> bool) -> bool {
        self.nearest[k] != NONE && is_of(self.nearest[k])
    }
}

/// The points shared by a pair of triangles that meet.
#[derive(Debug, Clone)]
pub(crate) struct Segment {
    /// The two faces, in [`ContactRegions::faces`].
    pub faces: [u32; 2],
    /// Its points, a range of [`ContactRegions::points`]: two ends, or the corners of a polygon.
    pub points: (u32, u32),
    /// Whether the two triangles lie in one plane, so that it decides no side.
    pub flat: bool,
}

/// All contact regions of the tool and one part.
#[derive(Debug, Default)]
pub(crate) struct ContactRegions {
    /// Triangles of the tool, and of the mock-up, that collide with one of the other.
    pub faces: [Vec<Face>; 2],
    pub segments: Vec<Segment>,
    pub points: Vec<Point>,
    pub regions: Vec<ContactRegion>,
    /// Segments by region, and within a region by face: of the tool, and of the mock-up.
    pub(super) region_segments: [Vec<u32>; 2],
    /// Enclosed triangles by region: of the tool behind the part's surface, and of the part inside the tool, each with a segment of
    /// the contour that it was filled from.
    pub(super) region_inside: [Vec<[u32; 2]>; 2],
    /// Segments by face of tool and mock-up, and the range of each face.
    pub(super) by_face: [Vec<u32>; 2],
    pub(super) segments_of_face: [Vec<(u32, u32)>; 2],
    /// The region of each segment, and its index among the segments of that.
    pub region_of_segment: Vec<u32>,
    pub index_in_region: Vec<u32>,
    /// Unit, to where the tool is assumed to have come from, if anything is assumed: then a point of the tool is behind the mock-up's
    /// surface where it is behind the plane across this axis through the segment, whichever way the surface faces.
    pub assumed_axis: Option<Point>,
    /// Least height (metres) of triangles of tool and mock-up over their longest edges for their normals to count: see
    /// [`WELD_SHARE`](feeler_core::constants::WELD_SHARE).
    pub thin: [f64; 2],
    /// The numbers of the faces, and after them those of the enclosed triangles.
    pub face_numbers: FaceNumbers,
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
            index_in_region,
            ..
        } = self;
        faces.iter_mut().for_each(Vec::clear);
        by_face.iter_mut().for_each(Vec::clear);
        segments_of_face.iter_mut().for_each(Vec::clear);
        segments.clear();
        points.clear();
        regions.clear();
        region_of_segment.clear();
        index_in_region.clear();
    }

    /// The first two points of a segment: its ends where it is not flat.
    pub fn ends(&self, segment: u32) -> [Point; 2] {
        let from = self.segments[segment as usize].points.0 as usize;
        [self.points[from], self.points[from + 1]]
    }

    /// The face of a segment.
    pub fn face(&self, surface: Surface, segment: u32) -> &Face {
        &self.faces[surface][self.segments[segment as usize].faces[surface] as usize]
    }

    /// The normal that defines the side of a face, and whether a solid is behind it.
    #[inline(always)]
    pub fn outward(&self, surface: Surface, face: u32) -> (Point, bool) {
        let face = &self.faces[surface][face as usize];
        self.assumed_axis
            .filter(|_| surface == Surface::Mockup)
            .map_or((face.normal, face.closed), |axis| (axis, false))
    }

    /// The segments of each face of a surface.
    pub fn by_face(&self, surface: Surface) -> impl Iterator<Item = &[u32]> {
        (0..self.faces[surface].len()).map(move |face| self.of_face(surface, face))
    }

    /// The segments of one face.
    pub fn of_face(&self, surface: Surface, face: usize) -> &[u32] {
        let (from, to) = self.segments_of_face[surface][face];
        &self.by_face[surface][from as usize..to as usize]
    }

    /// The segments of a region, sorted by faces of the tool or of the mock-up.
    pub fn segments_of(&self, region: usize, surface: Surface) -> &[u32] {
        let (from, to) = self.regions[region].segments;
        &self.region_segments[surface][from as usize..to as usize]
    }

    /// The enclosed triangles of one surface in a region, each with the segment that it was filled from.
    pub fn inside_of(&self, region: usize, surface: Surface) -> &[[u32; 2]] {
        let (from, to) = self.regions[region].inside[surface];
        &self.region_inside[surface][from as usize..to as usize]
    }

    /// Sorts the segments by face; those of one face stay in their order.
    pub(super) fn sort_by_face(&mut self) {
        let ContactRegions { faces, segments, by_face, segments_of_face, .. } = self;
        for surface in Surface::BOTH {
            let (order, ranges) = (&mut by_face[surface], &mut segments_of_face[surface]);
            ranges.resize(faces[surface].len(), (0, 0));
            segments.iter().for_each(|segment| ranges[segment.faces[surface] as usize].1 += 1);
            lay_out(ranges.iter_mut());
            order.resize(segments.len(), 0);
            for (i, segment) in (0..).zip(segments.iter()) {
                let end = &mut ranges[segment.faces[surface] as usize].1;
                order[*end as usize] = i;
                *end += 1;
            }
        }
    }
}

/// One contact region: the ranges of its segments and of its enclosed triangles among those of all regions.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ContactRegion {
    pub(super) segments: (u32, u32),
    pub(super) inside: [(u32, u32); 2],
}

/// Numbers of triangles of tool and mock-up, in the order in which they were found.
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

    /// How many triangles of a surface have a number.
    pub fn len(&self, surface: Surface) -> usize {
        if surface == Surface::Tool {
            self.tool.len()
        } else {
            self.mockup.len()
        }
    }

    /// The number of a triangle, and whether it is new.
    pub fn number(&mut self, surface: Surface, id: u32) -> (u32, bool) {
        if surface == Surface::Tool {
            self.tool.number(id)
        } else {
            self.mockup.number(u64::from(id))
        }
    }

    /// The number of a triangle that has one.
    pub fn get(&self, surface: Surface, id: u32) -> Option<u32> {
        if surface == Surface::Tool {
            self.tool.get(id)
        } else {
            self.mockup.get(u64::from(id))
        }
    }
}
