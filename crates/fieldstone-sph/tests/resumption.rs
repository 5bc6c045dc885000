//! Runs that were stopped: they go on with the same bits, and nothing of what they have written is lost.
#![allow(clippy::unwrap_used)]

use std::sync::atomic::{AtomicBool, Ordering};

use fieldstone_io::CsvTable;
use fieldstone_io::vtk::{read_pvd, read_vtk_particles};
use fieldstone_sph::{Case, Outcome, RunFolder, SHIPPED, Solver, SphError, run};

fn shipped(name: &str) -> Case {
    SHIPPED.iter().find(|c| c.name == name).unwrap().at_spacing(None).unwrap()
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
    // What was written before keeps its name, with another version.
    let mut old = good.clone();
    old[7] = 6;
    std::fs::write(&path, &old).unwrap();
    let message = Solver::read_checkpoint(&path, case.flow().unwrap()).unwrap_err().to_string();
    assert!(message.contains("the checkpoint has format 6, this program reads 7 only: go on with"), "{message}");
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
    // The next start removes it.
    run(&small(0.02, 0.03), &folder, true, &never, |_| ()).unwrap();
    assert!(!space.path().join("failure.vtp").exists());
}

#[test]
fn no_file_of_the_series_is_written_over_by_a_run_with_another_cadence() {
    let space = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(space.path()).unwrap();
    let never = AtomicBool::new(false);
    for (every, end, resume) in [(0.01, 0.05, false), (0.025, 0.1, true), (0.01, 0.14, true)] {
        run(&small(every, end), &folder, resume, &never, |_| ()).unwrap();
    }
    let series = read_pvd(&folder.series()).unwrap();
    // 0 to 0.05, 0.075 and 0.1, 0.11 to 0.14.
    assert_eq!(series.len(), 6 + 2 + 4);
    let mut names: Vec<_> = series.iter().map(|(_, file)| file.clone()).collect();
    names.dedup();
    assert_eq!(names.len(), series.len());
    for (time, file) in &series {
        let particles = read_vtk_particles(&space.path().join(file.file_name().unwrap())).unwrap();
        assert_eq!(particles.time(), Some(*time));
    }
}

#[test]
fn a_table_goes_on_with_its_own_gauges_only() {
    let space = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(space.path()).unwrap();
    let never = AtomicBool::new(false);
    run(&small(0.02, 0.02), &folder, false, &never, |_| ()).unwrap();
    let before = std::fs::read(folder.gauges()).unwrap();
    let more = small(0.02, 0.04).text().to_string() + "\n[[gauge]]\nname = \"second\"\nkind = \"front\"\n";
    let error = run(&Case::parse(&more, "c.toml").unwrap(), &folder, true, &never, |_| ()).unwrap_err().to_string();
    assert!(error.contains("gauges.csv: its columns are not those of the case's gauges"), "{error}");
    assert!(std::fs::read(folder.gauges()).unwrap() == before);
    // Moved away, another is begun.
    std::fs::rename(folder.gauges(), space.path().join("old.csv")).unwrap();
    run(&Case::parse(&more, "c.toml").unwrap(), &folder, true, &never, |_| ()).unwrap();
    assert!(CsvTable::read(&folder.gauges()).unwrap().column("second").unwrap().iter().all(|x| *x > 0.146));
}

#[test]
fn small_numbers_of_gauges_are_short_and_a_table_with_long_ones_is_gone_on_with() {
    let space = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(space.path()).unwrap();
    let never = AtomicBool::new(false);
    let case = |end: &str| {
        let text = small(0.02, 0.02).text().replace("end = 0.02", end);
        Case::parse(&text, "c.toml").unwrap()
    };
    run(&case("end = 0.02"), &folder, false, &never, |_| ()).unwrap();
    let table = std::fs::read_to_string(folder.gauges()).unwrap();
    let longest = table.lines().skip(1).flat_map(|row| row.split(',')).map(str::len).max().unwrap();
    assert!(longest <= 25 && table.contains("e-"), "{table}");
    // Written without exponents, the numbers are the same.
    let row = |row: &str| row.split(',').map(|x| x.parse::<f64>().unwrap().to_string()).collect::<Vec<_>>().join(",");
    let long = table.lines().enumerate().map(|(n, line)| if n == 0 { line.into() } else { row(line) } + "\n");
    std::fs::write(folder.gauges(), long.collect::<String>()).unwrap();
    run(&case("end = 0.04"), &folder, true, &never, |_| ()).unwrap();
    let rows = CsvTable::read(&folder.gauges()).unwrap().column("time").unwrap();
    assert!(rows.len() > table.lines().count() - 1 && rows.windows(2).all(|w| w[0] < w[1]), "{rows:?}");
    assert_eq!(rows[0], 0.0);
}

#[test]
fn cadences_beyond_all_measure_are_no_reason_to_stop() {
    let space = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(space.path()).unwrap();
    let mut case = small(1e-300, 0.004);
    case.sections.output.checkpoint_every = 1e20;
    let mut steps = 0;
    run(&case, &folder, false, &AtomicBool::new(false), |_| steps += 1).unwrap();
    // One at the start, one after each step.
    assert_eq!(read_pvd(&folder.series()).unwrap().len(), steps + 1);
}

