//! Which vectors are compiled: a processor with AVX-512 takes those of AVX2 up to four lanes only, and its own for more.
//!
//! The feature `every-processor`, or a build for another target, compiles all of them (`cfg(wide)`).

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(wide)");
    if std::env::var_os("CARGO_FEATURE_EVERY_PROCESSOR").is_some() || !takes_wider_ones() {
        println!("cargo::rustc-cfg=wide");
    }
}

/// Whether programs run here, on a processor with AVX-512.
fn takes_wider_ones() -> bool {
    #[cfg(target_arch = "x86_64")]
    let has = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl");
    #[cfg(not(target_arch = "x86_64"))]
    let has = false;
    has && std::env::var_os("HOST") == std::env::var_os("TARGET")
}
