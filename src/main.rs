//! The `catena` program.

fn main() -> std::process::ExitCode {
    catena::cli::main()
}
