//! The firmware on emulated boards (Cortex-M4F, Cortex-M7, RV32IMC) sends, byte for byte, what the desktop computes, and obeys
//! commands.

use std::env;
use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result, ensure};
use concentric::report::{
    Answer, COMMAND_MAX_LEN, Command, Decoder, Detail, HELLO_MAX_LEN, Hello, Message, Outcome, Ratios,
    Report, Request, max_len,
};
use concentric::track::Tracker;
use concentric::{Detector, Image, Run, Settings, TargetSpec};
use concentric_host::link::protocol::{Frame, HeadStorage, MAX_TARGETS, MAX_WIDTH, VERSION};
use concentric_host::link::{Head, MPS2_AN386, MPS2_AN500, Machine, RISCV_VIRT, Serial, runs, sample_frames};
use concentric_host::picture::Picture;
use concentric_host::render::{Artwork, Camera, Scene, Shading, Style};

const ANY: u32 = 0;
const HALF: u32 = Frame::RATIO_ONE / 2;
const EXACT: u32 = 2;
const AUTO: u32 = 3;
const FULL: u32 = 2;

/// A frame, and how it is to be measured.
struct Case {
    name: &'static str,
    frame: Frame,
    pixels: Vec<u8>,
}

impl Case {
    fn new(name: &'static str, ratio: u32, width: u32, pixels: Vec<u8>) -> Self {
        let height = pixels.len() as u32 / width;
        Self {
            name,
            frame: Frame { width, height, ratio, light: 0, compensation: EXACT, detail: FULL },
            pixels,
        }
    }

    fn rendered(name: &'static str, ratio: u32, scene: &Scene) -> Self {
        let frame = scene.render(1);
        Self::new(name, ratio, frame.width as u32, frame.pixels)
    }

    fn light(mut self) -> Self {
        self.frame.light = 1;
        self
    }

    fn compensation(mut self, compensation: u32) -> Self {
        self.frame.compensation = compensation;
        self
    }

    fn detail(mut self, detail: u32) -> Self {
        self.frame.detail = detail;
        self
    }
}

/// Empty, crowded, noisy, cluttered, dim, bright, unevenly lit; and more than any buffer holds.
fn cases() -> Result<Vec<Case>> {
    let many = |count, width, height, clutter| Scene::many(count, width, height, clutter, 7);
    let empty = |width, height| Scene::empty(Camera::new(width, height, 1000.0));
    let lit = |black, white, shading, noise| {
        many(20, 640, 480, true).map(|mut scene| {
            let light = &mut scene.photometry;
            (light.black, light.white, light.shading, light.noise) = (black, white, shading, noise);
            scene
        })
    };
    let slope = Shading { fraction: 0.3, span: 60.0, direction: 30.0, x: 320.0, y: 240.0 };
    let mut drawn = empty(640, 480);
    drawn.crowd(8, &Artwork { style: Style::Lines(1.5), ..Artwork::annulus(10.0, 5.0) }, 3)?;
    let inverse = many(20, 640, 480, false)?.render(1).pixels.iter().map(|grey| 255 - grey).collect();
    let board = |x: usize, y: usize| if (x / 3 + y / 3).is_multiple_of(2) { 30 } else { 220 };
    let checkers = (0..1024).flat_map(|y| (0..1280).map(move |x| board(x, y))).collect();
    let mut state = 1u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    Ok(vec![
        Case::rendered("empty, small", ANY, &empty(320, 240)),
        Case::rendered("empty, large", HALF, &empty(1280, 1024)),
        Case::new("black", ANY, 320, vec![0; 320 * 240]),
        Case::rendered("one tilted target", HALF, &Scene::single(40.0, 60.0, 30.0, [0.3, 0.7])).detail(1),
        Case::rendered("one tilted target, eq. (7)", HALF, &Scene::single(40.0, 60.0, 30.0, [0.3, 0.7]))
            .compensation(1),
        Case::rendered("few targets", ANY, &many(6, 320, 240, false)?).detail(1),
        Case::rendered("odd size, terse, not corrected", HALF, &many(12, 637, 479, false)?)
            .compensation(0)
            .detail(0),
        Case::rendered("60 targets", HALF, &many(60, 640, 480, false)?),
        Case::rendered("60 targets, large", HALF, &many(60, 1280, 1024, false)?),
        Case::rendered("60 targets of any ratio, large", ANY, &many(60, 1280, 1024, false)?),
        Case::rendered("60 targets in clutter", HALF, &many(60, 640, 480, true)?),
        Case::rendered("60 targets in clutter, large", ANY, &many(60, 1280, 1024, true)?),
        Case::rendered("noisy", HALF, &lit(30.0, 220.0, None, 12.0)?).compensation(AUTO),
        Case::rendered("dim", HALF, &lit(20.0, 60.0, None, 2.0)?),
        Case::rendered("bright", HALF, &lit(190.0, 240.0, None, 2.0)?),
        Case::rendered("unevenly lit", ANY, &lit(30.0, 150.0, Some(slope), 2.0)?),
        Case::new("light on dark", HALF, 640, inverse).light(),
        Case::rendered("circles drawn as lines", ANY, &drawn),
        Case::new("checkerboard", ANY, 1280, checkers),
        Case::new("nothing but noise", ANY, 640, (0..640 * 480).map(|_| random()).collect()),
    ])
}

