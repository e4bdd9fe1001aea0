//! The head's end of the mailbox.

use core::array;

use crate::protocol::{ANSWER, Answer, DONE, MAGIC, ORDER, ORDERED, Order, PIXELS, READY, words_in_row};
use crate::words::Words;

/// The head's end of the mailbox.
pub struct Mailbox {
    words: Words,
    done: u32,
}

impl Mailbox {
    /// Tells the camera that the head is ready.
    pub fn open(mut words: Words) -> Self {
        let done = words.read(ORDERED);
        words.write(DONE, done);
        words.write(READY, MAGIC);
        Self { words, done }
    }

    /// The next order, with its number, when there is one. `Some((number, None))` is an order of another protocol.
    pub fn next(&mut self) -> Option<(u32, Option<Order>)> {
        let number = self.words.read(ORDERED);
        if number == self.done {
            return None;
        }
        Some((number, Order::from_words(array::from_fn(|i| self.words.read(ORDER + i)))))
    }

    /// Whether the mailbox is large enough for the frame.
    pub fn holds(&self, width: u32, height: u32) -> bool {
        let words = words_in_row(width as usize).checked_mul(height as usize);
        words.is_some_and(|words| words <= self.words.len().saturating_sub(PIXELS))
    }

    /// Word `index` of the pixels and what is between them, if the mailbox reaches there.
    pub fn pixel_word(&self, index: usize) -> Option<u32> {
        let at = PIXELS + index;
        (at < self.words.len()).then(|| self.words.read(at))
    }

    /// Copies the row that begins at word `start` of the pixels.
    pub fn copy_row(&self, start: usize, row: &mut [u8]) {
        for (i, pixels) in row.chunks_mut(4).enumerate() {
            let word = self.pixel_word(start + i).unwrap_or(0).to_le_bytes();
            for (pixel, byte) in pixels.iter_mut().zip(word) {
                *pixel = byte;
            }
        }
    }

    /// Hands order `number` back to the camera.
    pub fn answer(&mut self, number: u32, answer: Answer) {
        for (i, word) in answer.to_words().into_iter().enumerate() {
            self.words.write(ANSWER + i, word);
        }
        self.words.write(DONE, number);
        self.done = number;
    }
}
