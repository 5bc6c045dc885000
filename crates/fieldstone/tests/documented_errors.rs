//! The errors in `docs/validation/overlap-kernel.md` against those of today.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use fieldstone::geometry::{Ball, CornerOrder, ElementKind, Orientation, Polyhedron, certified_overlap};
use fieldstone::io::CsvTable;
use fieldstone_testing::{data, read_text, repository};

/// What the document says of a family of cases.
#[derive(Debug, Default)]
struct Family {
    cases: usize,
    worst_volume: f64,
    /// Cases that took 64, 106, 256 bits.
    precisions: [usize; 3],
}

/// The first table: `overlap` and `certified_overlap`.
fn documented() -> BTreeMap<String, Family> {
    let page = read_text(&repository().join("docs/validation/overlap-kernel.md"));
    let table = page.lines().skip_while(|line| !line.starts_with("| family | cases |")).skip(2);
    table
        .take_while(|line| line.starts_with('|'))
        .map(|line| {
            let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
            let bits: Vec<usize> = cells[8].trim_matches(['[', ']']).split(", ").map(|n| n.parse().unwrap()).collect();
            let family = Family {
                cases: cells[1].parse().unwrap(),
                worst_volume: cells[3].parse().unwrap(),
                precisions: bits.try_into().unwrap(),
            };
            (cells[0].to_string(), family)
        })
        .collect()
}

fn measured() -> BTreeMap<String, Family> {
    let mut families = BTreeMap::<String, Family>::new();
    let kinds = [("tet", ElementKind::Tetrahedron), ("wedge", ElementKind::Wedge), ("hex", ElementKind::Hexahedron)];
    for (name, kind) in kinds {
        let table = CsvTable::read(&data(&format!("overlap-cases/{name}.csv.gz"))).unwrap();
        let column = |name: &str| table.column(name).unwrap();
        let (centre, radius, exact) = (["cx", "cy", "cz"].map(column), column("r"), column("vol_exact"));
        let corners: Vec<[Vec<f64>; 3]> = (0..kind.corner_count().unwrap())
            .map(|k| ["x", "y", "z"].map(|axis| column(&format!("{axis}{k}"))))
            .collect();
        for (row, (_, text)) in table.rows().enumerate() {
            let at = |columns: &[Vec<f64>; 3]| columns.each_ref().map(|column| column[row]);
            let points: Vec<[f64; 3]> = corners.iter().map(at).collect();
            let element = Polyhedron::element(kind, CornerOrder::Cgns, &points, Orientation::Refuse).unwrap();
            let ball = Ball::new(at(&centre), radius[row]).unwrap();
            let found = certified_overlap(&ball, &element);
            let error = (found.overlap.volume - exact[row]).abs() / ball.volume().min(element.volume());
            let family = families.entry(text.split(',').next().unwrap().into()).or_default();
            family.cases += 1;
            family.worst_volume = family.worst_volume.max(error);
            family.precisions[found.precision as usize] += 1;
        }
    }
    families
}

#[test]
fn the_documented_errors_and_digits_of_each_family_are_those_of_today() {
    let (documented, measured) = (documented(), measured());
    assert_eq!(documented.keys().collect::<Vec<_>>(), measured.keys().collect::<Vec<_>>());
    for (name, page) in &documented {
        let today = &measured[name];
        let says =
            format!("{name}: the page says {page:?}, and today it is {today:?}; print its tables anew as it says");
        assert_eq!(page.cases, today.cases, "{says}");
        // Sines and arc tangents of other systems differ in their last digits.
        let ratio = page.worst_volume / today.worst_volume;
        assert!((0.7..1.4).contains(&ratio), "{says}");
        let apart = page.precisions.iter().zip(today.precisions).map(|(a, b)| a.abs_diff(b)).max();
        assert!(apart <= Some(2), "{says}");
    }
}
