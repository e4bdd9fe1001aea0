use super::*;

const GOOD: &str = "concentric-layout: 1
# The corner plate. Lengths in mm.
code: five

ink: dark
id,x_mm,y_mm,z_mm,radii_mm
32,-40,-30,0,5 2.5   # top left
,-20.125,-30,0.5,5 2.5
";

#[test]
fn a_layout_is_read_and_written_back() {
    let layout = Layout::parse(GOOD).unwrap();
    assert_eq!(layout.code, Some(CodeName::Five));
    assert_eq!(layout.targets[0].id, Some(32));
    let plain = LayoutTarget { id: None, position: [-20.125, -30.0, 0.5], radii: vec![5.0, 2.5] };
    assert_eq!(layout.targets[1], plain);
    assert_eq!(Layout::parse(&layout.text()).unwrap(), layout);
    let thirds = Layout {
        light: true,
        targets: vec![LayoutTarget { position: [1.0 / 3.0, -1e-7, 2e5], ..plain }],
        ..layout.clone()
    };
    assert_eq!(Layout::parse(&thirds.text()).unwrap(), thirds);
    assert_eq!(layout.settings_code().unwrap(), Some(Code::five().only(&[32]).unwrap()));
}

/// A line of the good layout exchanged for another, and what must then be said.
#[test]
fn what_is_wrong_is_named_with_line_and_field() {
    let columns = COLUMNS;
    for (line, text, message) in [
        (1, "", "no version: the first line must be `concentric-layout: 1`"),
        (1, "layout: 1", "line 1: no version"),
        (1, "concentric-layout: 2", "line 1: version `2` is not known; this program reads version 1"),
        (3, "code: aicon", "line 3: code `aicon` is not known; must be none, cct14, cct12 or five"),
        (3, "code: none", "line 7: id `32` in a layout without a code"),
        (4, "ink: dark", "line 5: ink is given twice"),
        (5, "ink: red", "line 5: ink `red` must be dark or light"),
        (5, "colour: red", "line 5: unknown field `colour`; must be code or ink"),
        (5, "hello", "line 5: `hello` is neither a setting nor"),
        (6, "id,x_mm,y_mm,z_mm,diameter_mm", "line 6: unknown field `diameter_mm`; the fields are"),
        (6, "x_mm,id,y_mm,z_mm,radii_mm", "line 6: the fields must be"),
        (6, "", "line 7: unknown field `32`"),
        (7, "33,-40,-30,0,5 2.5", "line 7: id 33 is not in the code five: must be 32, 123, 336, 366, 515"),
        (7, "3a,-40,-30,0,5 2.5", "line 7: id `3a` is no number"),
        (7, "32,-40,,0,5 2.5", "line 7: y_mm: `` is no number"),
        (7, "32,-40,nan,0,5 2.5", "line 7: y_mm: `nan` is no number"),
        (7, "32,-4e9,0,0,5 2.5", "line 7: x_mm = -4e9 is outside"),
        (7, "32,-40,-30,0,2.5 5", "line 7: radii_mm = 2.5 5 must fall: the outer circle comes first"),
        (7, "32,-40,-30,0,5 0", "line 7: radii_mm = 5 0: each must be 0.001 to"),
        (7, "32,-40,-30,0,5", "line 7: radii_mm: 1 given; must be 2 to 4"),
        (7, "32,-40,-30,0", "line 7: 4 fields given: must be 5"),
        (8, "32,40,-30,0,5 2.5", "line 8: id 32 is given twice: the first time in line 7"),
        (8, ",-40,-30,0,4 2", "line 8: x_mm, y_mm, z_mm are those of the target in line 7"),
        (8, ",-34,-30,0,4 2", "line 8: the target overlaps with that in line 7"),
    ] {
        let mut lines: Vec<_> = GOOD.lines().collect();
        lines[line - 1] = text;
        let error = format!("{:#}", Layout::parse(&lines.join("\n")).expect_err(message));
        assert!(error.contains(message), "{text}: {error}");
    }
    let error = format!("{:#}", Layout::parse(&format!("concentric-layout: 1\n{columns}\n")).unwrap_err());
    assert!(error.contains("no targets"), "{error}");
    let error = format!("{:#}", Layout::parse("concentric-layout: 1\ncode: five").unwrap_err());
    assert!(error.contains("is missing"), "{error}");
}

#[test]
fn files_are_named_in_errors() {
    let error = format!("{:#}", Layout::read(Path::new("nowhere.layout")).unwrap_err());
    assert!(error.contains("cannot read layout nowhere.layout"), "{error}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plate.layout");
    fs::write(&path, GOOD.replace("5 2.5 ", "2 2.5 ")).unwrap();
    let error = format!("{:#}", Layout::read(&path).unwrap_err());
    assert!(error.contains("plate.layout: line 7: radii_mm"), "{error}");
    let layout = Layout::parse(GOOD).unwrap();
    layout.write(&path).unwrap();
    assert_eq!(Layout::read(&path).unwrap(), layout);
}
