//! Where one surface goes right through the other: a rod through a sheet, a wire across a finger. Along every direction something
//! goes on beyond the curve, so that the search for the least depth finds no plane, and the surfaces do not say on which side of
//! what is pierced the tool belongs. It is taken to be where its bulk is, as with open surfaces, unless a reference says more; one
//! plane across the way there holds all that the curve encloses.

use crate::contact_plane::ContactPlane;
use crate::context::QueryContext;
use crate::contour::contact_region::ContactRegions;
use crate::surface::{Side, Surface};
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{along, dot, length, scaled, sub, unit};

/// A zone without a plane, to be looked at again from one side.
#[derive(Debug)]
pub(crate) struct Piercing {
    /// What meets there, sorted.
    pub pairs: Vec<[u32; 2]>,
    /// Unit: to where the tool is taken to have come from.
    pub way: Point,
}

impl Piercing {
    /// `None` where the curve has no length, or what it runs over no normals.
    pub fn new(context: &QueryContext<'_>, regions: &ContactRegions, region: usize) -> Option<Piercing> {
        let segments = regions.segments_of(region, Surface::Tool);
        // Segments of the curve: length, middle, and normal of what is pierced.
        let spans = || {
            segments.iter().filter(|i| !regions.segments[**i as usize].flat).map(|i| {
                let [a, b] = regions.ends(*i);
                (length(&sub(&b, &a)), along(&scaled(&a, 0.5), 0.5, &b), regions.face(Surface::Mockup, *i).normal)
            })
        };
        let whole: f64 = spans().map(|(l, ..)| l).sum();
        let middle = spans().fold([0.0; 3], |sum, (l, middle, _)| along(&sum, l / whole, &middle));
        let back = context.way_back(&middle).unwrap_or_else(|| sub(&context.centre, &middle));
        // Straight off what is pierced, and not to the bulk, which may lie far aside: the mean of the normals, each turned to that
        // side; of a tool right in the middle to either.
        let towards = |back: &Point| {
            let side = |(l, _, n): (f64, Point, Point)| (l * dot(back, &n).signum(), n);
            unit(&spans().map(side).fold([0.0; 3], |sum, (l, n)| along(&sum, l, &n)))
        };
        let way = towards(&back).or_else(|| towards(&spans().max_by(|p, q| p.0.total_cmp(&q.0))?.2))?;
        let pairs = segments.iter().map(|i| Surface::BOTH.map(|surface| regions.face(surface, *i).id)).collect();
        Some(Piercing { pairs, way })
    }

    /// The plane across the way, `zones` being those of its pairs with the tool on that side.
    pub fn plane(&self, context: &QueryContext<'_>, regions: &ContactRegions, part: u32) -> ContactPlane {
        // The farthest along a direction of the curve and of what it encloses of one surface.
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
            (farthest(Surface::Mockup, &self.way), farthest(Surface::Tool, &scaled(&self.way, -1.0)));
        let depth = dot(&sub(&highest, &lowest), &self.way);
        let ids = |surface: Surface| self.pairs.iter().map(|pair| pair[surface]).collect();
        ContactPlane {
            point: along(&lowest, depth, &self.way),
            normal: self.way,
            gap: -depth,
            part,
            tool_triangles: ids(Surface::Tool),
            mockup_triangles: ids(Surface::Mockup),
            id: 0,
            carriers: self.pairs[0],
            certain: false,
            assumed: true,
        }
    }
}
