//! Where a stream comes from: TCP, standard input, a serial line.

use std::{
    io::Write,
    net::TcpListener,
    process::{Command, Stdio},
    thread,
};

use serde_json::json;

use super::support::{monitor, stream};

#[test]
fn tcp_in_small_pieces() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let source = format!("tcp:{}", listener.local_addr().unwrap());
    let head = thread::spawn(move || {
        let (mut head, _) = listener.accept().unwrap();
        head.set_nodelay(true).unwrap();
        stream(0..20).chunks(7).for_each(|piece| head.write_all(piece).unwrap());
    });
    let outcome = monitor(&[&source]);
    head.join().unwrap();
    assert_eq!(outcome.seqs(), (0..20).collect::<Vec<_>>());
    assert_eq!((outcome.notes.as_str(), outcome.error), ("", None));
}

#[test]
fn silence_is_given_up_on() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let source = format!("tcp:{}", listener.local_addr().unwrap());
    let head = thread::spawn(move || {
        let (mut head, _) = listener.accept().unwrap();
        head.write_all(&stream([4])).unwrap();
        head
    });
    let outcome = monitor(&[&source, "--timeout", "0.2"]);
    drop(head.join().unwrap());
    assert_eq!(outcome.seqs(), [4]);
    assert_eq!(outcome.error.unwrap(), format!("{source}: nothing arrived for 0.2 s"));
}

#[test]
fn the_program_reads_standard_input_and_exits_2_on_errors() {
    let program = |input: &[u8]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_concentric"));
        command.args(["monitor", "-"]).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        child.stdin.take().unwrap().write_all(input).unwrap();
        let output = child.wait_with_output().unwrap();
        let [out, notes] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        (out.lines().count(), notes, output.status.code())
    };
    assert_eq!(program(&stream(0..5)), (7, String::new(), Some(0)));
    let error = "concentric: standard input: empty; wanted a stream of reports\n".to_owned();
    assert_eq!(program(b""), (1, error, Some(2)));
}

#[cfg(unix)]
#[test]
fn a_serial_line() {
    use serialport::{SerialPort, TTYPort};

    let (mut head, line) = TTYPort::pair().unwrap();
    let source = line.name().unwrap();
    // All byte values cross the line unchanged.
    let bytes = [stream(0..3), (1..=255).collect(), vec![0], stream(4..6)].concat();
    let sender = thread::spawn(move || {
        head.write_all(&bytes).unwrap();
        head
    });
    let outcome = monitor(&[&source, "--count", "5", "--timeout", "10", "--baud", "921600"]);
    drop(sender.join().unwrap());
    assert_eq!((&outcome.summary()["damaged"], &outcome.summary()["lost"]), (&json!(1), &json!(1)));
    assert_eq!((outcome.seqs(), outcome.error), (vec![0, 1, 2, 4, 5], None));
}
