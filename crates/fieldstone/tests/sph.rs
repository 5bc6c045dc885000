//! `fieldstone sph` as users run it.
#![allow(clippy::unwrap_used)]

mod support;

use support::Folder;

/// A shipped case in the folder.
fn case(folder: &Folder, name: &str, spacing: &str) -> String {
    let run = folder.succeeds(&format!("sph new {name} --spacing {spacing}"));
    let file = format!("{name}.toml");
    folder.write(&file, run.stdout);
    file
}

#[test]
fn check_counts_the_papers_free_surface_before_anything_runs() {
    let folder = Folder::new();
    for (name, spacing, fluid, free) in [("double-dam-break", "0.04", 39_000, 4142), ("obstacle", "0.01", 72_000, 4140)]
    {
        let file = case(&folder, name, spacing);
        folder.succeeds(&format!("sph check {file} --json check.json"));
        let found: serde_json::Value =
            serde_json::from_slice(&std::fs::read(folder.path("check.json")).unwrap()).unwrap();
        assert_eq!(found["fluid"], fluid);
        assert_eq!(found["free_surface"], free);
        assert!(found["ghost"].as_u64().unwrap() > 10_000 && found["time_step"].as_f64().unwrap() > 1e-5);
        assert!(found["bytes"].as_u64().unwrap() / fluid > 1000);
    }
}

#[test]
fn a_case_runs_to_its_end_and_is_not_overwritten_but_resumed() {
    let folder = Folder::new();
    let file = case(&folder, "column-1-2", "0.0146");
    let short = std::fs::read_to_string(folder.path(&file)).unwrap().replace("end = 0.5", "end = 0.04");
    folder.write(&file, &short);
    let said = folder.succeeds(&format!("sph run {file} -v")).stdout;
    assert!(said.contains("gradient") && said.contains("written to           column-1-2"), "{said}");
    for name in ["particles.pvd", "particles_00000.vtp", "gauges.csv", "checkpoint.bin"] {
        assert!(folder.path("column-1-2").join(name).exists(), "{name}");
    }
    assert!(folder.fails(&format!("sph run {file}")).contains("go on from it with --resume"));
    // Frames without a checkpoint are not mixed with others.
    folder.copy(&folder.path("column-1-2/particles_00001.vtp"), "left/particles_00001.vtp");
    let left = folder.fails(&format!("sph run {file} --out left"));
    assert!(
        left.contains("particles_00001.vtp: there are particles of an earlier run") && left.contains("--out"),
        "{left}"
    );
    // Nothing to go on from, and nothing left behind.
    let none = folder.fails(&format!("sph run {file} --resume --out elsewhere"));
    assert!(none.contains("run without --resume first") && !folder.path("elsewhere").exists(), "{none}");
    folder.write(&file, short.replace("end = 0.04", "end = 0.06"));
    folder.copy(&folder.path("column-1-2"), "copy");
    folder.succeeds(&format!("sph run {file} --resume"));
    folder.succeeds(&format!("sph run {file} --resume --out copy --threads 2"));
    let checkpoint = |name: &str| std::fs::read(folder.path(name).join("checkpoint.bin")).unwrap();
    assert!(checkpoint("column-1-2") == checkpoint("copy"));
    let table = std::fs::read_to_string(folder.path("column-1-2/gauges.csv")).unwrap();
    // Its end is passed; not a file changes.
    let again = folder.succeeds(&format!("sph run {file} --resume")).stdout;
    assert!(
        again.contains("already at t = 0.06") && again.contains("beyond the end 0.06: nothing was computed"),
        "{again}"
    );
    assert_eq!(std::fs::read_to_string(folder.path("column-1-2/gauges.csv")).unwrap(), table);
    let last: f64 = table.lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
    assert!(last > 0.055, "{last}");
}

#[test]
fn a_mistake_in_a_case_is_named_with_its_line() {
    let folder = Folder::new();
    let file = case(&folder, "hydrostatic", "0.05");
    let wrong = std::fs::read_to_string(folder.path(&file)).unwrap().replace("alpha = 0.02", "alfa = 0.02");
    folder.write(&file, wrong);
    let said = folder.fails(&format!("sph run {file}"));
    assert!(said.contains("hydrostatic.toml:15: unknown field `alfa`, expected one of"), "{said}");
}

