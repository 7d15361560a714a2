//! Contacts of concave solids of known depth: pockets, racks, stepped shafts and such, made of axis-aligned blocks,
//! with a tool pressed against chosen faces by so many units, or off them.
//!
//! The cases are limited to those with a unique truth. Wherever a face is pressed, the overlap is thin and at least
//! three times as wide, so that the way across that face is the shortest. No two faces lie in one plane: rotated flush
//! surfaces cut each other by rounding (see the limits in `docs/contacts.md`).
//!
//! They are also limited to what the contacts guarantee today:
//! - If two pressed faces meet in a concave edge and one of the solids ends across it, the end is an L. Pressed by less
//!   than a few hundredths of its size it may count as a body of its own, with a plane along the edge as deep as the
//!   other solid is long. So the concave solid is the longer one.
//! - If opposite faces are pressed, and the tool or a tooth of the mock-up is wedged, planes may be missing, or lean by
//!   up to some twenty degrees. So none are, and all teeth of a rack press to one side.
//! - Of three pressed faces that meet in a concave corner one may, rarely, have no plane. So two are pressed, at most.
//! - If a shoulder is pressed all around and a wall beside it, walls and shoulder give planes across the whole bore. So
//!   a stepped shaft is pressed against walls or against shoulders, and at each step against one wall.
//! - Beside a deep contact a near face of large triangles may have no plane: each pair of triangles is evaluated at its
//!   nearest point, and a deep plane may cover that point. So near planes are required only where nothing is deep.

use crate::blocks::{Block, Obstacles, Solid};
use crate::random::Random;

/// About how large the solids are, in units.
pub const SIZE: i64 = 1 << 20;

/// How wide what overlaps, and what the solids are made of, is at least.
const WIDE: i64 = SIZE / 12;

/// How deep and how near it is at most.
const DEEPEST: i64 = SIZE / 48;
const NEAREST: i64 = SIZE / 30;

/// Less than this a face is neither pressed nor free.
const LEAST: i64 = SIZE / 2048;

/// A plane that is to be found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Known {
    /// The part it is of.
    pub part: usize,
    /// The axis it is across, and 1 or -1: to which side of it the tool belongs.
    pub axis: usize,
    /// See `axis`.
    pub sense: i64,
    /// How deep the tool is behind it; negative: how far from it.
    pub depth: i64,
}

/// A mock-up, a tool pressed into it, and the truth about the two.
#[derive(Debug, Clone)]
pub struct Contact {
    /// The solids of the mock-up, each a part.
    pub parts: Vec<Solid>,
    /// The tool.
    pub tool: Solid,
    /// One for each face that is pressed, or that the tool is near to.
    pub planes: Vec<Known>,
}

impl Contact {
    /// The tool's ways that let it overlap the mock-up, all as much larger.
    pub fn obstacles(&self, larger: i64) -> Obstacles {
        Obstacles::new(&self.parts, &self.tool, larger)
    }
}

/// A kind of contact.
#[derive(Clone, Copy)]
pub struct Family {
    /// The name for `--only` and the table.
    pub name: &'static str,
    /// What it makes.
    pub about: &'static str,
    make: fn(&mut Random) -> Contact,
}

/// Every family, in the order of the table.
#[rustfmt::skip]
pub const FAMILIES: [Family; 7] = [
    Family { name: "block", about: "a block pressed into a face of another, over edges or not", make: block },
    Family { name: "corner", about: "a block in a corner of a floor and one wall or two", make: |r| pocket(r, [true, false, true, false]) },
    Family { name: "slot", about: "a block in a slot, or in a pocket of three or four walls", make: |r| { let walls = [true, true, r.one_in(3), r.one_in(3)]; pocket(r, walls) } },
    Family { name: "rack", about: "teeth in gaps, each flank and tip with a depth of its own", make: rack },
    Family { name: "stepped", about: "a stepped shaft in a stepped bore", make: stepped },
    Family { name: "terrain", about: "a plate on columns of different heights", make: terrain },
    Family { name: "undercut", about: "a foot in a T-slot, under both lips", make: undercut },
];

impl crate::tally::Family for Family {
    fn name(&self) -> &'static str {
        self.name
    }
}

