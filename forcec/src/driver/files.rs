//! Input and output files: finds force files, compiles them together, writes the results atomically.
//!
//! In: paths of force files and folders. Out: compiled files, and the files that targets generate; or all
//! errors as text.

use crate::compile::{self, Compiled, Request};
use crate::emit;
use crate::kernel::{File, Kernel, Precision, Target};
use crate::layout::{Lanes, Layout};
use crate::names::{defined_for, is_module};
use crate::options::specialize::Specialization;
use crate::source::diagnostic::{Diagnostic, Diagnostics};
use crate::source::span::{Source, shown};
use crate::syntax;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The reason for a failed build: all messages, in order.
#[derive(Clone, Debug, Default)]
pub struct BuildError {
    /// Errors in force files and scenes.
    pub diagnostics: Vec<Diagnostics>,
    /// Other errors, such as files that cannot be read or written.
    pub others: Vec<String>,
}

impl BuildError {
    /// Whether there are no errors.
    pub(crate) fn is_empty(&self) -> bool {
        self.diagnostics.is_empty() && self.others.is_empty()
    }

    /// All errors as text.
    pub(crate) fn render(&self, colour: bool) -> String {
        let diagnostics = self.diagnostics.iter().map(|diagnostics| diagnostics.render(colour));
        diagnostics.chain(self.others.iter().cloned()).collect::<Vec<String>>().join("\n\n")
    }
}

impl From<Vec<String>> for BuildError {
    fn from(others: Vec<String>) -> BuildError {
        BuildError { diagnostics: Vec::new(), others }
    }
}

impl From<Diagnostics> for BuildError {
    fn from(diagnostics: Diagnostics) -> BuildError {
        BuildError { diagnostics: vec![diagnostics], others: Vec::new() }
    }
}

impl std::fmt::Display for BuildError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for BuildError {}

/// One compiled force file.
pub(crate) struct Unit {
    /// The path of the force file.
    pub(crate) path: PathBuf,
    /// Its kernels.
    pub(crate) compiled: Compiled,
}

impl Unit {
    /// The files that a target prints, named after the force file: one for each layout and number of lanes. A
    /// number that a precision cannot represent is an error.
    pub(crate) fn files(&self, precisions: &[Precision]) -> Result<Vec<File>, Diagnostics> {
        let stem = self.path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let (mut kernels, mut errors) = (Vec::new(), Vec::new());
        for function in &self.compiled.functions {
            match compile::fitted(&function.definition, &function.kernel, precisions) {
                Ok(kernel) => kernels.push(kernel),
                Err(error) => errors.push(error),
            }
        }
        if !errors.is_empty() {
            return Err(Diagnostics::new(self.compiled.source.clone(), errors));
        }
        Ok(by_layout(&stem, &self.compiled.docs, kernels.into_iter(), precisions))
    }
}

/// Groups kernels into files: one file for each layout and number of lanes.
pub(crate) fn by_layout(
    stem: &str,
    docs: &[String],
    kernels: impl Iterator<Item = Kernel>,
    precisions: &[Precision],
) -> Vec<File> {
    let mut groups: BTreeMap<(Layout, Lanes), Vec<Kernel>> = BTreeMap::new();
    for kernel in kernels {
        groups.entry((kernel.layout, kernel.lanes)).or_default().push(kernel);
    }
    let file = |kernels| File {
        stem: stem.to_owned(),
        docs: docs.to_vec(),
        kernels,
        precisions: precisions.to_vec(),
    };
    groups.into_values().map(file).collect()
}

/// The force files among some paths.
pub(crate) struct Found {
    /// Force files, in order.
    pub(crate) sources: Vec<(PathBuf, Source)>,
    /// One error for each file that could not be read.
    pub(crate) errors: Vec<String>,
}

/// Finds and reads the force files at these paths: folders are searched, each file is read once.
pub(crate) fn read_all(named: &[PathBuf]) -> Found {
    let mut paths = Vec::new();
    let mut errors: Vec<String> = Vec::new();
    for path in named {
        find(path, true, &mut paths, &mut errors);
    }
    let mut seen = BTreeSet::new();
    paths.retain(|path| seen.insert(fs::canonicalize(path).unwrap_or_else(|_| path.clone())));
    let mut sources = Vec::new();
    for path in paths {
        match read(&path) {
            Ok(text) if syntax::mentions_forces(&text) => {
                let name = shown(Path::new(&path.to_string_lossy().replace('\\', "/")));
                sources.push((path, Source::new(name, text)));
            }
            Ok(_) => {}
            Err(error) => errors.push(error),
        }
    }
    if sources.is_empty() && errors.is_empty() {
        let paths: Vec<String> = named.iter().map(|p| format!("`{}`", shown(p))).collect();
        errors.push(format!(
            "error: no force function in {}\n  = help: mark one with `#[constraint]`, `#[energy]` or `#[force]`",
            paths.join(", ")
        ));
    }
    Found { sources, errors }
}