/// One particle is fast at the start only: friction brakes it.
fn with_a_fast_particle(case: &Case) -> Solver {
    let mut state = case.state().unwrap();
    state.u[190] = [4.0, 0.0, 0.0];
    Solver::new(case.flow().unwrap(), state).unwrap()
}

#[test]
fn the_largest_speed_is_that_since_time_0_after_a_stop_too() {
    let space = tempfile::tempdir().unwrap();
    let path = space.path().join("checkpoint.bin");
    let case = small(0.02, 0.1);
    let mut solver = with_a_fast_particle(&case);
    solver.step().unwrap();
    solver.write_checkpoint(&path).unwrap();
    assert_eq!(solver.fastest(), 4.0);
    let mut resumed = Solver::read_checkpoint(&path, case.flow().unwrap()).unwrap();
    resumed.step().unwrap();
    assert_eq!(resumed.fastest(), 4.0);
}

#[test]
fn questions_to_a_solver_change_neither_its_checkpoint_nor_its_largest_speed() {
    let space = tempfile::tempdir().unwrap();
    let path = space.path().join("checkpoint.bin");
    let case = small(0.02, 0.1);
    let mut solver = with_a_fast_particle(&case);
    // Also where lists are due.
    for _ in 0..30 {
        solver.write_checkpoint(&path).unwrap();
        let (before, fastest) = (std::fs::read(&path).unwrap(), solver.fastest());
        solver.allowed_step().unwrap();
        solver.mean_neighbours().unwrap();
        solver.boundary_forces().unwrap();
        assert_eq!(solver.fastest(), fastest);
        solver.write_checkpoint(&path).unwrap();
        assert!(std::fs::read(&path).unwrap() == before, "step {}", solver.steps());
        solver.step().unwrap();
    }
}

#[test]
fn a_run_goes_on_with_another_time_step() {
    let space = tempfile::tempdir().unwrap();
    let path = space.path().join("checkpoint.bin");
    let case = small(0.02, 0.1);
    assert!(case.sections.shifting.is_some());
    let mut solver = case.solver().unwrap();
    let dt = solver.step().unwrap();
    solver.write_checkpoint(&path).unwrap();
    let mut shorter = case.clone();
    shorter.sections.time.cfl *= 0.5;
    let mut resumed = Solver::read_checkpoint(&path, shorter.flow().unwrap()).unwrap();
    assert!((resumed.step().unwrap() / dt - 0.5).abs() < 1e-9);
    let mut denser = case.flow().unwrap();
    denser.shifting.as_mut().unwrap().factor = 4.0;
    let error = Solver::read_checkpoint(&path, denser).unwrap_err().to_string();
    assert!(error.contains("only [time], k_cfl and the output may change"), "{error}");
}

#[test]
fn without_detection_no_file_tells_of_a_free_surface() {
    let text = small(0.02, 0.02).text().replace("[shifting]\ndetection = \"exact\"\n", "");
    assert!(!text.contains("detection"));
    let never = AtomicBool::new(false);
    for (text, told) in [(small(0.02, 0.02).text().to_string(), true), (text, false)] {
        let space = tempfile::tempdir().unwrap();
        let folder = RunFolder::create(space.path()).unwrap();
        let case = |end: &str| Case::parse(&text.replace("end = 0.02", end), "c.toml").unwrap();
        run(&case("end = 0.02"), &folder, false, &never, |_| ()).unwrap();
        run(&case("end = 0.03"), &folder, true, &never, |_| ()).unwrap();
        let table = CsvTable::read(&folder.gauges()).unwrap();
        assert_eq!(table.column("free_surface").is_ok(), told);
        assert!(table.column("kinetic").unwrap().iter().all(|e| *e < 10.0));
        let particles = read_vtk_particles(&space.path().join("particles_00001.vtp")).unwrap();
        assert_eq!(particles.quantity("region").is_ok(), told);
    }
}

#[test]
fn a_run_that_began_with_other_fills_is_not_gone_on_with() {
    let space = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(space.path()).unwrap();
    let never = AtomicBool::new(false);
    run(&small(0.02, 0.02), &folder, false, &never, |_| ()).unwrap();
    let before = std::fs::read(folder.gauges()).unwrap();
    let changes: [fn(&mut Case); 2] = [
        |case| case.sections.fill[0].high = Some(vec![0.146, 0.146]),
        |case| case.sections.fill[0].velocity = Some(vec![0.1, 0.0]),
    ];
    for change in changes {
        let mut other = small(0.02, 0.04);
        change(&mut other);
        let error = run(&other, &folder, true, &never, |_| ()).unwrap_err();
        assert!(matches!(error, SphError::Checkpoint { .. }), "{error}");
        assert!(error.to_string().contains("began with other particles than the fills make"), "{error}");
        assert!(error.to_string().contains("only [time], k_cfl and the output may change"), "{error}");
    }
    assert!(std::fs::read(folder.gauges()).unwrap() == before);
    assert_eq!(run(&small(0.02, 0.04), &folder, true, &never, |_| ()).unwrap(), Outcome::Finished);
    // Nor after the run has gone on.
    let mut other = small(0.02, 0.06);
    changes[0](&mut other);
    assert!(run(&other, &folder, true, &never, |_| ()).is_err());
}

