//! What instructions do to the stack, in the syntax of LLVM's disassembler.

use std::collections::BTreeMap;

use super::Function;
use crate::image::Image;

/// Reads the instructions of a function in order.
pub struct Reader<'i> {
    image: &'i Image,
    /// Constants in registers: frames that are larger than an instruction can say are in one.
    constants: BTreeMap<String, i64>,
}

impl<'i> Reader<'i> {
    pub fn new(image: &'i Image) -> Self {
        Self { image, constants: BTreeMap::new() }
    }

    /// A new function begins.
    pub fn enter(&mut self) {
        self.constants.clear();
    }

    /// Takes an instruction into account; gives the address that it calls or jumps to.
    pub fn read(
        &mut self,
        place: u64,
        operation: &str,
        operands: &str,
        function: &mut Function,
    ) -> Option<u64> {
        match self.growth(operation, operands) {
            Ok(bytes) => function.frame += bytes,
            Err(reason) => _ = function.unknown.insert(reason),
        }
        // `jr` and `bx` to another register than the one of the return are the jump tables of a `match`.
        let target = self.target(operation, operands);
        if ["blx", "jalr"].contains(&operation) && target.is_none() {
            function.unknown.insert(format!("calls through a pointer at {place:#x}"));
        }
        self.note_constant(place, operation, operands);
        target
    }

    /// Bytes that the stack grows by.
    fn growth(&self, operation: &str, operands: &str) -> Result<u64, String> {
        let plain = operation.trim_end_matches(".w");
        let mut parts = operands.split(", ");
        let first = parts.next().unwrap_or_default();
        match plain {
            "push" | "vpush" => return Ok(list_bytes(operands)),
            "stmdb" | "vstmdb" if first == "sp!" => return Ok(list_bytes(operands)),
            "str" | "strd" | "strb" | "strh" => {
                let below = operands.split_once("[sp, #-").and_then(|(_, rest)| rest.strip_suffix("]!"));
                return Ok(below.and_then(number).unwrap_or(0).unsigned_abs());
            }
            _ if first != "sp" => return Ok(0),
            _ => {}
        }
        let last = parts.last().unwrap_or_default();
        let last = last.split_whitespace().next().unwrap_or_default();
        let amount = match number(last.trim_start_matches('#')) {
            Some(amount) => Some(amount),
            None => self.constants.get(last).copied(),
        };
        let amount = match plain {
            "sub" | "subw" => amount,
            "add" | "addw" | "addi" | "c.addi16sp" => amount.map(|amount| -amount),
            _ => return Ok(0),
        };
        match amount {
            // What shrinks the stack is the other end of the function.
            Some(amount) => Ok(amount.max(0).unsigned_abs()),
            None if plain == "sub" => Err(format!("frame of a computed size, {operation} {operands}")),
            None => Ok(0),
        }
    }

    /// Keeps what a register holds, as far as the frames need it.
    fn note_constant(&mut self, place: u64, operation: &str, operands: &str) {
        let mut parts = operands.split(", ");
        let Some(register) = parts.next() else { return };
        let rest: Vec<&str> = parts.collect();
        let first = rest.first().copied().unwrap_or_default();
        let immediate = |text: &str| number(text.trim_start_matches('#').split_whitespace().next()?);
        let value = match operation {
            "movw" | "mov.w" | "mov" | "movs" | "li" => immediate(first),
            "lui" => immediate(first).map(|high| i64::from((high << 12) as i32)),
            "auipc" => immediate(first).map(|high| place as i64 + i64::from((high << 12) as i32)),
            "addi" if rest.len() == 2 => {
                self.constants.get(first).and_then(|base| Some(base + immediate(rest[1])?))
            }
            "ldr" if first.starts_with("[pc") => {
                literal(operands).and_then(|place| self.image.word(place)).map(|word| i64::from(word as i32))
            }
            _ => None,
        };
        match value {
            Some(value) => _ = self.constants.insert(register.to_owned(), value),
            None if leaves_register(operation) => {}
            None => _ = self.constants.remove(register),
        }
    }

    /// The address that an instruction calls or jumps to.
    fn target(&self, operation: &str, operands: &str) -> Option<u64> {
        if ["jalr", "jr"].contains(&operation) {
            let last = operands.rsplit(", ").next()?;
            let (offset, register) = last.trim_end_matches(')').split_once('(').unwrap_or(("0", last));
            return Some((self.constants.get(register)? + number(offset)?) as u64 & !1);
        }
        let is_jump = operation.starts_with('b') || operation.starts_with('j') || operation.starts_with("cb");
        let is_jump = is_jump && !["bic", "bics", "bfi", "bfc", "bkpt"].contains(&operation);
        let (before, _) = operands.split_once(" <").filter(|_| is_jump)?;
        let place = before.rsplit([' ', '\t']).next()?;
        u64::from_str_radix(place.trim_start_matches('#').strip_prefix("0x")?, 16)
            .ok()
            .map(|place| place & !1)
    }
}

