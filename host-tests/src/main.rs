//! The program `concentric`.

fn main() -> std::process::ExitCode {
    concentric_host::cli::main()
}
