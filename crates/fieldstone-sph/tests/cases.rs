//! Case files: what ships starts as it should, and what is wrong is named with its line.
#![allow(clippy::unwrap_used)]

use std::sync::atomic::{AtomicBool, Ordering};

use fieldstone_sph::{Case, RunFolder, SHIPPED, Solver, level_over, particles_of, run};

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
        (
            "end = 10.0",
            "end = 10.0\ncfl = 7",
            "c.toml:20: the CFL number is 7; it must be above 0 and at most 2.1: beyond",
        ),
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
        (
            "end = 10.0",
            "end = 10.0\n[shifting]\nenabled = false\ncap = -1",
            "c.toml:22: the largest shift over the spacing is -1",
        ),
        ("end = 10.0", "end = 10.0\n[shifting]\nenabled = false\nn = 0", "c.toml:22: n of the shifting is 0"),
        ("end = 10.0", "end = 10.0\n[[gauge]]\nname = \"\"\nkind = \"front\"", "c.toml:21: the name \"\" is empty"),
        (
            "end = 10.0",
            "end = 10.0\n[[gauge]]\nname = \"a\\rb\"\nkind = \"front\"",
            "c.toml:21: the name \"a\\rb\" is empty, or holds a comma, a quote or a control character",
        ),
        ("end = 10.0", "end = 10.0\n[shifting]\ncap = 7", "c.toml:21: the largest shift over the spacing is 7"),
        (
            "kind = \"tank\"",
            "kind = \"tank\"\n[[wall]]\nkind = \"plane\"\npoint = [0, 0]\nnormal = [0, 1]\nslip = \"no\"",
            "c.toml:30: walls 2 and 3 face the same way; one mirror wall may bound the fluid on a side",
        ),
        (
            // A face named open again and again is one open face.
            "open = [\"y+\"]",
            "open = [\"y+\", \"y+\", \"y+\", \"y+\", \"y+\"]\n[[wall]]\nkind = \"plane\"\npoint = [0, 0]\nnormal = [0, 1]",
            "c.toml:32: walls 0 and 3 face the same way",
        ),
        (
            "[[wall]]\nkind = \"tank\"",
            "[[wall]]\nkind = \"plane\"\npoint = [0, 0.55]\nnormal = [0, 1]",
            "c.toml:22: nothing is filled: the shapes are smaller than the spacing, or all in bodies or behind walls",
        ),
        (
            "open = [\"y+\"]\n",
            "open = [\"y+\"]\nperiodic = [\"x\"]\n[[wall]]\nkind = \"plane\"\npoint = [0, 0]\nnormal = [0.6, 0.8]\n",
            "a wall's normal along a periodic axis is 0.6; it must be 0: such walls do not repeat",
        ),
        (
            "pressure = \"hydrostatic\"",
            "pressure = 2e5",
            "c.toml:25: the fill begins with a pressure of 200000.000000, for which the speed of sound, 44.3, must be at least \
             141.421356 (Eq. 3); raise expected_pressure",
        ),
        ("pressure = \"hydrostatic\"", "pressure = -1e7", "c.toml:25: the fill begins with a pressure of -10000000"),
        (
            "pressure = \"hydrostatic\"",
            "velocity = [0, 6]",
            "c.toml:25: the fill begins with a speed of 6.000000, for which the speed of sound, 44.3, must be at least 60.000000",
        ),
        (
            "end = 10.0",
            "end = 10.0\n[[body]]\nshape = \"box\"\nlow = [0.4, 0.6]\nhigh = [0.6, 0.8]\n\
             motion = [[0, 0, 0], [0.001, 0, 0], [0.02, 0.2, 0], [0.03, 0.2, 0]]",
            "c.toml:24: the body moves as fast as 15.78",
        ),
    ] {
        assert!(good.contains(from));
        let text = good.replacen(from, to, 1);
        let Err(error) = Case::parse(&text, "c.toml").and_then(|c| c.state()) else { panic!("accepted: {to}") };
        let error = error.to_string();
        assert!(error.contains(expected) && error.starts_with("c.toml:"), "{error}\ninstead of {expected}");
    }
}