#[test]
fn particles_too_fast_for_the_speed_of_sound_are_told() {
    let folder = Folder::new();
    // A block falls for 0.15 s, to 1.5 m/s; ten times the expected speed is a speed of sound of 4 or of 20.
    let falling = |speed: f64| {
        format!(
            "dimension = 2\nspacing = 0.05\n[domain]\nlow = [0, 0]\nhigh = [1, 2]\n[fluid]\ndensity = 1000\nexpected_speed = {speed}\n\
             expected_pressure = 0\ngravity = [0, -9.81]\n[time]\nend = 0.15\n[[fill]]\nshape = \"box\"\nlow = [0.4, 1.5]\n\
             high = [0.6, 1.7]\n"
        )
    };
    folder.write("slow.toml", falling(0.4));
    folder.write("right.toml", falling(2.0));
    let slow = folder.succeeds("sph run slow.toml");
    assert!(slow.stderr.contains("warning: particles were as fast as 1.4"), "{}", slow.stderr);
    assert!(slow.stderr.contains("with a speed of sound of 4: the fluid was compressible"), "{}", slow.stderr);
    assert!(slow.stderr.contains("write expected_speed = 1.4"), "{}", slow.stderr);
    // A third faster than expected is no tenth of the speed of sound any more, though far from compressible.
    folder.write("less.toml", falling(1.1));
    let less = folder.succeeds("sph run less.toml").stderr;
    assert!(
        less.contains("asks for a speed of sound of 14.") && less.contains("with a speed of sound of 11: "),
        "{less}"
    );
    assert!(!less.contains("compressible") && !less.contains("expected_pressure"), "{less}");
    let right = folder.succeeds("sph run right.toml");
    assert!(right.stdout.contains("largest speed        1.4") && !right.stderr.contains("warning"), "{}", right.stderr);
}

#[test]
fn a_pressure_beyond_the_bound_of_the_speed_of_sound_is_told() {
    let folder = Folder::new();
    // Water that falls by 0.2 m is 2 m/s fast, and stops at once.
    let slab = "dimension = 2\nspacing = 0.05\n[domain]\nlow = [0, 0]\nhigh = [1, 2]\n[fluid]\ndensity = 1000\nexpected_speed = 2.1\n\
                gravity = [0, -9.81]\n[time]\nend = 0.22\n[[fill]]\nshape = \"box\"\nlow = [0, 0.2]\nhigh = [1, 0.5]\n[[wall]]\n\
                kind = \"tank\"\n";
    folder.write("slab.toml", slab);
    let told = folder.succeeds("sph run slab.toml").stderr;
    assert!(told.contains("warning: the pressure rose to ") && told.contains("write expected_pressure = "), "{told}");
}

#[test]
fn the_number_of_steps_is_a_whole_one() {
    let folder = Folder::new();
    let file = case(&folder, "hydrostatic", "0.05");
    folder.succeeds(&format!("sph check {file} --json check.json"));
    let found: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.path("check.json")).unwrap()).unwrap();
    assert!(found["steps"].as_u64().is_some_and(|steps| steps > 100), "{}", found["steps"]);
}

