//! Compiles the joints of Jolt, with the flags that `joltc-sys` compiles Jolt with.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    #[cfg(feature = "jolt")]
    jolt::compile();
}

#[cfg(feature = "jolt")]
mod jolt {
    use std::env;
    use std::path::PathBuf;
    use std::process::Command;

    const SOURCE: &str = "src/engines/jolt/joints.cpp";

    pub(super) fn compile() {
        println!("cargo::rerun-if-changed={SOURCE}");
        let mut build = cc::Build::new();
        build
            .cpp(true)
            .std("c++17")
            .file(SOURCE)
            .include(headers().join("JoltC/JoltPhysics"))
            .opt_level(3)
            .warnings(false);
        // As its CMake files have it for `Release`; what differs is told by `arena_jolt_fits`.
        for name in ["NDEBUG", "JPH_DEBUG_RENDERER", "JPH_PROFILE_ENABLED"] {
            build.define(name, None);
        }
        if env::var("CARGO_CFG_TARGET_ARCH").as_deref() == Ok("x86_64") {
            for set in [
                "AVX2", "AVX", "SSE4_1", "SSE4_2", "LZCNT", "TZCNT", "F16C", "FMADD",
            ] {
                build.define(&format!("JPH_USE_{set}"), None);
            }
            for flag in ["-mavx2", "-mbmi", "-mpopcnt", "-mlzcnt", "-mf16c", "-mfma"] {
                build.flag(flag);
            }
        }
        for flag in ["-fno-rtti", "-fno-exceptions", "-ffp-contract=off"] {
            build.flag(flag);
        }
        build.compile("arena_jolt_joints");
    }

    /// The folder of `joltc-sys`, which brings Jolt's headers but does not tell where they are.
    fn headers() -> PathBuf {
        let cargo = env::var_os("CARGO").expect("set by cargo");
        let metadata = Command::new(cargo)
            .args(["metadata", "--format-version", "1", "--offline", "--locked"])
            .output()
            .expect("cargo metadata");
        let text = String::from_utf8_lossy(&metadata.stdout);
        let manifests = text.split("\"manifest_path\":\"").skip(1);
        let mut paths = manifests.filter_map(|rest| rest.split('"').next().map(PathBuf::from));
        let is_jolt = |path: &PathBuf| {
            let folder = path.parent().and_then(|folder| folder.file_name());
            folder.is_some_and(|name| name.to_string_lossy().starts_with("joltc-sys"))
        };
        let manifest = paths.find(is_jolt).expect("joltc-sys among the packages");
        manifest.parent().expect("a folder").into()
    }
}
