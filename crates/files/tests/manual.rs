//! The manual is the catalogues': `docs/scene-format.md` must be what they print. `BLESS=1` writes it.

#[test]
fn the_manual_is_made_of_the_catalogues() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scene-format.md");
    let expected = barnard_files::manual();
    if std::env::var("BLESS").is_ok_and(|v| v == "1") {
        std::fs::write(&path, &expected).unwrap();
    }
    let page = std::fs::read_to_string(&path).expect("docs/scene-format.md is missing; BLESS=1 writes it");
    assert!(page == expected, "docs/scene-format.md is stale; run BLESS=1 cargo test -p barnard-files --test suite manual");
}

/// The scene that the manual shows is one that works.
#[test]
fn the_manuals_example_is_a_scene() {
    let manual = barnard_files::manual();
    let example = manual.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let loader = barnard_files::in_folder(".", barnard::memory::DEFAULT_LIMIT);
    let scene = barnard_files::parse("example", "example", example.to_owned(), &loader).unwrap();
    assert_eq!((scene.bands.len(), scene.stars.len()), (3, 1));
}

/// Every equation of docs/method.md is cited by the code that evaluates it, and nothing is cited that is not there.
#[test]
fn equations_are_cited() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = std::fs::read_to_string(root.join("docs/method.md")).unwrap();
    let number = |text: &str| text.split(')').next().and_then(|n| n.parse::<usize>().ok());
    // A number at the end of a line of a formula.
    let stated: Vec<usize> = page.lines().filter_map(|l| l.strip_suffix(')')?.rsplit_once('(').and_then(|(_, n)| n.parse().ok())).collect();
    assert_eq!(stated, (1..=stated.len()).collect::<Vec<_>>());
    let mut cited = std::collections::BTreeSet::new();
    let mut folders = vec![root.join("crates")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
            if entry.is_dir() {
                folders.push(entry);
            } else if entry.extension().is_some_and(|e| e == "rs") && !entry.ends_with("manual.rs") {
                let source = std::fs::read_to_string(&entry).unwrap();
                let files = source.contains("docs/method.md");
                let cites = source
                    .match_indices("eq. (")
                    .chain(source.match_indices("eqs. ("))
                    .filter_map(|(at, m)| number(&source[at + m.len()..]));
                cited.extend(cites.filter(|_| files));
                cited.extend(source.match_indices("and (").filter(|_| files).filter_map(|(at, m)| number(&source[at + m.len()..])));
            }
        }
    }
    assert_eq!(cited.into_iter().collect::<Vec<_>>(), stated);
}