/// What a desktop that measures the same frames sends.
struct Desktop {
    /// One for all frames: a limited search takes the least contrast of the last whole one.
    detector: Detector<'static>,
    tracker: Tracker<MAX_TARGETS>,
    told: Option<Detail>,
}

impl Desktop {
    fn new() -> Self {
        let storage = Box::leak(Box::new(HeadStorage::new()));
        let detector = Detector::new(Settings::new(TargetSpec::any()), storage);
        Self { detector, tracker: Tracker::new(), told: None }
    }

    fn send(&mut self, seq: u32, case: &Case) -> Result<Vec<u8>> {
        self.send_with(seq, case, None)
    }

    /// The same; `given` are the runs of the rows and their contrast where they are known.
    fn send_with(&mut self, seq: u32, case: &Case, given: Option<(&[Vec<Run>], u8)>) -> Result<Vec<u8>> {
        let detail = case.frame.detail();
        let mut sent = Vec::new();
        let mut hello = |detail| -> Result<()> {
            let hello = Hello::new(VERSION, MAX_WIDTH as u16, detail);
            sent.extend_from_slice(hello.encode(&mut [0; HELLO_MAX_LEN])?);
            Ok(())
        };
        // The first one after its reset, with the level that it starts with.
        if self.told.is_none() {
            hello(Detail::Terse)?;
        }
        if self.told.replace(detail).unwrap_or(Detail::Terse) != detail {
            hello(detail)?;
        }
        let mut report = Report::<MAX_TARGETS>::new(detail);
        report.begin(seq);
        self.tracker.begin();
        self.detector.set_settings(case.frame.settings()?);
        let image = Image::new(&case.pixels, case.frame.width.try_into()?, case.frame.height.try_into()?)?;
        let (width, height) = image.size();
        let regions = self.tracker.regions(width, height).filter(|_| given.is_none());
        let mut take = |target| report.push_tracked(&target, self.tracker.follow(&target).as_ref());
        let mut scan = self.detector.begin(width, height)?;
        if let Some(regions) = &regions {
            scan = scan.within(regions)?;
        }
        for (y, row) in case.pixels.chunks_exact(width.into()).enumerate() {
            let targets = match given {
                Some((runs, min_contrast)) => scan.push_row_with_runs(row, &runs[y], min_contrast)?,
                None => scan.push_row(row)?,
            };
            targets.for_each(&mut take);
        }
        let mut rest = scan.finish()?;
        rest.by_ref().for_each(&mut take);
        let mut bytes = vec![0; max_len(MAX_TARGETS, detail)];
        sent.extend_from_slice(report.finish(&rest.summary(), &mut bytes)?);
        Ok(sent)
    }
}

