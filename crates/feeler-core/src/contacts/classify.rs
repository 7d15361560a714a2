//! On which side of the other surface the corners of cut triangles are.

use crate::contacts::zones::{Zones, MOCKUP, TOOL};
use crate::contacts::Ground;
use crate::vectors::{cross, dot, square_to_segment, sub};

/// The nearest cut tells on which side a corner is. Where two are equally near, at an edge of the other surface, the one whose
/// line the corner stands off most steeply, in the plane of the triangle: there the two lines are a bend of the curve, and the
/// corner is on the outer side of it. Where a surface turns away within a triangle's length the nearest cut may be wrong about a
/// far corner: outside the other solid's box it is outside.
pub(crate) fn classify(ground: &Ground<'_>, part: u32, zones: &mut Zones) {
    let Zones { faces, cuts, points, .. } = zones;
    for (i, cut) in cuts.iter().enumerate().filter(|(_, c)| !c.flat) {
        let (a, b) = (points[cut.points.0 as usize], points[cut.points.0 as usize + 1]);
        let line = sub(&b, &a);
        let lengths = dot(&line, &line);
        for w in [TOOL, MOCKUP] {
            let n = faces[1 - w][cut.faces[1 - w] as usize].normal;
            let face = &mut faces[w][cut.faces[w] as usize];
            for k in 0..3 {
                let square = square_to_segment(&face.corners[k], &a, &b);
                if square > face.square[k] * (1.0 + 1e-9) {
                    continue;
                }
                let from = sub(&face.corners[k], &a);
                let height = dot(&from, &n);
                // How far it is off the line of the cut, in the face's own plane: that other plane may be met at any angle.
                let off = cross(&from, &line);
                let off = if lengths > 0.0 { dot(&off, &off) / lengths } else { height * height };
                let (steepness, is_on) = match square > 0.0 {
                    true => (off / square, height * height < 1e-18 * square),
                    false => (0.0, true),
                };
                let tie = square >= face.square[k] * (1.0 - 1e-9);
                if if tie { steepness > face.steepness[k] } else { square < face.square[k] } {
                    face.square[k] = square;
                    face.steepness[k] = steepness;
                    face.nearest[k] = i as u32;
                    face.side[k] = if is_on {
                        0
                    } else if height < 0.0 {
                        -1
                    } else {
                        1
                    };
                }
            }
        }
    }
    for w in [TOOL, MOCKUP] {
        for i in 0..faces[w].len() {
            for k in 0..3 {
                let face = &faces[w][i];
                if face.side[k] < 0 {
                    let other = cuts[face.nearest[k] as usize].faces[1 - w];
                    if faces[1 - w][other as usize].closed && !ground.may_enclose(1 - w, part, &face.corners[k]) {
                        faces[w][i].side[k] = 1;
                    }
                }
            }
        }
    }
}
