//! Case files: what ships starts as it should, and what is wrong is named with its line.
#![allow(clippy::unwrap_used)]

use std::sync::atomic::{AtomicBool, Ordering};

use fieldstone_io::CsvTable;
use fieldstone_io::vtk::{read_pvd, read_vtk_particles};
use fieldstone_sph::{Case, Outcome, RunFolder, SHIPPED, Solver, SphError, run};

fn shipped(name: &str) -> Case {
    let case = SHIPPED.iter().find(|c| c.name == name).unwrap();
    Case::parse(case.text, name).unwrap()
}

fn free_surface(solver: &Solver) -> usize {
    solver.regions().iter().filter(|&&r| r == 0).count()
}

#[test]
fn the_papers_cases_start_with_its_free_surface_counts() {
    for (name, spacing, fluid, expected) in [
        ("double-dam-break", 0.04, 20 * 20 * 30 + 30 * 30 * 30, 4142),
        ("double-dam-break", 0.02, 40 * 40 * 60 + 60 * 60 * 60, 16_882),
        ("obstacle", 0.01, 40 * 60 * 30, 4140),
        ("obstacle", 0.005, 80 * 120 * 60, 16_680),
        ("dam-break", 0.02, 60 * 15 * 30, 60 * 15 + 29 * 15),
    ] {
        let solver = shipped(name).with_spacing(spacing).unwrap().solver().unwrap();
        assert_eq!((solver.state().len(), free_surface(&solver)), (fluid, expected), "{name} {spacing}");
    }
}

#[test]
fn every_shipped_case_makes_a_step() {
    for case in SHIPPED {
        // The large ones coarser, by what their bodies bear.
        let spacing = match case.name {
            "dam-break" | "dam-break-slab" => Some(0.03),
            "double-dam-break" => Some(0.1),
            "obstacle" => Some(0.02),
            "spheric-2" => Some(0.04),
            _ => None,
        };
        let parsed = shipped(case.name);
        let parsed = spacing.map_or(parsed.clone(), |dx| parsed.with_spacing(dx).unwrap());
        let mut solver = parsed.solver().unwrap_or_else(|e| panic!("{}: {e}", case.name));
        let dt = solver.step().unwrap_or_else(|e| panic!("{}: {e}", case.name));
        assert!(dt > 0.0 && solver.time() == dt);
    }
}

