//! Where one surface goes right through the other: a rod through a sheet, a wire across a finger. Along every direction something
//! goes on beyond the curve, so that the search for the least depth finds no plane, and the surfaces do not say on which side of
//! what is pierced the tool belongs. It is taken to be where its bulk is, as with open surfaces, unless a reference says more; one
//! plane across the way there holds all that the curve encloses.

use crate::contact_plane::ContactPlane;
use crate::context::Ground;
use crate::context::{MOCKUP, TOOL};
use crate::contour::contact_region::Zones;
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{along, dot, length, scaled, sub, unit};

/// A zone without a plane, to be looked at again from one side.
#[derive(Debug)]
pub(crate) struct RightThrough {
    /// What meets there, sorted.
    pub pairs: Vec<[u32; 2]>,
    /// Unit: to where the tool is taken to have come from.
    pub way: Point,
}

impl RightThrough {
    /// `None` where the curve has no length, or what it runs over no normals.
    pub fn new(ground: &Ground<'_>, zones: &Zones, zone: usize) -> Option<RightThrough> {
        let cuts = zones.cuts_of(zone, TOOL);
        // Segments of the curve: length, middle, and normal of what is pierced.
        let segments = || {
            cuts.iter().filter(|i| !zones.cuts[**i as usize].flat).map(|i| {
                let [a, b] = zones.ends(*i);
                (length(&sub(&b, &a)), along(&scaled(&a, 0.5), 0.5, &b), zones.face(MOCKUP, *i).normal)
            })
        };
        let whole: f64 = segments().map(|(l, ..)| l).sum();
        let middle = segments().fold([0.0; 3], |sum, (l, middle, _)| along(&sum, l / whole, &middle));
        let back = ground.way_back(&middle).unwrap_or_else(|| sub(&ground.centre, &middle));
        // Straight off what is pierced, and not to the bulk, which may lie far aside: the mean of the normals, each turned to that
        // side; of a tool right in the middle to either.
        let towards = |back: &Point| {
            let side = |(l, _, n): (f64, Point, Point)| (l * dot(back, &n).signum(), n);
            unit(&segments().map(side).fold([0.0; 3], |sum, (l, n)| along(&sum, l, &n)))
        };
        let way = towards(&back).or_else(|| towards(&segments().max_by(|p, q| p.0.total_cmp(&q.0))?.2))?;
        let pairs = cuts.iter().map(|i| [TOOL, MOCKUP].map(|w| zones.face(w, *i).id)).collect();
        Some(RightThrough { pairs, way })
    }

    /// The plane across the way, `zones` being those of its pairs with the tool on that side.
    pub fn plane(&self, ground: &Ground<'_>, zones: &Zones, part: u32) -> ContactPlane {
        // The farthest along a direction of the curve and of what it encloses of one surface.
        let farthest = |w: usize, d: &Point| {
            let whole = (0..zones.zones.len()).flat_map(|zone| zones.inside_of(zone, w));
            let beyond = zones.faces[w].iter().flat_map(|f| (0..3).filter(|k| f.side[*k] < 0).map(|k| f.corners[k]));
            let points = zones.points.iter().copied().chain(beyond);
            let points = points.chain(whole.flat_map(|[id, _]| ground.triangle(w, *id)));
            points.max_by(|p, q| dot(p, d).total_cmp(&dot(q, d))).unwrap_or_default()
        };
        let (highest, lowest) = (farthest(MOCKUP, &self.way), farthest(TOOL, &scaled(&self.way, -1.0)));
        let depth = dot(&sub(&highest, &lowest), &self.way);
        let ids = |w: usize| self.pairs.iter().map(|pair| pair[w]).collect();
        ContactPlane {
            point: along(&lowest, depth, &self.way),
            normal: self.way,
            gap: -depth,
            part,
            tool_triangles: ids(TOOL),
            mockup_triangles: ids(MOCKUP),
            certain: false,
            assumed: true,
        }
    }
}
