//! Finished files get their names: all of them, or none.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};

/// Files under their final names, with what stood there before.
#[derive(Debug, Default)]
#[must_use = "dropping it forgets what stood there before"]
pub(crate) struct Published {
    files: Vec<(PathBuf, Option<PathBuf>)>,
}

impl Published {
    /// Renames every (from, to); where one cannot be, those before it are taken back.
    ///
    /// What stood there before is kept in the folder `aside`, on the same file system, until that is removed. A run that
    /// is killed in between leaves the files that it has come to.
    pub fn new(files: &[(PathBuf, PathBuf)], aside: &Path) -> anyhow::Result<Self> {
        let mut published = Self::default();
        for (number, (from, to)) in files.iter().enumerate() {
            if let Err(error) = published.add(from, to, &aside.join(format!("before-{number}"))) {
                published.take_back();
                return Err(error);
            }
        }
        Ok(published)
    }

    fn add(&mut self, from: &Path, to: &Path, kept: &Path) -> anyhow::Result<()> {
        let shown = to.display();
        let before = match std::fs::symlink_metadata(to) {
            Ok(found) if found.is_dir() => bail!("{shown}: there is a folder of this name; remove it first"),
            // A second name keeps the old file in place until the new one replaces it; some file systems have none.
            Ok(_) => std::fs::hard_link(to, kept).or_else(|_| std::fs::rename(to, kept)).map(|()| Some(kept.into())),
            Err(_) => Ok(None),
        };
        let before: Option<PathBuf> = before.with_context(|| format!("{shown}: cannot be replaced"))?;
        let renamed = std::fs::rename(from, to).with_context(|| format!("{shown}: cannot write"));
        if let (Err(_), Some(kept)) = (&renamed, &before) {
            restore(kept, to);
        }
        renamed?;
        self.files.push((to.into(), before));
        Ok(())
    }

    /// Brings back what stood there before.
    pub fn take_back(self) {
        for (to, before) in self.files.iter().rev() {
            match before {
                Some(kept) => restore(kept, to),
                None => {
                    let _ = std::fs::remove_file(to);
                }
            }
        }
    }
}

/// The error that led here is what the user hears of: one more cannot be helped.
fn restore(kept: &Path, to: &Path) {
    let _ = std::fs::rename(kept, to);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_cannot_be_given_takes_back_those_before_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::create_dir(path("new")).unwrap();
        std::fs::create_dir(path("aside")).unwrap();
        for name in ["a", "b", "c"] {
            std::fs::write(path("new").join(name), "new").unwrap();
        }
        std::fs::write(path("a"), "old").unwrap();
        let files = |names: &[&str]| -> Vec<(PathBuf, PathBuf)> {
            names.iter().map(|name| (path("new").join(name), path(name))).collect()
        };
        std::fs::create_dir(path("c")).unwrap();
        let message = Published::new(&files(&["a", "b", "c"]), &path("aside")).unwrap_err().to_string();
        assert!(message.ends_with("c: there is a folder of this name; remove it first"), "{message}");
        assert_eq!(std::fs::read_to_string(path("a")).unwrap(), "old");
        assert!(!path("b").exists());

        std::fs::write(path("new/a"), "newer").unwrap();
        let published = Published::new(&files(&["a"]), &path("aside")).unwrap();
        assert_eq!(std::fs::read_to_string(path("a")).unwrap(), "newer");
        published.take_back();
        assert_eq!(std::fs::read_to_string(path("a")).unwrap(), "old");
    }
}