/// Compiles files one by one.
pub(crate) fn compile_all(
    sources: Vec<(PathBuf, Source)>,
    wanted: &dyn Fn(&str) -> bool,
    request: &Request,
    step: &mut dyn FnMut(&str),
) -> (Vec<Unit>, Vec<Diagnostics>) {
    let (mut units, mut errors) = (Vec::new(), Vec::new());
    for (path, source) in sources {
        step(&source.name);
        match compile::compile(&source, wanted, request.clone()) {
            Ok(compiled) => units.push(Unit { path, compiled }),
            Err(diagnostics) => errors.push(diagnostics),
        }
    }
    (units, errors)
}

/// An error for every specialised body or parameter that no force function has.
pub(crate) fn unknown(units: &[Unit], known: &Specialization) -> Vec<String> {
    let errors = compile::unknown(units.iter().flat_map(|unit| &unit.compiled.functions), known);
    let line = |error: Diagnostic| {
        let help = error.help.map_or_else(String::new, |help| format!("\n  = help: {help}"));
        format!("error: {}{help}", error.message)
    };
    errors.into_iter().map(line).collect()
}

/// The files that the targets generate, sorted by path; fails if one would overwrite a force file or the
/// scene.
pub(crate) fn outputs(
    units: &[Unit],
    folder: &Path,
    targets: &[Target],
    precisions: &[Precision],
    scene: Option<&Path>,
) -> Result<Vec<Output>, String> {
    let mut files: BTreeMap<PathBuf, String> = BTreeMap::new();
    // On file systems that ignore case, names with the same lower-case form are the same file.
    let mut spelled: BTreeMap<String, String> = BTreeMap::new();
    for unit in units {
        let printed = unit.files(precisions).map_err(|errors| errors.to_string())?;
        if targets.contains(&Target::C) {
            printed.iter().try_for_each(|file| includable(unit, &file.stem))?;
        }
        let printed =
            printed.iter().flat_map(|file| targets.iter().flat_map(|target| emit::emit(file, *target)));
        for generated in printed {
            let path = folder.join(&generated.name);
            let spelling =
                spelled.entry(generated.name.to_lowercase()).or_insert_with(|| generated.name.clone());
            let other = *spelling != generated.name;
            let old = files.insert(path.clone(), generated.text);
            if other || old.is_some_and(|old| old != files[&path]) {
                return Err(collision(unit, &path));
            }
        }
    }
    let outputs: Vec<Output> = files.into_iter().map(|(path, text)| Output { path, text }).collect();
    spare_inputs(units.iter().map(|unit| unit.path.as_path()).chain(scene), &outputs)?;
    Ok(outputs)
}

/// Headers of the C standard library, its implementations and POSIX, without extension: folders given with
/// `-I` are searched before the system's.
const HEADERS: &str = "assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg \
    stdatomic stdbit stdbool stdckdint stddef stdint stdio stdlib stdmchar stdnoreturn string tgmath threads time uchar wchar \
    wctype \
    alloca byteswap endian error features features-time64 getopt libio malloc memory stdc-predef syslimits ucontext values \
    xlocale _ansi _g_config _mingw _newlib_version availability availabilitymacros availabilityversions \
    corecrt crtdefs newlib no_sal2 sal sdkddkver stdbool stdfix targetconditionals unwind vadefs vcruntime yvals \
    aio cpio devctl dirent dlfcn fcntl fmtmsg fnmatch ftw glob grp iconv langinfo libgen libintl monetary mqueue ndbm netdb \
    nl_types poll pthread pwd regex sched search semaphore spawn strings stropts syslog tar termios trace ulimit unistd utime \
    utmpx wordexp direct io process windows";

