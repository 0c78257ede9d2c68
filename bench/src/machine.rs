//! The setting of measurements: the processor, the date, the compiler.

use std::collections::BTreeSet;
use std::process::Command;

/// The first line that a program prints.
pub fn first_line(program: &str, arguments: &[&str]) -> String {
    let output = Command::new(program).args(arguments).output().map(|output| output.stdout);
    let text = String::from_utf8_lossy(&output.unwrap_or_default()).into_owned();
    text.lines().next().unwrap_or("unknown").trim().to_owned()
}

/// The processor and the date.
pub fn machine() -> String {
    let processors = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = processors.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    format!("{}; {}", name.map_or("unknown processor", |(_, name)| name), first_line("date", &["+%F"]))
}

/// Programs with their versions, each once.
pub fn versions<'a>(programs: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<String> {
    let versions: BTreeSet<String> = programs.map(|(name, version)| format!("{name} {version}")).collect();
    versions.into_iter().collect()
}

/// The compiler of the Rust code, with its version.
pub fn rustc() -> String {
    first_line("rustc", &["--version"])
}