#[test]
fn frames_that_no_series_lists_are_neither_written_over_nor_forgotten() {
    let space = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(space.path()).unwrap();
    let never = AtomicBool::new(false);
    run(&small(0.02, 0.05), &folder, false, &never, |_| ()).unwrap();
    let frames = || folder.frames().unwrap().iter().map(|path| std::fs::read(path).unwrap()).collect::<Vec<_>>();
    let (before, series) = (frames(), space.path().join("kept.pvd"));
    std::fs::rename(folder.series(), &series).unwrap();
    let error = run(&small(0.02, 0.1), &folder, true, &never, |_| ()).unwrap_err().to_string();
    assert!(error.contains("particles.pvd: the series is missing, but there are 3 of its files"), "{error}");
    assert!(error.contains("put it back, or move particles_*.vtp away"), "{error}");
    assert!(frames() == before);
    std::fs::rename(&series, folder.series()).unwrap();
    run(&small(0.02, 0.1), &folder, true, &never, |_| ()).unwrap();
    assert!(frames()[..3] == before && read_pvd(&folder.series()).unwrap().len() == 6);
}

#[test]
fn rows_that_a_full_disk_has_cut_are_no_rows() {
    let space = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(space.path()).unwrap();
    let never = AtomicBool::new(false);
    run(&small(0.02, 0.05), &folder, false, &never, |_| ()).unwrap();
    let whole = std::fs::read_to_string(folder.gauges()).unwrap();
    let (rest, last) = whole.trim_end().rsplit_once('\n').unwrap();
    let fields: Vec<&str> = last.split(',').collect();
    let damage = |cut: String| {
        std::fs::write(folder.gauges(), cut).unwrap();
        run(&small(0.02, 0.06), &folder, true, &never, |_| ()).unwrap();
        let table = std::fs::read_to_string(folder.gauges()).unwrap();
        // Back to where it was, for another cut.
        std::fs::remove_file(folder.checkpoint()).unwrap();
        std::fs::copy(space.path().join("checkpoint.kept"), folder.checkpoint()).unwrap();
        table
    };
    std::fs::copy(folder.checkpoint(), space.path().join("checkpoint.kept")).unwrap();
    let full = damage(whole.clone());
    // Cut after three fields, within the time, within the last number, and with a word for a number.
    for cut in [
        format!("{rest}\n{}", fields[..3].join(",")),
        format!("{rest}\n{}\n", fields[..3].join(",")),
        format!("{rest}\n{}", &fields[0][..3]),
        format!("{rest}\n{}", &last[..last.len() - 1]),
        format!("{rest}\n{}\n", last.replacen(fields[3], "none", 1)),
    ] {
        let table = damage(cut);
        let found: Vec<&str> = table.lines().collect();
        let expected: Vec<&str> = full.lines().filter(|line| *line != last).collect();
        assert_eq!(found, expected);
    }
}

#[test]
fn a_gauge_that_measures_something_else_by_the_same_name_does_not_go_on() {
    let space = tempfile::tempdir().unwrap();
    let folder = RunFolder::create(space.path()).unwrap();
    let never = AtomicBool::new(false);
    let with = |end: f64, gauge: &str| {
        let text = small(0.02, end).text().to_string() + "\n[[gauge]]\nname = \"g\"\n" + gauge;
        Case::parse(&text, "c.toml").unwrap()
    };
    let level = "kind = \"level\"\nat = [0.05, 0.1]\n";
    run(&with(0.02, level), &folder, false, &never, |_| ()).unwrap();
    let before = std::fs::read(folder.gauges()).unwrap();
    for (other, said) in [
        ("kind = \"level\"\nat = [0.1, 0.1]\n", "the level at [0.1, 0.1]"),
        ("kind = \"pressure\"\nat = [0.05, 0.1]\n", "the pressure at [0.05, 0.1]"),
        ("kind = \"front\"\naxis = \"-x\"\n", "the front along -x"),
    ] {
        let error = run(&with(0.04, other), &folder, true, &never, |_| ()).unwrap_err().to_string();
        assert!(error.contains(&format!("gauge 'g' is {said}, but was the level at [0.05, 0.1] when")), "{error}");
        assert!(error.contains("gauges.csv") && std::fs::read(folder.gauges()).unwrap() == before);
    }
    run(&with(0.03, level), &folder, true, &never, |_| ()).unwrap();
    // With the table moved away another is begun, whose gauges are those from then on.
    std::fs::remove_file(folder.gauges()).unwrap();
    let front = "kind = \"front\"\n";
    run(&with(0.04, front), &folder, true, &never, |_| ()).unwrap();
    run(&with(0.05, front), &folder, true, &never, |_| ()).unwrap();
    let error = run(&with(0.06, level), &folder, true, &never, |_| ()).unwrap_err().to_string();
    assert!(error.contains("but was the front along x when"), "{error}");
}
