# Commands for daily work. CONTRIBUTING.md has them without `just`; `just --list` shows them.

# Edits rebuild in seconds instead of minutes.
export CARGO_INCREMENTAL := "1"

# Format, types and lints.
check:
    cargo fmt --check
    cargo clippy --release --all-targets --all-features -- -D warnings

# All tests, or some: `just test --test renderer fog`.
test *args:
    cargo test --release {{ args }}

# Write golden pictures, schema and contract anew. Look at every picture that has changed.
bless:
    UPDATE_GOLDEN=1 cargo test --release
    git status --short

# Instruction counts against the recorded ones.
bench:
    cargo build --release
    python3 benches/instructions/check.py

# The service, on http://127.0.0.1:8080.
run *flags:
    cargo run --release -- serve {{ flags }}

# The book into target/book, the library's documentation into target/doc.
docs:
    mdbook build
    cargo doc --release --no-deps