fn boot(machine: Machine) -> Result<Head> {
    let elf = env::var_os(machine.elf)
        .with_context(|| format!("{} does not name a firmware; use `cargo xtask qemu`", machine.elf))?;
    Head::boot(machine, Path::new(&elf), Serial::Here)
}

/// The tests below, on a board.
macro_rules! on {
    ($board:ident, $machine:expr, $($test:ident)*) => {
        mod $board {
            $(
                #[test]
                #[ignore = "runs in QEMU: cargo xtask qemu"]
                fn $test() -> anyhow::Result<()> {
                    super::$test($machine)
                }
            )*
        }
    };
}

on!(mps2_an386, super::MPS2_AN386,
    twenty_frames_give_the_bytes_of_the_desktop photographs_give_the_bytes_of_the_desktop
    an_altered_block_of_pixels_gives_other_bytes the_log_is_the_one_beside_the_firmware
    targets_are_followed_and_looked_for_where_they_are_expected
    a_head_that_refuses_a_frame_says_why_and_takes_the_next
    commands_change_the_next_report_and_damage_costs_only_itself);
on!(mps2_an500, super::MPS2_AN500,
    twenty_frames_give_the_bytes_of_the_desktop a_head_that_refuses_a_frame_says_why_and_takes_the_next);
on!(riscv_virt, super::RISCV_VIRT,
    twenty_frames_give_the_bytes_of_the_desktop photographs_give_the_bytes_of_the_desktop
    an_altered_block_of_pixels_gives_other_bytes a_head_that_refuses_a_frame_says_why_and_takes_the_next
    runs_from_the_fabric_give_the_bytes_of_the_desktop targets_are_followed_and_looked_for_where_they_are_expected
    commands_change_the_next_report_and_damage_costs_only_itself);

fn twenty_frames_give_the_bytes_of_the_desktop(machine: Machine) -> Result<()> {
    let mut head = boot(machine)?;
    let mut desktop = Desktop::new();
    let cases = cases()?;
    assert_eq!(cases.len(), 20);
    let mut targets = 0;
    for (seq, case) in (1..).zip(&cases) {
        let answer = head.measure(case.frame, &case.pixels).context(case.name)?;
        let received = head.report(answer.length).context(case.name)?;
        let expected = desktop.send(seq, case).context(case.name)?;
        ensure!(
            received == expected,
            "frame {seq}, {}: the head's {} bytes differ",
            case.name,
            received.len()
        );
        targets += answer.targets;
    }
    let (status, rest) = head.exit(0)?;
    assert_eq!(status.code(), Some(0));
    assert!(rest.is_empty(), "the head sent {} bytes more than its reports", rest.len());
    // Without targets the reports would be the same whatever is computed.
    assert!(targets > 300, "{targets} targets in all");
    Ok(())
}

fn photographs_give_the_bytes_of_the_desktop(machine: Machine) -> Result<()> {
    let Some(folder) = env::var_os("CONCENTRIC_PHOTOS") else {
        // Not by `eprintln!`, which the test harness keeps back from a test that passes.
        writeln!(io::stderr(), "photographs skipped: set CONCENTRIC_PHOTOS to their folder")?;
        return Ok(());
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder);
    let (mut head, mut desktop) = (boot(machine)?, Desktop::new());
    let photographs = [("cctag-01.png", 4), ("ringgrid-board.png", 1), ("openmv-apriltags.pgm", 0)];
    for (seq, (name, least)) in (1..).zip(photographs) {
        let picture = Picture::read(&folder.join(name))?;
        let case = Case::new(name, ANY, picture.width as u32, picture.pixels);
        let answer = head.measure(case.frame, &case.pixels).context(name)?;
        ensure!(head.report(answer.length)? == desktop.send(seq, &case)?, "{name}: the head's bytes differ");
        ensure!(answer.targets >= least, "{name}: only {} targets", answer.targets);
    }
    head.exit(0)?;
    Ok(())
}

