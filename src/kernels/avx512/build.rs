//! Whether these vectors are compiled: only a processor with AVX-512 takes them.
//!
//! The feature `every-processor`, or a build for another target, compiles them too (`cfg(compiled)`).

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(compiled)");
    let elsewhere = std::env::var_os("HOST") != std::env::var_os("TARGET");
    if std::env::var_os("CARGO_FEATURE_EVERY_PROCESSOR").is_some() || elsewhere || can_run() {
        println!("cargo::rustc-cfg=compiled");
    }
}

/// Whether the processor that builds has AVX-512.
fn can_run() -> bool {
    #[cfg(target_arch = "x86_64")]
    let has = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl");
    #[cfg(not(target_arch = "x86_64"))]
    let has = false;
    has
}
