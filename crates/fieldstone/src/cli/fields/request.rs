//! What is known of a run before anything is read.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use anyhow::{anyhow, bail};
use fieldstone::fields::{CoarseGrainingOptions, FieldName, Function, Kernel, Method, Selection};
use fieldstone::io::{ContactFiles, FrameRange, ParticleOptions, Series, find_files, find_times};
use fieldstone::particles::Domain;

use super::names::ascii;
use super::output::{CellKind, Format, check_side};
use super::settings::{FunctionName, Settings, Sign};
use crate::cli::arguments::{Periodic, ending};
use crate::cli::outputs;

/// What is known before anything is read.
pub(super) struct Run<'a> {
    pub settings: &'a Settings,
    pub out: &'a Path,
    pub format: Format,
    pub files: Vec<PathBuf>,
    /// Time of each file, where a .pvd lists them.
    pub times: Vec<f64>,
    pub contacts: Vec<ContactFiles>,
    pub range: FrameRange,
    pub periodic: Periodic,
    /// In place of the files' box.
    pub bounds: Option<Domain>,
    /// The settings with bounds of the cells that the first frame's particles gave, where nothing else did.
    pub laid: Option<Settings>,
    pub options: CoarseGrainingOptions,
    pub gravity: Option<[f64; 3]>,
    /// Types that get fields of their own.
    pub species: Vec<i64>,
    /// What to say once the results are there.
    pub warnings: Vec<String>,
}

impl<'a> Run<'a> {
    pub fn new(settings: &'a Settings, config: Option<&Path>) -> anyhow::Result<Self> {
        let particles = settings.particles.as_deref().ok_or_else(|| anyhow!("give the particles: --particles FILE"))?;
        let out = settings.out.as_deref().ok_or_else(|| anyhow!("give the result's name: --out OUT"))?;
        let kind = match (&settings.mesh, settings.is_cylindrical()) {
            (Some(_), _) => CellKind::Mesh,
            (None, true) => CellKind::Cylinder,
            (None, false) => CellKind::Grid,
        };
        let format = Format::of(out, kind)?;
        let files = find_files(particles)?;
        let contacts: Vec<ContactFiles> = (settings.contacts.0.iter())
            .map(|source| Ok(ContactFiles { files: find_files(&source.file)?, options: source.options() }))
            .collect::<anyhow::Result<_>>()?;
        refuse_repeats(&contacts)?;
        let inputs: Vec<&Path> = (files.iter().chain(contacts.iter().flat_map(|source| &source.files)))
            .map(PathBuf::as_path)
            .chain(settings.restart.as_deref())
            .chain(settings.mesh.as_deref())
            .chain(config)
            .collect();
        check_names(settings, out, kind, &inputs)?;
        check_beside(settings, kind, format)?;
        let gravity = settings.gravity.as_ref().map(|g| g.exactly("gravity")).transpose()?;
        let mut run = Self {
            settings,
            out,
            format,
            files,
            times: find_times(particles)?,
            contacts,
            range: FrameRange::default(),
            periodic: settings.periodic.as_deref().unwrap_or("auto").parse().map_err(|e| anyhow!("--periodic: {e}"))?,
            bounds: None,
            laid: None,
            options: CoarseGrainingOptions::default(),
            gravity,
            species: Vec::new(),
            warnings: Vec::new(),
        };
        run.bounds = run.bounds()?;
        run.options = run.options()?;
        run.range = run.range()?;
        Ok(run)
    }

