//! The command `accuracy`.

use super::support::{Folder, assert_refused, text};

#[test]
fn it_writes_where_it_is_told() {
    let folder = Folder::new();
    let few = ["accuracy", "--quick", "--cell", "size: R10 w0", "--frames", "5", "--method", "none,exact"];
    let output = folder.run(&few);
    let table = text(&output.stdout);
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), String::new()));
    assert!(
        ["none\n", "exact\n", "size: R10 w0\n", "RMS / bound"].iter().all(|part| table.contains(part)),
        "{table}"
    );
    assert_eq!(std::fs::read_dir(folder.path("")).unwrap().count(), 0, "nothing is written with --cell");

    let output = folder.run(&[&few[..], &["--out", "new/folder"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let page = std::fs::read_to_string(folder.path("new/folder/accuracy.md")).unwrap();
    assert!(page.contains("| R10 w0 | 5 | 5 |"), "{page}");
    let lines = std::fs::read_to_string(folder.path("new/folder/accuracy.csv")).unwrap();
    let columns: Vec<_> = lines.lines().map(|line| line.split(',').count()).collect();
    assert!(columns.len() > 2 && columns.iter().all(|count| *count == columns[0]), "{lines}");
    for plot in ["bound.svg", "sigma.svg"] {
        let svg = std::fs::read_to_string(folder.path("new/folder").join(plot)).unwrap();
        assert!(svg.trim_end().ends_with("</svg>") && page.contains(plot));
    }
}

#[test]
fn it_refuses_what_it_cannot_do() {
    let folder = Folder::new();
    folder.write("file", b"");
    for (arguments, parts) in [
        (&["--frames", "0"][..], &["--frames", "0 is not in 1..="][..]),
        (&["--frames", "many"], &["--frames", "many"]),
        (&["--method", "best"], &["--method", "best", "exact"]),
    ] {
        let output = folder.run(&[&["accuracy", "--quick"], arguments].concat());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    }
    assert_refused(&folder.run(&["accuracy", "--cell", "R1000"]), &["--cell R1000", "no cell"]);
    assert_refused(
        &folder.run(&["accuracy", "--out", "file/below"]),
        &["cannot write to the folder file/below"],
    );
}