fn runs_from_the_fabric_give_the_bytes_of_the_desktop(machine: Machine) -> Result<()> {
    const CONTRAST: u8 = 40;
    let (mut head, mut desktop) = (boot(machine)?, Desktop::new());
    // Odd width: the words of a row's runs begin behind its padding.
    for (seq, case) in [
        (1, Case::rendered("60 targets", HALF, &Scene::many(60, 640, 480, false, 7)?)),
        (3, Case::rendered("odd size", HALF, &Scene::many(12, 637, 479, false, 7)?)),
    ] {
        let rows = case.pixels.chunks_exact(case.frame.width as usize);
        let mut given: Vec<_> = rows.map(|row| runs(row, 125)).collect();
        let answer = head.measure_with_runs(case.frame, &case.pixels, &given, CONTRAST)?;
        ensure!(answer.targets >= 12, "{}: {} targets", case.name, answer.targets);
        let expected = desktop.send_with(seq, &case, Some((&given, CONTRAST)))?;
        ensure!(head.report(answer.length)? == expected, "{}: the head's bytes differ", case.name);
        // One that ends beyond the row.
        given[5].push(Run { start: 600, end: 700 });
        let error = head.measure_with_runs(case.frame, &case.pixels, &given, CONTRAST).expect_err("refused");
        assert!(format!("{error:#}").contains("the runs of a row"), "{error:#}");
        desktop.tracker.begin();
    }
    head.exit(0)?;
    Ok(())
}

fn targets_are_followed_and_looked_for_where_they_are_expected(machine: Machine) -> Result<()> {
    let (mut head, mut desktop) = (boot(machine)?, Desktop::new());
    let command = Command { tag: 1, request: Request::WholeEvery(3) };
    head.tell(command.encode(&mut [0; COMMAND_MAX_LEN])?)?;
    let (answer, read) = next_answer(&mut head)?;
    assert_eq!((answer.outcome, answer.settings.whole_every), (Outcome::Done, 3));
    desktop.tracker.set_period(3);
    desktop.told = Some(Detail::Terse);
    let mut read = read;
    for seq in 1..=5 {
        let place = [2.5 * f64::from(seq), 0.7];
        let case = Case::rendered("drifting", HALF, &Scene::single(40.0, 30.0, 30.0, place));
        let answer = head.measure(case.frame, &case.pixels)?;
        ensure!(answer.targets == 1, "frame {seq}: {} targets", answer.targets);
        ensure!(head.report(answer.length - read)? == desktop.send(seq, &case)?, "frame {seq} differs");
        read = 0;
    }
    assert_eq!(desktop.tracker.tracks().first().map(|track| (track.id, track.age)), Some((1, 4)));
    head.exit(0)?;
    Ok(())
}

fn an_altered_block_of_pixels_gives_other_bytes(machine: Machine) -> Result<()> {
    let mut head = boot(machine)?;
    let scene = Scene::single(40.0, 60.0, 30.0, [0.3, 0.7]);
    let original = Case::rendered("original", HALF, &scene);
    let mut altered = Case::rendered("altered", HALF, &scene);
    let rim = scene.targets[0].rim_in_image(&scene.camera)[0];
    let (left, top) = (rim.x as usize - 4, rim.y as usize - 4);
    for row in altered.pixels.chunks_exact_mut(altered.frame.width as usize).skip(top).take(8) {
        for pixel in &mut row[left..left + 8] {
            *pixel = pixel.saturating_add(20);
        }
    }
    let answer = head.measure(altered.frame, &altered.pixels)?;
    let received = head.report(answer.length)?;
    assert_eq!(received, Desktop::new().send(1, &altered)?);
    assert_ne!(received, Desktop::new().send(1, &original)?);
    head.exit(0)?;
    Ok(())
}

