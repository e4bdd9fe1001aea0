//! Streams, whole and damaged, against a plain model of a receiver.

use std::ops::Range;

use concentric::report::{
    DecodeError, Detail, Hello, Message, Report, SEPARATOR, Version, WIRE_VERSION, max_len,
};
use concentric::{Circle, Covariance, Dropped, Ellipse, Flags, Position, Reading, Reject, Summary, Target};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::support::{DETAILS, LEN, Outcome, annulus, encode, outcomes};

fn any_position() -> impl Strategy<Value = Position> {
    (any::<i32>(), any::<i32>()).prop_map(|(x, y)| Position { x, y })
}

fn any_circle() -> impl Strategy<Value = Circle> {
    let ellipse = (any_position(), any::<f32>(), any::<f32>(), -4.0f32..4.0);
    (ellipse, any::<f32>(), any::<u16>(), 0.0f32..400.0, (0.0f32..2.0, 0.0f32..2.0)).prop_map(
        |((centre, a, b, theta), rms, points, gap, (ratio, measured_ratio))| Circle {
            ellipse: Ellipse { centre, a, b, theta },
            covariance: Covariance::default(),
            rms,
            points,
            gap,
            ratio,
            measured_ratio,
        },
    )
}

fn any_target() -> impl Strategy<Value = Target> {
    let covariance =
        (any::<f32>(), any::<f32>(), any::<f32>()).prop_map(|(xx, xy, yy)| Covariance { xx, xy, yy });
    let places = (any_position(), any_position(), any_position());
    let rest = (0.0f32..5000.0, 0.0f32..300.0, 0.0f32..300.0, any::<u16>(), any::<Option<u16>>());
    (places, covariance, vec(any_circle(), 0..=8), rest).prop_map(
        |((centre, eq7, exact), covariance, circles, (contrast, noise, blur, flags, code))| Target {
            normal: None,
            code: code.map(|id| Reading { id, ..Reading::default() }),
            centre,
            covariance,
            eq7,
            exact,
            circles: circles.into_iter().collect(),
            contrast,
            noise,
            blur,
            flags: Flags(flags),
        },
    )
}

fn any_summary() -> impl Strategy<Value = Summary> {
    let size = (any::<u16>(), any::<u16>());
    let dropped = (any::<u32>(), any::<u32>(), any::<u32>());
    (size, vec(any::<u32>(), Reject::ALL.len()), dropped).prop_map(|((width, height), counts, dropped)| {
        let (runs, outlines, crossings) = dropped;
        Summary {
            width,
            height,
            targets: 0,
            rejected: Reject::ALL.iter().zip(counts).map(|(&(cause, _), count)| (cause, count)).collect(),
            dropped: Dropped { runs, outlines, crossings },
            ..Summary::default()
        }
    })
}

proptest! {
    #[test]
    fn what_is_encoded_is_decoded(
        seq: u32, level in 0..3usize, targets in vec(any_target(), 0..12), summary in any_summary(),
    ) {
        let detail = DETAILS[level];
        let mut report = Report::<10>::new(detail);
        report.begin(seq);
        targets.iter().for_each(|target| report.push(target));
        let mut buffer = [0; max_len(10, Detail::Full)];
        let bytes = report.finish(&summary, &mut buffer[..max_len(10, detail)]).unwrap();
        prop_assert_eq!(bytes.iter().position(|&byte| byte == SEPARATOR), Some(bytes.len() - 1));

        let outcomes = outcomes::<LEN>(bytes);
        let [Outcome::Frame(head, decoded)] = outcomes.as_slice() else { panic!("{outcomes:?}") };
        prop_assert_eq!((head.seq, head.width, head.height), (seq, summary.width, summary.height));
        prop_assert_eq!((head.rejected, head.dropped, head.detail), (summary.rejected, summary.dropped, detail));
        prop_assert_eq!(head.dropped_targets as usize, targets.len().saturating_sub(10));
        prop_assert_eq!(decoded.as_slice(), report.targets());
        let ids = targets.iter().map(|target| target.code.map_or(0, |code| code.id)).take(10);
        prop_assert!(ids.eq(decoded.iter().map(|entry| entry.id)));
    }

    #[test]
    fn the_frame_around_a_message_is_the_one_that_others_make(count in 0..60u32, seq: u32) {
        let targets: Vec<Target> = (0..count).map(annulus).collect();
        let bytes = encode(seq, Detail::Full, &targets);
        let plain = cobs::decode_vec(&bytes[..bytes.len() - 1]).unwrap();
        prop_assert_eq!(&cobs::encode_vec(&plain), &bytes[..bytes.len() - 1]);
        let (content, crc) = plain.split_at(plain.len() - 4);
        prop_assert_eq!(crc, crc32fast::hash(content).to_le_bytes());
    }

    #[test]
    fn noise_is_never_a_message(bytes in vec(any::<u8>(), 0..2000)) {
        for outcome in outcomes::<100>(&bytes) {
            prop_assert!(matches!(outcome, Outcome::Damaged(_)), "{:?}", outcome);
        }
    }

    #[test]
    fn damage_costs_only_what_it_touches(damage in vec(any_damage(), 1..4)) {
        let sent = Sent::new();
        let mut stream = sent.bytes.clone();
        for one in damage {
            one.to(&mut stream);
        }
        let received = outcomes::<LEN>(&stream.iter().map(|&(byte, _)| byte).collect::<Vec<_>>());
        prop_assert_eq!(&received, &sent.expected(&stream));
    }
}