/// Whether the first register of the operands keeps its value: in a store, a comparison, a branch.
fn leaves_register(operation: &str) -> bool {
    let stores = ["str", "stm", "sw", "sh", "sb", "push", "vstr", "vpush"];
    let compares = ["cmp", "cmn", "tst", "teq", "cb", "b"];
    let clears_bits = ["bic", "bfi", "bfc"].iter().any(|start| operation.starts_with(start));
    !clears_bits && stores.iter().chain(&compares).any(|start| operation.starts_with(start))
}

/// Whether the operation calls, rather than jumps.
pub fn is_call(operation: &str) -> bool {
    ["bl", "jal", "jalr"].contains(&operation)
}

/// A number as the disassembler writes it.
fn number(text: &str) -> Option<i64> {
    let (text, sign) = text.strip_prefix('-').map_or((text, 1), |text| (text, -1));
    let value = match text.strip_prefix("0x") {
        Some(digits) => i64::from_str_radix(digits, 16).ok()?,
        None => text.parse().ok()?,
    };
    Some(sign * value)
}

/// The address behind `@`, of a constant in the code.
fn literal(operands: &str) -> Option<u64> {
    let (_, place) = operands.split_once("@ 0x")?;
    u64::from_str_radix(place.split_whitespace().next()?, 16).ok()
}

/// Bytes of a list of registers.
fn list_bytes(operands: &str) -> u64 {
    let list =
        operands.split_once('{').and_then(|(_, rest)| rest.split_once('}')).map_or("", |(list, _)| list);
    let registers = list.split(',').map(str::trim).filter(|register| !register.is_empty());
    registers
        .map(|range| {
            let width = if range.starts_with('d') { 8 } else { 4 };
            let number =
                |register: &str| register.trim_start_matches(char::is_alphabetic).parse::<u64>().ok();
            let count = range.split_once('-').and_then(|(a, b)| Some(number(b)? - number(a)? + 1));
            width * count.unwrap_or(1)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frame, target of the last instruction and number of unknowns of a function.
    fn read(lines: &[(&str, &str)]) -> (u64, Option<u64>, usize) {
        let image = Image::default();
        let mut reader = Reader::new(&image);
        let mut function = Function::default();
        let mut target = None;
        for (i, (operation, operands)) in lines.iter().enumerate() {
            target = reader.read(0x8000_0000 + 4 * i as u64, operation, operands, &mut function);
        }
        (function.frame, target, function.unknown.len())
    }

    #[test]
    fn frames_are_added_up() {
        assert_eq!(read(&[("push", "{r4, r5, r6, r7, lr}"), ("sub", "sp, #24")]), (44, None, 0));
        assert_eq!(
            read(&[("push.w", "{r8, r9}"), ("vpush", "{d8-d15}"), ("sub.w", "sp, sp, #0x400")]).0,
            1096
        );
        assert_eq!(read(&[("str", "r11, [sp, #-4]!"), ("add", "sp, #4")]).0, 4);
        assert_eq!(read(&[("addi", "sp, sp, -64"), ("addi", "sp, sp, 64")]).0, 64);
    }

    #[test]
    fn large_frames_are_in_a_register() {
        let lines = [("lui", "a3, 2"), ("addi", "a3, a3, -480"), ("sub", "sp, sp, a3")];
        assert_eq!(read(&lines), (7712, None, 0));
        assert_eq!(read(&[("movw", "r12, #5000"), ("sub.w", "sp, sp, r12")]).0, 5000);
        assert_eq!(read(&[("sub", "sp, sp, a3")]).2, 1);
    }

    #[test]
    fn calls_are_found() {
        assert_eq!(read(&[("bl", "0x1f326 <panic> @ imm = #98414")]).1, Some(0x1f326));
        assert_eq!(read(&[("cbz", "r0, 0x7a <f+0x10> @ imm = #4")]).1, Some(0x7a));
        assert_eq!(read(&[("jal", "0x80001234 <f>")]).1, Some(0x8000_1234));
        assert_eq!(read(&[("auipc", "ra, 1"), ("jalr", "-4(ra)")]).1, Some(0x8000_0ffc));
        assert_eq!(read(&[("auipc", "ra, 1"), ("jalr", "ra")]), (0, Some(0x8000_1000), 0));
        assert_eq!(read(&[("blx", "r3")]).2, 1);
        assert_eq!(read(&[("jalr", "a5")]).2, 1);
        assert_eq!(read(&[("bic", "r0, r1, #0x1 <f>")]).1, None);
    }
}
