//! Which columns of a table of contacts hold what.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::IoError;
use crate::lines::{integer, number, shown};

/// Which columns of a dump or table hold the parts of a contact, by their names.
///
/// As text: `id1=c_pair[13],id2=c_pair[14],force=c_pair[16..18],point=c_pair[33..35]`. Three columns are a range in
/// brackets, or three names between slashes: `force=fx/fy/fz`.
///
/// | part | columns | meaning |
/// |---|---|---|
/// | `id1` | 1 | particle that the force acts on |
/// | `id2` | 1 | its partner; empty or negative for a wall; left out where all rows are walls |
/// | `wall` | 1 | number of the wall |
/// | `position1`, `position2` | 3 | centres of the two, in place of ids |
/// | `force` | 3 | the force on the first particle |
/// | `normal`, `tangential` | 3 | its two parts, in place of `force` |
/// | `point` | 3 | contact point |
/// | `overlap` | 1 | overlap, where there is no contact point |
///
/// Without `point` and `overlap` the spheres' radii and centres say where they touch.
///
/// ```
/// use fieldstone_io::ContactColumns;
/// let columns: ContactColumns = "id1=c_id[1],id2=c_id[2],normal=c_c[2..4],tangential=c_c[5..7]".parse()?;
/// assert_eq!(columns.normal.as_ref().map(|names| names[2].as_str()), Some("c_c[4]"));
/// # Ok::<(), fieldstone_io::IoError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContactColumns {
    /// Id of the particle that the force acts on.
    pub id1: Option<String>,
    /// Id of its partner.
    pub id2: Option<String>,
    /// Number of the wall.
    pub wall: Option<String>,
    /// Centre of the first particle, in place of its id.
    pub position1: Option<[String; 3]>,
    /// Centre of the second particle, in place of its id.
    pub position2: Option<[String; 3]>,
    /// Force on the first particle.
    pub force: Option<[String; 3]>,
    /// Normal part of the force.
    pub normal: Option<[String; 3]>,
    /// Tangential part of the force.
    pub tangential: Option<[String; 3]>,
    /// Contact point.
    pub point: Option<[String; 3]>,
    /// Overlap of the two spheres.
    pub overlap: Option<String>,
}

const PARTS: &str = "id1, id2, wall, position1, position2, force, normal, tangential, point, overlap";

impl FromStr for ContactColumns {
    type Err = IoError;

    fn from_str(text: &str) -> Result<Self, IoError> {
        let wrong = IoError::ContactColumns;
        let mut columns = Self::default();
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let Some((key, value)) = part.split_once('=') else {
                return Err(wrong(format!("'{part}' is not of the form part=column; the parts are {PARTS}")));
            };
            let (key, value) = (key.trim(), value.trim());
            let scalar = match key {
                "id1" => Some(&mut columns.id1),
                "id2" => Some(&mut columns.id2),
                "wall" => Some(&mut columns.wall),
                "overlap" => Some(&mut columns.overlap),
                _ => None,
            };
            if let Some(slot) = scalar {
                if value.is_empty() || value.contains("..") {
                    return Err(wrong(format!("'{part}': {key} is one column")));
                }
                *slot = Some(value.into());
                continue;
            }
            let slot = match key {
                "position1" => &mut columns.position1,
                "position2" => &mut columns.position2,
                "force" => &mut columns.force,
                "normal" => &mut columns.normal,
                "tangential" => &mut columns.tangential,
                "point" => &mut columns.point,
                _ => return Err(wrong(format!("'{key}' is no part of a contact; the parts are {PARTS}"))),
            };
            *slot = Some(three(value).ok_or_else(|| {
                wrong(format!("'{part}': {key} is three columns, as in {key}=c_pair[16..18] or {key}=fx/fy/fz"))
            })?);
        }
        columns.check()?;
        Ok(columns)
    }
}

/// `name[1..3]` or `a/b/c`.
fn three(text: &str) -> Option<[String; 3]> {
    if let Some((name, range)) = text.strip_suffix(']').and_then(|rest| rest.rsplit_once('['))
        && let Some((first, last)) = range.split_once("..")
    {
        let (first, last): (usize, usize) = (first.parse().ok()?, last.parse().ok()?);
        return (first.checked_add(2) == Some(last)).then(|| numbered(name, first));
    }
    let names: Vec<&str> = text.split('/').map(str::trim).collect();
    let [x, y, z] = names.as_slice() else { return None };
    (!names.contains(&"")).then(|| [x, y, z].map(ToString::to_string))
}