/// Fails if C cannot include a header of this name, or if the header would hide a system header.
fn includable(unit: &Unit, stem: &str) -> Result<(), String> {
    let why = if HEADERS.split_ascii_whitespace().any(|name| stem.eq_ignore_ascii_case(name)) {
        format!("`{stem}.h` would hide the header <{stem}.h> of the C library")
    } else if stem.contains(['"', '\\']) || stem.contains(|c: char| c.is_control() || emit::turns(c)) {
        "C cannot include a header of such a name".to_owned()
    } else {
        return Ok(());
    };
    Err(format!("error: {why}\n --> {}\n  = help: rename the force file", shown(&unit.path)))
}

/// The error about an output that would be written twice.
fn collision(unit: &Unit, output: &Path) -> String {
    let help = if unit.path.file_stem().is_some_and(|stem| stem == "forcec") {
        "`forcec.h` holds the body types; rename the force file"
    } else {
        "give the files different names, or build them into different folders"
    };
    let (unit, output) = (shown(&unit.path), shown(output));
    format!(
        "error: the kernels of `{unit}` would overwrite another file of this build, `{output}`\n  = help: {help}"
    )
}

/// Collects a file given by name, or a folder's Rust files, recursively, in sorted order.
fn find(path: &Path, named: bool, found: &mut Vec<PathBuf>, errors: &mut Vec<String>) {
    let metadata = match fs::metadata(path) {
        Ok(metadata) => metadata,
        Err(error) => return errors.push(unreadable(path, &error)),
    };
    if !metadata.is_dir() {
        if named || path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path.to_owned());
        }
        return;
    }
    let mut entries = match fs::read_dir(path).and_then(Iterator::collect::<std::io::Result<Vec<_>>>) {
        Ok(entries) => entries,
        Err(error) => return errors.push(unreadable(path, &error)),
    };
    entries.sort_by_key(fs::DirEntry::file_name);
    for entry in entries {
        let path = entry.path();
        let hidden = entry.file_name().to_string_lossy().starts_with('.') && path.is_dir();
        // Does not follow links to folders, so cyclic links cannot cause an endless search.
        let folder_link = path.is_symlink() && path.is_dir();
        if !hidden && !folder_link && path.exists() {
            find(&path, false, found, errors);
        }
    }
}

fn unreadable(path: &Path, error: &std::io::Error) -> String {
    format!("error: cannot read `{}`: {error}", shown(path))
}

fn read(path: &Path) -> Result<String, String> {
    let bytes = fs::read(path).map_err(|error| unreadable(path, &error))?;
    String::from_utf8(bytes).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        let line = error.as_bytes()[..offset].iter().filter(|b| **b == b'\n').count() + 1;
        format!(
            "error: `{}` is not UTF-8\n --> {}:{line}\n  = help: save the file as UTF-8",
            shown(path),
            shown(path)
        )
    })
}

/// Errors for kernels of different files that define the same names.
pub(crate) fn duplicates(units: &[Unit]) -> Vec<String> {
    let mut errors = Vec::new();
    let mut defined: BTreeMap<(Target, String), (usize, &str)> = BTreeMap::new();
    for (index, unit) in units.iter().enumerate() {
        for function in &unit.compiled.functions {
            let name = function.kernel.name.as_str();
            let mut meets = None;
            for item in defined_for(name, &function.kernel.layout.tables())
                .into_iter()
                .filter(|(target, _)| *target == Target::C)
            {
                let first = *defined.entry(item).or_insert((index, name));
                meets = meets.or((first != (index, name)).then_some(first));
            }
            let Some((first, other)) = meets else { continue };
            let place = |unit: &Unit, name: &str| {
                let kernel = unit.compiled.functions.iter().find(|k| k.kernel.name == name);
                let offset = kernel.map_or(0, |k| k.definition.span.start);
                let (line, column) = unit.compiled.source.line_column(offset);
                format!(" --> {}:{line}:{column}", unit.compiled.source.name)
            };
            let what = if name == other {
                format!("two kernels are named `{name}`")
            } else {
                format!("kernels of `{name}` and `{other}` would have the same name")
            };
            errors.push(format!(
                "error: {what}\n{}\n{}\n  = help: rename one of the functions",
                place(&units[first], other),
                place(unit, name)
            ));
        }
    }
    errors
}

/// A file to write.
pub(crate) struct Output {
    /// The path.
    pub(crate) path: PathBuf,
    /// The contents.
    pub(crate) text: String,
}

