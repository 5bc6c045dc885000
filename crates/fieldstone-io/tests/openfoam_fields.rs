//! OpenFOAM fields and clouds, written by us and by OpenFOAM.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

use fieldstone_io::openfoam::{
    Dimensions, FieldEncoding, InternalValues, VolField, read_cloud, read_internal_field, read_poly_mesh,
    write_vol_field,
};
use fieldstone_mesh::Patch;
use fieldstone_testing::data;

fn patch(name: &str, kind: &str) -> Patch {
    Patch { name: name.into(), kind: kind.into(), start: 0, count: 0 }
}

const AWKWARD: [f64; 6] = [0.1, -0.0, 1e-300, 5e-324, 1.797_693_134_862_315_7e308, 0.333_333_333_333_333_3];

#[test]
fn written_fields_are_read_back_with_the_same_bits() {
    let case = tempfile::tempdir().unwrap();
    let bits = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    for encoding in [FieldEncoding::Text, FieldEncoding::Binary] {
        for components in [1, 3, 6, 9] {
            let values = AWKWARD.repeat(3);
            let cells = values.len() / components;
            let dimensions = Dimensions::MOMENTUM_DENSITY;
            let field = VolField { name: "momentum", dimensions, components, values: &values };
            let path = write_vol_field(&case.path().join("0"), &field, cells, &[], encoding).unwrap();
            let read = read_internal_field(&path).unwrap();
            assert_eq!(bits(&read.values(cells).unwrap()), bits(&values));
            assert_eq!((read.components, read.dimensions), (components, Some(dimensions)));
        }
    }
}

#[test]
fn a_scalar_field_is_written_exactly_like_this() {
    let case = tempfile::tempdir().unwrap();
    let values = [0.5, 1.0, 1e-7];
    let field = VolField { name: "alpha.solids", dimensions: Dimensions::NONE, components: 1, values: &values };
    let patches = [patch("floor", "wall"), patch("sides", "cyclic"), patch("procBoundary0to1", "processor")];
    let path = write_vol_field(&case.path().join("0"), &field, 3, &patches, FieldEncoding::Text).unwrap();
    assert!(path.ends_with("0/alpha.solids"));
    assert_eq!(
        fs::read_to_string(path).unwrap(),
        r#"FoamFile
{
    version     2.0;
    format      ascii;
    class       volScalarField;
    location    "0";
    object      alpha.solids;
}

dimensions      [0 0 0 0 0 0 0];

internalField   nonuniform List<scalar>
3
(
0.5
1.0
1e-7
);

boundaryField
{
    floor
    {
        type            zeroGradient;
    }
    sides
    {
        type            cyclic;
    }
    procBoundary0to1
    {
        type            processor;
    }
}
"#
    );
}

#[test]
fn constraint_patches_keep_their_own_type_and_all_others_get_zero_gradient() {
    let case = tempfile::tempdir().unwrap();
    let kinds = [
        "empty",
        "wedge",
        "symmetry",
        "symmetryPlane",
        "cyclic",
        "cyclicAMI",
        "cyclicACMI",
        "cyclicSlip",
        "cyclicPeriodicAMI",
        "cyclicRepeatAMI",
        "nonuniformTransformCyclic",
        "processor",
        "processorCyclic",
        "nonConformalCyclic",
        "nonConformalError",
        "nonConformalProcessorCyclic",
        "overset",
    ];
    let patches: Vec<Patch> =
        kinds.iter().chain(&["patch", "wall", "nonConformalMappedWall"]).map(|k| patch(k, k)).collect();
    let field = VolField { name: "U", dimensions: Dimensions::VELOCITY, components: 3, values: &[0.0; 3] };
    let path = write_vol_field(case.path(), &field, 1, &patches, FieldEncoding::Binary).unwrap();
    let text = String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
    for kind in kinds {
        assert!(text.contains(&format!("    {kind}\n    {{\n        type            {kind};\n")), "{kind}");
    }
    assert_eq!(text.matches("zeroGradient").count(), 3);
}