#[derive(Clone, Debug)]
enum Damage {
    Drop(f64, usize),
    Flip(f64, u8),
    Insert(f64, Vec<u8>),
    Cut(f64),
}

fn any_damage() -> impl Strategy<Value = Damage> {
    prop_oneof![
        (0.0..1.0, 1..300usize).prop_map(|(at, len)| Damage::Drop(at, len)),
        (0.0..1.0, 0..8u8).prop_map(|(at, bit)| Damage::Flip(at, bit)),
        (0.0..1.0, vec(prop_oneof![3 => any::<u8>(), 1 => Just(0)], 1..20))
            .prop_map(|(at, bytes)| Damage::Insert(at, bytes)),
        (0.5..1.0).prop_map(Damage::Cut),
    ]
}

/// A byte of the stream and its place among the bytes that were sent; `None`: not as sent.
type Byte = (u8, Option<usize>);

impl Damage {
    fn to(self, stream: &mut Vec<Byte>) {
        let place = |at: f64| (at * stream.len() as f64) as usize;
        match self {
            Self::Drop(at, len) => {
                let start = place(at);
                let end = (start + len).min(stream.len());
                stream.drain(start..end);
            }
            Self::Flip(at, bit) => {
                let start = place(at);
                if let Some(byte) = stream.get_mut(start) {
                    *byte = (byte.0 ^ 1 << bit, None);
                }
            }
            Self::Insert(at, bytes) => {
                let start = place(at);
                stream.splice(start..start, bytes.into_iter().map(|byte| (byte, None)));
            }
            Self::Cut(at) => {
                let end = place(at);
                stream.truncate(end);
            }
        }
    }
}

/// A stream and the messages in it.
struct Sent {
    bytes: Vec<Byte>,
    /// Where each message is, without its separator, and what it says.
    messages: Vec<(Range<usize>, Outcome)>,
}

impl Sent {
    fn new() -> Self {
        let hello = Hello::new(Version::LIBRARY, 1280, Detail::Terse);
        let frames = (0..9).map(|seq| {
            let targets: Vec<Target> = (0..seq * seq % 11).map(annulus).collect();
            encode(seq, DETAILS[seq as usize % 3], &targets)
        });
        let (mut bytes, mut messages) = (Vec::new(), Vec::new());
        for message in std::iter::once(hello.encode(&mut [0; 64]).unwrap().to_vec()).chain(frames) {
            let start = bytes.len() + usize::from(message[0] == SEPARATOR);
            bytes.extend(&message);
            let said = outcomes::<LEN>(&message).remove(0);
            messages.push((start..bytes.len() - 1, said));
        }
        let bytes = bytes.into_iter().enumerate().map(|(at, byte)| (byte, Some(at))).collect();
        Self { bytes, messages }
    }

    /// What a receiver of `stream` must say: a stretch between separators is a message if it is, byte by byte, one that
    /// was sent; else it is damage of the cause that plain code finds.
    fn expected(&self, stream: &[Byte]) -> Vec<Outcome> {
        let mut stretches: Vec<&[Byte]> = stream.split(|&(byte, _)| byte == SEPARATOR).collect();
        stretches.pop();
        stretches.retain(|stretch| !stretch.is_empty());
        stretches.into_iter().map(|stretch| self.of(stretch)).collect()
    }

    fn of(&self, stretch: &[Byte]) -> Outcome {
        let bytes: Vec<u8> = stretch.iter().map(|&(byte, _)| byte).collect();
        let sent =
            |range: &Range<usize>| self.bytes[range.clone()].iter().map(|&(byte, _)| byte).eq(bytes.clone());
        if let Some((_, said)) = self.messages.iter().find(|(range, _)| sent(range)) {
            return said.clone();
        }
        let untouched = |(range, _): &(Range<usize>, Outcome)| {
            stretch.iter().map(|&(_, at)| at).eq(range.clone().map(Some))
        };
        assert!(!self.messages.iter().any(untouched));
        Outcome::Damaged(match cobs::decode_vec(&bytes) {
            Err(_) => DecodeError::Cobs,
            Ok(plain) if plain.len() < 6 => DecodeError::TooShort,
            Ok(_) => DecodeError::Checksum,
        })
    }
}

