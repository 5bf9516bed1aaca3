//! The manual is the catalogues': `docs/scene-format.md` must be what they print. `BLESS=1` writes it.

#[test]
fn the_manual_is_made_of_the_catalogues() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scene-format.md");
    let expected = barnard::scene::manual();
    if std::env::var("BLESS").is_ok_and(|v| v == "1") {
        std::fs::write(&path, &expected).unwrap();
    }
    let page = std::fs::read_to_string(&path).expect("docs/scene-format.md is missing; BLESS=1 writes it");
    assert!(page == expected, "docs/scene-format.md is stale; run BLESS=1 cargo test -p barnard --test manual");
}

/// The scene that the manual shows is one that works.
#[test]
fn the_manuals_example_is_a_scene() {
    let manual = barnard::scene::manual();
    let example = manual.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let loader = barnard::scene::Loader::in_folder(".", barnard::scene::DEFAULT_MEMORY);
    let scene = barnard::scene::Scene::parse("example", "example", example.to_owned(), &loader).unwrap();
    assert_eq!((scene.bands.len(), scene.stars.len()), (3, 1));
}