#[test]
fn what_lies_behind_a_wall_is_not_filled() {
    // A beach at 45 degrees cuts the corner off a square of 20 × 20: 20 · 21/2 particles stay, those on the diagonal too.
    let text = "dimension = 2\nspacing = 0.05\n[domain]\nlow = [0, 0]\nhigh = [2, 2]\nopen = [\"y+\"]\n[fluid]\ndensity = 1000\n\
                expected_speed = 5\nexpected_pressure = 20000\ngravity = [0, -9.81]\n[time]\nend = 1\n[[fill]]\nshape = \"box\"\n\
                low = [0, 0]\nhigh = [1, 1]\n[[wall]]\nkind = \"plane\"\npoint = [0.99, 0]\nnormal = [1, 1]\n";
    let state = Case::parse(text, "beach.toml").unwrap().state().unwrap();
    assert_eq!(state.len(), 20 * 21 / 2);
    assert!(state.x.iter().all(|x| x[0] + x[1] >= 0.99));
}

#[test]
fn the_sections_written_as_toml_are_the_case() {
    for shipped in SHIPPED {
        let mut case = shipped.at_spacing(None).unwrap();
        case.sections.time.end *= 1.5;
        case.sections.time.cfl = 0.125;
        let again = Case::parse(&case.to_toml().unwrap(), shipped.name).unwrap();
        assert_eq!(again.sections, case.sections, "{}", shipped.name);
        assert_eq!(again.flow().unwrap().time_step.cfl, 0.125);
    }
}

#[test]
fn the_spacing_is_changed_wherever_its_line_stands() {
    let text = shipped("hydrostatic").text().replace("spacing = 0.025", "  spacing=0.025 # fine");
    let case = Case::parse(&text, "c.toml").unwrap().with_spacing(0.05).unwrap();
    assert_eq!(case.state().unwrap().len(), 20 * 10);
    let quoted = shipped("hydrostatic").text().replace("spacing = 0.025", "\"spacing\" = 0.025");
    let error = Case::parse(&quoted, "c.toml").unwrap().with_spacing(0.05).unwrap_err().to_string();
    assert!(error.contains("give it as a line `spacing = …`"), "{error}");
}

#[test]
fn a_body_that_is_too_thin_and_a_slab_that_is_too_narrow_are_refused() {
    let thin = shipped("obstacle").text().replace("high = [1.02, 0.36, 0.45]", "high = [0.92, 0.36, 0.45]");
    let error = Case::parse(&thin, "c.toml").unwrap_err().to_string();
    assert!(error.contains("thick along x; it must be at least 4 spacings"), "{error}");
    let narrow = shipped("dam-break-slab").with_spacing(0.06).unwrap_err().to_string();
    assert!(narrow.contains("the periodic faces along y are 0.18"), "{narrow}");
}

/// A block of water in a closed box, with gravity and fills as given.
fn still(gravity: &str, fills: &str) -> String {
    format!(
        "dimension = 2\nspacing = 0.05\n[domain]\nlow = [0, 0]\nhigh = [2, 2]\n[fluid]\ndensity = 1000\nexpected_speed = 1\n\
         expected_pressure = 20000\ngravity = {gravity}\n[time]\nend = 1\n{fills}[[wall]]\nkind = \"tank\"\n"
    )
}

fn fill(low: [f64; 2], high: [f64; 2], rest: &str) -> String {
    format!("[[fill]]\nshape = \"box\"\nlow = {low:?}\nhigh = {high:?}\n{rest}\n")
}

/// Positions and pressures at the start.
fn pressures(text: &str) -> Vec<([f64; 3], f64)> {
    let case = Case::parse(text, "c.toml").unwrap();
    let (state, fluid) = (case.state().unwrap(), case.flow().unwrap().fluid);
    state.x.iter().zip(&state.density).map(|(x, density)| (*x, fluid.pressure(*density))).collect()
}

