//! Scene files: the example, its kernels and what it saves as snapshots; and what is said of wrong ones.
//!
//! ```text
//! INSTA_UPDATE=always cargo test -p forcec --test scenes
//! ```

#![cfg(feature = "cli")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn example() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/scene")
}

/// A folder with the example's force file, and a scene.
fn place(name: &str, scene: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("scenes").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::copy(example().join("gate.rs"), folder.join("gate.rs")).unwrap();
    // Not found by a search of the folder.
    let drag = "#[force]\npub fn drag(a: Particle) -> Vec3 { -a.velocity }\n";
    std::fs::write(folder.join("drag.force"), drag).unwrap();
    std::fs::write(folder.join("scene.toml"), scene).unwrap();
    folder
}

fn forcec(folder: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_forcec"));
    command.args(arguments.split(' ')).current_dir(folder).env("NO_COLOR", "1").output().unwrap()
}

fn succeeds(folder: &Path, arguments: &str) -> String {
    let output = forcec(folder, arguments);
    assert!(output.status.success(), "{arguments}:\n{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn refused(name: &str, scene: &str) -> String {
    let output = forcec(&place(name, scene), "build --scene scene.toml");
    assert_eq!(output.status.code(), Some(2), "{scene}");
    String::from_utf8(output.stderr).unwrap()
}

fn assert_snapshot(name: &str, text: &str) {
    insta::with_settings!({ prepend_module_to_snapshot => false, omit_expression => true }, {
        insta::assert_snapshot!(name, text);
    });
}

#[test]
fn the_example() {
    let folder = place("example", &std::fs::read_to_string(example().join("gate.toml")).unwrap());
    assert_snapshot("gate.stats", &succeeds(&folder, "stats --scene scene.toml"));
    let table = succeeds(&folder, "check --scene scene.toml");
    assert_eq!(table.matches("  pass  ").count(), 4, "{table}");
    succeeds(&folder, "build --scene scene.toml");
    succeeds(&folder, "build --scene scene.toml --check");
    let mut names: Vec<PathBuf> =
        std::fs::read_dir(folder.join("kernels")).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.sort();
    for path in &names {
        let name = path.file_name().unwrap().to_string_lossy();
        if name != "forcec.h" {
            assert_snapshot(&name, &std::fs::read_to_string(path).unwrap());
        }
    }
    assert_eq!(names.len(), 7, "{names:?}");
}

/// A build script writes what the command line writes, where it is told to.
#[test]
fn build_scripts_take_scenes() {
    let folder = place("script", &std::fs::read_to_string(example().join("gate.toml")).unwrap());
    let scene = folder.join("scene.toml");
    let build = || forcec::Build::new().scene(&scene).out(folder.join("written"));
    let (files, warnings) = build().try_run().unwrap();
    succeeds(&folder, "build --scene scene.toml --target rust");
    let mut texts = 0;
    for path in files.iter().filter(|path| !path.ends_with("mod.rs")) {
        let other = folder.join("kernels").join(path.file_name().unwrap());
        assert_eq!(std::fs::read_to_string(path).unwrap(), std::fs::read_to_string(other).unwrap());
        texts += 1;
    }
    assert_eq!((texts, warnings.len()), (3, 0), "{files:?}");
    let modules = std::fs::read_to_string(folder.join("written/mod.rs")).unwrap();
    assert_eq!(
        modules,
        "// Made by forcec from the files beside it; the code is yours.\npub mod gate;\npub mod gate_system;\npub mod gate_x4;\n"
    );

    let (files, _) = build().target(forcec::Target::C).real(forcec::Precision::F32).try_run().unwrap();
    assert!(files.iter().any(|path| path.ends_with("gate_x4.c")), "{files:?}");
    let text = std::fs::read_to_string(folder.join("written/gate_x4.c")).unwrap();
    assert!(text.contains("_f32") && !text.contains("_f64"));

    for refused in [build().lanes(4), build().input("gate.rs")] {
        let error = refused.try_run().unwrap_err().to_string();
        assert!(error.starts_with("error: a scene says itself what is compiled and how"), "{error}");
    }
    std::fs::write(&scene, "forces = [\"gate.rs\"]\n[[kernel]]\nfunction = \"hing\"\n").unwrap();
    let error = build().try_run().unwrap_err();
    assert_eq!((error.diagnostics.len(), error.others.len()), (1, 0));
    assert!(error.to_string().contains("did you mean `hinge`?"), "{error}");
}

/// An integrator says which kernels there are; equal ones are written once, and the command's own target goes first.
#[test]
fn an_integrator_decides() {
    let entry = "[[kernel]]\nfunction = \"weight\"\n";
    let scene =
        format!("forces = \".\"\nintegrator = \"matrix-free\"\ntarget = [\"c\", \"rust\"]\n{entry}{entry}");
    let folder = place("decides", &scene);
    let stats = succeeds(&folder, "stats --scene scene.toml");
    assert!(stats.contains("weight_product") && stats.contains("written once: 2"), "{stats}");
    succeeds(&folder, "build --scene scene.toml --target rust --out own");
    let mut written: Vec<String> = std::fs::read_dir(folder.join("own"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    written.sort();
    assert_eq!(written, ["gate.rs", "gate_product.rs"]);
}

/// What holds for the whole scene holds for the functions that it fits, and what a kernel states goes before it.
#[test]
fn a_kernel_goes_before_its_scene() {
    let scene = "forces = [\"gate.rs\"]\nintegrator = \"explicit\"\nfixed = [\"post\"]\nset = { damping = 0.0 }\n\
                 [[kernel]]\nfunction = \"closer\"\nset = { damping = 2.0 }\n[[kernel]]\nfunction = \"weight\"\n";
    let folder = place("before", scene);
    succeeds(&folder, "build --scene scene.toml");
    let kernels = std::fs::read_to_string(folder.join("kernels/gate.c")).unwrap();
    assert!(
        kernels.contains("closer_fixed_post_set_damping_f64") && kernels.contains("damping = 2"),
        "{kernels}"
    );
    assert!(kernels.contains("void weight_f64("), "{kernels}");
}

#[test]
fn wrong_scenes() {
    let mut text = String::new();
    for (name, scene) in [
        (
            "keys",
            "forces = [\"gate.rs\"]\nintegrator = \"implicitt\"\nlanes = 3\nefort = \"max\"\n\
                  [[kernel]]\nfunction = \"hinge\"\nfixd = [\"post\"]\nset = { arm_post = \"x\" }\n",
        ),
        (
            "kernels",
            "forces = [\"gate.rs\"]\n[[kernel]]\nname = \"1a\"\nfma = 3\n\
                     [[kernel]]\nfunction = \"ground\"\nintegrator = \"explicit\"\nlayout = \"packed\"\ntarget = \"c\"\n",
        ),
        (
            "names",
            "forces = [\"gate.rs\"]\nintegrator = \"implicit\"\nfixed = [\"poste\"]\n\
                   [[kernel]]\nfunction = \"hing\"\n\
                   [[kernel]]\nfunction = \"hinge\"\nfixed = [\"pst\"]\nset = { arm_post = [1, 2], stifness = 3, step = 0.01 }\n\
                   [[kernel]]\nfunction = \"ground\"\nfixed = [\"gate\"]\n",
        ),
        (
            "twice",
            "forces = [\"gate.rs\"]\nintegrator = \"newton\"\n\
                   [[kernel]]\nfunction = \"weight\"\n[[kernel]]\nfunction = \"weight\"\nmode = \"fast\"\n",
        ),
        (
            "conflict",
            "forces = [\"gate.rs\"]\n[[kernel]]\nfunction = \"weight\"\nlayout = \"system\"\noutputs = \"force\"\n",
        ),
        (
            "lanes",
            "forces = [\"gate.rs\"]\nlanes = 4\n[[kernel]]\nfunction = \"weight\"\nlayout = \"accumulate\"\n",
        ),
        (
            "value",
            "forces = \"drag.force\"\n[[kernel]]\nfunction = \"drag\"\nintegrator = \"xpbd\"\n\
             [[kernel]]\nfunction = \"drag\"\noutputs = \"value\"\n",
        ),
        (
            "meet",
            "forces = [\"gate.rs\"]\n[[kernel]]\nfunction = \"weight\"\nname = \"x\"\n\
             [[kernel]]\nfunction = \"hinge\"\nname = \"x_params\"\n",
        ),
        (
            "types",
            "forces = [\"gate.rs\"]\nintegrator = \"euler\"\nlanes = \"4\"\neffort = 3\n\
             [[kernel]]\nfunction = \"weight\"\noutputs = []\nprepare = \"true\"\n",
        ),
        ("none", "forces = []\n[[kernel]]\nfunction = \"weight\"\n"),
        ("file", "forces = [\"gates.rs\"]\n[[kernel]]\nfunction = \"weight\"\n"),
        ("text", "forces = [\"gate.rs\"]\n[[kernel]\nfunction = 3\n"),
        ("type", "forces = [\"gate.rs\"]\n[[kernel]]\nfunction = 3\n"),
        ("empty", ""),
    ] {
        text.push_str(&format!("== {name}\n{}\n", refused(name, scene)));
    }
    assert_snapshot("wrong_scenes", &text);
    let folder = place("options", "forces = [\"gate.rs\"]\n[[kernel]]\nfunction = \"weight\"\n");
    let output = forcec(&folder, "build --scene scene.toml --lanes 4");
    assert!(String::from_utf8_lossy(&output.stderr).contains("a scene says itself"), "{output:?}");
}

/// The table of a packed kernel is a name in C like that of any kernel.
#[test]
fn tables_meet_kernels() {
    let scene = "forces = [\"p.rs\"]\nout = \"k\"\n[[kernel]]\nfunction = \"p\"\nlayout = \"packed\"\n\
                 [[kernel]]\nfunction = \"p_packed_dfdx\"\n";
    let folder = place("tables", scene);
    let text = ["p", "p_packed_dfdx"].map(|name| {
        format!("#[energy]\npub fn {name}(a: Particle) -> Real {{ a.position.norm_squared() }}\n")
    });
    std::fs::write(folder.join("p.rs"), text.concat()).unwrap();
    let output = forcec(&folder, "build --scene scene.toml");
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("`p_packed_dfdx`"), "{message}");
}
