//! How deep the stack can get below a function: from the calls and the frames in the disassembled image.

mod code;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};

use crate::image::Image;
use crate::setup::install_packages;
use crate::steps::output_of;
use crate::toolchain::Target;
use code::Reader;

/// The disassembler, and the package that it is in.
const DISASSEMBLER: &str = "llvm-objdump";
const PACKAGE: &str = "llvm";

/// What a function does to the stack.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Function {
    name: String,
    /// Bytes that it takes itself.
    frame: u64,
    /// Addresses of the functions that it calls.
    calls: BTreeSet<u64>,
    /// What cannot be read from the code.
    unknown: BTreeSet<String>,
}

/// Greatest depth of the stack.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bound {
    /// Bytes, as far as nothing is unknown and there is no recursion.
    pub bytes: u64,
    /// The functions of the deepest chain of calls.
    pub chain: Vec<String>,
    /// Calls through pointers and frames of a size that is computed.
    pub unknown: BTreeSet<String>,
    /// Functions that call themselves, directly or not.
    pub recursion: BTreeSet<String>,
}

/// Sees to it that the disassembler is there.
///
/// # Errors
/// It is not and cannot be installed.
pub fn ensure_disassembler() -> Result<()> {
    let is_here = || output_of(Command::new(DISASSEMBLER).arg("--version")).is_some();
    if !(is_here() || install_packages(&[PACKAGE]) && is_here()) {
        bail!("no {DISASSEMBLER}: install it, on Debian or Ubuntu with `apt-get install {PACKAGE}`");
    }
    Ok(())
}

/// Bytes for the interrupts of a board and what its executor calls through pointers, which no chain of calls shows.
const RESERVE: u64 = 2048;

/// Checks that the deepest chain of calls of an image fits above its variables. Says so where there is no disassembler.
///
/// # Errors
/// It does not fit, or the image does not say where its stack starts.
pub fn check_room(elf: &Path, image: &Image, target: Target) -> Result<()> {
    let room = image.room_for_stack().context("the image does not say where its stack starts")?;
    let Some(functions) = disassemble(elf, image, target) else {
        println!("room for the stack: {room} bytes; what it takes is not determined");
        return Ok(());
    };
    let mut walk = Walk::new(&functions);
    let deepest = functions.keys().map(|&start| walk.depth(start, &mut Vec::new()));
    let (bytes, chain) = deepest.max_by_key(|(bytes, _)| *bytes).unwrap_or_default();
    let unknown = walk.bound.unknown.len();
    println!(
        "room for the stack: {room} bytes; deepest calls: {bytes}, reserve: {RESERVE} for interrupts and {unknown} calls or frames \
         that are not counted"
    );
    ensure!(bytes + RESERVE <= room, "the stack does not fit:\n  {}", chain.join("\n  "));
    Ok(())
}

/// Bound of the stack below the function of this name; `None` without a disassembler or without such a function.
pub fn bound(elf: &Path, image: &Image, target: Target, root: &str) -> Option<Bound> {
    let functions = disassemble(elf, image, target)?;
    let mut walk = Walk::new(&functions);
    let (bytes, chain) = walk.depth(image.function(root)?.start, &mut Vec::new());
    Some(Bound { bytes, chain, ..walk.bound })
}

/// The functions of an image; `None` without a disassembler.
fn disassemble(elf: &Path, image: &Image, target: Target) -> Option<BTreeMap<u64, Function>> {
    let mut command = Command::new(DISASSEMBLER);
    command.args(["-d", "--no-show-raw-insn"]).arg(elf);
    if target != Target::Rv32Imc {
        // What the processors have beyond the least of their family.
        command.arg("--mattr=+fp-armv8d16,+dsp");
    }
    let listing = output_of(&mut command)?;
    Some(read(&listing, image))
}