/// `name[first]` and the two columns after it.
fn numbered(name: &str, first: usize) -> [String; 3] {
    [0, 1, 2].map(|k| format!("{name}[{}]", first + k))
}

impl ContactColumns {
    /// Checks that the parts make a contact.
    ///
    /// # Errors
    /// [`IoError::ContactColumns`]: what is missing or given twice.
    pub fn check(&self) -> Result<(), IoError> {
        let wrong = match (&self.force, &self.normal, &self.tangential) {
            _ if self.id1.is_none() && self.position1.is_none() => {
                "the particle is missing: give its id (id1) or its centre (position1)"
            }
            _ if self.id1.is_some() && self.position1.is_some() => {
                "the particle is given twice: leave out id1 or position1"
            }
            _ if self.id2.is_some() && self.position2.is_some() => {
                "the partner is given twice: leave out id2 or position2"
            }
            (Some(_), None, None) | (None, Some(_), _) => return Ok(()),
            (None, None, _) => "the force is missing: give it whole (force), or in parts (normal and tangential)",
            _ => "the force is given twice: leave out force, or both normal and tangential",
        };
        Err(IoError::ContactColumns(wrong.into()))
    }

    /// The order that LIGGGHTS's `compute pair/gran/local` has.
    pub(crate) fn liggghts_pair(names: &[String]) -> Result<Self, String> {
        let (base, count) = only_array(names, 18)?;
        Ok(Self {
            id1: Some(format!("{base}[13]")),
            id2: Some(format!("{base}[14]")),
            force: Some(numbered(base, 16)),
            // History values stand before it, and how many there are depends on the contact model.
            point: (count == 35).then(|| numbered(base, 33)),
            ..Self::default()
        })
    }

    /// The order that LIGGGHTS's `compute wall/gran/local` has.
    pub(crate) fn liggghts_wall(names: &[String]) -> Result<Self, String> {
        let (base, _) = only_array(names, 18)?;
        Ok(Self {
            id1: Some(format!("{base}[15]")),
            wall: Some(format!("{base}[13]")),
            force: Some(numbered(base, 16)),
            point: Some(numbered(base, 1)),
            ..Self::default()
        })
    }

    /// LAMMPS's `compute property/local patom1 patom2` beside `compute pair/local dist [force] fx fy fz p1 p2 p3 …`.
    pub(crate) fn lammps_pair(names: &[String]) -> Result<Self, String> {
        let arrays = arrays(names);
        let ids: Vec<_> = arrays.iter().filter(|(_, members)| members == &[1, 2]).collect();
        let forces: Vec<_> = arrays.iter().filter(|(_, members)| members.last() >= Some(&7)).collect();
        let ([(ids, _)], [(forces, members)]) = (ids.as_slice(), forces.as_slice()) else {
            return Err(format!(
                "an array of two ids (property/local patom1 patom2) and one of forces (pair/local dist force fx fy fz p1 \
                 p2 p3) are expected among the columns {}",
                names.join(" ")
            ));
        };
        // Without `force` everything after the distance stands one column further left.
        let first = if members.last() >= Some(&8) { 3 } else { 2 };
        Ok(Self {
            id1: Some(format!("{ids}[1]")),
            id2: Some(format!("{ids}[2]")),
            normal: Some(numbered(forces, first)),
            tangential: Some(numbered(forces, first + 3)),
            ..Self::default()
        })
    }

    /// What a table's header row says by common names.
    pub(crate) fn of_table(names: &[String]) -> Result<Self, String> {
        let find = |wanted: &str| names.iter().find(|name| name.eq_ignore_ascii_case(wanted)).cloned();
        let any = |aliases: &[&str]| aliases.iter().find_map(|alias| find(alias));
        let triple = |sets: &[[&str; 3]]| sets.iter().find_map(|[x, y, z]| Some([find(x)?, find(y)?, find(z)?]));
        let mut columns = Self {
            id1: any(&["id1", "id_1", "id_i", "i", "particle"]),
            id2: any(&["id2", "id_2", "id_j", "j", "partner"]),
            wall: any(&["wall"]),
            force: triple(&[["fx", "fy", "fz"], ["force_x", "force_y", "force_z"], ["force:0", "force:1", "force:2"]]),
            point: triple(&[
                ["cx", "cy", "cz"],
                ["px", "py", "pz"],
                ["point_x", "point_y", "point_z"],
                ["point:0", "point:1", "point:2"],
                ["x", "y", "z"],
            ]),
            overlap: any(&["overlap", "delta"]),
            ..Self::default()
        };
        if columns.id1.is_none() {
            columns.id2 = None;
            columns.position1 = triple(&[["x1", "y1", "z1"], ["xi", "yi", "zi"]]);
            columns.position2 = triple(&[["x2", "y2", "z2"], ["xj", "yj", "zj"]]);
        }
        if columns.force.is_none() {
            columns.normal = triple(&[["fnx", "fny", "fnz"]]);
            columns.tangential = triple(&[["ftx", "fty", "ftz"]]);
        }
        columns.check().map_err(|missing| {
            format!("{missing}; columns called id1 id2 fx fy fz cx cy cz are expected among {}", names.join(" "))
        })?;
        Ok(columns)
    }
}