    /// Options of the library, but for what the first frame decides.
    fn options(&self) -> anyhow::Result<CoarseGrainingOptions> {
        let settings = self.settings;
        let defaults = CoarseGrainingOptions::default();
        let function = match settings.function.unwrap_or(FunctionName::Overlap(Method::Kernel)) {
            FunctionName::Overlap(method) => {
                if settings.width.is_some() || settings.cutoff.is_some() || settings.conserve == Some(true) {
                    bail!(
                        "--width, --cutoff and --conserve go with kernels: --function gauss, lucy, heaviside or linear"
                    );
                }
                Function::Overlap(method)
            }
            FunctionName::Kernel(shape) => {
                let Some(width) = settings.width else {
                    bail!("--function {shape} needs a width: --width W, about a particle's radius or more")
                };
                let cutoff = settings.cutoff;
                Function::Kernel(Kernel::new(shape, width, cutoff).map_err(|e| anyhow!("--width, --cutoff: {e}"))?)
            }
        };
        let asked = settings.fields.as_deref().unwrap_or("standard");
        // Made of the density after all frames.
        let weight = |word: &str| word.trim() == "body_force_density";
        if asked.split(',').any(weight) && self.gravity.is_none() {
            bail!("--fields body_force_density: the density's weight needs --gravity GX,GY,GZ");
        }
        let asked: Vec<&str> = asked.split(',').map(|word| if weight(word) { "density" } else { word }).collect();
        let mut fields = FieldName::parse_list(&asked.join(",")).map_err(|e| anyhow!("--fields: {e}"))?;
        if self.contacts.is_empty() && matches!(settings.fields.as_deref(), None | Some("all")) {
            fields.retain(|field| !field.needs_contacts());
        }
        if self.gravity.is_some() && !fields.contains(&FieldName::Density) {
            bail!("--gravity makes body_force_density of the density; add density to --fields");
        }
        let radii = settings.radii.as_ref().map(|radii| radii.exactly("radii")).transpose()?;
        let region = settings.region.as_ref().map(|region| region.exactly("region")).transpose()?;
        let selection = Selection {
            types: settings.species.as_ref().map(|types| types.0.clone()),
            radii,
            region: region.map(|[x0, x1, y0, y1, z0, z1]: [f64; 6]| [[x0, y0, z0], [x1, y1, z1]]),
        };
        selection.check().map_err(|e| anyhow!("--radii, --region: {e}"))?;
        Ok(CoarseGrainingOptions {
            function,
            contact_form: settings.stress_form.map(Into::into),
            fields,
            sign: settings.sign.unwrap_or(Sign::Compression).into(),
            mean_velocity: settings.mean_velocity.map_or(defaults.mean_velocity, Into::into),
            walls_in_contact_force: settings.walls.map_or(defaults.walls_in_contact_force, Into::into),
            conserve: settings.conserve.unwrap_or(false),
            selection,
            particle_density: settings.density,
            parcel_weight: (settings.parcel_weight.as_ref())
                .map(|text| text.parse().map_err(|e| anyhow!("--parcel-weight {text}: {e}")))
                .transpose()?,
            ..defaults
        })
    }

    /// The box that was given, with its periodic directions.
    fn bounds(&self) -> anyhow::Result<Option<Domain>> {
        let Some(bounds) = &self.settings.bounds else { return Ok(None) };
        Ok(Some(self.periodic.given_box(bounds.exactly("box")?)?))
    }

    pub fn displaced(&self) -> bool {
        self.options.fields.iter().any(|field| field.needs_displacement())
    }

    /// Whether the result is that of one frame.
    pub fn one_frame(&self) -> bool {
        !self.format.is_series() && self.settings.average != Some(true) && self.settings.smooth.is_none()
    }

    fn range(&self) -> anyhow::Result<FrameRange> {
        let one_frame = self.one_frame();
        let text = match self.settings.frames.as_deref() {
            Some(text) => text,
            None if one_frame && self.displaced() => "-2:",
            None if one_frame => "-1",
            None => ":",
        };
        text.parse().map_err(|e| anyhow!("--frames: {e}"))
    }

    pub fn particle_options(&self) -> ParticleOptions {
        ParticleOptions { allow_non_spherical: self.settings.allow_non_spherical.unwrap_or(false) }
    }

    pub fn series(&self, with_contacts: bool) -> Series {
        let series = Series::new(self.files.clone(), self.particle_options())
            .with_times(self.times.clone())
            .with_range(self.range);
        let series = match self.periodic {
            Periodic::Given(axes) => series.with_periodic(axes),
            Periodic::Auto => series,
        };
        let series = match self.bounds {
            Some(bounds) => series.with_box(bounds),
            None => series,
        };
        let contacts = self.contacts.iter().filter(|_| with_contacts).cloned();
        contacts.fold(series, Series::with_contacts)
    }