#[test]
fn fields_that_openfoam_could_not_read_are_refused() {
    let case = tempfile::tempdir().unwrap();
    let refusal = |name: &str, components: usize, values: &[f64]| {
        let field = VolField { name, dimensions: Dimensions::NONE, components, values };
        let e = write_vol_field(case.path(), &field, 2, &[], FieldEncoding::Text).unwrap_err().to_string();
        assert_eq!(fs::read_dir(case.path()).unwrap().count(), 0, "{name} left a file");
        e
    };
    assert!(refusal("alpha", 1, &[0.5, f64::NAN]).contains("cell 1 has the value NaN"));
    assert!(refusal("alpha", 1, &[0.5]).contains("1 numbers were given for 2 cells"));
    assert!(refusal("alpha", 2, &[0.5; 4]).contains("2 numbers per cell has no OpenFOAM class"));
    for name in ["", "a b", "../alpha", "a;b", "a\"b", "a{b"] {
        assert!(refusal(name, 1, &[0.5; 2]).contains("cannot be the name of a field"), "{name}");
    }
}

#[test]
fn fields_that_openfoam_wrote_are_read() {
    for kind in ["text", "binary"] {
        let time = data("openfoam/cloud").join(kind).join("0.02");
        let rho = read_internal_field(&time.join("rho")).unwrap();
        assert_eq!(rho.dimensions, Some(Dimensions::DENSITY));
        assert_eq!(rho.internal, InternalValues::Uniform(vec![1.2]));
        let velocity = read_internal_field(&time.join("U")).unwrap();
        assert_eq!((velocity.components, velocity.dimensions), (3, Some(Dimensions::VELOCITY)));
        assert_eq!(velocity.values(2).unwrap(), [0.1, 0.0, 0.0, 0.1, 0.0, 0.0]);
    }
}

fn field_text(body: &str) -> Result<fieldstone_io::openfoam::InternalField, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("T");
    fs::write(&path, format!("FoamFile {{ format ascii; class volScalarField; }}\n{body}")).unwrap();
    read_internal_field(&path).map_err(|e| e.to_string().rsplit('/').next().unwrap().to_owned())
}

#[test]
fn fields_are_read_in_the_forms_that_users_write_by_hand() {
    let values = |body: &str| field_text(body).unwrap().values(2).unwrap();
    assert_eq!(values("dimensions [0 0 0 1 0]; internalField uniform 300;"), [300.0; 2]);
    assert_eq!(
        values("#include \"initial\"\n note \"a;b\"; internalField nonuniform List<scalar> 2(1 2);"),
        [1.0, 2.0]
    );
    assert_eq!(values("internalField nonuniform List<scalar> 2{7};"), [7.0; 2]);
    assert_eq!(values("internalField nonuniform 2(1 2);"), [1.0, 2.0]);
    assert_eq!(field_text("dimensions [m s^-1]; internalField uniform 1;").unwrap().dimensions, None);
}

#[test]
fn fields_that_cannot_be_read_say_why() {
    let refusal = |body: &str| field_text(body).unwrap_err();
    assert!(refusal("internalField $initial;").contains("T:2: internalField is the macro '$initial'"));
    assert!(refusal("internalField uniform #calc \"1+1\";").contains("macro"));
    assert!(refusal("dimensions [0 0 0 1 0 0 0];\n").contains("the file has no internalField"));
    assert!(refusal("internalField nonuniform List<scalar> 3(1 2);").contains("announces 3 entries but holds 2"));
    let e = field_text("internalField nonuniform List<scalar> 3(1 2 3);").unwrap().values(2).unwrap_err();
    assert!(e.to_string().contains("values for 3 cells, but the mesh has 2"), "{e}");
}

// ---- Clouds ----

#[test]
fn a_cloud_is_read_from_text_and_binary_files_that_openfoam_wrote() {
    let root = data("openfoam/cloud");
    let text = read_cloud(&root.join("text/0.02/lagrangian/kinematicCloud")).unwrap();
    assert_eq!(text.len(), 5);
    assert_eq!(text.positions()[2], [0.7503022544589794, 0.2505994990091158, 0.1219015489902783]);
    assert_eq!(text.quantity("nParticle").unwrap().data, [2.0; 5]);
    assert_eq!(text.quantity("density").unwrap().data, [2500.0; 5]);
    assert_eq!(
        text.quantity("velocity").unwrap().data[..3],
        [0.01018781841962612, 0.01995826257341642, -0.2638611287224009]
    );
    assert!(text.radii().unwrap().iter().all(|&r| (0.0005..=0.001).contains(&r)));
    assert_eq!(text.time(), Some(0.02));

    let binary = read_cloud(&root.join("binary/0.02")).unwrap();
    assert_eq!(binary.radii().unwrap().len(), 5);
    // The two runs drew the same diameters; text has 16 digits.
    for (a, b) in text.positions().iter().flatten().zip(binary.positions().iter().flatten()) {
        assert!((a - b).abs() < 1e-14, "{a} {b}");
    }
    for (a, b) in text.radii().unwrap().iter().zip(binary.radii().unwrap()) {
        assert!((a - b).abs() < 1e-17, "{a} {b}");
    }
}