/// Arrays `name[k]` among the columns, with their members in rising order.
fn arrays(names: &[String]) -> Vec<(&str, Vec<usize>)> {
    let mut found: Vec<(&str, Vec<usize>)> = Vec::new();
    for name in names {
        let Some((base, index)) = name.strip_suffix(']').and_then(|rest| rest.rsplit_once('[')) else { continue };
        let Ok(index) = index.parse() else { continue };
        match found.iter_mut().find(|(known, _)| *known == base) {
            Some((_, members)) => members.push(index),
            None => found.push((base, vec![index])),
        }
    }
    for (_, members) in &mut found {
        members.sort_unstable();
    }
    found
}

/// The only array with all of the columns 1 to `least`, and how many it has.
fn only_array(names: &[String], least: usize) -> Result<(&str, usize), String> {
    let all = arrays(names);
    let complete: Vec<_> = all.iter().filter(|(_, m)| m.iter().take(least).copied().eq(1..=least)).collect();
    match complete.as_slice() {
        [(base, members)] => Ok((base, members.len())),
        found => Err(format!(
            "one array with columns name[1] to name[{least}] is expected, {} are there among the columns {}",
            found.len(),
            names.join(" ")
        )),
    }
}

/// Where a value of a row goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Slot {
    Id(usize),
    Number(usize),
}

/// Numbers of one row: what the mapping asks for, and no more.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ContactValues {
    /// First particle, second particle, wall.
    pub(crate) ids: [Option<i64>; 3],
    pub(crate) position1: [f64; 3],
    pub(crate) position2: Option<[f64; 3]>,
    pub(crate) force: [f64; 3],
    pub(crate) normal: Option<[f64; 3]>,
    pub(crate) point: Option<[f64; 3]>,
    pub(crate) overlap: Option<f64>,
}

/// [`ContactColumns`] found among the names of a file.
#[derive(Debug, Clone)]
pub(crate) struct ResolvedColumns {
    mapping: ContactColumns,
    /// Columns to read in the order in which they stand.
    slots: Vec<(usize, Slot)>,
    names: Vec<String>,
}

/// Numbers of all parts, one after the other.
const NUMBERS: usize = 19;

impl ResolvedColumns {
    /// # Errors
    /// Which columns are missing, and which there are.
    pub(crate) fn new(mapping: ContactColumns, names: Vec<String>) -> Result<Self, String> {
        mapping.check().map_err(|wrong| wrong.to_string())?;
        let scalars = [(&mapping.id1, Slot::Id(0)), (&mapping.id2, Slot::Id(1)), (&mapping.wall, Slot::Id(2))];
        let mut wanted: Vec<(&String, Slot)> =
            scalars.into_iter().filter_map(|(n, s)| Some((n.as_ref()?, s))).collect();
        let triples = [
            &mapping.position1,
            &mapping.position2,
            &mapping.force,
            &mapping.normal,
            &mapping.tangential,
            &mapping.point,
        ];
        for (start, triple) in triples.into_iter().enumerate() {
            for (k, name) in triple.iter().flatten().enumerate() {
                wanted.push((name, Slot::Number(3 * start + k)));
            }
        }
        wanted.extend(mapping.overlap.as_ref().map(|name| (name, Slot::Number(NUMBERS - 1))));
        let mut slots = Vec::new();
        let mut missing = Vec::new();
        for (name, slot) in wanted {
            match names.iter().position(|n| n == name) {
                Some(column) => slots.push((column, slot)),
                None => missing.push(name.as_str()),
            }
        }
        if !missing.is_empty() {
            return Err(format!("no column {}; the columns are {}", missing.join(", "), names.join(" ")));
        }
        slots.sort_by_key(|&(column, _)| column);
        Ok(Self { mapping, slots, names })
    }