/// `mod.rs`, which declares the Rust files in its folder; an error for each file that is not a valid module
/// name.
pub(crate) fn modules(folder: &Path, outputs: &[Output]) -> Result<Output, BuildError> {
    let mut text = format!("// {}the files in this folder{}\n", emit::MADE, emit::NO_EDIT);
    let mut errors = Vec::new();
    for path in
        outputs.iter().map(|output| &output.path).filter(|path| path.extension() == Some("rs".as_ref()))
    {
        let stem = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        if is_module(&stem) {
            text.push_str(&format!("pub mod {stem};\n"));
        } else {
            errors
                .push(format!("error: `{stem}` is not a valid module name\n  = help: rename the force file"));
        }
    }
    if errors.is_empty() { Ok(Output { path: folder.join("mod.rs"), text }) } else { Err(errors.into()) }
}

/// Fails if an output is one of the inputs, also through links.
pub(crate) fn spare_inputs<'a>(
    inputs: impl Iterator<Item = &'a Path>,
    outputs: &[Output],
) -> Result<(), String> {
    let inputs: Vec<(&Path, Identity)> = inputs.filter_map(|path| Some((path, identity(path)?))).collect();
    let errors = outputs.iter().filter_map(|output| {
        let own = identity(&output.path)?;
        let (input, _) = inputs.iter().find(|(_, input)| *input == own)?;
        Some(format!(
            "error: the output `{}` is the input `{}`\n  = help: write into another folder",
            shown(&output.path),
            shown(input)
        ))
    });
    all_fine(errors.collect())
}

fn all_fine(errors: Vec<String>) -> Result<(), String> {
    if errors.is_empty() { Ok(()) } else { Err(errors.join("\n\n")) }
}

/// Identifies a file independently of its path: symbolic and hard links lead to the same identity.
#[cfg(unix)]
type Identity = (u64, u64);

#[cfg(unix)]
fn identity(path: &Path) -> Option<Identity> {
    use std::os::unix::fs::MetadataExt;
    fs::metadata(path).ok().map(|metadata| (metadata.dev(), metadata.ino()))
}

/// Identifies a file independently of its path: links are resolved, and the system normalises the path.
#[cfg(not(unix))]
type Identity = PathBuf;

#[cfg(not(unix))]
fn identity(path: &Path) -> Option<Identity> {
    fs::canonicalize(path).ok()
}

/// An output whose file must change.
struct Change<'a> {
    output: &'a Output,
    /// The path that is written: the target of the links, if the output's path is a link.
    place: PathBuf,
    /// The metadata of the existing file.
    old: Option<fs::Metadata>,
}

/// Writes files such that each is complete or unchanged: writes all to temporary files in the target folders,
/// then renames them. Replaces only files that forcec generated.
pub(crate) fn write(folder: &Path, outputs: &[Output]) -> Result<(), String> {
    if folder.exists() && !folder.is_dir() {
        return Err(failed(folder, std::io::ErrorKind::NotADirectory.into()));
    }
    fs::create_dir_all(folder).map_err(|error| failed(folder, error))?;
    let places = outputs.iter().map(|output| place(&output.path));
    let places = places.collect::<Result<Vec<PathBuf>, String>>()?;
    let folders: BTreeSet<PathBuf> = places.iter().map(|place| folder_of(place)).collect();
    // Serialises builds into the same folder; all builds acquire locks in the same order.
    let locks: Vec<(PathBuf, Option<fs::File>)> =
        folders.into_iter().map(|folder| (folder.clone(), lock(&folder))).collect();
    for (folder, _) in locks.iter().filter(|(_, lock)| lock.is_some()) {
        sweep(folder);
    }
    let mut changes: Vec<Change<'_>> = Vec::new();
    let mut errors = Vec::new();
    for (output, place) in outputs.iter().zip(places) {
        match change(output, place) {
            Ok(Some(change)) if changes.iter().any(|other| other.place == change.place) => {
                let path = shown(&output.path);
                errors.push(format!("error: `{path}` is a link to another output\n  = help: remove it"));
            }
            Ok(change) => changes.extend(change),
            Err(error) => errors.push(error),
        }
    }
    all_fine(errors)?;
    let mut waiting: Vec<(PathBuf, &Change<'_>)> = Vec::new();
    let written = (|| {
        for change in &changes {
            let temporary = temporary(&change.place);
            waiting.push((temporary.clone(), change));
            fill(&temporary, change).map_err(|error| failed(&change.output.path, error))?;
        }
        for (temporary, change) in &waiting {
            fs::rename(temporary, &change.place).map_err(|error| failed(&change.output.path, error))?;
        }
        Ok(())
    })();
    if written.is_err() {
        for (temporary, _) in &waiting {
            // Removes remaining temporary files if possible; the first error is reported.
            let _ = fs::remove_file(temporary);
        }
    }
    written
}

fn failed(path: &Path, error: std::io::Error) -> String {
    format!("error: cannot write `{}`: {error}", shown(path))
}

/// The largest number of links to follow.
const MOST_LINKS: usize = 40;

/// The path that is written, after following links; the target need not exist.
fn place(path: &Path) -> Result<PathBuf, String> {
    let mut place = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&place) {
            Ok(target) => place = folder_of(&place).join(target),
            Err(_) => {
                // Canonical paths for folders.
                let folder = fs::canonicalize(folder_of(&place)).map_err(|error| failed(path, error))?;
                return Ok(folder.join(place.file_name().unwrap_or_default()));
            }
        }
    }
    Err(format!("error: cannot write `{}`: its links lead nowhere", shown(path)))
}

