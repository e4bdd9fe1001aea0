//! Settings over the line: what is asked, what is answered, and what damage does.

use concentric::report::{
    COMMAND_MAX_LEN, Command, Detail, Format, Hello, Outcome, Ratios, Request, WIRE_VERSION,
};
use concentric::{Camera, Compensation, Effort, Polarity, Settings, TargetSpec};
use proptest::prelude::*;

use crate::support::{BUFFER, Bench, FIRMWARE, PlayedLine, SIZE, Sent, TestStorage, messages};

fn encode(tag: u16, request: Request) -> Vec<u8> {
    Command { tag, request }.encode(&mut [0; COMMAND_MAX_LEN]).unwrap().to_vec()
}

fn ratios(ratios: &[f64]) -> Request {
    Request::Ratios(ratios.iter().map(|ratio| (ratio * 65536.0) as u16).collect())
}

fn with_bench(test: impl FnOnce(&mut Bench<'_>)) {
    let (mut storage, mut buffer) = (TestStorage::new(), [0; BUFFER]);
    let mut bench = Bench::new(PlayedLine::fast(), &mut storage, &mut buffer);
    bench.settle();
    bench.line.take();
    test(&mut bench);
}

/// What a head that has just been set up answers to `bytes`.
fn answers_to(bytes: &[u8]) -> Vec<(u16, Outcome)> {
    let mut answers = Vec::new();
    with_bench(|bench| answers = ask(bench, bytes));
    answers
}

fn ask(bench: &mut Bench<'_>, bytes: &[u8]) -> Vec<(u16, Outcome)> {
    bench.line.receive(bytes);
    bench.serve();
    bench.settle();
    let sent = messages(&bench.line.take());
    sent.iter().filter_map(Sent::answer).map(|answer| (answer.tag, answer.outcome)).collect()
}

#[test]
fn every_setting_is_changed_answered_and_in_force_with_the_next_frame() {
    with_bench(|bench| {
        let requests = [
            ratios(&[0.75, 0.5]),
            Request::Polarity(Polarity::Light),
            Request::Compensation(Compensation::Eq7),
            Request::Detail(Detail::Full),
            Request::Format(Format::Binary),
            Request::WholeEvery(5),
            Request::PxPerRun(20),
            Request::Effort(Effort::Quick),
            Request::Settings,
        ];
        let commands: Vec<u8> = (1..).zip(requests).flat_map(|(tag, request)| encode(tag, request)).collect();
        bench.line.receive(&commands);
        bench.serve();
        bench.settle();
        let sent = messages(&bench.line.take());
        let answers: Vec<_> = sent.iter().filter_map(Sent::answer).collect();
        assert_eq!(answers.iter().map(|answer| answer.tag).collect::<Vec<_>>(), [1, 2, 3, 4, 5, 6, 7, 8, 9]);
        assert!(answers.iter().all(|answer| answer.outcome == Outcome::Done));
        assert_eq!(answers[0].settings.ratios, [49152, 32768]);
        assert_eq!(answers[0].settings.polarity, Polarity::Dark, "changed by the second only");
        let settings = &answers[8].settings;
        assert_eq!(settings.ratios, [49152, 32768]);
        assert_eq!((settings.polarity, settings.compensation), (Polarity::Light, Compensation::Eq7));
        assert_eq!((settings.detail, settings.format), (Detail::Full, Format::Binary));
        assert_eq!((settings.whole_every, answers[4].settings.whole_every), (5, 0));
        assert_eq!((settings.px_per_run, answers[5].settings.px_per_run), (20, Settings::DEFAULT_PX_PER_RUN));
        assert_eq!((settings.effort, answers[6].settings.effort), (Effort::Quick, Effort::Full));
        let spec = TargetSpec::circles(&[0.75, 0.5]).unwrap().light();
        assert_eq!(
            *bench.detector.settings(),
            Settings::new(spec).compensation(Compensation::Eq7).px_per_run(20).effort(Effort::Quick)
        );
        // A hello tells of another level of detail.
        assert!(sent.contains(&Sent::Hello(Hello::new(FIRMWARE, SIZE, Detail::Full))));

        // A dark target is none any more; then it is one again.
        assert_eq!(bench.frame().map(|summary| summary.targets), Ok(0));
        ask(bench, &[encode(7, ratios(&[0.5])), encode(8, Request::Polarity(Polarity::Dark))].concat());
        assert_eq!(bench.frame().map(|summary| summary.targets), Ok(1));
        bench.settle();
        let sent = messages(&bench.line.take());
        assert_eq!(sent[0].frame().unwrap().detail, Detail::Full);
        ask(bench, &encode(9, ratios(&[0.8])));
        assert_eq!(bench.frame().map(|summary| summary.targets), Ok(0));
        ask(bench, &encode(9, ratios(&[])));
        assert_eq!(bench.frame().map(|summary| summary.targets), Ok(1));
    });
}

#[test]
fn a_hello_comes_when_it_is_asked_for() {
    with_bench(|bench| {
        bench.line.receive(&encode(3, Request::Hello));
        bench.serve();
        bench.settle();
        let sent = messages(&bench.line.take());
        assert_eq!(sent[0], Sent::Hello(Hello::new(FIRMWARE, SIZE, Detail::Normal)));
        assert_eq!(sent[1].answer().unwrap().tag, 3);
    });
}

#[test]
fn a_refusal_names_what_was_given_and_what_is_allowed() {
    let refused = |request| match answers_to(&encode(9, request))[..] {
        [(9, outcome)] => outcome,
        ref other => panic!("{other:?}"),
    };
    let low = Outcome::Ratio { value: 3276, min: 6554, max: 62259 };
    assert_eq!(refused(ratios(&[0.05])), low);
    assert_eq!(low.to_string(), "ratio 0.04999 is outside 0.10001..=0.95000");
    assert_eq!(refused(ratios(&[0.5, 0.5])), Outcome::Ratio { value: 32768, min: 6554, max: 31129 });
    let many = Outcome::RatioCount { given: 4, max: 3 };
    assert_eq!(refused(ratios(&[0.9, 0.8, 0.7, 0.6])), many);
    assert_eq!(many.to_string(), "4 ratios given: 0..=3 inner circles are possible");
    assert_eq!(refused(Request::Compensation(Compensation::Known)), Outcome::NoCamera);
    // What is allowed is allowed.
    for ratio in [6554u16, 62259] {
        let request = Request::Ratios(Ratios::from_slice(&[ratio]).unwrap());
        assert_eq!(refused(request), Outcome::Done, "{ratio}");
    }
}

#[test]
fn a_refused_command_changes_nothing() {
    with_bench(|bench| {
        ask(bench, &encode(1, ratios(&[0.5])));
        let before = *bench.detector.settings();
        ask(bench, &encode(2, ratios(&[0.99])));
        assert_eq!(*bench.detector.settings(), before);
    });
}

#[test]
fn a_head_that_knows_its_camera_can_use_it() {
    with_bench(|bench| {
        let camera = Camera::new(100.0, 100.0, 48.0, 48.0).unwrap();
        bench.detector.set_settings(Settings::new(TargetSpec::any()).camera(camera));
        let answers = ask(bench, &encode(4, Request::Compensation(Compensation::Known)));
        assert_eq!(answers, [(4, Outcome::Done)]);
        assert_eq!(bench.detector.settings().camera, Some(camera));
    });
}

#[test]
fn a_command_in_mid_frame_waits_for_its_end() {
    with_bench(|bench| {
        let commands = [encode(1, Request::Detail(Detail::Terse)), encode(2, Request::Detail(Detail::Full))];
        bench.line.0.borrow_mut().arriving.extend(commands.concat());
        bench.frame().unwrap();
        bench.settle();
        let sent = messages(&bench.line.take());
        assert_eq!(sent[0].frame().unwrap().detail, Detail::Normal, "the frame began with it");
        let answers: Vec<_> = sent.iter().filter_map(Sent::answer).map(|answer| answer.tag).collect();
        assert_eq!(answers, [1, 2]);
        assert_eq!(bench.results.report.detail(), Detail::Full);
    });
}

#[test]
fn damage_is_answered_and_the_next_command_is_carried_out() {
    let good = encode(5, Request::Settings);
    let done = (5, Outcome::Done);
    let half = &good[..good.len() / 2];
    assert_eq!(answers_to(half), [], "the rest may follow");
    // The separator in front of every command ends what came before.
    assert_eq!(answers_to(&[half, &good].concat()), [(0, Outcome::Damaged), done]);
    let mut flipped = good.clone();
    flipped[4] ^= 0x20;
    assert_eq!(answers_to(&[flipped, good.clone()].concat()), [(0, Outcome::Damaged), done]);
    let garbage: Vec<u8> = (1..=255).collect();
    assert_eq!(answers_to(&[garbage, good.clone()].concat()), [(0, Outcome::Damaged), done]);
    assert_eq!(answers_to(&[&[0; 50], good.as_slice()].concat()), [done], "nothing is no damage");
}

#[test]
fn what_is_intact_and_no_command_is_answered_as_unknown() {
    let message = |content: &[u8]| {
        let plain = [content, &crc32fast::hash(content).to_le_bytes()].concat();
        [&[0], cobs::encode_vec(&plain).as_slice(), &[0]].concat()
    };
    const COMMAND: u8 = 3;
    let settings = [WIRE_VERSION, COMMAND, 5, 0];
    assert_eq!(answers_to(&message(&settings)), [(5, Outcome::Done)]);
    for content in [
        [WIRE_VERSION + 1, COMMAND, 5, 0].as_slice(),
        &[WIRE_VERSION, 1, 5, 0],
        &[WIRE_VERSION, COMMAND, 5, 200],
        &[WIRE_VERSION, COMMAND, 5],
        &[WIRE_VERSION, COMMAND, 5, 0, 0],
        &[WIRE_VERSION, COMMAND, 5, 5, 3],
    ] {
        assert_eq!(answers_to(&message(content)), [(0, Outcome::Unknown)], "{content:?}");
    }
}

#[test]
fn an_answer_waits_for_room_and_reports_leave_it_some() {
    let (mut storage, mut buffer) = (TestStorage::new(), [0; BUFFER]);
    let mut bench = Bench::new(PlayedLine::default(), &mut storage, &mut buffer);
    for _ in 0..50 {
        bench.frame().unwrap();
    }
    let commands: Vec<u8> = (1..=9).flat_map(|tag| encode(tag, Request::Settings)).collect();
    bench.line.receive(&commands);
    for _ in 0..50 {
        bench.frame().unwrap();
    }
    assert!(!bench.line.0.borrow().arrived.is_empty(), "commands wait for room");
    // A trickle, while frames go on: every answer arrives in the end.
    bench.line.0.borrow_mut().per_row = 1;
    for _ in 0..30 {
        bench.frame().unwrap();
    }
    bench.settle();
    let answers: Vec<_> =
        messages(&bench.line.take()).iter().filter_map(Sent::answer).map(|a| a.tag).collect();
    assert_eq!(answers, Vec::from_iter(1..=9));
}

#[test]
fn text_and_messages_do_not_spoil_each_other() {
    with_bench(|bench| {
        ask(bench, &encode(1, Request::Format(Format::Text)));
        bench.frame().unwrap();
        bench.line.receive(&encode(2, Request::Format(Format::Binary)));
        bench.settle();
        bench.frame().unwrap();
        bench.settle();
        let stream = bench.line.take();
        let start = stream.iter().position(|&byte| byte == 0).unwrap();
        assert!(stream.starts_with(b"$CCF,1,96,96,1,0,0*") && stream[..start].ends_with(b"\r\n"));
        let sent = messages(&stream[start..]);
        assert!(matches!(sent[0], Sent::Hello(_)), "{sent:?}");
        assert_eq!(sent[1].answer().unwrap().tag, 2);
        assert_eq!(sent[2].frame().unwrap().seq, 2);
    });
}

fn any_request() -> impl Strategy<Value = Request> {
    prop_oneof![
        Just(Request::Settings),
        Just(Request::Hello),
        prop::collection::vec(any::<u16>(), 0..8)
            .prop_map(|list| Request::Ratios(list.into_iter().collect())),
        prop_oneof![Just(Polarity::Dark), Just(Polarity::Light)].prop_map(Request::Polarity),
        prop_oneof![Just(Detail::Terse), Just(Detail::Normal), Just(Detail::Full)].prop_map(Request::Detail),
    ]
}

proptest! {
    /// Noise between commands costs no command and changes no setting.
    #[test]
    fn noise_between_commands_costs_nothing(parts in prop::collection::vec(
        (prop::collection::vec(any::<u8>(), 0..60), any_request()), 1..6,
    )) {
        let clean: Vec<u8> = (1..).zip(&parts).flat_map(|(tag, (_, request))| encode(tag, request.clone())).collect();
        let noisy: Vec<u8> = (1..).zip(&parts)
            .flat_map(|(tag, (noise, request))| [noise.clone(), encode(tag, request.clone())].concat())
            .collect();
        let run = |bytes: &[u8]| {
            let mut result = None;
            with_bench(|bench| {
                let answers = ask(bench, bytes);
                let known = answers.into_iter().filter(|&(tag, _)| tag > 0).collect::<Vec<_>>();
                result = Some((known, *bench.detector.settings(), bench.results.report.detail()));
            });
            result.unwrap()
        };
        let (expected, received) = (run(&clean), run(&noisy));
        prop_assert_eq!(expected.0.len(), parts.len());
        prop_assert_eq!(expected, received);
    }
}
