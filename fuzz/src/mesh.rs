//! Arrays of any content make a mock-up, a tool or a typed error; welding keeps every position.

use arbitrary::Arbitrary;
use feeler_core::{weld_vertices, DefectKind, Mockup, Point, Tool};

#[derive(Arbitrary, Debug)]
pub struct Case {
    vertices: Vec<Point>,
    faces: Vec<[u8; 3]>,
    parts: Vec<u8>,
    part_count: u8,
}

pub fn check(case: Case) {
    let (unique, index) = weld_vertices(&case.vertices);
    for (given, at) in case.vertices.iter().zip(&index) {
        let kept = unique[*at as usize];
        assert!((0..3).all(|a| given[a] == kept[a] || given[a].is_nan() && kept[a].is_nan()));
    }
    let faces: Vec<[u32; 3]> = case.faces.iter().map(|f| f.map(u32::from)).collect();
    let parts: Vec<u32> = case.parts.iter().map(|p| u32::from(*p)).collect();
    if let Ok(tool) = Tool::new(case.vertices.clone(), faces.clone()) {
        // Every triangle is queried or counted under exactly one reason.
        let excluded = DefectKind::ALL.iter().filter(|k| **k != DefectKind::Duplicate);
        let counted: usize = excluded.map(|k| tool.mesh().defects().of(*k).count).sum();
        assert_eq!(counted + tool.mesh().queried_count(), faces.len());
    }
    if let Ok(mockup) = Mockup::new(case.vertices, faces.clone(), parts, usize::from(case.part_count)) {
        assert_eq!(mockup.part_triangles().iter().sum::<u32>() as usize, faces.len());
    }
}
