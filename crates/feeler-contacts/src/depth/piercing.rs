//! Piercing: one surface goes right through the other, as a rod through a sheet or a wire across a finger.
//!
//! Every axis is blocked there, so the search for the least depth finds no plane, and the surfaces do not show on which
//! side of the pierced one the tool belongs. The side of the tool's centre of area decides, as with open surfaces, or
//! that of the reference pose if there is one. One plane across that axis separates everything inside the contour.

use crate::contact_plane::ContactPlane;
use crate::context::QueryContext;
use crate::contour::contact_region::ContactRegions;
use crate::surface::{Side, Surface};
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{along, dot, length, scaled, sub, unit};

/// A region without a plane, to be searched again with a side assumed.
#[derive(Debug)]
pub(crate) struct Piercing {
    /// The colliding pairs of triangles there, sorted.
    pub pairs: Vec<[u32; 2]>,
    /// Unit, to the side that the tool is taken to have come from.
    pub axis: Point,
}

impl Piercing {
    /// `None` where the contour has no length, or the pierced surface no normals along it.
    pub fn new(context: &QueryContext<'_>, regions: &ContactRegions, region: usize) -> Option<Piercing> {
        let segments = regions.segments_of(region, Surface::Tool);
        // Segments of the contour: length, middle, and normal of the pierced surface.
        let spans = || {
            segments.iter().filter(|i| !regions.segments[**i as usize].flat).map(|i| {
                let [a, b] = regions.ends(*i);
                (length(&sub(&b, &a)), along(&scaled(&a, 0.5), 0.5, &b), regions.face(Surface::Mockup, *i).normal)
            })
        };
        let whole: f64 = spans().map(|(l, ..)| l).sum();
        let middle = spans().fold([0.0; 3], |sum, (l, middle, _)| along(&sum, l / whole, &middle));
        let back = context.way_back(&middle).unwrap_or_else(|| sub(&context.centre, &middle));
        // Straight off the pierced surface, and not towards the centre, which may lie far aside: the mean of the normals, each turned
        // to that side. With the tool's centre in the pierced surface that has no length, and the longest segment's normal decides.
        let towards = |back: &Point| {
            let side = |(l, _, n): (f64, Point, Point)| (l * dot(back, &n).signum(), n);
            unit(&spans().map(side).fold([0.0; 3], |sum, (l, n)| along(&sum, l, &n)))
        };
        let axis = towards(&back).or_else(|| towards(&spans().max_by(|p, q| p.0.total_cmp(&q.0))?.2))?;
        let pairs = segments.iter().map(|i| Surface::BOTH.map(|surface| regions.face(surface, *i).id)).collect();
        Some(Piercing { pairs, axis })
    }

    /// The plane across the axis; `regions` are those of its pairs with the tool on that side.
    pub fn plane(&self, context: &QueryContext<'_>, regions: &ContactRegions, part: u32) -> ContactPlane {
        // The farthest point along a direction, of the contour and of the region that it encloses on one surface.
        let farthest = |surface: Surface, d: &Point| {
            let whole = (0..regions.regions.len()).flat_map(|region| regions.inside_of(region, surface));
            let beyond = regions.faces[surface]
                .iter()
                .flat_map(|f| (0..3).filter(|k| f.side[*k] == Side::Inside).map(|k| f.corners[k]));
            let points = regions.points.iter().copied().chain(beyond);
            let points = points.chain(whole.flat_map(|[id, _]| context.triangle(surface, *id)));
            points.max_by(|p, q| dot(p, d).total_cmp(&dot(q, d))).unwrap_or_default()
        };
        let (highest, lowest) =
            (farthest(Surface::Mockup, &self.axis), farthest(Surface::Tool, &scaled(&self.axis, -1.0)));
        let depth = dot(&sub(&highest, &lowest), &self.axis);
        let ids = |surface: Surface| self.pairs.iter().map(|pair| pair[surface]).collect();
        ContactPlane {
            point: along(&lowest, depth, &self.axis),
            normal: self.axis,
            gap: -depth,
            part,
            tool_triangles: ids(Surface::Tool),
            mockup_triangles: ids(Surface::Mockup),
            id: 0,
            carriers: self.pairs[0],
            assumed: true,
        }
    }
}