#[test]
fn every_path_to_a_cloud_leads_to_it() {
    let time = data("openfoam/cloud/text/0.02");
    let expected = read_cloud(&time).unwrap();
    for below in ["lagrangian", "lagrangian/kinematicCloud", "lagrangian/kinematicCloud/positions"] {
        assert_eq!(read_cloud(&time.join(below)).unwrap(), expected);
    }
}

#[test]
fn a_list_of_positions_for_injection_is_a_cloud_without_radii() {
    let cloud = read_cloud(&data("openfoam/cloud/constant/kinematicCloudPositions")).unwrap();
    assert_eq!(cloud.len(), 5);
    assert_eq!(cloud.positions()[2], [0.75, 0.25, 0.125]);
    assert!(cloud.radii().is_err());
}

#[test]
fn barycentric_coordinates_are_refused_by_name_in_text_and_binary() {
    for kind in ["text", "binary"] {
        let source = data("openfoam/cloud").join(kind).join("0.02/lagrangian/kinematicCloud");
        let folder = tempfile::tempdir().unwrap();
        fs::copy(source.join("coordinates"), folder.path().join("coordinates")).unwrap();
        let e = read_cloud(folder.path()).unwrap_err().to_string();
        assert!(e.contains("'coordinates' but no 'positions'") && e.contains("barycentric"), "{e}");
        // As the OpenFOAM Foundation's versions call them.
        fs::rename(folder.path().join("coordinates"), folder.path().join("positions")).unwrap();
        let e = read_cloud(folder.path()).unwrap_err().to_string();
        assert!(e.contains("particle 0 has four coordinates, which are barycentric"), "{e}");
    }
}

fn cloud_of(files: &[(&str, &str)]) -> Result<fieldstone_particles::Particles, String> {
    let folder = tempfile::tempdir().unwrap();
    for (name, content) in files {
        let class = if *name == "positions" { "Cloud<parcel>" } else { "scalarField" };
        fs::write(folder.path().join(name), format!("FoamFile {{ format ascii; class {class}; }}\n{content}")).unwrap();
    }
    read_cloud(folder.path()).map_err(|e| e.to_string().rsplit('/').next().unwrap().to_owned())
}

#[test]
fn an_empty_cloud_has_no_particles() {
    for empty in ["0()", "0\n(\n)", "()"] {
        assert!(cloud_of(&[("positions", empty)]).unwrap().is_empty(), "{empty}");
    }
}

#[test]
fn broken_clouds_say_what_is_wrong() {
    let two = ("positions", "2((0 0 0) 1 (1 0 0) 2 7 9)");
    assert_eq!(cloud_of(&[two, ("d", "2{0.5}")]).unwrap().radii().unwrap(), [0.25; 2]);
    let e = cloud_of(&[two, ("d", "3(0.1 0.1 0.1)")]).unwrap_err();
    assert!(e.starts_with("d: the file has 3 values, but the cloud has 2 particles"), "{e}");
    let e = cloud_of(&[two, ("d", "2(0.1 -0.1)")]).unwrap_err();
    assert!(e.starts_with("d: particle 1 has radius -0.05"), "{e}");
    let e = cloud_of(&[two, ("rho", "9999999999999{1}")]).unwrap_err();
    assert!(e.starts_with("rho:2: the list of values states one value for 9999999999999 scalars"), "{e}");
    let e = cloud_of(&[("positions", "2((0 0 0) 1 (1 0) 2)")]).unwrap_err();
    assert!(e.starts_with("positions:2: expected a number"), "{e}");
    let e = cloud_of(&[("positions", "2((0 0 0) 1 (1 nan 0) 2)")]).unwrap_err();
    assert!(e.contains("particle 1 has y = NaN"), "{e}");
}