impl Family {
    /// One of them, the same for the same numbers.
    pub fn make(&self, r: &mut Random) -> Contact {
        loop {
            let contact = (self.make)(r);
            // A way out that fits to a hair is no way out once it is rounded; and of no contact there is nothing to say.
            let [way, wide] = [0, LEAST / 4].map(|larger| contact.obstacles(larger).shortest_way());
            let is_steady = (0..3).all(|a| (way[a] - wide[a]).abs() <= LEAST / 4);
            if is_steady && contact.planes.iter().any(|known| known.depth > -NEAREST) {
                return contact;
            }
        }
    }
}

fn span(r: &mut Random, low: i64, high: i64) -> i64 {
    low + r.below((high - low).max(1) as usize) as i64
}

/// A depth, a short distance, or a distance beyond all that is near.
fn press(r: &mut Random) -> i64 {
    match r.below(5) {
        0 | 1 => span(r, LEAST, DEEPEST),
        2 | 3 => -span(r, LEAST, NEAREST),
        _ => -span(r, WIDE, 2 * WIDE),
    }
}

/// The presses of faces of which at most `most` are to be deep.
fn presses<const N: usize>(r: &mut Random, most: usize) -> [i64; N] {
    let mut all = [0; N].map(|_| press(r));
    while all.iter().filter(|depth| **depth > 0).count() > most {
        let one = r.below(N);
        if all[one] > 0 {
            all[one] = press_off(r);
        }
    }
    all
}

/// Off a face, and near to it.
fn press_off(r: &mut Random) -> i64 {
    -span(r, LEAST, NEAREST)
}

/// Where something as long lies that shares at least [`WIDE`] with what is between two ends, and ends at neither.
fn beside(r: &mut Random, [low, high]: [i64; 2], length: i64) -> [i64; 2] {
    loop {
        let from = span(r, low - length + WIDE, high - WIDE);
        if (from - low).abs() > LEAST && (from + length - high).abs() > LEAST {
            return [from, from + length];
        }
    }
}

/// Ends between two others, at least [`WIDE`] apart.
fn inside(r: &mut Random, [low, high]: [i64; 2]) -> [i64; 2] {
    let from = span(r, low + LEAST, high - WIDE - 2 * LEAST);
    [from, span(r, from + WIDE, high - LEAST)]
}

/// Ends beyond two others.
fn around(r: &mut Random, [low, high]: [i64; 2]) -> [i64; 2] {
    [low - span(r, LEAST, WIDE), high + span(r, LEAST, WIDE)]
}

/// A block between ends along each axis.
fn between([x, y, z]: [[i64; 2]; 3]) -> Block {
    Block::new([x[0], y[0], z[0]], [x[1], y[1], z[1]])
}

/// All blocks as one part, or seldom each as one.
fn parts_of(r: &mut Random, blocks: Vec<Block>) -> (Vec<Solid>, bool) {
    if r.one_in(3) {
        (blocks.into_iter().map(|b| Solid(vec![b])).collect(), true)
    } else {
        (vec![Solid(blocks)], false)
    }
}

fn block(r: &mut Random) -> Contact {
    let fixed = [0, 1, 2].map(|_| [0, span(r, 3 * WIDE, SIZE)]);
    let (axis, sense, depth) = (r.below(3), r.pick(&[-1, 1]), press(r));
    let mover = [0, 1, 2].map(|a| {
        let length = span(r, 2 * WIDE, SIZE);
        if a != axis {
            beside(r, fixed[a], length)
        } else if sense > 0 {
            [fixed[a][1] - depth, fixed[a][1] - depth + length]
        } else {
            [depth - length, depth]
        }
    });
    Contact {
        parts: vec![Solid(vec![between(fixed)])],
        tool: Solid(vec![between(mover)]),
        planes: vec![Known { part: 0, axis, sense, depth }],
    }
}

