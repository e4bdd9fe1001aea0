//! The specification tells the truth: its examples are what the encoder sends, its lists are those of the code.

use concentric::report::{
    ANSWER_MAX_LEN, Answer, COMMAND_MAX_LEN, Command, CommandDecoder, Detail, Format, HELLO_MAX_LEN,
    HeadSettings, Hello, Outcome, Ratios, Report, Request, Version,
};
use concentric::{
    Circle, Compensation, Covariance, Effort, Ellipse, Flags, Polarity, Position, Reject, Settings, Summary,
    Target, TargetSpec,
};

use crate::support::{LEN, at, outcomes};

const SPECIFICATION: &str = include_str!("../../../src/report/SPECIFICATION.md");

/// The text below the heading `title` up to the next heading.
fn section(title: &str) -> &'static str {
    let (_, rest) = SPECIFICATION.split_once(&format!("\n### {title}\n")).expect(title);
    rest.split("\n#").next().unwrap()
}

fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace().map(|byte| u8::from_str_radix(byte, 16).expect(byte)).collect()
}

fn print(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02X} ")).collect()
}

/// The bytes in the first column of the table, one field a row.
fn fields(section: &str) -> Vec<u8> {
    let cells = section.lines().filter_map(|line| line.strip_prefix("| `")?.split_once('`'));
    cells.flat_map(|(bytes, _)| hex(bytes)).collect()
}

/// The bytes in the block below the table.
fn wire(section: &str) -> Vec<u8> {
    hex(section.split("```").nth(1).unwrap().strip_prefix("text").unwrap())
}

fn check(title: &str, sent: &[u8]) {
    let section = section(title);
    let message = sent.strip_prefix(&[0]).unwrap_or(sent).strip_suffix(&[0]).unwrap();
    let plain = cobs::decode_vec(message).unwrap();
    assert_eq!(print(&fields(section)), print(&plain), "{title}, field by field");
    assert_eq!(print(&wire(section)), print(sent), "{title}, on the wire");
}

#[test]
fn the_example_of_a_hello() {
    let hello = Hello {
        library: Version { major: 0, minor: 1, patch: 0 },
        ..Hello::new(Version { major: 1, minor: 4, patch: 0 }, 1280, Detail::Normal)
    };
    check("A hello", hello.encode(&mut [0; HELLO_MAX_LEN]).unwrap());
}

#[test]
fn a_hello_names_this_library() {
    let Version { major, minor, patch } = Hello::new(Version::default(), 0, Detail::Terse).library;
    assert_eq!(format!("{major}.{minor}.{patch}"), env!("CARGO_PKG_VERSION"));
}

#[test]
fn the_example_of_a_frame_report() {
    let mut target = Target {
        centre: at(320.25, 239.5),
        covariance: Covariance { xx: 0.005 * 0.005, xy: -0.25 * 0.005 * 0.004, yy: 0.004 * 0.004 },
        flags: Flags::MEASURED_RATIO,
        ..Target::default()
    };
    let ellipse = Ellipse { centre: Position::default(), a: 41.5, b: 30.0, theta: 0.5 };
    target.circles.push(Circle { ellipse, rms: 0.03, ..Circle::default() }).unwrap();
    let rejected = [(Reject::TooSmall, 2), (Reject::Alone, 1)].into_iter().collect();
    let summary = Summary { width: 640, height: 480, targets: 1, rejected, ..Summary::default() };
    let mut report = Report::<1>::new(Detail::Normal);
    report.begin(300);
    report.push(&target);
    check("A frame report", report.finish(&summary, &mut [0; LEN]).unwrap());
}

fn command() -> Command {
    Command { tag: 7, request: Request::Ratios(Ratios::from_slice(&[49152, 32768]).unwrap()) }
}

fn answer() -> Answer {
    let settings = HeadSettings::new(&Settings::new(TargetSpec::any()), Detail::Normal, Format::Binary, 0);
    Answer { tag: 8, outcome: Outcome::Ratio { value: 63569, min: 6554, max: 62259 }, settings }
}

