extern crate std;

use super::*;
use std::collections::HashMap;
use std::vec::Vec;

/// The code by its rule alone, without any shortcut.
fn enumerated(segments: u32) -> Vec<u16> {
    let rotations = |word: u32| {
        (0..segments).map(move |turn| (word << turn | word >> (segments - turn)) & ((1 << segments) - 1))
    };
    let mut words: Vec<u16> = (1..(1u32 << segments) - 1)
        .filter(|word| word.count_ones() % 2 == 0)
        .filter(|word| (0..segments / 2).any(|i| word >> i & 1 == 1 && word >> (i + segments / 2) & 1 == 1))
        .filter_map(|word| rotations(word).min())
        .map(|word| word as u16)
        .collect();
    words.sort_unstable();
    words.dedup();
    words
}

#[test]
fn words_are_those_of_the_rule() {
    for (code, count) in [(Code::cct14(), 516), (Code::cct12(), 147)] {
        let words = enumerated(code.segments());
        assert_eq!(words.len(), count);
        assert_eq!(code.words(), &words[..]);
        assert_eq!(code.ids().count(), count);
    }
}

#[test]
fn words_of_the_preset() {
    let words = [0b00000011111111, 0b00001100001111, 0b00100100110011, 0b00101001010101, 0b01111101111111];
    for (id, word) in Code::FIVE.into_iter().zip(words) {
        assert_eq!(Code::five().word(id), Some(word));
    }
    assert_eq!(Code::cct14().only(&Code::FIVE), Ok(Code::five()));
    assert!(Code::five().ids().eq(Code::FIVE));
}

/// What every one of all words is decoded to, against a table of all that it can be.
#[test]
fn every_word_is_decoded_or_refused() {
    for code in [Code::cct14(), Code::cct12(), Code::cct14().only(&[3, 77, 516]).unwrap()] {
        let segments = code.segments();
        let mut table = HashMap::new();
        for id in code.ids() {
            for turn in 0..segments {
                table.insert(rotated(code.word(id).unwrap(), turn, segments), id);
            }
        }
        for read in 0..1u32 << segments {
            let decoded = code.decode(read as u16).filter(|decoded| decoded.wrong == 0);
            assert_eq!(decoded.map(|d| d.id), table.get(&(read as u16)).copied(), "{read:b}");
            if let Some(Decoded { id, turn, .. }) = decoded {
                assert_eq!(Some(rotated(read as u16, turn.into(), segments)), code.word(id));
            }
        }
        assert_eq!(code.decode(1 << segments), None);
    }
}

#[test]
fn two_wrong_segments_of_the_preset_are_repaired_and_no_more() {
    let code = Code::five();
    let bits = |flip: u16| flip.count_ones();
    for id in Code::FIVE {
        for turn in 0..14 {
            let word = rotated(code.word(id).unwrap(), turn, 14);
            for flip in 0..1u16 << 14 {
                let read = word ^ flip;
                let decoded = code.decode(read);
                // Where the word begins is not protected: another rotation can be nearer.
                if bits(flip) <= 2 {
                    let right = decoded.is_some_and(|d| d.id == id && u32::from(d.wrong) <= bits(flip));
                    assert!(right, "{word:b} {flip:b}");
                }
                // What is farther from every rotation of every word is no id.
                if let Some(Decoded { id, turn, wrong }) = decoded {
                    let apart = bits(rotated(read, turn.into(), 14) ^ code.word(id).unwrap());
                    assert!(apart == u32::from(wrong) && apart <= 2, "{word:b} {flip:b}");
                }
            }
        }
    }
}

#[test]
fn one_wrong_segment_is_seen() {
    for code in [Code::cct14(), Code::cct12()] {
        for id in code.ids() {
            let word = code.word(id).unwrap();
            assert!((0..code.segments()).all(|i| code.decode(word ^ 1 << i).is_none()), "{id}");
        }
    }
}

#[test]
fn what_can_be_repaired_follows_from_the_ids() {
    // 4, 13, 33, 150, 398, 451, 463, 485, 495, 515 differ in four segments or more.
    let ten = Code::cct14().only(&[4, 13, 33, 150, 398, 451, 463, 485, 495, 515]).unwrap();
    assert_eq!((ten.repairs(), Code::five().repairs(), Code::cct14().repairs()), (1, 2, 0));
    assert_eq!(Code::cct14().only(&[1, 2]).unwrap().repairs(), 0);
    let many: Vec<u16> = (1..=40).collect();
    assert_eq!(Code::cct14().only(&many).unwrap().repairs(), 0);
}

#[test]
fn ids_that_do_not_exist_are_refused() {
    assert_eq!(Code::cct14().only(&[]), Err(CodeError::NoIds));
    for (code, given, max) in [(Code::cct14(), 0, 516), (Code::cct14(), 517, 516), (Code::cct12(), 148, 147)]
    {
        assert_eq!(code.only(&[1, given]), Err(CodeError::Id { given, max }));
    }
    assert!(!Code::cct12().has(148) && !Code::cct12().has(u16::MAX) && Code::cct12().word(0).is_none());
}