/// A block on a floor between walls: before and behind along x, before and behind along y.
fn pocket(r: &mut Random, walls: [bool; 4]) -> Contact {
    let walls = if walls[1] || r.one_in(2) { walls } else { [walls[0], false, false, false] };
    // Of the floor, and of what of two opposite walls is nearer.
    let [floor, x, y] = presses::<3>(r, 2);
    let mut depths = [[x, press_off(r)], [y, press_off(r)]];
    depths.iter_mut().for_each(|of_axis| of_axis.rotate_left(r.below(2)));
    let is_deep = |wall: usize| walls[wall] && depths[wall / 2][wall % 2] > 0;
    let is_edge = (0..4).filter(|wall| is_deep(*wall)).count() + usize::from(floor > 0) > 1;
    let height = span(r, 4 * WIDE, SIZE);
    let thick = span(r, WIDE, SIZE / 3);
    // The free space between the walls, what is around it, and the block.
    let mut inner = [[0; 2]; 2];
    let (mut outer, mut mover) = ([[0; 2], [0; 2], [-thick, height]], [[0; 2]; 3]);
    for a in 0..2 {
        let room = span(r, 3 * WIDE, SIZE);
        let [before, behind] = depths[a];
        inner[a] = [0, room];
        outer[a] = around(r, [-WIDE, room + WIDE]);
        let length = if is_edge { span(r, 2 * WIDE, room) } else { span(r, 2 * WIDE, SIZE) };
        mover[a] = match [walls[2 * a], walls[2 * a + 1]] {
            [true, true] => [-before, room + behind],
            [true, false] => [-before, -before + length],
            [false, true] => [room + behind - length, room + behind],
            [false, false] if is_edge => inside(r, outer[a]),
            [false, false] => beside(r, outer[a], length),
        };
    }
    mover[2] = [-floor, if is_edge { span(r, 2 * WIDE, height - LEAST) } else { span(r, 2 * WIDE, SIZE) }];
    let mut blocks = vec![between([outer[0], outer[1], [-thick, 0]])];
    let mut planes = vec![Known { part: 0, axis: 2, sense: 1, depth: floor }];
    for (axis, side) in [0, 1].into_iter().flat_map(|axis| [(axis, 0), (axis, 1)]) {
        if walls[2 * axis + side] {
            let mut ends = outer;
            ends[axis] = [[outer[axis][0], inner[axis][0]], [inner[axis][1], outer[axis][1]]][side];
            planes.push(Known { part: blocks.len(), axis, sense: [1, -1][side], depth: depths[axis][side] });
            blocks.push(between(ends));
        }
    }
    finish(r, blocks, Solid(vec![between(mover)]), planes)
}

/// Planes by the blocks they are of.
fn finish(r: &mut Random, blocks: Vec<Block>, tool: Solid, mut planes: Vec<Known>) -> Contact {
    let (parts, is_parted) = parts_of(r, blocks);
    if !is_parted {
        planes.iter_mut().for_each(|known| known.part = 0);
    }
    Contact { parts, tool, planes }
}

fn rack(r: &mut Random) -> Contact {
    let gaps = 1 + r.below(5);
    let height = span(r, 2 * WIDE, SIZE / 2);
    let deep = [0, span(r, 3 * WIDE, SIZE)];
    let thick = [span(r, WIDE, SIZE / 3), span(r, WIDE, SIZE / 3)];
    // The tips of one rack are at the roots of the other: one of the two is hollow where they are pressed.
    let is_root = r.one_in(2);
    let of_tool = if is_root { around(r, deep) } else { inside(r, deep) };
    let root = if is_root { press(r) } else { press_off(r) };
    let (bottom, side) = (height - root, r.below(2));
    let (mut blocks, mut teeth, mut planes) = (Vec::new(), Vec::new(), Vec::new());
    let mut at = 0;
    for gap in 0..=gaps {
        let end = at + span(r, 2 * WIDE, 3 * WIDE);
        // Into the base, so that it is one solid with it, and as a part of its own stands in it.
        blocks.push(between([[at, end], deep, [-thick[0] / 2, height]]));
        planes.push(Known { part: gap, axis: 2, sense: 1, depth: root });
        if gap == gaps {
            at = end;
            break;
        }
        at = end + span(r, 3 * WIDE, 4 * WIDE);
        // All against one flank: a tooth between two that press it is wedged.
        let mut flanks = [press(r).max(-NEAREST), press_off(r)];
        flanks.rotate_left(side);
        let [left, right] = flanks;
        let tip = if is_root { press_off(r) } else { press(r).max(-WIDE) };
        teeth.push(between([[end - left, at + right], of_tool, [-tip, bottom + thick[1] / 2]]));
        planes.push(Known { part: gap, axis: 0, sense: 1, depth: left });
        planes.push(Known { part: gap + 1, axis: 0, sense: -1, depth: right });
        planes.push(Known { part: gaps + 1, axis: 2, sense: 1, depth: tip });
    }
    blocks.push(between([[0, at], deep, [-thick[0], 0]]));
    teeth.push(between([around(r, [0, at]), of_tool, [bottom, bottom + thick[1]]]));
    finish(r, blocks, Solid(teeth), planes)
}

