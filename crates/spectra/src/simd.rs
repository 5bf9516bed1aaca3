//! Functions compiled for several instruction sets.

/// Compiles a function for each instruction set with wide registers and picks one when it is first called: AVX-512,
/// AVX2 with FMA, NEON, and whatever the target has.
///
/// Each compiles everything that is inlined into the function once more, so such a function shall be small: large
/// parts get a function of their own.
#[macro_export]
macro_rules! simd {
    ($($function:tt)+) => {
        #[::multiversion::multiversion(targets(
            "x86_64+avx512f+avx512vl+avx512bw+avx512dq+avx2+fma+bmi1+bmi2",
            "x86_64+avx2+fma+bmi1+bmi2",
            "aarch64+neon"
        ))]
        $($function)+
    };
}