fn the_log_is_the_one_beside_the_firmware(machine: Machine) -> Result<()> {
    let mut head = boot(machine)?;
    for picture in sample_frames()? {
        let Case { frame, pixels, .. } = Case::new("sample", HALF, picture.width as u32, picture.pixels);
        let answer = head.measure(frame, &pixels)?;
        head.report(answer.length)?;
    }
    assert_eq!(head.log(), include_str!("../../examples/mps2/expected.txt"));
    head.exit(0)?;
    Ok(())
}

fn a_head_that_refuses_a_frame_says_why_and_takes_the_next(machine: Machine) -> Result<()> {
    let mut head = boot(machine)?;
    let good = Case::new("good", ANY, 64, vec![200; 64 * 48]);
    let refusals = [
        (Frame { width: 2049, ..good.frame }, "wider than 2048 px"),
        (Frame { width: 0, height: 0, ..good.frame }, "smaller than 8x8 px"),
        (Frame { ratio: Frame::RATIO_ONE * 6 / 5, ..good.frame }, "outside 0.1 to 0.95"),
    ];
    for (frame, reason) in refusals {
        let pixels = vec![200; (frame.width * frame.height) as usize];
        let error = head.measure(frame, &pixels).expect_err("refused");
        assert!(format!("{error:#}").contains(reason), "{error:#}");
    }
    let answer = head.measure(good.frame, &good.pixels)?;
    assert_eq!(head.report(answer.length)?, Desktop::new().send(4, &good)?);
    let (status, _) = head.exit(7)?;
    assert_eq!(status.code(), Some(7));
    Ok(())
}

/// The next message of the head and its length.
fn next_answer(head: &mut Head) -> Result<(Answer, u32)> {
    let mut decoder = Decoder::<64>::new();
    let mut length = 0;
    loop {
        length += 1;
        let byte = head.report(1)?[0];
        match decoder.push(byte).transpose()? {
            Some(Message::Answer(answer)) => return Ok((answer, length)),
            Some(Message::Frame(frame)) => anyhow::bail!("frame {} instead of an answer", frame.head.seq),
            Some(Message::Hello(_)) | None => {}
        }
    }
}

fn commands_change_the_next_report_and_damage_costs_only_itself(machine: Machine) -> Result<()> {
    let encode = |tag, request| -> Result<Vec<u8>> {
        Ok(Command { tag, request }.encode(&mut [0; COMMAND_MAX_LEN])?.to_vec())
    };
    let half = Ratios::from_slice(&[32768]).map_err(|_| anyhow::anyhow!("too many"))?;
    let ratio = encode(1, Request::Ratios(half))?;
    let detail = encode(2, Request::Detail(Detail::Full))?;
    // Half a command, and noise: the separator in front of the next command ends them.
    let told = [&ratio[..8], &ratio, &[0x55; 100], &detail].concat();
    let expected = [(0, Outcome::Damaged), (1, Outcome::Done), (0, Outcome::Damaged), (2, Outcome::Done)];
    let mut head = boot(machine)?;
    let mut read = 0;
    head.tell(&told)?;
    for (tag, outcome) in expected {
        let (answer, length) = next_answer(&mut head)?;
        read += length;
        assert_eq!((answer.tag, answer.outcome), (tag, outcome));
    }
    // The desktop's bytes for the same settings, without the hellos, which were sent with the answers.
    let case = Case::rendered("one tilted target", HALF, &Scene::single(40.0, 60.0, 30.0, [0.3, 0.7]));
    let answer = head.measure_as_set((case.frame.width, case.frame.height), &case.pixels)?;
    assert_eq!(answer.targets, 1);
    let mut desktop = Desktop::new();
    desktop.told = Some(Detail::Full);
    assert_eq!(head.report(answer.length - read)?, desktop.send(1, &case)?);
    head.exit(0)?;
    Ok(())
}