#[test]
fn hydrostatic_pressure_grows_along_gravity_whatever_its_direction() {
    let block = fill([0.0, 0.0], [1.0, 0.5], "pressure = \"hydrostatic\"");
    for (gravity, top) in
        [([0.0, -9.81], [0.0, 0.5]), ([0.0, 9.81], [0.0, 0.0]), ([9.81, 0.0], [0.0, 0.0]), ([-6.0, -8.0], [1.0, 0.5])]
    {
        for (x, p) in pressures(&still(&format!("{gravity:?}"), &block)) {
            let expected = 1000.0 * (gravity[0] * (x[0] - top[0]) + gravity[1] * (x[1] - top[1]));
            assert!((p - expected).abs() < 1e-6 && p > 0.0, "{gravity:?} {x:?}: {p} {expected}");
        }
    }
}

#[test]
fn stacked_fills_below_one_level_begin_as_one_fill() {
    for (gravity, level) in [("[0, -9.81]", "0.8"), ("[0, 9.81]", "0.0")] {
        let below = format!("pressure = \"hydrostatic\"\nsurface = {level}");
        let halves = fill([0.0, 0.0], [1.0, 0.5], &below) + &fill([0.0, 0.5], [1.0, 0.8], &below);
        let mut two = pressures(&still(gravity, &halves));
        let mut one = pressures(&still(gravity, &fill([0.0, 0.0], [1.0, 0.8], "pressure = \"hydrostatic\"")));
        for particles in [&mut one, &mut two] {
            particles.sort_by_key(|(x, _)| [x[0], x[1]].map(|x| (x / 0.05) as i64));
        }
        assert_eq!(one.len(), two.len());
        for ((x, p), (y, q)) in one.iter().zip(&two) {
            assert!((0..2).all(|k| (x[k] - y[k]).abs() < 1e-9) && (p - q).abs() < 1e-5, "{x:?} {p}, {y:?} {q}");
        }
    }
}

