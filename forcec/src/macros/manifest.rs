//! Finds the name under which a crate depends on the runtime; manifests can rename dependencies.
//!
//! In: the manifests of the crate being compiled and of its workspace. Out: the name, if it is not the
//! default.

use std::path::{Path, PathBuf};
use toml::de::{DeTable, DeValue};

/// The package of the runtime.
const RUNTIME: &str = "forcec-runtime";

/// The name of the runtime in the crate being compiled; `None` if it is `forcec_runtime`.
pub(crate) fn runtime() -> Option<String> {
    let folder = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR")?);
    let own = read(&folder)?;
    let around = || folder.ancestors().skip(1).filter_map(read).find(|text| text.contains("[workspace"));
    name(&own, around)
}

fn read(folder: &Path) -> Option<String> {
    std::fs::read_to_string(folder.join("Cargo.toml")).ok()
}

/// The name of the runtime by a manifest; `workspace` reads the workspace's manifest if necessary.
fn name(manifest: &str, workspace: impl Fn() -> Option<String>) -> Option<String> {
    let manifest = DeTable::parse(manifest).ok()?;
    let manifest = manifest.get_ref();
    let targets = table(manifest, "target").into_iter().flat_map(|targets| targets.iter());
    let targets = targets.filter_map(|(_, target)| target.get_ref().as_table());
    const KINDS: [&str; 3] = ["dependencies", "dev-dependencies", "build-dependencies"];
    let lists = std::iter::once(manifest).chain(targets);
    let lists = lists.flat_map(|place| KINDS.iter().filter_map(|kind| table(place, kind)));
    let shared = || {
        let text = workspace()?;
        let around = DeTable::parse(&text).ok()?;
        let list = table(table(around.get_ref(), "workspace")?, "dependencies")?;
        let renamed = list.iter().filter(|(_, value)| is_runtime(value.get_ref()));
        Some(renamed.map(|(name, _)| name.get_ref().to_string()).collect::<Vec<String>>())
    };
    let mut inherited: Option<Vec<String>> = None;
    for (name, value) in lists.flat_map(|list| list.iter()) {
        let name = name.get_ref().as_ref();
        if name == RUNTIME {
            return None;
        }
        let from_workspace = value.get_ref().as_table().is_some_and(|value| value.contains_key("workspace"));
        let renamed = is_runtime(value.get_ref())
            || from_workspace
                && inherited
                    .get_or_insert_with(|| shared().unwrap_or_default())
                    .iter()
                    .any(|own| own == name);
        if renamed {
            return Some(name.replace('-', "_"));
        }
    }
    None
}

fn table<'t, 'a>(table: &'t DeTable<'a>, key: &str) -> Option<&'t DeTable<'a>> {
    table.get(key)?.get_ref().as_table()
}

fn is_runtime(dependency: &DeValue<'_>) -> bool {
    let package = dependency.as_table().and_then(|table| table.get("package"));
    package.is_some_and(|package| package.get_ref().as_str() == Some(RUNTIME))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_runtime_is_called_as_manifests_call_it() {
        let none = || None;
        let called = |text: &str| name(text, none);
        assert_eq!(called("[dependencies]\nforcec-runtime = \"0.1\"\n"), None);
        assert_eq!(called("[dependencies]\nserde = \"1\"\n"), None);
        assert_eq!(called("no toml {"), None);
        let renamed = "fr = { package = \"forcec-runtime\", path = \"..\" }\n";
        let table = "[dependencies.my-forces]\nversion = \"0.1\"\npackage = \"forcec-runtime\"\n";
        assert_eq!(called(&format!("[dependencies]\nserde = \"1\"\n{renamed}")).as_deref(), Some("fr"));
        assert_eq!(called(&format!("[dev-dependencies]\n{renamed}")).as_deref(), Some("fr"));
        assert_eq!(called(&format!("[target.'cfg(unix)'.dependencies]\n{renamed}")).as_deref(), Some("fr"));
        assert_eq!(called(table).as_deref(), Some("my_forces"));
        assert_eq!(called(&format!("[dependencies]\n{renamed}forcec-runtime = \"0.1\"\n")), None);
        let workspace = || Some(format!("[workspace.dependencies]\nserde = \"1\"\n{renamed}"));
        let own = "[dependencies]\nserde.workspace = true\nfr = { workspace = true }\n";
        assert_eq!(name(own, workspace).as_deref(), Some("fr"));
        assert_eq!(name(own, none), None);
    }
}