/// The folder that a file is in.
fn folder_of(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.unwrap_or(Path::new(".")).to_owned()
}

/// Locks a folder against other builds until the file is dropped; `None` if the system cannot lock folders.
fn lock(folder: &Path) -> Option<fs::File> {
    let file = fs::File::open(folder).ok()?;
    file.lock().ok().map(|()| file)
}

/// Precedes the process id and a number in the name of a temporary file.
const TEMPORARY: &str = ".forcec-";

/// A name that no other build or thread uses.
fn temporary(place: &Path) -> PathBuf {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    place.with_file_name(format!(".{name}{TEMPORARY}{}-{number}", std::process::id()))
}

/// Removes temporary files of killed builds from a locked folder, in which no other build is writing.
fn sweep(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let numbers = name.rsplit_once(TEMPORARY).filter(|(name, _)| name.starts_with('.'));
        let numbers = numbers.and_then(|(_, numbers)| numbers.split_once('-'));
        let digits = |text: &str| !text.is_empty() && text.bytes().all(|digit| digit.is_ascii_digit());
        if numbers.is_some_and(|(process, number)| digits(process) && digits(number)) {
            // A file that cannot be removed does no harm.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The change for an output; `None` if the file has this text, an error if forcec did not generate the file.
fn change(output: &Output, place: PathBuf) -> Result<Option<Change<'_>>, String> {
    let path = &output.path;
    let old = match fs::metadata(&place) {
        Ok(old) => old,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Ok(Some(Change { output, place, old: None }));
        }
        Err(error) => return Err(failed(path, error)),
    };
    if old.is_dir() {
        return Err(failed(path, std::io::ErrorKind::IsADirectory.into()));
    }
    let foreign = |what: &str| {
        let help = "write into another folder, or move the file away";
        Err(format!("error: `{}` {what}; it is left as it is\n  = help: {help}", shown(path)))
    };
    if !old.is_file() {
        return foreign("is not a regular file");
    }
    let text = fs::read(&place).map_err(|error| failed(path, error))?;
    if text == output.text.as_bytes() {
        return Ok(None);
    }
    let ours = text.is_empty()
        || std::str::from_utf8(&text).is_ok_and(|text| emit::is_made(text) || names_kernels(text, path));
    if ours { Ok(Some(Change { output, place, old: Some(old) })) } else { foreign("was not made by forcec") }
}

/// Whether a text only declares generated modules: early build scripts wrote `mod.rs` without a head line.
fn names_kernels(text: &str, path: &Path) -> bool {
    text.lines().all(|line| {
        let stem = line.strip_prefix("pub mod ").and_then(|line| line.strip_suffix(';'));
        let module = stem.map(|stem| path.with_file_name(format!("{stem}.rs")));
        module.is_some_and(|module| fs::read_to_string(module).is_ok_and(|text| emit::is_made(&text)))
    })
}

/// Writes a temporary file, with the permissions of the file that it replaces.
fn fill(temporary: &Path, change: &Change<'_>) -> std::io::Result<()> {
    let mut options = fs::OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    if let Some(old) = &change.old {
        use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
        options.mode(old.mode() & 0o600);
    }
    let mut file = options.open(temporary)?;
    file.write_all(change.output.text.as_bytes())?;
    if let Some(old) = &change.old {
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            // Only a privileged build can restore the owner.
            let _ = std::os::unix::fs::fchown(&file, Some(old.uid()), Some(old.gid()));
        }
        file.set_permissions(old.permissions())?;
    }
    Ok(())
}
