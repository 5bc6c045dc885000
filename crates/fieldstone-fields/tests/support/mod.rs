//! Real particles and contacts, read by the few lines that a test needs.
#![allow(dead_code)]

use std::collections::HashMap;
use std::path::Path;

use fieldstone_particles::{Contact, Contacts, Domain, Particles, Partner, Quantity};
use fieldstone_testing::{extended, read_text};

/// A frame with its contacts.
pub struct Case {
    pub name: &'static str,
    pub particles: Particles,
    pub contacts: Contacts,
    pub domain: Domain,
    /// Density of the particles' material.
    pub density: Option<f64>,
}

fn numbers(line: &str) -> Vec<f64> {
    line.split_whitespace().map(|x| x.parse().unwrap()).collect()
}

fn quantity(name: &str, components: usize, data: Vec<f64>) -> Quantity {
    Quantity { name: name.into(), components, data }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// A small packing that is always there, and the real ones where their files are.
pub fn cases() -> Vec<Case> {
    let real = [mercury_box(), liggghts_chute(), lammps_pack()];
    std::iter::once(sheared_layer()).chain(real.into_iter().flatten()).collect()
}

/// 288 balls on a floor, periodic in x and y, sheared along x, with springs and friction in 600 contacts or more.
///
/// Sites of a cubic lattice 6 × 6 × 8, each moved by up to 0.1 of its spacing; radii of 0.48 to 0.58 spacings. Where two
/// overlap, or one and the floor z = 0, they push each other apart with 100 times the depth, and rub with up to a third of
/// that across. Not at rest: the identities hold for any forces.
pub fn sheared_layer() -> Case {
    let counts = [6, 6, 8];
    let mut seed = 20_240_229u64;
    // The upper bits of a linear congruential generator, in −1…1.
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let (mut positions, mut radii, mut velocities, mut spins) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for site in 0..counts.iter().product() {
        let at = [site % counts[0], site / counts[0] % counts[1], site / (counts[0] * counts[1])];
        let position: [f64; 3] = at.map(|k| k as f64 + 0.5 + 0.1 * random());
        velocities.extend([0.3 * position[2] + 0.1 * random(), 0.1 * random(), 0.1 * random()]);
        spins.extend([random(), 0.15 + random(), random()]);
        radii.push(0.53 + 0.05 * random());
        positions.push(position);
    }
    let domain = Domain::new([0.0; 3], counts.map(|n| n as f64), [true, true, false]).unwrap();
    let mut contacts = Contacts::new();
    let mut push = |i: usize, partner: Partner, reach: f64, branch: [f64; 3], share: f64| {
        let distance = branch.iter().map(|b| b * b).sum::<f64>().sqrt();
        if distance >= reach {
            return;
        }
        let normal = branch.map(|b| b / distance);
        let push = 100.0 * (reach - distance);
        let rub: [f64; 3] = std::array::from_fn(|_| push / 3.0 * random() / 3f64.sqrt());
        let along: f64 = (0..3).map(|k| rub[k] * normal[k]).sum();
        let force = std::array::from_fn(|k| -push * normal[k] + rub[k] - along * normal[k]);
        let arm = branch.map(|b| share * b);
        contacts.push(positions.len(), Contact { particle: i as u32, partner, force, arm, branch }).unwrap();
    };
    for i in 0..positions.len() {
        for j in i + 1..positions.len() {
            let branch = domain.minimum_image(minus(positions[j], positions[i]));
            push(i, Partner::Particle(j as u32), radii[i] + radii[j], branch, radii[i] / (radii[i] + radii[j]));
        }
        push(i, Partner::Wall(0), radii[i], [0.0, 0.0, -positions[i][2]], 1.0);
    }
    assert!(contacts.len() > 600, "{}", contacts.len());
    let particles = Particles::new(positions).unwrap().with_radii(radii).unwrap();
    let particles = particles.with_quantity(quantity("velocity", 3, velocities)).unwrap();
    let particles = particles.with_quantity(quantity("angular_velocity", 3, spins)).unwrap();
    Case { name: "sheared-layer", particles, contacts, domain, density: Some(2.0) }
}

/// The last frame of MercuryDPM's box.
pub fn mercury_box() -> Option<Case> {
    let folder = extended("mercury-box")?;
    let data = read_text(&folder.join("box1000.data.gz"));
    let lines: Vec<&str> = data.lines().collect();
    let rows: Vec<Vec<f64>> = lines[lines.len() - 1000..].iter().map(|l| numbers(l)).collect();
    let positions: Vec<[f64; 3]> = rows.iter().map(|r| [r[0], r[1], r[2]]).collect();
    let density = 1.909_859_317_102_74;
    let particles = Particles::new(positions.clone())
        .unwrap()
        .with_radii(rows.iter().map(|r| r[6]).collect())
        .unwrap()
        .with_quantity(quantity("velocity", 3, rows.iter().flat_map(|r| r[3..6].to_vec()).collect()))
        .unwrap()
        .with_quantity(quantity("angular_velocity", 3, rows.iter().flat_map(|r| r[10..13].to_vec()).collect()))
        .unwrap();
    let text = read_text(&folder.join("box1000.fstat.gz"));
    let last = text.rfind("\n# 10 ").unwrap();
    let mut contacts = Contacts::new();
    for line in text[last..].lines().filter(|l| !l.is_empty() && !l.starts_with('#')) {
        let r = numbers(line);
        let (i, j) = (r[1] as usize, r[2] as i64);
        let point = [r[3], r[4], r[5]];
        let force: [f64; 3] = std::array::from_fn(|k| r[8] * r[10 + k] + r[9] * r[13 + k]);
        let arm = minus(point, positions[i]);
        if j < 0 {
            let contact =
                Contact { particle: i as u32, partner: Partner::Wall(-j), force: force.map(|f| -f), arm, branch: arm };
            contacts.push(1000, contact).unwrap();
        } else if i < j as usize {
            let branch = minus(positions[j as usize], positions[i]);
            let partner = Partner::Particle(j as u32);
            contacts.push(1000, Contact { particle: i as u32, partner, force, arm, branch }).unwrap();
        }
    }
    let domain = Domain::new([0.0; 3], [11.2, 11.2, 13.2], [false; 3]).unwrap();
    Some(Case { name: "mercury-box", particles, contacts, domain, density: Some(density) })
}

struct Dump {
    columns: HashMap<String, usize>,
    rows: Vec<Vec<f64>>,
    bounds: [[f64; 2]; 3],
}

fn dump(path: &Path) -> Dump {
    let text = read_text(path);
    let mut lines = text.lines();
    let mut bounds = [[0.0; 2]; 3];
    let mut columns = HashMap::new();
    for line in lines.by_ref() {
        if let Some(names) = line.strip_prefix("ITEM: ATOMS ").or(line.strip_prefix("ITEM: ENTRIES ")) {
            columns = names.split_whitespace().enumerate().map(|(k, n)| (n.to_string(), k)).collect();
            break;
        }
        let row: Vec<f64> = line.split_whitespace().filter_map(|x| x.parse().ok()).collect();
        if row.len() == 2 {
            let k = bounds.iter().position(|b| b == &[0.0; 2]).unwrap();
            bounds[k] = [row[0], row[1]];
        }
    }
    // The last columns of a wall dump can be what memory held: not even always numbers.
    let rows = lines.map(|l| l.split_whitespace().map(|x| x.parse().unwrap_or(f64::NAN)).collect()).collect();
    Dump { columns, rows, bounds }
}

impl Dump {
    fn get(&self, row: usize, name: &str) -> f64 {
        self.rows[row][self.columns[name]]
    }

    fn vector(&self, names: [&str; 3]) -> Vec<f64> {
        (0..self.rows.len()).flat_map(|row| names.map(|n| self.get(row, n))).collect()
    }

    fn particles(&self) -> (Particles, HashMap<i64, usize>) {
        let n = self.rows.len();
        let scalar = |name: &str| (0..n).map(|row| self.get(row, name)).collect::<Vec<f64>>();
        let positions = (0..n).map(|row| ["x", "y", "z"].map(|c| self.get(row, c))).collect();
        let ids: Vec<i64> = scalar("id").iter().map(|&x| x as i64).collect();
        let places = ids.iter().enumerate().map(|(k, &id)| (id, k)).collect();
        let mut particles = Particles::new(positions)
            .unwrap()
            .with_radii(scalar("radius"))
            .unwrap()
            .with_ids(ids)
            .unwrap()
            .with_types(scalar("type").iter().map(|&x| x as i64).collect())
            .unwrap()
            .with_quantity(quantity("velocity", 3, self.vector(["vx", "vy", "vz"])))
            .unwrap();
        for (name, columns) in [("force", ["fx", "fy", "fz"]), ("angular_velocity", ["omegax", "omegay", "omegaz"])] {
            if self.columns.contains_key(columns[0]) {
                particles = particles.with_quantity(quantity(name, 3, self.vector(columns))).unwrap();
            }
        }
        if self.columns.contains_key("mass") {
            particles = particles.with_quantity(quantity("mass", 1, scalar("mass"))).unwrap();
        }
        (particles, places)
    }

    fn domain(&self, periodic: [bool; 3]) -> Domain {
        Domain::new(self.bounds.map(|b| b[0]), self.bounds.map(|b| b[1]), periodic).unwrap()
    }
}

/// LIGGGHTS's chute, periodic in x and y.
pub fn liggghts_chute() -> Option<Case> {
    let folder = extended("liggghts-chute")?;
    let part = dump(&folder.join("oracle_part.26001.dump.gz"));
    let domain = part.domain([true, true, false]);
    let (particles, places) = part.particles();
    let x = particles.positions();
    let mut contacts = Contacts::new();
    let pairs = dump(&folder.join("oracle_pair.26001.dump.gz"));
    for r in &pairs.rows {
        let (i, j) = (places[&(r[12] as i64)], places[&(r[13] as i64)]);
        let force = [r[15], r[16], r[17]];
        let branch = domain.minimum_image(minus(x[j], x[i]));
        let arm = domain.minimum_image(minus([r[32], r[33], r[34]], x[i]));
        let contact = Contact { particle: i as u32, partner: Partner::Particle(j as u32), force, arm, branch };
        contacts.push(x.len(), contact).unwrap();
    }
    let walls = dump(&folder.join("oracle_wall.26001.dump.gz"));
    for r in &walls.rows {
        let i = places[&(r[14] as i64)];
        let force = [r[15], r[16], r[17]];
        let arm = domain.minimum_image(minus([r[0], r[1], r[2]], x[i]));
        let contact = Contact { particle: i as u32, partner: Partner::Wall(r[12] as i64), force, arm, branch: arm };
        contacts.push(x.len(), contact).unwrap();
    }
    Some(Case { name: "liggghts-chute", particles, contacts, domain, density: None })
}

/// A frame of LAMMPS's grains, periodic in x and y.
pub fn lammps_pack() -> Option<Case> {
    let folder = extended("lammps-pack")?;
    let part = dump(&folder.join("part.4500.dump.gz"));
    let domain = part.domain([true, true, false]);
    let (particles, places) = part.particles();
    let x = particles.positions();
    let radii = particles.radii().unwrap();
    let mut contacts = Contacts::new();
    let pairs = dump(&folder.join("pair.4500.dump.gz"));
    for row in 0..pairs.rows.len() {
        let get = |name: &str| pairs.get(row, name);
        let (i, j) = (places[&(get("c_pl[1]") as i64)], places[&(get("c_pl[2]") as i64)]);
        // Normal force, and the tangential one apart.
        let normal = ["c_fl[3]", "c_fl[4]", "c_fl[5]"].map(get);
        let tangential = ["c_fl[6]", "c_fl[7]", "c_fl[8]"].map(get);
        let force = std::array::from_fn(|k| normal[k] + tangential[k]);
        let branch = domain.minimum_image(minus(x[j], x[i]));
        let share = radii[i] / (radii[i] + radii[j]);
        let arm = branch.map(|b| share * b);
        let contact = Contact { particle: i as u32, partner: Partner::Particle(j as u32), force, arm, branch };
        contacts.push(x.len(), contact).unwrap();
    }
    for i in 0..x.len() {
        let w = |k: usize| part.get(i, &format!("f_w[{k}]"));
        if w(1) == 0.0 {
            continue;
        }
        let arm = minus([w(5), w(6), w(7)], x[i]);
        let force = [w(2), w(3), w(4)];
        contacts
            .push(x.len(), Contact { particle: i as u32, partner: Partner::Wall(0), force, arm, branch: arm })
            .unwrap();
    }
    Some(Case { name: "lammps-pack", particles, contacts, domain, density: None })
}

/// The spheres in a cylinder, and the pairs among them; walls were not written.
pub fn packed_cylinder() -> Option<Case> {
    let folder = extended("packed-cylinder")?;
    let part = dump(&folder.join("packed.dump.gz"));
    let domain = part.domain([false; 3]);
    let (particles, places) = part.particles();
    let x = particles.positions();
    let radii = particles.radii().unwrap();
    let mut contacts = Contacts::new();
    let pairs = dump(&folder.join("contacts.dump.gz"));
    for r in &pairs.rows {
        let (i, j) = (places[&(r[0] as i64)], places[&(r[1] as i64)]);
        let force = std::array::from_fn(|k| r[2 + k] + r[5 + k]);
        let branch = minus(x[j], x[i]);
        let share = radii[i] / (radii[i] + radii[j]);
        let arm = branch.map(|b| share * b);
        contacts
            .push(x.len(), Contact { particle: i as u32, partner: Partner::Particle(j as u32), force, arm, branch })
            .unwrap();
    }
    let density = particles.quantity("mass").is_err().then_some(2500.0);
    Some(Case { name: "packed-cylinder", particles, contacts, domain, density })
}

/// Rows of MercuryCG's output: the columns after time and coordinates.
pub fn stat(path: &Path, coordinates: usize) -> Vec<Vec<f64>> {
    read_text(path).lines().skip(2).map(|l| numbers(l)[1 + coordinates..].to_vec()).collect()
}