#[test]
fn the_example_of_a_command() {
    check("A command", command().encode(&mut [0; COMMAND_MAX_LEN]).unwrap());
    let mut decoder = CommandDecoder::new();
    let decoded: Vec<_> =
        wire(section("A command")).into_iter().filter_map(|byte| decoder.push(byte)).collect();
    assert_eq!(decoded, [Ok(command())]);
}

#[test]
fn the_example_of_an_answer() {
    check("An answer", answer().encode(&mut [0; ANSWER_MAX_LEN]).unwrap());
    let decoded = outcomes::<LEN>(&wire(section("An answer")));
    assert_eq!(decoded, [crate::support::Outcome::Answer(answer())]);
}

/// The number and the name in the rows of the table whose first column has this heading.
fn numbered(heading: &str) -> Vec<(u8, String)> {
    let (_, table) = SPECIFICATION.split_once(&format!("\n| {heading} | |")).expect(heading);
    let rows = table.lines().skip(2).take_while(|line| line.starts_with("| "));
    let cells = rows.map(|row| row.split('|').map(str::trim).collect::<Vec<_>>());
    cells.map(|cells| (cells[1].parse().unwrap(), cells[2].to_owned())).collect()
}

#[test]
fn requests_and_outcomes_have_the_numbers_of_their_tables() {
    let requests = [
        ("settings", Request::Settings),
        ("hello", Request::Hello),
        ("ratios", Request::Ratios(Ratios::new())),
        ("polarity", Request::Polarity(Polarity::Light)),
        ("compensation", Request::Compensation(Compensation::Known)),
        ("detail", Request::Detail(Detail::Full)),
        ("format", Request::Format(Format::Text)),
        ("whole every", Request::WholeEvery(10)),
        ("px per run", Request::PxPerRun(32)),
        ("effort", Request::Effort(Effort::Quick)),
    ];
    let sent = requests.map(|(name, request)| {
        let mut buffer = [0; COMMAND_MAX_LEN];
        let message = Command { tag: 1, request }.encode(&mut buffer).unwrap().to_vec();
        (cobs::decode_vec(&message[1..message.len() - 1]).unwrap()[3], name.to_owned())
    });
    assert_eq!(numbered("request"), sent);
    let outcomes = [
        ("done", Outcome::Done),
        ("a ratio is outside its range", Outcome::Ratio { value: 1, min: 2, max: 3 }),
        ("too many ratios", Outcome::RatioCount { given: 4, max: 3 }),
        ("`known` needs a camera", Outcome::NoCamera),
        ("intact, and no command of this version", Outcome::Unknown),
        ("damaged, or cut short", Outcome::Damaged),
    ];
    let sent = outcomes.map(|(name, outcome)| {
        let mut buffer = [0; ANSWER_MAX_LEN];
        let message = Answer { outcome, ..answer() }.encode(&mut buffer).unwrap().to_vec();
        (cobs::decode_vec(&message[1..message.len() - 1]).unwrap()[3], name.to_owned())
    });
    assert_eq!(numbered("outcome"), sent);
}

#[test]
fn the_examples_are_decoded() {
    let stream = [wire(section("A hello")), wire(section("A frame report"))].concat();
    assert!(outcomes::<LEN>(&stream).iter().all(|one| !matches!(one, crate::support::Outcome::Damaged(_))));
}

#[test]
fn causes_and_flags_are_listed_in_wire_order() {
    let causes: Vec<String> = Reject::ALL.iter().map(|(_, name)| format!("`{name}`")).collect();
    let row = format!("| rejected | {} `u32` |", causes.len());
    let line = SPECIFICATION.lines().find(|line| line.starts_with(&row)).expect(&row);
    assert!(line.contains(&causes.join(", ")), "{}", causes.join(", "));
    for (flag, name) in Flags::NAMES {
        let row = format!("\n| `{name}` | {} |", flag.0.trailing_zeros());
        assert!(SPECIFICATION.contains(&row), "{row}");
    }
}
