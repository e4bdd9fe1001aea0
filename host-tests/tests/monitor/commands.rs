//! Commands to a head.

use std::{
    io::{Read, Write},
    net::TcpListener,
    thread,
};

use concentric::report::{
    ANSWER_MAX_LEN, Answer, CommandDecoder, Detail, Format, HeadSettings, Outcome, Request,
};
use serde_json::json;

use super::support::{file, folder, frame, monitor, refusal, stream};

/// Plays a head that does not hear the first command and refuses ratios; it gives the requests that it heard.
fn deaf_head(listener: &TcpListener) -> Vec<Request> {
    let (mut line, _) = listener.accept().unwrap();
    let (mut decoder, mut heard) = (CommandDecoder::new(), Vec::new());
    let mut byte = [0];
    while heard.len() < 4 {
        line.read_exact(&mut byte).unwrap();
        let Some(command) = decoder.push(byte[0]) else { continue };
        let command = command.unwrap();
        heard.push(command.request.clone());
        if heard.len() == 1 {
            continue;
        }
        let outcome = match command.request {
            Request::Ratios(_) => Outcome::Ratio { value: 3276, min: 6554, max: 62259 },
            _ => Outcome::Done,
        };
        let settings = HeadSettings { format: Format::Text, ..HeadSettings::default() };
        let answer = Answer { tag: command.tag, outcome, settings };
        line.write_all(answer.encode(&mut [0; ANSWER_MAX_LEN]).unwrap()).unwrap();
    }
    line.write_all(&frame(1, Detail::Terse, 0)).unwrap();
    heard
}

#[test]
fn commands_are_sent_one_after_the_other_until_they_are_answered() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let source = format!("tcp:{}", listener.local_addr().unwrap());
    let head = thread::spawn(move || deaf_head(&listener));
    let words = ["--command", "detail=full", "--command", "ratio=0.05", "--command", "settings"];
    let outcome = monitor(&[&[source.as_str(), "--count", "1"], words.as_slice()].concat());
    assert_eq!(outcome.error, None);
    let heard = head.join().unwrap();
    assert_eq!(heard[..2], [Request::Detail(Detail::Full), Request::Detail(Detail::Full)]);
    assert!(matches!(heard[2..], [Request::Ratios(_), Request::Settings]));
    let settings = json!({"ratios": [], "polarity": "dark", "compensation": "exact", "detail": "terse", "format": "text",
        "whole_every": 0, "px_per_run": 0, "effort": "full"});
    let answer = |tag: u32, outcome: &str| json!({"kind": "answer", "tag": tag, "outcome": outcome, "settings": settings});
    let refused = answer(2, "ratio 0.04999 is outside 0.10001..=0.95000");
    assert_eq!(outcome.lines[..3], [answer(1, "done"), refused, answer(3, "done")]);
}

#[test]
fn commands_need_a_way_back() {
    let folder = folder();
    let outcome = monitor(&[&file(&folder, &stream([1])), "--command", "settings"]);
    assert!(outcome.error.unwrap().ends_with("stream.bin: commands need a serial port or tcp:HOST:PORT"));
    assert!(refusal(&["-", "--command", "detail=fine"]).contains("wanted one of terse, normal, full"));
}