#[test]
fn what_is_wrong_is_named_with_file_line_and_remedy() {
    let good = shipped("hydrostatic").text().to_string();
    for (from, to, expected) in [
        ("density = 1000.0", "densitty = 1000.0", "c.toml:11: unknown field `densitty`, expected one of `density`"),
        ("density = 1000.0", "density = -1.0", "c.toml:11: the density is -1; it must be finite and above 0"),
        ("density = 1000.0", "density = nan", "c.toml:11: the density is NaN; it must be finite and above 0"),
        ("sound_speed = 44.3", "sound_speed = 4.0", "c.toml:12: the speed of sound is 4; for an expected pressure of"),
        ("spacing = 0.025", "spacing = 0", "c.toml:3: "),
        ("shape = \"box\"", "shape = \"cube\"", "c.toml:22: unknown variant `cube`, expected one of `box`"),
        ("high = [1.0, 0.5]", "high = [1.0, -0.5]", "c.toml:24: high is [1.0, -0.5]; it must be above low"),
        ("high = [1.0, 0.5]", "high = [1.1, 0.5]", "c.toml:22: the fill leaves the domain at"),
        ("open = [\"y+\"]", "open = [\"up\"]", "c.toml:8: 'up' is no face"),
        ("gravity = [0.0, -9.81]", "gravity = [0.0]", "c.toml:16: 1 numbers were found; give 2"),
        ("end = 10.0", "end = 10.0\ncfl = 7", "c.toml:20: the CFL number is 7; it must be above 0 and at most 4"),
        ("open = [\"y+\"]", "periodic = [\"z\"]", "c.toml:8: there is no z in two dimensions; give x or y"),
        ("open = [\"y+\"]", "periodic = [\"x\", \"x\"]", "c.toml:8: x is listed twice"),
        ("open = [\"y+\"]", "open = [\"y+\"]\nperiodic = [\"y\"]", "c.toml:9: y is periodic and has an open face"),
        (
            "spacing = 0.025",
            "spacing = 1e-9",
            "c.toml:3: a spacing of 0.000000001 makes about 5.0e17 particles, at most",
        ),
        ("expected_speed = 1.0", "expected_speed = inf", "expected_speed is inf; it must be finite and at least 0"),
        ("kind = \"tank\"", "kind = \"tank\"\npoint = [0, 0]", "a plane needs point and normal, a tank has neither"),
        (
            "shape = \"box\"",
            "shape = \"box\"\nradius = 3",
            "c.toml:23: radius does not go with shape = \"box\", which takes low, high",
        ),
        (
            "shape = \"box\"",
            "shape = \"box\"\nrate = 1",
            "c.toml:23: rate does not go with a uniform flow, which takes velocity",
        ),
        (
            "shape = \"box\"",
            "shape = \"box\"\nvelocity = [nan, 0]",
            "c.toml:23: velocity is [NaN, 0.0]; give 2 finite numbers",
        ),
        (
            "shape = \"box\"",
            "shape = \"box\"\nflow = \"taylor-green\"\nspeed = 1",
            "c.toml:23: this flow needs wavelength",
        ),
        (
            "pressure = \"hydrostatic\"",
            "pressure = \"hydro\"",
            "pressure is neither a number nor \"hydrostatic\" nor \"flow\"",
        ),
        ("pressure = \"hydrostatic\"", "pressure = nan", "pressure is NaN; it must be finite"),
        (
            "low = [0.0, 0.0]\nhigh = [1.0, 0.5]",
            "low = [0.0, 0.0, 0.0]\nhigh = [1.0, 0.5]",
            "low is [0.0, 0.0, 0.0]; give 2 finite numbers",
        ),
        ("kind = \"pressure\"", "kind = \"force\"", "at does not go with kind = \"force\", which takes body"),
        (
            "kind = \"pressure\"",
            "kind = \"pressure\"\nbody = 0",
            "body does not go with kind = \"pressure\", which takes at",
        ),
        ("end = 10.0", "end = 10.0\n[[gauge]]\nname = \"f\"\nkind = \"force\"\nbody = 2", "there are 0 bodies"),
        (
            "end = 10.0",
            "end = 10.0\n[[gauge]]\nname = \"f\"\nkind = \"front\"\naxis = \"z\"",
            "there is no z in two dimensions",
        ),
        (
            "end = 10.0",
            "end = 10.0\n[[gauge]]\nname = \"f\"\nkind = \"level\"\nat = [5.0, 0.0]",
            "at is [5.0, 0.0]; it must be in the domain",
        ),
        ("end = 10.0", "end = 10.0\n[[gauge]]\nname = \"time\"\nkind = \"front\"", "the name 'time' is taken"),
        ("end = 10.0", "end = 10.0\n[shifting]\ncap = 7", "c.toml:21: the largest shift over the spacing is 7"),
    ] {
        assert!(good.contains(from));
        let text = good.replacen(from, to, 1);
        let error = Case::parse(&text, "c.toml").and_then(|c| c.state()).unwrap_err().to_string();
        assert!(error.contains(expected) && error.starts_with("c.toml:"), "{error}\ninstead of {expected}");
    }
}

#[test]
fn a_body_that_is_too_thin_and_a_slab_that_is_too_narrow_are_refused() {
    let thin = shipped("obstacle").text().replace("high = [1.02, 0.36, 0.45]", "high = [0.92, 0.36, 0.45]");
    let error = Case::parse(&thin, "c.toml").unwrap_err().to_string();
    assert!(error.contains("thick along x; it must be at least 4 spacings"), "{error}");
    let narrow = shipped("dam-break-slab").with_spacing(0.06).unwrap_err().to_string();
    assert!(narrow.contains("the periodic faces along y are 0.18"), "{narrow}");
}

/// A dam break of half a second of computing, with outputs as given.
fn small(every: f64, end: f64) -> Case {
    let text = shipped("column-1-2").text().replace("spacing = 0.004", "spacing = 0.0146");
    let text =
        text.replace("every = 0.02\n", &format!("every = {every}\n")).replace("end = 0.5", &format!("end = {end}"));
    Case::parse(&text, "small.toml").unwrap()
}

fn final_checkpoint(folder: &RunFolder) -> Vec<u8> {
    std::fs::read(folder.checkpoint()).unwrap()
}

