//! `docs/commands.md` is the program's help. `BLESS=1` writes it.

#[test]
fn commands_are_documented_by_their_help() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/commands.md");
    let expected = barnard_cli::manual();
    if std::env::var("BLESS").is_ok_and(|v| v == "1") {
        std::fs::write(&path, &expected).unwrap();
    }
    let page = std::fs::read_to_string(&path).expect("docs/commands.md is missing; BLESS=1 writes it");
    assert!(page == expected, "docs/commands.md is stale; run BLESS=1 cargo test -p barnard-cli --all-features manual");
    assert!(["render", "fit", "view", "study"].iter().all(|verb| page.contains(&format!("## barnard {verb}\n"))));
}