#[test]
fn an_undamaged_stream_is_decoded_whole() {
    let sent = Sent::new();
    let bytes: Vec<u8> = sent.bytes.iter().map(|&(byte, _)| byte).collect();
    let said: Vec<Outcome> = sent.messages.into_iter().map(|(_, said)| said).collect();
    assert!(matches!(said[0], Outcome::Hello(_)));
    assert_eq!(outcomes::<LEN>(&bytes), said);
}

#[test]
fn separators_between_messages_change_nothing() {
    let message = encode(1, Detail::Terse, &[annulus(1)]);
    let padded = [&[0, 0, 0], message.as_slice(), &[0, 0], message.as_slice(), &[0]].concat();
    let said = outcomes::<LEN>(&message).remove(0);
    assert_eq!(outcomes::<LEN>(&padded), [said.clone(), said]);
}

#[test]
fn the_tail_of_a_message_that_is_too_long_is_no_message() {
    let message = encode(5, Detail::Terse, &[]);
    let said = outcomes::<LEN>(&message);
    for noise in 1..600 {
        let stream = [vec![0xFF; noise], message.clone(), message.clone()].concat();
        let received = outcomes::<64>(&stream);
        assert_eq!(received.len(), 2, "{noise}");
        assert!(matches!(received[0], Outcome::Damaged(_)), "{noise}: {received:?}");
        if noise > 65 {
            assert_eq!(received[0], Outcome::Damaged(DecodeError::TooLong), "{noise}");
        }
        assert_eq!(received[1..], said, "{noise}");
    }
}

/// Frames `content` as the specification says, by other code than the encoder's.
fn frame(content: &[u8]) -> Vec<u8> {
    let plain = [content, &crc32fast::hash(content).to_le_bytes()].concat();
    let mut bytes = cobs::encode_vec(&plain);
    bytes.push(SEPARATOR);
    bytes
}

#[test]
fn an_intact_message_that_makes_no_sense_says_why() {
    let good = encode(5, Detail::Normal, &[annulus(3)]);
    let plain = cobs::decode_vec(&good[..good.len() - 1]).unwrap();
    let content = &plain[..plain.len() - 4];
    let why = |content: &[u8]| match outcomes::<LEN>(&frame(content)).as_slice() {
        [Outcome::Damaged(error)] => *error,
        other => panic!("{other:?}"),
    };
    assert_eq!(outcomes::<LEN>(&frame(content)), outcomes::<LEN>(&good));
    assert_eq!(why(&[&[WIRE_VERSION + 1], &content[1..]].concat()), DecodeError::Version(WIRE_VERSION + 1));
    assert_eq!(why(&[&[WIRE_VERSION, 9], &content[2..]].concat()), DecodeError::Kind(9));
    assert_eq!(why(&[&[WIRE_VERSION, 1], &content[2..]].concat()), DecodeError::Body);
    assert_eq!(why(&[content, &[0]].concat()), DecodeError::Body);
    for len in 2..content.len() {
        assert_eq!(why(&content[..len]), DecodeError::Body, "{len}");
    }
    assert_eq!(why(&content[..1]), DecodeError::TooShort);
    assert_eq!(why(&[]), DecodeError::TooShort);
}

#[test]
fn an_empty_last_block_may_be_sent_or_left_out() {
    // 254 bytes without a zero, checksum included, of a kind that shows that the checksum was right.
    let messages = (1..=255).map(|fill| frame(&[[WIRE_VERSION, 9].as_slice(), &[fill; 248]].concat()));
    let without = messages.into_iter().find(|message| message.len() == 256).unwrap();
    assert_eq!(without[0], 0xFF);
    let with = [&without[..255], &[1, 0]].concat();
    for message in [without, with] {
        assert_eq!(outcomes::<254>(&message), [Outcome::Damaged(DecodeError::Kind(9))]);
    }
}

#[test]
fn a_message_is_readable_until_the_next_byte() {
    let bytes = encode(3, Detail::Full, &[annulus(0), annulus(1)]);
    let mut decoder = concentric::report::Decoder::<LEN>::new();
    for &byte in &bytes {
        if let Some(Ok(Message::Frame(frame))) = decoder.push(byte) {
            assert_eq!(frame.targets().count(), 2);
            assert_eq!(frame.targets().count(), 2, "reading takes nothing away");
        }
    }
}