#[test]
fn an_interrupted_and_resumed_run_ends_with_the_same_bits_also_with_other_outputs() {
    let space = tempfile::tempdir().unwrap();
    let folder = |name: &str| RunFolder::create(&space.path().join(name)).unwrap();
    let never = AtomicBool::new(false);
    let whole = folder("whole");
    assert_eq!(run(&small(0.02, 0.3), &whole, false, &never, |_| ()).unwrap(), Outcome::Finished);
    // Stopped where lists are of any age, and more than once.
    let parts = folder("parts");
    let mut resume = false;
    for (steps, every) in [(7, 0.02), (23, 0.01), (40, 0.02)] {
        let stop = AtomicBool::new(false);
        let mut made = 0;
        let outcome = run(&small(every, 0.3), &parts, resume, &stop, |_| {
            made += 1;
            stop.store(made >= steps, Ordering::Relaxed);
        });
        assert_eq!(outcome.unwrap(), Outcome::Interrupted);
        resume = true;
    }
    assert_eq!(run(&small(0.02, 0.3), &parts, true, &never, |_| ()).unwrap(), Outcome::Finished);
    assert!(final_checkpoint(&whole) == final_checkpoint(&parts));
    // The table has no row twice and none is missing.
    let times = |folder: &RunFolder| CsvTable::read(&folder.gauges()).unwrap().column("time").unwrap();
    assert_eq!(times(&whole), times(&parts));
}

#[test]
fn the_series_holds_every_particle_and_a_resumed_run_can_go_on_to_a_later_end() {
    let space = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(space.path()).unwrap();
    let never = AtomicBool::new(false);
    run(&small(0.02, 0.05), &folder, false, &never, |_| ()).unwrap();
    run(&small(0.02, 0.1), &folder, true, &never, |_| ()).unwrap();
    let series = read_pvd(&folder.series()).unwrap();
    assert_eq!(series.len(), 6);
    assert!(series.iter().enumerate().all(|(n, (t, _))| *t >= 0.02 * n as f64 - 1e-12 && *t < 0.02 * n as f64 + 0.002));
    for (_, file) in &series {
        let particles = read_vtk_particles(&space.path().join(file.file_name().unwrap())).unwrap();
        assert_eq!(particles.len(), 200);
        assert!(particles.ids().unwrap().iter().enumerate().all(|(n, &id)| id == n as i64));
        assert_eq!(particles.quantity("velocity").unwrap().components, 3);
    }
    let table = CsvTable::read(&folder.gauges()).unwrap();
    let front = table.column("front").unwrap();
    assert!((front[0] - 0.146).abs() < 1e-12 && front.windows(2).all(|w| w[1] > w[0] - 1e-9));
    assert!(front[front.len() - 1] > 0.16);
}

#[test]
fn damaged_and_foreign_checkpoints_are_refused() {
    let space = tempfile::tempdir().unwrap();
    let path = space.path().join("checkpoint.bin");
    let case = small(0.02, 0.1);
    let mut solver = case.solver().unwrap();
    solver.step().unwrap();
    solver.write_checkpoint(&path).unwrap();
    let good = std::fs::read(&path).unwrap();
    assert!(Solver::read_checkpoint(&path, case.flow().unwrap()).is_ok());
    let mut other = case.flow().unwrap();
    other.fluid.delta = 0.2;
    let message = Solver::read_checkpoint(&path, other).unwrap_err().to_string();
    assert!(message.contains("belongs to another flow"), "{message}");
    for at in [0, 7, 13, 20, good.len() / 2, good.len() - 1] {
        let mut bad = good.clone();
        bad[at] ^= 4;
        std::fs::write(&path, &bad).unwrap();
        assert!(Solver::read_checkpoint(&path, case.flow().unwrap()).is_err(), "byte {at}");
    }
    std::fs::write(&path, &good[..good.len() - 8]).unwrap();
    assert!(Solver::read_checkpoint(&path, case.flow().unwrap()).is_err());
}

#[test]
fn a_run_that_breaks_names_the_particle_and_keeps_the_last_good_checkpoint() {
    let space = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(space.path()).unwrap();
    let never = AtomicBool::new(false);
    run(&small(0.02, 0.02), &folder, false, &never, |_| ()).unwrap();
    let good = final_checkpoint(&folder);
    // Closed on the right, with no wall there: the fluid runs out of the domain.
    let text =
        small(0.02, 1.0).text().replace("kind = \"tank\"", "kind = \"plane\"\npoint = [0.0, 0.0]\nnormal = [0.0, 1.0]");
    let text = text.replace("high = [0.584, 0.6]", "high = [0.2, 0.6]");
    let case = Case::parse(&text, "leak.toml").unwrap();
    let error = run(&case, &folder, false, &never, |_| ()).unwrap_err();
    assert!(matches!(error, SphError::Lost { .. }), "{error}");
    assert!(error.to_string().contains("has left the domain at"), "{error}");
    assert!(final_checkpoint(&folder) == good);
    assert!(space.path().join("failure.vtp").exists());
}