#[test]
fn levels_and_waves_that_gravity_does_not_allow_are_refused() {
    let below = |level: &str| fill([0.0, 0.0], [1.0, 0.5], &format!("pressure = \"hydrostatic\"\nsurface = {level}"));
    let wave = "flow = \"standing-wave\"\namplitude = 0.01\nwavelength = 1";
    for (gravity, fills, expected) in [
        ("[0, -9.81]", below("0.4"), "c.toml:18: surface is 0.4; it must be at least the fill's top, 0.5"),
        ("[0, 9.81]", below("-0.1"), "c.toml:18: surface is -0.1; it must be at least the fill's top, 0,"),
        ("[0, 0]", below("0.6"), "c.toml:18: without gravity there is no level"),
        ("[0, -9.81]", below("nan"), "c.toml:18: surface is NaN; it must be finite"),
        (
            "[0, -9.81]",
            fill([0.0, 0.0], [1.0, 0.5], "pressure = 3\nsurface = 0.6"),
            "c.toml:18: surface goes with pressure = \"hydrostatic\" only",
        ),
        (
            "[9.81, 0]",
            fill([0.0, 0.0], [1.0, 0.5], wave),
            "c.toml:17: a standing wave needs gravity along minus y, it is [9.81, 0.0]",
        ),
        ("[0, 9.81]", fill([0.0, 0.0], [1.0, 0.5], wave), "c.toml:17: a standing wave needs gravity along minus y"),
    ] {
        let error = Case::parse(&still(gravity, &fills), "c.toml").and_then(|c| c.state()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\ninstead of {expected}");
    }
}

#[test]
fn shifting_without_a_mach_number_is_refused() {
    let text = |speed: &str, rest: &str| {
        let text = shipped("hydrostatic").text().replace("expected_speed = 1.0", &format!("expected_speed = {speed}"));
        format!("{text}\n[shifting]\n{rest}\n")
    };
    let error = Case::parse(&text("0.0", ""), "c.toml").unwrap_err().to_string();
    assert!(error.starts_with("c.toml:13: the Mach number of the shifting"), "{error}");
    assert!(error.contains("give mach, or an expected_speed above 0"), "{error}");
    for (speed, rest) in [("0.0", "mach = 0.05"), ("0.0", "enabled = false"), ("1.0", "")] {
        assert!(Case::parse(&text(speed, rest), "c.toml").is_ok(), "{speed} {rest}");
    }
}

#[test]
fn sections_that_were_changed_stay_so_at_another_spacing() {
    let mut case = shipped("hydrostatic");
    case.sections.fluid.delta = 0.3;
    case.sections.fill[0].high = Some(vec![1.0, 0.25]);
    let finer = case.with_spacing(0.0125).unwrap();
    assert_eq!(finer.flow().unwrap().fluid.delta, 0.3);
    assert_eq!(finer.state().unwrap().len(), 80 * 20);
    // Text and line numbers are those of the file, at the spacing.
    assert_eq!(Case::parse(finer.text(), "c.toml").unwrap().sections.spacing, 0.0125);
}

#[test]
fn sections_that_were_changed_are_checked_before_anything_is_made_of_them() {
    let folder = tempfile::tempdir().unwrap();
    let files = RunFolder::create(folder.path()).unwrap();
    type Change = fn(&mut Case);
    let changes: [(Change, &str); 3] = [
        (|case| case.sections.time.end = f64::NAN, "hydrostatic:19: end is NaN; it must be finite and above 0"),
        (|case| case.sections.output.every = Some(0.0), "every is 0; it must be finite and above 0"),
        (|case| case.sections.dimension = 4, "hydrostatic:2: the dimension is 4; it must be 2 or 3"),
    ];
    for (change, expected) in changes {
        let mut case = shipped("hydrostatic");
        change(&mut case);
        let stop = AtomicBool::new(false);
        let mut steps = 0;
        let ran = run(&case, &files, false, &stop, |_| {
            steps += 1;
            stop.store(steps > 3, Ordering::Relaxed);
        });
        for error in [case.flow().unwrap_err(), case.state().unwrap_err(), ran.unwrap_err()] {
            assert!(error.to_string().contains(expected), "{error}\ninstead of {expected}");
        }
    }
}

#[test]
fn gravity_along_a_periodic_axis_makes_no_pressure_and_no_level() {
    // A channel that slopes down along x.
    for (rest, level) in [("", 0.5), ("\nsurface = 0.6", 0.6)] {
        let water = fill([0.0, 0.0], [2.0, 0.5], &format!("pressure = \"hydrostatic\"{rest}"));
        let text = still("[1.0, -9.76]", &water).replace("high = [2, 2]\n", "high = [2, 2]\nperiodic = [\"x\"]\n");
        for (x, p) in pressures(&text) {
            assert!((p - 9760.0 * (level - x[1])).abs() < 1e-6, "{x:?}: {p}");
        }
    }
    let lying = fill([0.0, 0.0], [2.0, 0.5], "pressure = \"hydrostatic\"\nsurface = 0.6");
    let text = still("[1.0, 0.0]", &lying).replace("high = [2, 2]\n", "high = [2, 2]\nperiodic = [\"x\"]\n");
    let error = Case::parse(&text, "c.toml").and_then(|c| c.state()).unwrap_err().to_string();
    assert!(error.contains("c.toml:19: without gravity there is no level") && error.contains("periodic"), "{error}");
}

#[test]
fn levels_are_measured_against_gravity() {
    for (gravity, periodic, low, high, at, level) in [
        ("[0, -9.81]", "", [0.0, 0.0], [2.0, 0.5], [1.0, 0.0], 0.5),
        ("[0, 9.81]", "", [0.0, 1.4], [2.0, 2.0], [1.0, 0.0], 1.4),
        ("[-9.81, 0]", "", [0.0, 0.0], [0.5, 2.0], [0.0, 1.0], 0.5),
        ("[9.81, 0]", "", [1.4, 0.0], [2.0, 2.0], [0.0, 1.0], 1.4),
        // The larger component counts, and one along a period does not.
        ("[-9.81, 3]", "", [0.0, 0.0], [0.5, 2.0], [0.0, 1.0], 0.5),
        ("[9, -3]", "periodic = [\"x\"]\n", [0.0, 0.0], [2.0, 0.5], [1.0, 0.0], 0.5),
        ("[0, 0]", "", [0.0, 0.0], [2.0, 0.5], [1.0, 0.0], 0.5),
        // Dry: the face that the water would lie on.
        ("[-9.81, 0]", "", [0.0, 0.0], [0.5, 1.0], [1.0, 1.5], 0.0),
        ("[9.81, 0]", "", [1.5, 0.0], [2.0, 1.0], [1.0, 1.5], 2.0),
    ] {
        let text =
            still(gravity, &fill(low, high, "")).replace("high = [2, 2]\n", &format!("high = [2, 2]\n{periodic}"));
        let solver = Case::parse(&text, "c.toml").unwrap().solver().unwrap();
        let found = level_over(&solver, [at[0], at[1], 0.0]);
        assert!((found - level).abs() < 1e-9, "{gravity}: {found} for {level}");
    }
}

/// Fluid that fills a box of periods, and moves along x.
const STREAM: &str = r#"
dimension = 2
spacing = 0.1
[domain]
low = [0, 0]
high = [1, 1]
periodic = ["x", "y"]
[fluid]
density = 1000
expected_speed = 1
gravity = [0, 0]
[time]
end = 1
[[fill]]
shape = "box"
low = [0, 0]
high = [1, 1]
flow = "uniform"
velocity = [1, 0]
"#;

#[test]
fn frames_hold_particles_of_a_periodic_flow_within_its_period() {
    let mut solver = Case::parse(STREAM, "c.toml").unwrap().solver().unwrap();
    let mut beyond = 0;
    while solver.time() < 0.3 {
        solver.step().unwrap();
        beyond += solver.state().x.iter().filter(|x| x[0] >= 1.0).count();
        let frame = particles_of(&solver).unwrap();
        assert!(frame.positions().iter().all(|x| (0.0..1.0).contains(&x[0]) && (0.0..1.0).contains(&x[1])));
    }
    // The solver's own are not always.
    assert!(beyond > 0);
}

#[test]
fn a_front_along_a_period_is_refused() {
    let with = |axis: &str| format!("{STREAM}[[gauge]]\nname = \"f\"\nkind = \"front\"\naxis = \"{axis}\"\n");
    for axis in ["x", "-x", "y"] {
        let error = Case::parse(&with(axis), "c.toml").unwrap_err().to_string();
        assert!(error.contains("c.toml:23: along a periodic axis there is no front"), "{error}");
    }
}

#[test]
fn without_gravity_there_is_none() {
    let text = shipped("hydrostatic").text().to_string();
    let mut lines: Vec<&str> = text.lines().collect();
    lines.retain(|line| !line.starts_with("gravity"));
    let case = Case::parse(&lines.join("\n"), "c.toml").unwrap();
    assert_eq!(case.flow().unwrap().fluid.gravity, [0.0; 3]);
    assert_eq!(Case::parse(&case.to_toml().unwrap(), "c.toml").unwrap().sections, case.sections);
}

#[test]
fn a_gauge_of_pressure_where_no_fluid_comes_is_refused() {
    let with = |at: &str| {
        let body = "[[body]]\nshape = \"box\"\nlow = [0.4, -0.2]\nhigh = [0.6, 0.3]\n[[wall]]\nkind = \"plane\"\npoint = [0.9, 0]\n\
                    normal = [-1, 0]\n";
        let low = fill([0.0, 0.0], [0.2, 0.5], "");
        let text = still("[0, -9.81]", &(low + body)).replace("[[wall]]\nkind = \"tank\"\n", "");
        Case::parse(&format!("{text}[[gauge]]\nname = \"p\"\nkind = \"pressure\"\nat = {at}\n"), "c.toml")
            .and_then(|c| c.state())
    };
    let error = with("[0.5, 0.2]").unwrap_err().to_string();
    assert!(error.contains("at is [0.5, 0.2], inside body 0, where there is no pressure to measure"), "{error}");
    assert!(error.contains(": at is") && error.starts_with("c.toml:"), "{error}");
    let error = with("[0.95, 0.2]").unwrap_err().to_string();
    assert!(error.contains("at is [0.95, 0.2], behind wall 0"), "{error}");
    for fine in ["[0.4, 0.2]", "[0.5, 0.3]", "[0.9, 0.1]", "[0.1, 0.1]"] {
        with(fine).unwrap();
    }
}