#[test]
fn several_clouds_are_listed_instead_of_one_being_picked() {
    let time = tempfile::tempdir().unwrap();
    for name in ["coal", "lime"] {
        let folder = time.path().join("lagrangian").join(name);
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("positions"), "FoamFile { class Cloud<p>; }\n0()").unwrap();
    }
    let e = read_cloud(time.path()).unwrap_err().to_string();
    assert!(e.contains("there are 2 clouds: coal, lime"), "{e}");
    assert!(read_cloud(&time.path().join("lagrangian/lime")).unwrap().is_empty());
    assert!(read_cloud(Path::new("no/such/folder")).is_err());
}

#[test]
fn a_field_for_a_real_mesh_names_its_patches() {
    let mesh = read_poly_mesh(&data("openfoam/decomposed/processor0")).unwrap();
    let case = tempfile::tempdir().unwrap();
    let volumes = mesh.cell_volumes();
    let field = VolField {
        name: "V",
        dimensions: Dimensions([0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        components: 1,
        values: volumes,
    };
    let path =
        write_vol_field(&case.path().join("0"), &field, mesh.cell_count(), &mesh.parts().patches, FieldEncoding::Text)
            .unwrap();
    let text = fs::read_to_string(&path).unwrap();
    let boundary = text.split("boundaryField").nth(1).unwrap();
    for p in &mesh.parts().patches {
        assert!(boundary.contains(&format!("    {}\n", p.name)), "{}", p.name);
    }
    assert_eq!(read_internal_field(&path).unwrap().values(mesh.cell_count()).unwrap(), volumes);
}

/// OpenFOAM's `postProcess` on a case, where it is installed.
fn post_process(case: &Path, function: &str) -> Option<std::process::Output> {
    let mut command = std::process::Command::new("postProcess");
    // Debian's package leaves the environment to its users.
    if std::env::var_os("WM_PROJECT_DIR").is_none() && Path::new("/usr/share/openfoam/etc").is_dir() {
        command.env("WM_PROJECT_DIR", "/usr/share/openfoam");
    }
    let output = command.arg("-case").arg(case).args(["-func", function, "-time", "0"]).output();
    output.inspect_err(|_| eprintln!("not run: OpenFOAM's postProcess is not installed")).ok()
}

#[test]
fn openfoam_computes_with_the_fields_that_we_write() {
    let source = data("openfoam/decomposed");
    let mesh = read_poly_mesh(&source.join("whole")).unwrap();
    let cells = mesh.cell_count();
    let velocity: Vec<f64> = (0..3 * cells).map(|k| (k as f64 - 7.0) / 3.0).collect();
    for encoding in [FieldEncoding::Text, FieldEncoding::Binary] {
        let case = tempfile::tempdir().unwrap();
        for folder in ["system", "constant/polyMesh"] {
            fs::create_dir_all(case.path().join(folder)).unwrap();
        }
        for file in ["points", "faces", "owner", "neighbour", "boundary"] {
            let file = format!("constant/polyMesh/{file}");
            fs::copy(source.join("whole").join(&file), case.path().join(&file)).unwrap();
        }
        fs::copy(source.join("system/controlDict"), case.path().join("system/controlDict")).unwrap();
        let dictionaries = [
            ("fvSchemes", "divSchemes {} gradSchemes {} laplacianSchemes {} interpolationSchemes {} snGradSchemes {}"),
            ("fvSolution", ""),
        ];
        for (name, entries) in dictionaries {
            let text =
                format!("FoamFile {{ version 2.0; format ascii; class dictionary; object {name}; }}\n{entries}\n");
            fs::write(case.path().join("system").join(name), text).unwrap();
        }
        let field = VolField { name: "U.solids", dimensions: Dimensions::VELOCITY, components: 3, values: &velocity };
        write_vol_field(&case.path().join("0"), &field, cells, &mesh.parts().patches, encoding).unwrap();
        let Some(output) = post_process(case.path(), "mag(U.solids)") else { return };
        let log = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{log}");
        let magnitude = read_internal_field(&case.path().join("0/mag(U.solids)")).expect(&log);
        assert_eq!(magnitude.dimensions, Some(Dimensions::VELOCITY));
        for (found, v) in magnitude.values(cells).unwrap().iter().zip(velocity.chunks_exact(3)) {
            let expected = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
            assert!((found - expected).abs() < 1e-14 * expected, "{found} {expected}");
        }
    }
}