#[test]
fn a_hydrostatic_fill_below_another_is_told_to_need_the_surface() {
    let folder = Folder::new();
    let layers = |surface: &str, second: &str| {
        format!(
            "dimension = 2\nspacing = 0.05\n[domain]\nlow = [0, 0]\nhigh = [2, 1]\n[fluid]\ndensity = 1000\nexpected_speed = 2\n\
             expected_pressure = 5000\ngravity = [0, -9.81]\n[time]\nend = 0.01\n[[fill]]\nshape = \"box\"\nlow = [0, 0]\n\
             high = [1, 0.25]\npressure = \"hydrostatic\"\n{surface}\n[[fill]]\nshape = \"box\"\n{second}\n\
             pressure = \"hydrostatic\"\n[[wall]]\nkind = \"tank\"\n"
        )
    };
    folder.write("layers.toml", layers("", "low = [0, 0.25]\nhigh = [1, 0.5]"));
    folder.write("level.toml", layers("surface = 0.5", "low = [0, 0.25]\nhigh = [1, 0.5]"));
    folder.write("beside.toml", layers("", "low = [1, 0]\nhigh = [2, 0.25]"));
    folder.write("falling.toml", layers("", "low = [0, 0.5]\nhigh = [1, 0.75]"));
    for command in ["sph check layers.toml", "sph run layers.toml"] {
        let told = folder.succeeds(command).stderr;
        assert!(told.contains("warning: fill 0 is hydrostatic from its own top on, but fill 1 lies upon it"), "{told}");
        assert!(told.contains("give fill 0 surface"), "{told}");
    }
    for quiet in ["level", "beside", "falling"] {
        let told = folder.succeeds(&format!("sph check {quiet}.toml")).stderr;
        assert!(!told.contains("warning"), "{quiet}: {told}");
    }
}

#[test]
fn check_tells_by_how_much_fills_are_too_heavy() {
    let folder = Folder::new();
    let file = case(&folder, "hydrostatic", "0.05");
    let text = std::fs::read_to_string(folder.path(&file)).unwrap();
    let quiet = |file: &str| {
        let found = folder.succeeds(&format!("sph check {file}"));
        assert!(!found.stdout.contains("excess mass") && !found.stderr.contains("warning"), "{found:?}");
    };
    quiet(&file);
    // 0.49 m are 9.8 spacings, filled with 10 layers of particles that are lighter.
    folder.write("odd.toml", text.replace("high = [1.0, 0.5]", "high = [1.0, 0.49]"));
    quiet("odd.toml");
    // A second fill of whole spacings: its particles are now too light, those of the first too heavy.
    let second = "[[fill]]\nshape = \"box\"\nlow = [0.0, 0.5]\nhigh = [0.5, 0.75]\n\n[[wall]]";
    let two = text.replace("high = [1.0, 0.5]", "high = [1.0, 0.49]").replace("[[wall]]", second);
    folder.write("two.toml", two.replace("end = 10.0", "end = 0.01"));
    for command in ["sph check two.toml", "sph run two.toml"] {
        let told = folder.succeeds(command).stderr;
        // By 0.00246 m² over 0.0025 m².
        assert!(told.contains("the particles of fill 1 are 1.6 % too light for"), "{told}");
    }
    // A disc is cut out of a lattice.
    let disc = "shape = \"sphere\"\ncentre = [0.5, 0.25]\nradius = 0.2\n# pressure";
    let round = text.replace("shape = \"box\"\nlow = [0.0, 0.0]\nhigh = [1.0, 0.5]\npressure", disc);
    folder.write("round.toml", round);
    let round = folder.succeeds("sph check round.toml").stdout;
    let expected = 100.0 * (52.0 * 0.0025 / (std::f64::consts::PI * 0.04) - 1.0);
    assert!(round.contains(&format!("excess mass          {expected:+.2} %: fills are round")), "{round}");
}

/// A tank of water, 1 long and 0.24 deep, with a fill and a body as given.
fn tank(fill: &str, body: &str) -> String {
    format!(
        "dimension = 2\nspacing = 0.02\n[domain]\nlow = [-0.2, 0]\nhigh = [1, 0.6]\nopen = [\"y+\"]\n[fluid]\ndensity = 1000\n\
         expected_speed = 2\nexpected_pressure = 3000\ngravity = [0, -9.81]\n[time]\nend = 0.002\n[[wall]]\nkind = \"tank\"\n\
         [[fill]]\nshape = \"box\"\n{fill}\npressure = \"hydrostatic\"\n{body}"
    )
}

