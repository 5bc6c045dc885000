//! `fieldstone reproduce dam-break` as users run it: tables and pictures, stopped and gone on.
#![allow(clippy::unwrap_used)]

mod support;

use std::process::{Command, Stdio};
use std::time::Duration;

use support::Folder;

/// Coarse enough for seconds; the flow still runs against the far wall.
const COARSE: &str = "--slab --spacing 0.12 --integrator rk4 --cfl 1.5 --threads 1";

#[test]
#[cfg(unix)]
fn a_reproduction_that_is_stopped_goes_on_to_the_same_tables() {
    let folder = Folder::new();
    folder.succeeds(&format!("reproduce dam-break whole {COARSE} --only table1"));
    // Ctrl-C twice, on the way.
    let mut stopped = 0;
    for wait in [400, 800] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_fieldstone"))
            .current_dir(folder.path("."))
            .args(format!("reproduce dam-break pieces {COARSE} --only table1").split(' '))
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(wait));
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        stopped += i32::from(!child.wait().unwrap().success());
    }
    assert!(stopped > 0 && folder.path("pieces/flows/dam-break-slab_0.12_rk4_cfl1.5/checkpoint.bin").exists());
    folder.succeeds(&format!("reproduce dam-break pieces {COARSE} --only table1,fig11,fig12,fig16"));
    let read = |name: &str| std::fs::read(folder.path(name)).unwrap();
    assert_eq!(read("whole/table1.csv"), read("pieces/table1.csv"));
    for name in ["table1_1.45s.png", "fig11_1.80s.png", "fig12_1.45s.png", "fig16_0.52s.png"] {
        assert!(read(&format!("pieces/{name}")).starts_with(b"\x89PNG"), "{name}");
    }
    let page = String::from_utf8(read("pieces/index.md")).unwrap();
    for title in ["## Table 1", "## Fig. 11", "## Fig. 12", "## Fig. 16"] {
        assert!(page.contains(title), "{title}");
    }
    assert!(!page.contains("NaN"), "{page}");
    // A wider cone finds no other particles, only fewer: misses, no false positives, in every row.
    let rows = page.lines().skip_while(|line| !line.starts_with("## Fig. 12")).filter(|line| line.contains(" s | "));
    assert!(rows.clone().count() >= 3);
    assert!(rows.take(3).all(|row| row.split('|').skip(2).take(2).all(|cell| cell.contains(" + 0 /"))), "{page}");
    // Frames that are there are not computed again.
    std::fs::remove_file(folder.path("pieces/flows/dam-break-slab_0.12_rk4_cfl1.5/checkpoint.bin")).unwrap();
    folder.succeeds(&format!("reproduce dam-break pieces {COARSE} --only table1"));
    // A flow of other settings is not taken for this one, whatever its end.
    let case = "pieces/flows/dam-break-slab_0.12_rk4_cfl1.5/case.toml";
    let text = String::from_utf8(read(case)).unwrap();
    folder.write(case, text.replace("delta = 0.1\n", "delta = 0.2\n"));
    let said = folder.fails(&format!("reproduce dam-break pieces {COARSE} --only table1"));
    assert!(said.contains("case.toml: this flow was computed with other settings"), "{said}");
}

#[test]
fn measured_flows_are_refused_without_their_measurements() {
    let folder = Folder::new();
    let said = folder.fails("reproduce dam-break out --only buchner");
    assert!(said.contains("--measurements"), "{said}");
    // A folder without the file: named before anything is computed.
    let said = folder.fails("reproduce dam-break out --only buchner --measurements .");
    assert!(said.contains("there is no file ./buchner2002_pressure.txt"), "{said}");
    assert!(!folder.path("out").exists());
}

/// A minute: FIELDSTONE_SPH_LONG=1 runs it. The measurements are not in the repository.
#[test]
fn a_collapsing_column_sinks_and_runs_as_fast_as_measured() {
    let data = fieldstone_testing::extended("sph-validation");
    let (Some(data), Some(_)) = (data, std::env::var_os("FIELDSTONE_SPH_LONG")) else {
        eprintln!("skipped: needs FIELDSTONE_SPH_LONG and sph-validation in FIELDSTONE_DATA");
        return;
    };
    let folder = Folder::new();
    folder.succeeds(&format!("reproduce dam-break out --only column --measurements {}", data.display()));
    let page = std::fs::read_to_string(folder.path("out/index.md")).unwrap();
    let cell = |row: &str, index: usize| -> f64 {
        let line = page.lines().find(|line| line.contains(row)).unwrap();
        line.split('|').nth(index).unwrap().replace('−', "-").replace([' ', '%'], "").parse().unwrap()
    };
    assert!(cell("height, table 6", 3) < 5.0, "{page}");
    assert!(cell("Moyce, table 2", 6).abs() < 5.0, "{page}");
}