/// Every function of the image by its address.
fn read(listing: &str, image: &Image) -> BTreeMap<u64, Function> {
    let mut functions: BTreeMap<u64, Function> = image
        .functions()
        .map(|s| (s.start, Function { name: s.readable(), ..Function::default() }))
        .collect();
    let starts: Vec<u64> = functions.keys().copied().collect();
    let start_of = |place: u64| starts[..starts.partition_point(|&start| start <= place)].last().copied();
    let mut reader = Reader::new(image);
    let mut last = None;
    for line in listing.lines() {
        let Some((place, operation, operands)) = split(line) else { continue };
        let Some(start) = start_of(place) else { continue };
        if last.replace(start) != Some(start) {
            reader.enter();
        }
        if let Some(function) = functions.get_mut(&start) {
            if operation == "<unknown>" {
                function.unknown.insert("has an unknown instruction".to_owned());
            }
            let target = reader.read(place, operation, operands, function);
            // A jump within the function is no call; one to the start of another is a call without return.
            let is_call = |target| target != start || code::is_call(operation);
            let target = target.filter(|&target| start_of(target) == Some(target) && is_call(target));
            function.calls.extend(target);
        }
    }
    functions
}

/// Address, operation and operands of a line of the listing.
fn split(line: &str) -> Option<(u64, &str, &str)> {
    let (place, rest) = line.split_once(':')?;
    let place = u64::from_str_radix(place.trim(), 16).ok()?;
    let rest = rest.trim();
    let (operation, operands) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
    (!operation.is_empty() && !line.ends_with(">:")).then_some((place, operation, operands.trim()))
}

struct Walk<'f> {
    functions: &'f BTreeMap<u64, Function>,
    known: BTreeMap<u64, (u64, Vec<String>)>,
    bound: Bound,
}

impl<'f> Walk<'f> {
    fn new(functions: &'f BTreeMap<u64, Function>) -> Self {
        Self { functions, known: BTreeMap::new(), bound: Bound::default() }
    }

    fn depth(&mut self, start: u64, path: &mut Vec<u64>) -> (u64, Vec<String>) {
        let Some(function) = self.functions.get(&start) else { return (0, Vec::new()) };
        if path.contains(&start) {
            self.bound.recursion.insert(function.name.clone());
            return (0, Vec::new());
        }
        if let Some(known) = self.known.get(&start) {
            return known.clone();
        }
        let reasons = function.unknown.iter().map(|reason| format!("{}: {reason}", function.name));
        self.bound.unknown.extend(reasons);
        path.push(start);
        let below =
            function.calls.iter().map(|&callee| self.depth(callee, path)).max_by_key(|(bytes, _)| *bytes);
        path.pop();
        let (bytes, mut chain) = below.unwrap_or_default();
        chain.insert(0, format!("{} {}", function.name, function.frame));
        let found = (function.frame + bytes, chain);
        self.known.insert(start, found.clone());
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn function(name: &str, frame: u64, calls: &[u64]) -> Function {
        Function {
            name: name.to_owned(),
            frame,
            calls: calls.iter().copied().collect(),
            ..Function::default()
        }
    }

    fn walk(functions: &[(u64, Function)]) -> (u64, Bound) {
        let functions = functions.iter().cloned().collect();
        let mut walk = Walk::new(&functions);
        let (bytes, _) = walk.depth(0, &mut Vec::new());
        (bytes, walk.bound)
    }

    #[test]
    fn the_deepest_chain_counts() {
        let functions = [
            (0, function("root", 8, &[2, 4])),
            (2, function("shallow", 16, &[6])),
            (4, function("deep", 100, &[6])),
            (6, function("leaf", 4, &[])),
        ];
        assert_eq!(walk(&functions).0, 112);
    }

    #[test]
    fn recursion_is_found() {
        let functions =
            [(0, function("root", 8, &[2])), (2, function("ping", 8, &[4])), (4, function("pong", 8, &[2]))];
        let (_, bound) = walk(&functions);
        assert_eq!(bound.recursion.into_iter().collect::<Vec<_>>(), ["ping"]);
    }

    #[test]
    fn lines_are_split() {
        assert_eq!(split("     ea8:      \tpush\t{r4, lr}"), Some((0xea8, "push", "{r4, lr}")));
        assert_eq!(split("80000554:\tret"), Some((0x8000_0554, "ret", "")));
        assert_eq!(split("00000ea8 <main>:"), None);
        assert_eq!(split("Disassembly of section .text:"), None);
    }
}