#[test]
fn a_body_that_ends_at_the_floor_is_told_to_reach_beyond_it() {
    let folder = Folder::new();
    let piston = |foot: &str| {
        let body = format!("[[body]]\nshape = \"box\"\nlow = [-0.1, {foot}]\nhigh = [0.0, 0.5]\n");
        tank("low = [0, 0]\nhigh = [1, 0.24]", &body)
    };
    folder.write("floor.toml", piston("0.0"));
    folder.write("less.toml", piston("-0.04"));
    folder.write("beyond.toml", piston("-0.08"));
    folder.write("gap.toml", piston("0.1"));
    for (line, reaches) in [("check floor", "0.000e0"), ("run floor", "0.000e0"), ("check less", "4.000e-2")] {
        let told = folder.succeeds(&format!("sph {line}.toml")).stderr;
        let expected = format!("warning: body 0 stands on wall 0 (normal [0.0, 1.0]) and reaches {reaches} beyond it");
        assert!(told.contains(&expected) && told.contains("let it reach 8.000e-2 (2h) beyond"), "{told}");
    }
    for fine in ["beyond", "gap"] {
        let told = folder.succeeds(&format!("sph check {fine}.toml")).stderr;
        assert!(!told.contains("warning"), "{told}");
    }
}

#[test]
fn a_fill_that_does_not_end_at_its_wall_is_told() {
    let folder = Folder::new();
    for (file, low, high) in
        [("through", -0.2, 1.006), ("short", -0.19, 1.0), ("gap", -0.2, 0.98), ("right", -0.2, 1.0)]
    {
        folder.write(&format!("{file}.toml"), tank(&format!("low = [{low}, 0]\nhigh = [{high}, 0.24]"), ""));
    }
    for (line, normal) in
        [("check through", "[-1.0, 0.0]"), ("run through", "[-1.0, 0.0]"), ("check short", "[1.0, 0.0]")]
    {
        let told = folder.succeeds(&format!("sph {line}.toml")).stderr;
        assert!(
            told.contains("warning: the outermost particles of fill 0 are ") && told.contains("let the fill end"),
            "{told}"
        );
        assert!(told.contains(&format!("from wall 0 (normal {normal}), not half a cell, ")), "{told}");
    }
    for fine in ["gap", "right"] {
        let told = folder.succeeds(&format!("sph check {fine}.toml")).stderr;
        assert!(!told.contains("warning"), "{told}");
    }
}

#[test]
fn files_that_a_run_has_lost_are_told_when_it_goes_on() {
    let folder = Folder::new();
    let case = tank("low = [-0.2, 0]\nhigh = [1, 0.24]", "");
    folder.write("tank.toml", &case);
    folder.succeeds("sph run tank.toml");
    folder.write("tank.toml", case.replace("end = 0.002", "end = 0.004"));
    std::fs::remove_file(folder.path("tank/gauges.csv")).unwrap();
    std::fs::remove_file(folder.path("tank/particles_00001.vtp")).unwrap();
    let told = folder.succeeds("sph run tank.toml --resume").stderr;
    assert!(told.contains("gauges.csv is gone; another begins at the checkpoint"), "{told}");
    assert!(told.contains("particles.pvd: 1 of the files that it lists is gone, the first is"), "{told}");
    assert!(told.contains("particles_00001.vtp; the run goes on without"), "{told}");
    // Stopped before its first checkpoint: one message says the way out.
    std::fs::remove_file(folder.path("tank/checkpoint.bin")).unwrap();
    let told = folder.fails("sph run tank.toml --resume");
    assert!(
        told.contains("stopped before its first checkpoint: remove particles_*.vtp, then run without --resume"),
        "{told}"
    );
}

#[test]
fn a_small_case_takes_kilobytes_and_hundredths_of_seconds() {
    let folder = Folder::new();
    folder.write("tank.toml", tank("low = [-0.2, 0]\nhigh = [1, 0.24]", ""));
    let said = folder.succeeds("sph check tank.toml").stdout;
    let line = |name: &str| said.lines().find(|line| line.starts_with(name)).unwrap_or_default().to_string();
    assert!(line("memory").ends_with("kB") || line("memory").ends_with("MB"), "{said}");
    assert!(!line("memory").contains(" 0") && !line("estimated time").ends_with(" 0 s"), "{said}");
}