    /// Numbers per cell in the result.
    pub fn columns(&self) -> usize {
        let named: usize = self.options.fields.iter().map(|field| field.components().len()).sum();
        let own = named + self.options.quantities.iter().map(|quantity| quantity.columns.len()).sum::<usize>();
        own * (1 + self.species.len())
    }

    /// Formulas and units, as comments below the settings; in ASCII, since VTK reads nothing else.
    pub fn legend(&self) -> String {
        let lines = self.options.fields.iter().map(|field| {
            let components = field.components().join(" ");
            let components = if components.is_empty() { String::new() } else { format!(" ({components})") };
            ascii(&format!("# {field}{components}: {}, in {}\n", field.formula(), field.unit()))
        });
        lines.collect()
    }
}

/// Refuses names of results that are those of other files of the run.
fn check_names(settings: &Settings, out: &Path, kind: CellKind, inputs: &[&Path]) -> anyhow::Result<()> {
    for (option, path) in [
        ("--out", Some(out)),
        ("--face-fields", settings.face_fields.as_deref()),
        ("--to-particles", settings.to_particles.as_deref()),
    ] {
        let Some(name) = path.and_then(Path::file_name).map(|name| name.to_string_lossy()) else { continue };
        if name.contains("{}") {
            let series = if option == "--out" { ".pvd file, or a .stat file," } else { ".pvd file" };
            bail!(
                "{option} {}: names are not numbered here; give a {series} for a result of each frame, or leave out {{}} for one",
                path.unwrap_or(out).display()
            );
        }
    }
    outputs::check("--out", out, inputs)?;
    let mut taken = [inputs, &[out]].concat();
    for (option, path) in [("--face-fields", &settings.face_fields), ("--to-particles", &settings.to_particles)] {
        if let Some(path) = path {
            outputs::check(option, path, &taken)?;
            taken.push(path);
        }
    }
    if let Some(path) = &settings.json {
        outputs::check_json(path, &taken)?;
        taken.push(path);
    }
    let cells_ending = if kind == CellKind::Mesh { ".vtu" } else { ".vti" };
    let lists = [
        ("--out", Some(out), cells_ending),
        ("--face-fields", settings.face_fields.as_deref(), ".vtp"),
        ("--to-particles", settings.to_particles.as_deref(), ".vtp"),
    ];
    for (option, path, after) in lists {
        if let Some(path) = path.filter(|path| ending(path) == "pvd") {
            let before = format!("{}_", path.file_stem().unwrap_or_default().to_string_lossy());
            outputs::NumberedNames::beside(path, &before, after).check(option, path, &taken)?;
        }
    }
    Ok(())
}

/// Refuses results beside the fields on cells that do not go with the other options.
fn check_beside(settings: &Settings, kind: CellKind, format: Format) -> anyhow::Result<()> {
    if let Some(path) = &settings.face_fields {
        if kind == CellKind::Cylinder {
            bail!(
                "--face-fields goes with grids and meshes: what crosses the curved faces of cylindrical cells is not \
                 computed"
            );
        }
        check_side("--face-fields", path, &["vtp"], format.is_series())?;
    }
    if let Some(path) = &settings.to_particles {
        if settings.average == Some(true) || settings.smooth.is_some() {
            bail!("--to-particles needs the fields of one frame at a time; leave out --average and --smooth");
        }
        if matches!(settings.function, Some(FunctionName::Kernel(_))) {
            bail!("--to-particles goes with overlaps, whose weights are volumes: --function exact");
        }
        check_side("--to-particles", path, &["vtp", "csv"], format.is_series())?;
    }
    Ok(())
}

/// Refuses a file of contacts that is given twice: each of its contacts would count twice.
fn refuse_repeats(contacts: &[ContactFiles]) -> anyhow::Result<()> {
    let mut seen: HashMap<PathBuf, &Path> = HashMap::new();
    for path in contacts.iter().flat_map(|source| &source.files) {
        let Ok(real) = path.canonicalize() else { continue };
        if let Some(before) = seen.insert(real, path) {
            let also = if before == path { String::new() } else { format!(", also as {}", before.display()) };
            bail!(
                "--contacts {}: the file is given twice{also}, and each of its contacts would count twice; give every file once",
                path.display()
            );
        }
    }
    Ok(())
}
