//! The command `barnard`: renders three-dimensional nebulae as telescopes would record them, in calibrated units.

fn main() -> std::process::ExitCode {
    // Mesa's layer that sorts devices looks for a Wayland compositor, and prints an error outside of a desktop session.
    #[cfg(target_os = "linux")]
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        // SAFETY: no other thread has been started.
        unsafe { std::env::set_var("NODEVICE_SELECT", "1") };
    }
    barnard_cli::run(std::env::args_os())
}