fn stepped(r: &mut Random) -> Contact {
    let levels = 2 + r.below(3);
    // From the bottom up: half widths of the bore along x and y, and where levels begin.
    let mut half = [span(r, 2 * WIDE, 3 * WIDE), span(r, 2 * WIDE, 3 * WIDE)];
    let (mut blocks, mut sections, mut planes) = (Vec::new(), Vec::new(), Vec::new());
    let outer = [7, 8].map(|n| (n + levels as i64) * WIDE);
    let is_blind = r.one_in(2);
    let is_shoulder = r.one_in(2);
    let mut floor = 0;
    // Where the bore goes through, the shaft looks out below.
    let bottom = match is_blind {
        true if is_shoulder => press(r).max(-WIDE / 2),
        true => press_off(r),
        false => span(r, LEAST, 2 * WIDE),
    };
    let mut section_floor = floor - bottom;
    for level in 0..levels {
        let ceiling = floor + span(r, 2 * WIDE, 4 * WIDE);
        let mut ends = [[0; 2], [0; 2], [floor, ceiling]];
        let depths = presses::<4>(r, usize::from(!is_shoulder)).map(|x| x.max(-NEAREST));
        for (axis, of_axis) in depths.chunks_exact(2).enumerate() {
            ends[axis] = [-half[axis] - of_axis[0], half[axis] + of_axis[1]];
            planes.extend([0, 1].map(|side| Known { part: 0, axis, sense: [1, -1][side], depth: of_axis[side] }));
        }
        // Four walls around the bore, each as long as the outline.
        let [x, y] = outer.map(|o| [-o, o]);
        let walls = [[x[0], -half[0]], [half[0], x[1]]].map(|x| [x, y]);
        let others = [[y[0], -half[1]], [half[1], y[1]]].map(|y| [x, y]);
        blocks.extend(walls.into_iter().chain(others).map(|[x, y]| between([x, y, [floor, ceiling]])));
        let is_last = level + 1 == levels;
        let shoulder = match is_shoulder {
            _ if is_last => -span(r, WIDE, 2 * WIDE),
            true => press(r).max(-WIDE / 2),
            false => press_off(r),
        };
        let section_ceiling = ceiling - shoulder;
        sections.push(between([ends[0], ends[1], [section_floor, section_ceiling]]));
        if !is_last {
            planes.push(Known { part: 0, axis: 2, sense: 1, depth: shoulder });
            half = half.map(|h| h + span(r, WIDE, 2 * WIDE));
        }
        (floor, section_floor) = (ceiling, section_ceiling);
    }
    if is_blind {
        planes.push(Known { part: 0, axis: 2, sense: 1, depth: bottom });
        blocks.push(between([[-outer[0], outer[0]], [-outer[1], outer[1]], [-span(r, WIDE, SIZE / 3), 0]]));
    }
    Contact { parts: vec![Solid(blocks)], tool: Solid(sections), planes }
}

fn terrain(r: &mut Random) -> Contact {
    let count = [1 + r.below(3), 1 + r.below(3)];
    let lines = count.map(|n| {
        (0..n).fold(vec![0], |mut line, _| {
            let next = line[line.len() - 1] + span(r, 2 * WIDE, 4 * WIDE);
            line.push(next);
            line
        })
    });
    let whole = [0, 1].map(|a| [0, lines[a][count[a]]]);
    let over = whole.map(|[_, end]| {
        let length = span(r, 2 * WIDE, end + 2 * WIDE);
        beside(r, [0, end], length)
    });
    let top = span(r, 2 * WIDE, 4 * WIDE);
    let (mut blocks, mut planes) = (Vec::new(), Vec::new());
    for x in lines[0].windows(2) {
        for y in lines[1].windows(2) {
            let ends = [[x[0], x[1]], [y[0], y[1]]];
            let shared = [0, 1].map(|a| over[a][1].min(ends[a][1]) - over[a][0].max(ends[a][0]));
            // What only an edge of the plate is over stays off: the way aside may be shorter.
            let is_wide = shared.iter().all(|s| *s >= WIDE);
            let depth = if is_wide { press(r).max(-WIDE) } else { -WIDE };
            planes.extend(is_wide.then_some(Known { part: 0, axis: 2, sense: 1, depth }));
            blocks.push(between([ends[0], ends[1], [0, top + depth]]));
        }
    }
    let plate = between([over[0], over[1], [top, top + span(r, 2 * WIDE, SIZE)]]);
    Contact { parts: vec![Solid(blocks)], tool: Solid(vec![plate]), planes }
}

