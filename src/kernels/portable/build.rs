//! Which vectors are compiled: a processor with AVX2 takes none of these, so that one width for all numbers of stages is enough.
//!
//! That width makes programs right on every processor. The feature `every-processor`, a processor without AVX2, or a build for another target compiles
//! the narrow vectors too (`cfg(narrow)`).

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(narrow)");
    if std::env::var_os("CARGO_FEATURE_EVERY_PROCESSOR").is_some() || !takes_others() {
        println!("cargo::rustc-cfg=narrow");
    }
}

/// Whether programs run here, on a processor with AVX2.
fn takes_others() -> bool {
    #[cfg(target_arch = "x86_64")]
    let has = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    #[cfg(not(target_arch = "x86_64"))]
    let has = false;
    has && std::env::var_os("HOST") == std::env::var_os("TARGET")
}