    /// Reads what is needed of a row; what stands beyond the last column needed is not looked at, since some programs
    /// leave garbage there.
    ///
    /// # Errors
    /// What was found, as a sentence.
    pub(crate) fn read<'a>(&self, mut fields: impl Iterator<Item = &'a [u8]>) -> Result<ContactValues, String> {
        let mut values = ContactValues::default();
        let mut numbers = [0.0; NUMBERS];
        let mut empty = [false; NUMBERS];
        let mut at = 0;
        let mut field: &[u8] = &[];
        for &(column, slot) in &self.slots {
            while at <= column {
                field = fields.next().ok_or_else(|| {
                    format!("the row has {at} columns; {} are expected: {}", self.names.len(), self.names.join(" "))
                })?;
                at += 1;
            }
            let name = || format!("column {} '{}'", column + 1, self.names[column]);
            match slot {
                Slot::Id(which) => {
                    values.ids[which] = match integer(field) {
                        Some(id) => Some(id),
                        None if field.is_empty() && which > 0 => None,
                        None => return Err(format!("{} holds '{}', which is no integer", name(), shown(field))),
                    };
                }
                Slot::Number(which) if field.is_empty() => {
                    // Walls have no second particle, and some contacts no point.
                    if !(3..6).contains(&which) && which < 15 {
                        return Err(format!("{} is empty", name()));
                    }
                    empty[which] = true;
                }
                Slot::Number(which) => match number(field) {
                    Some(value) if value.is_finite() => numbers[which] = value,
                    Some(value) => return Err(format!("{} is {value}; only finite numbers are accepted", name())),
                    None => return Err(format!("{} holds '{}', which is no number", name(), shown(field))),
                },
            }
        }
        let triple = |start: usize| [numbers[start], numbers[start + 1], numbers[start + 2]];
        let present = |part: &Option<[String; 3]>, start: usize| {
            (part.is_some() && !empty[start..start + 3].contains(&true)).then(|| triple(start))
        };
        values.position1 = triple(0);
        values.position2 = present(&self.mapping.position2, 3);
        values.normal = present(&self.mapping.normal, 9);
        values.force = std::array::from_fn(|k| numbers[6 + k] + (numbers[9 + k] + numbers[12 + k]));
        values.point = present(&self.mapping.point, 15);
        values.overlap = (self.mapping.overlap.is_some() && !empty[NUMBERS - 1]).then_some(numbers[NUMBERS - 1]);
        Ok(values)
    }

    /// Whether particles are named by id.
    pub(crate) fn by_id(&self) -> bool {
        self.mapping.id1.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_of_other_than_three_columns_is_refused() {
        for bad in
            ["force=c[1..2]", "force=c[1..4]", "force=c[3..1]", "force=fx/fy", "force=c[18446744073709551615..2]"]
        {
            let error = format!("id1=a,{bad}").parse::<ContactColumns>().unwrap_err();
            assert!(error.to_string().contains("three columns"), "{bad}: {error}");
        }
    }

    #[test]
    fn parts_that_are_unknown_missing_or_given_twice_are_named() {
        for (text, reason) in [
            ("id1=a,strength=c[1..3]", "'strength' is no part"),
            ("id1=a", "the force is missing"),
            ("force=c[1..3]", "the particle is missing"),
            ("id1=a,force=c[1..3],normal=c[4..6]", "the force is given twice"),
            ("id1=a,position1=x/y/z,force=c[1..3]", "the particle is given twice"),
            ("id1=c[1..3],force=c[1..3]", "id1 is one column"),
            ("id1", "not of the form"),
        ] {
            let error = text.parse::<ContactColumns>().unwrap_err();
            assert!(error.to_string().contains(reason), "{text}: {error}");
        }
    }

    #[test]
    fn without_the_column_force_those_of_pair_local_stand_one_further_left() {
        let names = |text: &str| text.split(' ').map(String::from).collect::<Vec<_>>();
        let c = ContactColumns::lammps_pair(&names("c_id[1] c_id[2] c_c[2] c_c[3] c_c[4] c_c[5] c_c[6] c_c[7]"));
        assert_eq!(c.unwrap().tangential, Some(numbered("c_c", 5)));
        let c = ContactColumns::lammps_pair(&names("index c_p[1] c_p[2] c_f[1] c_f[2] c_f[3] c_f[4] c_f[5] c_f[8]"));
        assert_eq!(c.unwrap().normal, Some(numbered("c_f", 3)));
    }
}