fn undercut(r: &mut Random) -> Contact {
    let room = span(r, 8 * WIDE, SIZE);
    let (height, lip) = (span(r, 2 * WIDE, 5 * WIDE), span(r, WIDE, 2 * WIDE));
    let lips = [span(r, 2 * WIDE, 3 * WIDE), room - span(r, 2 * WIDE, 3 * WIDE)];
    let deep = [0, span(r, 3 * WIDE, SIZE)];
    // Pressed from within the slot, which is hollow there, or between foot and neck, which are.
    let is_neck = r.one_in(2);
    let of_tool = if is_neck { around(r, deep) } else { inside(r, deep) };
    let off = |r: &mut Random| [press_off(r), press_off(r)];
    let near = |r: &mut Random| presses(r, 1).map(|x: i64| x.max(-NEAREST));
    let [left, right] = if is_neck { off(r) } else { near(r) };
    let stem = if is_neck { near(r) } else { off(r) };
    let [down, up] = if is_neck { [press_off(r), press(r).max(-NEAREST)] } else { near(r) };
    let foot = between([[-left, room + right], of_tool, [-down, height + up]]);
    let neck = [lips[0] - stem[0], lips[1] + stem[1]];
    let top = height + lip + span(r, WIDE, SIZE / 3);
    let neck = between([neck, of_tool, [height + up, top]]);
    let outer = around(r, [-WIDE, room + WIDE]);
    let blocks = vec![
        between([outer, deep, [-span(r, WIDE, SIZE / 3), 0]]),
        between([[outer[0], 0], deep, [0, height + lip]]),
        between([[room, outer[1]], deep, [0, height + lip]]),
        between([[0, lips[0]], deep, [height, height + lip]]),
        between([[lips[1], room], deep, [height, height + lip]]),
    ];
    let known = |axis: usize, sense: i64, depth: i64| Known { part: 0, axis, sense, depth };
    let planes = vec![
        known(2, 1, down),
        known(2, -1, up),
        known(0, 1, left),
        known(0, -1, right),
        known(0, 1, stem[0]),
        known(0, -1, stem[1]),
    ];
    Contact { parts: vec![Solid(blocks)], tool: Solid(vec![foot, neck]), planes }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_is_so() {
        for family in FAMILIES {
            let mut counts = [0; 3];
            for seed in 0..200 {
                let mut r = Random::new(seed);
                let contact = family.make(&mut r);
                let what = format!("{} {seed}: {contact:?}", family.name);
                // Each depth is that of a block in another, and no others overlap.
                let overlaps = |known: &Known| {
                    let faces = |b: &Block, sense: i64| if sense > 0 { b.high[known.axis] } else { -b.low[known.axis] };
                    let blocks = contact.parts[known.part].0.iter();
                    blocks
                        .flat_map(|m| {
                            contact.tool.0.iter().map(move |t| faces(m, known.sense) + faces(t, -known.sense))
                        })
                        .any(|depth| depth == known.depth)
                };
                assert!(contact.planes.iter().all(overlaps), "{what}");
                let is_deep = contact.planes.iter().any(|known| known.depth > 0);
                assert_eq!(is_deep, !contact.obstacles(0).is_free(&[0; 3]), "{what}");
                // Along every axis as far as the deepest asks is far enough, where not both directions are wanted.
                let asked = |axis: usize, sense: i64| {
                    let of = contact.planes.iter().filter(|known| (known.axis, known.sense) == (axis, sense));
                    of.map(|known| known.depth).max().unwrap_or(0).max(0)
                };
                let both = [0, 1, 2].map(|axis| [asked(axis, 1), asked(axis, -1)]);
                if both.iter().all(|[up, down]| *up == 0 || *down == 0) {
                    let way = both.map(|[up, down]| up - down);
                    let rest = contact
                        .planes
                        .iter()
                        .any(|known| known.depth <= 0 && known.depth + known.sense * -way[known.axis] > 0);
                    assert!(rest || contact.obstacles(0).is_free(&way), "{what}");
                    counts[usize::from(is_deep)] += 1;
                } else {
                    counts[2] += 1;
                }
            }
            assert!(counts[1] > 60, "{} {counts:?}", family.name);
        }
    }
}
